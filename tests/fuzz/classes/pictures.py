"""Cameras and Gaussians at the edges: pictures are finite, or the camera is refused."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import Splats
from physagent_jax.render import look_at, render
from physagent_jax.scene.camera import find_viewer_directions, frame_camera, make_reference_camera
from physagent_jax.scene.config import CameraConfig, Domain, Rendering
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw

COUNT, SIZE = 12, 32
PLACES = (0.0, 1.0, -1.0, 1e-6, 1e-12, 1e-30, 0.01, 3.0, 1e3, 1e8, 1e19, 1e30, 3e38, np.nan, np.inf)
ANGLES = (40.0, 1.0001, 149.9, 1e-9, 0.0, -20.0, 179.999, 180.0, 360.0, 1e30, np.nan)


def make(draw: Draw) -> Case:
    """One picture, or one camera of a scene."""
    if draw.chance(0.3):
        return _draw_scene_camera(draw)
    eye = [0.0, -3.0, 0.5] if draw.chance(0.5) else [draw.one(PLACES) for _ in range(3)]
    target = [0.0, 0.0, 0.0] if draw.chance(0.6) else draw.one([eye, [draw.one(PLACES) for _ in range(3)]])
    up = (
        [0.0, 0.0, 1.0]
        if draw.chance(0.6)
        else draw.one([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], eye, [1e30, 0.0, 0.0], [0, 1e-30, 1e-30]])
    )
    fov = 40.0 if draw.chance(0.6) else draw.one(ANGLES)
    splats, changed = _draw_splats(draw)
    what = f"eye {eye}, target {target}, up {up}, fov {fov}; {changed}"

    def act(_):
        camera = look_at(eye, target, up, fov_degrees=fov, width=SIZE, height=SIZE)
        return camera, render(splats, camera)

    return Case(what, act, refusals=(UserError, ValueError), seconds=60.0)


def _draw_splats(draw: Draw) -> tuple[Splats, str]:
    """Twelve Gaussians, some of which are of no ordinary size, place or colour."""
    rng = np.random.default_rng(1)
    arrays = {
        "means": 0.3 * rng.normal(size=(COUNT, 3)),
        "covariances": np.tile([1e-2, 0, 0, 1e-2, 0, 1e-2], (COUNT, 1)),
        "opacities": np.full(COUNT, 0.8),
        "sh": 0.3 * rng.normal(size=(COUNT, 1, 3)),
        "rotations": np.tile(np.eye(3), (COUNT, 1, 1)),
    }
    done = []
    for _ in range(draw.one([0, 1, 1, 2])):
        name, value, whole = draw.one(sorted(arrays)), draw.one(PLACES), draw.chance(0.5)
        arrays[name][slice(None) if whole else draw.randrange(COUNT)] = value
        done.append(f"{name} = {value:g}{'' if whole else ' of one'}")
    with np.errstate(over="ignore"):
        return Splats(**{name: array.astype(np.float32) for name, array in arrays.items()}), ", ".join(
            done
        ) or "usual"


def _draw_scene_camera(draw: Draw) -> Case:
    values: dict = {}
    edges = {
        "azimuth_degrees": (0.0, 90.0, 1e9, -1e300, 1e300),
        "elevation_degrees": (0.0, 88.999, -88.999, 89.0, 90.0, 1e-300),
        "distance": (4.0, 1e-300, 1e-12, 1e-5, 1e30, 1e300),
        "fov_degrees": (40.0, 1.0001, 149.99, 150.0),
        "target": (None, (0.0, 0.0, 0.0), (1e300, 0.0, 0.0), (1e30, 1e30, 1e30), (1e9, 1.0, 1.0)),
    }
    for name in draw.sample(sorted(edges), draw.one([1, 2, 3])):
        values[name] = draw.one(edges[name])
    points = np.random.default_rng(0).normal(size=(20, 3)) * draw.one([1.0, 1e-12, 1e9, 1e300, 0.0])

    def act(_):
        config, pictures = CameraConfig(**values), Rendering(width=SIZE, height=SIZE)
        camera = make_reference_camera(config, pictures, Domain())
        seen = frame_camera(points, config, pictures)
        arrays = [np.asarray(part, np.float32) for part in (camera.viewmat, camera.K)]
        return arrays, find_viewer_directions(config), seen

    return Case(f"a scene's camera {values}", act, refusals=(UserError, ValueError), seconds=60.0)
