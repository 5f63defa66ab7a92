"""Plane strain on a three-dimensional grid: one layer of particles between two frictionless walls.

The particles sit on a plane of nodes, and slip walls half a cell to either side hold the nodes beyond. The field
is then the same on all three planes of nodes and nothing moves across them: v_y = 0 and F_yy = 1 exactly.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.bodies import half_space
from physagent_jax.mpm import Contact, Grid, HalfSpace

LAYER = 3
"""Node index of the layer in y: its stencil clears the particles' wall, two cells from the domain's face."""


def sheet(cells: tuple[int, int], dx: float, low: tuple[float, float], per_axis: int) -> np.ndarray:
    """``per_axis``**2 particles per cell of a rectangle in x and z with low corner ``low`` [m], shape (n, 3)."""
    x, z = ((np.arange(count * per_axis) + 0.5) * dx / per_axis for count in cells)
    x, z = (axis.ravel() for axis in np.meshgrid(x + low[0], z + low[1], indexing="ij"))
    return np.stack([x, np.full_like(x, LAYER * dx), z], -1)


def sheet_grid(cells_x: int, cells_z: int, dx: float) -> Grid:
    """The window of the sheet's three planes of nodes; nodes 0..cells_x and 0..cells_z in x and z."""
    origin = jnp.asarray([0, LAYER - 1, 0], jnp.int32)
    return Grid(origin, (cells_x + 1, 3, cells_z + 1), dx, max(cells_x, cells_z))


def side_walls(dx: float, dtype) -> tuple[HalfSpace, HalfSpace]:
    """The slip walls either side of the layer."""
    y = LAYER * dx
    return (
        half_space((0, y - dx / 2, 0), (0, 1, 0), Contact.SLIP, dtype),
        half_space((0, y + dx / 2, 0), (0, -1, 0), Contact.SLIP, dtype),
    )
