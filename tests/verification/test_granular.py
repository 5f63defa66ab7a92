"""Friction and sand: a block on an incline, an endless slope, a collapsing column."""

import dataclasses

import numpy as np
import pytest

from benchmarks.cases.base import Numerics, check, run
from benchmarks.cases.incline import Incline
from benchmarks.cases.sand_column import SandColumn
from benchmarks.cases.slope import Slope, critical_angle, triaxial_angle
from physagent_jax.mpm import DruckerPrager

FAST = ("courant", 0.5)
SLIDES, RESTS = Incline(0.3), Incline(0.7)


@pytest.mark.parametrize("friction", (0.0, 0.3, 0.5))
def test_a_block_slides_with_coulomb_friction(friction, x64):
    errors = check(Incline(friction), Numerics(4, step=FAST, dtype=np.float64))
    assert abs(errors["acceleration"]) < 1e-4


def test_a_block_slides_with_coulomb_friction_in_single_precision():
    check(SLIDES, Numerics(4))


@pytest.mark.parametrize("cells", (4, 8))
def test_friction_holds_a_block(cells):
    check(RESTS, Numerics(cells))


def test_a_block_just_short_of_friction_does_not_hold():
    errors = RESTS.judge(*_solve(Incline(0.55), Numerics(4)))
    assert errors["drift / L"] > 1e-3


@pytest.mark.parametrize("phi, theta", ((20, 24.0), (25, 29.6), (30, 34.7), (35, 39.3), (40, 43.4)))
def test_the_critical_slope_is_that_of_simple_shear(phi, theta):
    assert critical_angle(phi) == pytest.approx(theta, abs=0.06)
    assert triaxial_angle(critical_angle(phi)) == pytest.approx(phi)


def test_a_slope_of_sand_rests_below_the_critical_angle():
    check(Slope(-2.0), Numerics(8, step=FAST))


def test_a_slope_of_sand_accelerates_above_the_critical_angle():
    check(Slope(3.0), Numerics(16, step=FAST))


def test_sand_of_less_friction_would_be_found_out():
    """One degree less in friction angle is 0.9 less in slope: the distance to it grows from 3 degrees to 3.9."""
    problem = Slope(3.0).problem(Numerics(16, step=FAST))
    (sand,) = problem.model.materials
    assert isinstance(sand, DruckerPrager)
    smoother = dataclasses.replace(sand, friction_angle=sand.friction_angle - np.float32(np.radians(1)))
    problem = dataclasses.replace(problem, model=problem.model.replace(materials=(smoother,)))
    assert Slope(3.0).judge(problem, run(problem))["acceleration"] > 0.2


@pytest.mark.parametrize("aspect", (1.0, 2.0))
def test_a_column_of_sand_collapses_about_as_measured_on_a_coarse_grid(aspect):
    check(SandColumn(aspect), Numerics(step=("courant", 0.6)))


@pytest.mark.slow
@pytest.mark.parametrize("aspect", (0.5, 1.0, 2.0))
def test_a_column_of_sand_collapses_as_measured(aspect):
    case = SandColumn(aspect)
    check(case, Numerics(case.resolutions[1], step=("courant", 0.6)))


def _solve(case, numerics):
    problem = case.problem(numerics)
    return problem, run(problem)
