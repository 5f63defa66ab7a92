"""Regions that a word names by their place: the front of a head, the middle of a leg, the top of the whole.

They stick out little, so that a shape does not show them. `places.yaml` says where each is: which end of which parent.
What the object has no parent for is not found.
"""

from __future__ import annotations

import collections
from collections.abc import Collection, Sequence

import numpy as np

from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts.figures import is_figure_on_base
from physagent_jax.scene.parts.regions import Frame, Regions, read_places
from physagent_jax.scene.parts.shells import Shells, find_shells


def find_places(
    points: np.ndarray,
    parts: Sequence[Part],
    words: Collection[str],
    name: str,
    viewer: Frame,
    shells: Shells | None = None,
) -> tuple[Part, ...]:
    """The regions of an object that some words name.

    Args:
        points: Its particles at rest, z up [m], shape (n, 3).
        parts: Its parts: what is one of them, or has a part for it, is no region.
        words: Words of a sentence, in lower case.
        name: What the object is called.
        viewer: The viewer's directions.
        shells: Its shells; None = it has one alone.

    Returns:
        Parts with the words as names, and a side before it where there are two.
    """
    told = ([word for word in split_name(part.name) if not word.isdigit()] for part in parts)
    names = [words[-1] for words in told if words]
    known = {*names, *(each.removesuffix("s") for each in names)}
    parts = [part for part in parts if not part.stands_for]
    based = [part for part in parts if is_figure_on_base(part) and not (part.front and "head" in part.roles)]
    roles = collections.Counter(part.roles[0] for part in parts if part.roles and part not in based)
    height = float(np.ptp(points[:, 2]) / np.ptp(points, axis=0).max())  # [body lengths]
    long: dict[str, float] = {}
    for part in parts:
        for role in part.roles[:1]:
            long[role] = max(long.get(role, 0.0), float(np.linalg.norm(part.arm)) / height)
    said = {
        word: read_places()[word] for each in words for word in (each, each[:-1]) if word in read_places()
    }
    asked = {
        word: row
        for word, row in said.items()
        if word not in known
        and all(long.get(r, -1) < row.get("short", 0) for r in row.get("role", "").split())
        if roles[row.get("lone", "")] != 1
    }
    if not asked:
        return ()
    masks = [
        make_region_mask(part.moved, points)
        if "head" in part.roles[:1]
        else ~make_region_mask(part.rest, points)
        for part in parts
    ]  # of a head without its neck
    regions = Regions(points, parts, masks, name, viewer, shells or find_shells(points))
    return tuple(each for word, row in asked.items() for each in regions.find(word, row))
