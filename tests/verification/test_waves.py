"""Wave fronts in a bar, and its rebound from a wall."""

import numpy as np
import pytest

from benchmarks.cases.base import Numerics, check
from benchmarks.cases.ring import SpinningRing
from benchmarks.cases.stepped_rod import SteppedRod
from benchmarks.cases.wave import WallImpact, WaveFront
from physagent_jax.mpm import Lumped, Sharpened

FORMS = ("mls", "gradient")


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("cells", [32, 64])
def test_a_front_arrives_in_time_and_leaves_a_plateau(cells, form, x64):
    errors = check(WaveFront(), Numerics(cells, dtype=np.float64, stress_form=form))
    assert errors["overshoot"] < 0.2


def test_a_front_in_single_precision():
    check(WaveFront(), Numerics(64))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("cells", [16, 32])
def test_a_bar_leaves_a_wall_after_two_transits_with_its_momentum(cells, form, x64):
    errors = check(WallImpact(), Numerics(cells, dtype=np.float64, stress_form=form))
    assert errors["momentum"] < 0 and errors["kinetic energy"] < 0  # a wall gives nothing


def test_the_rebound_improves_with_the_grid(x64):
    coarse, fine = (check(WallImpact(), Numerics(cells, dtype=np.float64))["momentum"] for cells in (16, 64))
    assert np.log2(coarse / fine) / 2 > 0.6  # fronts widen as cells^(1/3)


def test_an_impact_in_single_precision():
    check(WallImpact(), Numerics(32))


@pytest.mark.parametrize("inertia", [Lumped(), Sharpened()])
def test_a_step_of_stiffness_throws_back_a_third_of_a_pulse(inertia, x64):
    """And lets two thirds through, to second order."""
    coarse, fine = (
        check(SteppedRod(), Numerics(cells, dtype=np.float64, inertia=inertia))["velocity (rms)"]
        for cells in (64, 128)
    )
    assert np.log2(coarse / fine) > 1.8


@pytest.mark.parametrize("inertia", [Lumped(), Sharpened()])
def test_a_ring_that_begins_to_spin_breathes(inertia, x64):
    check(SpinningRing(), Numerics(2, dtype=np.float64, inertia=inertia))
