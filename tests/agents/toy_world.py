"""A toy world: rigid travel, one rotation, uniform strain, each proportional to what acts, times an unknown gain.

Lengths are body lengths and the clip lasts one unit of time, so that the skill library's scaling holds with
gain 1: M = 1 moves and turns a free object as far as it is calibrated to, and strains it as much as is expected.
A held object follows the force without inertia.
"""

from __future__ import annotations

import math

from physagent_jax.agents.context import Round
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces import calibration
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ActionType, ConstraintType, ForceField, HalfSpaceRegion
from physagent_jax.forces.swinging import find_strokes
from physagent_jax.motion.schema import ExpectedMotion, Judgement, SceneBrief, Verdict
from physagent_jax.motion.tolerances import list_windows
from physagent_jax.motion.vectors import add, cross, scale
from physagent_jax.perception.schema import MotionReport, PartMotion
from tests.agents.scenes import judge, make_report, rewrite

STEPS = 20  # per frame
SHORTENING = 0.2  # of the length per M: a soft solid gives more than its linear strain
HELD = 0.16  # body lengths of a held object per M
GRAVITY = 8.0  # body lengths per clip^2
ZERO = (0.0, 0.0, 0.0)


class ToyWorld:
    """The motion report of a force field in a toy world.

    Attributes:
        gain: Factor on every response.
    """

    def __init__(self, scene: SceneBrief, gain: float = 1.0):
        self.scene, self.gain = scene, gain

    def simulate(self, field: ForceField, expectations: tuple[ExpectedMotion, ...]) -> MotionReport:
        """Simulate and report every expectation's window."""
        count = self.scene.frame_count
        places, angles, strains = self._integrate(field)
        seen = make_report(
            places,
            angles,
            [
                tuple(tuple(max(1.0 + e[i], 0.05) * (i == j) for j in range(3)) for i in range(3))
                for e in strains
            ],
            windows=list_windows(expectations, count),
        )
        sides = {a.region.normal for a in field.actions if isinstance(a.region, HalfSpaceRegion)}
        if len(sides) != 1:
            return seen
        side = sides.pop()
        return seen.model_copy(update={"parts": tuple(_drag_along(part, side) for part in seen.parts)})

    def _integrate(self, field: ForceField):
        """Per frame: place, angle vector [degrees], strain tensor's diagonal in world axes."""
        last = self.scene.frame_count - 1
        dt = 1.0 / last / STEPS
        place, speed, angle, turning = ZERO, ZERO, ZERO, ZERO
        places, angles, strains = [], [], []
        effects = self._list_effects(field, self._find_strokes(field))
        for step in range(last * STEPS + 1):
            push, torque, strain, drive, spin = _sum_effects(effects, max(step - 0.5, 0.0) / STEPS)
            if self.scene.anchored is not None:
                place, angle = scale(push, 0.5 * HELD * (step > 0)), scale(torque, 0.3 * (step > 0))
            if step % STEPS == 0:
                places.append(place)
                angles.append(angle)
                strains.append(scale(strain, step > 0))
            if self.scene.anchored is not None:
                continue
            gravity = scale(self.scene.directions.down, GRAVITY if field.default_drop else 0.0)
            speed = add([speed, scale(push, dt), scale(gravity, dt)])
            turning = add([turning, scale(torque, dt)])
            place = add([place, scale(add([speed, drive]), dt)])
            angle = add([angle, scale(add([turning, spin]), dt)])
        return places, angles, strains

    def _find_strokes(self, field: ForceField):
        """The velocity changes of pushes to and fro on a free object."""
        if self.scene.anchored is not None:
            return {}
        count = self.scene.frame_count
        scaling = make_closed_form_scaling(extent=1.0, youngs_modulus=1.0, density=1.0, duration=1.0)
        values = ForceFieldParameters.of(field, count).actions
        return find_strokes(field, values, scaling, 1.0 / (count - 1))

    def _list_effects(self, field: ForceField, strokes):
        """The effect of each action from its first frame until its last: (first, last, what, amount at a frame).

        Accelerations, angular accelerations [degrees], strain diagonals, prescribed velocities and spins [degrees].
        """
        count, effects = self.scene.frame_count, []
        for index, item in enumerate((*field.actions, *field.constraints)):
            first, last = item.active_time or (0, count - 1)
            stays = last if getattr(item, "bend", None) is None else count  # it is bent on from there
            effects.append((first, stays, *self._find_effect(item, first, last, strokes.get(index))))
        return effects

    def _find_effect(self, item, first: float, last: float, stroke):
        """The effect of one action: its name, and a function of the frame that gives its amount."""
        frames = self.scene.frame_count - 1
        effort = item.gain * item.magnitude
        vector = scale(item.vector, self.gain * effort)
        kind = getattr(item, "action_type", None) or item.constraint_type
        if kind is ActionType.TRANSLATION:
            return "push", _always(
                scale(vector, float(2.0 * calibration.TRAVEL if stroke is None else stroke.k))
            )
        if kind == "wind_gust":

            def blow(frame):
                share = 1.0 - math.cos(2.0 * math.pi * (frame - first) / (last - first))
                return scale(vector, 2.0 * calibration.TRAVEL * share)

            return "push", blow
        if kind in (ActionType.IMPULSE, ConstraintType.PARTICLE_IMPULSE):
            length = max(last - first, 1e-9)  # what has no length never acts
            return "push", _always(scale(vector, calibration.TRAVEL * frames / length))
        if kind is ActionType.TORQUE:
            return "torque", _always(scale(vector, 2.0 * math.degrees(calibration.TURN)))
        if kind is ActionType.SCALE:
            return "strain", _always(_make_diagonal(item.vector, SHORTENING * self.gain * effort))
        if getattr(item, "bend", None) is not None:
            # It bends over its height: its middle goes by 0.15 of that per radian.
            turn = calibration.TURN / calibration.HELD_TIME * effort * self.scene.frame_dt
            way = scale(cross(item.vector, self.scene.directions.up), 0.15 * turn / (0.5 * HELD))
            return "push", lambda frame: scale(way, min(frame, last) - first)
        if kind is ConstraintType.PARTICLE_ROTATION:
            return "spin", _always(scale(item.vector, math.degrees(calibration.TURN) * effort))
        if not isinstance(item.region, HalfSpaceRegion):
            return "drive", _always(scale(item.vector, calibration.PRESCRIBED_TRAVEL * effort))
        # one of two end slabs: prescribed, whatever the stiffness
        side = math.copysign(1.0, sum(v * n for v, n in zip(item.vector, item.region.normal)))
        reach = side * calibration.PRESCRIBED_TRAVEL * effort
        return "strain", lambda frame: _make_diagonal(item.vector, reach * (frame - first) / frames)


def _always(amount):
    return lambda frame: amount


def _sum_effects(effects, frame: float):
    """Acceleration, angular acceleration [degrees], strain diagonal, prescribed velocity and spin at a frame."""
    acting = {"push": [], "torque": [], "strain": [], "drive": [], "spin": []}
    for first, last, what, amount in effects:
        if first <= frame < last:
            acting[what].append(amount(frame))
    return (add(vectors) if vectors else ZERO for vectors in acting.values())


def _drag_along(part: PartMotion, side) -> PartMotion:
    """The lag of the far end in a motion that acts on the end towards ``side``."""
    share = {1: 1.0, 0: 0.6, -1: 0.3}[round(sum(a * b for a, b in zip(part.direction, side)))]
    return part.model_copy(
        update={
            "centroid": tuple(scale(p, share) for p in part.centroid),
            "rotation": tuple(scale(r, share) for r in part.rotation),
        }
    )


def _make_diagonal(axis, amount: float):
    return tuple(amount * c * c for c in axis)


def loop(
    field: ForceField,
    expectations: tuple[ExpectedMotion, ...],
    world: ToyWorld,
    iterations: int = 3,
    prompt: str = "",
) -> list[tuple[ForceField, Judgement]]:
    """The closed loop with the offline planner and executor: attempts until SUCCESS or the limit."""
    reading = SemanticReply(force_field=field, expectations=expectations)
    rounds: list[Round] = []
    for _ in range(iterations):
        rounds.append(judge(prompt, reading, world.simulate(field, expectations), world.scene, field))
        if rounds[-1].judgement.verdict is Verdict.SUCCESS:
            break
        rewritten = rewrite(prompt, reading, rounds[-1], world.scene, rounds[:-1])
        if rewritten.force_field == field:  # nothing left to try
            break
        field = rewritten.force_field
    return [(each.force_field, each.judgement) for each in rounds]
