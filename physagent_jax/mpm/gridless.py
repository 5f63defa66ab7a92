"""A substep of a model that is one rigid body and nothing else: without a grid, in whose place is its motion.

Rigid velocities come back from the grid as they went there: quadratic B-splines reproduce what is linear, and APIC
keeps linear and angular momenta (Jiang et al. 2015). Its nodes have the body's centre, momenta and moment of inertia,
so that the results are those of the grid but for round-off. Stress within a rigid body does not move it. It may be
led: all of it by one prescribed motion after the other; and from some moment on it may be in fragments.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm import transfer
from physagent_jax.mpm.constraints import PrescribedMotion, RigidBody, Shatter
from physagent_jax.mpm.constraints.rigid import RigidMotion
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.linalg import matmul, matvec, skew
from physagent_jax.mpm.state import Model, State


def needs_grid(model: Model) -> bool:
    """Return whether ``model`` is anything but one rigid body that meets boundaries at its particles."""
    if not model.constraints or model.axis is not None:
        return True
    body, *leads = model.constraints
    alone = isinstance(body, RigidBody) and body.whole
    led = all(
        isinstance(lead, Shatter) or isinstance(lead, PrescribedMotion) and lead.leads_as_one
        for lead in leads
    )
    return not (alone and led and all(boundary.acts_on_points for boundary in model.boundaries))


def use_grid(model: Model) -> Model:
    """``model`` with a grid all the same: what is exchanged with boundaries is measured there (`mpm.ledger`)."""
    if needs_grid(model):
        return model
    body, *leads = model.constraints
    return model.replace(constraints=(dataclasses.replace(body, whole=False), *leads))


def drop_window(model: Model) -> Model:
    """``model`` without its window, if it needs no grid: another one is then no other program."""
    if needs_grid(model):
        return model
    return model.replace(grid=dataclasses.replace(model.grid, shape=(0, 0, 0)))


def move_body(model: Model, state: State, forced: State) -> tuple[State, Health]:
    """The state after a substep, and what was seen on the way.

    Args:
        model: One that does not need a grid.
        state: At the start.
        forced: The same with the v and C that forces have left.
    """
    bursts = [each for each in model.constraints if isinstance(each, Shatter)]
    whole = model.replace(constraints=tuple(each for each in model.constraints if each not in bursts))
    after = (
        _move_whole(whole, state, forced)
        if not bursts
        else jax.lax.cond(
            bursts[0].is_broken(state.time, model.dt),
            lambda: bursts[0].move(model, state, forced),
            lambda: _move_whole(whole, state, forced),
        )
    )
    return _stop_at_walls(model, dataclasses.replace(after, time=state.time + model.dt))


def _move_whole(model: Model, state: State, forced: State) -> State:
    body, *leads = model.constraints
    free = _measure_motion(model, forced)
    if model.damping_rate is not None:
        kept = jnp.exp(-model.damping_rate * model.dt)
        free = dataclasses.replace(free, velocity=kept * free.velocity, spin=kept * free.spin)
    v, w = body.oppose(model, free, model.mass, state.x, state.time)
    motion = dataclasses.replace(free, velocity=v, spin=matvec(free.inertia, w))
    for lead in leads:
        led = _measure_motion(model, lead.before_p2g(model, forced))
        held = lead.active(lead.read_clock(state.time, model.dt)).all()
        motion = jax.tree.map(lambda its, other, held=held: jnp.where(held, its, other), led, motion)
    x, turn, turned = motion.advance(model.dt)
    w = motion.angular_velocity(turn)
    after = dataclasses.replace(
        forced,
        x=x,
        v=turned.field(motion.velocity, w),
        C=jnp.broadcast_to(skew(w), forced.C.shape),
        F=matmul(turn, forced.F),
    )
    for lead in leads:
        after = lead.after_g2p(model, state, after)
    return after


def _measure_motion(model: Model, state: State) -> RigidMotion:
    return RigidMotion.of(model.mass, state.x, state.v, model.grid.dx, state.C)


def _stop_at_walls(model: Model, state: State) -> tuple[State, Health]:
    """As `step.stop_at_walls`."""
    low, high = transfer.find_walls(model.wall, model.grid)
    beyond = ((state.x < low) | (state.x > high)).any(-1).sum(dtype=jnp.int32)
    x, v = transfer.stop(low, high, state.x, state.v, beyond)
    speed = jnp.sqrt(jax.lax.stop_gradient((v**2).sum(-1)).max())
    health = Health.initial(state.x.dtype)
    finite = jnp.isfinite(speed) & jnp.isfinite(x).all()
    health = dataclasses.replace(health, max_speed=speed, finite=finite, beyond=beyond)
    return dataclasses.replace(state, x=x, v=v, stopped=state.stopped + beyond), health
