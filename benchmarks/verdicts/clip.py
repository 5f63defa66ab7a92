"""One clip: an object, a sentence, a motion, and whether a person would call it a success."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Literal

from benchmarks.verdicts.backgrounds import BACKGROUNDS, Background
from benchmarks.verdicts.motions import Motion

Wrong = Literal[
    "still",
    "mirrored",
    "turned by 60",
    "turned by 90",
    "too weak",
    "too strong",
    "order",
    "window",
    "part",
    "kind",
    "ending",
    "collateral",
    "broken up",
    "out of the picture",
]


@dataclasses.dataclass(frozen=True)
class Clip:
    """A sentence and a motion.

    Attributes:
        thing: The object's noun.
        sentence: What is asked.
        motion: What is shown.
        tag: Tag of the sentence, for the name.
        variant: Variant of the motion, for the name.
        wrong: How the motion is wrong; None = it is right.
        world: Where the object is, as those who read the sentence are told.
        held: Whether its foot is held, likewise.
    """

    thing: str
    sentence: str
    motion: Motion
    tag: str
    variant: str
    wrong: Wrong | None
    world: Literal["free", "ground"]
    held: bool

    @property
    def name(self) -> str:
        """Unique."""
        return f"{self.thing}/{self.tag}/{self.variant}"

    @property
    def background(self) -> Background:
        """By the name, so that a clip keeps it."""
        return BACKGROUNDS[_digest("background", self.name) % len(BACKGROUNDS)]

    @property
    def half(self) -> Literal["development", "test"]:
        """By the name."""
        return "test" if _digest("half", self.name) % 2 else "development"

    @property
    def turn(self) -> int:
        """A number by which fair samples can be drawn."""
        return _digest("order", self.name)


def _digest(*words: str) -> int:
    return int.from_bytes(hashlib.sha256(" ".join(words).encode()).digest()[:8], "big")
