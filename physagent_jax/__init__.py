"""Differentiable Material Point Method simulation of 3D Gaussians, and the closed loop around it.

    import physagent_jax as pa

    robot = pa.load_object("robot.ply")
    scene = pa.build_scene(robot, "push the robot to the left")
    recording = pa.simulate_scene(scene)
    pictures = pa.render_recording(recording, camera)

Nothing heavy is imported before a verb is asked for. Sub-packages, lowest layer first: `core`, `kernels`, `mpm` (the
simulator), `forces` (the force field skill library), `gaussians`, `render`, `scene`, `simulation`, `perception`,
`agents`, `metrics`, `output`, `run` (the loop and its folder).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from physagent_jax.api import LoadedObject as LoadedObject
    from physagent_jax.api import build_scene as build_scene
    from physagent_jax.api import load_object as load_object
    from physagent_jax.api import load_scene as load_scene
    from physagent_jax.api import synthesize as synthesize
    from physagent_jax.forces.parameters import ForceFieldParameters as ForceFieldParameters
    from physagent_jax.forces.schema import ForceField as ForceField
    from physagent_jax.kernels.compile_cache import enable_compile_cache as enable_compile_cache
    from physagent_jax.render.camera import look_at as look_at
    from physagent_jax.run.findings import Inspection as Inspection
    from physagent_jax.run.finished import FinishedRun as FinishedRun
    from physagent_jax.run.finished import open_run as open_run
    from physagent_jax.run.inspection import inspect_object as inspect_object
    from physagent_jax.run.spec import RunSpec as RunSpec
    from physagent_jax.scene.parameters import SceneParameters as SceneParameters
    from physagent_jax.simulation.recording import Recording as Recording
    from physagent_jax.simulation.simulate import simulate_scene as simulate_scene
    from physagent_jax.simulation.trajectory import trajectory as trajectory
    from physagent_jax.simulation.views import render_recording as render_recording

_PLACES = {
    "FinishedRun": "run.finished",
    "ForceField": "forces.schema",
    "ForceFieldParameters": "forces.parameters",
    "Inspection": "run.findings",
    "LoadedObject": "api",
    "Recording": "simulation.recording",
    "RunSpec": "run.spec",
    "SceneParameters": "scene.parameters",
    "build_scene": "api",
    "enable_compile_cache": "kernels.compile_cache",
    "inspect_object": "run.inspection",
    "load_object": "api",
    "load_scene": "api",
    "look_at": "render.camera",
    "open_run": "run.finished",
    "render_recording": "simulation.views",
    "simulate_scene": "simulation.simulate",
    "synthesize": "api",
    "trajectory": "simulation.trajectory",
}
"""Module of each name."""

__all__ = [
    "FinishedRun",
    "ForceField",
    "ForceFieldParameters",
    "Inspection",
    "LoadedObject",
    "Recording",
    "RunSpec",
    "SceneParameters",
    "__version__",
    "build_scene",
    "enable_compile_cache",
    "inspect_object",
    "load_object",
    "load_scene",
    "look_at",
    "open_run",
    "render_recording",
    "simulate_scene",
    "synthesize",
    "trajectory",
]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
