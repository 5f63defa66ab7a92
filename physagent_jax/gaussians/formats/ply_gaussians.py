"""Gaussians in PLY files of the 3DGS layout and its relatives, told apart by their properties.

All have one ``vertex`` per Gaussian with properties in any order and of any number type: ``x y z``, ``opacity``,
``scale_*`` and ``rot_0..3`` (quaternion wxyz, any norm). They differ in two ways:

- Colours: ``f_dc_0..2`` and ``f_rest_*`` (spherical harmonics, channel-major: all coefficients of red, then green, then
  blue; Kerbl et al. 2023), or ``red green blue``.
- Scales: three, or two for flat Gaussians whose normal is the third local axis (2DGS, Huang et al. 2024).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.encoding import decode, find_stated
from physagent_jax.gaussians.formats.packing import colours_to_sh
from physagent_jax.gaussians.formats.ply_header import PlyHeader, parse_ply_head
from physagent_jax.gaussians.formats.ply_vertices import Vertices, read_vertices

POSITION = ("x", "y", "z")
DC = ("f_dc_0", "f_dc_1", "f_dc_2")
SCALE = ("scale_0", "scale_1", "scale_2")
ROTATION = ("rot_0", "rot_1", "rot_2", "rot_3")
RGB = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))

_MOST_DEGREE = 3
_BEYOND_WHITE = 4.0  # a coefficient of white is 1.8
_FEWEST_COLOURS, _SPREAD = 50, 0.5  # colours from which their spread over [0, 1] says something
_REST_COUNTS = {3 * ((degree + 1) ** 2 - 1): degree for degree in range(7)}  # of `f_rest_*`, by degree


@dataclasses.dataclass(frozen=True)
class GaussianPly:
    """A PLY layout with one Gaussian per vertex.

    Attributes:
        name: The layout's name.
        colours: The kind of its colours: "sh" or "rgb".
        scale_count: Number of scales, 2 or 3.
        suffixes: Usual file name endings.
    """

    name: str
    colours: str = "sh"
    scale_count: int = 3
    suffixes: tuple[str, ...] = (".ply",)

    def matches(self, head: bytes) -> bool:
        """Return whether a file begins with the header of this layout."""
        header = parse_ply_head(head)
        if (
            header is None
        ):  # no sensible header, or one too long for the head: the usual layout's reader says which
            return head.startswith(b"ply") and (self.colours, self.scale_count) == ("sh", 3)
        names = find_gaussian_properties(header)
        if names is None:
            return False
        rgb = find_rgb(names) is not None and not set(DC) & names
        flat = "scale_1" in names and "scale_2" not in names
        return (self.scale_count == 2) == flat and (flat or (self.colours == "rgb") == rgb)

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file; see `Format.read`."""
        vertices = read_vertices(path)
        notes: list[str] = []
        scale_names = SCALE[: self.scale_count]
        rest_names, rgb_names = _check_properties(vertices, scale_names, notes)
        sh, colour_words = (
            _read_rgb(vertices, rgb_names) if rgb_names else _read_sh(vertices, rest_names, notes)
        )
        means = vertices.read_columns(POSITION)
        plain, opacities = _read_opacities(vertices, notes)
        decoded = decode(
            means,
            vertices.read_columns(scale_names),
            opacities,
            shown=vertices.shown,
            given=encoding,
            stated=find_stated(vertices.comments),
            plain_opacities=plain,
        )
        scales = np.pad(decoded.scales, ((0, 0), (0, 3 - self.scale_count)))
        words = [decoded.words, colour_words, f"float{8 * vertices.types['x'].itemsize} positions"]
        if self.scale_count == 2:
            words.insert(1, "flat along the third axis")
        return SplatData(
            means=means,
            quats=_read_rotations(vertices, notes),
            scales=scales,
            opacities=decoded.opacities,
            sh=sh,
            encoding=", ".join(words),
            notes=(*notes, *decoded.notes),
        )


PLY_2DGS = GaussianPly("2DGS PLY", scale_count=2)
PLY_RGB = GaussianPly("RGB splat PLY", colours="rgb")
PLY_3DGS = GaussianPly("3DGS PLY")


def find_gaussian_properties(header: PlyHeader) -> set[str] | None:
    """The vertex properties of a PLY of Gaussians; None if it holds a mesh, points or another layout.

    A file with faces is a mesh, unless its vertices have scales and rotations. One without faces is meant as Gaussians
    if it has any property of theirs: what it lacks is then said.
    """
    vertex, face = header.element("vertex"), header.element("face")
    if vertex is None:
        return set()
    names = vertex.names
    telling = {"scale_0", "rot_0"} & names
    if face is not None and face.count > 0:
        return names if len(telling) == 2 else None
    return names if telling or {"f_dc_0", "opacity"} & names else None


def find_rgb(names: set[str]) -> tuple[str, ...] | None:
    """The names of the properties that hold red, green and blue; None if there are none."""
    return next((each for each in RGB if names >= set(each)), None)


def _check_properties(
    vertices: Vertices, scale_names: Sequence[str], notes: list[str]
) -> tuple[list[str], tuple[str, ...] | None]:
    """The names of the higher SH coefficients in order, and of RGB colours where there are no coefficients.

    Opacity and rotation may be absent as a whole, which is noted; a part of a group is not enough.

    Raises:
        UserError: A property is missing, or the number of coefficients is that of no degree.
    """
    present = set(vertices.types)
    rgb = None if set(DC) & present else find_rgb(present)
    rest_count = 0 if rgb else sum(name.startswith("f_rest_") for name in present)
    rest_names = [f"f_rest_{i}" for i in range(rest_count)]
    needed = [*POSITION, *(rgb or DC), *scale_names, *rest_names]
    if set(ROTATION) & present:
        needed += ROTATION
    missing = [name for name in needed if name not in present]
    if missing:
        listed = (*POSITION, *(rgb or DC), "opacity", *SCALE[: len(scale_names)], *ROTATION, *rest_names)
        raise UserError(
            f"{vertices.shown} is not a 3D Gaussian PLY: it lacks the properties "
            f"{', '.join(name for name in listed if name not in present)}",
            do="Export it from a 3DGS trainer in the INRIA layout (a mesh or a point cloud is not enough)",
        )
    if rest_count not in _REST_COUNTS:
        raise UserError(
            f"{vertices.shown} has an impossible number of `f_rest_*` properties",
            got=rest_count,
            do="Keep 0, 9, 24 or 45 of them (spherical harmonics of degree 0 to 3)",
        )
    if vertices.face_count:
        notes.append(
            f"{vertices.shown}: it holds {vertices.face_count:,} faces beside the Gaussians; they are not used"
        )
    return rest_names, rgb


def _read_sh(vertices: Vertices, rest_names: list[str], notes: list[str]) -> tuple[np.ndarray, str]:
    """Coefficients, shape (n, (degree + 1)^2, 3), and their kind in words."""
    dc, degree = vertices.read_columns(DC), _REST_COUNTS[len(rest_names)]
    known = dc[np.isfinite(dc).all(axis=1)]
    if degree == 0 and len(known) >= _FEWEST_COLOURS and known.min() >= 0:
        # Coefficients of colours that no channel of any Gaussian has below one half.
        if np.median(known.max(axis=1)) > _BEYOND_WHITE and known.max() <= 255.0:
            notes.append(
                f"{vertices.shown}: its `f_dc_*` are read as RGB colours of 0 to 255, which their values show"
            )
            return colours_to_sh(dc[:, None, :] / 255.0), "RGB colours of 0 to 255"
        if known.max() <= 1.0 and np.ptp(known) >= _SPREAD:
            notes.append(
                f"{vertices.shown}: its `f_dc_*` are all in 0 to 1. They are read as SH, colours of 0.5 to 0.78; "
                "if they are RGB colours, name them `red green blue`"
            )
    sh = dc[:, None, :]
    if degree > _MOST_DEGREE:
        notes.append(
            f"{vertices.shown}: its spherical harmonics have degree {degree}; bands above {_MOST_DEGREE} are left out"
        )
    if degree:
        each, kept = (degree + 1) ** 2 - 1, (min(degree, _MOST_DEGREE) + 1) ** 2 - 1
        # A channel at a time: the bands that are left out need no memory.
        rest = [vertices.read_columns(rest_names[i * each : i * each + kept]) for i in range(3)]
        sh = np.concatenate([sh, np.stack(rest, axis=-1)], axis=1)
    return sh, f"SH of degree {min(degree, _MOST_DEGREE)}"


def _read_rgb(vertices: Vertices, names: Sequence[str]) -> tuple[np.ndarray, str]:
    """RGB colours as coefficients of degree 0, shape (n, 1, 3), and their kind in words.

    Integers span their type's range; floats are in [0, 255] if one is above 1, else in [0, 1].

    Raises:
        UserError: Floats are outside both ranges.
    """
    rgb = vertices.read_columns(names)
    kind = vertices.types[names[0]]
    if kind.kind in "iu":
        span = float(np.iinfo(kind).max)
    else:
        known = rgb[np.isfinite(rgb)]
        low, high = (known.min(), known.max()) if known.size else (0.0, 1.0)
        span = 255.0 if high > 1.0 else 1.0
        if low < 0.0 or high > 255.0:
            raise UserError(
                f"{vertices.shown}: the colours `{' '.join(names)}` are neither in 0 to 1 nor in 0 to 255",
                got=f"{low:.3g} to {high:.3g}",
                do="Export the scene again",
            )
    return colours_to_sh(rgb[:, None, :] / span), f"RGB colours of 0 to {span:g}"


def _read_opacities(vertices: Vertices, notes: list[str]) -> tuple[bool, np.ndarray]:
    """Return whether opacities are plain by their type, and the stored values, shape (n,)."""
    if "opacity" not in vertices.types:
        notes.append(f"{vertices.shown}: it has no property `opacity`; all Gaussians are taken as opaque")
        return True, np.ones(len(vertices.read_columns(POSITION[:1])))
    values, kind = vertices.read_columns(["opacity"])[:, 0], vertices.types["opacity"]
    return (True, values / 255.0) if kind == np.uint8 else (False, values)


def _read_rotations(vertices: Vertices, notes: list[str]) -> np.ndarray:
    """Quaternions wxyz of any norm, shape (n, 4)."""
    if "rot_0" in vertices.types:
        return vertices.read_columns(ROTATION)
    notes.append(
        f"{vertices.shown}: it has no properties `rot_*`; all Gaussians are taken as parallel to the axes"
    )
    return np.tile([1.0, 0.0, 0.0, 0.0], (len(vertices.read_columns(POSITION[:1])), 1))
