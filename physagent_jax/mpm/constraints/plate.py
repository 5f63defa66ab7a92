"""A plate that moves into the material: one jaw of a press."""

from __future__ import annotations

import dataclasses

import jax

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.half_space import HalfSpace
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import Stencil


@register_dataclass
@dataclasses.dataclass(frozen=True)
class MovingPlate(Constraint):
    """Contact with a moving half-space that comes and goes with a force field.

    The same contact as a boundary of the scene; as a constraint it is one of a force field's entries.

    Attributes:
        face: The plate: the solid half-space behind it, when it acts, and how it moves.
    """

    face: HalfSpace

    def before_p2g(self, model: Model, state: State) -> State:
        """Nothing: contact is on the grid."""
        del model
        return state

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Node velocities after contact with the plate [m/s], shape (nx, ny, nz, 3)."""
        del free, node_mass, s
        return self.face.apply(velocity, model.grid, time)

    def after_g2p(self, model: Model, before: State, after: State) -> State:
        """Nothing: contact is on the grid."""
        del model, before
        return after
