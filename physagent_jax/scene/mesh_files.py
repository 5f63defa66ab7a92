"""Mesh files as surfaces: one triangle mesh, or parts with their colours."""

from __future__ import annotations

import logging
import warnings
from pathlib import Path

import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.core.reading import read_bytes, shorten
from physagent_jax.scene.config.source import MESH_SUFFIXES, MOST_MESH_BYTES
from physagent_jax.scene.mesh_formats import HEAD_BYTES, MeshPart, Neighbours, find_mesh_format
from physagent_jax.scene.mesh_formats.obj import OBJ, read_groups

# Its loaders log tracebacks of what they survive, which would reach the terminal.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

_WELDED = 1e-5  # of the longest side, within which vertices are one
_MOST_SHELLS, _MOST_OF_ALL = 500, 0.4  # shells; share of the area from which on one is looked at again
_FEWEST_FACES, _MOST_FACES = 4, 500_000  # of a shell; of a mesh whose shells are looked for
_FARTHEST = 1e12  # in the file's units; float32 holds its square


def read_mesh(path: str | Path) -> trimesh.Trimesh:
    """Read a file as one triangle mesh without colours.

    Raises:
        UserError: As `read_parts`.
    """
    vertices, faces = join_parts(read_parts(path))
    return trimesh.Trimesh(vertices, faces, process=True)


def read_parts(path: str | Path) -> list[MeshPart]:
    """Read a file's surfaces, each with its colours.

    The format is found by content. Files that a mesh names (materials, textures, buffers) are read from its own folder
    only. Colours that cannot be had are left out with a warning.

    Raises:
        UserError: The file is missing, of an unknown kind, damaged, or holds no faces; its faces have no area, or
            coordinates that are not finite or beyond sense.
    """
    path = Path(path)
    data = read_bytes(path, most=MOST_MESH_BYTES, what="the mesh file")
    kind, beside = find_mesh_format(data[:HEAD_BYTES], path), Neighbours(path)
    if kind is None:
        raise explain_unknown_name(
            f"the kind of mesh of {shorten(path)}", path.suffix.lower(), (".ply", *MESH_SUFFIXES)
        )
    try:
        with np.errstate(all="ignore"):  # what overflows is found by the check
            parts = [part for part in kind.read(data, path, beside) if len(part.faces)]
            _check_parts(parts, path)
    except UserError:
        raise
    except Exception as error:  # trimesh's loaders raise whatever their parsers meet
        raise UserError(
            f"cannot read the mesh {shorten(path)} as {kind.name}",
            got=shorten(f"{type(error).__name__}: {error}"),
            do="Export it again as .obj or .glb",
        ) from None
    if beside.missing:
        more = len(set(beside.missing)) - 1
        extra = f" ({more} more)" if more else ""
        warnings.warn(f"{path}: colours are left out: {beside.missing[0]}{extra}", stacklevel=2)
    return parts


def read_named_parts(path: str | Path) -> list[MeshPart]:
    """Read a file's surfaces with the names that it gives them; none if the file names no part of itself.

    Raises:
        UserError: As `read_parts`.
    """
    path = Path(path)
    data = read_bytes(path, most=MOST_MESH_BYTES, what="the mesh file")
    if isinstance(find_mesh_format(data[:HEAD_BYTES], path), OBJ):
        try:
            parts = read_groups(data)
        except (ValueError, IndexError) as error:
            got = shorten(f"{type(error).__name__}: {error}")
            raise UserError(
                f"cannot read the groups of {shorten(path)}", got=got, do="Export it again"
            ) from None
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of colours, which are not asked for
            parts = [limb for part in read_parts(path) for limb in part.split()]
    return parts if any(part.names for part in parts) else []


def read_shells(path: str | Path) -> list[MeshPart]:
    """Read the shells of a file: surfaces that touch each other nowhere, whatever the file calls them.

    Vertices at one place are one. A large shell is looked at again: what meets along an edge of more than
    two faces is two then, as a door in its frame. None for what is a single shell, for so many that they are crumbs,
    and for what is as finely meshed as a scan.

    Raises:
        UserError: As `read_parts`.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of colours, which are not asked for
        vertices, faces = join_parts(read_parts(path))
    if len(faces) > _MOST_FACES:
        return []
    step = _WELDED * max(float(np.ptp(vertices, axis=0).max()), 1e-30)
    places = np.unique(np.round(vertices / step).astype(np.int64), axis=0, return_inverse=True)[1].ravel()
    edges = np.sort(places[faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    key, counts = np.unique(edges @ (len(vertices), 1), return_inverse=True, return_counts=True)[1:]
    key = key.ravel()
    order = np.argsort(key, kind="stable")
    pairs = order[counts[key[order]] == 2].reshape(-1, 2) // 3
    links = coo_matrix((np.ones(len(pairs)), pairs.T), 2 * (len(faces),))
    owner = connected_components(coo_matrix((np.ones(len(edges)), edges.T), 2 * (len(vertices),)))[1][
        edges[::3, 0]
    ]
    inner, area = connected_components(links, directed=False)[1], trimesh.triangles.area(vertices[faces])
    inner = np.where(np.bincount(inner)[inner] < _FEWEST_FACES, inner.max() + 1, inner)  # crumbs
    most = np.bincount(owner, area)
    split = (most > _MOST_OF_ALL * area.sum())[owner]
    if len(np.unique(inner[split])) <= _MOST_SHELLS:
        owner = np.where(split, owner.max() + 1 + inner, owner)
    owner = np.unique(owner, return_inverse=True)[1].ravel()
    count = int(owner.max()) + 1
    groups = np.split(faces[np.argsort(owner, kind="stable")], np.cumsum(np.bincount(owner))[:-1])
    return [MeshPart(vertices, group) for group in groups] if 1 < count <= _MOST_SHELLS else []


def join_parts(parts: list[MeshPart]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices, shape (n, 3), and faces, shape (m, 3), of all parts, one after the other."""
    first = np.cumsum([0] + [len(part.vertices) for part in parts])
    return (
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, first)]),
    )


def _check_parts(parts: list[MeshPart], path: Path) -> None:
    shown = shorten(path)
    if not parts:
        raise UserError(f"{shown} holds no faces", do="Give a mesh with triangles, or a 3DGS .ply")
    area = 0.0
    for part in parts:
        vertices, faces = part.vertices, part.faces
        if not (0 <= faces.min() and faces.max() < len(vertices)):
            raise UserError(
                f"the faces of {shown} name vertices that it does not hold",
                got=f"vertex {faces.max()} of {len(vertices)}",
                do="Export it again",
            )
        if not (np.abs(vertices) <= _FARTHEST).all():
            raise UserError(
                f"{shown} has vertices that are not finite, or beyond {_FARTHEST:g}", do="Mend the mesh"
            )
        area += trimesh.triangles.area(vertices[faces]).sum()
    if not (np.isfinite(area) and area > 0):
        raise UserError(f"the faces of {shown} have no finite area", got=area, do="Mend the mesh")
