"""One run for each sentence of the first results: the seconds until its first clip is there, and where they go."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from benchmarks import harness
from benchmarks.first_results.catalogue import FIRST, THINGS, Case, name_case
from benchmarks.harness import Job, Row, Rows, table
from physagent_jax.run.manifest import Manifest
from physagent_jax.simulation.record import SimulationRecord

AIM = 45.0  # most seconds until the first clip
PARTICLES = 20_000  # of the scenes for which the aim holds: what `--preset fast` has at most
SHOWN = "clip of round 1:"  # how the line begins that tells of the clip
STAGES = ("start", "prepare", "compile", "simulate", "render", "agents", "draw", "rest")


def list_jobs(
    data: Path | None, first: Sequence[str], options: Sequence[str], every: int = 1
) -> Iterator[Job]:
    """A job for each sentence whose object is there, at the default settings.

    Args:
        data: Folder of objects that are not bundled and cannot be made.
        first: Options of a run that is made before, so that programs are there that all scenes share.
        options: More options of each.
        every: Leave out all but each so-manieth sentence.
    """
    folder = tempfile.TemporaryDirectory()
    place = Path(folder.name)
    _run_once(first, place)
    for number, case in list(enumerate(FIRST, 1))[::every]:
        file = THINGS[case.thing].find_file(data, place)
        name = name_case(number, case)
        if file is None:
            harness.say(f"{name} is left out: {THINGS[case.thing].file} is not in --data")
            continue
        yield Job(f"{name}: {case.sentence}", partial(_measure, folder, name, case, file, options))


def _run_once(job: Sequence[str], place: Path) -> None:
    command = _make_command(job, place / "first")
    subprocess.run(command, env=_make_environment(place), capture_output=True, check=True)


def _measure(
    folder: tempfile.TemporaryDirectory, name: str, case: Case, file: Path, options: Sequence[str]
) -> Rows:
    place = Path(folder.name)
    job = ["--object", str(file), *THINGS[case.thing].options, "--prompt", case.sentence, *case.options]
    row = time_clip([*job, "--max-iterations", "1", *options], place / name, place)
    harness.say(f"{name:12s} {row['seconds'] or row['message']}")
    return [{"case": name, "object": case.thing, "sentence": case.sentence, **row}]


def time_clip(job: Sequence[str], out: Path, place: Path) -> Row:
    """Run a job and note when its process tells of the first clip.

    Args:
        job: Options of ``physagent run``.
        out: Folder of the run.
        place: Folder that keeps compiled programs.
    """
    load, begun, seconds, told = os.getloadavg()[0], time.perf_counter(), None, []
    with subprocess.Popen(
        _make_command(job, out),
        env=_make_environment(place),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            told.append(line.strip())
            if line.strip().startswith(SHOWN) and seconds is None:
                seconds = round(time.perf_counter() - begun, 2)
    row: Row = {"seconds": seconds, "load_average": round(load, 2), "code": process.returncode}
    if seconds is None:
        return {**row, "message": " ".join(told)[-300:], "good": process.returncode == 2}
    record = SimulationRecord.model_validate_json((out / "iterations/0/simulation.json").read_bytes())
    sizes = {"particles": record.particle_count, "frames": len(record.kinetic_energy)}
    manifest = Manifest.model_validate_json((out / "manifest.json").read_bytes())
    return {**row, **sizes, "substeps": record.substeps, "stages": split_stages(seconds, manifest)}


def split_stages(seconds: float, manifest: Manifest) -> dict[str, float]:
    """Seconds of each of `STAGES` until the clip was there; "start" is that of Python with its packages."""
    first = manifest.first_clip
    assert first is not None
    stages = {name: value for name, value in first.stages.model_dump().items() if name in STAGES}
    rest = first.seconds - sum(stages.values()) - first.draw
    found = {"start": seconds - first.seconds, **stages, "draw": first.draw, "rest": rest}
    return {name: round(found[name], 2) for name in STAGES}


def _make_command(job: Sequence[str], out: Path) -> list[str]:
    return [sys.executable, "-m", "physagent_jax", "run", *job, "--out", str(out), "--overwrite", "--json"]


def _make_environment(place: Path) -> dict[str, str]:
    environment = {**os.environ, "XDG_CACHE_HOME": str(place / "cache")}
    for name in ("NUMBA_CACHE_DIR", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    return environment


def write_tables(rows: Rows) -> harness.Tables:
    """The table of all sentences, and that of the stages."""
    shown = [row for row in rows if row["seconds"] is not None]
    lines = [
        [
            row["case"],
            row["sentence"],
            *(
                (f"{row['particles']:,}", row["frames"], f"{row['seconds']:.0f}")
                if row["seconds"] is not None
                else ("", "", "refused" if row["code"] == 2 else "crashed")
            ),
        ]
        for row in rows
    ]
    cases = table(("case", "sentence", "particles", "frames", "seconds to the clip"), lines)
    if not shown:
        return {"clips": cases}
    return {"clips": f"{_summarise(shown)}\n\n{cases}", "clip stages": _write_stages(shown)}


def _summarise(rows: Rows) -> str:
    seconds = [row["seconds"] for row in rows]
    within = sum(each <= AIM for each in seconds)
    return (
        f"Median {statistics.median(seconds):.0f} s, longest {max(seconds):.0f} s; {within} of {len(rows)} first clips "
        f"are there within {AIM:.0f} s (aim: all, for up to {PARTICLES:,} particles on two idle cores)."
    )


def _write_stages(rows: Rows) -> str:
    lines = []
    for stage in STAGES:
        seconds = [row["stages"][stage] for row in rows]
        share = sum(seconds) / sum(row["seconds"] for row in rows)
        lines.append((stage, f"{statistics.median(seconds):.1f}", f"{max(seconds):.1f}", f"{share:.0%}"))
    return table(("stage", "median [s]", "longest [s]", "share of all"), lines)
