"""The meaning of M = 1 for each skill, measured on simulated bodies; conservation; regions; windows."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL, RETREAT, TURN
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Holding, Opposition
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.mpm import step
from physagent_jax.mpm.constraints import GradedRotation, GradedTranslation, MovingPlate
from physagent_jax.mpm.energy import angular_momentum, momentum
from tests.mpm.blocks import block

FRAMES, FRAME_DT = 21, 0.02
DURATION = (FRAMES - 1) * FRAME_DT
LENGTH = 0.2
_NONE = ((0.0, 0.0, 0.0),) * 3
HOLDING = Holding(compliance=_NONE, shift=0.1, least=1e-3, most=1e3)
SCALING = make_closed_form_scaling(extent=0.4, youngs_modulus=1e5, density=1000.0, duration=DURATION)


def field(**action):
    return ForceField.model_validate({"actions": [{"magnitude": 1.0, "vector": [1, 0, 0], **action}]})


def moved(
    force_field,
    *,
    cells=(4, 4, 4),
    E=1e6,
    density=1000.0,
    per_frame=20,
    extent=LENGTH,
    seconds=DURATION,
    opposition=None,
    holding=None,
):
    """Simulate a block of longest side 0.2 m under ``force_field``; return (model, start, end)."""
    model, state = block(
        cells,
        size=1.5,
        grid_cells=30,
        low=(0.6, 0.6, 0.6),
        youngs_modulus=E,
        density=density,
        dt=FRAME_DT / per_frame,
        dtype=np.float64,
    )
    scaling = make_closed_form_scaling(
        extent=extent,
        youngs_modulus=E,
        density=density,
        duration=DURATION,
        opposition=opposition,
        holding=holding,
    )
    forces, constraints = compile_force_field(
        force_field,
        scaling,
        np.asarray(state.x),
        np.asarray(model.volume),
        frame_dt=FRAME_DT,
        frame_count=FRAMES,
    )
    model = model.replace(forces=forces, constraints=constraints)
    steps = round(seconds / FRAME_DT * per_frame)
    return model, state, jax.jit(lambda s: jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), s))(state)


def test_translation_moves_one_body_length_over_the_clip(x64):
    _, start, end = moved(field(action_type="translation"))
    np.testing.assert_allclose((end.x - start.x).mean(0), [LENGTH, 0, 0], rtol=0.01, atol=1e-9)


@pytest.mark.parametrize("friction", [0.0, 4.0])
def test_what_stands_gets_longer_upwards(x64, friction):
    """Two ends that part by the same way make it as long; on the ground the lower one stays, else the middle does."""
    ends = [
        {
            "constraint_type": "enforce_particle_translation",
            "vector": [0, 0, sign],
            "magnitude": 0.5,
            "region": {"kind": "half_space", "point": [0.5, 0.5, 0.5 + 0.25 * sign], "normal": [0, 0, sign]},
        }
        for sign in (1.0, -1.0)
    ]
    stands = Opposition(friction=friction, travel=LENGTH, time=1.0)
    _, start, end = moved(ForceField.model_validate({"constraints": ends}), opposition=stands)
    height = np.asarray(start.x[:, 2])
    strain, shift = np.polyfit(height, np.asarray(end.x[:, 2]) - height, 1)
    # The outermost of so few particles lie well inside.
    assert strain == pytest.approx(2 * 0.5 * PRESCRIBED_TRAVEL, rel=0.15)
    assert -shift / strain == pytest.approx(height.min() if friction else height.mean(), abs=0.02 * LENGTH)


def test_motion_does_not_depend_on_density_or_stiffness(x64):
    for density, E in ((300.0, 1e5), (3000.0, 3e6)):
        _, start, end = moved(field(action_type="translation"), density=density, E=E)
        np.testing.assert_allclose((end.x - start.x).mean(0), [LENGTH, 0, 0], rtol=0.01, atol=1e-9)


@pytest.mark.parametrize("magnitude", [0.7, -1.3])
def test_impulse_gives_exactly_its_velocity_change(magnitude, x64):
    push = field(action_type="impulse", vector=[0, 0, 2], magnitude=magnitude, active_time=[3.37, 4.13])
    model, _, end = moved(push)
    change = momentum(model, end) / model.mass.sum()
    np.testing.assert_allclose(change, [0, 0, magnitude * LENGTH / DURATION], rtol=1e-9, atol=1e-12)


def test_torque_turns_a_quarter_and_adds_the_angular_momentum_it_should(x64):
    model, start, end = moved(field(action_type="torque", vector=[0, 0, 1]))
    a = np.asarray(start.x - start.x.mean(0))
    b = np.asarray(end.x - end.x.mean(0))
    turn = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a[:, :2] * b[:, :2]).sum())
    np.testing.assert_allclose(np.degrees(turn), 90, rtol=0.02)
    # APIC particles have an own moment of inertia of m dx^2 / 2 about each axis.
    inertia = float((model.mass * ((a[:, :2] ** 2).sum(1) + 0.05**2 / 2)).sum())
    spin = angular_momentum(model, end, end.x.mean(0))[2]
    np.testing.assert_allclose(spin, inertia * np.pi / DURATION, rtol=0.02)
    np.testing.assert_allclose(momentum(model, end), 0, atol=1e-9)


@pytest.mark.parametrize("magnitude", [0.4, -0.4])
def test_scale_strains_a_bar_by_the_stated_amount(magnitude, x64):
    """Linear bar under opposed body forces on its halves: mean strain 0.15 M (rho a L / 4 E)."""
    _, start, end = moved(
        field(action_type="scale", magnitude=magnitude),
        cells=(8, 2, 2),
        E=1e5,
        seconds=0.8 * DURATION,
        extent=0.4,
    )
    extent = [float(s.x[:, 0].max() - s.x[:, 0].min()) for s in (start, end)]
    np.testing.assert_allclose(extent[1] / extent[0] - 1, 0.15 * magnitude, rtol=0.2)


def test_scale_changes_neither_momentum_nor_angular_momentum(x64):
    lopsided = ForceField.model_validate(
        {
            "actions": [
                {
                    "action_type": "scale",
                    "vector": [1, 1, 0],
                    "magnitude": 1.0,
                    "region": {"kind": "half_space", "point": [0.4, 0.3, 0.5], "normal": [1, 0.5, 0.2]},
                }
            ]
        }
    )
    model, _, end = moved(lopsided, E=1e5)
    scale = float(model.mass.sum()) * LENGTH / DURATION
    np.testing.assert_allclose(momentum(model, end), 0, atol=1e-6 * scale)
    np.testing.assert_allclose(angular_momentum(model, end, end.x.mean(0)), 0, atol=1e-6 * scale * LENGTH)


def test_a_region_confines_the_force(x64):
    top = field(
        action_type="translation",
        region={"kind": "half_space", "point": [0.5, 0.5, 0.5], "normal": [0, 0, 1]},
    )
    model, start, end = moved(top)
    change = momentum(model, end)[0] / model.mass.sum()
    np.testing.assert_allclose(change, 0.5 * 2 * LENGTH / DURATION, rtol=1e-9)  # half of the mass is pushed


def test_velocity_constraints_are_exact(x64):
    pull = ForceField.model_validate(
        {
            "constraints": [
                {
                    "constraint_type": "enforce_particle_translation",
                    "vector": [1, 0, 0],
                    "magnitude": 1.0,
                    "active_time": [0, 10],
                },
                {
                    "constraint_type": "particle_impulse",
                    "vector": [0, 1, 0],
                    "magnitude": 1.0,
                    "active_time": [10, 11],
                },
            ]
        }
    )
    _, start, end = moved(pull)
    travelled = 0.5 * LENGTH / DURATION * DURATION  # held speed for half of the clip, then coasting on
    np.testing.assert_allclose((end.x - start.x).mean(0)[0], travelled, rtol=1e-6)
    np.testing.assert_allclose(end.v.mean(0)[1], LENGTH / DURATION, rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "field_name"),
    [
        ({"vector": [0, 0, 0]}, "vector"),
        ({"vector": [1, float("nan"), 0]}, "vector"),
        ({"magnitude": 3.0}, "magnitude"),
        ({"magnitude": 0.0}, "magnitude"),
        ({"action_type": "teleport"}, "action_type"),
        ({"active_time": [5, 5]}, "active_time"),
        ({"active_time": [-1, 5]}, "active_time"),
        ({"strength": 2}, "strength"),
        ({"region": {"kind": "box", "low": [0, 0, 0], "high": [1, 0, 1]}}, "region"),
        ({"region": {"kind": "blob"}}, "region"),
    ],
)
def test_schema_errors_name_the_field(change, field_name):
    with pytest.raises(ValidationError) as error:
        field(**{"action_type": "translation", **change})
    assert field_name in str(error.value.errors()[0]["loc"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"region": {"kind": "sphere", "center": [5, 5, 5], "radius": 0.1}}, "selects no particle"),
        ({"active_time": [40, 50]}, "begins after the clip's last frame 20"),
        ({"object": "teapot"}, "names an object"),
    ],
)
def test_impossible_actions_are_refused(change, message, x64):
    with pytest.raises(UserError, match=message):
        moved(field(action_type="translation", **change))


def test_a_thin_neck_is_strained_no_more_than_a_bar(x64):
    """A dumb-bell: two heads of 4 x 4 cells joined by a neck of 2 x 2. Unreduced, the neck would carry
    four times the stress of a bar's middle and tear."""
    model, state = block(
        (10, 4, 4), size=1.5, grid_cells=30, low=(0.5, 0.6, 0.6), youngs_modulus=1e5, dtype=np.float64
    )
    x = np.asarray(state.x)
    neck = np.abs(x[:, 0] - 0.75) < 0.1
    thin = np.all(np.abs(x[:, 1:] - 0.7) < 0.05, axis=1)
    keep = thin | ~neck
    rest, volume = x[keep], np.asarray(model.volume)[keep]
    scaling = make_closed_form_scaling(extent=0.5, youngs_modulus=1e5, density=1000.0, duration=DURATION)
    pull = field(action_type="scale")

    def strength(rest, volume):
        forces, _ = compile_force_field(pull, scaling, rest, volume, frame_dt=FRAME_DT, frame_count=FRAMES)
        return float(forces[0].magnitude)

    bar = strength(x, np.asarray(model.volume))
    np.testing.assert_allclose(bar, scaling.scale, rtol=0.15)  # a section is a tenth thick
    # Beyond the middle: a head of 3 x 4 x 4 and a neck of 2 x 2 x 2 cells, over 2 x 2; the bar: 5 cells.
    np.testing.assert_allclose(strength(rest, volume) / bar, 5 / ((48 + 8) / 4), rtol=0.15)


@pytest.mark.parametrize(
    "change",
    [{"duration": 1e-9}, {"density": 1e-9, "youngs_modulus": 1e13}, {"extent": 1e-20, "duration": 1e3}],
)
def test_accelerations_beyond_float32_are_refused_in_words(change):
    values = {"extent": 1.0, "youngs_modulus": 1e5, "density": 200.0, "duration": 2.0} | change
    with pytest.raises(UserError, match="closed form for L = "):
        make_closed_form_scaling(**values)


def constraint_of(kind, **changes):
    item = {"constraint_type": kind, "vector": [1, 0, 0]} | changes
    return ForceField.model_validate({"constraints": [item]})


@pytest.mark.parametrize("per_frame", [3, 10, 17])
def test_a_particle_impulse_is_one_substep_long(per_frame, x64):
    """Whatever the step, all of the change comes in one, the first that begins with its moment."""
    blow = constraint_of("particle_impulse", vector=[0, 0, 2], magnitude=-0.7, active_time=[3, 4])
    terms, constraints = compile_force_field(
        blow,
        SCALING,
        np.ones((4, 3)) * np.arange(4)[:, None],
        np.ones(4),
        frame_dt=FRAME_DT,
        frame_count=FRAMES,
    )
    assert constraints == ()
    (term,), dt = terms, FRAME_DT / per_frame
    changes = []
    for k in range(8 * per_frame):
        now = term.acceleration(jnp.zeros((4, 3)), jnp.zeros((4, 3)), jnp.ones(4), k * dt, dt)
        changes.append(np.asarray(now * dt).mean(0))  # what is struck gets more, the whole as much
    (at,) = np.flatnonzero(np.abs(changes).sum(-1) > 0)
    assert at in (3 * per_frame, 3 * per_frame - 1)  # the clock k dt may be off by round-off
    np.testing.assert_allclose(changes[at], [0, 0, -0.7 * SCALING.impulse], rtol=1e-6)


def test_opposed_ends_part_by_a_share_of_the_extent_between_them(x64):
    """k of a part goes by the object's extent along the motion, and what is held stays."""
    ends = [
        dict(
            constraint_type="enforce_particle_translation",
            vector=[0, side, 0],
            magnitude=0.8,
            active_time=[0, 8],
            held_until=18,
            region={"kind": "half_space", "point": [0.5, 0.5 + 0.3 * side, 0.5], "normal": [0, side, 0]},
        )
        for side in (1, -1)
    ]
    pull = ForceField.model_validate({"constraints": ends})
    # Particles fill the block but for half their distance: 0.375 m by 0.175 m.
    model, start, end = moved(pull, cells=(8, 4, 2), E=1e5, seconds=0.8 * DURATION, extent=0.375)
    width = [float(np.ptp(np.asarray(s.x[:, 1]))) for s in (start, end)]
    np.testing.assert_allclose(width[1] / width[0] - 1, 2 * 0.5 * 0.8 * 8 / 20, rtol=1e-6)
    np.testing.assert_allclose(momentum(model, end)[1], 0, atol=1e-9)


@pytest.mark.parametrize("degrees", [0, 15, 40, 90])
@pytest.mark.parametrize("kind", ["enforce_particle_translation", "enforce_particle_rotation"])
def test_ends_are_ends_from_wherever_they_are_seen(kind, degrees):
    """Regions are fractions of a box that is no cube: across an oblique line they are no slabs."""
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    ends = [
        dict(
            constraint_type=kind,
            vector=(sign * way).tolist(),
            active_time=[0, 8],
            region=make_end_region(tuple((sign * way).tolist()), 0.75),
        )
        for sign in (1, -1)
    ]
    rest = np.random.default_rng(0).uniform(0, 1, (500, 3)) * [1.0, 0.25, 0.7]
    _, (made,) = compile_force_field(
        ForceField.model_validate(dict(constraints=ends)),
        SCALING,
        rest.astype(np.float32),
        np.ones(len(rest), np.float32),
        frame_dt=FRAME_DT,
        frame_count=FRAMES,
    )
    assert isinstance(made, GradedTranslation | GradedRotation)
    np.testing.assert_allclose(np.abs(made.axis @ way), 1, rtol=1e-6)


def test_opposed_rotations_wring_every_section_in_proportion(x64):
    """Also where the object is no longer where it was at the start."""
    ends = [
        dict(
            constraint_type="enforce_particle_rotation",
            vector=[side, 0, 0],
            magnitude=0.8,
            active_time=[10, 18],
            region={"kind": "half_space", "point": [0.5 + 0.3 * side, 0.5, 0.5], "normal": [side, 0, 0]},
        )
        for side in (1, -1)
    ]
    push = dict(action_type="translation", vector=[0, 1, 0], active_time=[0, 10])
    twist = ForceField.model_validate({"actions": [push], "constraints": ends})
    _, start, end = moved(twist, cells=(8, 3, 3), E=1e5, seconds=0.9 * DURATION, extent=0.4)
    along = np.asarray(start.x[:, 0], float)
    middle = along.mean()
    ends_middle = (along[along > along.min() + 0.8 * np.ptp(along)] - middle).mean()
    for section in np.unique(along.round(6)):
        inside = np.abs(along - section) < 1e-4
        a, b = (np.asarray(s.x)[inside] - np.asarray(s.x)[inside].mean(0) for s in (start, end))
        turn = np.arctan2((a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]).sum(), (a[:, 1:] * b[:, 1:]).sum())
        wanted = 0.8 * SCALING.rotation * 8 * FRAME_DT * (section - middle) / ends_middle
        np.testing.assert_allclose(turn, wanted, rtol=0.03, atol=1e-3)
        assert float((end.x - start.x)[inside, 1].mean()) > 0.1  # it has been pushed there


@pytest.mark.parametrize(("side", "width"), [(1, 7), (-1, 2)])
def test_an_end_of_what_is_held_is_wrung_against_the_other(side, width, x64, least_optimised):
    """From none at the held end to all of it at the free one, for slender and stubby objects."""
    end = dict(
        constraint_type="enforce_particle_rotation",
        vector=[side, 0, 0],
        magnitude=0.8,
        active_time=[0, 10],
        region={"kind": "half_space", "point": [0.5 + 0.3 * side, 0.5, 0.5], "normal": [side, 0, 0]},
    )
    _, start, after = moved(
        ForceField.model_validate({"constraints": [end]}),
        cells=(8, width, width),
        E=1e5,
        seconds=0.5 * DURATION,
        extent=0.4,
        holding=HOLDING,
    )
    off = np.asarray(start.x[:, 0], float)
    off = side * (off - (off.min() if side > 0 else off.max()))
    turned = off[off > 0.8 * off.max()].mean()
    for section in np.unique(off.round(6)):
        inside = np.abs(off - section) < 1e-4
        a, b = (np.asarray(s.x)[inside] - np.asarray(s.x)[inside].mean(0) for s in (start, after))
        turn = np.arctan2((a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]).sum(), (a[:, 1:] * b[:, 1:]).sum())
        wanted = 0.8 * TURN / DURATION * 10 * FRAME_DT * section / turned
        np.testing.assert_allclose(side * turn, wanted, rtol=0.03, atol=2e-3)


def test_a_thin_neck_stretches_as_much_as_what_is_thick(x64):
    """Moved as slabs, the ends would strain the neck many times more than the rest."""
    ends = [
        dict(
            constraint_type="enforce_particle_translation",
            vector=[side, 0, 0],
            magnitude=1.0,
            active_time=[0, 12],
            region={"kind": "half_space", "point": [0.5 + 0.25 * side, 0.5, 0.5], "normal": [side, 0, 0]},
        )
        for side in (1, -1)
    ]
    field = ForceField.model_validate({"constraints": ends})
    model, state = block((12, 5, 5), size=1.5, grid_cells=30, low=(0.45, 0.6, 0.6), youngs_modulus=1e5, dt=1e-3,
                         dtype=np.float64)  # fmt: skip
    x = np.asarray(state.x)
    out = (np.abs(x[:, 0] - x[:, 0].mean()) < 0.08) & (np.abs(x[:, 1:] - x[:, 1:].mean(0)).max(1) > 0.06)
    x = x[~out]
    constraints = compile_force_field(
        field, SCALING, x, np.asarray(model.volume)[~out], frame_dt=FRAME_DT, frame_count=FRAMES
    )[1]
    # The motion that the constraints impose: every section parts in proportion to its distance from the middle.
    (motion,) = constraints
    nodes, mass = jnp.asarray(x), jnp.ones(len(x))
    change = motion.find_change(nodes, jnp.zeros_like(nodes), nodes.mean(0), 0.0, mass)
    slope = np.asarray(change)[:, 0] / (x[:, 0] - x[:, 0].mean())
    np.testing.assert_allclose(slope, slope[0], rtol=1e-9)
    np.testing.assert_allclose(
        slope[0] * np.ptp(x[:, 0]),
        2 * SCALING.velocity * np.ptp(x[:, 0]) / np.ptp(x, axis=0).max(),
        rtol=1e-6,
    )
    assert np.abs(np.asarray(change)[:, 1:]).max() == 0  # free across


def test_plates_press_what_lies_between_them(x64):
    plates = [
        dict(constraint_type="moving_plate", vector=[-side, 0, 0], magnitude=0.4, active_time=[0, 10])
        for side in (1, -1)
    ]
    squeeze = ForceField.model_validate({"constraints": plates})
    _, start, end = moved(squeeze, cells=(8, 4, 4), E=1e5, seconds=0.5 * DURATION, extent=0.4)
    length = [float(np.ptp(np.asarray(s.x[:, 0]))) for s in (start, end)]
    # Contact is felt up to a cell and a half before the plate: 0.2 asked for, a little more is had.
    assert -0.45 < length[1] / length[0] - 1 < -0.15
    np.testing.assert_allclose(end.x[:, 0].mean(), start.x[:, 0].mean(), atol=0.005)


def test_plates_on_a_region_press_that_alone(x64):
    region = dict(kind="half_space", point=[0.7, 0.5, 0.5], normal=[1, 0, 0])
    told = dict(constraint_type="moving_plate", magnitude=1.0, active_time=[0, 10], region=region)
    squeeze = ForceField.model_validate(
        {"constraints": [told | dict(vector=[0, 0, side]) for side in (1, -1)]}
    )
    _, start, end = moved(squeeze, cells=(12, 4, 4), E=1e5, seconds=0.5 * DURATION, extent=0.6)
    x, y = np.asarray(start.x), np.asarray(end.x)
    share = (x[:, 0] - x[:, 0].min()) / np.ptp(x[:, 0])
    outer = (x[:, 2] == x[:, 2].min(), x[:, 2] == x[:, 2].max())
    low, high = (
        [(y - x)[face & side, 2].mean() / np.ptp(x[:, 2]) for side in (share > 0.75, share < 0.5)]
        for face in outer
    )
    assert (
        0.08 < low[0] < 0.3 and -0.3 < high[0] < -0.08
    )  # half of its height is asked for, less is had in contact
    assert max(abs(low[1]), abs(high[1])) < 0.01


def test_a_plate_stays_and_then_goes_back_slowly(x64):
    """Let go at once, soft matter leaps off the ground."""
    told = dict(constraint_type="moving_plate", vector=[0, 0, -1], magnitude=1.0, active_time=[0, 4])
    for held in ({}, {"held_until": 7}):
        field = ForceField.model_validate({"constraints": [told | held]})
        x = np.random.default_rng(0).random((200, 3))
        _, plates = compile_force_field(
            field, SCALING, x, np.ones(len(x)), frame_dt=FRAME_DT, frame_count=FRAMES
        )
        faces = [each.face for each in plates if isinstance(each, MovingPlate)]
        times = [(float(face.start), float(face.end)) for face in faces]
        assert all(one[1] == other[0] for one, other in zip(times, times[1:]))
        assert times[-1][0] == pytest.approx(FRAME_DT * (7 if held else 4))
        assert times[-1][1] - times[-1][0] == pytest.approx(RETREAT)
        way = sum(
            np.asarray(face.velocity) * (end - start)
            for face, (start, end) in zip(faces, times)
            if face.velocity is not None
        )
        assert np.allclose(way, 0, atol=1e-6)


@pytest.mark.parametrize("following", [None, 12])
def test_what_was_pressed_is_led_evenly_back_until_something_else_acts(following):
    """Soft matter kicked itself off the ground although the plate went back slowly."""
    plates = [
        dict(constraint_type="moving_plate", vector=[side, 0, 0], magnitude=1.0, active_time=[0, 4])
        for side in (1, -1)
    ]
    push = (
        [] if following is None else [dict(action_type="translation", vector=[0, 1, 0], active_time=[12, 19])]
    )
    x = np.random.default_rng(0).random((200, 3))
    _, made = compile_force_field(
        ForceField.model_validate(dict(constraints=plates, actions=push)),
        SCALING,
        x,
        np.ones(len(x)),
        frame_dt=FRAME_DT,
        frame_count=FRAMES,
    )
    press, back = [each for each in made if isinstance(each, GradedTranslation)]
    assert not press.limits and back.limits and back.start == press.end
    pressed, until = float(press.speed * (press.end - press.start)), float(press.end) + RETREAT
    assert float(back.speed) == pytest.approx(-pressed / RETREAT)
    assert float(back.end) == pytest.approx(until if following is None else min(until, FRAME_DT * following))


@pytest.mark.parametrize(
    "changes",
    [{"held_until": 5}, {"active_time": None, "held_until": 12}, {"constraint_type": "particle_impulse"}],
)
def test_what_cannot_be_held_is_refused(changes):
    item = dict(constraint_type="moving_plate", vector=[1, 0, 0], active_time=[0, 8], held_until=12)
    with pytest.raises(ValidationError, match="held_until"):
        ForceField.model_validate({"constraints": [item | changes]})
