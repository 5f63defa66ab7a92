"""3D Gaussians as PLY: damaged bytes, other headers, columns of other types, values that no capture has."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from physagent_jax.gaussians import read_ply
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Domain, Filling, Source
from physagent_jax.scene.load import load_object
from tests.fuzz import seeds
from tests.fuzz.contract import Case
from tests.fuzz.drawing import NUMBERS, Draw, damaged

COUNTS = ("0", "-1", "1", "61", "59", "4294967296", "9" * 19, "9" * 30, "1e3", "0x10", "", "999999999999")
TYPES = (
    "float",
    "double",
    "int",
    "uchar",
    "short",
    "uint",
    "list uchar int",
    "list double float",
    "float16",
    "",
)
NAMES = (
    *"xyz", *(f"f_dc_{i}" for i in range(3)), "opacity", *(f"scale_{i}" for i in range(3)),
    *(f"rot_{i}" for i in range(4)),
)  # fmt: skip


def make(draw: Draw) -> Case:
    """One file, read, and now and then made a body of."""
    kind = draw.one([_damage, _damage, _change_header, _change_columns, _change_values, _change_values])
    what, content = kind(draw)
    threshold = draw.one([0.0, 0.02, 0.02, 0.5, 1.0])
    if draw.chance(0.35):
        return Case(f"{what}; as an object", _make_body, {seeds.OBJECT: content})
    return Case(what, lambda folder: _read(folder, threshold), {seeds.OBJECT: content})


def _read(folder: Path, threshold: float):
    return read_ply(folder / seeds.OBJECT, opacity_threshold=threshold)


def _make_body(folder: Path):
    source = Source(path=seeds.OBJECT, surface_samples=40)
    filling = Filling(cells=6, max_particles=100)
    return load_object(source, folder), make_body(source, filling, Domain(size=2.0, cells=16), folder)


def _damage(draw: Draw) -> tuple[str, bytes]:
    files = [
        seeds.gaussians(), seeds.gaussians(12, 1), seeds.gaussians(3, 3), seeds.gaussians_ascii(),
        seeds.gaussians_big_endian(), seeds.meshes()["box.ply"],
    ]  # fmt: skip
    return damaged(draw, draw.one(files), files)


def _change_header(draw: Draw) -> tuple[str, bytes]:
    """One line of the header changed, the data kept."""
    content = draw.one([seeds.gaussians(), seeds.gaussians_ascii()])
    end = content.index(b"end_header\n") + len(b"end_header\n")
    lines = content[:end].decode().splitlines()
    index = draw.randrange(len(lines))
    words = lines[index].split()
    change = draw.one(["drop", "twice", "swap", "word", "long", "bytes"])
    if words[0] == "element":
        lines[index] = f"element {draw.one(['vertex', 'face', 'chunk', 'é'])} {draw.one(COUNTS)}"
    elif words[0] == "property" and change in ("word", "long", "bytes"):
        lines[index] = f"property {draw.one(TYPES)} {draw.one((words[-1], 'x', 'opacity', 'f_rest_0', ''))}"
    elif change == "drop":
        del lines[index]
    elif change == "twice":
        lines.insert(index, lines[index])
    elif change == "swap":
        lines.insert(draw.randrange(len(lines)), lines.pop(index))
    elif change == "long":
        lines.insert(1, "comment " + "x" * draw.one([1000, 100_000, 3_000_000]))
    elif change == "word":
        lines[index] = draw.one(
            ["format ascii 1.0", "format binary_big_endian 1.0", "format x 9", "obj_info", ""]
        )
    else:
        lines[index] += "\x00\x7f"
    return f"header line {index}: {change} {words[0]}", "\n".join(lines).encode() + b"\n" + content[end:]


def _change_columns(draw: Draw) -> tuple[str, bytes]:
    """Columns of other types, in another order, with more of them."""
    rng = np.random.default_rng(draw.getrandbits(32))
    rest = draw.one([0, 0, 9, 24, 45, 1, 10, 46])
    names = [*NAMES, *(f"f_rest_{i}" for i in range(rest))]
    if draw.chance(0.3):
        names.remove(draw.one(names))
    if draw.chance(0.2):
        names.append(draw.one(names))
    draw.shuffle(names)
    kinds = ("float", "double", "double", "int", "uchar", "short", "uint")
    properties = [(name, draw.one(kinds) if draw.chance(0.3) else "float") for name in names]
    rows = rng.normal(size=(draw.one([1, 2, 30]), len(names)))
    return f"columns {len(names)}, {rest} of them f_rest", seeds.table(properties, rows)


def _change_values(draw: Draw) -> tuple[str, bytes]:
    """Extreme values in one column or one row, in single or double precision."""
    rng = np.random.default_rng(draw.getrandbits(32))
    count = draw.one([1, 1, 5, 40])
    rows = np.concatenate(
        [rng.uniform(size=(count, 3)), rng.normal(size=(count, 3)), np.full((count, 1), 3.0),
         np.full((count, 3), -3.0), rng.normal(size=(count, 4))], axis=1
    )  # fmt: skip
    kind = draw.one(["float", "double"])
    extremes = [n for n in map(_to_float, NUMBERS) if n is not None] + [np.nan, np.inf, -np.inf]
    done = []
    for _ in range(draw.one([1, 1, 2, 4])):
        column, value = draw.randrange(len(NAMES)), draw.one(extremes)
        whole = draw.chance(0.6)
        rows[slice(None) if whole else draw.randrange(count), column] = value
        done.append(f"{NAMES[column]} = {value:g}{'' if whole else ' in one row'}")
    if draw.chance(0.1):
        rows[:, -4:] = draw.one([0.0, 1e-30, 1e30, 1e200])
        done.append("all quaternions alike")
    return f"{kind}, {count} Gaussians: {', '.join(done)}", seeds.table([(n, kind) for n in NAMES], rows)


def _to_float(number) -> float | None:
    try:
        return float(number)
    except OverflowError:
        return None
