"""A task of 200 particles and eight frames, whose target is what a hidden push does."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

import physagent_jax as pa
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.targets import Follow, Path, Target
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.procedural import make_jelly
from physagent_jax.simulation.simulate import simulate_frames

FRAMES = 8


def act(kind: str, vector, magnitude: float = 1.0, window=None) -> ForceField:
    """One action."""
    action = Action(action_type=kind, vector=vector, magnitude=magnitude, active_time=window)  # type: ignore[arg-type]
    return ForceField(actions=(action,))


@dataclasses.dataclass(frozen=True)
class TinyTask:
    spec: Any
    build: Callable[[ForceField], CompiledScene]
    target: Any
    start: ForceField
    frame_count: int
    mass: np.ndarray
    frame_dt: float = 0.04


def play(build, force_field: ForceField) -> np.ndarray:
    scene = build(force_field)
    return np.stack([np.asarray(frame.state.x) for frame in simulate_frames(scene)])


def make_tiny_task(folder, hidden: ForceField, start: ForceField) -> TinyTask:
    path = folder / "jelly.ply"
    write_ply(path, make_jelly(0, count=400))
    jelly = pa.load_object(path, up="+z", kind="jelly", extent=0.8, cells=32, max_particles=200)

    def build(force_field: ForceField) -> CompiledScene:
        """With one camera for all: the product's own follows what the force field will do."""
        return dataclasses.replace(compose(force_field), camera=camera)

    def compose(force_field: ForceField) -> CompiledScene:
        return pa.build_scene(
            jelly,
            force_field=force_field,
            material=dict(youngs_modulus=2e4, poissons_ratio=0.3, density=400.0),
            anchor="none",
            world="free",
            frame_count=FRAMES,
            width=64,
            height=48,
        )

    camera = compose(start).camera
    mass = np.asarray(build(start).model.mass)
    clip = Clip(play(build, hidden), mass, 0.04)
    parts = (None, (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    paths = [np.asarray(clip.centre(part) - clip.centre(part)[0], float) for part in parts]
    places = [Follow(part=part, centres=path.tolist()) for part, path in zip(parts, paths)]  # type: ignore[arg-type]
    target = Target(clauses=(Path(window=(0, FRAMES - 1), places=tuple(places)),))
    spec = SimpleNamespace(name="tiny", sentence="push the jelly to the left", hidden=hidden, expert=hidden)
    return TinyTask(spec, build, target, start, FRAMES, mass)
