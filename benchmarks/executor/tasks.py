"""Sentences, what they ask for, a force field that means it, all written without the parser; and ways to go wrong."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.motion.vectors import add, cross, scale

FRAMES = 50
LAST = float(FRAMES - 1)
HALF = float(FRAMES // 2)


@dataclasses.dataclass(frozen=True)
class Task:
    """A sentence about an object.

    Attributes:
        name: Unique.
        object: Name of an object of `benchmarks.executor.scenes`.
        sentence: What is asked for.
        expectations: The same for the judge; directions are the names of `DirectionTable`.
        actions: A force field that means it: type, direction's name, magnitude, first and last frame.
        drop: Whether it lets the object fall.
        world: "free" or "ground".
        faults: Names of `FAULTS`: the wrong force fields that are started from.
    """

    name: str
    object: str
    sentence: str
    expectations: tuple[dict, ...]
    actions: tuple[tuple[str, str, float, float, float], ...]
    faults: tuple[str, ...]
    drop: bool = False
    world: str = "free"

    def expect(self, brief: SceneBrief) -> tuple[ExpectedMotion, ...]:
        """Motions that the sentence asks for, in the scene's directions."""
        table = brief.directions
        whole = {"window": (0.0, LAST), "words": self.sentence}
        return tuple(
            ExpectedMotion.model_validate(
                whole | e | ({"direction": getattr(table, e["direction"])} if "direction" in e else {})
            )
            for e in self.expectations
        )

    def mean(self, brief: SceneBrief) -> ForceField:
        """A force field that means the sentence, in the scene's directions."""
        return ForceField(
            default_drop=self.drop,
            actions=tuple(
                Action(
                    action_type=ActionType(kind),
                    vector=getattr(brief.directions, way),
                    magnitude=magnitude,
                    active_time=(first, last),
                )
                for kind, way, magnitude, first, last in self.actions
            ),
        )


_PUSHED = (
    "sign",
    "60 degrees",
    "90 degrees",
    "half",
    "minimum",
    "maximum",
    "type",
    "late",
    "missing",
    "extra",
)
_HIT = ("sign", "90 degrees", "minimum", "maximum", "type", "late")
_DEFORMED = ("sign", "half", "minimum", "maximum", "type", "late", "missing", "extra")

TASKS = (
    Task(
        "push", "robot", "push the robot to the left",
        ({"kind": "move", "direction": "left"},), (("translation", "left", 1.0, 0, 40),), _PUSHED,
    ),
    Task(
        "gentle push", "loaf", "push the loaf gently away",
        ({"kind": "move", "direction": "away", "strength": 0.4},), (("translation", "away", 0.4, 0, 32),),
        ("60 degrees", "double", "maximum", "extra"),
    ),
    Task(
        "hit", "robot", "hit the robot from the left",
        ({"kind": "move", "direction": "right", "sudden": True},), (("impulse", "right", 0.8, 0, 1),), _HIT,
    ),
    Task(
        "spin", "loaf", "spin the loaf about the vertical axis",
        ({"kind": "rotate", "direction": "up"},), (("torque", "up", 1.0, 0, 45),),
        ("sign", "90 degrees", "half", "maximum", "type", "late", "missing", "extra"),
    ),
    Task(
        "stretch", "jelly", "stretch the jelly sideways",
        ({"kind": "stretch", "direction": "right"},), (("scale", "right", 1.2, 0, LAST),), _DEFORMED,
    ),
    Task(
        "squeeze", "jelly", "squeeze the jelly from both sides",
        ({"kind": "squeeze", "direction": "right"},), (("scale", "right", -1.0, 0, LAST),),
        ("sign", "minimum", "type", "missing"),
    ),
    Task(
        "bend", "plant", "a wind bends the plant to the left",
        ({"kind": "move", "direction": "left"},), (("translation", "left", 1.0, 0, LAST),),
        ("sign", "90 degrees", "minimum", "maximum", "type", "missing"),
    ),
    Task(
        "drop", "jelly", "drop the jelly", ({"kind": "fall"},), (), ("no gravity", "pushed down", "extra"), drop=True
    ),
    Task(
        "two steps", "robot", "push the robot to the left, then spin it",
        (
            {"kind": "move", "direction": "left", "window": (0.0, HALF)},
            {"kind": "rotate", "direction": "up", "window": (HALF, LAST)},
        ),
        (("translation", "left", 1.4, 0, HALF), ("torque", "up", 1.6, HALF, LAST)),
        ("order", "sign", "minimum", "first missing", "second missing", "late"),
    ),
    Task(
        "grounded push", "robot", "push the robot to the right",
        ({"kind": "move", "direction": "right"},), (("translation", "right", 1.4, 0, 40),),
        ("sign", "90 degrees", "minimum", "maximum", "type"), world="ground",
    ),
    Task(
        "push over the ground", "loaf", "push the loaf to the right",
        ({"kind": "move", "direction": "right"},), (("translation", "right", 1.4, 0, 40),),
        ("sign", "90 degrees", "minimum", "maximum", "type"), world="ground",
    ),
    Task(
        "push towards us", "jelly", "push the jelly towards us",
        ({"kind": "move", "direction": "toward"},), (("translation", "toward", 1.0, 0, 40),),
        ("sign", "90 degrees", "60 degrees", "type", "missing"),
    ),
    Task(
        "clockwise", "robot", "spin the robot clockwise, seen from above",
        ({"kind": "rotate", "direction": "down"},), (("torque", "down", 1.0, 0, 45),),
        ("sign", "90 degrees", "type", "missing"),
    ),
)  # fmt: skip

Fault = Callable[[ForceField, SceneBrief], ForceField]


def _change_each(change: Callable[[Action], Action]) -> Fault:
    return lambda field, brief: field.model_copy(update={"actions": tuple(map(change, field.actions))})


def _scale_magnitudes(factor: float) -> Fault:
    def change(action: Action) -> Action:
        size = min(max(abs(action.magnitude) * factor, MAGNITUDE_MIN), MAGNITUDE_MAX)
        return action.model_copy(update={"magnitude": math.copysign(size, action.magnitude)})

    return _change_each(change)


def _turn_vectors(degrees: float) -> Fault:
    """Vectors turned about the line of sight; those along it, about the vertical."""

    def fault(field: ForceField, brief: SceneBrief) -> ForceField:
        def change(action: Action) -> Action:
            table = brief.directions
            along = abs(sum(a * b for a, b in zip(action.vector, table.toward))) > 0.7
            return action.model_copy(
                update={"vector": rotate(action.vector, table.up if along else table.toward, degrees)}
            )

        return _change_each(change)(field, brief)

    return fault


def rotate(vector: Vector, axis: Vector, degrees: float) -> Vector:
    """A vector across ``axis`` turned about it."""
    angle = math.radians(degrees)
    return add([scale(vector, math.cos(angle)), scale(cross(axis, vector), math.sin(angle))])


_OTHER = {
    ActionType.TRANSLATION: ActionType.TORQUE,
    ActionType.IMPULSE: ActionType.SCALE,
    ActionType.TORQUE: ActionType.TRANSLATION,
    ActionType.SCALE: ActionType.TRANSLATION,
}


def _mistake(action: Action) -> Action:
    """The action as a skill of another kind; a push in place of what turns or deforms, unless the table says."""
    turned = ActionType.TORQUE if "move" in get_skill(action).causes else ActionType.TRANSLATION
    return action.model_copy(update={"action_type": _OTHER.get(action.action_type, turned)})


def _delay_last(field: ForceField, brief: SceneBrief) -> ForceField:
    del brief
    window = (LAST - 8.0, LAST)
    last = field.actions[-1].model_copy(update={"active_time": window})
    return field.model_copy(update={"actions": (*field.actions[:-1], last)})


def _add_action(field: ForceField, brief: SceneBrief) -> ForceField:
    kinds = {action.action_type for action in field.actions}
    spin = Action(action_type=ActionType.TORQUE, vector=brief.directions.up, magnitude=1.4)
    push = Action(action_type=ActionType.TRANSLATION, vector=brief.directions.right, magnitude=1.4)
    return field.model_copy(
        update={"actions": (*field.actions, push if ActionType.TORQUE in kinds else spin)}
    )


def _swap_windows(field: ForceField, brief: SceneBrief) -> ForceField:
    del brief
    windows = [action.active_time for action in reversed(field.actions)]
    moved = (a.model_copy(update={"active_time": w}) for a, w in zip(field.actions, windows))
    return field.model_copy(update={"actions": tuple(moved)})


def _push_down(field: ForceField, brief: SceneBrief) -> ForceField:
    down = Action(action_type=ActionType.TRANSLATION, vector=brief.directions.down, magnitude=1.6)
    return field.model_copy(update={"default_drop": False, "actions": (down,)})


FAULTS: dict[str, Fault] = {
    "sign": _change_each(lambda a: a.model_copy(update={"magnitude": -a.magnitude})),
    "60 degrees": _turn_vectors(60.0),
    "90 degrees": _turn_vectors(90.0),
    "half": _scale_magnitudes(0.5),
    "double": _scale_magnitudes(2.0),
    "minimum": _scale_magnitudes(0.0),
    "maximum": _scale_magnitudes(10.0),
    "type": _change_each(_mistake),
    "late": _delay_last,
    "missing": lambda field, brief: ForceField(),
    "first missing": lambda field, brief: field.model_copy(update={"actions": field.actions[1:]}),
    "second missing": lambda field, brief: field.model_copy(update={"actions": field.actions[:1]}),
    "extra": _add_action,
    "order": _swap_windows,
    "no gravity": lambda field, brief: ForceField(),
    "pushed down": _push_down,
}
