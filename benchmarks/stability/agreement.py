"""Runs that must agree with one another, and one that must come to rest (P7, P9, P10)."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator

import jax.numpy as jnp
import numpy as np

from benchmarks.stability.criteria import Result
from benchmarks.stability.materials import make_material
from benchmarks.stability.scenario import FRAMES, Run, Scenario, build
from physagent_jax.mpm import HalfSpace, simulate
from physagent_jax.mpm.boundaries import Contact
from physagent_jax.mpm.energy import kinetic_energy

_AGREE = 1e-4  # largest difference after a clip, in cells, float32: some hundred substeps of round-off
_RESTING = 1e-4  # P7: kinetic energy over the potential it fell from
_DAMPING = 20.0  # [1/s]


def agreements() -> Iterator[tuple[str, Callable[[], Result]]]:
    """Names and runs."""
    yield "P7: damped matter comes to rest", _settling
    yield "P9: plasticity that never acts", _unused_plasticity
    yield "P9: viscosity of zero", lambda: _agree(_with(viscosity=_zeros))
    yield "P9: an obstacle far away", lambda: _agree(_with(boundaries=_and_far_plane))
    yield "P9: damping of zero", lambda: _agree(_with(damping_rate=lambda run: 0.0))
    yield "P10: particles in another order", _permuted
    yield "P10: a shift by whole cells", _shifted


def _base(material: str = "neo-hookean") -> Run:
    return build(Scenario(material, wall="corner"))


def _with(**changes) -> Callable[[Run], Run]:
    def changed(run: Run) -> Run:
        model = run.model.replace(**{name: value(run) for name, value in changes.items()})
        return dataclasses.replace(run, model=model)

    return changed


def _zeros(run: Run):
    return jnp.zeros_like(run.model.mass)


def _and_far_plane(run: Run) -> tuple:
    zero = jnp.zeros((), jnp.float32)
    far = HalfSpace(
        point=jnp.asarray([0.0, 0.0, -5.0], jnp.float32),
        normal=jnp.asarray([0.0, 0.0, 1.0], jnp.float32),
        friction=zero,
        start=zero,
        end=zero + 1e9,
        contact=Contact.SEPARATE,
    )
    return (*run.model.boundaries, far)


def _unused_plasticity() -> Result:
    def strong(run: Run) -> Run:
        count = run.state.x.shape[0]
        metal = make_material("von-mises", count, 1e6, 0.3, np.float32)
        metal = dataclasses.replace(metal, yield_stress=jnp.full(count, 1e12, jnp.float32))
        return Run(
            run.model.replace(materials=(metal,)),
            dataclasses.replace(run.state, history=(metal.initial_history(),)),
            run.frame_dt,
            run.options,
        )

    return _agree(strong, base=_base("hencky"))


def _permuted() -> Result:
    order = np.random.default_rng(0).permutation(len(_base().state.x))

    def shuffled(run: Run) -> Run:
        return dataclasses.replace(run, state=dataclasses.replace(run.state, x=run.state.x[order]))

    return _agree(shuffled, undo=lambda x: x[np.argsort(order)])


def _shifted() -> Result:
    run = build(Scenario("neo-hookean", force="impulse"))
    shift = np.array([3.0, -2.0, 4.0]) * run.model.grid.dx

    def moved(run: Run) -> Run:
        x = run.state.x + jnp.asarray(shift, run.state.x.dtype)
        return dataclasses.replace(run, state=dataclasses.replace(run.state, x=x))

    return _agree(moved, base=run, undo=lambda x: x - shift)


def _agree(
    change: Callable[[Run], Run],
    base: Run | None = None,
    undo: Callable[[np.ndarray], np.ndarray] = lambda x: x,
) -> Result:
    """The changed run ends where the base does; the ratio of times tells what the unused feature costs."""
    begun, result = time.perf_counter(), Result("")
    base = base or _base()
    one, other = _end(base), _end(change(base))
    error = float(np.abs(one[0] - undo(other[0])).max()) / base.model.grid.dx
    ratio = other[1] / max(one[1], 1e-9)
    result.message = f"differs by {error:.1e} cells at most; takes {ratio:.2f} times as long"
    result.figures.update(difference=error, time_ratio=ratio, seconds=round(time.perf_counter() - begun, 3))
    if not error <= _AGREE:
        result.fail("agreement", f"{error:.1e} cells apart")
    return result


def _end(run: Run) -> tuple[np.ndarray, float]:
    """Final positions, and the seconds of the frames after the first, which holds the compilation."""
    frames = list(
        simulate(run.model, run.state, frame_count=FRAMES + 1, frame_dt=run.frame_dt, **run.options)
    )
    return np.asarray(frames[-1].state.x, np.float64), sum(frame.seconds for frame in frames[2:])


def _settling() -> Result:
    begun, result = time.perf_counter(), Result("")
    run = build(Scenario("neo-hookean", wall="resting", youngs_modulus=1e5))
    model = run.model.replace(damping_rate=_DAMPING)
    *_, last = simulate(model, run.state, frame_count=11, frame_dt=0.05)
    height = float(np.ptp(np.asarray(run.state.x)[:, 2]))
    fallen = float(model.mass.sum()) * float(-model.gravity[2]) * height
    share = float(kinetic_energy(model, last.state)) / fallen
    result.figures.update(kinetic_share=share, seconds=round(time.perf_counter() - begun, 3))
    result.message = f"kinetic energy at the end: {share:.1e} of its weight times its height"
    if not share <= _RESTING:
        result.fail("P7", "it still moves")
    return result
