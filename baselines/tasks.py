"""Benchmark tasks: a scene, the force parameters that are sought, and the path that must be met.

A task's target path comes from a hidden force field, simulated in the same scene; a method sees the path
only. What is sought is the continuous part of one action of the skill library: its unit vector and its
magnitude, inside the library's range, so that the result is a force field that agents could have written.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from pydantic import ValidationError

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.core.reading import validation_message
from physagent_jax.forces.schema import MAGNITUDE_MAX, MAGNITUDE_MIN, Action, ActionType, ForceField
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.mpm import Grid, rollout, stable_dt
from physagent_jax.mpm.timestep import substeps_for
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.config import (
    Anchor,
    CameraConfig,
    Domain,
    Filling,
    Material,
    Rendering,
    SceneConfig,
    Source,
    Timing,
    Transfer,
)
from physagent_jax.scene.fuse import SceneTemplate, fuse
from physagent_jax.scene.presets import Preset
from physagent_jax.scene.procedural import make_jelly


@dataclasses.dataclass(frozen=True)
class TaskSpec:
    """What distinguishes one task from another.

    Attributes:
        name: For the command line.
        prompt: The task as a sentence, for the record.
        action_type: The skill whose vector and magnitude are sought.
        active_time: Its window in frames; None = the whole clip.
        drop: Whether gravity acts.
        hidden_vector, hidden_magnitude: The force field that made the target.
        start_vector, start_magnitude: Where a method begins.
    """

    name: str
    prompt: str
    action_type: ActionType
    active_time: tuple[float, float] | None
    drop: bool
    hidden_vector: tuple[float, float, float]
    hidden_magnitude: float
    start_vector: tuple[float, float, float]
    start_magnitude: float


TASKS = {
    "push": TaskSpec(
        name="push",
        prompt="push the jelly to the left and a little up",
        action_type=ActionType.TRANSLATION,
        active_time=None,
        drop=False,
        hidden_vector=(-0.9, 0.1, 0.4),
        hidden_magnitude=1.3,
        start_vector=(0.3, 0.5, 0.1),
        start_magnitude=0.8,
    ),
    "drop": TaskSpec(
        name="drop",
        prompt="drop the jelly and hit it to the left while it falls",
        action_type=ActionType.IMPULSE,
        active_time=(2, 4),
        drop=True,
        hidden_vector=(-0.8, 0.5, 0.0),
        hidden_magnitude=1.4,
        start_vector=(0.4, 0.3, 0.2),
        start_magnitude=0.8,
    ),
}


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Parameters:
    """The sought force as one vector: its length is the magnitude M, its direction the action's vector.

    Displacements are linear in it while nothing is touched, which suits a gradient method.

    Attributes:
        push: M v, shape (3,).
    """

    push: jax.Array

    @staticmethod
    def of(vector, magnitude: float, dtype=np.float32) -> Parameters:
        """The parameters of a given action; ``vector`` need not be of unit length."""
        vector = np.asarray(vector, float)
        return Parameters(jnp.asarray(magnitude * vector / np.linalg.norm(vector), dtype))

    @property
    def magnitude(self) -> jax.Array:
        """M."""
        return jnp.linalg.norm(self.push)

    @property
    def direction(self) -> jax.Array:
        """Unit vector, shape (3,)."""
        return self.push / self.magnitude

    def projected(self) -> Parameters:
        """The nearest parameters whose magnitude lies in the skill library's range."""
        return Parameters(self.direction * jnp.clip(self.magnitude, MAGNITUDE_MIN, MAGNITUDE_MAX))


@dataclasses.dataclass(frozen=True)
class Task:
    """A task ready to be solved.

    Attributes:
        spec: Its definition.
        ingredients, body: For fusing the solution into a scene like any other.
        scene: The scene without any action.
        substeps: Per frame.
        target: Centroid path per frame, frame 0 left out [m], shape (frames - 1, 3).
    """

    spec: TaskSpec
    ingredients: SceneTemplate
    body: Body
    scene: CompiledScene
    substeps: int
    target: jax.Array

    def centroid_path(self, parameters: Parameters) -> jax.Array:
        """Centroid path under ``parameters`` [m], shape (frames - 1, 3); differentiable."""
        return _path(self.spec, self.scene, self.substeps, parameters)

    def loss(self, parameters: Parameters) -> jax.Array:
        """Mean squared distance to the target path, in squared body lengths."""
        miss = self.centroid_path(parameters) - self.target
        return (miss**2).sum(-1).mean() / self.body.extent**2

    def force_field(self, parameters: Parameters) -> ForceField:
        """The parameters as the JSON that an agent would have written."""
        action = Action(
            action_type=self.spec.action_type,
            vector=tuple(np.asarray(parameters.direction, float).tolist()),
            magnitude=float(np.clip(parameters.magnitude, MAGNITUDE_MIN, MAGNITUDE_MAX)),
            active_time=self.spec.active_time,
        )
        return ForceField(default_drop=self.spec.drop, actions=(action,))

    def solution(self, parameters: Parameters) -> SceneConfig:
        """The complete scene with the found force field."""
        return fuse(self.ingredients, self.body, self.force_field(parameters))


def make_task(spec: TaskSpec, folder: Path, *, frame_count: int = 26, particles: int = 1500) -> Task:
    """Builds the scene (a jelly, written to ``folder``) and its target path.

    Args:
        spec: Which task.
        folder: Where the object file goes.
        frame_count: Frames of the clip; fewer make a faster task.
        particles: Particles at most.

    Raises:
        UserError: ``frame_count`` or ``particles`` is out of range.
    """
    try:
        preset = _preset(frame_count, particles)
    except ValidationError as error:
        raise validation_message(error, "the task", do="Choose another --frames or --particles") from None
    path = folder / "object.ply"
    folder.mkdir(parents=True, exist_ok=True)
    write_ply(path, make_jelly(0, count=2500))
    ingredients = SceneTemplate(
        prompt=spec.prompt,
        preset_name="baseline",
        preset=preset,
        source=Source(path=str(path.resolve()), name="jelly", kind="jelly", extent=0.8),
        material=Material(youngs_modulus=5e4, poissons_ratio=0.3, density=400.0, reason="benchmark task"),
        anchor=Anchor(reason="benchmark task"),
        camera=CameraConfig(),
    )
    body = make_body(ingredients.source, preset.filling, preset.domain, folder)
    scene = compile_scene(fuse(ingredients, body, ForceField(default_drop=spec.drop)), body, folder)
    scene, substeps = _with_static_grid(scene)
    hidden = Parameters.of(spec.hidden_vector, spec.hidden_magnitude)
    return Task(spec, ingredients, body, scene, substeps, _path(spec, scene, substeps, hidden))


def _preset(frame_count: int, particles: int) -> Preset:
    """Coarse on purpose: a gradient costs several rollouts per iteration."""
    return Preset(
        Domain(size=4.0, cells=48),
        Filling(max_particles=particles),
        Timing(frame_count=frame_count, frame_dt=0.04),
        Transfer(),
        Rendering(width=320, height=240),
    )


_SAFETY = 0.5  # of the bound at rest; a static step must also bear the squeeze on landing


def _with_static_grid(scene: CompiledScene) -> tuple[CompiledScene, int]:
    """A rollout under differentiation cannot move its window or change its step: both are fixed here."""
    domain, timing = scene.config.domain, scene.config.timing
    substeps = substeps_for(timing.frame_dt, _SAFETY * float(stable_dt(scene.model, scene.state)))
    dt = jnp.asarray(timing.frame_dt / substeps, scene.state.x.dtype)
    model = scene.model.replace(grid=Grid.whole(domain.size, domain.cells), dt=dt)
    return dataclasses.replace(scene, model=model), substeps


def _path(spec: TaskSpec, scene: CompiledScene, substeps: int, parameters: Parameters) -> jax.Array:
    model = scene.model
    _, states = rollout(
        model.replace(forces=(*model.forces, _force(spec, scene, parameters))),
        scene.state,
        frame_count=scene.config.timing.frame_count - 1,
        substeps=substeps,
    )
    return (states.x * model.mass[:, None]).sum(1) / model.mass.sum()


def _force(spec: TaskSpec, scene: CompiledScene, parameters: Parameters) -> UniformAcceleration:
    """The sought action, as `forces.skills` would compile it, but with differentiable parameters."""
    scaling, timing = scene.config.scaling, scene.config.timing
    assert scaling is not None
    first, last = spec.active_time or (0, timing.frame_count - 1)
    start, end = first * timing.frame_dt, last * timing.frame_dt
    k = scaling.translation if spec.action_type is ActionType.TRANSLATION else scaling.impulse / (end - start)
    dtype = scene.state.x.dtype
    return UniformAcceleration(
        (k * parameters.push).astype(dtype), jnp.asarray(start, dtype), jnp.asarray(end, dtype)
    )
