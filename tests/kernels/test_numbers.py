"""The kernels' own mathematics, against NumPy in more digits."""

import numpy as np
import pytest

pytest.importorskip("numba")

from numba import njit  # noqa: E402  (after the check for Numba)

from physagent_jax.kernels.numbers import log  # noqa: E402


@njit
def take_logarithms(x, result):
    for i in range(x.size):
        result[i] = log(x[i])


@pytest.mark.parametrize("dtype, digits", [(np.float32, np.float64), (np.float64, np.longdouble)])
def test_logarithms_are_right_to_the_last_place(dtype, digits):
    """Near 1, where a deformation is small, and over all magnitudes; zero, negative and what is not finite."""
    if np.finfo(digits).eps >= np.finfo(dtype).eps:
        pytest.skip("no longer numbers to compare with")
    rng = np.random.default_rng(0)
    near, far = 1 + rng.normal(size=(2, 20_000)) * [[1e-1], [1e-4]], np.exp(rng.uniform(-80, 80, 20_000))
    edges = [
        1,
        np.nextafter(dtype(1), 2),
        np.sqrt(0.5),
        np.sqrt(2),
        np.finfo(dtype).tiny,
        np.finfo(dtype).max,
    ]
    x = np.concatenate([np.abs(near).ravel(), far, edges]).astype(dtype)
    got = np.empty_like(x)
    take_logarithms(x, got)
    exact = np.log(x.astype(digits))
    assert (np.abs(got - exact) <= 0.9 * np.spacing(np.abs(exact).astype(dtype)).astype(digits)).all()

    special = np.array([0, -0.0, -1, np.inf, -np.inf, np.nan], dtype)
    got = np.empty_like(special)
    take_logarithms(special, got)
    np.testing.assert_array_equal(got, [-np.inf, -np.inf, np.nan, np.inf, np.nan, np.nan])
