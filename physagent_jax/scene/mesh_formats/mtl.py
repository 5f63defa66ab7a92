"""Colours of OBJ files: material libraries (MTL).

The loader's own reader of libraries says nothing of pictures that it cannot open and takes the options of a map for
a part of the file's name.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.scene.mesh_formats.base import Neighbours
from physagent_jax.scene.mesh_formats.look import Wrap, read_pixels

CUTOFF = 0.5  # alpha of a cut-out picture from which on the surface is there

_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2,
    "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1,
}  # fmt: skip
"""Options of a map and the number of their values; of three, the last two may be left out."""


@dataclasses.dataclass(frozen=True)
class Picture:
    """A map of a material.

    Attributes:
        name: Name of the picture's file.
        scale, offset: Texture coordinates are scaled, then shifted, shapes (2,).
        wrap: Continuation beyond the picture.
    """

    name: str
    scale: np.ndarray
    offset: np.ndarray
    wrap: Wrap


@dataclasses.dataclass
class Material:
    """A material's colour and texture.

    Attributes:
        diffuse: Kd, RGB in [0, 1]; None = not given.
        picture: map_Kd; None = not given.
        cut_out: Whether it has a map of transparency (map_d).
    """

    diffuse: np.ndarray | None = None
    picture: Picture | None = None
    cut_out: bool = False


def parse_mtl(text: str) -> dict[str, Material]:
    """Materials by name; lines that make no sense are left out."""
    materials: dict[str, Material] = {}
    current = Material()
    for line in text.splitlines():
        match line.split():
            case [key, *rest] if key.lower() == "newmtl" and rest:
                current = materials.setdefault(" ".join(rest), Material())
            case [key, *values] if key.lower() == "kd":
                current.diffuse = _read_colour(values)
            case [key, *words] if key.lower() == "map_kd" and words:
                current.picture = _read_map(words)
            case [key, *_] if key.lower() == "map_d":
                current.cut_out = True
            case _:
                pass
    return materials


def read_picture(picture: Picture, beside: Neighbours) -> np.ndarray | None:
    """The pixels of a map, RGBA, uint8, shape (h, w, 4); None = they cannot be had, which is noted."""
    data = beside.read_optional(picture.name)
    if data is None:
        return None
    try:
        return read_pixels(data)
    except UserError as error:
        beside.missing.append(f"{picture.name}: {error}")
        return None


def _read_colour(values: list[str]) -> np.ndarray | None:
    numbers = _read_numbers(values[:3])
    if len(numbers) == 1:  # one value stands for all three
        numbers = numbers * 3
    return np.clip(numbers, 0, 1) if len(numbers) == 3 else None


def _read_map(words: list[str]) -> Picture | None:
    scale, offset, wrap = np.ones(2), np.zeros(2), "repeat"
    at = 0
    while at < len(words) - 1 and words[at].lower() in _OPTIONS:
        option = words[at].lower()
        values = words[at + 1 : at + 1 + _OPTIONS[option]]
        if _OPTIONS[option] == 3:
            numbers = _read_numbers(values)
            values = values[: max(len(numbers), 1)]
            if option == "-s":
                scale[: len(numbers)] = numbers[:2]
            elif option == "-o":
                offset[: len(numbers)] = numbers[:2]
        elif option == "-clamp" and values[0].lower() == "on":
            wrap = "clamp"
        at += 1 + len(values)
    name = " ".join(words[at:])
    return Picture(name, scale, offset, wrap) if name else None  # pyright: ignore[reportArgumentType]


def _read_numbers(words: list[str]) -> list[float]:
    """Finite numbers up to the first word that is none."""
    numbers = []
    for word in words:
        try:
            number = float(word)
        except ValueError:
            break
        if not np.isfinite(number):
            break
        numbers.append(number)
    return numbers
