"""Video judges of others: what they say of a finished clip, beside this package's verdict.

None of them takes part in a run. Each answers semantic adherence (does the clip show what the sentence says) and
physical scores, from 1 to 5 and higher is better:

- `videophy2`: VideoPhy-2 AutoEval (Bansal et al. 2025, arXiv 2503.06800), by the ``inference.py`` of its repository.
- `phyjudge`: PhyJudge-9B of PhyGround (arXiv 2605.10806), by the ``infer.py`` beside its weights.
- `served`: any model with eyes behind a chat server, asked the same two questions about frames of the clip.
"""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from pydantic import Field

from physagent_jax.agents.llm.structured import ask
from physagent_jax.chat.base import ChatMessage, ChatModel
from physagent_jax.core.errors import UserError
from physagent_jax.core.foreign_python import Foreign, find_python, run_python
from physagent_jax.core.reading import shorten
from physagent_jax.core.registry import Choice, Registry
from physagent_jax.core.strict import Strict
from physagent_jax.run.key_frames import VideoKeyFrames

ADHERENCE, COMMONSENSE = "semantic adherence", "physical commonsense"
LEAST, MOST = 1, 5
FRAMES = 16
"""Frames that a served model is shown."""

Scores = Mapping[str, float]
Clips = Sequence[tuple[Path, str]]
"""Videos and their sentences."""


class VideoJudge(Protocol):
    """A judge of videos; ``name`` says which, with its weights."""

    name: str

    def judge(self, clips: Clips) -> list[Scores]:
        """Scores of each clip, by what they are of.

        Raises:
            UserError: It cannot be run, or answers something else.
        """
        ...


@dataclasses.dataclass(frozen=True)
class _Program:
    """A judge that another Python runs.

    Args:
        folder: Folder of its program.
        python: Python that has its packages.
        timeout: Longest time of one start [s].

    Raises:
        UserError: Program or Python are missing.
    """

    folder: str
    python: str | None = None
    timeout: float = 3600.0

    script = ""
    title = ""

    def __post_init__(self):
        if not (self._folder / self.script).is_file():
            do = f"Give `folder`: a folder with {self.script}"
            raise UserError(f"{self.title} is not there", got=shorten(repr(self.folder)), do=do)
        find_python(self.python, self._told, "a path like /path/venv/bin/python")
        if not 0 < self.timeout <= 86_400:
            raise UserError("`timeout` must be above 0 and at most 86400 s", got=self.timeout)

    @property
    def _folder(self) -> Path:
        return Path(self.folder).expanduser()

    @property
    def _told(self) -> Foreign:
        return Foreign(self.title)

    def _run(self, *arguments: str) -> str:
        return run_python(
            find_python(self.python, self._told, ""),
            [self.script, *arguments],
            told=self._told,
            folder=self._folder,
            timeout=self.timeout,
        )


@dataclasses.dataclass(frozen=True)
class VideoPhy2(_Program):
    """VideoPhy-2 AutoEval: semantic adherence and physical commonsense; ``weights`` is its folder of weights."""

    weights: str = ""

    script = "inference.py"
    title = "VideoPhy-2 AutoEval"
    _tasks = (("sa", ADHERENCE), ("pc", COMMONSENSE))

    def __post_init__(self):
        super().__post_init__()
        if not Path(self.weights).expanduser().is_dir() or not self.weights:
            raise UserError(
                f"the weights of {self.title} are not there",
                got=repr(self.weights),
                do="Give `weights`: the folder videophy_2_auto",
            )

    @property
    def name(self) -> str:
        """The judge and its folder of weights."""
        return f"videophy2:{Path(self.weights).expanduser().resolve().name}"

    def judge(self, clips: Clips) -> list[Scores]:
        """Two starts of its program, each with all clips; see `VideoJudge`."""
        found: list[dict[str, float]] = [{} for _ in clips]
        with tempfile.TemporaryDirectory() as folder:
            asked = Path(folder, "asked.csv")
            with asked.open("w", newline="") as file:
                rows = [(str(video.resolve()), sentence) for video, sentence in clips]
                csv.writer(file).writerows([("videopath", "caption"), *rows])
            for task, score in self._tasks:
                answer = Path(folder, f"{task}.csv")
                checkpoint = str(Path(self.weights).expanduser().resolve())
                files = ["--input_csv", str(asked), "--output_csv", str(answer)]
                self._run(*files, "--checkpoint", checkpoint, "--task", task)
                for scores, value in zip(found, self._read(answer, len(clips))):
                    scores[score] = value
        return list(found)

    def _read(self, answer: Path, count: int) -> list[float]:
        """The column ``score`` of an answer: as many rows as clips."""
        if not answer.is_file():
            raise UserError(f"{self.title} wrote no {answer.name}")
        with answer.open(newline="") as file:
            rows = list(csv.DictReader(file))
        if len(rows) != count:
            raise UserError(f"{self.title} must answer {count} clips", got=len(rows))
        return [check_score(row.get("score"), self.title) for row in rows]


@dataclasses.dataclass(frozen=True)
class PhyJudge(_Program):
    """PhyJudge-9B: prompt alignment, temporal order, persistence, and laws of solids; a start for each."""

    script = "infer.py"
    title = "PhyJudge"
    _metrics = (("SA", ADHERENCE), ("PTV", "temporal order"), ("persistence", "persistence"))
    _laws = ("gravity", "inertia", "impenetrability", "material")

    @property
    def name(self) -> str:
        """The judge and its folder."""
        return f"phyjudge:{self._folder.resolve().name}"

    def judge(self, clips: Clips) -> list[Scores]:
        """See `VideoJudge`."""
        asked = [("--metric", key, score) for key, score in self._metrics]
        asked += [("--law", law, law) for law in self._laws]
        return [
            {score: self._ask(video, sentence, option, key) for option, key, score in asked}
            for video, sentence in clips
        ]

    def _ask(self, video: Path, sentence: str, option: str, key: str) -> float:
        """The number in the last JSON object that it prints."""
        where = ["--adapter-dir", str(self._folder.resolve()), "--video", str(video.resolve())]
        printed = self._run(*where, "--caption", sentence, option, key)
        for each in reversed(re.findall(r"\{[^{}]*\}", printed)):
            try:
                return check_score(json.loads(each)[key], self.title)
            except (json.JSONDecodeError, KeyError):
                continue
        raise UserError(f"{self.title} must print a JSON object with {key!r}", got=shorten(printed.strip()))


class ServedForm(Strict):
    """A served model's answer.

    Attributes:
        reason: A sentence or two.
        semantic_adherence: How far the clip shows what the sentence says, 1 to 5.
        physical_commonsense: How far it moves as things do, 1 to 5.
    """

    reason: str = Field(default="", max_length=2_000)
    semantic_adherence: int = Field(ge=LEAST, le=MOST)
    physical_commonsense: int = Field(ge=LEAST, le=MOST)


_QUESTION = """You judge a short video, of which you see {count} frames in order, evenly spaced.
The sentence that it should show: {sentence}
semantic_adherence: 5 = the video shows all that the sentence says, 3 = a part of it, 1 = nothing of it.
physical_commonsense: 5 = everything moves, falls, bends and stays as real things do; 1 = nothing does."""


@dataclasses.dataclass(frozen=True)
class ServedJudge:
    """A chat model with eyes.

    Args:
        model: The model.

    Raises:
        UserError: It takes no pictures.
    """

    model: ChatModel

    def __post_init__(self):
        if not self.model.has_eyes:
            raise UserError(f"{self.model.name} takes no pictures", do="Pass --eyes if it does")

    @property
    def name(self) -> str:
        """The model."""
        return f"served:{self.model.name}"

    def judge(self, clips: Clips) -> list[Scores]:
        """See `VideoJudge`; the sentence is quoted, so that it gives no orders.

        Raises:
            AgentError: The model gives no answer, or none that fits.
        """
        return [self._ask(video, sentence) for video, sentence in clips]

    def _ask(self, video: Path, sentence: str) -> Scores:
        frames = VideoKeyFrames(video).pick(FRAMES)
        text = _QUESTION.format(count=len(frames), sentence=json.dumps(sentence))
        message = ChatMessage("user", text, tuple(frame.png for frame in frames))
        form = ask(self.model, [message], ServedForm).value
        return {ADHERENCE: form.semantic_adherence, COMMONSENSE: form.physical_commonsense}


JUDGES = Registry(
    "`--judge`",
    {
        name: f"{__name__}:{made.__name__}"
        for name, made in dict(videophy2=VideoPhy2, phyjudge=PhyJudge).items()
    }
    | {"served": f"{__name__}:ServedJudge"},
)


def make_judge(choice: Choice) -> VideoJudge:
    """The judge of this name, with its options.

    Raises:
        UserError: There is no such judge, it does not have such options, or what it needs is missing.
    """
    return JUDGES.make(choice)


def check_score(value: Any, title: str) -> float:
    """A score within its range.

    Raises:
        UserError: It is none.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not LEAST <= number <= MOST:
        raise UserError(f"a score of {title} must be {LEAST} to {MOST}", got=shorten(repr(value)))
    return number
