"""Manufactured solutions: the exact maps solve the equations of motion, and the simulator approaches them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.cases.axis_aligned import AxisAligned, cube_force, cube_motion
from benchmarks.cases.base import Numerics, check, run
from benchmarks.cases.periodic_bar import PeriodicBar, bar_force, bar_motion
from benchmarks.cases.vortex import Vortex, vortex_force, vortex_motion
from physagent_jax.mpm import lame_parameters

FORMS = ("mls", "gradient")


def force_by_differentiation(motion, E, nu, rho):
    """b = x_tt - Div P(F) / rho0 of a neo-Hookean solid, from nothing but the map."""
    mu, lam = lame_parameters(E, nu)

    def stress(X, t):
        F = jax.jacfwd(motion)(X, t)
        inverse = jnp.linalg.inv(F).T
        return mu * (F - inverse) + lam * jnp.log(jnp.linalg.det(F)) * inverse

    def force(X, t):
        acceleration = jax.jacfwd(jax.jacfwd(motion, 1), 1)(X, t)
        return acceleration - jnp.einsum("ijj->i", jax.jacfwd(stress)(X, t)) / rho

    return force


@pytest.mark.parametrize(
    ("motion", "force", "solid", "X"),
    [
        (vortex_motion, vortex_force, (1e3, 0.3, 1e3), (0.8, 0.55, 0.02)),
        (bar_motion, bar_force, (1e4, 0.0, 1.0), (0.31, 0.02, 0.01)),
        (cube_motion, cube_force, (1e4, 0.3, 1.0), (0.2, 0.7, 0.35)),
    ],
)
def test_the_closed_form_force_is_that_of_the_map(motion, force, solid, X, x64):
    X, by_hand = jnp.array(X), jax.jit(force_by_differentiation(motion, *solid))
    for t in (0.0, 0.0031, 0.21, 0.8):
        expected = by_hand(X, t)
        np.testing.assert_allclose(force(X, t), expected, rtol=1e-9, atol=1e-9 * abs(expected).max())


def test_the_vortex_force_has_its_published_value(x64):
    """Checked against finite differences of the exact map to nine digits, with mu rounded to 384.615 Pa."""
    b = vortex_force(jnp.array([0.8, 0.55, 0.0]), jnp.array(0.21), amplitude=1.0, mu=384.615)
    np.testing.assert_allclose(b, [-8.43686056, -2.27481039, 0.0], atol=1e-8)


def test_the_vortex_leaves_its_rims_and_faces_free_of_traction(x64):
    mu, lam = lame_parameters(1e3, 0.3)
    for R in (0.75, 1.25):
        F = jax.jacfwd(vortex_motion)(jnp.array([0.6 * R, 0.8 * R, 0.0]), 0.37)
        P = mu * (F - jnp.linalg.inv(F).T) + lam * jnp.log(jnp.linalg.det(F)) * jnp.linalg.inv(F).T
        np.testing.assert_allclose(P @ jnp.array([0.6, 0.8, 0.0]), 0, atol=1e-9)
        np.testing.assert_allclose(P[:, 2], 0, atol=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_the_vortex_on_a_coarse_grid(form, x64):
    check(Vortex(), Numerics(5, ("courant", 0.2), dtype=np.float64, stress_form=form, per_axis=3))


def test_the_vortex_with_ten_cells(x64):
    check(Vortex(), Numerics(10, ("courant", 0.2), dtype=np.float64))


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("cells", [10, 20])
def test_the_vortex_on_fine_grids(cells, form, x64):
    errors = check(
        Vortex(), Numerics(cells, ("courant", 0.2), dtype=np.float64, stress_form=form, per_axis=3)
    )
    assert cells < 20 or errors["twisted [m]"] < 5e-4


def test_the_vortex_in_single_precision():
    check(Vortex(), Numerics(5))


@pytest.mark.parametrize(("form", "cells"), [("mls", 16), ("mls", 32), ("gradient", 32)])
def test_the_bar_with_free_ends_is_below_the_published_baseline(form, cells, x64):
    check(PeriodicBar("free"), Numerics(cells, dtype=np.float64, stress_form=form))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("ends", ["free", "mirrors"])
def test_the_bar_converges_at_second_order(ends, form, x64):
    case, greatest = PeriodicBar(ends), []
    for cells in (8, 32):
        problem = case.problem(Numerics(cells, dtype=np.float64, stress_form=form))
        greatest.append(case.judge(problem, run(problem))["greatest [m]"])
    assert np.log2(greatest[0] / greatest[1]) / 2 > 1.9


@pytest.mark.parametrize("form", FORMS)
def test_the_bar_between_walls_converges_at_first_order(form, x64):
    """Walls zero the nodes behind them instead of mirroring; see `PeriodicBar`."""
    coarse, fine = (
        check(PeriodicBar("walls"), Numerics(cells, dtype=np.float64, stress_form=form))["greatest [m]"]
        for cells in (8, 32)
    )
    assert np.log2(coarse / fine) / 2 > 0.95


def test_the_bar_in_single_precision():
    check(PeriodicBar("free"), Numerics(32))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("walls", "order"), [("slip", 0.95), ("mirror", 1.8)])
def test_order_of_the_cube_between_walls(walls, order, form, x64):
    """A plane of symmetry is of second order where a slip wall, which only stops its nodes, is of first."""
    coarse, fine = (
        check(AxisAligned(walls), Numerics(cells, dtype=np.float64, stress_form=form))["displacement"]
        for cells in (6, 10)
    )
    assert np.log(coarse / fine) / np.log(10 / 6) > order


@pytest.mark.slow
def test_the_cube_at_the_published_resolution(x64):
    check(AxisAligned(), Numerics(16, dtype=np.float64))


def test_the_cube_in_single_precision():
    check(AxisAligned(), Numerics(8))
