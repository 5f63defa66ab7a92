"""Constraints within a substep: prescribed motions, also from end to end, rigid bodies, fragments, plates that press.

Each constraint acts at three places, in the order of `Model.constraints`: on the particles before P2G, on the
grid velocities, and on the particles after G2P. Where two claim the same particles, the later one wins.
"""

from __future__ import annotations

import jax

from physagent_jax.mpm.constraints.graded import GradedRotation as GradedRotation
from physagent_jax.mpm.constraints.graded import GradedTranslation as GradedTranslation
from physagent_jax.mpm.constraints.plate import MovingPlate as MovingPlate
from physagent_jax.mpm.constraints.prescribed import PrescribedMotion as PrescribedMotion
from physagent_jax.mpm.constraints.rigid import RigidBody as RigidBody
from physagent_jax.mpm.constraints.rotation import rotate as rotate
from physagent_jax.mpm.constraints.shatter import Shatter as Shatter
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import Stencil


def before_p2g(model: Model, state: State) -> State:
    """Give the constrained particles the v and C that P2G is to see."""
    for constraint in model.constraints:
        state = constraint.before_p2g(model, state)
    return state


def on_grid(
    model: Model, free: jax.Array, velocity: jax.Array, node_mass: jax.Array, s: Stencil, time: jax.Array
) -> jax.Array:
    """Grid velocities after all constraints [m/s]; arguments as in `protocols.Constraint`."""
    for constraint in model.constraints:
        velocity = constraint.on_grid(model, free, velocity, node_mass, s, time)
    return velocity


def after_g2p(model: Model, before: State, after: State) -> State:
    """Put the constrained particles where they belong."""
    for constraint in model.constraints:
        after = constraint.after_g2p(model, before, after)
    return after
