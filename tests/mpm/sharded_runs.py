"""Runs that `test_sharding` compares, in a process of its own with four devices and in double precision."""

from __future__ import annotations

import dataclasses
import gc
import sys
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, PartitionSpec

from physagent_jax.forces.terms import Stretch, Torque
from physagent_jax.mpm import (
    Fluid,
    HalfSpace,
    Lumped,
    NeoHookean,
    PrescribedMotion,
    Rigid,
    RigidBody,
    Sharpened,
    State,
    VonMises,
    rollout,
    rollout_sharded,
    stable_dt,
)
from physagent_jax.mpm.energy import angular_momentum, elastic_energy, momentum, total_energy
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.sharding import AXIS, ParticleLayout, find_specs
from physagent_jax.mpm.timestep import kinematic_dt
from tests.conftest import keep_freed_memory, lower_in_few_contexts, share_programs
from tests.mpm.blocks import block

UP = jnp.array([0.0, 0.0, 1.0])
LUMPED = Lumped()
COUNTS = dict(jelly=101, metal=70, drop=2, stone=42)  # none of them divisible by four; 215 particles


def make_materials(counts, youngs_modulus=4e4):
    mu, lam = youngs_modulus / 2.6, 0.3 * youngs_modulus / (1.3 * 0.4)

    def full(name, *values):
        return [jnp.full(counts[name], value) for value in values]

    laws = dict(
        jelly=NeoHookean(*full("jelly", mu, lam)),
        metal=VonMises(*full("metal", mu, lam, 200.0, 1e3)),
        drop=Fluid(*full("drop", lam)),
        stone=Rigid(counts["stone"]),
    )
    return tuple(laws[name] for name, count in counts.items() if count)


def scene(**changes):
    """A tilted, spinning block of four materials on a floor; a corner is held for a while, the top is a rigid body."""
    model, state = block((3, 3, 3), low=(0.4, 0.4, 0.22), dtype=np.float64, kernels="reference")
    counts = COUNTS | changes
    count = sum(counts.values())
    materials = make_materials(counts)
    x = state.x[:count]
    arm = x - x.mean(0)
    v = 4 * jnp.stack([-arm[:, 1], arm[:, 0], 2 * arm[:, 0]], -1) - 0.5 * UP
    # All held particles are the first device's, so that the others hold none.
    grip = dataclasses.replace(
        PrescribedMotion.fixed(jnp.arange(3, 10), jnp.float64),
        velocity=jnp.array([0.1, 0.0, 0.2]),
        angular_velocity=jnp.array([0.0, 1.0, 0.0]),
        center=x[0],
        end=jnp.linspace(0.005, 0.03, 7),
    )
    body = RigidBody(jnp.arange(count - counts["stone"], count))
    window = jnp.array(0.0), jnp.array(0.02)
    model = model.replace(
        gravity=-9.8 * UP,
        mass=model.mass[:count] * jnp.linspace(0.8, 1.2, count),
        volume=model.volume[:count],
        materials=materials,
        forces=(
            Torque(UP, jnp.array(60.0), *window, weight=(x[:, 0] > 0.45) * 1.0),
            Stretch(jnp.array([1.0, 0.0, 0.0]), jnp.array(30.0), *window, ramp=jnp.array(0.01)),
        ),
        boundaries=(
            HalfSpace(0.21 * UP, UP, jnp.array(0.3), jnp.array(0.0), jnp.array(jnp.inf)),
            *model.boundaries,
        ),
        constraints=(grip, body) if counts["stone"] else (grip,),
        viscosity=jnp.full(count, 5.0),
    )
    return model, State.at_rest(x, v, materials)


def gradients(run, inertia=LUMPED, **counts):
    """Of a loss over all particles, with respect to everything that shared and per-particle numbers can be."""
    model, state = scene(stone=0, **counts)
    forces = model.forces
    weight = jnp.asarray(np.random.default_rng(0).normal(size=state.x.shape))

    def loss(p):
        changed = model.replace(
            inertia=inertia,
            gravity=p["gravity"],
            mass=p["mass"],
            materials=jax.tree.map(lambda a: p["stiffness"] * a, model.materials),
            forces=(dataclasses.replace(forces[0], magnitude=p["torque"]), *forces[1:]),
        )
        end, path = run(changed, dataclasses.replace(state, v=p["v"]), frame_count=2, substeps=8)
        return (weight * end.x).sum() + (path.F[..., 0, 1] ** 2).sum()

    point = dict(
        gravity=model.gravity, mass=model.mass, stiffness=jnp.array(1.1), torque=jnp.array(50.0), v=state.v
    )
    return jax.grad(loss)(point)


def everything_reduced(model, state, about):
    """All that the simulator reduces over particles, over twelve substeps."""
    after, health, exchange = advance(model, state, jnp.asarray(12, jnp.int32), ledger=True)
    return dict(
        stable_dt=stable_dt(model, after),
        kinematic_dt=kinematic_dt(model, after, jnp.asarray(0.01)),
        energy=total_energy(model, after),
        elastic=elastic_energy(model, after),
        momentum=momentum(model, after),
        angular=angular_momentum(model, after, about),
        health=dataclasses.asdict(health),
        exchange=dataclasses.asdict(exchange),
    )


def reduced(devices=None):
    model, state = scene(metal=0)
    function = partial(everything_reduced, about=jnp.array([0.5, 0.4, 0.3]))
    if devices is None:
        return jax.jit(function)(model, state)
    layout = ParticleLayout(tuple(material.count for material in model.materials), len(devices))
    split, mesh = layout.split(model, state), Mesh(np.asarray(devices), (AXIS,))
    return jax.jit(jax.shard_map(function, mesh=mesh, in_specs=find_specs(split), out_specs=PartitionSpec()))(
        *split
    )


def loose():
    """Elastic matter that nothing holds, under a stretch: one program for the three runs below."""
    model, state = scene(metal=0, stone=0)
    return model.replace(gravity=None, boundaries=(), constraints=(), forces=model.forces[1:]), state


def free_flight():
    """Momentum before and after, without anything from outside."""
    model, state = loose()
    end, _ = rollout_sharded(model, state, frame_count=1, substeps=20)
    return [(momentum(model, s), angular_momentum(model, s, jnp.zeros(3))) for s in (state, end)]


def against_the_wall(run):
    """The last particle, of which there are twins, flies into the wall: positions, and how often it was stopped."""
    model, state = loose()
    state = dataclasses.replace(state, x=state.x.at[-1].set(jnp.array([0.1, 0.5, 0.5])))
    state = dataclasses.replace(state, v=state.v.at[-1].set(jnp.array([-5.0, 0, 0])))
    end, _ = run(model, state, frame_count=1, substeps=20)
    return end.x, end.stopped


def out_of_the_window():
    """A single particle of one device leaves the window, which is the whole domain but for its first nodes."""
    model, state = loose()
    state = dataclasses.replace(state, x=state.x.at[50].set(jnp.array([0.28, 0.5, 0.5])))
    state = dataclasses.replace(state, v=state.v.at[50].set(jnp.array([-8.0, 0, 0])))
    model = model.replace(grid=dataclasses.replace(model.grid, origin=jnp.array([4, 0, 0], jnp.int32)))
    return rollout_sharded(model, state, frame_count=1, substeps=20)[0].x


def quick():
    devices = jax.devices()
    on_three = partial(rollout_sharded, devices=devices[:3])  # 101 and 2 do not divide by three either
    model, state = scene()
    return dict(
        one=rollout(model, state, frame_count=3, substeps=10),
        four=rollout_sharded(model, state, frame_count=3, substeps=10),
        gradients_one=gradients(rollout, Sharpened(), metal=0),
        gradients_four=gradients(rollout_sharded, Sharpened(), metal=0),
        reduced_one=reduced(),
        reduced_four=reduced(devices),
        free_flight=free_flight(),
        wall_one=against_the_wall(rollout),
        wall_four=against_the_wall(rollout_sharded),
        wall_three=against_the_wall(on_three),
        out=out_of_the_window(),
    )


def thorough():
    """The derivatives of a law in principal stretches take a minute to compile."""
    return dict(gradients_one=gradients(rollout), gradients_four=gradients(rollout_sharded))


def main(which: str, file: str) -> None:
    assert jax.device_count() == 4
    gc.disable()  # next to none, and a tenth of the time goes into looking for it
    lower_in_few_contexts()
    keep_freed_memory()
    share_programs()
    leaves = jax.tree.leaves_with_path(dict(quick=quick, thorough=thorough)[which]())
    np.savez(file, **{jax.tree_util.keystr(path, simple=True, separator="/"): leaf for path, leaf in leaves})


if __name__ == "__main__":
    main(*sys.argv[1:])
