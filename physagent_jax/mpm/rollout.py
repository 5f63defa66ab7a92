"""Two drivers of the same `step`: `simulate` for frames, `rollout` for gradients.

`simulate` adapts: it fits substeps and the grid window to each frame, checks the result on the device,
and redoes a frame from its start with smaller steps if the check fails. `rollout` is a pure function with
static counts, made for `jax.grad` and `jax.vmap`.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.arrays import on_device
from physagent_jax.core.errors import UserError
from physagent_jax.kernels import programs
from physagent_jax.mpm import kernels, reductions
from physagent_jax.mpm.checks import check_start
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.health import Health, count_outside
from physagent_jax.mpm.ledger import Exchange, balanced, exchange
from physagent_jax.mpm.plan import acting
from physagent_jax.mpm.sorting import placed, renewed, restored
from physagent_jax.mpm.state import Grid, Model, State
from physagent_jax.mpm.step import body_acceleration, kirchhoff_stress, per_material, substep
from physagent_jax.mpm.timestep import SAFETY, check_explicit_dt, kinematic_dt, stable_dt, substeps_for
from physagent_jax.mpm.window import fit_window

MAX_RETRIES = 6  # halvings of the step before a frame is given up
MAX_CRUSHES = (
    3  # attempts that crush matter to nothing before a frame is given up: no step helps against that
)
MAX_SUBSTEPS = 100_000  # in one frame, retries included; more would look like a hang
_LEFT = "particles left the grid window"
_CRUSHED = "matter is crushed to nothing"


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

    @property
    def grid_shape(self) -> tuple[int, int, int]:
        """Nodes of the window."""
        return self.grid.shape


@partial(jax.jit, static_argnames="ledger")
def advance(
    model: Model, state: State, substeps: jax.Array, ledger: bool = False
) -> tuple[State, Health, Exchange | None]:
    """``substeps`` steps in a row (a traced count: no recompilation when it changes), watched.

    Stops where `Health` says that the frame has to be redone: its remaining steps would be wasted. With ``ledger``,
    what was exchanged is summed too; without, it is not computed.
    """

    def going(carry):
        done, _, _, health, _ = carry
        return (done < substeps) & health.good(model)

    def body(carry):
        done, state, tau, health, total = carry
        after, tau, trace = substep(model, state, tau)
        if total is not None:
            total = total + exchange(model, state, trace, after)
        return done + 1, after, tau, health + trace.health, total

    dtype = state.x.dtype
    tau, total = kirchhoff_stress(model, state), Exchange.none(dtype) if ledger else None
    start = (jnp.zeros_like(substeps), state, tau, Health.unharmed(dtype), total)
    _, after, _, health, total = jax.lax.while_loop(going, body, start)
    finite = reductions.every(jnp.isfinite(after.F).all(), model.axis)  # the return mapping included
    health = dataclasses.replace(health, finite=health.finite & finite)
    return after, health, None if total is None else balanced(model, state, after, total)


def simulate(
    model: Model,
    state: State,
    *,
    frame_count: int,
    frame_dt: float,
    substep_dt: float | None = None,
    safety: float = SAFETY,
    force_substep: bool = False,
    ledger: bool = False,
    begin: Frame | None = None,
) -> Iterator[Frame]:
    """Yields ``frame_count`` frames, the initial state first; or, of these, those after ``begin``.

    Args:
        model: Its ``dt`` and ``grid.origin``/``grid.shape`` are chosen anew for each frame.
        state: The initial state.
        frame_count: Frames in all; frame_count - 1 intervals are simulated.
        frame_dt: Time between frames [s].
        substep_dt: Fixed substep [s], shortened to fit the frame; None = ``safety`` times the bound.
        safety: Fraction of the stable bound, in (0, 1].
        force_substep: Whether to run ``substep_dt`` even above the bound. It is then never shortened: a frame
            that fails its check ends the run.
        ledger: Whether frames carry an `Exchange`.
        begin: A frame of an earlier call whose frames up to there are these too. Nothing but its state, grid window
            and order passes from frame to frame, so what follows is the same as if all were simulated.

    Raises:
        UserError: The input cannot be simulated (`checks.check_start`), ``substep_dt`` is above the stable bound
            and not forced, or a frame fails even with steps 2**MAX_RETRIES times smaller (the message says what
            the check saw).
    """
    programs.bound()
    model, state = conform(model, state)
    check_start(model, state, frame_dt=frame_dt, substep_dt=substep_dt, safety=safety)
    if substep_dt is not None and not force_substep:
        check_explicit_dt(substep_dt, float(stable_dt(model, state)))
    pace = _Pace(frame_dt, substep_dt, safety, fixed=substep_dt is not None and force_substep)
    frame = begin
    if frame is None:
        frame = Frame(0, state, 0, 0.0, 1.0, 1.0, (), model.grid, 0.0, _nothing(state, ledger))
        yield frame
    for _ in range(frame.index + 1, frame_count):
        with kernels.beside(frame.state.x):
            frame = _next_frame(model, frame, pace, ledger)
        yield frame


@dataclasses.dataclass(frozen=True)
class _Pace:
    """How long frames and substeps are, as in `simulate`; ``fixed`` = the substep is forced."""

    frame_dt: float
    substep_dt: float | None
    safety: float
    fixed: bool


def _next_frame(model: Model, before: Frame, pace: _Pace, ledger: bool) -> Frame:
    """The frame after ``before``, redone with shorter steps or a wider window until it can be trusted."""
    begun, index, frame_dt = time.perf_counter(), before.index + 1, pace.frame_dt
    state, order, model = before.state, before.order, model.replace(grid=before.grid)
    time_now = float(state.time)
    substeps = _substeps(model, state, pace)
    order = renewed(order, model, state)
    retries, margin = [], 1.0
    while True:
        grid = _follow(model, state, frame_dt, margin)
        model = model.replace(grid=grid, dt=on_device(frame_dt / substeps, state.x.dtype))
        present = acting(model, time_now, time_now + frame_dt)
        after, health, total = advance(*placed(order, present, state), on_device(substeps, np.int32), ledger)
        after = restored(order, model, after)
        breach = _breach(model, after, health, pace.fixed)
        if breach is None:
            break
        retries.append(f"{breach} at dt = {frame_dt / substeps:.3g} s")
        tight_window = breach == _LEFT
        crushes = sum(_CRUSHED in reason for reason in retries)
        spent = len(retries) > MAX_RETRIES or crushes >= MAX_CRUSHES or 2 * substeps > MAX_SUBSTEPS
        if spent or (pace.fixed and not tight_window):
            raise _hopeless(index, retries, pace.fixed, model, state)
        if tight_window:
            margin *= 2.5  # the window was too small, not the step too long
        else:
            substeps *= 2
    return Frame(
        index,
        after,
        substeps,
        frame_dt / substeps,
        float(health.min_J),
        float(health.max_J),
        tuple(retries),
        grid,
        time.perf_counter() - begun,
        total,
        order,
    )


def _nothing(state: State, ledger: bool) -> Exchange | None:
    return Exchange.none(state.x.dtype) if ledger else None


def _substeps(model: Model, state: State, pace: _Pace) -> int:
    """Substeps for the coming frame.

    Raises:
        UserError: They would be more than MAX_SUBSTEPS.
    """
    frame_dt = pace.frame_dt
    if pace.fixed and pace.substep_dt is not None:
        return substeps_for(frame_dt, pace.substep_dt)
    elastic = pace.substep_dt or pace.safety * float(stable_dt(model, state))
    horizon = on_device(frame_dt, state.x.dtype)
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
    return substeps_for(frame_dt, dt)


def _hopeless(index: int, retries: list[str], fixed: bool, model: Model, state: State) -> UserError:
    if fixed:
        return UserError(
            f"frame {index} fails with the forced substep: {retries[-1]}",
            do='Take a smaller `substep_dt`, or "auto"',
        )
    what = f"frame {index} cannot be simulated: {'; '.join(retries)}"
    if _CRUSHED not in retries[-1]:
        return UserError(what, do="Use a stiffer material, a weaker force, or a finer grid")
    load, stiffness = _load(model, state)
    return UserError(
        f"{what}: what acts on the matter is a pressure of some {load:.2g} Pa, and what is most stiff in it has a "
        f"modulus of {stiffness:.2g} Pa (3 lam + 2 mu)",
        do=(
            f"Use a material {load / stiffness:.2g} times as stiff or more, or forces and speeds as much weaker"
            if load > stiffness
            else "Use a stiffer material, weaker forces, or a finer grid"
        )
        + "; of the elastic laws, neo-hookean resists being crushed most",
    )


def _load(model: Model, state: State) -> tuple[float, float]:
    """Pressure of inertia, rho (|a| L + |v|^2), over the body's length L, and the greatest stiffness at rest [Pa]."""
    x, v = np.asarray(state.x), np.asarray(state.v)
    density = float((np.asarray(model.mass) / np.asarray(model.volume)).max())
    acceleration = np.linalg.norm(np.asarray(body_acceleration(model, state)), axis=-1).max()
    load = density * (acceleration * np.ptp(x, axis=0).max() + (v**2).sum(-1).max())
    rest = dataclasses.replace(state, F=jnp.broadcast_to(jnp.eye(3, dtype=state.F.dtype), state.F.shape))
    stiffness = per_material(model, rest, lambda material, F, history: material.stiffness(F, history))
    return float(load), float(stiffness.max())


def _follow(model: Model, state: State, frame_dt: float, margin: float):
    """The grid window for the coming frame."""
    x = np.asarray(state.x)
    speed = float(np.linalg.norm(np.asarray(state.v), axis=-1).max())
    reach = margin * (speed * frame_dt + 2 * model.grid.dx)
    return fit_window(model.grid, x.min(0), x.max(0), reach)


def _breach(model: Model, after: State, health: Health, fixed: bool) -> str | None:
    """Why the frame cannot be trusted, or None."""
    if not bool(health.finite):
        return f"a value is not finite (the least det F is {float(health.min_J):.3g})"
    if int(health.outside) > 0:
        return _LEFT
    min_J = float(health.min_J)
    if abs(min_J) < jnp.finfo(health.min_J.dtype).eps:
        return f"{_CRUSHED} (det F = {min_J:.3g})"
    if min_J <= 0:
        return f"matter is turned inside out (det F = {min_J:.3g})"
    if float(health.min_increment) <= 0:
        return f"a substep turns matter inside out (det(I + dt grad v) = {float(health.min_increment):.3g})"
    cells = float(health.max_speed) * float(model.dt) / model.grid.dx
    if cells >= 1:
        return f"a particle crosses {cells:.2g} cells in one substep"
    bound = math.inf if fixed else float(stable_dt(model, after))
    if float(model.dt) > bound:
        return f"deformation lowered the stable bound to {bound:.3g} s"
    return None


def rollout(model: Model, state: State, *, frame_count: int, substeps: int) -> tuple[State, State]:
    """``frame_count`` frames of ``substeps`` steps of ``model.dt`` each; differentiable in reverse.

    Nothing adapts: ``model.grid`` must cover the whole motion (`Grid.whole` always does) and ``model.dt``
    must be stable throughout. If a particle leaves the window, all positions become NaN: a pure function
    cannot raise, and going on would answer wrongly in silence.

    Each frame is checkpointed, and each step within it: the reverse pass stores one state per frame and,
    for one frame at a time, one per step; grids are recomputed.

    Returns:
        The final state, and the states at the end of every frame stacked along a new first axis.

    Raises:
        UserError: ``model`` and ``state`` do not fit each other (`conform`).
    """
    programs.bound()
    with kernels.beside(state.x):
        return _rollout(*conform(model, state), frame_count, substeps)


@partial(jax.jit, static_argnums=(2, 3))
def _rollout(model: Model, state: State, frame_count: int, substeps: int) -> tuple[State, State]:
    @jax.checkpoint
    def one(carry, _):
        state, tau, _ = substep(model, *carry)
        left = reductions.total(count_outside(state.x, model.grid), model.axis)
        poison = jnp.where(left > 0, jnp.nan, 0.0).astype(state.x.dtype)
        return (dataclasses.replace(state, x=state.x + poison), tau), None

    @jax.checkpoint
    def frame(carry, _):
        carry, _ = jax.lax.scan(one, carry, None, length=substeps)
        return carry, carry[0]

    (end, _), states = jax.lax.scan(frame, (state, kirchhoff_stress(model, state)), None, length=frame_count)
    return end, states
