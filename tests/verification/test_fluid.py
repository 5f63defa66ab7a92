"""Fluids: hydrostatics, a collapsing column, viscous decay."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.cases.base import Numerics, check, run
from benchmarks.cases.dam_break import DamBreak
from benchmarks.cases.hydrostatic import Hydrostatic
from benchmarks.cases.viscous import WAVE_NUMBER, Swirl, swirl


@pytest.mark.parametrize("form", ("mls", "gradient"))
@pytest.mark.parametrize("cells", (10, 20))
def test_a_column_of_fluid_bears_its_weight_and_comes_to_rest(cells, form, x64):
    check(Hydrostatic(), Numerics(cells, dtype=np.float64, stress_form=form))


def test_a_column_of_fluid_bears_its_weight_in_single_precision():
    check(Hydrostatic(), Numerics(20))


def test_pressure_gets_more_accurate_with_resolution(x64):
    coarse, fine = (check(Hydrostatic(), Numerics(n, dtype=np.float64))["pressure"] for n in (10, 40))
    assert fine < 0.5 * coarse


def test_a_heavier_fluid_would_be_found_out():
    problem = Hydrostatic().problem(Numerics(20))
    problem = dataclasses.replace(problem, model=problem.model.replace(mass=1.1 * problem.model.mass))
    assert Hydrostatic().judge(problem, run(problem))["pressure"] > 0.03


@pytest.mark.parametrize("tension", (True, False))
def test_a_collapsing_column_of_water_runs_as_measured(tension):
    check(DamBreak(tension), Numerics(16, step=("courant", 0.5)))


@pytest.mark.slow
def test_a_finer_column_of_water_runs_as_measured():
    check(DamBreak(), Numerics(32, step=("courant", 0.5)))


def test_the_swirl_is_an_eigenfunction_without_divergence_or_shear_at_the_edge(x64):
    angles, radii = np.meshgrid(np.linspace(0.1, 6, 7), [0.3, 0.6, 0.9])
    points = np.stack([radii * np.cos(angles), 0 * radii, radii * np.sin(angles)], -1).reshape(-1, 3)
    step = 1e-4
    v, gradient = swirl(points)
    laplacian = np.zeros_like(v)
    for axis in (0, 2):
        ahead, behind = (swirl(points + sign * step * np.eye(3)[axis])[0] for sign in (1, -1))
        np.testing.assert_allclose(gradient[..., axis], (ahead - behind) / (2 * step), atol=1e-7)
        laplacian += (ahead - 2 * v + behind) / step**2
    np.testing.assert_allclose(laplacian, -(WAVE_NUMBER**2) * v, atol=1e-5)
    np.testing.assert_allclose(gradient[:, 0, 0] + gradient[:, 2, 2], 0, atol=1e-12)

    edge = np.array([[np.cos(0.7), 0, np.sin(0.7)]])
    strain = swirl(edge)[1] + swirl(edge)[1].transpose(0, 2, 1)
    np.testing.assert_allclose(strain @ edge[0], 0, atol=1e-12)


def test_a_swirl_dies_out_by_viscosity(x64):
    check(Swirl(), Numerics(16, dtype=np.float64))


def test_a_swirl_dies_out_by_viscosity_in_single_precision():
    check(Swirl(), Numerics(16, stress_form="gradient"))


def test_a_less_viscous_swirl_would_be_found_out():
    problem = Swirl().problem(Numerics(16))
    thinner = problem.model.replace(viscosity=0.9 * jnp.asarray(problem.model.viscosity))
    errors = Swirl().judge(problem, run(dataclasses.replace(problem, model=thinner)))
    assert errors["decay rate"] < -0.05


def test_observations_also_work_on_numpy_arrays():
    for case in (Hydrostatic(), DamBreak(), Swirl()):
        problem = case.problem(Numerics(case.resolutions[0]))
        state = problem.state
        seen = problem.observe(*(np.asarray(leaf) for leaf in (state.x, state.v, state.C, state.F)))
        assert isinstance(jax.block_until_ready(seen), jax.Array | np.ndarray)
