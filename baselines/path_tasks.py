"""Two tasks of one action: a scene, the force parameters that are sought, and the path that must be met.

A task's target path comes from a hidden force field, simulated in the same scene; a method sees the path
only. What is sought is the continuous part of one action of the skill library: its unit vector and its
magnitude, inside the library's range, so that the result is a force field that agents could have written.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import physagent_jax as pa
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.procedural import make_jelly
from physagent_jax.simulation.trajectory import with_static_step


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

    @property
    def start(self) -> ForceField:
        """The force field that a method begins with."""
        action = Action(
            action_type=self.action_type,
            vector=self.start_vector,
            magnitude=self.start_magnitude,
            active_time=self.active_time,
        )
        return ForceField(default_drop=self.drop, actions=(action,))


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

    def of_force_field(self, force_field: ForceField, frame_count: int) -> pa.ForceFieldParameters:
        """As the numbers of a force field of one action, whose window is kept."""
        known = pa.ForceFieldParameters.of(force_field, frame_count)
        action = dataclasses.replace(known.actions[0], vector=self.direction, magnitude=self.magnitude)
        return dataclasses.replace(known, actions=(action,))

    def projected(self) -> Parameters:
        """The nearest parameters whose magnitude lies in the skill library's range."""
        return Parameters(self.direction * jnp.clip(self.magnitude, MAGNITUDE_MIN, MAGNITUDE_MAX))


@dataclasses.dataclass(frozen=True)
class Task:
    """A task ready to be solved.

    Attributes:
        spec: Its definition.
        build: Makes the scene in which a force field acts.
        scene: The scene with the action that a method begins with; its step is fixed.
        target: Centroid path per frame, frame 0 left out [m], shape (frames - 1, 3).
    """

    spec: TaskSpec
    build: Callable[[ForceField], CompiledScene]
    scene: CompiledScene
    target: jax.Array

    @property
    def substeps(self) -> int:
        """Per frame."""
        return self.scene.substeps

    def centroid_path(self, parameters: Parameters) -> jax.Array:
        """Centroid path under ``parameters`` [m], shape (frames - 1, 3); differentiable."""
        return _compute_path(self.scene, parameters)

    def loss(self, parameters: Parameters) -> jax.Array:
        """Mean squared distance to the target path, in squared body lengths."""
        miss = self.centroid_path(parameters) - self.target
        return (miss**2).sum(-1).mean() / self.scene.body.extent**2

    def force_field(self, parameters: Parameters) -> ForceField:
        """The parameters as the JSON that an agent would have written."""
        begun, frame_count = self.scene.config.force_field, self.scene.config.timing.frame_count
        return parameters.of_force_field(begun, frame_count).to_force_field(begun, frame_count)

    def solution(self, parameters: Parameters) -> CompiledScene:
        """The complete scene with the found force field, and the sentence for the record."""
        scene = self.build(self.force_field(parameters))
        config = scene.config.model_copy(update=dict(prompt=self.spec.prompt))
        return dataclasses.replace(scene, config=config)


def make_task(spec: TaskSpec, folder: Path, *, frame_count: int = 26, particles: int = 1500) -> Task:
    """Builds the scene (a jelly, written to ``folder``) and its target path.

    Coarse on purpose: a gradient costs several rollouts per iteration.

    Args:
        spec: Which task.
        folder: Where the object file goes.
        frame_count: Frames of the clip; fewer make a faster task.
        particles: Particles at most.

    Raises:
        UserError: ``frame_count`` or ``particles`` is out of range.
    """
    path = folder / "jelly.ply"
    folder.mkdir(parents=True, exist_ok=True)
    write_ply(path, make_jelly(0, count=2500))
    jelly = pa.load_object(path, up="+z", kind="jelly", extent=0.8, cells=48, max_particles=particles)

    def build(force_field: ForceField) -> CompiledScene:
        return pa.build_scene(
            jelly,
            force_field=force_field,
            material=dict(youngs_modulus=5e4, poissons_ratio=0.3, density=400.0),
            anchor="none",
            world="free",
            frame_count=frame_count,
            width=320,
            height=240,
        )

    scene = with_static_step(build(spec.start))
    hidden = Parameters.of(spec.hidden_vector, spec.hidden_magnitude)
    return Task(spec, build, scene, _compute_path(scene, hidden))


def _compute_path(scene: CompiledScene, parameters: Parameters) -> jax.Array:
    values = parameters.of_force_field(scene.config.force_field, scene.config.timing.frame_count)
    return pa.trajectory(scene, values, substeps=scene.substeps).centroid(scene.model.mass)[1:]
