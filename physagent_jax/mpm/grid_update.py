"""The grid's part of a substep: node velocities from momentum and mass, boundaries, constraints, damping."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm import constraints, inertia, kernels, reductions, transfer
from physagent_jax.mpm.conform import as_field
from physagent_jax.mpm.inertia import Lumped
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import stencil


def update_grid(
    model: Model, state: State, nodes: jax.Array
) -> tuple[jax.Array, jax.Array, jax.Array | None, jax.Array]:
    """From the ``nodes`` of `step.scatter`: node_mass, free_velocity, sharpening and velocity of `step.StepTrace`."""
    node_mass = nodes[..., 3]
    s = stencil(state.x, model.grid)  # compiled away where nothing is constrained

    def oppose(velocity: jax.Array) -> jax.Array:
        bounded = apply_boundaries(model, velocity, state.time)
        return constraints.on_grid(model, velocity, bounded, node_mass, s, state.time)

    if not model.inertia.apart:
        folded = grid_velocity(model, fold_boundaries(model, nodes))
        return node_mass, grid_velocity(model, nodes), None, oppose(damp(model, folded))
    kernel = kernels.load_cpu_kernels() if kernels.use_cpu(model.kernels) else inertia
    masses, aggregation = (find_mass_unit(model), find_least_mass(model)), model.inertia.aggregation
    mirrored = jnp.concatenate([_mirror(model, nodes[..., :4]), _mirror(model, nodes[..., 4:])], axis=-1)
    if isinstance(model.inertia, Lumped):
        free, moved = (
            kernel.aggregated_velocity(aggregation, each, *masses, find_empty_mass(model, each))
            for each in (nodes, mirrored)
        )
        return node_mass, free, None, oppose(damp(model, moved))
    if aggregation:
        nodes, mirrored = (
            jnp.concatenate(
                [each[..., :4], kernel.aggregate(aggregation, each, *masses), each[..., 7:]], axis=-1
            )
            for each in (nodes, mirrored)
        )
    free, moved = grid_velocity(model, _join(nodes)), grid_velocity(model, _join(mirrored))
    # With what opposes them: matter at rest has no increments then, so that its equilibrium is that of lumped masses.
    opposed = oppose(moved) if model.boundaries or model.constraints else None
    empty = find_empty_mass(model, nodes)
    velocity = kernel.sharpened_velocity(model.inertia.beta, mirrored, opposed, *masses, empty)
    sharpening = velocity - (moved if opposed is None else opposed)
    return node_mass, free, sharpening, oppose(damp(model, velocity))


def _join(nodes: jax.Array) -> jax.Array:
    """Momentum and mass of the nodes of `transfer.p2g_apart`, all together, shape (nx, ny, nz, 4)."""
    return jnp.concatenate([nodes[..., :3] + nodes[..., 4:7], nodes[..., 3:4]], axis=-1)


def _mirror(model: Model, nodes: jax.Array) -> jax.Array:
    """Nodes with what lies behind planes of symmetry, shape (nx, ny, nz, 4)."""
    return unfold_boundaries(model, fold_boundaries(model, nodes))


def grid_velocity(model: Model, nodes: jax.Array) -> jax.Array:
    """Node velocities [m/s] from momentum and mass; empty nodes stay at zero."""
    use_cpu = kernels.use_cpu(model.kernels)
    divide = kernels.load_cpu_kernels().grid_velocity if use_cpu else transfer.grid_velocity
    return divide(nodes, find_empty_mass(model, nodes))


def find_empty_mass(model: Model, nodes: jax.Array) -> jax.Array:
    """Mass up to which a node counts as empty [kg]: eps^1.5 of the lightest particle's.

    Every particle's weight there is smaller still, so that its velocity would be lost in round-off; but the derivative
    of momentum / mass divides by the mass squared, which in float32 underflows.
    """
    return jnp.finfo(nodes.dtype).eps ** 1.5 * find_least_mass(model)


def find_least_mass(model: Model) -> jax.Array:
    """Least mass of a particle [kg], a constant to derivatives."""
    if model.axis is None:
        return jax.lax.stop_gradient(model.mass.min())
    return reductions.min_devices(
        jnp.where(model.mass > 0, model.mass, jnp.inf).min(), model.axis
    )  # padding aside


def find_mass_unit(model: Model) -> jax.Array:
    """One over the greatest mass of a particle [1/kg], a constant to derivatives."""
    return jax.lax.stop_gradient(1 / reductions.max_devices(model.mass.max(), model.axis))


def fold_boundaries(model: Model, nodes: jax.Array) -> jax.Array:
    """Momentum and mass at the nodes with what boundaries add to them, shape (nx, ny, nz, 4)."""
    for boundary in model.boundaries:
        nodes = boundary.fold(nodes, model.grid)
    return nodes


def unfold_boundaries(model: Model, nodes: jax.Array) -> jax.Array:
    """Folded momentum and mass with the images in place, shape (nx, ny, nz, 4)."""
    for boundary in model.boundaries:
        nodes = boundary.unfold(nodes, model.grid)
    return nodes


def apply_boundaries(model: Model, velocity: jax.Array, time: jax.Array) -> jax.Array:
    """Node velocities after all boundaries [m/s]."""
    for boundary in model.boundaries:
        applied = boundary.apply(velocity, model.grid, time)
        velocity = as_field(applied, velocity, f"velocities after {type(boundary).__name__}")
    return velocity


def damp(model: Model, velocity: jax.Array) -> jax.Array:
    """Node velocities after the global damping of one substep."""
    return velocity if model.damping_rate is None else velocity * jnp.exp(-model.damping_rate * model.dt)
