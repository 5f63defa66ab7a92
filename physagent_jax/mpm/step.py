"""One substep of explicit MLS-MPM with affine transfers (Hu et al. 2018; Jiang et al. 2015).

x, v, C, F  --P2G-->  m_i, (m v)_i  --forces, boundaries-->  v_i  --G2P-->  v, C  -->  x, F
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm import constraints
from physagent_jax.mpm.linalg import matmul, transpose
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import g2p, p2g, stencil


def step(model: Model, state: State) -> State:
    """Advances ``state`` by ``model.dt``; pure, jittable, differentiable."""
    dt, grid = model.dt, model.grid
    with jax.named_scope("forces"):
        C = damped_affine(model, state.C) + dt * body_gradient(model, state)
        state = dataclasses.replace(state, v=state.v + dt * body_acceleration(model, state), C=C)
        state = constraints.before_p2g(model.constraints, state)
    with jax.named_scope("stress"):
        tau = kirchhoff_stress(model, state.F)
    with jax.named_scope("p2g"):
        s = stencil(state.x, grid)
        affine = model.mass[:, None, None] * state.C
        affine = affine - (dt * 4 / grid.dx**2) * model.volume[:, None, None] * tau
        nodes = p2g(s, grid, model.mass, model.mass[:, None] * state.v, affine)
    with jax.named_scope("grid_update"):
        node_mass = nodes[..., 3]
        velocity = grid_velocity(model, nodes)
        for boundary in model.boundaries:
            velocity = boundary.apply(velocity, grid, state.time)
        if model.constraints:
            velocity = constraints.on_grid(
                model.constraints, velocity, node_mass, s, grid, model.mass, state.time
            )
    with jax.named_scope("g2p"):
        v, C = g2p(s, grid, velocity)
        F = state.F + dt * matmul(C, state.F)
        after = dataclasses.replace(state, x=state.x + dt * v, v=v, C=C, F=F, time=state.time + dt)
        after = constraints.after_g2p(model.constraints, state, after, dt)
    with jax.named_scope("stop_at_walls"):
        return stop_at_walls(model, after)


def body_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of gravity and all force terms [m/s^2], shape (n, 3) or (3,)."""
    total = jnp.zeros(3, state.x.dtype) if model.gravity is None else model.gravity
    for force in model.forces:
        total = total + force.acceleration(state.x, state.v, model.mass, state.time, model.dt)
    return total


def body_gradient(model: Model, state: State) -> jax.Array | float:
    """Sum of the force terms' gradients [1/s^2], shape (n, 3, 3) or (3, 3); 0.0 if all are uniform."""
    gradients = [force.gradient(state.x, state.time, model.dt) for force in model.forces]
    return sum((g for g in gradients if g is not None), 0.0)


def kirchhoff_stress(model: Model, F: jax.Array) -> jax.Array:
    """Kirchhoff stress [Pa], shape (n, 3, 3), each block of particles by its own material."""
    return per_material(model, F, lambda material, block: material.stress(block))


def per_material(model: Model, F: jax.Array, function) -> jax.Array:
    """Applies ``function(material, F_block)`` to each material's block and joins the results."""
    if len(model.materials) == 1:
        return function(model.materials[0], F)
    results, start = [], 0
    for material in model.materials:
        results.append(function(material, F[start : start + material.count]))
        start += material.count
    return jnp.concatenate(results)


def damped_affine(model: Model, C: jax.Array) -> jax.Array:
    """C as the transfer scheme lets it through: PIC none, RPIC less of its symmetric part."""
    if model.transfer == "pic":
        return jnp.zeros_like(C)
    if model.rpic_damping == 0:
        return C
    r = model.rpic_damping
    return (1 - r) * C + (0.5 * r) * (C - transpose(C))


def grid_velocity(model: Model, nodes: jax.Array) -> jax.Array:
    """Node velocities [m/s] from momentum and mass, damped; empty nodes stay at zero.

    A node counts as empty below eps^1.5 of the lightest particle's mass. Every particle's weight there is
    smaller still, so that its velocity would be lost in round-off; but the derivative of momentum / mass
    divides by the mass squared, which in float32 underflows.
    """
    mass = nodes[..., 3:]
    lightest = jax.lax.stop_gradient(model.mass.min())
    occupied = mass > jnp.finfo(mass.dtype).eps ** 1.5 * lightest
    velocity = jnp.where(occupied, nodes[..., :3] / jnp.where(occupied, mass, 1.0), 0.0)
    if model.damping_rate > 0:
        velocity = velocity * jnp.exp(-model.damping_rate * model.dt)
    return velocity


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
