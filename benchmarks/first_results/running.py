"""One sentence through the command line, in a process of its own, and what came of it as a row."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks import harness
from benchmarks.first_results.cases import Case
from benchmarks.first_results.viewing import hash_video
from benchmarks.harness import Row
from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.registry import make_agents
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.metrics import report_true_motion
from physagent_jax.metrics.motion import compare
from physagent_jax.motion.schema import Judgement
from physagent_jax.run.brief import make_brief
from physagent_jax.run.finished import FinishedRun, open_run
from physagent_jax.run.key_frames import VideoKeyFrames
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.body import make_scene_body
from physagent_jax.scene.camera import make_reference_camera

REFUSED = 2  # exit code of the command line where a person can mend what was asked
_LONGEST = 500  # characters of a message


def run_case(case: Case, name: str, thing: Sequence[str], out: Path) -> Row:
    """Run a sentence anew and gather the figures.

    Args:
        case: The sentence.
        name: Name of the case and of its folder.
        thing: The object's options of the command line.
        out: Folder of the runs' folders.
    """
    folder = out / name
    shutil.rmtree(folder, ignore_errors=True)  # the run of an earlier revision would be taken for this one
    arguments = [*thing, "--prompt", case.sentence, "--preset", case.preset.value, *case.options]
    arguments += ["--out", str(folder), "--json"]
    command = [sys.executable, "-m", "physagent_jax", "run", *arguments]
    begun = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True)
    seconds = time.perf_counter() - begun
    row: Row = {
        "case": name,
        "object": case.thing,
        "sentence": case.sentence,
        "preset": case.preset.value,
        "options": list(case.options),
        "seconds": round(seconds, 1),
    }
    if done.returncode == 0:
        row |= gather(open_run(folder), json.loads(done.stdout))
    else:
        row |= {"verdict": "REFUSED" if done.returncode == REFUSED else "CRASHED", "video": None}
        row |= {"message": " ".join(done.stderr.split())[-_LONGEST:]}
    harness.say(f"{name:10s} {row['verdict']:8s} {case.preset.value:5s} {case.sentence}")
    return row


def gather(run: FinishedRun, summary: dict) -> Row:
    """Row of a run; ``summary`` is the output of its command line. A folder that is not whole gives a crashed row."""
    best = run.best
    if not (best and best.motion and best.simulation and best.judgement and best.force_field and run.video):
        return {"verdict": "CRASHED", "video": None, "message": " ".join(run.problems)[-_LONGEST:]}
    report, truth, judgement = best.motion, best.simulation.truth, best.judgement
    assert truth is not None
    return {
        "video": hash_video(run.video),
        "force_field": leave_seeds_out(best.force_field.model_dump(mode="json", exclude_none=True)),
        "frames": report.frame_count,
        "frame_dt": report.frame_dt,
        "errors": compare(report, truth),
        "verdict": summary["verdict"],
        "score": judgement.score,
        "failed_checks": list_failures(judgement),
        **_tell_truth(run),
        **{key: summary[key] for key in ("assumptions", "not_understood", "unsure")},
        "iterations": summary["iterations"],
        "particle_count": summary["particle_count"],
        "substeps": summary["substeps"],
        "wall_s": summary["wall_s"],
    }


def _tell_truth(run: FinishedRun) -> Row:
    """Columns of the verdict from the truth; none, with the reason, where the run's own does not come again."""
    try:
        judgement = judge_truth(run)
    except ValueError as error:
        return {"true_verdict": None, "true_score": None, "true_failed_checks": [f"not judged: {error}"]}
    return {
        "true_verdict": judgement.verdict.value,
        "true_score": judgement.score,
        "true_failed_checks": list_failures(judgement),
    }


def judge_truth(run: FinishedRun) -> Judgement:
    """Verdict of the planner on the best round's true motion, as of a viewer with perfect eyes.

    Raises:
        ValueError: Told of the perceived motion, it does not say again what it said in the run.
    """
    spec, reply, scene, best = run.spec, run.semantic, run.best_scene, run.best
    assert spec and reply and scene and best and best.motion and best.force_field and best.judgement
    assert best.video is not None
    resolved = resolve(spec)
    template = resolved.with_reply(reply)
    limbs = sorted({each.limb for each in reply.expectations if each.limb is not None})
    parts = resolved.list_parts(make_scene_body(scene, run.folder)) if limbs else ()
    brief = make_brief(template, frames_fixed=spec.overrides.frame_count is not None, parts=parts)
    if not scene.always_gravity:  # an object that cannot stand has no weight where it leaves its place
        brief = brief.model_copy(update={"world": "free"})
    if scene.anchor.kind != "none":  # or is held at its feet
        brief = brief.model_copy(update={"anchored": scene.anchor.reason or scene.anchor.kind})
    context = AgentContext(spec.prompt, brief, describe_skills(), reply)
    planner, pictures = make_agents().planner, VideoKeyFrames(best.video)
    again = planner.judge(context, Observation(best.force_field, best.motion, pictures)).value
    if again.verdict is not best.judgement.verdict:
        raise ValueError(f"the planner now says {again.verdict} of what it called {best.judgement.verdict}")
    x = run.motion().x
    report = report_true_motion(
        x,
        frame_dt=scene.timing.frame_dt,
        camera=make_reference_camera(scene.camera, scene.rendering, scene.domain),
        windows=planner.windows(context),
        parts={limb: make_region_mask(parts[limb].moved, x[0]) for limb in limbs},
    )
    return planner.judge(context, Observation(best.force_field, report, pictures)).value


def list_failures(judgement: Judgement) -> list[str]:
    """Checks that did not pass."""
    return [
        f"{check.question} expected {check.expected}, observed {check.observed}"
        for check in judgement.checks
        if check.passed is not True
    ]


def leave_seeds_out(field: Any) -> Any:
    """A force field as JSON without the seeds of its cells: hundreds of places, which nobody reads."""
    if isinstance(field, list):
        return [leave_seeds_out(each) for each in field]
    if not isinstance(field, dict):
        return field
    return {name: leave_seeds_out(each) for name, each in field.items() if name not in ("inside", "outside")}
