"""The step that all readers share: from the Gaussians of a file to a cloud that can be computed with."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.base import SignedAxis, SplatData
from physagent_jax.gaussians.formats.lattice import describe_lattice, find_origin

# The largest values that a Gaussian may have: lengths whose squares float32 holds, colours that float16 holds.
_MOST = {"means": 1e12, "scales": 1e12, "sh": 1e4}
_FEW_LEFT = 0.5  # share of the file's Gaussians below which the threshold's work is said


@dataclasses.dataclass(frozen=True)
class LoadedSplats:
    """The Gaussians of a file, ready to be placed.

    Attributes:
        cloud: The Gaussians in the file's frame and units, float32; positions are relative to ``origin``.
        origin: Point that was taken off the positions in the file's own precision [file units], float64, shape
            (3,); zero where float32 holds the positions as they are.
        format_name: The format's name ("3DGS PLY").
        encoding: The reading of the values in words.
        up: The up axis that the format prescribes; None = it prescribes none.
        notes: Sentences that a user should read before a run.
        count_in_file: Number of Gaussians in the file, before any was dropped.
        plain: The cloud in the colours that people should see; None = in its own.
        front: The axis towards which the format says that an object looks; None = it says nothing of that.
    """

    cloud: GaussianCloud
    origin: np.ndarray
    format_name: str
    encoding: str
    up: SignedAxis | None
    notes: tuple[str, ...]
    count_in_file: int
    plain: GaussianCloud | None = None
    front: SignedAxis | None = None


def check_threshold(opacity_threshold: float) -> None:
    """Refuse a threshold that is no opacity."""
    if not 0.0 <= opacity_threshold <= 1.0:
        raise UserError("`opacity_threshold` is no opacity", got=opacity_threshold, do="Give 0 to 1")


def finish(data: SplatData, path: str | Path, format_name: str, opacity_threshold: float) -> LoadedSplats:
    """Drop what cannot be computed with, normalise, centre and convert to float32.

    Args:
        data: The Gaussians as a reader hands them on.
        path: The file, for messages.
        format_name: The format's name.
        opacity_threshold: Least opacity of the Gaussians that are kept, in [0, 1].

    Raises:
        UserError: No usable Gaussian is left.
    """
    shown, count = shorten(path), len(data.means)
    if count == 0:
        raise UserError(f"{shown} holds no Gaussians", got="0 of them", do="Export the scene again")
    notes = list(data.notes)
    usable = _find_usable(data, shown, notes)
    keep = usable & (data.opacities >= opacity_threshold)
    left, most = int(keep.sum()), int(usable.sum())
    if left == 0:
        raise UserError(
            f"no Gaussian in {shown} reaches opacity_threshold={opacity_threshold}",
            got=f"{data.opacities[usable].max():.3g} at most",
            do="Lower the threshold",
        )
    if left < _FEW_LEFT * most:
        notes.append(
            f"{shown}: only {left:,} of {most:,} Gaussians reach opacity_threshold={opacity_threshold:g}; "
            "lower it if parts of the object are missing"
        )
    means, quats = data.means[keep], _normalise_quats(data.quats[keep], shown, notes)
    if (lattice := describe_lattice(means)) is not None:
        notes.append(f"{shown}: {lattice}")
    origin = find_origin(means)
    kept = (means - origin, quats, data.scales[keep], data.opacities[keep], data.sh[keep])
    cloud = GaussianCloud(*(to_device(values, np.float32) for values in kept))
    return LoadedSplats(cloud, origin, format_name, data.encoding, data.up, tuple(notes), count)


def _find_usable(data: SplatData, shown: str, notes: list[str]) -> np.ndarray:
    """Gaussians whose values are numbers that mean something, shape (n,); adds a note on the others.

    Raises:
        UserError: There is none.
    """
    count = len(data.means)
    finite = ~np.isnan(data.opacities)
    for values in (data.means, data.quats, data.scales, data.sh):
        finite &= np.isfinite(values.reshape(count, -1)).all(axis=1)
    _note_dropped(finite, np.ones_like(finite), "that are not finite", shown, notes)
    sane = finite.copy()
    for name, most in _MOST.items():
        sane &= (np.abs(getattr(data, name)) <= most).reshape(count, -1).all(axis=1)
    limits = ", ".join(f"{most:g} ({name})" for name, most in _MOST.items())
    _note_dropped(sane, finite, f"beyond {limits}", shown, notes)
    return sane


def _note_dropped(kept: np.ndarray, before: np.ndarray, what: str, shown: str, notes: list[str]) -> None:
    if not kept.any():
        raise UserError(f"all Gaussians in {shown} have values {what}", do="Export the scene again")
    if (dropped := np.sum(before & ~kept)) > 0:
        notes.append(f"{shown}: dropped {dropped} Gaussians with values {what}")


def _normalise_quats(quats: np.ndarray, shown: str, notes: list[str]) -> np.ndarray:
    """Normalised quaternions; those of norm zero become the identity."""
    largest = np.abs(quats).max(axis=1, keepdims=True)
    quats = quats / np.where(largest > 0, largest, 1.0)  # whose squares neither overflow nor vanish
    norms = np.linalg.norm(quats, axis=1, keepdims=True)
    zero = norms[:, 0] == 0.0
    if zero.any():
        notes.append(f"{shown}: took {zero.sum()} quaternions of norm zero as the identity")
    return np.where(zero[:, None], [1.0, 0.0, 0.0, 0.0], quats / np.where(zero[:, None], 1.0, norms))
