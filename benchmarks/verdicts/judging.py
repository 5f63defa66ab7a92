"""Judgements of the product on a clip: the sentence read, the motion perceived or known, and the verdict."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal

from benchmarks.harness import Row
from benchmarks.verdicts import backgrounds
from benchmarks.verdicts.backgrounds import compose
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.recording import find_file, record
from benchmarks.verdicts.scenes import FRAME_DT
from benchmarks.verdicts.things import THINGS
from physagent_jax import metrics, perception
from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.forces.description import describe_skills
from physagent_jax.metrics import report_true_motion
from physagent_jax.motion.schema import DirectionTable, ExpectedMotion, Judgement, SceneBrief
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.schema import MotionReport
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import CameraConfig

Sight = Literal["truth", "pictures"]
HELD = "its foot is held"


class _NoFrames:
    """The offline planner looks at the report alone."""

    def pick(self, most: int = 6) -> tuple:
        del most
        return ()


def judge(clip: Clip, sight: Sight, clips: Path, data: Path | None) -> Row:
    """The verdict on a clip, and what led to it.

    Args:
        clip: Which.
        sight: "truth": the true trajectories stand for perception; "pictures": perception looks at pictures and depth.
        clips: Folder of clips.
        data: Folder of captured objects and a photo.
    """
    context = AgentContext(clip.sentence, make_brief(clip), describe_skills())
    agents, row = make_agents(), describe(clip)
    try:
        reply = agents.semantic.compile(context).value
    except UserError as error:
        return row | _verdict(clip, "FAIL") | {"refused": error.what}
    context = AgentContext(clip.sentence, context.brief, context.skills, reply)
    windows = tuple(agents.planner.windows(context))
    report = look(clip, sight, windows, clips, data)
    observation = Observation(reply.force_field, report, _NoFrames())
    judgement = agents.planner.judge(context, observation).value
    row |= _verdict(clip, judgement.verdict.value) | {"score": judgement.score}
    if not row["right"]:
        row |= {"read": _describe_reading(reply), "seen": _describe_report(report)}
    return row | {"failed": _describe_failures(judgement)}


def describe(clip: Clip) -> Row:
    """Fields of a row about its clip."""
    return {
        "clip": clip.name,
        "object": clip.thing,
        "sentence": clip.sentence,
        "motion": clip.motion.words,
        "wrong": clip.wrong,
        "label": "SUCCESS" if clip.wrong is None else "FAIL",
        "world": clip.world,
        "background": clip.background,
        "half": clip.half,
    }


def make_brief(clip: Clip) -> SceneBrief:
    """Scene that agents who read the sentence are told of."""
    thing = THINGS[clip.thing]
    camera = CameraConfig(azimuth_degrees=thing.azimuth)
    return SceneBrief(
        object_name=thing.noun,
        object_kind=thing.kind,
        anchored=(thing.rooted or HELD) if clip.held else None,
        frame_count=round(clip.motion.seconds / FRAME_DT),
        frames_fixed=True,
        frame_dt=FRAME_DT,
        size=1.0,
        world=clip.world,
        directions=DirectionTable(**find_viewer_directions(camera)),
    )


def _verdict(clip: Clip, verdict: str) -> Row:
    return {"verdict": verdict, "right": (verdict == "SUCCESS") == (clip.wrong is None)}


def look(
    clip: Clip, sight: Sight, windows: Sequence[tuple[int, int]], clips: Path, data: Path | None
) -> MotionReport:
    """The motion report of a clip, from the folder if it is there.

    Args:
        clip: The clip.
        sight: As for `judge`.
        windows: Frames that it should tell apart.
        clips: Folder of clips.
        data: Folder of captured objects and a photo.
    """
    words = [
        find_file(clip.thing, clip.motion, clips, data).stem,
        sight,
        repr(windows),
        hash_sight(sight, data),
    ]
    words += [clip.background] if sight == "pictures" else []
    file = clips / "reports" / f"{hashlib.sha256(' '.join(words).encode()).hexdigest()[:16]}.json"
    if file.is_file():
        return MotionReport.model_validate_json(file.read_text())
    held = record(clip.thing, clip.motion, clips, data)
    if sight == "truth":
        report = report_true_motion(held.particles, frame_dt=FRAME_DT, camera=held.camera, windows=windows)
    else:
        rgb, depth = compose(held, clip.background, data)
        report = perceive(rgb, depth, held.camera, frame_dt=FRAME_DT, windows=windows).report
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, report.model_dump_json())
    return report


@cache
def hash_sight(sight: Sight, data: Path | None) -> str:
    """Of the sources of what makes a report: reports of other sources are not used."""
    packages = (perception, metrics) if sight == "truth" else (perception,)
    sources = [path for package in packages for path in Path(package.__path__[0]).rglob("*.py")]
    text = b"".join(source.read_bytes() for source in sorted(sources))
    if sight == "pictures":
        photo = data is not None and (data / backgrounds.PHOTO).is_file()
        text += Path(backgrounds.__file__).read_bytes() + bytes([photo])
    return hashlib.sha256(text).hexdigest()


def _describe_reading(reply: SemanticReply) -> list[str]:
    """Expectations of the sentence, a line each, and words that were not understood."""
    lines = [_describe_motion(motion) for motion in reply.expectations]
    return [*lines, *(f"unsure: {text}" for text in reply.unsure)]


def _describe_motion(motion: ExpectedMotion) -> str:
    text = motion.kind.value
    if motion.direction is not None:
        text += " ({:+.2f} {:+.2f} {:+.2f})".format(*motion.direction)
    text += f" x {motion.strength:g}, frames {motion.window[0]:.0f}-{motion.window[1]:.0f}"
    if motion.repeats != 1:
        text += f", {motion.repeats} times"
    if motion.amount is not None:
        text += f", {motion.amount.value:g} {motion.amount.unit}"
    flags = ("released", "sudden", "partial", "excludes_part", "stays")
    return ", ".join([text, *(flag for flag in flags if getattr(motion, flag))])


def _describe_report(report: MotionReport) -> str:
    """The motion at the clip's end in a line."""
    whole = report.windows[0]
    shift = (
        "not seen"
        if whole.displacement is None
        else "({:+.2f} {:+.2f} {:+.2f}) L".format(*whole.displacement)
    )
    turn = "not seen" if whole.rotation_degrees is None else f"{whole.rotation_degrees:.0f} deg"
    if whole.rotation_axis is not None:
        turn += " about ({:+.1f} {:+.1f} {:+.1f})".format(*whole.rotation_axis)
    diagonal = "not seen"
    if whole.stretch is not None:
        diagonal = " ".join(f"{whole.stretch[i][i]:.2f}" for i in range(3))
    pieces = max((count for count in report.pieces if count is not None), default=None)
    leaves = report.quality.leaves_frame
    return f"shift {shift}, turn {turn}, stretch {diagonal}, pieces {pieces}, leaves {leaves}"


def _describe_failures(judgement: Judgement) -> list[str]:
    """Checks that did not pass."""
    return [
        f"{check.question} expected {check.expected}, observed {check.observed}"
        + (" (not observable)" if check.passed is None else "")
        for check in judgement.checks
        if check.passed is not True
    ]
