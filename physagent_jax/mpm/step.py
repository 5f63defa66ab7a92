"""One substep of explicit MPM with affine transfers (Hu et al. 2018; Jiang et al. 2015).

x, v, C, tau  --forces, P2G-->  m_i, (m v)_i  --boundaries-->  v_i  --G2P-->  x, v, C, F  --return mapping-->  F, tau

The stress comes last, so that it can share its work with the return mapping; `step` and the loops make the first.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.ad_checkpoint import checkpoint_name

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import constraints, gridless, kernels, materials, reductions, transfer
from physagent_jax.mpm.conform import as_field, conform
from physagent_jax.mpm.grid_update import find_mass_unit, update_grid
from physagent_jax.mpm.health import Health, measure_health
from physagent_jax.mpm.linalg import transpose
from physagent_jax.mpm.materials import NeoHookean, viscous_stress
from physagent_jax.mpm.materials.base import History
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import STOPPED

NODES = "nodes"
"""Name for `jax.checkpoint_policies`: what costs a P2G to compute again in a reverse pass, as `STOPPED` a G2P."""


def step(model: Model, state: State) -> State:
    """Advance ``state`` by ``model.dt``; pure, jittable, differentiable.

    Raises:
        UserError: ``model`` and ``state`` do not fit each other (`conform`).
    """
    model, state = conform(model, state)
    with kernels.use_device_of(state.x):
        return substep(model, state, kirchhoff_stress(model, state))[0]


@register_dataclass
@dataclasses.dataclass(frozen=True)
class StepTrace:
    """The intermediate values of a substep, for `mpm.ledger`; compiled away where nobody reads them.

    Attributes:
        after_forces: Particles after body forces.
        after_constraints: Particles after body forces and constraints, as P2G sees them.
        node_mass: [kg], shape (nx, ny, nz).
        free_velocity: Node velocities before damping and boundaries [m/s], shape (nx, ny, nz, 3).
        sharpening: The part of ``velocity`` that `inertia.sharpen` has added before the boundaries [m/s], same shape;
            None = lumped masses.
        velocity: Node velocities after boundaries and constraints [m/s], same shape.
        gathered: Particles after G2P and return mapping, before constraints.
        trial: F before the return mapping, shape (n, 3, 3).
        health: Extremes over the particles.

    Where there is no grid (`mpm.gridless`), those of nodes are None.
    """

    after_forces: State
    after_constraints: State
    node_mass: jax.Array | None
    free_velocity: jax.Array | None
    sharpening: jax.Array | None
    velocity: jax.Array | None
    gathered: State
    trial: jax.Array
    health: Health


def substep(model: Model, state: State, tau: jax.Array) -> tuple[State, jax.Array, StepTrace]:
    """`step` with the stress before and after it [Pa], shape (n, 3, 3), and the trace of what happened in it.

    Args:
        model: As in `step`.
        state: At the start.
        tau: `kirchhoff_stress`, or what the substep before returned.
    """
    dt = model.dt
    with jax.named_scope("forces"):
        v = state.v + dt * body_acceleration(model, state)
        forced = dataclasses.replace(state, v=v, C=affine(model, state))
    if not gridless.needs_grid(model):
        with jax.named_scope("rigid"):
            after, health = gridless.move_body(model, state, forced)
        return after, tau, StepTrace(forced, forced, None, None, None, None, after, after.F, health)
    with jax.named_scope("constraints"):
        constrained = constraints.before_p2g(model, forced)
    with jax.named_scope("p2g"):
        push = find_push(model, state, forced, constrained) if model.inertia.apart else None
        nodes, state = scatter(model, state, constrained, tau, push)
        nodes = reductions.sum_devices(nodes, model.axis)  # one grid, whichever device a particle is on
        # Kept one number of all nodes after the other, as the grid update wants them: else it reads in strides.
        nodes = jnp.moveaxis(checkpoint_name(jnp.moveaxis(nodes, -1, 0), NODES), 0, -1)
    with jax.named_scope("grid_update"):
        node_mass, free, sharpening, velocity = update_grid(model, state, nodes)
    with jax.named_scope("g2p"):
        moved = gather(model, state, velocity)
    with jax.named_scope("stress"):
        F, history, tau = respond(model, moved.F, state.history)
        gathered = dataclasses.replace(
            state, x=moved.x, v=moved.v, C=moved.C, F=F, history=history, time=state.time + dt
        )
    with jax.named_scope("constraints"):
        after = constraints.after_g2p(model, state, gathered)
        after, health = stop_at_walls(model, state, velocity, after, moved.health)
        if model.constraints:  # F may have been turned
            tau = kirchhoff_stress(model, after)
    nodes = node_mass, free, sharpening, velocity
    return after, tau, StepTrace(forced, constrained, *nodes, gathered, moved.F, health)


def find_push(model: Model, state: State, forced: State, constrained: State) -> jax.Array:
    """The change of velocities by forces without a gradient [m/s], shape (n, 3), or (1, 3) zeros if there are none.

    P2G smooths it as it smooths the stress, so that it is sharpened with that. The other forces reach the nodes as they
    are. Of constrained particles it is what the constraints leave of it.
    """
    push = jnp.zeros((1, 3), state.v.dtype)
    for force, acceleration in iterate_accelerations(model, state):
        if force.gradient(state.x, state.time, model.dt) is None:
            push = push + model.dt * jnp.broadcast_to(acceleration, state.v.shape)
    if not model.forces or not model.constraints:
        return push
    without = constraints.before_p2g(model, dataclasses.replace(forced, v=forced.v - push))
    return constrained.v - without.v


def scatter(
    model: Model, state: State, constrained: State, tau: jax.Array, push: jax.Array | None = None
) -> tuple[jax.Array, State]:
    """Momentum and mass at the nodes, shape (nx, ny, nz, 4), with the stress ``tau`` and viscosity; and ``state``.

    ``constrained`` is ``state`` after forces and constraints. The state is as it was, but G2P is to take its x and F
    from here: a kernel's adjoint then adds up the derivatives by them.

    With ``push``, which is within the velocities, it and the stress are apart: shape (nx, ny, nz, 8), as of
    `transfer.p2g_apart`.
    """
    v, dv = constrained.v, jnp.zeros(3, constrained.v.dtype)
    if not model.forces and not model.constraints:  # gravity alone need not go through memory
        v, dv = state.v, model.dt * body_acceleration(model, state)
    form, grid, inputs = model.stress_form, model.grid, (model.mass, model.volume, dv, model.dt)
    eta = model.viscosity
    use_cpu, use_cuda = kernels.use_cpu(model.kernels), kernels.use_cuda(model.kernels)
    lame = None
    if makes_stress(model):
        law: Any = model.materials[0]
        lame = tuple(jnp.broadcast_to(parameter, model.mass.shape) for parameter in (law.mu, law.lam))
    if push is not None:
        v = v - push if model.forces else v
        viscous, total = None, tau
        if lame is not None:
            viscous, total = None if eta is None else (eta, state.C), constrained.F
        elif eta is not None:
            total = tau + viscous_stress(eta, state.C, state.F)
        x, C, unit = constrained.x, constrained.C, find_mass_unit(model)
        inputs = model.mass, model.volume, dv, push, unit, model.dt
        if use_cpu:
            p2g = kernels.load_cpu_kernels().p2g_apart
            nodes, x, F = p2g(form, grid, x, v, C, total, lame, viscous, *inputs)
            shared = lame is not None and viscous is None and not model.constraints
            return nodes, dataclasses.replace(state, x=x, F=F) if shared else state
        return transfer.p2g_apart(form, grid, x, v, C, total, *inputs), state
    if lame is not None and use_cuda:
        particles = constrained.x, v, constrained.C, constrained.F, *lame
        return kernels.load_cuda_kernels().p2g_neo_hookean(form, grid, *particles, *inputs), state
    if lame is not None:
        cpu = kernels.load_cpu_kernels()
        particles = constrained.x, v, constrained.C, constrained.F, *lame
        if eta is None:
            nodes, x, F = cpu.p2g_neo_hookean(form, grid, *particles, *inputs)
            return nodes, state if model.constraints else dataclasses.replace(state, x=x, F=F)
        return cpu.p2g_kelvin_voigt(form, grid, *particles, eta, state.C, *inputs), state
    total = tau if eta is None else tau + viscous_stress(eta, state.C, state.F)
    p2g = choose_transfer(model).p2g
    return p2g(form, grid, constrained.x, v, constrained.C, total, *inputs), state


def makes_stress(model: Model) -> bool:
    """Return whether P2G makes the stress on the way: nobody reads the ``tau`` of `substep`, nor is it computed."""
    if [type(material) for material in model.materials] != [NeoHookean]:  # a subclass may differ
        return False
    if kernels.use_cuda(model.kernels):
        return not model.inertia.apart and model.viscosity is None
    return kernels.use_cpu(model.kernels)


def choose_transfer(model: Model) -> Any:
    """The module whose ``p2g`` and ``g2p`` the model takes."""
    if kernels.use_cpu(model.kernels):
        return kernels.load_cpu_kernels()
    return kernels.load_cuda_kernels() if kernels.use_cuda(model.kernels) else transfer


def gather(model: Model, state: State, velocity: jax.Array) -> transfer.Moved:
    """Particles moved and deformed with the node velocities."""
    g2p = choose_transfer(model).g2p
    options = model.stress_form, model.wall, model.grid
    return g2p(*options, state.x, state.v, state.C, state.F, velocity, model.dt)


def body_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of gravity and all force terms [m/s^2], shape (n, 3) or (3,)."""
    total = external_acceleration(model, state)
    return total if model.gravity is None else total + model.gravity


def external_acceleration(model: Model, state: State) -> jax.Array:
    """Sum of the force terms [m/s^2], shape (n, 3); (3,) zeros if there are none."""
    total = jnp.zeros(3, state.x.dtype)
    for _, acceleration in iterate_accelerations(model, state):
        total = total + acceleration
    return total


def iterate_accelerations(model: Model, state: State) -> Iterator[tuple[Any, jax.Array]]:
    """Each force term and its acceleration [m/s^2], shape (n, 3)."""
    with reductions.split_over(model.axis):
        for force in model.forces:
            made = force.acceleration(state.x, state.v, model.mass, state.time, model.dt)
            yield force, as_field(made, state.x, f"accelerations of {type(force).__name__}")


def affine(model: Model, state: State) -> jax.Array:
    """C as P2G is to see it [1/s], shape (n, 3, 3): damped, and with the gradients of the force terms."""
    C = damp_affine(model, state.C)
    with reductions.split_over(model.axis):
        for force in model.forces:
            gradient = force.gradient(state.x, state.time, model.dt)
            if gradient is not None:
                C = C + model.dt * as_field(gradient, C, f"gradients of {type(force).__name__}")
    return C


def kirchhoff_stress(model: Model, state: State) -> jax.Array:
    """Kirchhoff stress without viscosity [Pa], shape (n, 3, 3), each block of particles by its own material."""
    tau = map_materials(model, state, lambda material, F, history: material.stress(F, history))
    return as_field(tau, state.F, "stresses")


def respond(
    model: Model, trial: jax.Array, history: tuple[History, ...]
) -> tuple[jax.Array, tuple, jax.Array]:
    """Elastic deformation gradients after each material's return mapping, the new histories, and the stress [Pa]."""
    with kernels.use_kernels(model.kernels):
        blocks = [materials.respond(*block, model.dt) for block in _split_blocks(model, trial, history)]
    F, memories, tau = zip(*blocks)
    F, tau = (as_field(_join_blocks(part), trial, "what the materials make") for part in (F, tau))
    return F, memories if history else (), tau


def map_materials(model: Model, state: State, function) -> jax.Array:
    """Apply ``function(material, F, history)`` to each material's block and join the results."""
    with kernels.use_kernels(model.kernels):
        return _join_blocks([function(*block) for block in _split_blocks(model, state.F, state.history)])


def _join_blocks(blocks) -> jax.Array:
    return blocks[0] if len(blocks) == 1 else jnp.concatenate(blocks)


def _split_blocks(model: Model, F: jax.Array, history: tuple[History, ...]):
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


def damp_affine(model: Model, C: jax.Array) -> jax.Array:
    """C as the transfer scheme lets it through: PIC none, RPIC less of its symmetric part."""
    if model.transfer == "pic":
        return jnp.zeros_like(C)
    if model.rpic_damping == 0:
        return C
    r = model.rpic_damping
    return (1 - r) * C + (0.5 * r) * (C - transpose(C))


def stop_at_walls(
    model: Model, before: State, velocity: jax.Array, state: State, health: Health
) -> tuple[State, Health]:
    """Stop particles ``model.wall`` cells before the domain's faces, and count them.

    ``state`` is what has become of ``before`` with the node velocities ``velocity``.

    The walls of `boundaries.DomainBox` act before; this is the last line of defence, because a particle
    without a full stencil would deposit elsewhere. Nothing is done where G2P has seen none there.
    """
    if model.constraints:  # they have moved particles since
        strain = jnp.zeros((), state.x.dtype)
        seen = measure_health(model.wall, model.grid, state.x, state.v, state.F, strain)
        health = dataclasses.replace(
            health, max_speed=seen.max_speed, outside=seen.outside, beyond=seen.beyond
        )
    low, high = transfer.find_walls(model.wall, model.grid)
    if model.axis is not None:
        beyond = ((state.x < low) | (state.x > high)).any(-1) & (model.mass > 0)  # padding does not count
        health = dataclasses.replace(health, beyond=beyond.sum(dtype=jnp.int32)).reduce(model.axis)
    if kernels.use_cpu(model.kernels) and not model.constraints:
        made_of = before.x, before.F, velocity, model.dt
        beyond = checkpoint_name(health.beyond, STOPPED)
        stop = partial(kernels.load_cpu_kernels().stop, model.stress_form, model.wall, model.grid, *made_of)
    else:
        stop, beyond = partial(transfer.stop, low, high), health.beyond
    x, v = stop(state.x, state.v, beyond)
    return dataclasses.replace(state, x=x, v=v, stopped=state.stopped + health.beyond), health
