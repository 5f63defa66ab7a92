"""Meshes as Gaussian clouds: discs sampled on the surface, with the mesh's colours or painted ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config import SignedAxis
from physagent_jax.scene.mesh_files import read_mesh
from physagent_jax.scene.placement import find_up_rotation
from physagent_jax.scene.surfels import bake_light, make_surfels, place_evenly, value_noise

OVERSAMPLING = 3  # random points per point kept
DISC_RADIUS = 0.7  # standard deviation over the mean spacing: the least that leaves no visible gaps

# Base coats for meshes without colours; the seed picks one.
_COATS = ((0.93, 0.89, 0.82), (0.86, 0.62, 0.43), (0.55, 0.70, 0.80), (0.72, 0.78, 0.52))


def gaussians_from_mesh(
    path: str | Path, *, count: int, seed: int = 0, up: SignedAxis = "+z", smooth: bool = True
) -> GaussianCloud:
    """Samples flat Gaussians evenly on a mesh's surface.

    Colours come from the mesh's texture, vertices or faces; a mesh without any is painted with seeded
    low-frequency patches, because tracking and flow need texture. Light is baked in from the normals.

    Args:
        path: .obj, .ply with faces, .glb, .gltf, .stl or .off.
        count: Number of Gaussians.
        seed: Seed of the sampling and the painting.
        up: The file's up axis: light comes from above.
        smooth: Whether to shade with interpolated vertex normals rather than face normals.

    Returns:
        ``count`` Gaussians in the file's frame and units, degree-0 SH.

    Raises:
        UserError: The file cannot be read, holds no faces, or its faces have no area.
    """
    mesh = read_mesh(path)
    points, faces = trimesh.sample.sample_surface(mesh, OVERSAMPLING * count, seed=seed)[:2]
    keep = place_evenly(np.asarray(points), count)
    points, faces = np.asarray(points)[keep], np.asarray(faces)[keep]
    bary = trimesh.triangles.points_to_barycentric(mesh.triangles[faces], points)
    face_normals = np.asarray(mesh.face_normals)[faces]
    shading = face_normals
    if smooth:
        corners = np.asarray(mesh.vertex_normals)[mesh.faces[faces]]
        shading = (bary[:, :, None] * corners).sum(axis=1)
        length = np.linalg.norm(shading, axis=1, keepdims=True)
        shading = np.where(length > 1e-6, shading / np.maximum(length, 1e-6), face_normals)
    rgb = _read_colours(mesh, faces, bary)
    if rgb is None:
        rgb = _paint(points, shading, float(mesh.extents.max()), seed)
    rgb = rgb * bake_light(shading @ find_up_rotation(up).T)[:, None]
    radius = DISC_RADIUS * np.sqrt(mesh.area / count)
    return make_surfels(points, face_normals, radius, rgb)


def _read_colours(mesh: trimesh.Trimesh, faces: np.ndarray, bary: np.ndarray) -> np.ndarray | None:
    """The mesh's own colours at the samples in [0, 1], shape (n, 3); None if it has none."""
    visual: Any = mesh.visual
    if visual.kind == "texture":
        return _read_texture_colours(visual, mesh.faces[faces], bary)
    if visual.kind == "vertex":
        corners = np.asarray(visual.vertex_colors)[mesh.faces[faces], :3]
        return (bary[:, :, None] * corners).sum(axis=1) / 255
    if visual.kind == "face":
        return np.asarray(visual.face_colors)[faces, :3] / 255
    return None


def _read_texture_colours(visual: Any, corners: np.ndarray, bary: np.ndarray) -> np.ndarray | None:
    """Texture looked up at the samples; None if there is but the grey or white that loaders put in for want of one."""
    material = visual.material
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None:
        pixels = np.asarray(material.main_color, np.float64).reshape(1, 1, -1)[..., :3] / 255
    else:
        pixels = np.asarray(image.convert("RGB"), np.float64) / 255
    if np.ptp(pixels) < 1e-6:
        return None
    at = (bary[:, :, None] * np.asarray(visual.uv)[corners]).sum(axis=1) % 1.0
    column = np.minimum((at[:, 0] * pixels.shape[1]).astype(int), pixels.shape[1] - 1)
    row = np.minimum(((1 - at[:, 1]) * pixels.shape[0]).astype(int), pixels.shape[0] - 1)
    return pixels[row, column]


def _paint(points: np.ndarray, normals: np.ndarray, size: float, seed: int) -> np.ndarray:
    """A pale coat with dark patches like a cow's, and fine grain; shape (n, 3)."""
    coat = np.asarray(_COATS[seed % len(_COATS)])
    patches = value_noise(points, 4.0 / size, seed + 1, octaves=2)
    grain = value_noise(points, 40.0 / size, seed + 2, octaves=2)
    edge = np.clip((patches - 0.56) / 0.03 + 0.5, 0, 1)[:, None]
    dark = 0.28 * coat + np.array([0.02, 0.0, 0.0])
    return ((1 - edge) * coat + edge * dark) * (0.86 + 0.28 * grain[:, None])
