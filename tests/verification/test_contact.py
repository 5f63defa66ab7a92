"""Colliding bodies: restitution, where contact begins, and Hertz's law."""

import numpy as np
import pytest

from benchmarks.cases.ball_drop import BallDrop, hertz_time
from benchmarks.cases.base import Numerics, check
from benchmarks.cases.disks import Disks


@pytest.mark.parametrize("cells", (20, 40))
def test_two_disks_rebound_like_those_of_an_independent_code(cells, x64):
    errors = check(Disks(), Numerics(cells, dtype=np.float64, per_axis=3))
    assert (
        errors["gap at contact [cells]"] > 0.5
    )  # fields overlap: later contact would mean something else is measured


def test_the_classical_stress_form_rebounds_alike(x64):
    check(Disks(), Numerics(20, dtype=np.float64, per_axis=3, stress_form="gradient"))


def test_two_disks_rebound_in_single_precision():
    check(Disks(), Numerics(40, per_axis=3))


def test_disks_without_affine_motion_would_be_found_out(x64):
    with pytest.raises(AssertionError, match="restitution"):
        check(Disks(), Numerics(20, dtype=np.float64, per_axis=3, transfer="pic"))


def test_hertz_contact_lasts_2_943_times_depth_over_speed():
    assert hertz_time(1.0, 1.0) == pytest.approx(2.943, abs=1e-3)  # Johnson 1985, eq. 11.24
    q = np.linspace(0.4, 1, 200_001)
    middle = 0.5 * (q[1:] + q[:-1])
    assert hertz_time(1.0, 1.0, 0.4) == pytest.approx(
        2 * (np.diff(q) / np.sqrt(1 - middle**2.5)).sum(), rel=2e-3
    )


def test_a_ball_rebounds_from_a_floor_nearly_as_hertz_says():
    check(BallDrop(), Numerics(8, step=("courant", 0.6)))


@pytest.mark.slow
def test_a_ball_rebounds_from_a_floor_as_hertz_says():
    check(BallDrop(), Numerics(12, step=("courant", 0.6)))
