"""The table of commands, and the small ones."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path
from typing import Literal

import tyro

from physagent_jax.cli.doctor import Doctor
from physagent_jax.cli.inspect import Inspect
from physagent_jax.cli.materials import Materials
from physagent_jax.cli.models import Models
from physagent_jax.cli.plan import Plan
from physagent_jax.cli.run import Run
from physagent_jax.cli.score import Score
from physagent_jax.cli.simulate import ImportPhysGaussian, Simulate
from physagent_jax.cli.study import Study
from physagent_jax.core.errors import UserError

DESCRIPTION = "Physically simulated 4D video from 3D Gaussians and a sentence."


@dataclasses.dataclass(frozen=True)
class Make:
    """Make an object to play with: 3D Gaussians written by seeded code."""

    what: tyro.conf.Positional[Literal["plant", "loaf", "jelly"]]
    """A potted plant, a loaf of bread, or a jelly."""
    out: Path
    """PLY to write; its card is written beside it."""
    seed: int = 0
    """Another seed, another individual."""
    overwrite: bool = False
    """Replace files that hold something else."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.core.files import write_new
        from physagent_jax.gaussians.formats.ply import write_ply
        from physagent_jax.scene.card import ObjectCard
        from physagent_jax.scene.priors import guess_kind
        from physagent_jax.scene.procedural import PROCEDURAL

        if self.out.suffix.lower() != ".ply":
            raise UserError(
                "`--out` must name a .ply file", got=f"{str(self.out)!r}", do="Pass --out object.ply"
            )
        if not 0 <= self.seed < 2**32:
            raise UserError("`--seed` must be at least 0 and below 2^32", got=self.seed)
        ply = io.BytesIO()
        write_ply(ply, PROCEDURAL[self.what](self.seed))
        card = ObjectCard(name=self.what, kind=guess_kind(self.what), up="+z")
        text = card.model_dump_json(indent=2, exclude_none=True) + "\n"
        contents = {self.out: ply.getvalue(), self.out.with_suffix(".card.json"): text.encode()}
        write_new(contents, overwrite=self.overwrite)
        print(self.out)
        return 0


@dataclasses.dataclass(frozen=True)
class Schema:
    """Print the JSON Schema of one of the file formats."""

    what: tyro.conf.Positional[
        Literal[
            "run",
            "scene",
            "force-field",
            "semantic",
            "motion-report",
            "judgement",
            "rewrite",
            "simulation",
            "manifest",
        ]
    ] = "scene"
    """Name of the format."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.agents.schema import Rewrite, SemanticReply
        from physagent_jax.forces.schema import ForceField
        from physagent_jax.motion.schema import Judgement
        from physagent_jax.perception.schema import MotionReport
        from physagent_jax.run.manifest import Manifest
        from physagent_jax.run.spec import RunSpec
        from physagent_jax.scene.config import SceneConfig
        from physagent_jax.simulation.record import SimulationRecord

        formats = {
            "run": RunSpec,
            "scene": SceneConfig,
            "force-field": ForceField,
            "semantic": SemanticReply,
            "motion-report": MotionReport,
            "judgement": Judgement,
            "rewrite": Rewrite,
            "simulation": SimulationRecord,
            "manifest": Manifest,
        }
        print(json.dumps(formats[self.what].model_json_schema(), indent=2))
        return 0


@dataclasses.dataclass(frozen=True)
class Report:
    """Write report.html of a run folder again, for instance after an upgrade."""

    run: tyro.conf.Positional[Path]
    """The run folder."""
    overwrite: bool = False
    """Replace a report.html that is something else."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.report.html import write_report

        print(write_report(self.run, overwrite=self.overwrite))
        return 0


COMMANDS = {
    "inspect": Inspect,
    "run": Run,
    "plan": Plan,
    "simulate": Simulate,
    "make": Make,
    "materials": Materials,
    "models": Models,
    "import-physgaussian": ImportPhysGaussian,
    "schema": Schema,
    "report": Report,
    "score": Score,
    "study": Study,
    "doctor": Doctor,
}
