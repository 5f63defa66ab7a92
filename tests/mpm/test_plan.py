"""Parts without effect are left out of a frame, and the results are those of the whole model."""

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.terms import UniformAcceleration, Wind
from physagent_jax.mpm import Contact, DomainBox, HalfSpace, PrescribedMotion, RigidBody, plan, simulate
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.plan import Timetable, find_acting
from tests.mpm.blocks import block

# Small scenes, whose programs take longer to compile than to run.
pytestmark = pytest.mark.usefixtures("least_optimised")

FRAME = 0.02


def push(start, end):
    return UniformAcceleration(jnp.array([3.0, 0.0, 1.0]), jnp.asarray(start), jnp.asarray(end))


def gust(start, end):
    return Wind(jnp.array([0.0, 1.0, 0.0]), 2.0, 1.0, 0.5, Envelope.pulse(start, end))


def floor(start, end):
    return HalfSpace(
        point=jnp.array([0.0, 0.0, 0.42]),
        normal=jnp.array([0.0, 0.0, 1.0]),
        friction=jnp.asarray(0.5),
        start=jnp.asarray(start),
        end=jnp.asarray(end),
        contact=Contact.SEPARATE,
    )


def grip(start, end):
    return PrescribedMotion(
        particles=jnp.arange(4, dtype=jnp.int32),
        velocity=jnp.array([0.0, 0.1, 0.0]),
        angular_velocity=jnp.zeros(3),
        center=jnp.zeros(3),
        start=jnp.asarray(start),
        end=jnp.asarray(end),
    )


@pytest.mark.parametrize("part", [push, gust, floor, grip])
@pytest.mark.parametrize(
    "start, end, acts",
    [
        (0.0, 1.0, True),
        (0.2, 1.0, True),
        (0.0, 0.1, True),
        (0.11, 0.12, True),
        (0.3, 1.0, False),
        (0.0, 0.05, False),
    ],
)
def test_a_part_acts_where_its_window_meets_the_stretch(part, start, end, acts):
    model, _ = block()
    field = {push: "forces", gust: "forces", floor: "boundaries", grip: "constraints"}[part]
    model = model.replace(**{field: (part(start, end),)})
    assert len(getattr(find_acting(model, 0.1, 0.2), field)) == acts


def test_particles_let_go_one_by_one_are_held_until_the_last_is_free():
    model, _ = block()
    model = model.replace(constraints=(grip(0.0, np.linspace(0.1, 0.4, 4)),))
    assert find_acting(model, 0.3, 0.35).constraints
    assert not find_acting(model, 0.45, 0.5).constraints


def test_what_has_no_window_always_acts():
    model, _ = block()
    model = model.replace(
        boundaries=(DomainBox(3),), constraints=(RigidBody(jnp.arange(4, dtype=jnp.int32)),)
    )
    alone = find_acting(model, 5.0, 6.0).select(model)
    assert alone.boundaries == model.boundaries and len(alone.constraints) == 1


@pytest.mark.parametrize("worth", [0.0, np.inf])
def test_frames_are_those_of_the_whole_model(x64, monkeypatch, worth):
    monkeypatch.setattr(plan, "WORTH", worth)
    model, state = block(
        gravity=jnp.array([0.0, 0.0, -9.8]),
        low=(0.4, 0.4, 0.45),
        dtype=np.float64,
        boundaries=(DomainBox(3),),
    )
    model = model.replace(
        forces=(push(0.03, 0.05), gust(0.08, 0.12)),
        boundaries=(*model.boundaries, floor(0.05, 0.09)),
        constraints=(grip(0.0, 0.03),),
    )
    sets = []
    for frame in simulate(model, state, frame_count=9, frame_dt=FRAME):
        if frame.index:
            present = find_acting(model, float(state.time), float(state.time) + FRAME)
            assert frame.acting.join(present) == frame.acting
            sets.append(frame.acting)
            whole = model.replace(grid=frame.grid, dt=jnp.asarray(frame.dt))
            expected, _, _ = advance(whole, state, jnp.int32(frame.substeps))
            for name in ("x", "v", "C", "F"):
                got, wanted = getattr(frame.state, name), getattr(expected, name)
                np.testing.assert_allclose(
                    got, wanted, rtol=1e-11, atol=1e-11, err_msg=f"{name}, {frame.index}"
                )
        state = frame.state
    assert len(set(sets)) > 3  # not the same parts throughout
    kept = [later.join(earlier) == later for earlier, later in zip(sets, sets[1:])]
    assert all(kept) if worth else not all(kept)


@pytest.mark.parametrize("work, most", [(0.0, 2), (np.inf, 2)])
def test_one_stroke_after_another_is_the_same_program(work, most):
    """Eight strokes were eight programs, as what had acted stayed whatever took its place."""
    model, _ = block()
    strokes = tuple(grip(0.1 * k, 0.1 * (k + 1)) for k in range(8))
    model = model.replace(constraints=strokes, forces=(push(0.0, 0.15),))
    timetable, acting, seen = Timetable.of(model), None, set()
    for k in range(20):
        begin = 0.04 * k
        acting = timetable.choose_acting(model, begin, begin + 0.04, work, acting)
        present = find_acting(model, begin, begin + 0.04)
        assert acting.join(present) == acting
        assert all(part <= 0.1 * (begin + 0.04) / 0.01 for part in acting.constraints)  # none is let in early
        seen.add((len(acting.forces), len(acting.constraints)))
    assert max(count for _, count in seen) <= most


def test_parts_of_other_kinds_stay_beside_each_other():
    model, _ = block()
    model = model.replace(forces=(push(0.0, 0.1), gust(0.2, 0.3), push(0.2, 0.3)))
    timetable = Timetable.of(model)
    first = timetable.choose_acting(model, 0.0, 0.04, 0.0)
    later = timetable.choose_acting(model, 0.22, 0.26, 0.0, first)
    assert first.forces == (0,) and later.forces == (1, 2)
    assert timetable.choose_acting(model, 0.4, 0.44, 0.0, later).forces == (1, 2)
