"""The inertia of grid nodes: lumped, with light nodes aggregated, or with most of the error undone that lumping makes.

**Aggregation.** At a free surface some nodes have hardly any mass: the outermost particles touch them with the rims of
their stencils. Few particles are a bad rule of quadrature for the stress there, and dt f / m of a light node is large,
so that the outer rows of particles creep until the wrong sum is zero: bodies with two particles per cell and axis bend
some 6 % too far. `aggregate` lets a light node follow its neighbours' increments, as cut-cell methods let small cells
(extended B-splines, Hoellig, Reif and Wipper 2001; aggregated finite elements, Badia, Verdugo and Martin 2018). With
masses m and sums over 3 x 3 x 3 nodes,

    own_i = min(m_i / (aggregation sum m^2 / sum m), 1),    P_ij = own_i delta_ij + (1 - own_i) m_j^2 / sum m^2,
    dv = P (P^T f) / (P^T m).

Rows of P sum to one, so that linear momentum stays exact and what is uniform stays so. They are convex, so that
sum m (P u)^2 <= sum (P^T m) u^2: no mode becomes faster, and the stable step is no shorter. Inside a body P is one.
Before a plane of symmetry, light nodes next to it see one layer of images.

**Sharpening.** A node's velocity changes by dv = f / m with f the impulses of stress and m its lumped mass. The full
mass matrix of quadratic B-splines is m (1 - q^2/4 + ...) for a wave of q radians a cell, so that lumping lets short
waves travel too slowly: omega = c k (1 - 0.108 q^2) with MLS stress. `Sharpened` adds to each dv what its neighbours'
lack,

    dv_i + beta / m_i sum_j m_ij (dv_i - dv_j)      over the six neighbours j,

which multiplies it by 1 + beta q^2. The edges' masses m_ij are symmetric, so that linear momentum stays exact; at most
the lighter node's, so that a surface bears them; and nothing between nodes that one particle can fill, since a lone
particle sets the stable step (`mpm.timestep`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import ClassVar

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError

MOST_BETA = 0.25
"""Strength that makes up for all of q^2/4: with more, short waves travel too fast at any step."""
FULL = 2.0
"""Particles of one size that a node must have for its edges to count in full."""
NEXT_TO_NOTHING = 1e-5
"""Share of the lightest particle's mass up to which a node has none."""


MOST_AGGREGATION = 0.8
"""Share of the neighbours' mass from which a node must be on its own: inside a body nodes differ by less."""


@dataclasses.dataclass(frozen=True)
class Lumped:
    """Each node has its own mass alone, but for those that `aggregate` lets follow their neighbours.

    Attributes:
        aggregation: Share of the neighbours' mass, in [0, 0.8], below which a node follows them in part; 0.5 for most,
            0 = none does. As of `Sharpened`, P2G carries eight numbers a node then, and angular momentum is not kept
            to round-off.

    Raises:
        UserError: ``aggregation`` is out of range.
    """

    aggregation: float = 0.0

    def __post_init__(self):
        _check_aggregation(self)

    @property
    def apart(self) -> bool:
        """True if P2G keeps what particles bring apart from what the step gives them."""
        return self.aggregation > 0

    @property
    def node_numbers(self) -> int:
        """Numbers per node that P2G makes: momentum and mass, or those of `transfer.p2g_apart`."""
        return 8 if self.apart else 4


@dataclasses.dataclass(frozen=True)
class Sharpened:
    """Lumped masses, the increments of velocity sharpened by a stencil of seven nodes.

    What stress, viscosity and forces without a gradient do is sharpened, and what boundaries and constraints oppose it
    with. Both act twice in a substep: a prescribed motion whose windows have smooth edges takes over earlier in them.
    Angular momentum is kept to some 2e-4, not to round-off. P2G carries eight numbers a node in place of four.

    Attributes:
        apart, node_numbers: As of `Lumped`.
        beta: Strength, in (0, 0.25]. For a Courant number Cr = c dt / dx the error of second order in the cell's size
            vanishes at 0.216 - Cr^2/12 (MLS stress; 0.25 - Cr^2/12 with the gradient form).
        aggregation: As of `Lumped`.

    Raises:
        UserError: ``beta`` or ``aggregation`` is out of range.
    """

    apart: ClassVar[bool] = True
    node_numbers: ClassVar[int] = 8
    beta: float = 0.18
    aggregation: float = 0.0

    def __post_init__(self):
        _check_aggregation(self)
        if not 0 < self.beta <= MOST_BETA:
            raise UserError(f"`Sharpened.beta` must be within (0, {MOST_BETA}]", got=self.beta)


def _check_aggregation(inertia: Lumped | Sharpened) -> None:
    if not 0 <= inertia.aggregation <= MOST_AGGREGATION:
        kind = type(inertia).__name__
        raise UserError(
            f"`{kind}.aggregation` must be within [0, {MOST_AGGREGATION}]", got=inertia.aggregation
        )


def sum_neighbours(values: jax.Array) -> jax.Array:
    """Sums over each node and its 26 neighbours, of numbers of shape (nx, ny, nz, k)."""
    return jax.lax.reduce_window(values, 0.0, jax.lax.add, (3, 3, 3, 1), (1, 1, 1, 1), "SAME")


def aggregate(
    aggregation: float,
    nodes: jax.Array,
    unit: jax.Array,
    least: jax.Array,
    sum_neighbours: Callable[[jax.Array], jax.Array] = sum_neighbours,
) -> jax.Array:
    """The impulses given to the nodes, with which light ones follow their neighbours [kg m/s], shape (nx, ny, nz, 3).

    Args:
        aggregation: As of `Lumped`.
        nodes: Numbers of the nodes, as `transfer.p2g_apart` makes them, shape (nx, ny, nz, 8).
        unit: As of `count_particles` [1/kg].
        least: As of `count_particles` [kg]; nodes with next to nothing of it stay by themselves.
        sum_neighbours: As the function of that name.
    """
    scaled, given = unit * nodes[..., 3:4], nodes[..., 4:7]
    some = scaled > NEXT_TO_NOTHING * least * unit
    m = jnp.where(some, scaled, 0.0)
    sums = sum_neighbours(jnp.concatenate([m, m * m], axis=-1))
    total, squares = sums[..., :1], jnp.where(some, sums[..., 1:], 1.0)
    own = jnp.where(some, jnp.minimum(m * total / (aggregation * squares), 1.0), 1.0)
    share = (1 - own) / squares
    handed = sum_neighbours(share * jnp.concatenate([given, m], axis=-1))
    mass = jnp.where(some, own * m + m * m * handed[..., 3:], 1.0)
    dv = jnp.where(some, (own * given + m * m * handed[..., :3]) / mass, 0.0)
    return jnp.where(some, m * (own * dv + share * sum_neighbours(m * m * dv)), given)


def aggregated_velocity(
    aggregation: float,
    nodes: jax.Array,
    unit: jax.Array,
    least: jax.Array,
    empty: jax.Array,
    sum_neighbours: Callable[[jax.Array], jax.Array] = sum_neighbours,
) -> jax.Array:
    """Node velocities [m/s] of which light ones follow their neighbours' increments, shape (nx, ny, nz, 3).

    Args:
        aggregation: As of `Lumped`.
        nodes: As of `aggregate`.
        unit: As of `aggregate` [1/kg].
        least: As of `aggregate` [kg].
        sum_neighbours: As the function of that name.
        empty: Mass up to which a node has no velocity [kg].
    """
    momentum = nodes[..., :3] + aggregate(aggregation, nodes, unit, least, sum_neighbours)
    some = nodes[..., 3:4] > empty
    return jnp.where(some, momentum / jnp.where(some, nodes[..., 3:4], 1.0), 0.0)


def sharpen(
    beta: float,
    increments: jax.Array,
    mass: jax.Array,
    squares: jax.Array,
    unit: jax.Array,
    least: jax.Array,
) -> jax.Array:
    """The change to ``increments``: beta / m_i sum_j m_ij (dv_i - dv_j), shape (nx, ny, nz, 3).

    Args:
        beta: Strength.
        increments: Changes of node velocities [m/s], shape (nx, ny, nz, 3).
        mass: Node masses [kg], shape (nx, ny, nz).
        squares: sum w m^2 ``unit`` [kg], same shape.
        unit: As of `count_particles` [1/kg].
        least: As of `count_particles` [kg].
    """
    count, flows = count_particles(mass, squares, unit, least), jnp.zeros_like(increments)
    for axis in range(3):
        sides = [[slice(None)] * 3, [slice(None)] * 3]
        sides[0][axis], sides[1][axis] = slice(0, -1), slice(1, None)
        low, high = map(tuple, sides)
        share = jnp.minimum(jnp.minimum(count[low], count[high]) / FULL, 1.0)
        edge = jnp.minimum(mass[low], mass[high]) * share
        flow = edge[..., None] * (increments[high] - increments[low])
        room = [(0, 0)] * 4
        at_high, at_low = ([*room[:axis], side, *room[axis + 1 :]] for side in ((1, 0), (0, 1)))
        flows = flows + (jnp.pad(flow, at_high) - jnp.pad(flow, at_low))
    some = count > 0
    return jnp.where(some[..., None], beta * flows / jnp.where(some, mass, 1.0)[..., None], 0.0)


def sharpened_velocity(
    beta: float,
    nodes: jax.Array,
    opposed: jax.Array | None,
    unit: jax.Array,
    least: jax.Array,
    empty: jax.Array,
) -> jax.Array:
    """Node velocities [m/s] with their increments sharpened, shape (nx, ny, nz, 3).

    Args:
        beta: Strength.
        nodes: Numbers of the nodes, as `transfer.p2g_apart` makes them, shape (nx, ny, nz, 8).
        opposed: The velocities that boundaries and constraints make of those after the step [m/s], shape
            (nx, ny, nz, 3); None = there are none.
        unit: As of `count_particles` [1/kg].
        least: As of `count_particles` [kg].
        empty: Mass up to which a node has no velocity [kg].
    """
    mass = nodes[..., 3:4]
    inverse = jnp.where(mass > empty, 1 / jnp.where(mass > empty, mass, 1.0), 0.0)
    old, given = inverse * nodes[..., :3], inverse * nodes[..., 4:7]
    increments = given if opposed is None else opposed - old
    gained = sharpen(beta, increments, mass[..., 0], nodes[..., 7], unit, least)
    return (old + given if opposed is None else opposed) + gained


def count_particles(mass: jax.Array, squares: jax.Array, unit: jax.Array, least: jax.Array) -> jax.Array:
    """Particles per node, (sum w m)^2 / sum w m^2, shape (nx, ny, nz); one alone has its weight.

    It counts the heavy ones among light ones: such a one is as good as alone.

    Args:
        mass: sum w m [kg], shape (nx, ny, nz).
        squares: sum w m^2 unit [kg], same shape.
        unit: One over a mass of the particles' size [1/kg], for single precision to hold all this.
        least: Mass of the lightest particle [kg]; nodes with next to nothing of it have none.
    """
    some = mass > NEXT_TO_NOTHING * least
    return jnp.where(some, unit * mass * (mass / jnp.where(some, squares, 1.0)), 0.0)
