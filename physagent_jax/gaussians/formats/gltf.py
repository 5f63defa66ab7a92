"""Reading 3D Gaussians of glTF files (.glb, .gltf) with the extension KHR_gaussian_splatting.

Layout (Khronos, KHR_gaussian_splatting): point primitives have the attribute ``POSITION``. After the prefix
``KHR_gaussian_splatting:`` they have ``ROTATION`` (unit quaternion xyzw), ``SCALE`` (standard deviations), ``OPACITY``
and ``SH_DEGREE_l_COEF_n``. Nothing is a logarithm. Nodes place them, +y is up. With
KHR_gaussian_splatting_compression_spz_2 the values are an SPZ file in a buffer view.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import MIB, shorten
from physagent_jax.gaussians.formats.base import SplatData
from physagent_jax.gaussians.formats.gltf_file import GLB_MAGIC, GltfFile, explain_damage
from physagent_jax.gaussians.formats.moving import move_gaussians
from physagent_jax.gaussians.formats.spz import decode_spz

EXTENSION = "KHR_gaussian_splatting"
SRGB, LINEAR = "srgb_rec709_display", "lin_rec709_display"
_SPZ = (f"{EXTENSION}_compression_spz_2", f"{EXTENSION}_compression_spz")
_SPZ_TO_GLTF = np.diag([-1.0, 1.0, -1.0])  # SPZ's axes point right, up and back, glTF's left, up and front
_LEAST_BYTES = 15  # of a Gaussian in the file
_MOST_COPIES = 16  # of all Gaussians by nodes that show the same ones


class _Gltf:
    """glTF with KHR_gaussian_splatting."""

    name = "glTF with KHR_gaussian_splatting"
    suffixes = (".glb", ".gltf")

    def matches(self, head: bytes) -> bool:
        """Return whether the file begins as glTF and names the extension."""
        return (
            head.startswith(GLB_MAGIC) or head.lstrip().startswith(b"{")
        ) and f'"{EXTENSION}"'.encode() in head

    def read(self, path: Path, encoding: str | None) -> SplatData:
        """Read a file; its values have one meaning, so that ``encoding`` changes nothing.

        Raises:
            UserError: It is damaged, has no Gaussians, mirrors them, or is compressed in a way that is not read.
        """
        file = GltfFile(path)
        parts: list[SplatData] = []
        total = others = 0
        for mesh, transform in file.walk_meshes():
            for primitive in file.get(file.item("meshes", mesh), "primitives", list):
                extension = file.get(file.get(primitive, "extensions", dict, {}), EXTENSION, dict, None)
                if extension is None:
                    others += 1
                    continue
                part = _move(_read_primitive(file, primitive, extension), transform, file.shown)
                total += len(part.means)
                if total * _LEAST_BYTES > _MOST_COPIES * file.size + MIB:
                    raise explain_damage(file.shown, f"more than {total:,} Gaussians in {file.size:,} bytes")
                parts.append(part)
        if total == 0:
            raise UserError(f"{file.shown} holds no Gaussians", do="Export the scene again")
        data = _join(parts)
        if others == 0:
            return data
        note = f"{file.shown}: only its Gaussians are read, and {others} part(s) that are meshes or points are left out"
        return dataclasses.replace(data, notes=(*data.notes, note))


GLTF = _Gltf()


def _read_primitive(file: GltfFile, primitive: dict, extension: dict) -> SplatData:
    """The Gaussians of a primitive in its own frame."""
    notes = []
    if file.get(extension, "colorSpace", str, SRGB) == LINEAR:
        notes.append(
            f"{file.shown}: its colours are linear light and are drawn as they are, that is, too dark"
        )
    if (kernel := file.get(extension, "kernel", str, "ellipse")) != "ellipse":
        notes.append(
            f"{file.shown}: its kernel {shorten(kernel, 40)!r} is not known and is read as Gaussians"
        )
    inner = file.get(extension, "extensions", dict, {})
    for name in _SPZ:
        if name in inner:
            view = file.read_view(file.count(file.get(inner, name, dict), "bufferView"))
            data, _ = decode_spz(bytes(view), file.shown)
            moved = move_gaussians(data.means, data.quats, data.scales, data.sh, _SPZ_TO_GLTF, np.zeros(3))
            means, quats, scales, sh = moved
            encoding = f"glTF, {data.encoding}"
            return SplatData(means, quats, scales, data.opacities, sh, encoding, "+y", (*notes, *data.notes))
    if unknown := [name for name in inner if "compression" in name]:
        raise UserError(
            f"{file.shown} is compressed in a way that is not read",
            got=shorten(unknown[0], 60),
            do="Export it without compression",
        )
    attributes = file.get(primitive, "attributes", dict)

    def read(name: str, kind: str) -> np.ndarray:
        if name not in attributes:
            raise UserError(
                f"{file.shown} is not laid out as {EXTENSION}: it has no attribute {name}",
                got=shorten(", ".join(attributes), 100),
                do="Export it again, as the ratified extension has it",
            )
        return file.read_accessor(file.count(attributes, name), (kind,))

    means = read("POSITION", "VEC3")
    quats = read(f"{EXTENSION}:ROTATION", "VEC4")[:, [3, 0, 1, 2]]
    scales = read(f"{EXTENSION}:SCALE", "VEC3")
    opacities = read(f"{EXTENSION}:OPACITY", "SCALAR")[:, 0]
    degree = max((d for d in range(1, 4) if f"{EXTENSION}:SH_DEGREE_{d}_COEF_0" in attributes), default=0)
    sh = [
        read(f"{EXTENSION}:SH_DEGREE_{d}_COEF_{n}", "VEC3")
        for d in range(degree + 1)
        for n in range(2 * d + 1)
    ]
    if any(len(each) != len(means) for each in (quats, scales, opacities, *sh)):
        raise explain_damage(file.shown, f"attributes of other lengths than {len(means)}")
    _check_ranges(scales, opacities, file.shown)
    return SplatData(
        means=means,
        quats=quats,
        scales=scales,
        opacities=opacities,
        sh=np.stack(sh, axis=1),
        encoding=f"plain scales and opacities, SH of degree {degree}",
        up="+y",
        notes=tuple(notes),
    )


def _check_ranges(scales: np.ndarray, opacities: np.ndarray, shown: str) -> None:
    """Refuse logarithms where the extension has plain values."""
    for name, wrong in (("scales", scales < 0), ("opacities", (opacities < 0) | (opacities > 1))):
        if wrong.any():
            raise UserError(
                f"{shown} has {name} that are none: the extension stores plain values, no logarithms",
                got=f"{np.sum(wrong):,} out of range",
                do="Export it again",
            )


def _move(data: SplatData, transform: np.ndarray, shown: str) -> SplatData:
    """The Gaussians in the frame of the scene."""
    linear, offset = transform[:3, :3], transform[:3, 3]
    determinant = np.linalg.det(linear)
    if not np.isfinite(transform).all() or not determinant > 1e-12 * np.linalg.norm(linear) ** 3:
        raise UserError(
            f"{shown} has a node that mirrors or flattens its Gaussians",
            got=f"determinant {determinant:.3g}",
            do="Export it with positive scales",
        )
    if np.array_equal(transform, np.eye(4)):
        return data
    means, quats, scales, sh = move_gaussians(data.means, data.quats, data.scales, data.sh, linear, offset)
    return dataclasses.replace(data, means=means, quats=quats, scales=scales, sh=sh)


def _join(parts: list[SplatData]) -> SplatData:
    """All Gaussians as one; harmonics that some lack are zero."""
    if len(parts) == 1:
        return parts[0]
    most = max(part.sh.shape[1] for part in parts)
    sh = [np.pad(part.sh, ((0, 0), (0, most - part.sh.shape[1]), (0, 0))) for part in parts]
    return SplatData(
        means=np.concatenate([part.means for part in parts]),
        quats=np.concatenate([part.quats for part in parts]),
        scales=np.concatenate([part.scales for part in parts]),
        opacities=np.concatenate([part.opacities for part in parts]),
        sh=np.concatenate(sh),
        encoding=f"{len(parts)} parts: {parts[0].encoding}",
        up="+y",
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
    )
