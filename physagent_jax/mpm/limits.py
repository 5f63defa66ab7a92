"""Limits of the method that a model runs into, told before anything is simulated (docs/limits.md)."""

from __future__ import annotations

import math
import warnings

import numpy as np

from physagent_jax.mpm.materials import Fluid
from physagent_jax.mpm.pieces import label_pieces
from physagent_jax.mpm.state import Model, State

THINNEST = 3.0
"""Cells of thickness from which on an obstacle holds what falls on it.

The nodes in an obstacle push towards the face that they are nearest to. The first node below a face may lie almost a
cell deep: with less than twice that it can belong to the far side. Measured with plates at several heights between two
nodes (docs/limits.md): with 1 and 1.5 cells all or nothing passes, as the nodes lie. At 3 m/s nothing passes 2 cells.
At 6 m/s, a fall of 1.8 m, up to 25 % passes 2 cells, up to 17 % passes 3 cells and nothing passes 4.
"""

FEWEST_PER_AXIS = 2.0
"""Particles along each side of a cell that a liquid needs to keep its depth."""

LONG = 2.0
"""Time from which on a stirred liquid's loss is worth a word [s]."""

BODY = 0.05
"""Share of the particles from which on a piece counts as a body of its own."""


def find_limits(model: Model, state: State, duration: float) -> list[str]:
    """Sentences on what the method does badly in this model.

    Args:
        model: Its boundaries, materials and grid are looked at.
        state: Where the particles start.
        duration: Time that will be simulated [s].
    """
    return [*_find_thin_obstacles(model), *_find_bodies(model, state), *_find_liquids(model, duration)]


def warn_of_limits(model: Model, state: State, duration: float, stacklevel: int = 2) -> None:
    """Warn of every sentence of `find_limits`."""
    for sentence in find_limits(model, state, duration):
        warnings.warn(sentence, UserWarning, stacklevel=stacklevel + 1)


def _find_thin_obstacles(model: Model) -> list[str]:
    dx, found = model.grid.dx, []
    for index, boundary in enumerate(model.boundaries):
        thickness = getattr(boundary, "thickness", None)
        if thickness is None or not math.isfinite(thickness) or thickness > (1 - 1e-3) * THINNEST * dx:
            continue
        needed = math.ceil(THINNEST * dx / thickness * model.grid.cells - 1e-3) if thickness > 0 else None
        finer = f", or take {needed} cells along the domain's side" if needed and needed <= 1024 else ""
        found.append(
            f"`boundaries[{index}]` ({type(boundary).__name__}) is {thickness / dx:.2g} cells thick: obstacles of less "
            f"than {THINNEST:g} cells let matter through; make it {THINNEST * dx:.2g} m thick{finer}"
        )
    return found


def _find_bodies(model: Model, state: State) -> list[str]:
    x = np.asarray(state.x, np.float64)
    if len(x) == 0 or not any(not isinstance(law, Fluid) for law in model.materials):
        return []
    shares = np.bincount(label_pieces(x, model.grid.dx)) / len(x)
    bodies = int((shares >= BODY).sum())
    if bodies < 2:
        return []
    return [
        f"{bodies} bodies start apart: from where they touch on they share one velocity field, so that they stick and "
        "neither slide nor part again"
    ]


def _find_liquids(model: Model, duration: float) -> list[str]:
    volume, dx, first = np.asarray(model.volume, np.float64), model.grid.dx, 0
    fewest = math.inf
    for law in model.materials:
        if isinstance(law, Fluid) and law.count:
            fewest = min(fewest, dx / float(np.median(volume[first : first + law.count])) ** (1 / 3))
        first += law.count
    if fewest < 0.95 * FEWEST_PER_AXIS:
        return [
            f"the liquid has {fewest:.2g} particles along a cell's side: with 1 it loses a quarter of its depth in 3 s "
            f"at rest; give it {FEWEST_PER_AXIS:g} by more particles or fewer cells"
        ]
    if math.isfinite(fewest) and duration >= LONG:
        return [
            f"liquids lose volume when they are stirred for long: some 8 % in 3 s; this clip has {duration:.3g} s"
        ]
    return []
