"""`motion.npz`: damaged archives, and whole ones whose arrays are wrong."""

from __future__ import annotations

import numpy as np

from physagent_jax.output.motion_file import read_motion
from tests.fuzz import seeds
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import Draw, damaged

NAME = "motion.npz"


def make(draw: Draw) -> Case:
    """One motion file, read."""
    what, content = draw.one([_damage, _draw_arrays, _draw_arrays])(draw)
    return Case(what, lambda folder: _read(folder / NAME), {NAME: content})


def _read(path):
    motion = read_motion(path)
    frames, particles = motion.x.shape[:2] if motion.x.ndim == 3 else (-1, -1)
    if motion.F.shape != (frames, particles, 3, 3) or motion.times.shape != (frames,):
        raise Breach(
            Fault.SILENT, f"shapes disagree: x {motion.x.shape}, F {motion.F.shape}, t {motion.times.shape}"
        )
    count = len(motion.cloud_means) if motion.cloud_means.ndim else -1
    rows = (
        motion.cloud_quats,
        motion.cloud_scales,
        motion.cloud_opacities,
        motion.cloud_sh,
        motion.binding_indices,
    )
    if any(part.shape[:1] != (count,) for part in rows):
        raise Breach(Fault.SILENT, "the Gaussians' arrays have different lengths")
    followed = motion.binding_indices
    if (
        followed.dtype.kind not in "iu"
        or followed.size
        and not 0 <= followed.min() <= followed.max() < particles
    ):
        raise Breach(Fault.SILENT, "a Gaussian follows a particle that there is not")
    return motion


def _damage(draw: Draw) -> tuple[str, bytes]:
    return damaged(draw, seeds.motion(), [seeds.npy(np.zeros(3)), seeds.gaussians(12)])


def _draw_arrays(draw: Draw) -> tuple[str, bytes]:
    arrays = dict(seeds.motion_arrays())
    done = []
    for _ in range(draw.one([1, 1, 2])):
        key = draw.one(sorted(arrays))
        change, new = _change(draw, arrays.pop(key))
        if new is not None:
            arrays[key] = new
        done.append(f"{key}: {change}")
    return "; ".join(done), seeds.npz(arrays)


def _change(draw: Draw, array: np.ndarray):
    with np.errstate(all="ignore"):
        match draw.one(["missing", "value", "value", "dtype", "dtype", "shape", "shape", "object", "text"]):
            case "missing":
                return "missing", None
            case "value":
                value = draw.one([np.nan, np.inf, -1, 1e300, 2**31 - 1, 0])
                changed = np.array(array, copy=True)
                kind = np.result_type(array.dtype)
                limit = np.iinfo(kind) if kind.kind in "iu" else None
                if limit is not None:
                    value = min(max(int(np.nan_to_num(value, posinf=9e9)), limit.min), limit.max)
                if changed.size:
                    changed.flat[draw.randrange(changed.size)] = value
                return f"one value {value}", changed
            case "dtype":
                kind = draw.one(["f2", "f8", "i1", "i8", "u8", "c16", "?", "U8", "M8[s]"])
                try:
                    return f"as {kind}", array.astype(kind)
                except (TypeError, ValueError):
                    return "as text", array.astype("U8")
            case "shape":
                shapes = [
                    array.ravel(),
                    array[None],
                    array[:0] if array.ndim else array,
                    array.T,
                    np.repeat(array[None], 2, 0),
                ]
                new = draw.one(shapes)
                return f"of shape {new.shape}", new
            case "object":
                return "of objects", np.array([{"a": 1}, None], object)
    return "a sentence", np.array("hello")
