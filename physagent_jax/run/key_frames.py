"""A round's pictures for the agents: read from its video when an agent asks for them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from physagent_jax.agents.context import KeyFrame
from physagent_jax.output.video import encode_png, read_video


@dataclasses.dataclass(frozen=True)
class VideoKeyFrames:
    """Implements `agents.context.KeyFrames`; a resumed run shows the same pictures as one that was not stopped.

    Attributes:
        video: The round's plain video: agents are shown what perception gets.
    """

    video: Path

    def pick(self, most: int = 6) -> tuple[KeyFrame, ...]:
        """At most ``most`` evenly spaced frames, the first and the last among them."""
        frames = read_video(self.video)
        return tuple(KeyFrame(k, encode_png(frames[k])) for k in spread_evenly(len(frames), most))


def spread_evenly(count: int, most: int) -> list[int]:
    """Indices of at most ``most`` of ``count`` frames, evenly spaced from the first to the last."""
    return np.linspace(0, count - 1, min(most, count)).round().astype(int).tolist()
