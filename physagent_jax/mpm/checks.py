"""Checks before the first frame: input that no step could handle is refused."""

from __future__ import annotations

import math
import warnings

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.timestep import stable_dt

EXTREME = 10.0
"""Volume by which, or by the inverse of which, matter at the start is thought to be a mistake: warned of."""


def check_start(
    model: Model, state: State, *, frame_dt: float, substep_dt: float | None, safety: float
) -> None:
    """Check the input of `mpm.simulate` once, after `conform`, and warn of matter that is hardly any more.

    Raises:
        UserError: Something is not finite, has no mass or volume, is inside out or lies outside
            the domain; a step or a material parameter makes no sense.
    """
    if not frame_dt > 0 or not 0 < safety <= 1 or not (substep_dt is None or substep_dt > 0):
        raise UserError(
            "`frame_dt` and `substep_dt` must be positive, and `safety` in (0, 1]",
            got=f"frame_dt={frame_dt}, substep_dt={substep_dt}, safety={safety}",
        )
    if model.axis is not None:
        raise UserError(
            "`simulate` runs on one device", got=f"axis={model.axis!r}", do="Use `mpm.rollout_sharded`"
        )
    if model.gravity is not None and not np.isfinite(np.asarray(model.gravity)).all():
        raise UserError("`model.gravity` must be finite", got=np.asarray(model.gravity).tolist())
    _check_particles(model, state)
    bound = float(stable_dt(model, state))
    if math.isnan(bound) or bound <= 0:
        raise UserError(
            "the material allows no time step: a stiffness is negative, infinite or not a number",
            got=f"a stable bound of {bound} s",
            do="Give E > 0 and 0 <= nu < 0.5",
        )


def _check_particles(model: Model, state: State) -> None:
    # Half a cell more than where particles are stopped: the last place from which a stencil is complete.
    low, high = (model.wall - 0.5) * model.grid.dx, (model.grid.cells - model.wall + 0.5) * model.grid.dx
    leaves = (state.x, state.v, state.C, state.F, model.mass, model.volume)
    finite = [np.isfinite(np.asarray(leaf)).reshape(len(leaf), -1).all(1) for leaf in leaves]
    x, J = np.asarray(state.x), np.linalg.det(np.asarray(state.F, float))
    faults = {
        "have a value that is not finite": ~np.logical_and.reduce(finite),
        "have no mass or no volume": ~((np.asarray(model.mass) > 0) & (np.asarray(model.volume) > 0)),
        "are turned inside out (det F <= 0)": ~(J > 0),
        f"lie outside the domain, {low:.3g} to {high:.3g} m along each axis": ~((low <= x) & (x <= high)).all(
            1
        ),
    }
    for fault, particles in faults.items():
        if particles.any():
            raise UserError(
                f"{particles.sum()} of {len(particles)} particles {fault} at the start",
                got=f"particle {np.flatnonzero(particles)[0]}",
                do="Mend or remove them",
            )
    extreme = (J < 1 / EXTREME) | (J > EXTREME)
    if extreme.any():
        warnings.warn(
            f"{extreme.sum()} of {len(J)} particles start with a volume changed by more than {EXTREME:g} times "
            f"(det F from {J.min():.3g} to {J.max():.3g}): the material is too soft for what they bear from the start "
            "(a stiffer or lighter one holds it), or `state.F` is not meant so",
            UserWarning,
            stacklevel=4,
        )
