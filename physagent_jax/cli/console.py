"""Console output: progress on standard error, results on standard output."""

from __future__ import annotations

import sys
import time
import warnings
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.cli import stopping
from physagent_jax.cli.options import describe_unknown, name_options
from physagent_jax.core.text import split_reason
from physagent_jax.motion.schema import Judgement, Verdict
from physagent_jax.run.observer import Observer

stderr = Console(stderr=True, highlight=False, soft_wrap=True)


PATIENCE = 2.0  # [s] after which a stage says how long all will take


def format_seconds(seconds: float) -> str:
    """A duration in words, as exact as an estimate is: ``"35 s"``, ``"4 min"``."""
    if seconds < 90:
        return f"{max(5 * round(seconds / 5), 5)} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.1f} h"


def warn(message: object) -> None:
    """One line about something that the user should know."""
    stderr.print(f"[yellow]warning:[/] {_escape(message)}")


def tell_warnings_plainly() -> None:
    """Print each warning that nothing caught as one plain line, without file, class and line of code.

    Other categories than `UserWarning` are for developers: they are left out, unless Python was asked for them.
    """
    if sys.warnoptions:
        return
    told: set[str] = set()

    def show(message, category, filename, lineno, file=None, line=None) -> None:
        del filename, lineno, line
        text = str(message)
        if file is None and category is UserWarning and text not in told:
            told.add(text)
            warn(name_options(text))

    warnings.showwarning = show


def _escape(message: object) -> str:
    """Text without rich's markup."""
    return str(message).replace("[", r"\[")


class FrameBar:
    """A progress bar over frames; a plain terminal or a pipe gets no control characters."""

    def __init__(self, text: str):
        self._text = text
        self._progress = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("frames"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            console=stderr,
            transient=True,
            disable=not stderr.is_terminal,
        )
        self._task = None
        self.left = ""  # what is said of the time left

    def __call__(self, done: int, total: int) -> None:
        """``done`` of ``total`` frames are finished; raises `Stopped` if the process has been asked to stop."""
        stopping.check()
        if self._task is None:
            self._progress.start()
            self._task = self._progress.add_task(self._text, total=total, left=self.left)
        self._progress.update(self._task, completed=done, left=self.left)
        if done == total:
            self.close()

    def close(self) -> None:
        """Take the bar off the screen."""
        self._progress.stop()


class ConsoleObserver(Observer):
    """Tells the loop's progress."""

    def __init__(self):
        self._bar: FrameBar | None = None
        self._begun = time.perf_counter()  # of the stage
        self._foretold = False
        self.told: set[str] = set()  # warnings that were printed

    def stage(self, text: str) -> None:
        """Print the stage; its frames, if any, get a bar. Raises as `FrameBar`."""
        self.close()
        stopping.check()
        stderr.print(f"[dim]·[/] {_escape(text)}")
        self._bar = FrameBar(text)
        self._begun, self._foretold = time.perf_counter(), False

    def frame(self, done: int, total: int) -> None:
        """Move the bar."""
        if self._bar is not None:
            self._bar(done, total)

    def remaining(self, clip: float, run: float) -> None:
        """Say it beside the bar, and once in a line of its own where a stage is not over at once."""
        times = [f"clip in about {format_seconds(clip)}"] if clip > 0 else []
        text = ", ".join([*times, f"end in at most about {format_seconds(run)}"])
        if self._bar is not None:
            self._bar.left = text
        if not self._foretold and time.perf_counter() - self._begun > PATIENCE:
            self._foretold = True
            stderr.print(f"  {text}")

    def shown(self, index: int, clip: Path) -> None:
        """Print the clip's path."""
        stderr.print(f"  clip of round {index + 1}: {_escape(clip)}")

    def understood(self, reply: SemanticReply) -> None:
        """Print what was assumed, and the words that led to nothing, while the run can still be stopped."""
        for note in reply.notes:
            stderr.print(f"  assumed: {_escape(note)}")
        if reply.ignored:
            stderr.print(f"  ignored: {_escape(', '.join(reply.ignored))}")
        if reply.not_understood:
            stderr.print(f"  [yellow]not understood:[/] {_escape(describe_unknown(reply))}")
        for doubt in reply.unsure:
            stderr.print(f"  [yellow]unsure:[/] {_escape(doubt)}")

    def assumed(self, text: str) -> None:
        """Print it beside what was assumed of the sentence."""
        stderr.print(f"  assumed: {_escape(name_options(text))}")

    def warned(self, text: str) -> None:
        """Print it, while the run can still be stopped."""
        self.told.add(text)
        warn(name_options(text))

    def ended(self, why: str) -> None:
        """Print why there is no further round."""
        stderr.print(f"  no further round: {_escape(why)}")

    def judged(self, index: int, judgement: Judgement) -> None:
        """Print the planner's verdict and its suggestion."""
        self._tell(f"round {index + 1}", judgement)

    def probed(self, index: int, judgement: Judgement) -> None:
        """Print the same of a coarse round."""
        self._tell(f"coarse round {index + 1}", judgement)

    def _tell(self, which: str, judgement: Judgement) -> None:
        self.close()
        good = judgement.verdict is Verdict.SUCCESS
        colour = "green" if good else "yellow"
        score = "" if judgement.score is None else f" (score {judgement.score:.2f})"
        stderr.print(
            f"[{colour}]{'✓' if good else '✗'}[/] {which}: [{colour}]{judgement.verdict.value}[/]{score}"
        )
        for number, stage in enumerate(judgement.stages, 1):
            if len(judgement.stages) > 1:
                found = f"{stage.asked}: {stage.measured}"
                stderr.print(
                    f"  stage {number}, {stage.verdict.value}: {_escape(f'{stage.words} ({found})')}"
                )
        if judgement.suggestion:
            why, details = split_reason(judgement.suggestion)
            stderr.print(f"  {_escape(why)}")
            if details:
                stderr.print(f"  [dim]{_escape(details)}[/]")
        for note in judgement.notes:
            stderr.print(f"  {_escape(note)}")

    def close(self) -> None:
        """Remove a bar that is still on the screen."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None
