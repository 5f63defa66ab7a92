"""Scenes, readable descriptions of replies and synthetic motion reports for the agents' tests."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.grammar.semantic import read_sentence
from physagent_jax.agents.rules.executor import RuleExecutor
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import BoxRegion, ForceField
from physagent_jax.motion.schema import DirectionTable, ExpectedMotion, SceneBrief
from physagent_jax.motion.tolerances import list_windows
from physagent_jax.perception.schema import (
    Box,
    Matrix,
    MotionReport,
    PartMotion,
    Quality,
    Uncertainty,
    WindowMotion,
)

Vector = tuple[float, float, float]
ZERO = (0.0, 0.0, 0.0)
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def table(degrees: float = 0.0) -> DirectionTable:
    """Directions of a camera turned about the vertical; at 0 the viewer looks along +y."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return DirectionTable(
        right=(c, s, 0), left=(-c, -s, 0), up=(0, 0, 1), down=(0, 0, -1), toward=(s, -c, 0), away=(-s, c, 0)
    )


def brief(**changes) -> SceneBrief:
    """A free robot in a clip of 49 frames (last index 48)."""
    values = {
        "object_name": "robot",
        "frame_count": 49,
        "frame_dt": 0.04,
        "frames_fixed": True,
        "directions": table(),
    } | changes
    return SceneBrief(**values)


def read(prompt: str, scene: SceneBrief | None = None) -> SemanticReply:
    """The reading in the four skills, before the kind of each is chosen."""
    return read_sentence(prompt, scene or brief())


class Unseen:
    """Pictures that nobody may ask for."""

    def pick(self, most: int = 6):
        raise AssertionError("rules look at no pictures")


def asked(
    prompt: str, scene: SceneBrief, reading: SemanticReply | None = None, rounds: Iterable[Round] = ()
) -> AgentContext:
    return AgentContext(prompt, scene, describe_skills(), reading, tuple(rounds))


def judge(
    prompt: str,
    reading: SemanticReply,
    seen: MotionReport,
    scene: SceneBrief,
    field: ForceField | None = None,
) -> Round:
    """Judge a report on the reading's force field, or on another one, with the offline planner."""
    observation = Observation(field or reading.force_field, seen, Unseen())
    reply = RulePlanner().judge(asked(prompt, scene, reading), observation)
    assert reply.trace.is_empty
    return Round(observation.force_field, seen, observation.key_frames, reply.value)


def rewrite(
    prompt: str, reading: SemanticReply, failed: Round, scene: SceneBrief, earlier: Iterable[Round] = ()
) -> Rewrite:
    """Rewrite the force field of a failed round with the offline executor."""
    reply = RuleExecutor().rewrite(asked(prompt, scene, reading, earlier), failed)
    assert reply.trace.is_empty
    return reply.value


def named(vector: Vector | None, directions: DirectionTable) -> str:
    """The vector in the viewer's words: "left", "left+up"; digits if it is no such sum."""
    if vector is None:
        return "all"
    lines = (("left", "right"), ("up", "down"), ("toward", "away"))
    for choice in itertools.product(*[("", *line) for line in lines]):
        names = [name for name in choice if name]
        total = [sum(getattr(directions, name)[i] for name in names) for i in range(3)]
        length = math.hypot(*total)
        if names and math.dist([c / length for c in total], vector) < 1e-6:
            return "+".join(names)
    return str(vector)


def described(reply: SemanticReply, scene: SceneBrief) -> tuple[str, str]:
    """Actions and expectations as two lines of text."""
    field, directions = reply.force_field, scene.directions
    parts = ["drop"] if field.default_drop else []
    for action in field.actions:
        region = ""
        if isinstance(action.region, BoxRegion):
            region = " on middle"
        elif action.region is not None:
            region = f" on {named(action.region.normal, directions)}"
        first, last = action.active_time or (0, 0)
        name = named(action.vector, directions)
        parts.append(f"{action.action_type.value} {name} {action.magnitude:+g} {first:g}-{last:g}{region}")
    parts += [f"anchor {reply.anchor.kind}"] if reply.anchor.kind else []
    seen = []
    for e in reply.expectations:
        repeats = f" x{e.repeats}" if e.repeats > 1 else ""
        direction = "" if e.direction is None else f" {named(e.direction, directions)}"
        seen.append(f"{e.kind.value}{direction}{repeats}{' released' if e.released else ''}")
    return "; ".join(parts), "; ".join(seen)


def make_report(
    places: Sequence[Vector | None],
    turns: Sequence[Vector] | None = None,
    stretches: Sequence[Matrix] | None = None,
    *,
    windows: Iterable[tuple[int, int]] = (),
    view_axis_shown: bool = True,
    leaves_frame: int | None = None,
    unobservable: dict[str, str] | None = None,
    frame_dt: float = 0.04,
    **changes,
) -> MotionReport:
    """A report of a body that moves, turns (rotation vectors [deg]) and stretches as told, frame by frame.

    Its ends sit half a body length from its centre along each axis and go with it.
    """
    count = len(places)
    turns = turns or [ZERO] * count
    stretches = stretches or [IDENTITY] * count
    volumes = tuple(np.linalg.det(np.asarray(stretches, float)).tolist())
    turned = Rotation.from_rotvec(np.radians(turns))
    ends = []
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        arm = 0.3 * axis
        shifts = turned.apply(np.asarray(stretches, float) @ arm) - arm
        moved = [None if p is None else tuple((s + p).tolist()) for p, s in zip(places, shifts)]
        ends.append(PartMotion(direction=tuple(axis.tolist()), centroid=tuple(moved), rotation=tuple(turns)))
    half = 0.5 * np.array([0.6, 0.6, 1.0])
    boxes = [
        None if p is None else Box(low=tuple(p - np.diag(S) * half), high=tuple(p + np.diag(S) * half))
        for p, S in zip(places, np.asarray(stretches))
    ]
    spans = dict.fromkeys([(0, count - 1), *windows])
    values = {
        "frame_count": count, "frame_dt": frame_dt, "object_size": 1.0, "object_center": ZERO,
        "windows": tuple(
            _measure(a, b, places, turns, stretches, view_axis_shown, unobservable or {}) for a, b in spans
        ),
        "centroid": tuple(places), "rotation_degrees": tuple(float(np.linalg.norm(r)) for r in turns),
        "volume_ratio": volumes, "rotation": tuple(turns), "stretch": tuple(stretches), "box": tuple(boxes),
        "parts": tuple(ends), "pieces": (1,) * count,
        "uncertainty": Uncertainty(displacement=0.0, rotation=0.0, axis=0.0, stretch=0.0, frequency=0.0),
        "oscillation": None, "onset_frame": None, "settle_frame": None, "text": "",
        "quality": Quality(
            tracks_kept=1.0, fit_residual=0.0, depth_noise=0.0, mask_fraction=0.2, leaves_frame=leaves_frame
        ),
    } | changes  # fmt: skip
    return MotionReport(**values)


def _measure(a, b, places, turns, stretches, view_axis_shown, unobservable) -> WindowMotion:
    """A window's own motion."""
    known = [p is not None for p in places[a : b + 1]]
    moved = peak = None
    if known[0] and known[-1]:
        moved = tuple(np.subtract(places[b], places[a]).tolist())
        away = [np.subtract(p, places[a]) for p in places[a : b + 1] if p is not None]
        peak = tuple(max(away, key=np.linalg.norm).tolist())
    turn = np.subtract(turns[b], turns[a])
    angle = float(np.linalg.norm(turn))
    S = np.asarray(stretches[b]) @ np.linalg.inv(stretches[a])
    return WindowMotion(
        first=a, last=b, displacement=moved, path_length=None, peak_displacement=peak, peak_frame=None,
        rotation_axis=tuple((turn / angle).tolist()) if angle > 1e-9 else None, rotation_degrees=angle,
        stretch=tuple(tuple(row) for row in (0.5 * (S + S.T)).tolist()),
        stretch_view_axis_observable=view_axis_shown, volume_ratio=float(np.linalg.det(S)),
        unobservable=unobservable,
    )  # fmt: skip


def ramp(frame: float, first: float, last: float) -> float:
    """Speeding up and slowing down from 0 at ``first`` to 1 at ``last``."""
    share = min(max((frame - first) / max(last - first, 1e-9), 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def seen_in(
    expectations: tuple[ExpectedMotion, ...],
    frame_count: int = 49,
    *,
    displacement: Vector | None = ZERO,
    turn: Vector = ZERO,
    stretch: Matrix = IDENTITY,
    at_once: bool = False,
    **options,
) -> MotionReport:
    """A report in which the same happens in every expectation's window, one after another.

    Args:
        expectations: Their windows; the whole clip without any.
        frame_count: Frames.
        displacement: In each window; None = not observable after frame 0.
        turn: Rotation vector in each [deg].
        stretch: Stretch tensor reached in each.
        at_once: Whether it starts with its full speed, as after a blow.
        options: Options of `make_report`.
    """
    spans = list_windows(expectations, frame_count) or [(0, frame_count - 1)]

    def share(t: float, a: int, b: int) -> float:
        return min(max((t - a) / (b - a), 0.0), 1.0) if at_once else ramp(t, a, b)

    shares = [sum(share(t, a, b) for a, b in spans) for t in range(frame_count)]
    places = [
        None if displacement is None and t else _scale(displacement or ZERO, s) for t, s in enumerate(shares)
    ]
    inside = [max(share(t, a, b) for a, b in spans) for t in range(frame_count)]
    stretches = [
        tuple(map(tuple, (np.eye(3) + s * (np.asarray(stretch) - np.eye(3))).tolist())) for s in inside
    ]
    return make_report(places, [_scale(turn, s) for s in shares], stretches, windows=spans, **options)


def _scale(v: Vector, factor: float) -> Vector:
    return (v[0] * factor, v[1] * factor, v[2] * factor)


def without_series(report: MotionReport) -> MotionReport:
    """The same report as perception without series per frame leaves it."""
    return report.model_copy(update={"rotation": (), "stretch": (), "box": (), "parts": (), "pieces": ()})
