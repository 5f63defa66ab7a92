"""`motion.npz`: everything that every frame's Gaussians can be made from again, compactly.

The particles' motion is stored, not the Gaussians': a Gaussian follows a few particles through the binding,
so the file stays small however many Gaussians an object has. Keys (n particles, g Gaussians, T frames):

    format                  int, version of this layout
    times                   float64 (T,), seconds [s]
    x_quantised             uint16 (T, n, 3); position = x_low + x_step * x_quantised
    x_low, x_step           float64 (3,) [m]; x_step is the motion's extent / 65535
    F_minus_identity        float16 (T, n, 3, 3), deformation gradient less the identity
    binding_indices         int32 (g, k), the particles that a Gaussian follows
    binding_weights         float32 (g, k)
    binding_offsets         float32 (g, ...), rest offsets as the binding defines them [m]
    cloud_means             float32 (g, 3), rest centres [m]
    cloud_quats             float32 (g, 4), wxyz
    cloud_scales            float32 (g, 3) [m]
    cloud_opacities         float16 (g,)
    cloud_sh                float16 (g, c, 3)
    cloud_rotation          float64 (3, 3), from the frame in which the cloud was captured to the world

Positions are off by at most half an ``x_step`` (3e-5 m in a domain of 4 m, far below a pixel), where float16
would be off by up to 1e-3 m far from the origin. F is near the identity, where float16's resolution is lost
unless the identity is taken away first.
"""

from __future__ import annotations

import dataclasses
import io
import zipfile
from pathlib import Path

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file
from physagent_jax.core.npy import read_npz

FORMAT = 1
LEVELS = np.iinfo(np.uint16).max
# The low bits are noise that no level packs: for 20 000 particles and 50 frames, level 1 makes a file 3 % larger
# than level 6 (18 MB) in two thirds of the time.
COMPRESSION_LEVEL = 1

_MOST_BYTES = 16 * 2**30  # unpacked; 200,000 particles and 1,000 frames take 5 GB

_PACKED_KEYS = {
    "x_quantised": np.uint16,
    "x_low": np.float64,
    "x_step": np.float64,
    "F_minus_identity": np.float16,
}
_PLAIN_KEYS = {
    "times": np.float64,
    "binding_indices": np.int32,
    "binding_weights": np.float32,
    "binding_offsets": np.float32,
    "cloud_means": np.float32,
    "cloud_quats": np.float32,
    "cloud_scales": np.float32,
    "cloud_opacities": np.float16,
    "cloud_sh": np.float16,
    "cloud_rotation": np.float64,
}


@dataclasses.dataclass(frozen=True)
class Motion:
    """A motion file's contents.

    Attributes:
        times: Seconds of each frame [s], shape (T,).
        x: Particle positions [m], shape (T, n, 3).
        F: Deformation gradients, shape (T, n, 3, 3).
        binding_indices: Particles that each Gaussian follows, shape (g, k).
        binding_weights: Their weights, shape (g, k).
        binding_offsets: Rest offsets as the binding defines them [m], shape (g, ...).
        cloud_means: Rest centres [m], shape (g, 3).
        cloud_quats: Rest unit quaternions wxyz, shape (g, 4).
        cloud_scales: Standard deviations along the local axes [m], shape (g, 3).
        cloud_opacities: In [0, 1], shape (g,).
        cloud_sh: Spherical harmonics coefficients, shape (g, c, 3).
        cloud_rotation: Rotation from the captured frame to the world, shape (3, 3).
    """

    times: np.ndarray
    x: np.ndarray
    F: np.ndarray
    binding_indices: np.ndarray
    binding_weights: np.ndarray
    binding_offsets: np.ndarray
    cloud_means: np.ndarray
    cloud_quats: np.ndarray
    cloud_scales: np.ndarray
    cloud_opacities: np.ndarray
    cloud_sh: np.ndarray
    cloud_rotation: np.ndarray = dataclasses.field(default_factory=lambda: np.eye(3))


def write_motion(path: str | Path, motion: Motion) -> Path:
    """Write a motion file atomically.

    Raises:
        UserError: The file cannot be written.
        ValueError: Shapes disagree, or something is not finite or beyond what the file's precision holds.
    """
    _check(motion)
    x = np.asarray(motion.x, np.float64)
    low = x.min(axis=(0, 1))
    step = (x.max(axis=(0, 1)) - low) / LEVELS
    arrays = {
        "format": np.int64(FORMAT),
        "x_quantised": np.rint((x - low) / np.where(step > 0, step, 1.0)).astype(np.uint16),
        "x_low": low,
        "x_step": step,
        "F_minus_identity": (np.asarray(motion.F, np.float32) - np.eye(3, dtype=np.float32)).astype(
            np.float16
        ),
    }
    with np.errstate(over="ignore"):  # what is beyond a half's range is found by the check just below
        arrays |= {key: np.asarray(getattr(motion, key), dtype) for key, dtype in _PLAIN_KEYS.items()}
    for key, array in arrays.items():
        if not np.isfinite(array).all():
            raise ValueError(f"`{key}` holds values beyond the range of {array.dtype}")
    with replace_file(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for key, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, np.asanyarray(array), allow_pickle=False)
            # A fixed date, so that the same motion gives the same bytes.
            entry = zipfile.ZipInfo(f"{key}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            archive.writestr(entry, content.getbuffer(), zipfile.ZIP_DEFLATED, COMPRESSION_LEVEL)
    return Path(path)


def read_motion(path: str | Path) -> Motion:
    """Read a motion file; reals come back as float32 (times and rotation: float64).

    Raises:
        UserError: The file is missing, is not a motion file or damaged, or has another version's layout.
    """
    keys = ("format", *_PACKED_KEYS, *_PLAIN_KEYS)
    arrays = read_npz(path, keys, most=_MOST_BYTES, what="the motion file")
    version = arrays.get("format", np.int64(0))
    if version.shape != () or version != FORMAT:
        raise UserError(
            f"{path} has motion format {version}, this version reads {FORMAT}",
            do="Simulate again to rewrite it",
        )
    for key, dtype in (_PACKED_KEYS | _PLAIN_KEYS).items():
        if key not in arrays or arrays[key].dtype != dtype:
            got = f"{arrays[key].dtype} in place of {np.dtype(dtype)}" if key in arrays else "nothing"
            raise UserError(f"the motion file {path} is damaged: `{key}`", got=got, do="Simulate again")
    plain = {
        key: arrays[key].astype(np.float32) if arrays[key].dtype == np.float16 else arrays[key]
        for key in _PLAIN_KEYS
    }
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused just below
            x = (arrays["x_low"] + arrays["x_step"] * arrays["x_quantised"]).astype(np.float32)
        F = arrays["F_minus_identity"].astype(np.float32) + np.eye(3, dtype=np.float32)
        motion = Motion(x=x, F=F, **plain)
        _check(motion)
    except ValueError as error:
        raise UserError(f"the motion file {path} is damaged", got=error, do="Simulate again") from None
    return motion


def _check(motion: Motion) -> None:
    if np.ndim(motion.x) != 3:
        raise ValueError(f"`x` must have three axes (got shape {np.shape(motion.x)})")
    frames, particles = np.shape(motion.x)[:2]
    gaussians = len(motion.cloud_means)
    expected = {
        "times": (frames,),
        "x": (frames, particles, 3),
        "F": (frames, particles, 3, 3),
        "binding_weights": np.shape(motion.binding_indices),
        "cloud_means": (gaussians, 3),
        "cloud_quats": (gaussians, 4),
        "cloud_scales": (gaussians, 3),
        "cloud_opacities": (gaussians,),
        "cloud_rotation": (3, 3),
    }
    for key, shape in expected.items():
        if np.shape(getattr(motion, key)) != shape:
            raise ValueError(f"`{key}` must have shape {shape} (got {np.shape(getattr(motion, key))})")
    for key in ("binding_indices", "binding_offsets", "cloud_sh"):
        if len(getattr(motion, key)) != gaussians:
            raise ValueError(f"`{key}` must have {gaussians} rows (got {len(getattr(motion, key))})")
    for key in (field.name for field in dataclasses.fields(motion)):
        if not np.isfinite(getattr(motion, key)).all():
            raise ValueError(f"`{key}` holds values that are not finite")
    if np.size(motion.binding_indices) and not (
        np.min(motion.binding_indices) >= 0 and np.max(motion.binding_indices) < particles
    ):
        raise ValueError(f"`binding_indices` must lie in 0 to {particles - 1}")
