"""Point clouds, which hold no Gaussians: recognised so that the message can say what they are and what to do."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import NoReturn

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.formats.ply_gaussians import find_gaussian_properties, find_rgb
from physagent_jax.gaussians.formats.ply_header import parse_ply_head, read_ply_header

_TRAIN = "Train 3D Gaussians on its pictures (gsplat, nerfstudio, INRIA's code) and give their .ply, or give a mesh"
_COLMAP_TITLE = b"# 3D point list with one line of data per point"
_POINT = struct.Struct("<QdddBBBdQ")  # id, position, colour, error, length of the track
_TRACK = 8  # bytes of an entry of the track: two uint32
_FEWEST_POINTS = 3
_FARTHEST = 1e9


class _PointPly:
    """A PLY of points: no faces, and no property of a Gaussian."""

    name = "point cloud PLY"
    suffixes = ()

    def matches(self, head: bytes) -> bool:
        """Return whether a file begins with a header of vertices alone."""
        header = parse_ply_head(head)
        if header is None or find_gaussian_properties(header) is not None:
            return False
        face = header.element("face")
        return face is None or face.count == 0

    def read(self, path: Path, encoding: str | None) -> NoReturn:
        """Refuse the file; see `Format.read`."""
        header, shown = read_ply_header(path), shorten(path)
        vertex = header.element("vertex")
        names = set() if vertex is None else vertex.names
        if vertex is None or not names >= set("xyz"):
            raise UserError(
                f"{shown} holds neither faces nor 3D Gaussians",
                got=f"vertex properties {sorted(names)}",
                do="Give a 3DGS .ply (with f_dc_*, scale_*, rot_*, opacity) or a mesh",
            )
        colours = " with colours" if find_rgb(names) else ""
        raise UserError(
            f"{shown} holds neither faces nor 3D Gaussians: it is a point cloud, as COLMAP and scanners write it",
            got=f"{vertex.count:,} points{colours}",
            do=_TRAIN,
        )


class _ColmapPoints:
    """COLMAP's points3D.txt and points3D.bin."""

    name = "COLMAP points"
    suffixes = ()

    def matches(self, head: bytes) -> bool:
        """Return whether a file begins with COLMAP's title, or with several records of its points."""
        return head.startswith(_COLMAP_TITLE) or _count_records(head) >= _FEWEST_POINTS

    def read(self, path: Path, encoding: str | None) -> NoReturn:
        """Refuse the file; see `Format.read`."""
        raise UserError(
            f"{shorten(path)} holds the points of a COLMAP reconstruction, not 3D Gaussians", do=_TRAIN
        )


PLY_POINTS = _PointPly()
COLMAP_POINTS = _ColmapPoints()


def _count_records(head: bytes) -> int:
    """Number of consecutive records at the beginning that make sense as points; 0 if one does not."""
    if len(head) < 8:
        return 0
    announced, at, found = int.from_bytes(head[:8], "little"), 8, 0
    while at + _POINT.size <= len(head) and found < announced:
        _, *position, _, _, _, error, track = _POINT.unpack_from(head, at)
        sound = all(math.isfinite(v) and abs(v) < _FARTHEST for v in position) and 0 <= error < _FARTHEST
        # A point is seen in two pictures at least.
        if not sound or not 2 <= track < 2**20:
            return 0
        at += _POINT.size + _TRACK * track
        found += 1
    return found
