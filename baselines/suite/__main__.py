"""`python -m baselines.suite --out DIR`: draw a suite of tasks into a folder that `baselines.compare --tasks` takes."""

from __future__ import annotations

import dataclasses
import json
import secrets
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import tyro

import physagent_jax as pa
from baselines.suite.drawing import Drawn, commit_seed, draw_task, hash_suite
from baselines.task_files import write_tasks, write_witnesses
from baselines.task_hashes import to_plain
from baselines.tasks import FAMILIES, TaskSpec
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import make_folders, write_text
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class Command:
    """Draw a suite of tasks; the same command goes on where it was stopped."""

    out: Path
    """Folder of <family>.json, witness.json (which no method may see) and suite.json."""
    seed: int | None = None
    """Seed of all that is drawn; default: a secret one, of which the hash is printed and suite.json has it."""
    count: int = 504
    """Number of tasks; a multiple of seven has as many of each family."""
    split: Literal["both", "development", "test"] = "both"
    """Cells (family, object, direction) that tasks are drawn from: twins are in one split."""
    commitment: str = ""
    """Hash that was published before; another seed is refused."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.suite", args=arguments)
    pa.enable_compile_cache()
    try:
        draw_suite(command)
    except UserError as error:
        print(f"baselines: {error}", file=sys.stderr)
        return 2
    return 0


def draw_suite(command: Command) -> tuple[TaskSpec, ...]:
    """Draw the tasks that the folder has not, and write all of them.

    Raises:
        UserError: The folder holds another suite, or the seed is not the one that was committed.
    """
    if command.count < 1:
        raise UserError("there must be at least one task", got=command.count)
    make_folders(command.out)
    about, path = command.out / "suite.json", command.out / "drawn.jsonl"
    before = json.loads(about.read_text("utf-8")) if about.is_file() else {}
    seed = command.seed if command.seed is not None else before.get("seed", secrets.randbits(63))
    if seed < 0:
        raise UserError("a seed is a whole number from 0", got=seed)
    settings = dict(seed=seed, split=command.split)
    if before and {name: before[name] for name in settings} != settings:
        raise UserError(f"{command.out} holds another suite", got=before, do="Give another --out")
    if command.commitment and command.commitment != commit_seed(seed):
        raise UserError("the seed is not the one that was committed", got=commit_seed(seed))
    write_text(about, json.dumps(settings | dict(commitment=commit_seed(seed))) + "\n")
    print(f"commitment {commit_seed(seed)}")
    drawn = list(_draw(command, seed, path))
    specs = tuple(each.spec for each in drawn)
    for family in FAMILIES:
        if own := [spec for spec in specs if spec.family == family]:
            write_tasks(command.out / f"{family}.json", own)
    write_witnesses(command.out / "witness.json", {each.spec.name: each.witness for each in drawn})
    told = settings | dict(commitment=commit_seed(seed), tasks=len(specs), hash=hash_suite(specs))
    write_text(about, json.dumps(told) + "\n")
    tries = Counter({family: sum(d.tries for d in drawn if d.spec.family == family) for family in FAMILIES})
    print(f"{len(specs)} tasks of {sum(tries.values())} draws ({dict(tries)}); hash {told['hash']}")
    return specs


def _draw(command: Command, seed: int, path: Path) -> Iterator[Drawn]:
    lines = path.read_text("utf-8").split("\n")[:-1] if path.is_file() else []  # one that was cut off goes
    write_text(path, "".join(line + "\n" for line in lines))
    split = None if command.split == "both" else command.split
    with tempfile.TemporaryDirectory() as folder, path.open("a", encoding="utf-8") as file:
        for number in range(command.count):
            if number < len(lines):
                fields = json.loads(lines[number])
                spec = TaskSpec.model_validate(fields["spec"])
                yield Drawn(spec, ForceField.model_validate(fields["witness"]), fields["tries"])
                continue
            made = draw_task(seed, number, Path(folder), split)
            told = dict(spec=to_plain(made.spec), witness=to_plain(made.witness), tries=made.tries)
            file.write(json.dumps(told) + "\n")
            file.flush()
            print(f"{number + 1}/{command.count}  {made.spec.name:34s} {made.spec.sentence}", flush=True)
            yield made


if __name__ == "__main__":
    sys.exit(main())
