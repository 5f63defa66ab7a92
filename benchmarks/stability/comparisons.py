"""Criteria that compare runs: rest (P7), unused features (P9), order and place (P10)."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.stability.criteria import Result
from benchmarks.stability.materials import FLUID, MATERIALS, make_material
from benchmarks.stability.scenario import GRAVITY, LUMPED, Run, Scenario, build
from physagent_jax.mpm import (
    Contact,
    HalfSpace,
    Lumped,
    Model,
    Sharpened,
    State,
    find_smallest_window,
    stable_dt,
    step,
)

REST = 1e-4  # P7: kinetic energy left, over the initial potential
UNUSED = 1e-6  # P9: displacement, over the domain's side
ORDER = 1e-5  # P10: displacement, over the domain's side
_STEPS = 200
_FOREVER = 1e9


Inertia = Lumped | Sharpened


def comparisons(inertia: Inertia = LUMPED) -> Iterator[tuple[str, Callable[[], Result]]]:
    """All checks of this module, by name."""
    for material in MATERIALS:
        yield f"P7 comes to rest: {material}", partial(at_rest, material, inertia)
    for name, pair in UNUSED_FEATURES.items():
        yield f"P9 {name}", lambda name=name, pair=pair: unused(name, *pair(), inertia)
    for material in ("neo-hookean", "sand", "fluid"):
        yield f"P10 order of particles: {material}", partial(permuted, material, inertia)
        yield f"P10 shift by whole cells: {material}", partial(shifted, material, inertia)


def at_rest(material: str, inertia: Inertia = LUMPED) -> Result:
    """P7: a column that fills a small box is let go under gravity, with damping, and comes to rest."""
    result = Result(f"P7 comes to rest: {material}")
    run = build(Scenario(material, wall="resting", cells=10, inertia=inertia))
    # A fluid goes on seeping into the walls' soft outer cell for seconds; a solid rests at once.
    frame_dt = 0.6 if material in FLUID else 0.1
    run = dataclasses.replace(run, model=run.model.replace(damping_rate=30.0), frame_dt=frame_dt)
    mass = np.asarray(run.model.mass, np.float64)
    height = np.asarray(run.state.x[:, 2], np.float64) - 3 * run.model.grid.dx
    potential = GRAVITY * float((mass * height).sum())
    left = np.inf
    for frame in run.frames(9, ledger=False):
        left = 0.5 * float((mass * (np.asarray(frame.state.v, np.float64) ** 2).sum(-1)).sum()) / potential
    result.figures["kinetic over potential"] = left
    if not left < REST:
        result.fail("P7", f"kinetic energy is still {left:.1e} of the initial potential")
    return result


def permuted(material: str, inertia: Inertia = LUMPED) -> Result:
    """P10: the order of particles does not matter."""
    run = build(Scenario(material, wall="corner", inertia=inertia))
    count = len(run.state.x)
    order = np.random.default_rng(3).permutation(count)

    def shuffle(leaf):
        return leaf[order] if getattr(leaf, "ndim", 0) and leaf.shape[0] == count else leaf

    mixed = run.model.replace(mass=shuffle(run.model.mass), volume=shuffle(run.model.volume))
    one = _simulate(run.model, run.state)
    other = _simulate(mixed, jax.tree.map(shuffle, run.state))
    return _compare("P10", f"P10 order of particles: {material}", one.x[order], other.x, ORDER)


def shifted(material: str, inertia: Inertia = LUMPED) -> Result:
    """P10: a shift by whole cells does not matter, where no wall is near."""
    run = build(Scenario(material, force="torque", inertia=inertia))
    shift = jnp.asarray([3, -2, 1], run.state.x.dtype) * run.model.grid.dx
    moved = dataclasses.replace(run.state, x=run.state.x + shift)
    one, other = _simulate(run.model, run.state), _simulate(run.model, moved)
    return _compare("P10", f"P10 shift by whole cells: {material}", one.x + shift, other.x, ORDER)


def unused(name: str, with_it: Run, without: Run, inertia: Inertia = LUMPED) -> Result:
    """P9: what a scene does not use changes nothing; the figures say what it would cost."""
    with_it, without = (
        dataclasses.replace(run, model=run.model.replace(inertia=inertia)) for run in (with_it, without)
    )
    one, other = _simulate(with_it.model, with_it.state), _simulate(without.model, without.state)
    result = _compare("P9", f"P9 {name}", one.x, other.x, UNUSED)
    result.figures["seconds with it"] = _time_run(with_it)
    result.figures["seconds without"] = _time_run(without)
    return result


def _compare(criterion: str, name: str, one: jax.Array, other: jax.Array, bar: float) -> Result:
    result = Result(name)
    difference = float(jnp.abs(one - other).max())
    result.figures["largest difference"] = difference
    if not difference <= bar:
        result.fail(criterion, f"positions differ by {difference:.1e} m")
    return result


@jax.jit
def _take_steps(model: Model, state: State) -> State:
    return jax.lax.fori_loop(0, _STEPS, lambda _, s: step(model, s), state)


def _simulate(model: Model, state: State) -> State:
    dt = 0.7 * stable_dt(model, state)
    return _take_steps(model.replace(dt=dt.astype(state.x.dtype)), state)


def _time_run(run: Run) -> float:
    begun = time.perf_counter()
    jax.block_until_ready(_simulate(run.model, run.state))
    return round(time.perf_counter() - begun, 4)


def _throw(material: str) -> Run:
    return build(Scenario(material, wall="corner"))


def _set_law(run: Run, law) -> Run:
    state = dataclasses.replace(run.state, history=(law.initial_history(),))
    return dataclasses.replace(run, model=run.model.replace(materials=(law,)), state=state)


def _make_unyielding(material: str, base: str) -> tuple[Run, Run]:
    """A plastic law that never yields, and its elastic base."""
    run = _throw(base)
    solid = make_material(material, len(run.state.x), 1e6, 0.3, np.float32)
    limits = {"yield_stress": 1e30} if hasattr(solid, "yield_stress") else {"cohesion": 1e30}
    changes = {name: jnp.full_like(getattr(solid, name), value) for name, value in limits.items()}
    return _set_law(run, dataclasses.replace(solid, **changes)), run


def _change_model(material: str, **changes) -> tuple[Run, Run]:
    run = _throw(material)
    return dataclasses.replace(run, model=run.model.replace(**changes)), run


def _remove_viscosity() -> tuple[Run, Run]:
    return _change_model("neo-hookean", viscosity=jnp.zeros_like(_throw("neo-hookean").model.mass))


def _remove_forces() -> tuple[Run, Run]:
    run = _throw("neo-hookean")  # its terms have strength zero
    return run, dataclasses.replace(run, model=run.model.replace(forces=()))


def _add_far_obstacle() -> tuple[Run, Run]:
    run = _throw("neo-hookean")
    zero, dtype = jnp.zeros((), run.state.x.dtype), run.state.x.dtype
    normal = jnp.asarray([0.0, 0.0, -1.0], dtype)
    ceiling = HalfSpace(0.9 * jnp.ones(3, dtype), normal, zero, zero, zero + _FOREVER, Contact.SEPARATE)
    return dataclasses.replace(run, model=run.model.replace(boundaries=(*run.model.boundaries, ceiling))), run


def _shrink_window() -> tuple[Run, Run]:
    run = _throw("neo-hookean")
    grid = dataclasses.replace(find_smallest_window(1.0, run.model.grid.cells), shape=(16, 16, 16))
    return run, dataclasses.replace(run, model=run.model.replace(grid=grid))


def _remove_gravity() -> tuple[Run, Run]:
    run = build(Scenario("neo-hookean", force="torque"))
    return run, dataclasses.replace(run, model=run.model.replace(gravity=None))


UNUSED_FEATURES: dict[str, Callable[[], tuple[Run, Run]]] = {
    "von Mises that never yields is Hencky": lambda: _make_unyielding("von-mises", "hencky"),
    "plasticine that never yields is Hencky": lambda: _make_unyielding("plasticine", "hencky"),
    "foam that never yields is Hencky": lambda: _make_unyielding("foam", "hencky"),
    "sand of endless cohesion is Hencky": lambda: _make_unyielding("wet-sand", "hencky"),
    "zero viscosity is none": _remove_viscosity,
    "force terms of strength zero are none": _remove_forces,
    "zero gravity is none": _remove_gravity,
    "an obstacle out of reach is none": _add_far_obstacle,
    "nodes out of reach are none": _shrink_window,
}
