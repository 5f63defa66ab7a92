"""3x3 algebra against numpy and scipy; derivatives against closed forms where the rules of an SVD fail."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from physagent_jax.kernels import use_kernels
from physagent_jax.mpm.linalg import (
    Principal,
    cofactor,
    determinant,
    greatest_stretch_squared,
    isotropic,
    matmul,
    singular_values,
    skew,
    spectral,
    svd,
)


def rotation(seed):
    return Rotation.random(rng=np.random.default_rng(seed)).as_matrix()


CASES = {
    "identity": np.eye(3),
    "two equal stretches": np.diag([2.0, 2.0, 1.0]),
    "rotated, nearly equal": rotation(1) @ np.diag([1.0, 1.0 + 1e-9, 0.5]),
    "generic": rotation(2) @ np.diag([0.3, 1.1, 2.5]) @ rotation(3),
    "strong squeeze": rotation(4) @ np.diag([0.02, 1.0, 3.0]),
}


def polar_rotation(F):
    """R of F = R S: the isotropic function that makes all singular values 1."""
    R = isotropic(lambda s, _: jnp.ones_like(s), F.reshape(-1, 3, 3), None)
    return R.reshape(F.shape)


@pytest.mark.parametrize("F", CASES.values(), ids=CASES.keys())
def test_polar_rotation_matches_scipy(F, x64):
    np.testing.assert_allclose(polar_rotation(jnp.asarray(F)), scipy.linalg.polar(F)[0], atol=1e-12)


@pytest.mark.parametrize("F", CASES.values(), ids=CASES.keys())
def test_polar_derivative_matches_central_differences(F, x64):
    for dF in (np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0.0]]), np.random.default_rng(5).normal(size=(3, 3))):
        _, tangent = jax.jvp(polar_rotation, (jnp.asarray(F),), (jnp.asarray(dF),))
        h = 1e-6
        difference = (scipy.linalg.polar(F + h * dF)[0] - scipy.linalg.polar(F - h * dF)[0]) / (2 * h)
        np.testing.assert_allclose(tangent, difference, atol=2e-5 if F.min() < 0.1 else 1e-8)


def test_polar_rotation_in_single_precision():
    F = np.stack(list(CASES.values())).astype(np.float32)
    expected = np.stack([scipy.linalg.polar(f.astype(float))[0] for f in F])
    np.testing.assert_allclose(polar_rotation(jnp.asarray(F)), expected, atol=3e-5)


def test_products_and_cofactors(x64):
    a, b = np.random.default_rng(0).normal(size=(2, 50, 3, 3))
    np.testing.assert_allclose(matmul(jnp.asarray(a), jnp.asarray(b)), a @ b, atol=1e-14)
    np.testing.assert_allclose(determinant(jnp.asarray(a)), np.linalg.det(a), atol=1e-14)
    cofactors = np.linalg.det(a)[:, None, None] * np.linalg.inv(a).swapaxes(1, 2)
    np.testing.assert_allclose(cofactor(jnp.asarray(a)), cofactors, atol=1e-12)
    w, u = a[:, 0], b[:, 0]
    np.testing.assert_allclose((skew(jnp.asarray(w)) @ u[..., None])[..., 0], np.cross(w, u), atol=1e-14)


def turned(*stretches, seed=0):
    """U diag(stretches) V^T with two rotations."""
    return rotation(seed) @ np.diag(stretches) @ rotation(seed + 1)


MATRICES = {
    **CASES,
    "uniform": np.diag([1.7, 1.7, 1.7]),
    "turned uniform": turned(0.6, 0.6, 0.6),
    "turned pair": turned(0.4, 1.3, 1.3),
    "nearly uniform": turned(1.0, 1.0 + 1e-9, 1.0 - 1e-9),
    "around the tolerance": turned(1.0, 1.0 + 3e-6, 1.0 + 1e-5),
    "reflected": turned(1.2, 0.9, -0.5),
    "reflected pair": turned(1.2, 0.8, -0.8),
    "reflected, nearly a pair": turned(1.2, 0.8, -0.8 + 1e-9),
    "reflected identity": np.diag([1.0, -1.0, 1.0]),
    "negative identity": -np.eye(3),
    "small": turned(1e-4, 3e-5, 1e-5),
    "tiny and large": turned(1e3, 1.0, 1e-3),
}


EXTREME = {"nothing": np.zeros((3, 3)), "huge": turned(1e15, 1e15, 1e-3), "minute": turned(1e-15, 1e-16, 0)}


@pytest.mark.parametrize("F", [*MATRICES.values(), *EXTREME.values()], ids=[*MATRICES, *EXTREME])
def test_greatest_stretch_matches_numpy(F):
    """In both precisions, at the exactness that its docstring states, and without overflow."""
    expected = np.linalg.norm(F, ord=2) ** 2
    single = greatest_stretch_squared(jnp.asarray(F, np.float32))
    np.testing.assert_allclose(single, expected, rtol=3e-4)
    with jax.enable_x64(True):
        np.testing.assert_allclose(greatest_stretch_squared(jnp.asarray(F)), expected, rtol=3e-8)


SINGULAR = {
    "rank 2": turned(1.5, 0.7, 0.0),
    "rank 1": turned(1.5, 0.0, 0.0),
    "rank 1 of small integers": np.array([[1.0, -1, 1], [-1, 1, -1], [0, 0, 0]]),
    "rank 0": np.zeros((3, 3)),
}
COUNT = 64  # one batch size everywhere: each operation compiles once
RANDOM = {f"random {i}": F for i, F in enumerate(np.random.default_rng(9).normal(size=(COUNT, 3, 3)))}
REGULAR = np.stack(list((MATRICES | RANDOM).values())[:COUNT])
FINITE = np.stack(list((MATRICES | SINGULAR | RANDOM).values())[:COUNT])
DIRECTIONS = np.random.default_rng(8).normal(size=FINITE.shape)


def assert_each_close(actual, expected, tolerance):
    """Elementwise |actual - expected| <= tolerance of each regular matrix; names the matrices that fail."""
    error = np.abs(np.asarray(actual) - expected).reshape(COUNT, -1).max(1)
    bad = {
        name: (e, t)
        for name, e, t in zip(MATRICES | RANDOM, error, np.broadcast_to(tolerance, error.shape))
        if not e <= t
    }
    assert not bad


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_svd_reconstructs_with_proper_rotations_in_order(dtype, x64):
    F = FINITE.astype(dtype)
    U, s, V = (np.asarray(a) for a in svd(jnp.asarray(F)))
    assert U.dtype == s.dtype == V.dtype == dtype
    eps, size = np.finfo(dtype).eps, np.abs(s[:, 0])
    assert np.all(np.abs((U * s[:, None, :]) @ V.swapaxes(1, 2) - F).max((1, 2)) <= 20 * eps * size)
    for Q in (U, V):
        np.testing.assert_allclose(Q.swapaxes(1, 2) @ Q, np.broadcast_to(np.eye(3), Q.shape), atol=20 * eps)
        np.testing.assert_allclose(np.linalg.det(Q), 1, atol=20 * eps)
    assert np.all(s[:, 0] >= s[:, 1] * (1 - 4 * eps)) and np.all(s[:, 1] >= np.abs(s[:, 2]) * (1 - 4 * eps))
    reference = np.linalg.svd(F.astype(float))[1]
    np.testing.assert_allclose(
        np.abs(s) / np.maximum(size, 1e-30)[:, None],
        reference / np.maximum(size, 1e-30)[:, None],
        atol=20 * eps,
    )
    regular = reference[:, 2] > 100 * eps * size
    np.testing.assert_array_equal(np.sign(s[regular, 2]), np.sign(np.linalg.det(F.astype(float)))[regular])
    assert regular.sum() > 50


def test_svd_is_exact_for_diagonal_stretches(x64):
    for s in ([1.0, 1.0, 1.0], [2.0, 2.0, 1.0], [3.0, 1e-150, 1e-300], [0.0, 0.0, 0.0]):
        np.testing.assert_array_equal(svd(jnp.diag(jnp.asarray(s)))[1], s)


def test_svd_keeps_the_relative_accuracy_of_small_singular_values():
    rng = np.random.default_rng(3)
    F = (rng.normal(size=(COUNT, 3, 3)) * 10.0 ** rng.uniform(-6, 0, (COUNT, 1, 3))).astype(np.float32)
    s, double = np.asarray(svd(jnp.asarray(F))[1]), F.astype(float)
    reference = np.linalg.svd(double)[1]
    assert (reference[:, 2] / reference[:, 0]).min() < 1e-6
    # One-sided Jacobi loses what the columns' directions are conditioned by, not what F is.
    directions = np.linalg.cond(double / np.linalg.norm(double, axis=1, keepdims=True))
    error = np.abs(np.abs(s) / reference - 1).max(1)
    assert np.all(error <= 10 * np.finfo(np.float32).eps * directions)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_svd_of_rotations_does_not_depend_on_how_xla_splits_its_loops(dtype, x64):
    """Columns that are orthogonal but for round-off take any angle, but both the same one: also in unoptimised code."""
    turns = 0.02 * np.random.default_rng(0).normal(size=(4096, 3))
    F = jnp.asarray(Rotation.from_rotvec(turns).as_matrix(), dtype)
    with use_kernels("reference"):
        plain = jax.jit(svd, compiler_options={"xla_backend_optimization_level": 0})
        U, s, V = plain(F)
    np.testing.assert_allclose(s, 1, atol=20 * np.finfo(dtype).eps)
    np.testing.assert_allclose((U * s[:, None]) @ jnp.swapaxes(V, 1, 2), F, atol=20 * np.finfo(dtype).eps)


def test_svd_of_what_is_not_finite_is_not_finite():
    for bad in (np.nan, np.inf):
        s = svd(jnp.eye(3).at[1, 0].set(bad))[1]
        assert not np.isfinite(s).any()


@pytest.mark.parametrize("transform", [jax.jacfwd, jax.jacrev])
def test_differentiating_the_svd_is_an_error_that_says_what_to_use(transform):
    with pytest.raises(NotImplementedError, match="isotropic"):
        transform(lambda F: svd(F)[0])(jnp.diag(jnp.array([3.0, 2.0, 1.0])))


def transposed(a):
    return a.swapaxes(-1, -2)


def cube(s, parameters):
    """G = F F^T F + p tr(F^T F) F: a polynomial, so that its derivative needs no SVD."""
    return s**3 + parameters["p"] * (s**2).sum(0) * s


def test_isotropic_derivative_of_a_polynomial_is_exact(x64):
    F, dF = REGULAR, DIRECTIONS
    p, dp = np.linspace(0.5, 1, COUNT), np.linspace(-1, 1, COUNT)
    value, tangent = jax.jvp(
        lambda F, p: isotropic(cube, F, {"p": p}),
        (jnp.asarray(F), jnp.asarray(p)),
        (jnp.asarray(dF), jnp.asarray(dp)),
    )
    p, dp = p[:, None, None], dp[:, None, None]
    Ft, dFt, square = transposed(F), transposed(dF), (F**2).sum((1, 2), keepdims=True)
    size = np.linalg.norm(F, axis=(1, 2))
    assert_each_close(value, F @ Ft @ F + p * square * F, 1e-14 * size**3)
    exact = dF @ Ft @ F + F @ dFt @ F + F @ Ft @ dF
    exact = exact + p * (2 * (F * dF).sum((1, 2), keepdims=True) * F + square * dF) + dp * square * F
    assert_each_close(tangent, exact, 2e-10 * size**2)


def test_isotropic_derivative_of_the_inverse_is_exact(x64):
    F, dF = REGULAR, DIRECTIONS
    value, tangent = jax.jvp(
        lambda F: isotropic(lambda s, _: 1 / s, F, ()), (jnp.asarray(F),), (jnp.asarray(dF),)
    )
    inverse = transposed(np.linalg.inv(F))
    size = np.abs(inverse).max((1, 2))
    assert_each_close(value, inverse, 1e-13 * size * np.linalg.cond(F))
    assert_each_close(tangent, -inverse @ transposed(dF) @ inverse, 1e-9 * size**2)


@pytest.mark.filterwarnings("ignore:logm result may be inaccurate")
def test_spatial_derivative_of_the_logarithm_matches_scipy(x64):
    def logarithm(F):
        return spectral(lambda s, _: Principal(spatial=jnp.log(jnp.abs(s))), F, ()).spatial

    F, dF = REGULAR, DIRECTIONS
    value, tangent = jax.jvp(logarithm, (jnp.asarray(F),), (jnp.asarray(dF),))
    b, db = F @ transposed(F), dF @ transposed(F) + F @ transposed(dF)
    # f([[b, db], [0, b]]) = [[f(b), Df(b)[db]], [0, f(b)]]
    block = np.stack([scipy.linalg.logm(np.block([[x, y], [0 * x, x]])) for x, y in zip(b, db)]) / 2
    usable = np.linalg.cond(F) < 1e4  # beyond, scipy's logarithm of F F^T has lost its digits
    assert usable.sum() >= len(F) - 2
    tolerance = np.where(usable, 1e-9 / np.linalg.svd(F)[1].min(1), np.inf)
    assert_each_close(value, block[:, :3, :3], tolerance)
    assert_each_close(tangent, block[:, :3, 3:], tolerance)


def test_derivatives_of_polynomials_at_singular_matrices(x64):
    F, dF = np.stack(list(SINGULAR.values()) * (COUNT // len(SINGULAR))), DIRECTIONS

    def both(F):
        return spectral(lambda s, _: Principal(two_point=s**3, spatial=s**2), F, ())[:3:2]

    values, tangents = jax.jvp(both, (jnp.asarray(F),), (jnp.asarray(dF),))
    Ft, dFt = transposed(F), transposed(dF)
    np.testing.assert_allclose(values[0], F @ Ft @ F, atol=1e-13)
    np.testing.assert_allclose(values[1], F @ Ft, atol=1e-13)
    np.testing.assert_allclose(tangents[0], dF @ Ft @ F + F @ dFt @ F + F @ Ft @ dF, atol=1e-13)
    np.testing.assert_allclose(tangents[1], dF @ Ft + F @ dFt, atol=1e-13)


@pytest.mark.parametrize("dtype, tolerance", [("float32", 3e-4), ("float64", 2e-9)])
def test_isotropic_derivative_is_accurate_at_every_separation(dtype, tolerance, x64):
    gap = np.logspace(-16, -0.5, COUNT)
    s = np.stack([np.ones(COUNT), 1 + gap, 1 - gap / 3], -1)
    F = ((rotation(1) * s[:, None, :]) @ rotation(2)).astype(dtype)
    dF = np.random.default_rng(1).normal(size=F.shape).astype(dtype)
    tangent = jax.jvp(lambda F: isotropic(lambda s, _: 1 / s, F, ()), (jnp.asarray(F),), (jnp.asarray(dF),))[
        1
    ]
    inverse = np.linalg.inv(F.astype(float)).swapaxes(1, 2)
    np.testing.assert_allclose(tangent, -inverse @ dF.swapaxes(1, 2) @ inverse, atol=tolerance)


def everything(F, p):
    """All kinds of results at once, shape (..., 7)."""

    def principal(s, p):
        return Principal(two_point=jnp.sin(s), spatial=s**4, scalar={"sum": p * (s**2).sum(0)})

    result = spectral(principal, F, p)
    return jnp.concatenate(
        [result.two_point.sum(-1), result.spatial.sum(-1), result.scalar["sum"][..., None]], -1
    )


def test_reverse_mode_is_the_transpose_of_forward_mode(x64):
    F, dF, p = jnp.asarray(FINITE), jnp.asarray(DIRECTIONS), jnp.linspace(1, 2, COUNT)
    dp = jnp.cos(p)
    _, forward = jax.jvp(everything, (F, p), (dF, dp))
    weights = np.random.default_rng(2).normal(size=forward.shape)
    _, pull = jax.vjp(everything, F, p)
    back_F, back_p = pull(jnp.asarray(weights))
    np.testing.assert_allclose(
        (back_F * dF).sum((1, 2)) + back_p * dp, (weights * forward).sum(-1), rtol=1e-12, atol=1e-9
    )


def test_gradient_through_jit_vmap_and_scan_matches_finite_differences(x64):
    F, dF = jnp.asarray(FINITE[:3].reshape(3, 1, 3, 3)), DIRECTIONS[:3].reshape(3, 1, 3, 3)

    @jax.jit
    def loss(F):
        def advance(F, _):
            G = isotropic(lambda s, p: p * jnp.sqrt(s), F, jnp.asarray([0.9]))
            return G + 0.1 * spectral(lambda s, _: Principal(spatial=jnp.log(s)), F, ()).spatial, None

        return jax.vmap(lambda F: (jax.lax.scan(advance, F, None, length=3)[0] ** 2).sum())(F)

    gradient = jax.grad(lambda F: loss(F).sum())(F)
    h = 1e-6
    difference = (loss(F + h * dF) - loss(F - h * dF)) / (2 * h)
    np.testing.assert_allclose((gradient * dF).sum((1, 2, 3)), difference, rtol=1e-7)


def test_second_derivatives_raise_instead_of_being_wrong():
    def energy(F):
        return spectral(lambda s, _: Principal(scalar=(jnp.log(s) ** 2).sum(0)), F, ()).scalar

    with pytest.raises(NotImplementedError, match="first derivatives"):
        jax.hessian(energy)(jnp.eye(3))


def test_integer_parameters_are_constants(x64):
    F, power = jnp.asarray(REGULAR), 1 + jnp.arange(COUNT) % 3

    def G(F, power):
        return isotropic(lambda s, n: s**n, F, power).sum()

    np.testing.assert_allclose(jax.grad(G)(F, power)[0], np.ones((3, 3)), atol=1e-14)
    gradients = jax.grad(G, argnums=(0, 1), allow_int=True)(F, power)
    assert gradients[1].dtype == jax.dtypes.float0


def test_symmetric_functions_of_singular_values_have_exact_derivatives(x64):
    F, dF = REGULAR, DIRECTIONS
    value, tangent = jax.jvp(
        lambda F: (singular_values(F) ** 4).sum(-1), (jnp.asarray(F),), (jnp.asarray(dF),)
    )
    b = F @ transposed(F)
    np.testing.assert_allclose(value, (b**2).sum((1, 2)), rtol=1e-13)
    np.testing.assert_allclose(tangent, 4 * (b @ F * dF).sum((1, 2)), rtol=1e-10)


def test_sorted_singular_values_have_their_own_derivatives(x64):
    F, dF, h = turned(1.4, 0.9, 0.3), DIRECTIONS[1], 1e-6
    tangent = jax.jvp(singular_values, (jnp.asarray(F),), (jnp.asarray(dF),))[1]
    difference = (np.linalg.svd(F + h * dF)[1] - np.linalg.svd(F - h * dF)[1]) / (2 * h)
    np.testing.assert_allclose(tangent, difference, atol=1e-8)
