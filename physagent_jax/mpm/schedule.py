"""A simulation once more, with derivatives: the frames of `simulate`, by the steps and windows that it chose.

`simulate` fits each frame's step and grid window to the motion, redoes frames, sorts particles and leaves out what does
not act. All of that is data of the host, which no derivative sees and none has to: `Schedule.of` notes it, and `replay`
takes the same steps by compiled programs that `jax.grad` goes through, one chunk of substeps after another. It is
called from Python, not from within `jax.jit`, where every frame would become a program of its own.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from functools import partial, reduce

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import programs
from physagent_jax.mpm import kernels
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.frame import Frame
from physagent_jax.mpm.plan import Acting, Timetable
from physagent_jax.mpm.sorting import permute_particles, unpermute_particles
from physagent_jax.mpm.state import Grid, Model, State
from physagent_jax.mpm.step import NODES, kirchhoff_stress, substep
from physagent_jax.mpm.transfer import STOPPED

MEMORY = 2e9
"""[bytes] that a reverse pass may take for what it keeps."""
_CHUNK, _SHORTEST_CHUNK = 32, 8  # substeps of a program where all states are kept, and where few are
_UNROLLED = (
    10  # in place of the former where frames are longer: one after another in the program, without a loop
)


@dataclasses.dataclass(frozen=True)
class FrameSchedule:
    """The record of a simulated frame's steps.

    Attributes:
        grid: The window.
        substeps: How many.
        dt: Their length [s].
        order: In which the particles lay in memory, shape (n,); None = as they are in the state.
        acting: Which of the model's parts took part.
    """

    grid: Grid
    substeps: int
    dt: float
    order: np.ndarray | None
    acting: Acting


@dataclasses.dataclass(frozen=True)
class Schedule:
    """The record of all frames after the first, in order."""

    frames: tuple[FrameSchedule, ...]

    @staticmethod
    def of(model: Model, frames: Iterable[Frame], start: float = 0.0) -> Schedule:
        """The schedule of frames of `simulate`, the initial one among them or not.

        Args:
            model: What was simulated.
            frames: In order and without a gap; their states are not looked at.
            start: Time of the initial state [s].

        Raises:
            UserError: Frames are missing.
        """
        made, time, timetable = [], start, Timetable.of(model)
        for frame in frames:
            if frame.index == 0:
                continue
            if frame.index != len(made) + 1:
                raise UserError(
                    "a schedule needs all frames from the first on, in order",
                    got=f"frame {frame.index} after {len(made)}",
                )
            length = frame.substeps * frame.dt
            acting = timetable.find_acting(time, time + length)
            made.append(FrameSchedule(frame.grid, frame.substeps, frame.dt, frame.order, acting))
            time += length
        return Schedule(tuple(made))

    @property
    def substeps(self) -> int:
        """Of all frames."""
        return sum(frame.substeps for frame in self.frames)

    def joined(self) -> Schedule:
        """The same, with what acts in any frame taking part in all: fewer programs to compile, more to compute.

        For small models of which many clips are differentiated, and windows that move across the borders of frames.
        """
        acting = reduce(Acting.join, (frame.acting for frame in self.frames))
        return Schedule(tuple(dataclasses.replace(frame, acting=acting) for frame in self.frames))

    def covering(self, model: Model, start: float = 0.0) -> Schedule:
        """The same, with what acts in ``model`` taking part too: for windows that are wider, or lie elsewhere.

        Args:
            model: Whose windows are known.
            start: Time of the initial state [s].
        """
        made, time, timetable = [], start, Timetable.of(model)
        for frame in self.frames:
            length = frame.substeps * frame.dt
            acting = frame.acting.join(timetable.find_acting(time, time + length))
            made.append(dataclasses.replace(frame, acting=acting))
            time += length
        return Schedule(tuple(made))


def replay(
    model: Model,
    state: State,
    schedule: Schedule,
    *,
    memory: float = MEMORY,
    horizon: int | None = None,
    truncate: int | None = None,
) -> tuple[State, ...]:
    """The states at the end of every frame of ``schedule``; differentiable in reverse by ``model`` and ``state``.

    The values are those of `simulate` to round-off for the model and the state that the schedule was made with. Others
    are simulated by the same steps: if a particle then leaves the window of a frame, all positions from there on are
    NaN; simulate anew and take that schedule. Windows of forces decide in which frames these take part: one that moves
    across a frame's border needs a new schedule too.

    A reverse pass keeps the state of each substep where ``memory`` allows it, else of one in so many and of each
    substep between two of these, at the cost of one more simulation.

    Args:
        model: As for `simulate`; its grid and step are the schedule's.
        state: The initial state.
        schedule: How to simulate.
        memory: What a reverse pass may keep [bytes].
        horizon: Frames that are simulated, the first ones; None = all. A horizon that grows from one stage of a fit to
            the next runs the programs that it has run before.
        truncate: Frames after which the gradient is cut, again and again (truncated backpropagation through time);
            None = never. The state at a cut counts as given: of what acts before it, nothing reaches a loss on frames
            after it. With as many as there are frames, or more, it is the full gradient.

    Raises:
        UserError: ``model`` and ``state`` do not fit each other (`conform`), ``memory`` is too little, or ``horizon``
            or ``truncate`` is out of range.
    """
    programs.release_programs()
    schedule = Schedule(schedule.frames[: check_horizon(horizon, len(schedule.frames))])
    check_truncation(truncate)
    with kernels.use_device_of(state.x):
        model, state = conform(model, state)
        advance = _choose_checkpoints(model.inertia.node_numbers, state, schedule, memory)
        state, states = _instantiate_zeros(model, state), []
        for index, frame in enumerate(schedule.frames):
            if truncate and index and index % truncate == 0:
                state = _instantiate_zeros(model, jax.lax.stop_gradient(state))
            state = _replay_frame(model, state, frame, advance)
            states.append(state)
        states[-1] = _instantiate_zeros(model, states[-1])
    return tuple(states)


def check_horizon(horizon: int | None, frames: int) -> int:
    """The number of frames to be simulated.

    Raises:
        UserError: ``horizon`` is none of 1..``frames``.
    """
    if horizon is not None and not 1 <= horizon <= frames:
        raise UserError(f"`horizon` must be within 1..{frames}, the frames after the first", got=horizon)
    return frames if horizon is None else horizon


def check_truncation(truncate: int | None) -> None:
    """Refuse a number of frames that is none.

    Raises:
        UserError: It is below 1.
    """
    if truncate is not None and truncate < 1:
        raise UserError("`truncate` must be at least 1 frame", got=truncate)


@dataclasses.dataclass(frozen=True)
class _Checkpoints:
    """Substeps of a program, and whether a reverse pass keeps the state of each or only the first."""

    length: int
    every: bool


def _choose_checkpoints(node_numbers: int, state: State, schedule: Schedule, memory: float) -> _Checkpoints:
    """All states if they fit, else the first of every k substeps, and all within k at a time.

    N S / k + k (S + G) is least at k = sqrt(N S / (S + G)), with N substeps, states of S and nodes of G bytes.
    """
    size = sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state))
    nodes = max((node_numbers * math.prod(frame.grid.shape) for frame in schedule.frames), default=0)
    each = size + nodes * state.x.dtype.itemsize
    count = schedule.substeps
    if count * each <= memory:
        longest = max((frame.substeps for frame in schedule.frames), default=0)
        return _Checkpoints(_fit_length(schedule, _CHUNK if longest <= _CHUNK else _UNROLLED), every=True)
    length = _fit_length(schedule, max(_SHORTEST_CHUNK, math.isqrt(int(count * size / each))))
    needed = count * size / length + length * each
    if needed > memory:
        raise UserError(
            f"a reverse pass through {count:,} substeps needs {needed / 1e9:.2g} GB at least",
            got=f"memory={memory / 1e9:.2g} GB",
            do="Allow more memory, or take fewer particles or frames",
        )
    return _Checkpoints(length, every=False)


def _fit_length(schedule: Schedule, length: int) -> int:
    """The length near ``length`` by which the frames' substeps are best divided: a rest costs its idle steps too."""

    def waste(candidate: int) -> float:
        rests = [frame.substeps % candidate for frame in schedule.frames]
        return sum(candidate for rest in rests if rest) + 0.1 * abs(candidate - length)

    return min(range(max(1, (2 * length) // 3), (3 * length) // 2 + 1), key=waste)


def _instantiate_zeros(model: Model, state: State) -> State:
    """``state``, whose zero tangents and cotangents become arrays where ``model`` is differentiated.

    JAX leaves zeros out, and compiles a program for each set of them: the first frame, whose state has no tangents, and
    the last one, of whose state the loss sees a part, would be compiled apart from those between.
    """

    def is_real(leaf) -> bool:
        return jnp.issubdtype(jnp.result_type(leaf), jnp.inexact)

    leaves, tree = jax.tree.flatten(state)
    others = [leaf for leaf in jax.tree.leaves(model) if is_real(leaf)]
    real = [leaf for leaf in leaves if is_real(leaf)]
    tied = iter(jax.lax.optimization_barrier((*real, *others))[: len(real)])
    return tree.unflatten([next(tied) if is_real(leaf) else leaf for leaf in leaves])


def _replay_frame(model: Model, state: State, frame: FrameSchedule, checkpoints: _Checkpoints) -> State:
    present = frame.acting.select(model)
    present = present.replace(grid=frame.grid, dt=np.asarray(frame.dt, state.x.dtype))
    present, state = permute_particles(frame.order, present, state)
    length = checkpoints.length
    for done in range(0, frame.substeps, length):
        count = min(length, frame.substeps - done)
        is_full = count == length < frame.substeps  # where frames are short, one program is enough
        state = _advance(present, state, None if is_full else np.asarray(count, np.int32), checkpoints)
    return unpermute_particles(frame.order, model, state)


@partial(jax.jit, static_argnames="checkpoints")
def _advance(
    model: Model, state: State, count: jax.Array | np.ndarray | None, checkpoints: _Checkpoints
) -> State:
    """``count`` substeps, of as many as there may be between checkpoints: one program for any number; None = all.

    To choose for each substep whether it is taken costs a gradient of many particles a twentieth: hence one for all. In
    that one, no loop puts the states that are kept into stacks and takes them out again: a further sixth.
    """

    def step(carry):
        state, tau, outside = carry
        state, tau, trace = substep(model, state, tau)
        return state, tau, outside + trace.health.outside

    # Around the choice, not within it: what does not change from step to step is then kept once, not by each of them.
    @partial(jax.checkpoint, policy=jax.checkpoint_policies.save_only_these_names(NODES, STOPPED))
    def body(carry, index):
        if count is None:
            return step(carry), None
        return jax.lax.cond(index < count, step, lambda same: same, carry), None

    def run(state: State) -> State:
        start = state, kirchhoff_stress(model, state), jnp.zeros((), jnp.int32)
        if checkpoints.every and count is None:
            end = reduce(lambda carry, index: body(carry, index)[0], range(checkpoints.length), start)
        else:
            end, _ = jax.lax.scan(body, start, jnp.arange(checkpoints.length))
        state, _, outside = end
        poison = jnp.where(outside > 0, jnp.nan, 0.0).astype(state.x.dtype)
        return dataclasses.replace(state, x=state.x + poison)

    return (run if checkpoints.every else jax.checkpoint(run))(state)
