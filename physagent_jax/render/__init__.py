"""Rendering of splats: camera, projection, tiles, differentiable rasteriser."""

from physagent_jax.render.camera import Camera, look_at
from physagent_jax.render.project import Projected, project
from physagent_jax.render.renderer import (
    Rendering,
    frames_at_once,
    pair_capacity,
    rasterize,
    render,
    render_all,
)

__all__ = [
    "Camera",
    "Projected",
    "Rendering",
    "frames_at_once",
    "look_at",
    "pair_capacity",
    "project",
    "rasterize",
    "render",
    "render_all",
]
