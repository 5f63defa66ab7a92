"""Reading a run folder: whatever is there, and a list of what is not."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from pydantic import BaseModel

from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import FailedCall, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import parse_model, read_json, shorten
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.progress import find_best_round
from physagent_jax.motion.schema import Judgement
from physagent_jax.output.motion_file import Motion, read_motion
from physagent_jax.output.video import read_video
from physagent_jax.perception.schema import MotionReport
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.refused import REFUSED, RefusedReading, RefusedReadings
from physagent_jax.run.spec import RunSpec
from physagent_jax.run.store import PLAIN_VIDEO, PROBE, REPORT, VIDEO
from physagent_jax.scene.config import SceneConfig
from physagent_jax.simulation.record import SimulationRecord

Model = TypeVar("Model", bound=BaseModel)


@dataclasses.dataclass(frozen=True)
class FinishedRound:
    """One round of the loop; None where the file is missing or broken. Its video is the plain one of perception.

    People count rounds from 1, as the terminal does; ``index``, which names the folder, counts from 0. ``failed_calls``
    are those that gave no answer, by the agent's role.
    """

    index: int
    scene: SceneConfig | None
    force_field: ForceField | None
    motion: MotionReport | None
    judgement: Judgement | None
    rewrite: Rewrite | None
    simulation: SimulationRecord | None
    video: Path | None
    overlay: Path | None
    reused_frames: int = 0
    planner_trace: Trace | None = None
    executor_trace: Trace | None = None
    failed_calls: Mapping[str, tuple[FailedCall, ...]] = dataclasses.field(default_factory=dict)

    @property
    def number(self) -> int:
        """The round's number, counted from 1."""
        return self.index + 1

    @property
    def clip(self) -> str:
        """The name under which the page's script groups this round's video and plots."""
        return f"round-{self.number}"


@dataclasses.dataclass(frozen=True)
class FinishedRun:
    """A run folder's contents.

    Attributes:
        folder: Where it is.
        spec: What was asked for; None in a folder that no agents made.
        manifest, semantic, scene: Top-level files; None where missing or broken.
        video: The best round's, drawn for people; the plain one if there is none.
        rounds: In order.
        probe: Rounds on a coarse version of the scene, which came before.
        problems: What is missing or broken, a sentence each.
        semantic_trace: How the semantic agent came to its reply.
        semantic_failed: Its calls that gave no answer.
        refused: Sentences that were read here for runs which were refused then.
    """

    folder: Path
    spec: RunSpec | None
    manifest: Manifest | None
    semantic: SemanticReply | None
    scene: SceneConfig | None
    video: Path | None
    rounds: tuple[FinishedRound, ...]
    probe: tuple[FinishedRound, ...]
    problems: tuple[str, ...]
    semantic_trace: Trace | None = None
    semantic_failed: tuple[FailedCall, ...] = ()
    refused: tuple[RefusedReading, ...] = ()

    @property
    def best(self) -> FinishedRound | None:
        """The round that the top-level files show; if the manifest does not say, what the loop would choose."""
        named = self.manifest.best_iteration if self.manifest else None
        for round_ in self.rounds:
            if round_.index == named:
                return round_
        judged = [it for it in self.rounds if it.judgement]
        if judged:
            return judged[find_best_round([it.judgement for it in judged if it.judgement])]
        return self.rounds[-1] if self.rounds else None

    @property
    def best_scene(self) -> SceneConfig | None:
        """The best round's scene, from the top level or its own folder."""
        return self.scene or (self.best.scene if self.best else None)

    @property
    def prompt(self) -> str:
        """The sentence."""
        if self.manifest:
            return self.manifest.prompt
        return self.best_scene.prompt if self.best_scene else ""

    @property
    def report(self) -> Path | None:
        """The report page; None if there is none."""
        path = self.folder / REPORT
        return path if path.is_file() else None

    def frames(self) -> np.ndarray:
        """The best round's pictures, from its video, uint8, shape (T, height, width, 3).

        Raises:
            UserError: There is no video, or it cannot be read.
        """
        return read_video(self.require(self.video, VIDEO))

    def motion(self) -> Motion:
        """The best round's particles and Gaussians, frame by frame.

        Raises:
            UserError: The run has left none, or the file is damaged.
        """
        path = self.folder / "motion.npz"
        return read_motion(self.require(path if path.is_file() else None, path.name))

    def require(self, path: Path | None, name: str) -> Path:
        """``path``, a file of the run that is called ``name``.

        Raises:
            UserError: There is none.
        """
        if path is None:
            raise UserError(
                f"{shorten(self.folder)} has no {name}", do="Finish the run: give its command again"
            )
        return path

    @property
    def frame_dt(self) -> float | None:
        """Seconds per frame [s]."""
        return self.best_scene.timing.frame_dt if self.best_scene else None


def open_run(folder: str | Path) -> FinishedRun:
    """Read a run folder; missing and broken files become notes, not errors.

    Raises:
        UserError: The folder does not exist or holds nothing of a run.
    """
    folder = Path(folder)
    if not os.path.isdir(folder):  # False too where the system cannot take the name
        raise UserError(f"{shorten(folder)} is not a run folder", got="no folder", do="Check the path")
    reader = _Reader(folder)
    spec = reader.model("run.json", RunSpec, optional=True)
    manifest = reader.model("manifest.json", Manifest)
    semantic = reader.model("semantic.json", SemanticReply)
    semantic_trace = reader.model("semantic_trace.json", Trace, optional=True)
    semantic_failed = reader.failed_calls("semantic")
    refused = reader.model(REFUSED, RefusedReadings, optional=True)
    scene = reader.model("scene.json", SceneConfig)
    video = reader.file(VIDEO, optional=True) or reader.file(PLAIN_VIDEO, optional=True)
    if video is None:
        reader.problems.append(f"{VIDEO} is missing.")
    reused = manifest.reused_frames if manifest else {}
    rounds = _read_rounds(reader, "iterations", reused)
    probe = _read_rounds(reader, f"{PROBE}/iterations", reused)
    if manifest is None and scene is None and not rounds and not probe:
        raise UserError(f"{folder} is not a run folder", do="Name the folder that holds manifest.json")
    if not rounds:
        reader.problems.append("No round has been stored yet.")
    problems = tuple(reader.problems)
    return FinishedRun(
        folder,
        spec,
        manifest,
        semantic,
        scene,
        video,
        rounds,
        probe,
        problems,
        semantic_trace,
        semantic_failed,
        refused.readings if refused else (),
    )


def _read_rounds(reader: _Reader, name: str, reused: dict[str, int]) -> tuple[FinishedRound, ...]:
    """Those in the folder ``name``, in order."""
    found = reader.folder.glob(f"{name}/*")
    indices = sorted(int(p.name) for p in found if p.is_dir() and p.name.isdecimal())
    return tuple(_read_round(reader, name, index, reused, is_last=index == indices[-1]) for index in indices)


def _read_round(
    reader: _Reader, name: str, index: int, reused: dict[str, int], *, is_last: bool
) -> FinishedRound:
    base = f"{name}/{index}"
    return FinishedRound(
        index=index,
        scene=reader.model(f"{base}/scene.json", SceneConfig),
        force_field=reader.model(f"{base}/force_field.json", ForceField),
        motion=reader.model(f"{base}/motion_report.json", MotionReport),
        judgement=reader.model(f"{base}/judgement.json", Judgement),
        # The last round has no successor, and pictures for people are a courtesy.
        rewrite=reader.model(f"{base}/rewrite.json", Rewrite, optional=is_last),
        simulation=reader.model(f"{base}/simulation.json", SimulationRecord),
        video=reader.file(f"{base}/{PLAIN_VIDEO}"),
        overlay=reader.file(f"{base}/overlay.png", optional=True),
        reused_frames=reused.get(base, 0),
        planner_trace=reader.model(f"{base}/planner_trace.json", Trace, optional=True),
        executor_trace=reader.model(f"{base}/executor_trace.json", Trace, optional=True),
        failed_calls={role: reader.failed_calls(f"{base}/{role}") for role in ("planner", "executor")},
    )


class _Reader:
    """Reads files of one folder and keeps account of those that fail."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.problems: list[str] = []

    def file(self, name: str, *, optional: bool = False) -> Path | None:
        path = self.folder / name
        if os.path.isfile(path):  # False too where the system cannot take the name
            return path
        if not optional:
            self.problems.append(f"{name} is missing.")
        return None

    def model(self, name: str, schema: type[Model], *, optional: bool = False) -> Model | None:
        path = self.file(name, optional=optional)
        if path is None:
            return None
        try:
            return parse_model(read_json(path), schema, f"{name} cannot be used")
        except UserError as error:
            self.problems.append(str(error))
        return None

    def failed_calls(self, agent: str) -> tuple[FailedCall, ...]:
        """Of the agent whose files begin with ``agent``, in the order of the calls."""
        paths = sorted(
            self.folder.glob(f"{agent}_failed_*.json"), key=lambda path: (len(path.name), path.name)
        )
        calls = [self.model(path.relative_to(self.folder).as_posix(), FailedCall) for path in paths]
        return tuple(call for call in calls if call is not None)
