"""Scenes, readable descriptions of replies and synthetic motion reports for the agents' tests."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.rules.executor import RuleExecutor
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.rules.semantic import RuleSemanticAgent
from physagent_jax.agents.rules.tolerances import list_windows
from physagent_jax.agents.schema import DirectionTable, ExpectedMotion, Rewrite, SceneBrief, SemanticReply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import BoxRegion, ForceField
from physagent_jax.perception.schema import MotionReport, Quality, WindowMotion

Vector = tuple[float, float, float]
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
    return RuleSemanticAgent().compile(asked(prompt, scene or brief())).value


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
    """What the offline planner makes of a report on the reading's force field, or on another one."""
    observation = Observation(field or reading.force_field, seen, Unseen())
    reply = RulePlanner().judge(asked(prompt, scene, reading), observation)
    assert reply.trace.is_empty
    return Round(observation.force_field, seen, observation.key_frames, reply.value)


def rewrite(
    prompt: str, reading: SemanticReply, failed: Round, scene: SceneBrief, earlier: Iterable[Round] = ()
) -> Rewrite:
    """What the offline executor makes of a failed round."""
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


def window(first: int, last: int, **seen) -> WindowMotion:
    """A window in which nothing happens but what is given."""
    still = {
        "displacement": (0, 0, 0), "path_length": 0.0, "peak_displacement": (0, 0, 0), "peak_frame": first,
        "rotation_axis": None, "rotation_degrees": 0.0, "stretch": IDENTITY, "volume_ratio": 1.0,
        "stretch_view_axis_observable": True,
    }  # fmt: skip
    if "displacement" in seen and "peak_displacement" not in seen:
        seen["peak_displacement"] = seen["displacement"]
    return WindowMotion(first=first, last=last, **(still | seen))


def report(
    windows: list[WindowMotion], frame_count: int = 49, centroid=None, leaves_frame: int | None = None
) -> MotionReport:
    """A report of the given windows; the first is repeated as the whole clip unless it is that already."""
    return MotionReport(
        frame_count=frame_count, frame_dt=0.04, object_size=1.0, object_center=(0, 0, 0), windows=tuple(windows),
        centroid=tuple(centroid or [(0, 0, 0)] * frame_count), rotation_degrees=(0.0,) * frame_count,
        volume_ratio=(1.0,) * frame_count, oscillation=None, onset_frame=None, settle_frame=None,
        quality=Quality(
            tracks_kept=1.0, fit_residual=0.0, depth_noise=0.0, mask_fraction=0.2, leaves_frame=leaves_frame
        ),
        text="",
    )  # fmt: skip


def seen_in(expectations: tuple[ExpectedMotion, ...], frame_count: int = 49, **seen) -> MotionReport:
    """The same motion in every expectation's window and in the whole clip."""
    spans = [(0, frame_count - 1), *list_windows(expectations, frame_count)]
    return report([window(*span, **seen) for span in dict.fromkeys(spans)], frame_count)
