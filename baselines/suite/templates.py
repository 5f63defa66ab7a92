"""Templates of tasks: a force field drawn at random, and what its motion is asked for in words and clauses.

The force field comes first, and the amounts are what it does, so that each task can be done. The clauses are those of
the published tasks of the same family (`benchmarks/tasks`), and so are their tolerances.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from baselines.task_files import record_target
from baselines.tasks import Task
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.measures import measure_clause
from physagent_jax.metrics.targets import Clause

Vector = tuple[float, float, float]
AXES: Mapping[str, Vector] = {
    "sideways": (1.0, 0.0, 0.0),
    "depth": (0.0, 1.0, 0.0),
    "vertical": (0.0, 0.0, 1.0),
}
_TO = {  # by axis: the way along it, and against it
    "sideways": ("to the right", "to the left"),
    "depth": ("away from us", "towards us"),
    "vertical": ("upwards", "downwards"),
}
_ROUND = {
    "sideways": (
        "about the line from left to right, its upper side towards us",
        "about the line from left to right, its upper side away from us",
    ),
    "depth": ("in the plane of the picture, clockwise", "in the plane of the picture, counter-clockwise"),
    "vertical": (
        "about the vertical, counter-clockwise seen from above",
        "about the vertical, clockwise seen from above",
    ),
}
_LENGTH = {"sideways": "wider", "depth": "deeper", "vertical": "taller"}
_SHORTENED = {"sideways": "narrower", "depth": "flatter from front to back", "vertical": "lower"}
_ADAPTER: TypeAdapter[Any] = TypeAdapter(Clause)


class Unfit(Exception):
    """Raised where a draw makes no task: its motion is too small, too large, or not what the words say."""


@dataclasses.dataclass(frozen=True)
class Cell:
    """A set of twins: all that is drawn within a cell is in one split.

    Attributes:
        family: Family of tasks.
        object: Object of `baselines.objects`.
        variant: An axis, or the kind of what is hidden.
    """

    family: str
    object: str
    variant: str

    @property
    def name(self) -> str:
        """Before a task's number; its hash decides the split."""
        return f"{self.family}-{self.object}-{self.variant}"


@dataclasses.dataclass(frozen=True)
class Draft:
    """A scene in which a force field acts, before anything is asked of it.

    Attributes:
        field: The force field.
        scene: Fields of `SceneOptions`.
        ask: From the task under way, and its true paths as a clip, to sentences that all say the same, and clauses.
        begin, hidden: Force fields of recovery tasks.
    """

    field: ForceField
    scene: Mapping[str, Any]
    ask: Callable[[Task, Clip], tuple[list[str], list[dict[str, Any]]]]
    begin: ForceField | None = None
    hidden: ForceField | None = None


def see(clip: Clip, **fields: Any) -> list[float]:
    """The numbers that a clause measures on a clip, whatever it asks for."""
    clause = _ADAPTER.validate_python({"target": 0.0, "tolerance": 1.0} | fields)
    return [float(measure.seen) for measure in measure_clause(clause, clip)]


def _clause(
    kind: str, window: tuple[int, int], target: float, widest: float, **fields: Any
) -> dict[str, Any]:
    """A clause with a tolerance of a third of its target, or ``widest``."""
    tolerance = min(widest, np.floor(1e4 * abs(target) / 3) / 1e4) if target else widest
    return {"kind": kind, "window": window, "target": target, "tolerance": float(tolerance), **fields}


def _still(
    window: tuple[int, int], axes: list[str], turns: list[str], widest: float = 25.0
) -> list[dict[str, Any]]:
    """Clauses against what nobody asked for: ways aside, and turns."""
    aside = [_clause("distance", window, 0.0, 0.1, along=AXES[axis], when="peak") for axis in axes]
    return aside + [_clause("turn", window, 0.0, widest, axis=AXES[axis], when="peak") for axis in turns]


def _within(value: float, low: float, high: float, digits: int) -> float:
    """A value as the sentence names it.

    Raises:
        Unfit: It is out of range.
    """
    if not low <= value <= high:
        raise Unfit
    return round(value, digits)


def _act(kind: ActionType, vector: np.ndarray, magnitude: float, window: tuple[int, int] | None) -> Action:
    x, y, z = (float(each) for each in vector)
    return Action(action_type=kind, vector=(x, y, z), magnitude=round(magnitude, 2), active_time=window)


def _sign(rng: np.random.Generator) -> int:
    return int(rng.choice((1, -1)))


def _others(axis: str) -> list[str]:
    return [each for each in AXES if each != axis]


def _draft_impulse(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign = _sign(rng)
    way = sign * np.array(AXES[axis])
    blow = _act(ActionType.IMPULSE, way, rng.uniform(0.45, 1.5), (0, 1))
    to, along = _TO[axis][sign < 0], tuple(way.tolist())

    def ask(task: Task, clip: Clip):
        far = _within(see(clip, kind="distance", window=(0, 25), along=along)[0], 0.15, 2.0, 2)
        clauses = [
            _clause("distance", (0, 6), round(far * 6 / 25, 4), 1.0, along=along),
            _clause("distance", (0, 25), far, 1.0, along=along),
            *_still((0, 25), _others(axis), list(AXES)),
        ]
        return [
            f"Hit {it} at once so that it flies evenly {to}, by {100 * far:.0f} % of its length in a second.",
            f"One blow sends {it} evenly {to}: {far:.2f} of its length within a second.",
            f"Struck once at the start, {it} moves evenly {to}, {100 * far:.0f} % of its length in one second.",
        ], clauses

    return Draft(ForceField(actions=(blow,)), dict(world="free"), ask)


def _draft_twist(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign = _sign(rng)
    way = sign * np.array(AXES[axis])
    turn = _act(ActionType.TORQUE, way, rng.uniform(0.4, 1.5), None)
    sense, about = _ROUND[axis][sign < 0], tuple(way.tolist())

    def ask(task: Task, clip: Clip):
        angle = _within(see(clip, kind="turn", window=(0, 25), axis=about)[0], 20.0, 150.0, 0)
        clauses = [
            _clause("turn", (0, 25), angle, 25.0, axis=about),
            {"kind": "distance", "window": (0, 25), "when": "peak", "target": 0.0, "tolerance": 0.1},
            *_still((0, 25), [], _others(axis), 20.0),
        ]
        return [
            f"Turn {it} by {angle:.0f} degrees {sense}.",
            f"Within a second {it} turns on the spot by {angle:.0f} degrees {sense}.",
            f"Rotate {it} {sense}, {angle:.0f} degrees in all.",
        ], clauses

    return Draft(ForceField(actions=(turn,)), dict(world="free"), ask)


def _draft_stretch(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign = _sign(rng)
    pull = _act(ActionType.SCALE, np.array(AXES[axis]), sign * rng.uniform(0.5, 1.5), None)

    def ask(task: Task, clip: Clip):
        early, late = (see(clip, kind="stretch", window=(0, end), along=AXES[axis])[0] for end in (9, 25))
        amount = _within(sign * late, 0.08, 0.6, 2)
        if abs(early - late) > amount / 6:  # it does not stay so
            raise Unfit
        clauses = [
            _clause("stretch", (0, 9), sign * amount, 1.0, along=AXES[axis]),
            _clause("stretch", (0, 25), sign * amount, 1.0, along=AXES[axis]),
            {"kind": "distance", "window": (0, 25), "when": "peak", "target": 0.0, "tolerance": 0.1},
        ]
        more = (_LENGTH if sign > 0 else _SHORTENED)[axis]
        verb = "Stretch" if sign > 0 else "Squeeze"
        share = f"{100 * amount:.0f} %"
        return [
            f"{verb} {it} until it is {share} {more}, within a third of a second, and keep it so.",
            f"Within a third of a second {it} becomes {share} {more}, and stays so.",
            f"{it[:1].upper()}{it[1:]} gets {share} {more} in a third of a second and keeps that shape.",
        ], clauses

    return Draft(ForceField(actions=(pull,)), dict(world="free"), ask)


def _draft_sway(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign = _sign(rng)
    way = sign * np.array(AXES[axis])
    blow = _act(ActionType.IMPULSE, way, rng.uniform(0.6, 1.5), (0, 2))
    to, line, top = _TO[axis][sign < 0], tuple(way.tolist()), (0.0, 0.0, 1.0)

    def ask(task: Task, clip: Clip):
        tolerances = dict(target=0.1, tolerance=0.03, frequency=1.0, frequency_tolerance=0.3)
        size, often = see(clip, kind="oscillation", window=(0, 32), part=top, along=line, **tolerances)
        size, often = _within(size, 0.05, 0.4, 2), _within(often, 0.7, 4.0, 1)
        quarter = max(2, round(0.25 / often / task.frame_dt))
        first = _within(
            see(clip, kind="distance", window=(0, quarter), part=top, along=line)[0], 0.05, 0.6, 2
        )
        clauses = [
            _clause("distance", (0, quarter), first, 1.0, part=top, along=line),
            _clause("oscillation", (0, 32), size, 1.0, part=top, along=line)
            | dict(frequency=often, frequency_tolerance=round(often / 3 - 5e-4, 3)),
            _clause("distance", (0, 32), 0.0, 0.07, part=top, along=AXES[_others(axis)[0]], when="peak"),
        ]
        told = f"first {to} by {100 * first:.0f} % of its length, then {100 * size:.0f} % to either side"
        return [
            f"Held at its foot, {it} sways, {told}, {often:.1f} times a second.",
            f"The foot of {it} is held; its upper end swings to and fro {often:.1f} times a second, {told}.",
        ], clauses

    return Draft(ForceField(actions=(blow,)), dict(world="free", anchor="base", frame_count=33), ask)


def _draft_drop(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign = _sign(rng)
    way = sign * np.array(AXES[axis])
    blow = _act(ActionType.IMPULSE, way, rng.uniform(0.4, 1.6), (0, 2))
    to, along, down = _TO[axis][sign < 0], tuple(way.tolist()), (0.0, 0.0, -1.0)

    def ask(task: Task, clip: Clip):
        far = _within(see(clip, kind="distance", window=(0, 8), along=along)[0], 0.1, 0.8, 2)
        clauses = [
            _clause("distance", (0, 6), 0.28, 0.093, along=down),
            _clause("distance", (0, 8), 0.5, 0.12, along=down),
            _clause("distance", (0, 8), far, 1.0, along=along),
            *_still((0, 8), [each for each in _others(axis) if each != "vertical"], []),
        ]
        share = f"{100 * far:.0f} % of its length"
        return [
            f"Drop {it} from half its length; as it reaches the ground it is {share} farther {to}.",
            f"{it[:1].upper()}{it[1:]} falls by half its length and lands {share} {to} of where it was let go.",
            f"Let {it} fall half its length and knock it {to} on the way, by {share} when it lands.",
        ], clauses

    return Draft(ForceField(default_drop=True, actions=(blow,)), {}, ask)


def _draft_multi(rng: np.random.Generator, axis: str, it: str) -> Draft:
    sign, sense = _sign(rng), _sign(rng)
    way, around = sign * np.array(AXES[axis]), str(rng.choice(list(AXES)))
    about = tuple((sense * np.array(AXES[around])).tolist())
    push = _act(ActionType.IMPULSE, way, rng.uniform(0.4, 1.4), (0, 1))
    turn = _act(ActionType.TORQUE, np.array(about), rng.uniform(0.8, 1.6), (19, 38))
    to, along, round_ = _TO[axis][sign < 0], tuple(way.tolist()), _ROUND[around][sense < 0]

    def ask(task: Task, clip: Clip):
        far = _within(see(clip, kind="distance", window=(0, 19), along=along)[0], 0.12, 1.2, 2)
        angle = _within(see(clip, kind="turn", window=(19, 38), axis=about)[0], 20.0, 120.0, 0)
        clauses = [
            _clause("distance", (0, 19), far, 1.0, along=along),
            _clause("turn", (0, 19), 0.0, 12.0, axis=about, when="peak"),
            _clause("turn", (19, 38), angle, 25.0, axis=about),
            *_still((0, 38), _others(axis), []),
        ]
        share = f"{100 * far:.0f} % of its length"
        return [
            f"Push {it} {to} by {share} in the first half of the clip without turning it; in the second half it turns "
            f"by {angle:.0f} degrees {round_}.",
            f"First {it} moves {to} by {share}, upright; then it turns by {angle:.0f} degrees {round_}.",
        ], clauses

    return Draft(ForceField(actions=(push, turn)), dict(world="free", frame_count=39), ask)


_HIDDEN = {
    "push": ("Push", ActionType.TRANSLATION, None, 0.015),
    "hit": ("Hit", ActionType.IMPULSE, (2, 4), 0.015),
    "spin": ("Spin", ActionType.TORQUE, None, 0.015),
}


def _draft_recovery(rng: np.random.Generator, kind: str, it: str) -> Draft:
    verb, skill, window, tolerance = _HIDDEN[kind]
    ways = [each / np.linalg.norm(each) for each in rng.normal(size=(2, 3))]
    hidden, begin = (
        ForceField(actions=(_act(skill, way, size, window),))
        for way, size in zip(ways, (rng.uniform(0.5, 1.5), 0.8))
    )

    def ask(task: Task, clip: Clip):
        target = record_target(task, hidden, tolerance)
        return [f"{verb} {it} as in the recording.", f"{verb} {it} so that it moves as it did before."], [
            clause.model_dump(mode="json") for clause in target.clauses
        ]

    return Draft(hidden, dict(world="free"), ask, begin, hidden)


DRAFTS: Mapping[str, Callable[[np.random.Generator, str, str], Draft]] = {
    "drop": _draft_drop,
    "stretch": _draft_stretch,
    "sway": _draft_sway,
    "twist": _draft_twist,
    "impulse": _draft_impulse,
    "multi": _draft_multi,
    "recovery": _draft_recovery,
}
_FREE, _LEVEL = ("jelly", "loaf", "robot"), ("sideways", "depth")
_PLACES: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "drop": (_FREE, _LEVEL),
    "sway": (("jelly", "loaf", "plant"), _LEVEL),
    "recovery": (_FREE, tuple(_HIDDEN)),
}
CELLS = tuple(
    Cell(family, thing, variant)
    for family in DRAFTS
    for thing in _PLACES.get(family, (_FREE, tuple(AXES)))[0]
    for variant in _PLACES.get(family, (_FREE, tuple(AXES)))[1]
)
"""All of them; objects are those that come with the package."""
