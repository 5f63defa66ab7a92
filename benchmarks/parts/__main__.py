"""`python -m benchmarks.parts --data DIR [--json OUT]`: are parts found that no name tells?"""

from __future__ import annotations

import dataclasses
import itertools
import sys
import tempfile
import warnings
from collections.abc import Iterable
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks import harness
from benchmarks.harness import RAW, Job, Row, say
from benchmarks.parts.answers import Answers, Thing, find_file, read_things
from benchmarks.parts.markdown import PAGE
from physagent_jax.agents.context import AgentContext
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.run.brief import make_brief
from physagent_jax.run.chosen_agents import open_agents
from physagent_jax.run.resolve import ResolvedRun, resolve
from physagent_jax.run.spec import ObjectChoice, Overrides, RunSpec
from physagent_jax.scene.body import Body, make_body

HALVES = ("developed with", "held back")
RIGHT = 0.5
"""Overlap (intersection over union) with the answer from which on a part is right."""
_PARTICLES = 6000  # the shape that parts are found in has its own


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Ask for the parts of meshes whose names are taken away."""

    json: Path = RAW / "parts.json"
    """File of the raw rows; those of other parts are kept."""
    data: Path = Path("objects")
    """Folder with the files, looked through with all below it."""
    parts: tuple[str, ...] = HALVES
    """Halves of the objects."""


def main() -> int:
    """Run the command line."""
    import tyro

    command = tyro.cli(Command)
    halves = {half: partial(make_jobs, half, command.data) for half in HALVES}
    return harness.main(command, halves, PAGE)


def make_jobs(half: str, data: Path) -> list[Job]:
    """One per object of a half."""
    return [Job(each.name, partial(ask_thing, each, data)) for each in read_things() if each.half == half]


def ask_thing(thing: Thing, data: Path) -> Iterable[Row]:
    """The rows of an object: one for each form and word."""
    path = find_file(thing, data)
    if path is None:
        raise FileNotFoundError(f"{thing.file.url} is not below {data}")
    answers = Answers(path)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        bare = Path(folder) / f"{thing.name.replace(' ', '_')}.glb"
        answers.write(bare)
        rows = ask_body(thing, answers, *load(thing, bare))
    say(f"{thing.name}: " + "; ".join(f"{r['word']} {r['outcome']} {r['overlap']:.2f}" for r in rows))
    return rows


def load(thing: Thing, path: Path) -> tuple[ResolvedRun, Body]:
    """A run of an object, and the object at rest."""
    chosen, few = ObjectChoice(path=str(path)), Overrides(max_particles=_PARTICLES)
    run = resolve(RunSpec(object=chosen, prompt=f"drop the {thing.name}", overrides=few))
    preset = run.template.preset
    return run, make_body(run.template.source, preset.filling, preset.domain, run.base_dir)


def ask_body(thing: Thing, answers: Answers, run: ResolvedRun, body: Body) -> list[Row]:
    """The rows of an object that is loaded."""
    truth, rows = answers.list_owners(body.placement.to_source(body.shape)), []
    forms = {"mesh": body, "capture": dataclasses.replace(body, surfaces=())}
    for (form, seen), (word, patterns) in itertools.product(forms.items(), thing.parts.items()):
        prompt = f"pull the {word} of the {thing.name} up"
        run = dataclasses.replace(run, spec=run.spec.model_copy(update=dict(prompt=prompt)))
        with open_agents(run.spec, run.base_dir) as agents:
            brief = make_brief(run.template, parts=run.list_parts(seen))
            reply = agents.semantic.compile(AgentContext(prompt, brief, describe_skills())).value
        known = brief.parts
        taken = [known[each.limb] for each in reply.expectations if each.limb is not None]
        mask = np.logical_or.reduce(
            [np.zeros(len(body.shape), bool), *(~make_region_mask(each.rest, body.shape) for each in taken)]
        )
        if not taken and not reply.unknown_parts:
            mask = _find_region(reply, body)
        asked = np.isin(truth, answers.list_fitting(patterns))
        overlap = float((mask & asked).sum() / max((mask | asked).sum(), 1))
        rows.append(
            dict(
                form=form,
                word=word,
                outcome="asked for" if not mask.any() else "right" if overlap >= RIGHT else "wrong",
                overlap=round(overlap, 3),
                unsure=any(each.unsure for each in taken),
                taken=", ".join(
                    each.stands_for or each.label or each.name or each.roles[0] for each in taken
                ),
                share=round(float(asked.mean()), 3),
            )
        )
    return rows


def _find_region(reply, body: Body) -> np.ndarray:
    """The particles that a force or a constraint acts on, where no part is meant; all of them if it says none."""
    acting = [*reply.force_field.actions, *reply.force_field.constraints]
    regions = [region for each in acting if (region := getattr(each, "region", None)) is not None]
    if not regions:
        return np.ones(len(body.shape), bool)
    return np.logical_or.reduce([make_region_mask(each, body.shape) for each in regions])


if __name__ == "__main__":
    sys.exit(main())
