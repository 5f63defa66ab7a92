"""Motion reports judged by the rules and by models.

The clips, their sentences and labels are those of `benchmarks.verdicts`. Every judge gets the same report; models get
its text alone, no pictures. The sentence is read by the grammar; one that it refuses is a FAIL without a question.
"""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from benchmarks.chat_models import Asked
from benchmarks.harness import Job, Row, Rows, number, table
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.judging import Sight, look, make_brief
from benchmarks.verdicts.work import do
from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.llm.planner import judge_with_model
from physagent_jax.agents.llm.structured import BadAnswers
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.trace import Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills
from physagent_jax.motion.schema import Verdict

PART = "judging"
CHUNK = 4  # clips of a job


@dataclasses.dataclass(frozen=True)
class Source:
    """The clips that are judged.

    Attributes:
        sight: Source of the reports: the true trajectories, or what perception sees in pictures.
        clips: Folder where clips and reports are kept; those that are missing are made.
        data: Folder of captured objects; None: none of them is needed.
    """

    sight: Sight
    clips: Path
    data: Path | None


class NoPictures:
    """Key frames of a report that is judged from its text."""

    def pick(self, most: int = 6) -> tuple:
        """None."""
        del most
        return ()


def list_jobs(source: Source, models: Iterable[Asked], sample: int, seed: int) -> list[Job]:
    """A job for every few clips, with all judges in it; ``sample`` clips are drawn by the seed."""
    clips = sorted(list_clips(source.data, False), key=lambda clip: clip.name)
    random.Random(seed).shuffle(clips)
    clips, judges = clips[:sample], tuple(models)
    return [
        Job(f"clips {start + 1}-{start + len(chunk)}", partial(_judge_all, source, chunk, judges))
        for start, chunk in ((at, clips[at : at + CHUNK]) for at in range(0, len(clips), CHUNK))
    ]


def _judge_all(source: Source, clips: list[Clip], models: tuple[Asked, ...]) -> list[Row]:
    return [row for clip in clips for row in judge_clip(source, clip, models)]


def judge_clip(source: Source, clip: Clip, models: tuple[Asked, ...]) -> list[Row]:
    """A row for each judge of a clip; none if it does not move as it is labelled."""
    checked = do("clips", clip, folder=source.clips, data=source.data, made=False)
    if checked is None or checked["untrue"]:
        return []
    agents = make_agents()
    context = AgentContext(clip.sentence, make_brief(clip), describe_skills())
    try:
        reading = agents.semantic.compile(context).value
    except UserError:
        return [_make_row(clip, name, "FAIL") for name in ("rules", *(model.name for model in models))]
    context = dataclasses.replace(context, reading=reading)
    windows = tuple(agents.planner.windows(context))
    report = look(clip, source.sight, windows, source.clips, source.data)
    seen = Observation(reading.force_field, report, NoPictures())
    rules = agents.planner.judge(context, seen).value.verdict.value
    rows = [_make_row(clip, "rules", rules)]
    for model in models:
        verdict, trace = _ask(model, context, seen)
        agreed = "SUCCESS" if (verdict, rules) == ("SUCCESS", "SUCCESS") else "FAIL"
        cost = {
            "seconds": round(trace.latency_seconds, 3),
            "input_tokens": trace.input_tokens,
            "output_tokens": trace.output_tokens,
            "unusable": verdict is None,
        }
        rows.append(_make_row(clip, model.name, verdict or "FAIL") | cost)
        rows.append(_make_row(clip, f"rules and {model.name}", rules if verdict is None else agreed) | cost)
    return rows


def _ask(asked: Asked, context: AgentContext, seen: Observation) -> tuple[str | None, Trace]:
    """The model's verdict; None if no answer of it fits."""
    try:
        answer = judge_with_model(asked.open(), context, seen)
    except BadAnswers as error:  # from a server that is away, nothing was measured
        return None, error.trace
    return Verdict(answer.value.verdict).value, answer.trace


def _make_row(clip: Clip, judge: str, verdict: str) -> Row:
    label = "SUCCESS" if clip.wrong is None else "FAIL"
    return {"judge": judge, "clip": clip.name, "half": clip.half, "label": label, "verdict": verdict}


def condense_judging(rows: Rows) -> Rows:
    """Counts of verdicts by judge."""
    judges: dict[str, Rows] = {}
    for row in rows:
        judges.setdefault(row["judge"], []).append(row)
    return [
        {
            "judge": judge,
            "wrong clips": sum(row["label"] == "FAIL" for row in mine),
            "false SUCCESS": sum((row["label"], row["verdict"]) == ("FAIL", "SUCCESS") for row in mine),
            "right clips": sum(row["label"] == "SUCCESS" for row in mine),
            "false FAIL": sum((row["label"], row["verdict"]) == ("SUCCESS", "FAIL") for row in mine),
            "unusable": sum(row.get("unusable", False) for row in mine),
            **{
                name: round(sum(row.get(name, 0) for row in mine) / len(mine), 3)
                for name in ("seconds", "input_tokens", "output_tokens")
            },
        }
        for judge, mine in judges.items()
    ]


def write_judging(counts: Rows) -> str:
    """The table of judges: false verdicts, and the cost of a clip."""
    names = ("wrong clips", "false SUCCESS", "right clips", "false FAIL", "unusable")
    rows = [
        [row["judge"], *(row[name] for name in names)]
        + [number(row[name]) for name in ("seconds", "input_tokens", "output_tokens")]
        for row in counts
    ]
    return table(["judge", *names, "s", "tokens in", "tokens out"], rows)
