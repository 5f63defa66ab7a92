"""Work on each clip, by this process or by others."""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Literal

from benchmarks.harness import Row
from benchmarks.verdicts.claims import Seen, find_faults
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.judging import judge
from benchmarks.verdicts.motions import Motion
from benchmarks.verdicts.recording import find_file, record
from benchmarks.verdicts.scenes import FRAME_DT, find_axes
from benchmarks.verdicts.things import THINGS

Part = Literal["clips", "truth", "pictures"]


def do_all(
    part: Part, clips: Sequence[Clip], folder: Path, data: Path | None, *, workers: int, made: bool
) -> list[Row]:
    """The rows of clips.

    Args:
        part: What to do with each.
        clips: Which.
        folder: Where they are kept.
        data: Folder of captured objects and a photo.
        workers: Processes that work at it.
        made: Leave out what has not been made.
    """
    each = partial(do, part, folder=folder, data=data, made=made)
    apart = workers > 1 and part != "truth"  # what the truth shows is judged in no time
    rows = _start_workers(workers).map(each, clips) if apart else map(each, clips)
    return [row for row in rows if row is not None]


def do(part: Part, clip: Clip, *, folder: Path, data: Path | None, made: bool) -> Row | None:
    """The row of a clip; None if it has not been made and is not to be, or does not move as it is said to."""
    if made and not find_file(clip.thing, clip.motion, folder, data).is_file():
        return None
    untrue = _check(clip.thing, clip.motion, folder, data)
    if part == "clips":
        return {"clip": clip.name, "motion": clip.motion.words, "untrue": untrue}
    return None if untrue else judge(clip, part, folder, data)


@cache
def _check(thing: str, motion: Motion, folder: Path, data: Path | None) -> list[str]:
    """Departures from what is said; several sentences share a motion, and all parts ask."""
    held = record(thing, motion, folder, data)
    x = held.particles @ find_axes(THINGS[thing]).T  # as the viewer has them
    return find_faults(motion.claims, Seen(x, (held.alpha > 0).sum((1, 2)), FRAME_DT), motion.held)


@cache
def _start_workers(count: int) -> ProcessPoolExecutor:
    """Processes of their own: JAX does not survive a fork."""
    return ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
