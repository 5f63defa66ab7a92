"""The distance of a force from the one that made the motion, its identifiable numbers, and its cost."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import Torque, UniformAcceleration, VelocityChange
from physagent_jax.metrics.effort import measure_effort
from physagent_jax.metrics.identifiability import find_identifiability
from physagent_jax.metrics.recovery import Force, compare_forces
from physagent_jax.mpm.boundaries.half_space import HalfSpace
from physagent_jax.mpm.constraints import GradedRotation, GradedTranslation, MovingPlate, PrescribedMotion


def force(vector, kind="translation", window=(0, 10), **more):
    return Force(kind=kind, vector=vector, window=window, **more)


def test_magnitude_and_direction_are_told_apart():
    hidden = force((2, 0, 0))
    longer = compare_forces([hidden], [force((2.5, 0, 0))])
    assert longer.magnitude_percent == pytest.approx(25) and longer.direction_degrees == pytest.approx(0)
    turned = compare_forces([hidden], [force((1, np.sqrt(3), 0))])
    assert turned.magnitude_percent == pytest.approx(0) and turned.direction_degrees == pytest.approx(60)
    assert compare_forces([hidden], [force((-2, 0, 0))]).direction_degrees == pytest.approx(180)


def test_actions_are_paired_by_kind_and_time():
    hidden = [force((1, 0, 0)), force((0, 1, 0), window=(10, 20)), force((0, 0, 1), "torque")]
    errors = compare_forces(hidden, [hidden[2], hidden[1], hidden[0]])
    assert errors.magnitude_percent == 0 and errors.direction_degrees == 0
    assert errors.missing == errors.extra == 0
    later = compare_forces(hidden[:1], [force((1, 0, 0), window=(4, 12))])
    assert later.actions[0].window_percent == pytest.approx(100 * (4 + 2) / 10)


def test_what_is_not_found_counts_in_full_and_what_is_too_many_is_said():
    errors = compare_forces([force((1, 0, 0)), force((0, 1, 0), "torque")], [force((1, 0, 0))] * 2)
    assert errors.missing == 1 and errors.extra == 1
    assert errors.magnitude_percent == pytest.approx(50) and errors.direction_degrees == 0
    nothing = compare_forces([force((1, 0, 0))], [])
    assert nothing.magnitude_percent == 100 and nothing.direction_degrees is None


def test_a_stretch_along_a_line_is_one_along_its_other_end_but_a_squeeze_is_not():
    def scale(vector, magnitude):
        return Force(
            kind="scale",
            vector=tuple(magnitude * np.array(vector)),
            window=(0, 10),
            axial=True,
            magnitude=magnitude,
        )

    hidden = scale((1.0, 0.0, 0.0), 1.2)
    assert compare_forces([hidden], [scale((-1.0, 0.0, 0.0), 1.2)]).direction_degrees == pytest.approx(0)
    assert compare_forces([hidden], [scale((1.0, 0.0, 0.0), -1.2)]).direction_degrees == pytest.approx(180)
    assert compare_forces([hidden], [scale((-1.0, 0.0, 0.0), -1.2)]).direction_degrees == pytest.approx(180)


def test_eigenvalues_and_directions_of_a_known_jacobian():
    """Singular values 4, 2, 0 along known directions, of unit parameters; the last cannot be told."""
    turn = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    J = np.random.default_rng(0).normal(size=(7, 3))
    J = np.linalg.qr(J)[0] @ np.diag([4.0, 2.0, 0.0]) @ turn
    seen = find_identifiability(J, ["a", "b", "c"], np.ones(3))
    np.testing.assert_allclose(seen.eigenvalues, [16, 4, 0], atol=1e-9)
    assert seen.identified == 2 and seen.unidentified == ("c",) and seen.condition is None
    np.testing.assert_allclose(np.abs(seen.directions[0]), [0.6, 0.8, 0], atol=1e-9)
    assert find_identifiability(J[:, :2], ["a", "b"], np.ones(2)).condition == pytest.approx(
        np.linalg.cond(J[:, :2])
    )
    scaled = find_identifiability(J[:, :2], ["a", "b"], np.full(2, 0.01))  # so little cannot be told
    assert scaled.identified == 0 and scaled.eigenvalues[0] == pytest.approx(16 * 1e-4)


def test_a_jacobian_that_makes_no_sense_is_refused():
    with pytest.raises(UserError, match="same parameters"):
        find_identifiability(np.ones((4, 3)), ["a", "b"], np.ones(2))
    with pytest.raises(UserError, match="finite"):
        find_identifiability(np.full((4, 2), np.nan), ["a", "b"], np.ones(2))


@dataclasses.dataclass
class Scene:
    """The forces, constraints and masses from which effort is computed."""

    mass: jnp.ndarray
    forces: tuple = ()
    constraints: tuple = ()
    axis: None = None


FRAMES, DT = 11, 0.1
REST = np.random.default_rng(2).uniform(-0.5, 0.5, (40, 3)).astype(np.float32)
STILL = np.tile(REST, (FRAMES, 1, 1))
MASS = jnp.asarray(np.r_[np.full(20, 1.0), np.full(20, 3.0)], jnp.float32)


def number(value):
    return jnp.asarray(value, jnp.float32)


def test_the_effort_of_pushes_and_blows_is_their_change_of_velocity():
    push = UniformAcceleration(number([0.0, 3.0, 4.0]), number(0.2), number(0.6))
    assert measure_effort(Scene(MASS, (push,)), STILL, DT) == pytest.approx(5 * 0.4, rel=1e-5)
    against = dataclasses.replace(push, value=-push.value)
    assert measure_effort(Scene(MASS, (push, against)), STILL, DT) == pytest.approx(2 * 5 * 0.4, rel=1e-5)
    half = dataclasses.replace(push, weight=number(np.r_[np.ones(20), np.zeros(20)]))
    assert measure_effort(Scene(MASS, (half,)), STILL, DT) == pytest.approx(5 * 0.4 / 4, rel=1e-5)
    blow = VelocityChange(number([0.0, 0.0, -1.5]), number(0.31), number(0.31))
    assert measure_effort(Scene(MASS, (blow,)), STILL, DT) == pytest.approx(1.5, rel=1e-5)


def test_the_effort_of_a_turn_is_by_the_distance_from_its_axis():
    turn = Torque(number([0.0, 0.0, 1.0]), number(2.0), number(0.0), number(1.0))
    arm = REST - MASS @ REST / MASS.sum()
    expected = 2.0 * (MASS @ np.linalg.norm(arm[:, :2], axis=1)) / MASS.sum()
    assert measure_effort(Scene(MASS, (turn,)), STILL, DT) == pytest.approx(float(expected), rel=0.05)


def test_what_prescribes_a_velocity_counts_as_it():
    some = np.arange(20, 40, dtype=np.int32)
    moved = PrescribedMotion(
        jnp.asarray(some), number([0.6, 0, 0.8]), number([0, 0, 0]), None, number(0), number(1)
    )
    assert measure_effort(Scene(MASS, (), (moved,)), STILL, DT) == pytest.approx(0.75, rel=1e-5)
    held = PrescribedMotion.fixed(jnp.asarray(some))
    assert measure_effort(Scene(MASS, (), (held,)), STILL, DT) == 0.0


def test_what_moves_evenly_from_end_to_end_counts_as_it_begins():
    axis, window = number([0.0, 0.0, 1.0]), dict(start=number(0.2), end=number(0.6))
    arm = REST - MASS @ REST / MASS.sum()
    share = MASS / MASS.sum()
    longer = GradedTranslation(axis=axis, speed=number(-0.5), length=number(1.0), **window)
    expected = 0.5 * (share @ abs(arm[:, 2]))
    assert measure_effort(Scene(MASS, (), (longer,)), STILL, DT) == pytest.approx(float(expected), rel=1e-5)
    wrung = GradedRotation(
        axis=axis, rate=number(3.0), length=number(1.0), offset=number(np.zeros((2, 3))), **window
    )
    expected = 3.0 * 2 * (share @ (abs(arm[:, 2]) * np.linalg.norm(arm[:, :2], axis=1)))
    assert measure_effort(Scene(MASS, (), (wrung,)), STILL, DT) == pytest.approx(float(expected), rel=1e-5)
    kept = dataclasses.replace(longer, speed=number(0.0)), dataclasses.replace(wrung, rate=number(0.0))
    assert measure_effort(Scene(MASS, (), kept), STILL, DT) == 0.0


def test_a_plate_counts_as_if_it_moved_all():
    up, zero, one = number([0.0, 0.0, 1.0]), number(0.0), number(1.0)
    face = HalfSpace(-up, up, zero, zero, one, velocity=0.7 * up)
    assert measure_effort(Scene(MASS, (), (MovingPlate(face),)), STILL, DT) == pytest.approx(0.7, rel=1e-5)
