"""The scene of most rows: a deformed, moving elastic cube in free space, and how its substeps are run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.skipping.base import Answer, Pair, Sizes, Way
from physagent_jax.mpm import (
    Model,
    NeoHookean,
    State,
    find_smallest_window,
    fit_window,
    lame_parameters,
    stable_dt,
)
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.materials import Material

SIZE = 2.0  # side of the domain [m]
SIDE = 0.6  # of the cube [m]
DENSITY = 1000.0  # [kg/m^3]
YOUNGS_MODULUS = 1e5  # [Pa]
POISSONS_RATIO = 0.3
SPEED = 0.5  # largest at the start [m/s]
STRAIN = 0.05  # largest at the start: no stress is zero, no two singular values are equal
SAFETY = 0.3  # of the stable bound: the step suits both ways of every row


def cube(
    sizes: Sizes, law: Callable[[jax.Array, jax.Array], Material] = NeoHookean, dtype: Any = np.float32
) -> tuple[Model, State]:
    """Uniformly random particles in random order; the same ones whenever they are as many.

    Nothing acts on them: no gravity, force, boundary, constraint or damping. The grid is the window that
    `mpm.simulate` would choose.

    Args:
        sizes: How many particles, and cells.
        law: Makes the material from the Lame parameters, shape (n,) each.
        dtype: np.float32 or np.float64 (which needs x64 enabled).
    """
    count, rng = sizes.particles, np.random.default_rng(0)
    place = rng.uniform(size=(count, 3))
    waves = np.sin(2 * np.pi * place)
    x = jnp.asarray(0.5 * (SIZE - SIDE) + SIDE * place, dtype)
    v = jnp.asarray(SPEED * waves[:, [1, 2, 0]], dtype)
    tilt = rng.uniform(-1, 1, (3, 3))
    F = jnp.asarray(np.eye(3) + STRAIN * waves[:, :, None] * tilt, dtype)
    volume = jnp.full(count, SIDE**3 / count, dtype)
    mu, lam = lame_parameters(YOUNGS_MODULUS, POISSONS_RATIO)
    material = law(jnp.full(count, mu, dtype), jnp.full(count, lam, dtype))
    model = Model(
        grid=find_smallest_window(SIZE, sizes.cells),
        dt=jnp.zeros((), dtype),
        gravity=None,
        mass=DENSITY * volume,
        volume=volume,
        materials=(material,),
    )
    state = dataclasses.replace(State.at_rest(x, v, materials=(material,)), F=F)
    return settled(model, state, sizes.substeps), state


def settled(model: Model, state: State, substeps: int) -> Model:
    """``model`` with a step well below its bound, and a window for so many of them."""
    dt = SAFETY * float(stable_dt(model, state))
    x = np.asarray(state.x)
    reach = 4 * SPEED * dt * substeps + 2 * model.grid.dx
    grid = fit_window(model.grid, x.min(0), x.max(0), reach)
    return model.replace(grid=grid, dt=jnp.asarray(dt, state.x.dtype))


def rolled(model: Model, state: State, substeps: int, ledger: bool = False) -> Way:
    """``substeps`` of ``model``, as `mpm.simulate` runs a frame."""

    def run():
        return model, *advance(model, state, jnp.asarray(substeps, jnp.int32), ledger)

    return Way(run, reading)


def reading(result: tuple) -> Answer:
    """Particles at the end, and whether the frame can be trusted, from (model, state, health, ...)."""
    model, state, health, *_ = result
    return read_motion(state) | {"trusted": float(health.is_good(model))}


def read_motion(state: State) -> dict[str, np.ndarray]:
    """Arrays that a substep changes. Not C: it is the rate of F, and as a difference across a cell mostly round-off."""
    return {name: np.asarray(getattr(state, name)) for name in ("x", "v", "F")}


def changed(change: Callable[[Model, State], Model]) -> Callable[[Sizes], Pair]:
    """The cube as it is, against the cube with ``change`` made to its model."""

    def build(sizes: Sizes) -> Pair:
        model, state = cube(sizes)
        return both(model, change(model, state), state, sizes)

    return build


def both(lean: Model, full: Model, state: State, sizes: Sizes, full_state: State | None = None) -> Pair:
    """Two models from the same start."""
    return Pair(
        rolled(lean, state, sizes.substeps),
        rolled(full, full_state or state, sizes.substeps),
        sizes.particles,
        sizes.substeps,
    )
