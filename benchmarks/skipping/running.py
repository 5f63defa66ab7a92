"""Skips of the loop over substeps: empty nodes, accounts that nobody asked for, steps that would be wasted."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.skipping.base import Answer, Pair, Sizes, Skip, State, Way
from benchmarks.skipping.scene import SIZE, both, cube, read_motion, reading, rolled, settled
from physagent_jax.mpm import DomainBox, Fluid, Grid, Model, cell_order, simulate
from physagent_jax.mpm import State as Particles
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.sorting import permute_particles, unpermute_particles, update_order
from physagent_jax.mpm.step import kirchhoff_stress, substep

THROW = (1.5, 0.7, 0.0)  # [m/s]
THROWN_FRAMES = 25  # of 0.04 s, after which the water has come back from the wall
TOO_LONG = 5.0  # times the step of the cube: 1.5 times its stable bound
WASTED = 10  # times the substeps of a run: a frame that fails early


def _compare_window(sizes: Sizes) -> Pair:
    model, state = cube(sizes)
    pair = both(model, model.replace(grid=Grid.whole(SIZE, sizes.cells)), state, sizes)
    window, whole = "x".join(map(str, model.grid.shape)), sizes.cells + 1
    return dataclasses.replace(pair, note=f"{window} of {whole}x{whole}x{whole} nodes")


def _compare_order(sizes: Sizes) -> Pair:
    """Sorted, against as they lie."""
    model, state = cube(sizes)
    order = cell_order(np.asarray(state.x), model.grid.dx)
    return Pair(
        _run_in_order(lambda: order, model, state, sizes),
        rolled(model, state, sizes.substeps),
        sizes.particles,
        sizes.substeps,
    )


def _compare_order_in_motion(sizes: Sizes) -> Pair:
    """Water that was sorted at rest, once it has been thrown against a wall."""
    model, state = cube(sizes, lambda mu, lam: Fluid(lam))
    x = state.x[cell_order(np.asarray(state.x), model.grid.dx)]
    state = Particles.at_rest(x, v=jnp.zeros_like(x) + jnp.asarray(THROW, x.dtype), materials=model.materials)
    thrown = model.replace(gravity=jnp.asarray([0, 0, -9.8], x.dtype), boundaries=(DomainBox(3),))
    *_, last = simulate(thrown, state, frame_count=THROWN_FRAMES + 1, frame_dt=0.04)
    model, state = settled(thrown, last.state, sizes.substeps), last.state
    return Pair(
        _run_in_order(lambda: update_order(None, model, state), model, state, sizes),
        rolled(model, state, sizes.substeps),
        sizes.particles,
        sizes.substeps,
    )


def _run_in_order(find: Callable[[], np.ndarray | None], model: Model, state: Particles, sizes: Sizes) -> Way:
    """A frame as `mpm.simulate` runs it: particles are put in an order, and back."""
    count = jnp.asarray(sizes.substeps, jnp.int32)

    def run():
        order = find()
        after, *rest = advance(*permute_particles(order, model, state), count)
        return model, unpermute_particles(order, model, after), *rest

    return Way(run, reading)


def _compare_ledger(sizes: Sizes) -> Pair:
    model, state = cube(sizes)
    lean, full = rolled(model, state, sizes.substeps), rolled(model, state, sizes.substeps, ledger=True)
    return Pair(lean, full, sizes.particles, sizes.substeps)


@jax.jit
def unwatched(model: Model, state: Particles, substeps: jax.Array) -> Particles:
    """`mpm.frame.advance` without looking at what goes on."""

    def body(_, carry):
        return substep(model, *carry)[:2]

    return jax.lax.fori_loop(0, substeps, body, (state, kirchhoff_stress(model, state)))[0]


@jax.jit
def unstopped(model: Model, state: Particles, substeps: jax.Array) -> jax.Array:
    """`mpm.frame.advance` to the end, come what may: how many substeps went well before the first that did not."""

    def body(_, carry):
        state, tau, good, count = carry
        state, tau, trace = substep(model, state, tau)
        good = good & trace.health.is_good(model)
        return state, tau, good, count + good

    start = state, kirchhoff_stress(model, state), jnp.array(True), jnp.zeros_like(substeps)
    return jax.lax.fori_loop(0, substeps, body, start)[-1]


def _compare_watching(sizes: Sizes) -> Pair:
    model, state = cube(sizes)
    count = jnp.asarray(sizes.substeps, jnp.int32)
    lean = Way(lambda: unwatched(model, state, count), read_motion)
    full = Way(lambda: advance(model, state, count)[0], read_motion)
    return Pair(lean, full, sizes.particles, sizes.substeps)


def _compare_early_stop(sizes: Sizes) -> Pair:
    """A frame whose step is too long: both ways must see when it goes wrong."""
    model, state = cube(sizes)
    model = model.replace(dt=TOO_LONG * model.dt)
    substeps = WASTED * sizes.substeps
    count = jnp.asarray(substeps, jnp.int32)

    def until_stopped(result) -> Answer:
        state, health, _ = result
        if health.is_good(model):
            raise RuntimeError("the frame that was meant to fail does not")
        return {"good substeps": round(float(state.time / model.dt)) - 1.0}

    return Pair(
        Way(lambda: advance(model, state, count), until_stopped),
        Way(lambda: unstopped(model, state, count), lambda good: {"good substeps": float(good)}),
        sizes.particles,
        unit="frame",
        note=lambda answer: f"the frame goes wrong after {answer['good substeps']:g} of {substeps} substeps",
    )


SKIPS = (
    Skip(
        "grid window",
        "nodes where there is no matter: the window of the grid follows the object",
        "`Grid.whole`, the whole domain",
        _compare_window,
    ),
    Skip(
        "order of particles",
        "jumps through memory, if particles lie in the order of their cells",
        "particles in random order",
        _compare_order,
        tolerance=1e-5,
        reason="node sums run in another order, with another round-off",
    ),
    Skip(
        "order in motion",
        "jumps through memory, if water that has spread is sorted again",
        "sorted once, at rest. Only water and sand mix at all. The lean way sorts in every run, and turns the "
        "particles back; the product sorts when they have mixed, which is every few frames",
        _compare_order_in_motion,
        tolerance=1e-5,
        reason="node sums run in another order, with another round-off",
    ),
    Skip(
        "ledger",
        "the accounts of energy and momentum, if nobody asks for them",
        "`ledger=True`",
        _compare_ledger,
    ),
    Skip(
        "early stop",
        "the remaining substeps of a frame that has to be redone",
        "all substeps of the frame, each of them watched; what must agree is which substep goes wrong first",
        _compare_early_stop,
    ),
    Skip(
        "health watch",
        "the watch over speed, volume and particles that leave, without which no frame could be trusted",
        "as the product has it; the lean way is a loop of the same substeps that looks at nothing. The walls need a "
        "part of the watch in either, and the CPU kernels' G2P always makes all of it",
        _compare_watching,
        State.KEPT,
    ),
)
