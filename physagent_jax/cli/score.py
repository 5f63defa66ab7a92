"""`physagent score`: verdicts of finished runs beside the scores that video judges of others give them."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class Score:
    """Let a video judge of somebody else score finished runs, and print its scores beside our verdicts.

    Scores are 1 to 5; higher is better. `videophy2` and `phyjudge` are programs with weights of their own
    (`physagent models` says where from), which another Python runs. `served` asks a chat model that takes pictures.
    """

    runs: tyro.conf.Positional[tuple[Path, ...]]
    """Run folders."""
    judge: Literal["videophy2", "phyjudge", "served"]
    """Name of the judge."""
    folder: Path | None = None
    """Folder with the judge's program: inference.py of VideoPhy-2, or infer.py beside PhyJudge's weights."""
    weights: Path | None = None
    """Folder with the weights of `videophy2`."""
    python: str | None = None
    """Python that has the judge's packages."""
    timeout: float = 3600.0
    """Longest time of one start of the judge's program [s]."""
    llm: str | None = None
    """Server, file or folder of the model for `served`, as in `physagent run`."""
    model: str | None = None
    """Its name, for a server."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print JSON instead of a table."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.run.finished import open_run
        from physagent_jax.run.store import VIDEO
        from physagent_jax.run.video_judges import make_judge

        if not self.runs:
            raise UserError("no run folder is named", do="Name one at least")
        runs = [open_run(folder) for folder in self.runs]
        clips = [(run.require(run.video, VIDEO), run.prompt) for run in runs]
        with contextlib.ExitStack() as stack:
            judge = make_judge((self.judge, self._choose_options(stack)))
            scores = judge.judge(clips)
        rows = []
        for folder, run, found in zip(self.runs, runs, scores):
            judgement = run.best.judgement if run.best else None
            ours = dict(verdict=judgement and judgement.verdict.value, score=judgement and judgement.score)
            rows.append(
                dict(run=str(folder), prompt=run.prompt, **ours, judge=judge.name, scores=dict(found))
            )
        print(json.dumps(rows, indent=2) if self.json_line else _write_table(rows))
        return 0

    def _choose_options(self, stack: contextlib.ExitStack) -> dict[str, Any]:
        """The options that are given; those of another judge are refused by it."""
        given = dict(folder=self.folder and str(self.folder), weights=self.weights and str(self.weights))
        options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        if self.judge != "served":
            if self.llm is not None or self.model is not None:
                raise UserError(f"`{self.judge}` asks no chat model", do="Leave out --llm and --model")
            return options | dict(python=self.python, timeout=self.timeout)
        from physagent_jax.chat.registry import make_model
        from physagent_jax.cli.options import choose_model

        chosen = choose_model(self.llm, self.model, None, eyes=self.llm is not None)
        if chosen is None:
            raise UserError("`served` needs a model", do="Pass --llm http://HOST:PORT/v1 --model NAME")
        model = make_model((chosen["name"], chosen["options"]))
        stack.callback(model.close)
        return options | dict(model=model)


def _write_table(rows: list[dict[str, Any]]) -> str:
    """A line per run; ours is the verdict and its score from 0 to 1."""
    lines = [f"judge: {rows[0]['judge']} (1 to 5)"]
    for row in rows:
        ours = "not judged" if row["verdict"] is None else f"{row['verdict']} ({row['score'] or 0:.2f})"
        theirs = ", ".join(f"{name} {value:g}" for name, value in row["scores"].items())
        lines.append(f"{row['run']}: ours {ours}; {theirs}: {row['prompt']}")
    return "\n".join(lines)
