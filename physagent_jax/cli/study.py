"""`physagent study`: a user study of finished runs."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path
from typing import Annotated

import tyro

from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class Build:
    """Make a study: one page of blind forced choices, which works without a network, and codes for participants."""

    results: tyro.conf.Positional[tuple[str, ...]]
    """Folders of the methods, as FOLDER or NAME=FOLDER: run folders below, or NAME.mp4 with the sentence in NAME.txt.
    What has the same path below them is compared; its parent is the family."""
    out: Path
    """Folder of the study."""
    participants: int = 20
    """Number of participants that the design is balanced for, and of codes."""
    sets: int | None = None
    """Number of sets for each participant; default: every item once."""
    alternatives: int = 3
    """Number of clips side by side."""
    open: bool = False
    """Let anybody with the page vote, once per browser, instead of those with a code."""
    seed: int = 0
    """Seed of the design."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.study.build import build_study
        from physagent_jax.study.schema import CODES, PAGE, PLAN

        ranges = {"participants": (1, 1000), "sets": (1, 1000), "alternatives": (2, 6)}
        for name, (least, most) in ranges.items():
            if (value := getattr(self, name)) is not None and not least <= value <= most:
                raise UserError(f"`--{name}` must be between {least} and {most}", got=value)
        if len(self.results) < self.alternatives:
            raise UserError(
                "there are fewer methods than a set has clips", got=len(self.results), do="Name more folders"
            )
        study, balance, notes = build_study(
            self.results,
            self.out,
            participants=self.participants,
            sets=self.sets,
            alternatives=self.alternatives,
            open_=self.open,
            seed=self.seed,
        )
        print("\n".join(notes), end="\n" if notes else "")
        print(
            f"{len(study.items)} items, {len(study.methods)} methods, {len(study.sheets)} sheets of "
            f"{len(study.sheets[0].sets)} sets. Over all sheets a method is shown {_span(balance.shown)} times, in "
            f"each place {_span(balance.places)} times, beside each other {_span(balance.pairs)} times."
        )
        print(
            f"{self.out / PAGE} is for participants"
            + ("." if self.open else f"; each gets one line of {CODES}.")
        )
        print(f"{self.out / PLAN} says whose each clip is: keep it to yourself.")
        return 0


@dataclasses.dataclass(frozen=True)
class Serve:
    """Show the page to participants and store their votes. No name, address or log is kept."""

    folder: tyro.conf.Positional[Path]
    """Folder of the study."""
    host: str = "127.0.0.1"
    """Address to listen at; 0.0.0.0 reaches other machines."""
    port: int = 8000
    """Port; 0 takes a free one."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.study.serve import make_server

        with make_server(self.folder, self.host, self.port) as server:
            print(f"http://{self.host}:{server.server_address[1]}/ (Ctrl-C stops); append #CODE", flush=True)
            server.serve_forever()
        return 0


@dataclasses.dataclass(frozen=True)
class Analyse:
    """Count votes: preference rates, Bradley-Terry strengths, agreement of raters with each other and our judge."""

    folder: tyro.conf.Positional[Path]
    """Folder of the study; its votes/ is read."""
    votes: tyro.conf.Positional[tuple[Path, ...]] = ()
    """Further files of votes that participants sent."""
    json: Path | None = None
    """File for all results."""
    overwrite: bool = False
    """Replace a file that holds something else."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.core.files import write_new
        from physagent_jax.study.analysis import analyse_study, write_summary
        from physagent_jax.study.schema import VOTES, collect_ballots, read_study

        study = read_study(self.folder)
        files = [*sorted((self.folder / VOTES).glob("*.json")), *self.votes]
        ballots, faults = collect_ballots(files, study)
        for fault in faults:
            print(f"not counted: {fault}", file=sys.stderr)
        if not ballots:
            raise UserError(
                f"there are no votes in {self.folder / VOTES}",
                got=f"{len(files)} files",
                do="Let people vote",
            )
        result = analyse_study(study, ballots) | {"not_counted": faults}
        if self.json is not None:
            write_new({self.json: (json.dumps(result, indent=1) + "\n").encode()}, overwrite=self.overwrite)
        print(write_summary(result))
        return 0


@dataclasses.dataclass(frozen=True)
class Study:
    """User study: build a page of forced choices from results, serve it, analyse the votes."""

    step: Annotated[
        Annotated[Build, tyro.conf.subcommand("build")]
        | Annotated[Serve, tyro.conf.subcommand("serve")]
        | Annotated[Analyse, tyro.conf.subcommand("analyse")],
        tyro.conf.arg(name=""),
    ]
    """Step of the study."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        return self.step()


def _span(ends: tuple[int, int]) -> str:
    return str(ends[0]) if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"
