"""Remarks on videos, written by hand and kept with the video's digest: they hold for no other video."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from benchmarks.harness import Row
from physagent_jax.core.strict import Strict

SEEN = Path(__file__).with_name("seen.json")
VIEWS = ("yes", "partly", "no")
UNSEEN = "not looked at"


class Remark(Strict):
    """Remark on a sentence's video by a viewer.

    Attributes:
        video: Digest of the video; None = the sentence was refused, and there is none.
        viewer: Whether it shows what the sentence says.
        would_show: Whether the viewer would show it to a colleague; None = nobody was asked.
        remark: What it shows.
    """

    video: str | None
    viewer: Literal["yes", "partly", "no"]
    would_show: Literal["yes", "no"] | None = None
    remark: Annotated[str, Field(min_length=1)]


Remarks = Mapping[str, Remark]


def hash_video(path: Path) -> str:
    """Digest of a video: the same scene on the same machine gives the same bytes."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def read_remarks(path: Path = SEEN) -> dict[str, Remark]:
    """Remarks by the name of the case."""
    return TypeAdapter(dict[str, Remark]).validate_json(path.read_bytes())


def find_remark(row: Row, remarks: Remarks) -> Remark | None:
    """The remark on this very video; None if nobody looked at it."""
    remark = remarks.get(row["case"])
    return None if remark is None or remark.video != row["video"] else remark


def find_view(row: Row, remarks: Remarks) -> tuple[str, str]:
    """Return whether the viewer agrees with the sentence, and the remark; `UNSEEN` if nobody looked at this video."""
    remark = find_remark(row, remarks)
    return (UNSEEN, "") if remark is None else (remark.viewer, remark.remark)


def list_unseen(rows: Iterable[Row], remarks: Remarks) -> dict[str, dict[str, str | None]]:
    """Remarks to be written by hand, with the digests of the videos that nobody has looked at."""
    blank = {"viewer": "", "would_show": "", "remark": ""}
    return {
        row["case"]: {"video": row["video"], **blank} for row in rows if find_remark(row, remarks) is None
    }


def rank(verdict: str, view: str) -> int:
    """Rank of disagreement of verdict and viewer: 0 = one says yes, the other no; 1 = a success only in part."""
    if view == UNSEEN:
        return 2
    success = verdict == "SUCCESS"
    if view == "partly":
        return 1 if success else 3
    return 3 if success == (view == "yes") else 0
