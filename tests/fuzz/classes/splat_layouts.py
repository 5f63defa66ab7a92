"""Relatives of the 3DGS PLY: RGB colours, two scales, doubles, plain values, far positions, points; then damaged."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.gaussians.diagnosis import diagnose_cloud
from physagent_jax.gaussians.formats import read_splats
from physagent_jax.gaussians.formats.encoding import ENCODINGS
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Domain, Filling, Source
from tests.fuzz import seeds
from tests.fuzz.contract import Case
from tests.fuzz.drawing import NUMBERS, Draw, damaged

_COLOURS = {
    "sh": [(f"f_dc_{i}", "float") for i in range(3)],
    "rgb bytes": [(name, "uchar") for name in ("red", "green", "blue")],
    "rgb floats": [(name, "float") for name in ("red", "green", "blue")],
    "r g b": [(name, "uint") for name in "rgb"],
}
_PLACES = (0.0, 0.0, 1.0, 5e5, -5.4e6, 1e11)


def make(draw: Draw) -> Case:
    """One file, read and diagnosed, and now and then made a body of."""
    what, content = _write_layout(draw)
    if draw.chance(0.4):
        files = [content, _write_layout(draw)[1], seeds.gaussians(12)]
        more, content = damaged(draw, content, files)
        what = f"{what}; {more}"
    encoding = draw.one([*[None] * 9, *ENCODINGS, "plain-log"])
    threshold = draw.one([0.0, 0.0, 0.02, 0.5])
    if encoding in (None, *ENCODINGS) and draw.chance(0.3):
        return Case(
            f"{what}, {encoding}; as an object",
            lambda folder: _make_body(folder, encoding, threshold),
            {seeds.OBJECT: content},
        )
    return Case(
        f"{what}, {encoding}", lambda folder: _read(folder, threshold, encoding), {seeds.OBJECT: content}
    )


def _read(folder: Path, threshold: float, encoding: str | None):
    loaded = read_splats(folder / seeds.OBJECT, opacity_threshold=threshold, encoding=encoding)
    return loaded, diagnose_cloud(loaded.cloud)


def _make_body(folder: Path, encoding, threshold: float):
    source = Source(path=seeds.OBJECT, opacity_threshold=threshold, splat_encoding=encoding)
    return make_body(source, Filling(cells=6, max_particles=100), Domain(size=2.0, cells=16), folder)


def _write_layout(draw: Draw) -> tuple[str, bytes]:
    """A file of one layout, with now and then a value that no capture has."""
    rng = np.random.default_rng(draw.getrandbits(32))
    count = draw.one([1, 3, 5, 70, 200])
    precise = draw.one(["float", "double"])
    scales, far = draw.one([2, 3, 3, 3]), draw.one(_PLACES)
    colours, encoding = draw.one(list(_COLOURS)), draw.one(ENCODINGS)
    size = draw.one([1e-4, 1.0, 1.0, 300.0])
    first, second = encoding.split("-")
    sizes = 0.1 * size * np.exp(rng.normal(0, draw.one([0.0, 0.5, 4.0]), (count, scales)))
    opacities = rng.uniform(0.01, 0.99, (count, 1)) if draw.chance(0.7) else np.full((count, 1), 0.9)
    groups = [
        ([(name, precise) for name in "xyz"], far + size * rng.uniform(size=(count, 3))),
        (_COLOURS[colours], rng.uniform(0, draw.one([1.0, 255.0]), (count, len(_COLOURS[colours])))),
        ([(f"scale_{i}", "float") for i in range(scales)], np.log(sizes) if first == "log" else sizes),
        (
            [("opacity", draw.one(["float", "float", "uchar"]))],
            np.log(opacities / (1 - opacities)) if second == "logit" else opacities,
        ),
        ([(f"rot_{i}", "float") for i in range(4)], rng.normal(size=(count, 4))),
    ]
    if draw.chance(0.2):
        groups.pop(draw.randrange(len(groups)))
    draw.shuffle(groups)
    properties = [each for names, _ in groups for each in names]
    rows = np.concatenate([values for _, values in groups], axis=1)
    if draw.chance(0.4):
        row, column = draw.randrange(count), draw.randrange(rows.shape[1])
        rows[row if draw.chance(0.5) else slice(None), column] = draw.one([np.nan, np.inf, 0.0, -1.0, 1e30])
    if draw.chance(0.1):
        rows[:, draw.randrange(rows.shape[1])] = float(draw.one([n for n in NUMBERS if abs(n) < 1e300]))
    what = f"{count} of {encoding}, {scales} scales, {colours}, {precise} at {far:g}"
    return what, seeds.table(properties, rows)
