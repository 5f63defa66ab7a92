"""Twelve sentences over four objects, as measured: `python -m benchmarks.first_results --out DIR`.

Runs the command-line job for each sentence, collects what was asked, simulated, perceived and true, and
writes ``first-results.json``; ``--markdown`` renders the table of docs/first-results.md from it. Real
captures that are not bundled are looked for in ``--data``; objects that are missing are left out and named.
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import tyro

from benchmarks.machine import circumstances
from physagent_jax.agents.schema import Judgement
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.motion import compare
from physagent_jax.perception.schema import MotionReport
from physagent_jax.run.manifest import Manifest
from physagent_jax.simulation.record import SimulationRecord

ASSETS = Path(__file__).resolve().parents[1] / "examples" / "assets"

CASES = [
    ("robot", "a strong wind pushes the robot to the left"),
    ("robot", "hit the robot hard from the left"),
    ("robot", "spin the robot clockwise about the vertical axis"),
    ("guitar", "drop the guitar"),
    ("guitar", "stretch the guitar vertically"),
    ("guitar", "push the guitar gently to the right, then pull it up"),
    ("plant", "a strong wind bends the plant to the left, then lets go"),
    ("plant", "the plant sways left and right twice, then is still"),
    ("plant", "hit the top of the plant from the right"),
    ("cow", "squeeze the cow from both sides"),
    ("cow", "twist the cow violently"),
    ("cow", "drop the cow and push it to the right"),
]


@dataclasses.dataclass(frozen=True)
class Command:
    """Run the cases, or render the table of an earlier run."""

    out: Path
    """Folder for the runs and first-results.json."""
    data: Path | None = None
    """Folder with guitar_sh0.ply and spot.obj."""
    markdown: Path | None = None
    """Also write the table here."""
    only: str = ""
    """Only cases whose sentence contains this."""
    frames: int | None = None
    """Shorter clips, for a quick look."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command, prog="python -m benchmarks.first_results")
    objects = prepare_objects(command)
    rows = []
    for index, (name, prompt) in enumerate(CASES):
        if command.only not in prompt:
            continue
        if name not in objects:
            print(f"left out, no file for {name!r}: {prompt}")
            continue
        rows.append(run_case(command, index, name, objects[name], prompt))
    result = {
        "command": "python -m benchmarks.first_results",
        **circumstances(),
        "rows": rows,
        "left_out": sorted({name for name, _ in CASES} - set(objects)),
    }
    (command.out / "first-results.json").write_text(json.dumps(result, indent=2) + "\n")
    if command.markdown:
        command.markdown.write_text(table(result))
    return 0


def prepare_objects(command: Command) -> dict[str, list[str]]:
    """Object options of the command line, by name."""
    command.out.mkdir(parents=True, exist_ok=True)
    plant = command.out / "plant.ply"
    physagent("make", "plant", "--out", str(plant))
    objects = {"robot": ["--object", str(ASSETS / "robot.ply")], "plant": ["--object", str(plant)]}
    extra = {
        "guitar": ("guitar_sh0.ply", ["--up", "-y", "--kind", "instrument"]),
        "cow": ("spot.obj", ["--up", "+y", "--kind", "animal", "--azimuth", "-60"]),
    }
    for name, (file, options) in extra.items():
        if command.data is not None and (command.data / file).is_file():
            objects[name] = ["--object", str(command.data / file), *options]
    return objects


def run_case(command: Command, index: int, name: str, options: list[str], prompt: str) -> dict:
    """One sentence: runs it in its own process and gathers the figures."""
    folder = command.out / f"{index:02d}-{name}"
    frames = ["--frames", str(command.frames)] if command.frames else []
    line = physagent(
        "run", *options, "--prompt", prompt, "--out", str(folder), "--overwrite", "--json", *frames
    )
    summary = json.loads(line)
    print(
        f"{index:2d} {summary['verdict']:8s} {summary['wall_s']['total']:6.1f} s  {name}: {prompt}",
        flush=True,
    )
    best = (
        folder
        / "iterations"
        / str(Manifest.model_validate_json((folder / "manifest.json").read_bytes()).best_iteration)
    )
    report = MotionReport.model_validate_json((best / "motion_report.json").read_bytes())
    record = SimulationRecord.model_validate_json((best / "simulation.json").read_bytes())
    judgement = Judgement.model_validate_json((best / "judgement.json").read_bytes())
    field = ForceField.model_validate_json((best / "force_field.json").read_bytes())
    truth = record.truth
    assert truth is not None
    return {
        "object": name,
        "prompt": prompt,
        "force_field": field.model_dump(mode="json", exclude_none=True),
        "perceived": report.text,
        "perceived_centroid": report.centroid[-1],
        "true_centroid": truth.centroid[-1],
        "perceived_farthest": farthest(report.centroid),
        "true_farthest": farthest(truth.centroid),
        "perceived_rotation": report.rotation_degrees[-1],
        "true_rotation": truth.rotation_degrees[-1],
        "true_stretch": truth.stretch[-1],
        "errors": compare(report, truth),
        "verdict": summary["verdict"],
        "score": judgement.score,
        "failed_checks": [
            f"{check.question} expected {check.expected}, observed {check.observed}"
            for check in judgement.checks
            if check.passed is not True
        ],
        "iterations": summary["iterations"],
        "particle_count": summary["particle_count"],
        "substeps": summary["substeps"],
        "wall_s": summary["wall_s"],
    }


def farthest(path) -> tuple[float, float, float] | None:
    """The largest displacement on a path [body lengths]; None if nothing of it was observable."""
    seen = [point for point in path if point is not None]
    return max(seen, key=lambda point: sum(c * c for c in point)) if seen else None


def physagent(*arguments: str) -> str:
    """Runs the command line in a fresh process; returns its standard output."""
    done = subprocess.run([sys.executable, "-m", "physagent_jax", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"physagent {' '.join(arguments)} failed:\n{done.stderr}")
    return done.stdout


def table(result: dict) -> str:
    """The measured rows as Markdown."""
    lines = [
        "| # | object | sentence | force field | perceived: farthest, last turn | truth | verdict | rounds | seconds |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for number, row in enumerate(result["rows"], 1):
        cells = [
            str(number),
            row["object"],
            row["prompt"],
            "<br>".join(_actions(row["force_field"])),
            _motion(row["perceived_farthest"], row["perceived_rotation"]),
            _motion(row["true_farthest"], row["true_rotation"]),
            f"{row['verdict']} ({row['score']:.2f})",
            str(row["iterations"]),
            f"{row['wall_s']['total']:.0f}",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _actions(field: dict) -> list[str]:
    lines = ["gravity"] if field["default_drop"] else []
    for action in (*field["actions"], *field["constraints"]):
        kind = action.get("action_type") or action["constraint_type"]
        vector = " ".join(f"{c:.2g}" for c in action["vector"])
        window = (
            "whole clip"
            if "active_time" not in action
            else "frames {:.3g}-{:.3g}".format(*action["active_time"])
        )
        region = ", a region" if "region" in action else ""
        lines.append(f"{kind} ({vector}) M = {action['magnitude']:.2f}, {window}{region}")
    return lines


def _motion(centroid, rotation) -> str:
    moved = "not observable" if centroid is None else "({:+.2f} {:+.2f} {:+.2f}) L".format(*centroid)
    turned = "turn not observable" if rotation is None else f"{rotation:.0f} deg"
    return f"{moved}, {turned}"


if __name__ == "__main__":
    sys.exit(main())
