"""The two kinds of skill side by side: what each does of what is asked, and what else it does."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks import harness
from benchmarks.executor.scenes import Clip, Setting, prepare
from benchmarks.executor.tasks import LAST
from benchmarks.harness import Row
from physagent_jax.core.rotations import polar
from physagent_jax.core.strict import Vector
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.motion import kinds
from physagent_jax.motion.matching import find_causes
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.motion.tolerances import expect_strain
from physagent_jax.motion.vectors import scale
from physagent_jax.motion.wishes import Wish

_TAIL = 2.0  # particles beyond this percentile on either side do not count for an extent [%]


@dataclasses.dataclass(frozen=True)
class Comparison:
    """One effect on one object by one kind.

    Attributes:
        effect: "stretch", "squeeze", "blow" or "twist".
        object: Name of an object of `scenes`.
        kind: "force", "ends", "plates", "instant".
    """

    effect: str
    object: str
    kind: str

    @property
    def name(self) -> str:
        """Unique."""
        return f"{self.effect}: {self.object}: {self.kind}"


_KINDS = {
    "stretch": ("force", "ends"),
    "squeeze": ("force", "ends", "plates"),
    "blow": ("force", "instant"),
    "twist": ("force", "ends"),
}
COMPARISONS = tuple(
    Comparison(effect, name, kind)
    for effect, possible in _KINDS.items()
    for name in ("loaf", "jelly", "robot")
    for kind in possible
)


def compare_kind(comparison: Comparison) -> list[Row]:
    """Simulate it and measure what was asked for, the rest of the motion, and the worst deformation."""
    setting = prepare(comparison.object)
    axis = _find_axis(setting, comparison)
    field, asked = _make_field(setting, comparison, axis)
    clip = setting.simulate(field)
    achieved, unit = _measure(clip, comparison, axis)
    harness.say(f"{comparison.name:28s} {achieved:8.3g} {unit} (asked for {asked:.3g})")
    row: Row = {
        "effect": comparison.effect,
        "object": comparison.object,
        "kind": comparison.kind,
        "asked": asked,
        "achieved": achieved,
        "unit": unit,
        **_measure_collateral(clip, comparison, axis),
        "min_J": clip.min_J,
        "max_J": clip.max_J,
        "field": field.model_dump(mode="json", exclude_none=True),
    }
    return [row]


def _find_axis(setting: Setting, comparison: Comparison) -> Vector:
    """Sideways, but a twist about the longest extent."""
    if comparison.effect != "twist":
        return setting.brief.directions.right
    size = np.ptp(setting.body.particles.x, axis=0)
    x, y, z = np.eye(3)[int(size.argmax())].tolist()
    return (x, y, z)


def _make_field(setting: Setting, comparison: Comparison, axis: Vector) -> tuple[ForceField, float]:
    """The force field, and the amount that is asked for."""
    match comparison.effect:
        case "stretch" | "squeeze":
            return _make_scale(setting, comparison, axis)
        case "blow":
            return _make_blow(comparison, axis)
    return _make_twist(comparison, axis)


def _make_scale(setting: Setting, comparison: Comparison, axis: Vector) -> tuple[ForceField, float]:
    stretches = comparison.effect == "stretch"
    expected = ExpectedMotion(
        kind=MotionKind.STRETCH if stretches else MotionKind.SQUEEZE, direction=axis, window=(0.0, LAST)
    )
    pull = Action(
        action_type=ActionType.SCALE,
        vector=axis,
        magnitude=1.0 if stretches else -1.0,
        active_time=(0.0, LAST),
    )
    field, target = ForceField(actions=(pull,)), expect_strain(expected, not stretches).target
    causes, wish = find_causes(expected, field), Wish(field, expected, (), setting.brief)
    match comparison.kind:
        case "ends":
            field = kinds.move_ends(wish, causes)
        case "plates":
            field = kinds.press_between(wish, causes)
    return field, target


def _make_blow(comparison: Comparison, axis: Vector) -> tuple[ForceField, float]:
    """A blow on the upper third: how much of its velocity the part has, on average over a frame."""
    region = make_end_region((0.0, 0.0, 1.0), 0.67)
    timed = {"vector": axis, "magnitude": 1.0, "active_time": (5.0, 6.0), "region": region}
    if comparison.kind == "force":
        return ForceField(actions=(Action(action_type=ActionType.IMPULSE, **timed),)), 1.0
    blow = VelocityConstraint(constraint_type=ConstraintType.PARTICLE_IMPULSE, **timed)
    return ForceField(constraints=(blow,)), 1.0


def _make_twist(comparison: Comparison, axis: Vector) -> tuple[ForceField, float]:
    """One end against the other by 54 degrees each, in six tenths of the clip."""
    until = float(round(kinds.MOVING * LAST))
    ends = []
    for side in (1.0, -1.0):
        way = scale(axis, side)
        region = make_end_region(way, kinds.SLAB if comparison.kind == "ends" else 0.5)
        timed = {"vector": way, "magnitude": 1.0, "region": region}
        if comparison.kind == "force":
            ends.append(Action(action_type=ActionType.TORQUE, active_time=(0.0, LAST), **timed))
        else:
            ends.append(
                VelocityConstraint(
                    constraint_type=ConstraintType.PARTICLE_ROTATION,
                    active_time=(0.0, until),
                    held_until=LAST,
                    **timed,
                )
            )
    group = "actions" if comparison.kind == "force" else "constraints"
    return ForceField.model_validate({group: ends}), 2 * 90.0 * until / LAST


def _measure(clip: Clip, comparison: Comparison, axis: Vector) -> tuple[float, str]:
    x, n = clip.x, np.asarray(axis)
    match comparison.effect:
        case "stretch" | "squeeze":
            low, high = np.percentile(x @ n, [_TAIL, 100 - _TAIL], axis=1)
            width = (high - low)[-8:].mean() / (high - low)[0] - 1
            return float(width if comparison.effect == "stretch" else -width), "of its extent"
        case "blow":
            part = x[0, :, 2] > x[0, :, 2].min() + 0.67 * np.ptp(x[0, :, 2])
            dt, scaling = clip.config.timing.frame_dt, clip.config.scaling
            assert scaling is not None
            speed = max(((x[k + 1, part] - x[k, part]) @ n).mean() / dt for k in range(5, 9))
            return float(speed / scaling.impulse), "of the blow's speed, in its best frame"
    height = x[0] @ n
    ends = [height > np.percentile(height, 85), height < np.percentile(height, 15)]
    turns = [_measure_turn(x[:, end], n) for end in ends]
    return float(np.degrees(turns[0] - turns[1])), "degrees"


def _measure_turn(x: np.ndarray, axis: np.ndarray) -> float:
    """Angle about ``axis`` by which particles, shape (T, k, 3), have turned at the end [rad], unwrapped."""
    total = 0.0
    for before, after in zip(x[:-1], x[1:]):
        a, b = before - before.mean(0), after - after.mean(0)
        R = polar(b.T @ a)[0]
        total += 0.5 * float(np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) @ axis)
    return total


def _measure_collateral(clip: Clip, comparison: Comparison, axis: Vector) -> Row:
    """Shift and turn of the whole at the end; only the blow asks for them."""
    x = clip.x
    size = float(np.ptp(x[0], axis=0).max())
    moved = (x[-1].mean(0) - x[0].mean(0)) / size
    if comparison.effect == "blow":
        moved = moved - (moved @ np.asarray(axis)) * np.asarray(axis)
    a, b = x[0] - x[0].mean(0), x[-1] - x[-1].mean(0)
    R = polar(b.T @ a)[0]
    angle = float(np.degrees(np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))))
    return {"drift": float(np.linalg.norm(moved)), "turn": angle}
