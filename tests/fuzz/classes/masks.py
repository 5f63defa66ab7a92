"""Anchor masks: `.npy` of one bool per Gaussian, and everything that only looks like it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.config import Anchor
from tests.fuzz import seeds
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import Draw, damaged

COUNT, NAME = 30, "mask.npy"


def make(draw: Draw) -> Case:
    """One mask, applied to particles of which some are filled."""
    good = np.arange(COUNT) % 3 == 0
    what, content = draw.one([_damage, _damage, _draw_arrays])(draw, good)
    exact = draw.chance(0.5)
    return Case(
        f"{what}; {'exact' if exact else 'covering'} length",
        lambda f: _select_anchored(f, exact),
        {NAME: content},
    )


def _select_anchored(folder: Path, exact: bool):
    rng = np.random.default_rng(0)
    index = np.concatenate([np.arange(COUNT), np.full(10, -1)])
    x, anchor = rng.uniform(size=(len(index), 3)), Anchor(kind="mask", mask_path=NAME)
    selection = select_anchored(anchor, x, index, folder, gaussian_count=COUNT if exact else None)
    if selection.shape != (len(index),) or selection.dtype != bool or not selection.any():
        raise Breach(Fault.SILENT, f"held {selection.dtype} {selection.shape}, {selection.sum()} particles")
    return selection


def _damage(draw: Draw, good: np.ndarray) -> tuple[str, bytes]:
    return damaged(draw, seeds.npy(good), [seeds.npz({"mask": good}), seeds.npy(np.ones(3))])


def _draw_arrays(draw: Draw, good: np.ndarray) -> tuple[str, bytes]:
    options = {
        "empty file": b"",
        "an archive": seeds.npz({"mask": good}),
        "an empty archive": seeds.npz({}),
        "only a header": seeds.npy(good)[:128],
        "half a header": seeds.npy(good)[:40],
        "integers": seeds.npy(good.astype(int)),
        "floats": seeds.npy(good.astype(float)),
        "two columns": seeds.npy(np.stack([good, good], 1)),
        "a scalar": seeds.npy(np.array(True)),
        "too short": seeds.npy(good[:-1]),
        "too long": seeds.npy(np.concatenate([good, good])),
        "nothing held": seeds.npy(np.zeros_like(good)),
        "pickled": seeds.npy(np.array([True, None] * 15, object)),
        "text": seeds.npy(np.array(["yes"] * COUNT)),
        "a dtype of records": seeds.npy(np.zeros(COUNT, [("a", bool)])),
        "a huge shape": seeds.npy(good).replace(b"(30,)", b"(9999999999999,)"),
        "a negative shape": seeds.npy(good).replace(b"(30,)", b"(-30,)"),
        "big": seeds.npy(np.zeros(2_000_000, bool)),
        "no array": b"\x93NUMPY" + bytes(draw.getrandbits(8) for _ in range(20)),
        "a picture": b"\x89PNG\r\n\x1a\n" + bytes(100),
    }
    name = draw.one(sorted(options))
    return name, options[name]
