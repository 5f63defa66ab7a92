"""One substep of explicit MPM with affine transfers (Hu et al. 2018; Jiang et al. 2015).

x, v, C, F  --forces, stress, P2G-->  m_i, (m v)_i  --boundaries-->  v_i  --G2P-->  x, v, C, F  --return mapping-->  F
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm import constraints
from physagent_jax.mpm.boundaries.symmetry_plane import SymmetryPlane
from physagent_jax.mpm.linalg import determinant, matmul, transpose
from physagent_jax.mpm.materials.base import History
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import Stencil, g2p, p2g, stencil, velocity_gradient
from physagent_jax.pytree import register_dataclass


def step(model: Model, state: State) -> State:
    """Advances ``state`` by ``model.dt``; pure, jittable, differentiable."""
    return substep(model, state)[0]


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Trace:
    """What happened within a substep, for `mpm.ledger`; compiled away where nobody looks.

    Attributes:
        pushed: Particles after body forces.
        held: Particles after body forces and constraints, as P2G sees them.
        node_mass: [kg], shape (nx, ny, nz).
        free: Node velocities before damping and boundaries [m/s], shape (nx, ny, nz, 3).
        velocity: Node velocities after boundaries and constraints [m/s], same shape.
        gathered: Particles after G2P and return mapping, before constraints.
        trial: F before the return mapping, shape (n, 3, 3).
    """

    pushed: State
    held: State
    node_mass: jax.Array
    free: jax.Array
    velocity: jax.Array
    gathered: State
    trial: jax.Array


def substep(model: Model, state: State) -> tuple[State, Trace]:
    """`step`, and the trace of what happened in it."""
    dt, grid = model.dt, model.grid
    with jax.named_scope("forces"):
        C = damped_affine(model, state.C) + dt * body_gradient(model, state)
        pushed = dataclasses.replace(state, v=state.v + dt * body_acceleration(model, state), C=C)
        held = constraints.before_p2g(model, pushed)
    with jax.named_scope("stress"):
        tau = kirchhoff_stress(model, state)
    with jax.named_scope("p2g"):
        s = stencil(state.x, grid)
        nodes = scatter(model, s, held, -dt * model.volume[:, None, None] * tau)
    with jax.named_scope("grid_update"):
        node_mass = nodes[..., 3]
        free = grid_velocity(model, nodes)
        unmet = velocity = damped(model, folded_velocity(model, nodes, free))
        for boundary in model.boundaries:
            velocity = boundary.apply(velocity, grid, state.time)
        velocity = constraints.on_grid(model, unmet, velocity, node_mass, s, state.time)
    with jax.named_scope("g2p"):
        v, C = g2p(s, grid, velocity)
        grad_v = C if model.stress_form == "mls" else velocity_gradient(s, grid, velocity)
        trial = state.F + dt * matmul(grad_v, state.F)
    with jax.named_scope("project"):
        F, history = project(model, trial, state.history)
        gathered = dataclasses.replace(
            state, x=state.x + dt * v, v=v, C=C, F=F, history=history, time=state.time + dt
        )
    with jax.named_scope("constraints"):
        after = constraints.after_g2p(model, state, gathered)
        after = stop_at_walls(model, after)
    return after, Trace(pushed, held, node_mass, free, velocity, gathered, trial)


def scatter(model: Model, s: Stencil, held: State, impulse: jax.Array) -> jax.Array:
    """Momentum and mass at the nodes, shape (nx, ny, nz, 4); ``impulse`` is -dt V0 tau, shape (n, 3, 3)."""
    mass, momentum = model.mass, model.mass[:, None] * held.v
    affine = model.mass[:, None, None] * held.C
    if model.stress_form == "mls":
        return p2g(s, model.grid, mass, momentum, affine + (4 / model.grid.dx**2) * impulse)
    return p2g(s, model.grid, mass, momentum, affine, impulse)


def body_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of gravity and all force terms [m/s^2], shape (n, 3) or (3,)."""
    total = external_acceleration(model, state)
    return total if model.gravity is None else total + model.gravity


def external_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of the force terms [m/s^2], shape (n, 3); (3,) zeros if there are none."""
    total = jnp.zeros(3, state.x.dtype)
    for force in model.forces:
        total = total + force.acceleration(state.x, state.v, model.mass, state.time, model.dt)
    return total


def body_gradient(model: Model, state: State) -> jax.Array | float:
    """Sum of the force terms' gradients [1/s^2], shape (n, 3, 3) or (3, 3); 0.0 if all are uniform."""
    gradients = [force.gradient(state.x, state.time, model.dt) for force in model.forces]
    return sum((g for g in gradients if g is not None), 0.0)


def kirchhoff_stress(model: Model, state: State) -> jax.Array:
    """Kirchhoff stress [Pa], shape (n, 3, 3), each block of particles by its own material; viscosity included."""
    tau = per_material(model, state, lambda material, F, history: material.stress(F, history))
    if model.viscosity is None:
        return tau
    return tau + viscous_stress(model.viscosity, state.F, state.C)


def viscous_stress(viscosity: jax.Array, F: jax.Array, grad_v: jax.Array) -> jax.Array:
    """Newtonian Kirchhoff stress 2 eta J dev(sym grad v) [Pa], shape (n, 3, 3)."""
    D = 0.5 * (grad_v + transpose(grad_v))
    mean = (D[:, 0, 0] + D[:, 1, 1] + D[:, 2, 2])[:, None, None] / 3
    deviator = D - mean * jnp.eye(3, dtype=D.dtype)
    return (2 * viscosity * determinant(F))[:, None, None] * deviator


def project(model: Model, trial: jax.Array, history: tuple[History, ...]) -> tuple[jax.Array, tuple]:
    """Elastic deformation gradients after each material's return mapping, and the new histories."""
    blocks, memories = [], []
    for material, F, past in _blocks(model, trial, history):
        F, past = material.project(F, past, model.dt)
        blocks.append(F)
        memories.append(past)
    F = blocks[0] if len(blocks) == 1 else jnp.concatenate(blocks)
    return F, tuple(memories) if history else ()


def per_material(model: Model, state: State, function) -> jax.Array:
    """Applies ``function(material, F, history)`` to each material's block and joins the results."""
    results = [function(*block) for block in _blocks(model, state.F, state.history)]
    return results[0] if len(results) == 1 else jnp.concatenate(results)


def _blocks(model: Model, F: jax.Array, history: tuple[History, ...]):
    """(material, its part of F, its history), one after the other."""
    if not history:
        history = tuple(() for _ in model.materials)
    expected = tuple(jax.eval_shape(material.initial_history) for material in model.materials)
    if jax.tree.structure(history) != jax.tree.structure(expected):
        raise ValueError(
            "`state.history` does not fit `model.materials`; make the state with "
            "`State.at_rest(x, v, materials=model.materials)`"
        )
    start = 0
    for material, past in zip(model.materials, history):
        yield material, F[start : start + material.count], past
        start += material.count


def damped_affine(model: Model, C: jax.Array) -> jax.Array:
    """C as the transfer scheme lets it through: PIC none, RPIC less of its symmetric part."""
    if model.transfer == "pic":
        return jnp.zeros_like(C)
    if model.rpic_damping == 0:
        return C
    r = model.rpic_damping
    return (1 - r) * C + (0.5 * r) * (C - transpose(C))


def grid_velocity(model: Model, nodes: jax.Array) -> jax.Array:
    """Node velocities [m/s] from momentum and mass; empty nodes stay at zero.

    A node counts as empty below eps^1.5 of the lightest particle's mass. Every particle's weight there is
    smaller still, so that its velocity would be lost in round-off; but the derivative of momentum / mass
    divides by the mass squared, which in float32 underflows.
    """
    mass = nodes[..., 3:]
    lightest = jax.lax.stop_gradient(model.mass.min())
    occupied = mass > jnp.finfo(mass.dtype).eps ** 1.5 * lightest
    return jnp.where(occupied, nodes[..., :3] / jnp.where(occupied, mass, 1.0), 0.0)


def folded_velocity(model: Model, nodes: jax.Array, free: jax.Array) -> jax.Array:
    """``free``, or what it becomes where planes of symmetry add images of matter."""
    mirrors = [boundary for boundary in model.boundaries if isinstance(boundary, SymmetryPlane)]
    if not mirrors:
        return free
    for mirror in mirrors:
        nodes = mirror.fold(nodes, model.grid)
    return grid_velocity(model, nodes)


def damped(model: Model, velocity: jax.Array) -> jax.Array:
    """Node velocities after the global damping of one substep."""
    return velocity * jnp.exp(-model.damping_rate * model.dt) if model.damping_rate > 0 else velocity


def stop_at_walls(model: Model, state: State) -> State:
    """Stops particles ``model.wall`` cells before the domain's faces, and counts them.

    The walls of `boundaries.DomainBox` act before; this is the last line of defence, because a particle
    without a full stencil would deposit elsewhere.
    """
    grid = model.grid
    low, high = model.wall * grid.dx, (grid.cells - model.wall) * grid.dx
    beyond_low, beyond_high = state.x < low, state.x > high
    x = jnp.clip(state.x, low, high)
    v = jnp.where(
        beyond_low, jnp.maximum(state.v, 0), jnp.where(beyond_high, jnp.minimum(state.v, 0), state.v)
    )
    count = (beyond_low | beyond_high).any(-1).sum(dtype=jnp.int32)
    return dataclasses.replace(state, x=x, v=v, stopped=state.stopped + count)
