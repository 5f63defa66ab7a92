"""One substep of explicit MPM with affine transfers (Hu et al. 2018; Jiang et al. 2015).

x, v, C, tau  --forces, P2G-->  m_i, (m v)_i  --boundaries-->  v_i  --G2P-->  x, v, C, F  --return mapping-->  F, tau

The stress comes last, so that it can share its work with the return mapping; `step` and the loops make the first.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import constraints, kernels, materials, reductions, transfer
from physagent_jax.mpm.boundaries.symmetry_plane import SymmetryPlane
from physagent_jax.mpm.conform import as_field, conform
from physagent_jax.mpm.linalg import determinant, transpose
from physagent_jax.mpm.materials import NeoHookean
from physagent_jax.mpm.materials.base import History
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import stencil


def step(model: Model, state: State) -> State:
    """Advances ``state`` by ``model.dt``; pure, jittable, differentiable.

    Raises:
        UserError: ``model`` and ``state`` do not fit each other (`conform`).
    """
    model, state = conform(model, state)
    with kernels.beside(state.x):
        return substep(model, state, initial_stress(model, state))[0]


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
        watch: Extremes over the particles.
    """

    pushed: State
    held: State
    node_mass: jax.Array
    free: jax.Array
    velocity: jax.Array
    gathered: State
    trial: jax.Array
    watch: transfer.Watch


def substep(model: Model, state: State, tau: jax.Array | None) -> tuple[State, jax.Array | None, Trace]:
    """`step` with the stress before and after it [Pa], shape (n, 3, 3), and the trace of what happened in it.

    Args:
        model: As in `step`.
        state: At the start.
        tau: `initial_stress`, or what the substep before returned.
    """
    dt, grid = model.dt, model.grid
    with jax.named_scope("forces"):
        C = affine(model, state)
        pushed = dataclasses.replace(state, v=state.v + dt * body_acceleration(model, state), C=C)
        held = constraints.before_p2g(model, pushed)
    with jax.named_scope("p2g"):
        viscous = None if model.viscosity is None else viscous_stress(model.viscosity, state)
        nodes = scatter(model, state, held, tau if tau is None or viscous is None else tau + viscous)
        nodes = reductions.total(nodes, model.axis)  # one grid, whichever device a particle is on
    with jax.named_scope("grid_update"):
        node_mass = nodes[..., 3]
        free = grid_velocity(model, nodes)
        unmet = velocity = damped(model, folded_velocity(model, nodes, free))
        for boundary in model.boundaries:
            met = boundary.apply(velocity, grid, state.time)
            velocity = as_field(met, velocity, f"velocities after {type(boundary).__name__}")
        s = stencil(state.x, grid)  # compiled away where nothing is constrained
        velocity = constraints.on_grid(model, unmet, velocity, node_mass, s, state.time)
    with jax.named_scope("g2p"):
        moved = gather(model, state, velocity)
    with jax.named_scope("stress"):
        F, history, stress = respond(model, moved.F, state.history)
        gathered = dataclasses.replace(
            state, x=moved.x, v=moved.v, C=moved.C, F=F, history=history, time=state.time + dt
        )
    with jax.named_scope("constraints"):
        after = constraints.after_g2p(model, state, gathered)
        after, watch = stop_at_walls(model, after, moved.watch)
        if model.constraints:  # F may have been turned
            stress = kirchhoff_stress(model, after)
        tau = None if tau is None else stress
    return after, tau, Trace(pushed, held, node_mass, free, velocity, gathered, moved.F, watch)


def scatter(model: Model, state: State, held: State, tau: jax.Array | None) -> jax.Array:
    """Momentum and mass at the nodes, shape (nx, ny, nz, 4); ``held`` is ``state`` after forces and constraints."""
    v, push = held.v, jnp.zeros(3, held.v.dtype)
    if not model.forces and not model.constraints:  # gravity alone need not go through memory
        v, push = state.v, model.dt * body_acceleration(model, state)
    form, grid, matter = model.stress_form, model.grid, (model.mass, model.volume, push, model.dt)
    if tau is None:
        law: Any = model.materials[0]
        p2g = kernels.compiled().p2g_neo_hookean
        mu, lam = (jnp.broadcast_to(parameter, model.mass.shape) for parameter in (law.mu, law.lam))
        return p2g(form, grid, held.x, v, held.C, held.F, mu, lam, *matter)
    p2g = kernels.compiled().p2g if kernels.use_cpu(model.kernels) else transfer.particles_to_grid
    return p2g(form, grid, held.x, v, held.C, tau, *matter)


def initial_stress(model: Model, state: State) -> jax.Array | None:
    """What `substep` needs first: the Kirchhoff stress, or None where a kernel's P2G makes it from F."""
    alone = len(model.materials) == 1 and isinstance(model.materials[0], NeoHookean)
    if alone and model.viscosity is None and kernels.use_cpu(model.kernels):
        return None
    return kirchhoff_stress(model, state)


def gather(model: Model, state: State, velocity: jax.Array) -> transfer.Moved:
    """Particles moved and deformed with the node velocities."""
    g2p = kernels.compiled().g2p if kernels.use_cpu(model.kernels) else transfer.grid_to_particles
    options = model.stress_form, model.wall, model.grid
    return g2p(*options, state.x, state.v, state.C, state.F, velocity, model.dt)


def body_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of gravity and all force terms [m/s^2], shape (n, 3) or (3,)."""
    total = external_acceleration(model, state)
    return total if model.gravity is None else total + model.gravity


def external_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of the force terms [m/s^2], shape (n, 3); (3,) zeros if there are none."""
    total = jnp.zeros(3, state.x.dtype)
    with reductions.split_over(model.axis):
        for force in model.forces:
            made = force.acceleration(state.x, state.v, model.mass, state.time, model.dt)
            total = total + as_field(made, state.x, f"accelerations of {type(force).__name__}")
    return total


def affine(model: Model, state: State) -> jax.Array:
    """C as P2G is to see it [1/s], shape (n, 3, 3): damped, and with the gradients of the force terms."""
    C = damped_affine(model, state.C)
    with reductions.split_over(model.axis):
        for force in model.forces:
            gradient = force.gradient(state.x, state.time, model.dt)
            if gradient is not None:
                C = C + model.dt * as_field(gradient, C, f"gradients of {type(force).__name__}")
    return C


def kirchhoff_stress(model: Model, state: State) -> jax.Array:
    """Kirchhoff stress without viscosity [Pa], shape (n, 3, 3), each block of particles by its own material."""
    tau = per_material(model, state, lambda material, F, history: material.stress(F, history))
    return as_field(tau, state.F, "stresses")


def viscous_stress(viscosity: jax.Array, state: State) -> jax.Array:
    """Newtonian Kirchhoff stress 2 eta J dev(sym grad v) [Pa], shape (n, 3, 3)."""
    D = 0.5 * (state.C + transpose(state.C))
    mean = (D[:, 0, 0] + D[:, 1, 1] + D[:, 2, 2])[:, None, None] / 3
    deviator = D - mean * jnp.eye(3, dtype=D.dtype)
    return (2 * viscosity * determinant(state.F))[:, None, None] * deviator


def respond(
    model: Model, trial: jax.Array, history: tuple[History, ...]
) -> tuple[jax.Array, tuple, jax.Array]:
    """Elastic deformation gradients after each material's return mapping, the new histories, and the stress [Pa]."""
    with kernels.using(model.kernels):
        blocks = [materials.respond(*block, model.dt) for block in _blocks(model, trial, history)]
    F, memories, tau = zip(*blocks)
    F, tau = (as_field(_joined(part), trial, "what the materials make") for part in (F, tau))
    return F, memories if history else (), tau


def per_material(model: Model, state: State, function) -> jax.Array:
    """Applies ``function(material, F, history)`` to each material's block and joins the results."""
    with kernels.using(model.kernels):
        return _joined([function(*block) for block in _blocks(model, state.F, state.history)])


def _joined(blocks) -> jax.Array:
    return blocks[0] if len(blocks) == 1 else jnp.concatenate(blocks)


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
    lightest = jax.lax.stop_gradient(_lightest(model))
    occupied = mass > jnp.finfo(mass.dtype).eps ** 1.5 * lightest
    return jnp.where(occupied, nodes[..., :3] / jnp.where(occupied, mass, 1.0), 0.0)


def _lightest(model: Model) -> jax.Array:
    """Least mass of a particle [kg]."""
    if model.axis is None:
        return model.mass.min()
    return reductions.least(jnp.where(model.mass > 0, model.mass, jnp.inf).min(), model.axis)  # padding aside


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


def stop_at_walls(model: Model, state: State, watch: transfer.Watch) -> tuple[State, transfer.Watch]:
    """Stops particles ``model.wall`` cells before the domain's faces, and counts them.

    The walls of `boundaries.DomainBox` act before; this is the last line of defence, because a particle
    without a full stencil would deposit elsewhere. Nothing is done where G2P has seen none there.
    """
    if model.constraints:  # they have moved particles since
        strain = jnp.zeros((), state.x.dtype)
        seen = transfer.watch(model.wall, model.grid, state.x, state.v, state.F, strain)
        watch = dataclasses.replace(watch, max_speed=seen.max_speed, outside=seen.outside, beyond=seen.beyond)
    low, high = model.wall * model.grid.dx, (model.grid.cells - model.wall) * model.grid.dx
    if model.axis is not None:
        beyond = ((state.x < low) | (state.x > high)).any(-1) & (model.mass > 0)  # padding does not count
        watch = dataclasses.replace(watch, beyond=beyond.sum(dtype=jnp.int32)).over(model.axis)

    def stop(x, v):
        held = jnp.where(x < low, jnp.maximum(v, 0), jnp.where(x > high, jnp.minimum(v, 0), v))
        return jnp.clip(x, low, high), held

    x, v = jax.lax.cond(watch.beyond > 0, stop, lambda x, v: (x, v), state.x, state.v)
    return dataclasses.replace(state, x=x, v=v, stopped=state.stopped + watch.beyond), watch
