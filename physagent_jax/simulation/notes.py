"""The choice of notes in the video for people."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class Notes:
    """The choice of what is drawn over the pictures.

    Attributes:
        caption: Whether the sentence is written below.
        arrows: Whether arrows show what acts, and where to.
    """

    caption: bool = False
    arrows: bool = False
