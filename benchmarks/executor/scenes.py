"""Small scenes, simulated and measured by their particles; nothing is rendered."""

from __future__ import annotations

import dataclasses
import tempfile
import warnings
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.rules.executor import RuleExecutor
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.metrics.true_report import report_true_motion
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief
from physagent_jax.perception.schema import MotionReport
from physagent_jax.render.camera import Camera
from physagent_jax.run.brief import make_brief
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import CameraConfig, SceneConfig
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.procedural import make_jelly, make_loaf, make_plant
from physagent_jax.scene.standing import Support, make_stand
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.simulation.simulate import simulate_frames

ROBOT = Path(__file__).resolve().parents[2] / "examples" / "assets" / "robot.ply"
MADE = {"jelly": make_jelly, "loaf": make_loaf, "plant": make_plant}
STIFFNESS = {"robot": 8e4, "jelly": 2e4, "loaf": 3e4, "plant": 8e4, "bar": 3e4}  # E [Pa]
DENSITY = 400.0  # [kg/m^3]
PARTICLES, CELLS, WIDTH, HEIGHT = 5000, 64, 320, 240


class NoPictures:
    """Key frames of what was not rendered."""

    def pick(self, most: int = 6):
        """None."""
        del most
        return ()


@dataclasses.dataclass(frozen=True)
class Setting:
    """An object in a world, ready for force fields.

    Attributes:
        template: The scene without its force field.
        body: The object at rest.
        brief: What agents are told.
    """

    template: SceneTemplate
    body: Body
    brief: SceneBrief

    def simulate(self, field: ForceField, camera: CameraConfig | None = None) -> Clip:
        """The particles' motion under ``field``; seen by the ``camera`` of the round before, if that shows it."""
        config = fuse(self.template, self.body, field, keep=camera)
        scene = compile_scene(config, self.body)
        frames = list(simulate_frames(scene))
        x = np.stack([np.asarray(frame.state.x, np.float64)[scene.back] for frame in frames])
        stopped = int(frames[-1].state.stopped)
        low, high = min(f.min_J for f in frames[1:]), max(f.max_J for f in frames[1:])
        return Clip(config, scene.camera, x, stopped, low, high)


@dataclasses.dataclass(frozen=True)
class Clip:
    """Outcome of a force field.

    Attributes:
        config: The scene.
        camera: Its reference camera.
        x: Particles per frame [m], shape (T, n, 3).
        stopped: How often a particle was stopped at the domain's faces.
        min_J, max_J: Extremes of det F.
    """

    config: SceneConfig
    camera: Camera
    x: np.ndarray
    stopped: int
    min_J: float
    max_J: float

    def report(self, windows: Sequence[tuple[int, int]] = ()) -> MotionReport:
        """Report that perfect perception would give."""
        return report_true_motion(
            self.x, frame_dt=self.config.timing.frame_dt, camera=self.camera, windows=windows
        )


@cache
def prepare(name: str, world: str = "free") -> Setting:
    """An object in a world; the same for all clips of a process."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", UserWarning
        )  # of few particles per cell: these scenes are small on purpose
        path = ROBOT
        if name in MADE:
            path = Path(folder) / f"{name}.ply"
            write_ply(path, MADE[name](0))
        spec = RunSpec.model_validate(
            {
                "object": {"path": str(path)},
                "prompt": "-",
                "world": world,
                "material": {"youngs_modulus": STIFFNESS[name], "density": DENSITY},
                "overrides": {
                    "max_particles": PARTICLES, "cells": CELLS, "width": WIDTH, "height": HEIGHT,
                },
            }
        )  # fmt: skip
        template = resolve(spec).template
        body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
        template, _ = make_stand(template, body, Support(keep_material=True, let_go=True))
    return Setting(template, body, make_brief(template))


@dataclasses.dataclass(frozen=True)
class Attempt:
    """One round, and the rewrite that led to the next.

    Attributes:
        round: Field, report and judgement.
        clip: What was simulated; None if it could not be.
        rewrite: The executor's answer; None after the last.
    """

    round: Round
    clip: Clip | None
    rewrite: Rewrite | None = None


def run_rounds(
    setting: Setting, sentence: str, expected: tuple[ExpectedMotion, ...], field: ForceField, most: int
) -> list[Attempt]:
    """The loop with perfect perception: the planner judges the truth, the executor reads it."""
    reading = SemanticReply(force_field=field, expectations=expected)
    planner, executor = RulePlanner(), RuleExecutor()
    attempts: list[Attempt] = []
    camera: CameraConfig | None = None
    for number in range(most):
        rounds = tuple(attempt.round for attempt in attempts)
        context = AgentContext(sentence, setting.brief, describe_skills(), reading, rounds)
        try:
            clip = setting.simulate(field, camera)
        except UserError:
            break  # what cannot be simulated is no success, and there is nothing to be learned from it
        camera = clip.config.camera
        seen = Observation(field, clip.report(list(planner.windows(context))), NoPictures())
        judgement = planner.judge(context, seen).value
        attempt = Attempt(Round(field, seen.report, seen.key_frames, judgement), clip)
        attempts.append(attempt)
        if judgement.verdict == "SUCCESS" or number + 1 == most:
            break
        rewrite = executor.rewrite(context, attempt.round).value
        attempts[-1] = dataclasses.replace(attempt, rewrite=rewrite)
        if rewrite.force_field == field:
            break
        field = rewrite.force_field
    return attempts
