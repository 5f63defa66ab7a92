"""Frames of a scene, by a driver that adapts.

`simulate` fits substeps and the grid window to each frame, checks the result on the device, and redoes a frame from its
start with smaller steps if the check fails (`mpm.frame`). For gradients there is `mpm.rollout`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from physagent_jax.kernels import programs
from physagent_jax.kernels.forks import refuse_fork
from physagent_jax.mpm import kernels
from physagent_jax.mpm.checks import check_start
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.frame import Frame, Pace, next_frame
from physagent_jax.mpm.ledger import Exchange
from physagent_jax.mpm.limits import warn_of_limits
from physagent_jax.mpm.plan import Timetable
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.timestep import SAFETY, check_explicit_dt, stable_dt


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
    tell_limits: bool = True,
    most_substeps: float = math.inf,
) -> Iterator[Frame]:
    """Yield ``frame_count`` frames, the initial state first; or, of these, those after ``begin``.

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
        begin: A frame of an earlier call whose frames up to there are these too. Nothing but its state, grid window,
            order, its step's trend and the parts that were computed passes from frame to frame, so what follows is the
            same as if all were simulated.
        most_substeps: Substeps that all frames after ``begin`` may take, attempts that are redone included.
        tell_limits: Whether to warn of what the method does badly in this model (`limits.find_limits`).

    Raises:
        UserError: This process was forked from one that computes; the input cannot be simulated
            (`checks.check_start`), ``substep_dt`` is above the stable bound
            and not forced, it takes more than ``most_substeps``,
            or a frame fails even with steps 2**MAX_RETRIES times smaller (the message says what
            the check saw).
    """
    refuse_fork()
    programs.release_programs()
    model, state = conform(model, state)
    check_start(model, state, frame_dt=frame_dt, substep_dt=substep_dt, safety=safety)
    if tell_limits:
        warn_of_limits(model, state, (frame_count - 1) * frame_dt, stacklevel=2)
    if substep_dt is not None and not force_substep:
        check_explicit_dt(substep_dt, float(stable_dt(model, state)))
    pace = Pace(frame_count, frame_dt, substep_dt, safety, fixed=substep_dt is not None and force_substep)
    timetable, frame = Timetable.of(model), begin
    if frame is None:
        nothing = Exchange.zeros(state.x.dtype) if ledger else None
        frame = Frame(0, state, 0, 0.0, 1.0, 1.0, (), model.grid, 0.0, nothing)
        yield frame
    bound, left = None, most_substeps
    for _ in range(frame.index + 1, frame_count):
        with kernels.use_device_of(frame.state.x):
            frame, bound = next_frame(model, timetable, frame, pace, ledger, bound, left)
        left -= frame.attempted
        yield frame
