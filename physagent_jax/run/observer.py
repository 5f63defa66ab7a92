"""Callbacks that observe the progress of a run, and what tells them of warnings."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.motion.schema import Judgement


class Observer:
    """Callbacks for a run's progress; override the ones of interest."""

    def stage(self, text: str) -> None:
        """A new stage begins."""

    def understood(self, reply: SemanticReply) -> None:
        """The sentence was read."""

    def assumed(self, text: str) -> None:
        """Something was assumed of the object before anything is simulated."""

    def warned(self, text: str) -> None:
        """Something about the object came up that the user should know before anything is simulated."""

    def frame(self, done: int, total: int) -> None:
        """``done`` of ``total`` frames are simulated and rendered."""

    def remaining(self, clip: float, run: float) -> None:
        """Estimated seconds until this round's clip is there, and until the end of a run that makes all rounds [s]."""

    def shown(self, index: int, clip: Path) -> None:
        """The video of round ``index`` for people is there; called from a thread, while the round is measured."""

    def judged(self, index: int, judgement: Judgement) -> None:
        """Round ``index``, counted from 0, was judged."""

    def ended(self, why: str) -> None:
        """No further round is made, although none was a success and more were allowed."""

    def probed(self, index: int, judgement: Judgement) -> None:
        """Round ``index`` on the coarse version of the scene was judged."""


class Teller:
    """Tells an observer of a run.

    Attributes:
        observer: The observer.
        warnings: All that was warned of, for the manifest.
    """

    def __init__(self, observer: Observer):
        self.observer = observer
        self.warnings: tuple[str, ...] = ()

    def warn(self, *texts: str) -> None:
        """Tell what has not been told yet, and keep it."""
        for text in dict.fromkeys(texts):
            if text not in self.warnings:
                self.warnings += (text,)
                self.observer.warned(text)

    @contextmanager
    def heed_warnings(self) -> Iterator[None]:
        """Tell what is warned of within."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            yield
        self.warn(*(str(warning.message) for warning in caught))
