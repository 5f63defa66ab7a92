"""Meshes as Gaussian clouds: discs sampled on the surface, in the mesh's own colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy.special import spence

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config import SignedAxis
from physagent_jax.scene.mesh_files import join_parts, read_parts
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.placement import find_up_rotation
from physagent_jax.scene.surfels import OPAQUE, bake_light, make_surfels, place_evenly, value_noise

OVERSAMPLING = 3  # random points per point kept
DISC_RADIUS = 0.7  # standard deviation over the mean spacing: the least that leaves no visible gaps
TONE = (0.80, 0.77, 0.72)  # of a surface that declares no colour, sRGB
# Optical flow needs something to follow. A plain box and a plain ball that turn by 45 degrees about the vertical are
# measured 8 degrees wrong, where 7 and 9 are stated; with this grain it is 4 and 6. Twice as much looks like stone.
# Objects with more shape, as a cow, are measured to 2 degrees without any.
GRAIN = 0.04  # share by which that tone varies, too fine and faint to be seen as a pattern
_GRAINS = 40.0  # of them along the longest side
_PLAIN, _LEVELS = 24, 16  # colours at most of a piece that is painted plainly, told apart at so many levels
_MOST_DRAWS = 64  # draws of points, on a surface that is mostly cut out


def gaussians_from_mesh(
    path: str | Path, *, count: int, seed: int = 0, up: SignedAxis = "+z", smooth: bool = True
) -> GaussianCloud:
    """Flat Gaussians on a mesh's surface as perception needs them; arguments and errors as of `sample_mesh`."""
    return sample_mesh(path, count=count, seed=seed, up=up, smooth=smooth)[0]


def sample_mesh(
    path: str | Path, *, count: int, seed: int = 0, up: SignedAxis = "+z", smooth: bool = True
) -> tuple[GaussianCloud, GaussianCloud]:
    """Samples flat Gaussians evenly on a mesh's surface.

    Colours are those that the file declares (textures, colours of vertices and faces, factors). Surfaces without any
    get one quiet tone; they, and pieces of few colours, get a faint grain. Where a texture is transparent there are no
    Gaussians, where it is blended they let through what it does. Light is baked in from the normals.

    Args:
        path: .obj, .ply with faces, .glb, .gltf, .stl or .off.
        count: Number of Gaussians.
        seed: Seed of the sampling and of the grain.
        up: The file's up axis: light comes from above.
        smooth: Whether to shade with interpolated vertex normals rather than face normals.

    Returns:
        ``count`` Gaussians in the file's frame and units, degree-0 SH; and the same without the grain, for people.

    Raises:
        UserError: The file cannot be read, holds no faces, is wholly transparent, or its faces have no area.
    """
    parts = read_parts(path)
    mesh = trimesh.Trimesh(*join_parts(parts), process=False)
    *sampled, area = _sample(mesh, parts, count, seed, shorten(path))
    keep = place_evenly(sampled[0], count)
    points, faces, bary, rgb, grain, alpha = (each[keep] for each in sampled)
    face_normals = _compute_face_normals(mesh.triangles[faces])
    shading = face_normals
    if smooth:
        corners = _find_vertex_normals(parts)[mesh.faces[faces]]
        shading = _normalise((bary[:, :, None] * corners).sum(axis=1), face_normals)
    rgb = rgb * bake_light(shading @ find_up_rotation(up).T)[:, None]
    radius = DISC_RADIUS * np.sqrt(area / count)
    opacity = find_opacity(alpha)
    grained = make_surfels(points, face_normals, radius, rgb * grain[:, None], opacity=opacity)
    if (grain == 1).all():
        return grained, grained
    return grained, make_surfels(points, face_normals, radius, rgb, opacity=opacity)


def find_opacity(alpha: np.ndarray) -> np.ndarray:
    """Opacity of discs that together stop the share ``alpha`` of light, shape (n,).

    Discs of opacity a with a standard deviation of r spacings, strewn at random, let through exp(-2 pi r^2 Li2(a)): the
    logarithm of 1 - a exp(-s^2 / 2), over all of the plane. Li2 is the dilogarithm.
    """
    opacity = np.linspace(0, 1, 513)
    stopped = 1 - np.exp(-2 * np.pi * DISC_RADIUS**2 * spence(1 - opacity))
    return np.minimum(np.interp(alpha, stopped, opacity), OPAQUE)


def _sample(
    mesh: trimesh.Trimesh, parts: list[MeshPart], count: int, seed: int, shown: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """More random points than are wanted, where the surface is not transparent.

    Returns:
        Points, shape (k, 3), their faces, shape (k,), barycentric coordinates, shape (k, 3), colours, shape (k, 3),
        their grain, shape (k,), and their alpha, shape (k,); and the area that they stand for.
    """
    wanted, kept, drawn = OVERSAMPLING * count, [], 0
    for draw in range(_MOST_DRAWS):
        points, faces = trimesh.sample.sample_surface(mesh, wanted, seed=seed + draw)[:2]
        points, faces = np.asarray(points), np.asarray(faces)
        bary = trimesh.triangles.points_to_barycentric(mesh.triangles[faces], points)
        rgb, grain, alpha = _find_colours(parts, faces, bary, points, float(mesh.extents.max()), seed)
        drawn += wanted
        kept.append([each[alpha > 0] for each in (points, faces, bary, rgb, grain, alpha)])
        if (found := sum(len(each[0]) for each in kept)) >= count and (found >= wanted or draw > 0):
            break
    else:
        raise UserError(
            f"{shown} is transparent all over",
            got=f"{found / drawn:.2%} of it is seen",
            do="Mend its textures",
        )
    points, faces, bary, rgb, grain, alpha = (np.concatenate(each)[:wanted] for each in zip(*kept))
    return points, faces, bary, rgb, grain, alpha, float(mesh.area) * found / drawn


def _find_colours(
    parts: list[MeshPart], faces: np.ndarray, bary: np.ndarray, points: np.ndarray, size: float, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colours of points on the joined parts, and the light that the surface stops there.

    Returns:
        Colours in [0, 1], shape (k, 3); factors of the grain, 1 where the file declares many colours, shape (k,);
        share of light that the surface stops, 0 where it is cut out, shape (k,).
    """
    rgb, grain, alpha = np.empty((len(faces), 3)), np.ones(len(faces)), np.ones(len(faces))
    first = np.cumsum([0] + [len(part.faces) for part in parts])
    for part, start, stop in zip(parts, first[:-1], first[1:]):
        mine = (faces >= start) & (faces < stop)
        rgb[mine] = TONE
        if part.look is not None:
            own = faces[mine] - start
            rgba = part.look.evaluate(part.faces[own], own, bary[mine])
            rgb[mine] = rgba[:, :3]
            if part.look.cutoff is not None:
                there = rgba[:, 3] >= part.look.cutoff
                alpha[mine] = there * (rgba[:, 3] if part.look.blended else 1.0)
        levels = (_LEVELS * rgb[mine]).astype(int) @ (1, 2**20, 2**40)  # sorted 20 times faster than rows
        if len(np.unique(levels)) <= _PLAIN:
            grain[mine] = 1 + GRAIN * (2 * value_noise(points[mine], _GRAINS / size, seed, octaves=2) - 1)
    return rgb, grain, alpha


def _find_vertex_normals(parts: list[MeshPart]) -> np.ndarray:
    """Unit normals of the joined parts' vertices, shape (n, 3): the file's own, else means of the faces around."""
    return np.concatenate([_find_part_normals(part) for part in parts])


def _find_part_normals(part: MeshPart) -> np.ndarray:
    # Vertices that differ in nothing but their texture coordinates are one.
    unique, inverse = trimesh.grouping.unique_rows(part.vertices)
    merged = trimesh.Trimesh(part.vertices[unique], inverse[part.faces], process=False)
    own = np.asarray(merged.vertex_normals)[inverse]
    return own if part.normals is None else _normalise(part.normals, own)


def _compute_face_normals(triangles: np.ndarray) -> np.ndarray:
    return _normalise(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), None)


def _normalise(vectors: np.ndarray, otherwise: np.ndarray | None) -> np.ndarray:
    """Unit vectors, shape (n, 3); those of no length are replaced, by default with +z."""
    replacement = np.array([0.0, 0.0, 1.0]) if otherwise is None else otherwise
    length = np.linalg.norm(np.nan_to_num(vectors), axis=1, keepdims=True)
    safe = length > (0 if otherwise is None else 1e-6)
    return np.where(safe, np.nan_to_num(vectors) / np.where(safe, length, 1), replacement)
