"""All cases, and those whose error is studied against wall time."""

from __future__ import annotations

from benchmarks.cases.bar import FreeBar
from benchmarks.cases.base import Case

CASES: tuple[Case, ...] = (FreeBar(),)

STUDIED: dict[Case, str] = {FreeBar(): "signal (rms)"}
"""Each with the error that its plot shows."""
