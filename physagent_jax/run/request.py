"""What the loop is asked for, by whom it is answered, and who looks on."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

from physagent_jax.agents.protocols import ExecutorAgent, PlannerAgent, SemanticAgent
from physagent_jax.agents.schema import Judgement
from physagent_jax.run.manifest import Manifest
from physagent_jax.scene.config import Anchor
from physagent_jax.scene.cost import Limits
from physagent_jax.scene.fuse import Ingredients


@dataclasses.dataclass(frozen=True)
class Agents:
    """The three agents."""

    semantic: SemanticAgent
    planner: PlannerAgent
    executor: ExecutorAgent


@dataclasses.dataclass(frozen=True)
class Request:
    """What to make.

    Attributes:
        prompt: The sentence.
        ingredients: Object, matter, cost, camera; its anchor is what the object's kind asks for.
        choose_anchor: From what the sentence says about holding (kind or None, words) to the anchor.
        base_dir: Folder that relative paths of the ingredients start from.
        out: Run folder.
        manifest: Passport; its ``inputs`` identify the run.
        max_iterations: Rounds at most.
        probe: Whether as many rounds on a coarse version of the scene come first, to begin with their best force field.
        limits: What a round may take.
        needed: Files that the run reads; ``overwrite`` does not replace these.
        overwrite: Replace another run in ``out``.
        save_frames, save_splats: Also leave PNG frames, and one PLY per frame.
    """

    prompt: str
    ingredients: Ingredients
    choose_anchor: Callable[[Any, str], Anchor]
    base_dir: Path
    out: Path
    manifest: Manifest
    limits: Limits = Limits()
    needed: tuple[Path, ...] = ()
    max_iterations: int = 3
    probe: bool = False
    overwrite: bool = False
    save_frames: bool = False
    save_splats: bool = False


class Observer:
    """What a user sees while it runs; override what is of interest."""

    def stage(self, text: str) -> None:
        """A new stage begins."""

    def frame(self, done: int, total: int) -> None:
        """``done`` of ``total`` frames are simulated and rendered."""

    def judged(self, index: int, judgement: Judgement) -> None:
        """Iteration ``index`` was judged."""

    def probed(self, index: int, judgement: Judgement) -> None:
        """Round ``index`` on the coarse version of the scene was judged."""
