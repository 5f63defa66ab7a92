"""The simulator's pytrees: `Grid`, `Model` (what does not change during a rollout) and `State` (what does)."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.fields import PER_BLOCK, PER_PARTICLE
from physagent_jax.mpm.inertia import Lumped, Sharpened
from physagent_jax.mpm.materials.base import History, Material

_STATIC = dict(static=True)
_KNOWN = dict(
    transfer=("apic", "pic"), stress_form=("mls", "gradient"), kernels=("auto", "reference", "cpu", "cuda")
)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Grid:
    """A window of nodes in the domain [0, cells * dx]^3; node (i, j, k) sits at (origin + (i, j, k)) * dx.

    The window moves with the object (`mpm.window`), so its cost follows the object's size, not the
    domain's. Moving it is exact: the grid holds nothing between steps.

    Attributes:
        origin: Domain index of the window's low corner, int32, shape (3,).
        shape: Nodes of the window, static.
        dx: Spacing [m], static.
        cells: Cells along a side of the domain, static; its nodes are 0..cells.
    """

    origin: jax.Array
    shape: tuple[int, int, int] = dataclasses.field(metadata=_STATIC)
    dx: float = dataclasses.field(metadata=_STATIC)
    cells: int = dataclasses.field(metadata=_STATIC)

    @staticmethod
    def whole(size: float, cells: int) -> Grid:
        """The window that covers the whole domain of side ``size`` [m]."""
        nodes = cells + 1
        return Grid(to_device(np.zeros(3, np.int32)), (nodes, nodes, nodes), size / cells, cells)

    def node_positions(self, dtype) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Node coordinates [m], shapes (nx, 1, 1), (1, ny, 1), (1, 1, nz): they broadcast, never materialise."""
        indices = self.node_indices()
        return tuple(i.astype(dtype) * self.dx for i in indices)  # type: ignore[return-value]

    def place_nodes(self, dtype) -> jax.Array:
        """Node positions [m], shape (nx, ny, nz, 3)."""
        return jnp.stack(jnp.broadcast_arrays(*self.node_positions(dtype)), axis=-1)

    def node_indices(self) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Domain indices of the nodes, int32, broadcastable as `node_positions`."""
        out = []
        for axis, count in enumerate(self.shape):
            shape = [1, 1, 1]
            shape[axis] = count
            out.append((self.origin[axis] + jnp.arange(count, dtype=jnp.int32)).reshape(shape))
        return tuple(out)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Model:
    """Everything that `step` needs and does not change.

    Attributes:
        grid: The window of nodes.
        dt: Substep [s], scalar.
        gravity: [m/s^2], shape (3,); None = none (skipped).
        mass: Particle mass [kg], shape (n,).
        volume: Rest volume [m^3], shape (n,).
        materials: One `Material` per contiguous block of particles, in particle order. All share one velocity field:
            where blocks or pieces touch they stick, and neither slide nor part again (`mpm.limits`).
        forces: Body-force terms (`mpm.protocols.BodyForce`), summed.
        boundaries: `mpm.protocols.Boundary`, applied to grid velocities in order.
        constraints: `mpm.protocols.Constraint`, later ones win.
        viscosity: Dynamic viscosity eta [Pa s], shape (n,): a Newtonian stress 2 eta dev(sym grad v) beside the
            material's own, for fluids and as internal (Kelvin-Voigt) damping of solids; None = none (skipped).
        transfer: "apic" or "pic" (C is discarded), static.
        stress_form: How stress acts on nodes and grad v is read: "mls" (4 / dx^2 w_i (x_i - x), C; Hu et al. 2018)
            or "gradient" (grad w_i, the classical form), static.
        inertia: `Lumped()`, or `Sharpened(beta)`: two to three times less error of frequency at the same cells; either
            with ``aggregation``, which keeps free surfaces from creeping; static.
        rpic_damping: 0 = APIC, 1 = only the rotational part of C; static.
        damping_rate: Global damping of grid velocities [1/s], scalar; None = none (skipped).
        wall: Cells from the domain's faces at which particles are stopped, static. One: matter rests up to 1.5 cells
            deep in the walls of `boundaries.DomainBox`, and its stencil needs half a cell.
        kernels: "auto", "reference", "cpu" or "cuda" (see `physagent_jax.kernels`), static; forward-mode derivatives
            need "reference".
        axis: Mesh axis along which the particles are split over devices (`mpm.sharding` sets it), static; None = all
            particles are here (skipped).
    """

    grid: Grid
    dt: jax.Array
    gravity: jax.Array | None
    mass: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    volume: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    materials: tuple[Material, ...] = dataclasses.field(metadata=PER_BLOCK)
    forces: tuple[Any, ...] = ()
    boundaries: tuple[Any, ...] = ()
    constraints: tuple[Any, ...] = ()
    viscosity: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    transfer: Literal["apic", "pic"] = dataclasses.field(default="apic", metadata=_STATIC)
    stress_form: Literal["mls", "gradient"] = dataclasses.field(default="mls", metadata=_STATIC)
    inertia: Lumped | Sharpened = dataclasses.field(default=Lumped(), metadata=_STATIC)
    rpic_damping: float = dataclasses.field(default=0.0, metadata=_STATIC)
    damping_rate: jax.Array | float | None = None
    wall: int = dataclasses.field(default=1, metadata=_STATIC)
    kernels: Literal["auto", "reference", "cpu", "cuda"] = dataclasses.field(default="auto", metadata=_STATIC)
    axis: str | None = dataclasses.field(default=None, metadata=_STATIC)

    def __post_init__(self):
        for name, known in _KNOWN.items():
            if getattr(self, name) not in known:
                raise explain_unknown_name(f"`Model.{name}`", getattr(self, name), known)
        if not isinstance(self.inertia, Lumped | Sharpened):
            raise UserError("`Model.inertia` must be `Lumped(...)` or `Sharpened(...)`", got=self.inertia)
        if not 0 <= self.rpic_damping <= 1:
            raise UserError("`Model.rpic_damping` must be within [0, 1]", got=self.rpic_damping)
        rate = self.damping_rate
        if isinstance(rate, float | int) and not 0 <= rate < math.inf:
            raise UserError("`Model.damping_rate` must be finite and not negative", got=rate)
        if self.wall < 1:
            raise UserError("`Model.wall` must be 1 or more: a stencil needs the room", got=self.wall)

    def replace(self, **changes) -> Model:
        """A copy with ``changes``."""
        return dataclasses.replace(self, **changes)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class State:
    """Everything that changes during a rollout; a run restarts exactly from it.

    Attributes:
        x: Positions [m], shape (n, 3).
        v: Velocities [m/s], shape (n, 3).
        C: Affine velocity matrices (APIC) [1/s], shape (n, 3, 3).
        F: Elastic deformation gradients (all of the deformation where nothing is plastic), shape (n, 3, 3).
        history: What each material remembers, one entry per `Model.materials`; () = nothing at all.
        time: [s], scalar.
        stopped: Particle-steps at which a particle was stopped at the domain's wall, int32 scalar.
    """

    x: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    v: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    C: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    F: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    history: tuple[History, ...] = dataclasses.field(metadata=PER_BLOCK)
    time: jax.Array
    stopped: jax.Array

    @staticmethod
    def at_rest(x: jax.Array, v: jax.Array | None = None, materials: tuple[Material, ...] = ()) -> State:
        """Undeformed particles at ``x`` [m] with velocity ``v`` [m/s] (default zero), shapes (n, 3).

        ``materials`` are the model's; they may be left out if none of them remembers anything.
        """
        return State(
            x=x,
            **_make_rest_fields(x) | ({} if v is None else {"v": v}),
            history=tuple(material.initial_history() for material in materials),
        )


@jax.jit
def _make_rest_fields(x: jax.Array) -> dict[str, jax.Array]:
    count, dtype = x.shape[0], x.dtype
    return dict(
        v=jnp.zeros_like(x),
        C=jnp.zeros((count, 3, 3), dtype),
        F=jnp.broadcast_to(jnp.eye(3, dtype=dtype), (count, 3, 3)),
        time=jnp.zeros((), dtype),
        stopped=jnp.zeros((), jnp.int32),
    )
