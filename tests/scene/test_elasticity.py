"""Linear elasticity on the grid: by sparse matrices, and by the simulation's own transfers."""

import numpy as np
import pytest

from physagent_jax.kernels import use_kernels
from physagent_jax.scene import elasticity
from physagent_jax.scene.elasticity import GridElasticity

DX = 0.1


def make_bar(form):
    """A bar of two stiffnesses whose left end is held, its free components, and its weight."""
    x = np.random.default_rng(1).uniform(0, 1, (1500, 3)) * [1.1, 0.3, 0.3] + 0.45
    volume = np.full(len(x), 1.1 * 0.3 * 0.3 / len(x))
    mu = np.where(x[:, 0] > 1, 1e4, 4e4)
    grid = GridElasticity(x, volume, 1000 * volume, mu, 2 * mu, dx=DX, form=form, share=1e-3)
    held = grid.spread @ (x[:, 0] < 0.6) > 0
    free = np.repeat(~(held | grid.light)[:, None], 3, axis=1)
    return grid, free, np.where(free, grid.mass[:, None] * [0, 0, -9.8], 0)


@pytest.mark.parametrize(
    ("form", "kernels"), [("mls", "auto"), ("gradient", "auto"), ("gradient", "reference")]
)
def test_both_ways_give_the_same_displacements(form, kernels, monkeypatch):
    """Up to what is left of the residual; the force can be of any size, as single precision must not underflow."""
    grid, free, weight = make_bar(form)
    expected, rounds = grid.solve(weight, free)
    monkeypatch.setattr(elasticity, "WORTH_COMPILING", 1)
    with use_kernels(kernels):
        got, taken = grid.solve(1e-25 * weight, free)
    assert abs(taken - rounds) < 0.2 * rounds and expected[:, 2].min() < -1e-3
    np.testing.assert_allclose(1e25 * got, expected, atol=0.004 * np.abs(expected).max())
