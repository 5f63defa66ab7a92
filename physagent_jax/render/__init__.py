"""Rendering of splats: camera, projection, tiles, differentiable rasteriser."""

from physagent_jax.render.camera import Camera, look_at
from physagent_jax.render.project import Projected, project
from physagent_jax.render.renderer import (
    RenderedImage,
    choose_batch_size,
    choose_pair_capacity,
    rasterize,
    render,
    render_all,
    to_uint8,
)

__all__ = [
    "Camera",
    "Projected",
    "RenderedImage",
    "choose_batch_size",
    "look_at",
    "choose_pair_capacity",
    "project",
    "rasterize",
    "render",
    "render_all",
    "to_uint8",
]
