"""One frame of `mpm.simulate`: planned, attempted, and planned again until `mpm.diagnosis` finds no fault."""

from __future__ import annotations

import dataclasses
import math
import time
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import find_platform
from physagent_jax.mpm import reductions
from physagent_jax.mpm.diagnosis import MAX_SUBSTEPS, Breach, Fault, explain_failure, find_breach, is_hopeless
from physagent_jax.mpm.gridless import drop_window, use_grid
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.ledger import Exchange, balance, measure_exchange
from physagent_jax.mpm.plan import Acting, Timetable
from physagent_jax.mpm.sorting import permute_particles, unpermute_particles, update_order
from physagent_jax.mpm.state import Grid, Model, State
from physagent_jax.mpm.step import kirchhoff_stress, makes_stress, substep
from physagent_jax.mpm.timestep import SAFETY, divide_frame, kinematic_dt, stable_dt
from physagent_jax.mpm.window import fit_window

CHUNK = 10
"""Substeps that a GPU runs before the host looks whether to go on, which costs as much as a small substep."""
_SPARE = 0.97  # of the stable step that is expected at the frame's end
_STEEPEST = 0.5  # of the stable step, by which it is expected to fall within a frame at most
_WIDER = 2.5  # times the room that a window had which particles have left


@dataclasses.dataclass(frozen=True)
class Frame:
    """One frame handed to the host.

    Attributes:
        index: Frame number; 0 is the initial state.
        state: The state at the end of the frame, on the device.
        substeps: Substeps that led here from the frame before.
        dt: Their length [s].
        min_J, max_J: Extremes of det F on the way.
        retries: Reasons for which this frame was redone, oldest first.
        grid: The window used; the next frame's is fitted from it.
        seconds: Wall time of the frame, redone attempts included [s].
        exchange: What forces, boundaries and dissipation exchanged since the frame before; None = not asked for.
        order: In which the particles lay in memory meanwhile, shape (n,); None = as they are in ``state``.
        attempted: Substeps that this frame took, all attempts together.
        trend: Stable step at the end of the frame over that at its beginning.
        acting: Which of the model's parts were computed; None = none yet.
    """

    index: int
    state: State
    substeps: int
    dt: float
    min_J: float
    max_J: float
    retries: tuple[str, ...]
    grid: Grid
    seconds: float
    exchange: Exchange | None = None
    order: np.ndarray | None = None
    attempted: int = 0
    trend: float = 1.0
    acting: Acting | None = None

    @property
    def grid_shape(self) -> tuple[int, int, int]:
        """Nodes of the window."""
        return self.grid.shape


@dataclasses.dataclass(frozen=True)
class Pace:
    """The lengths of frames and substeps, as in `simulate`; ``fixed`` = the substep is forced."""

    frame_count: int
    frame_dt: float
    substep_dt: float | None
    safety: float
    fixed: bool


def next_frame(
    model: Model,
    timetable: Timetable,
    before: Frame,
    pace: Pace,
    ledger: bool,
    bound: float | None = None,
    most_substeps: float = math.inf,
) -> tuple[Frame, float | None]:
    """The frame after ``before``, redone with shorter steps or a wider window until it can be trusted.

    Args:
        model: What is simulated.
        timetable: Timetable of its parts.
        before: Where from.
        pace: As asked for.
        ledger: As for `advance`.
        bound: The stable step there [s]; None = not known.
        most_substeps: Substeps that all attempts together may take.

    Returns:
        The frame, and the stable step at its end [s], None where nobody looked: what the next one begins with.

    Raises:
        UserError: It cannot be.
    """
    begun = time.perf_counter()
    if bound is None and not pace.fixed:
        bound = float(stable_dt(model, before.state))
    plan = plan_frame(model, before, pace, bound)
    breaches: list[Breach] = []
    attempted, begun_at = 0, bound
    now = float(before.state.time)
    frames_left = pace.frame_count - 1 - before.index
    work = frames_left * plan.substeps * before.state.x.shape[0]
    acting = timetable.choose_acting(model, now, now + pace.frame_dt, work, before.acting)
    while True:
        attempted += plan.substeps
        if attempted > most_substeps:
            raise _explain_cost(before.index + 1, attempted, most_substeps, breaches)
        after, seen, total = attempt_frame(plan, acting, before.state, ledger)
        health = jax.device_get(seen)  # at once: each number by itself would be a wait
        bound = math.inf if pace.fixed else float(stable_dt(plan.model, after))
        breach = find_breach(plan.model, health, bound)
        if breach is None:
            break
        breaches.append(breach)
        if is_hopeless(breaches, plan.substeps, pace.fixed):
            raise explain_failure(before.index + 1, breaches, pace.fixed, plan.model, before.state)
        plan = plan_again(plan, breach, before.state)
    frame = Frame(
        before.index + 1,
        after,
        plan.substeps,
        plan.dt,
        float(health.min_J),
        float(health.max_J),
        tuple(breach.words for breach in breaches),
        plan.model.grid,
        time.perf_counter() - begun,
        total,
        plan.order,
        attempted,
        bound / begun_at if begun_at and math.isfinite(bound) else 1.0,
        acting,
    )
    return frame, None if pace.fixed else bound


def _explain_cost(index: int, substeps: int, most: float, breaches: list[Breach]) -> UserError:
    """The error to raise when frame ``index`` would take more substeps than it may."""
    why = f": {breaches[-1].words}" if breaches else ""
    return UserError(
        f"frame {index} would take {substeps:,} substeps{why}",
        got=f"{most:,.0f} that are left",
        do="Use a softer material or weaker forces",
    )


# Plan


@dataclasses.dataclass(frozen=True)
class FramePlan:
    """A plan for an attempt at a frame.

    Attributes:
        model: With the step and the grid window of the attempt.
        frame_dt: Length of the frame [s].
        substeps: How many.
        margin: Factor on the room that particles have in the window.
        order: In which particles are to lie in memory, shape (n,); None = as they do.
    """

    model: Model
    frame_dt: float
    substeps: int
    margin: float
    order: np.ndarray | None

    @property
    def dt(self) -> float:
        """Length of a substep [s]."""
        return self.frame_dt / self.substeps


def plan_frame(model: Model, before: Frame, pace: Pace, bound: float | None = None) -> FramePlan:
    """The first attempt at the frame after ``before``, where the stable step is ``bound`` [s], if that is known.

    Raises:
        UserError: It would take more than MAX_SUBSTEPS.
    """
    model = model.replace(grid=before.grid)
    substeps = count_substeps(model, before.state, pace, bound, before.trend)
    order = update_order(before.order, model, before.state)
    return _fit(FramePlan(model, pace.frame_dt, substeps, 1.0, order), before.state)


def plan_again(plan: FramePlan, breach: Breach, state: State) -> FramePlan:
    """The next attempt from ``state``: a wider window if that was too small, else shorter steps.

    They are half as long, or as long as the stable step allows where only that has become shorter.
    """
    if breach.fault is Fault.LEFT:
        return _fit(dataclasses.replace(plan, margin=_WIDER * plan.margin), state)
    substeps = 2 * plan.substeps
    if breach.bound is not None:
        substeps = min(substeps, max(plan.substeps + 1, divide_frame(plan.frame_dt, SAFETY * breach.bound)))
    return _fit(dataclasses.replace(plan, substeps=substeps), state)


def count_substeps(
    model: Model, state: State, pace: Pace, bound: float | None = None, trend: float = 1.0
) -> int:
    """Substeps for the coming frame.

    Args:
        model: What is simulated.
        state: At the frame's beginning.
        pace: As asked for.
        bound: The stable step there [s]; None = not known yet.
        trend: Factor by which the frame before has changed it: one that falls is expected to fall on.

    Raises:
        UserError: They would be more than MAX_SUBSTEPS.
    """
    frame_dt = pace.frame_dt
    if pace.fixed and pace.substep_dt is not None:
        return divide_frame(frame_dt, pace.substep_dt)
    if pace.substep_dt is not None:
        elastic = pace.substep_dt
    else:
        bound = float(stable_dt(model, state)) if bound is None else bound
        elastic = bound * min(pace.safety, max(_SPARE * trend, _STEEPEST))
    horizon = np.asarray(frame_dt, state.x.dtype)
    # With the frame as the step, forces give their mean over it: blows within the frame are foreseen.
    kinematic = float(kinematic_dt(model.replace(dt=horizon), state, horizon))
    dt = elastic if math.isnan(kinematic) else min(elastic, kinematic)
    if frame_dt > MAX_SUBSTEPS * dt:
        reason = "the material is so stiff" if dt == elastic else "matter moves so fast"
        raise UserError(
            f"a frame of {frame_dt:.3g} s would take more than {MAX_SUBSTEPS:,} substeps: {reason}",
            got=f"a step of {dt:.3g} s",
            do="Use shorter frames, a softer or denser material, weaker forces, or fewer grid cells",
        )
    return divide_frame(frame_dt, dt)


def _fit(plan: FramePlan, state: State) -> FramePlan:
    """``plan`` with its model's step, and the window that the particles need during the frame."""
    model, (low, high, speed) = plan.model, jax.device_get(measure_extent(state.x, state.v))
    reach = plan.margin * (float(speed) * plan.frame_dt + 2 * model.grid.dx)
    grid = fit_window(model.grid, low, high, reach)
    return dataclasses.replace(plan, model=model.replace(grid=grid, dt=np.asarray(plan.dt, state.x.dtype)))


@jax.jit
def measure_extent(x: jax.Array, v: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Smallest and largest coordinates of particles [m], shape (3,) each, and the largest speed [m/s]."""
    return x.min(0), x.max(0), jnp.sqrt((v**2).sum(-1).max())


# Attempt


def attempt_frame(
    plan: FramePlan, acting: Acting, state: State, ledger: bool
) -> tuple[State, Health, Exchange | None]:
    """`advance` from ``state`` with the parts ``acting``, the particles sorted meanwhile."""
    model = acting.select(plan.model)
    model = use_grid(model) if ledger else drop_window(model)
    moved = permute_particles(plan.order, model, state)
    after, health, total = advance(*moved, np.asarray(plan.substeps, np.int32), ledger)
    return unpermute_particles(plan.order, plan.model, after), health, total


@partial(jax.jit, static_argnames="ledger")
def advance(
    model: Model, state: State, substeps: jax.Array | np.ndarray, ledger: bool = False
) -> tuple[State, Health, Exchange | None]:
    """``substeps`` steps in a row (a traced count: no recompilation when it changes), watched.

    Stops where `Health` says that the frame has to be redone: its remaining steps would be wasted. With ``ledger``,
    what was exchanged is summed too; without, it is not computed.
    """

    def going(carry, count=1):
        done, _, _, health, _ = carry
        return (done + count <= substeps) & health.is_good(model)

    def body(carry):
        done, state, tau, health, total = carry
        after, later, trace = substep(model, state, tau)
        if total is not None:
            total = total + measure_exchange(model, state, trace, after)
        return done + 1, after, None if tau is None else later, health + trace.health, total

    def several(carry):
        return jax.lax.fori_loop(0, CHUNK, lambda _, each: body(each), carry)

    dtype = state.x.dtype
    # XLA would carry what nobody reads through two loops.
    tau = None if makes_stress(model) else kirchhoff_stress(model, state)
    total = Exchange.zeros(dtype) if ledger else None
    start = (jnp.zeros_like(substeps), state, tau, Health.initial(dtype), total)
    if find_platform() != "cpu":
        start = jax.lax.while_loop(lambda carry: going(carry, CHUNK), several, start)
    _, after, _, health, total = jax.lax.while_loop(going, body, start)
    finite = reductions.all_devices(jnp.isfinite(after.F).all(), model.axis)  # the return mapping included
    health = dataclasses.replace(health, finite=health.finite & finite)
    return after, health, None if total is None else balance(model, state, after, total)
