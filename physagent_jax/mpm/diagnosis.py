"""The diagnosis of a failed frame: its fault, whether another attempt is worth it, and the message if not."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import body_acceleration, map_materials

MAX_RETRIES = 6  # halvings of the step before a frame is given up
MAX_CRUSHES = 3  # attempts that crush matter to nothing before it is given up: no step helps against that
MAX_SUBSTEPS = 100_000  # in one frame, retries included; more would look like a hang


class Fault(enum.Enum):
    """A fault of an attempt at a frame."""

    LEFT = "the window was too small"
    CRUSHED = "matter is crushed to nothing"
    STEP = "the step was too long, as far as anybody knows"


@dataclasses.dataclass(frozen=True)
class Breach:
    """A failed attempt: its fault, and what to say of it.

    Attributes:
        fault: Its fault.
        words: The reason, for people.
        bound: The stable step that it led to [s], where nothing else is wrong; None = something else is.
    """

    fault: Fault
    words: str
    bound: float | None = None


def find_breach(model: Model, health: Health, bound: float) -> Breach | None:
    """Find the reason why a frame cannot be trusted, or None.

    Args:
        model: With the attempt's step and window.
        health: Health of its substeps.
        bound: The stable step where it led [s]; infinite where the substep is forced, whatever it is.
    """
    fault, reason = _find_fault(model, health)
    lowered = fault is None and float(model.dt) > bound
    if lowered:
        fault, reason = Fault.STEP, f"deformation lowered the stable bound to {bound:.3g} s"
    if fault is None:
        return None
    return Breach(fault, f"{reason} at dt = {float(model.dt):.3g} s", bound if lowered else None)


def _find_fault(model: Model, health: Health) -> tuple[Fault | None, str]:
    min_J = float(health.min_J)
    if not bool(health.finite):
        return Fault.STEP, f"a value is not finite (the least volume ratio is {min_J:.3g})"
    if int(health.outside) > 0:
        return Fault.LEFT, "particles left the grid window"
    if abs(min_J) < jnp.finfo(health.min_J.dtype).eps:
        return Fault.CRUSHED, f"{Fault.CRUSHED.value} (volume ratio {min_J:.3g})"
    if min_J <= 0:
        return Fault.STEP, f"matter is turned inside out (volume ratio {min_J:.3g})"
    increment = float(health.min_increment)
    if increment <= 0:
        return Fault.STEP, f"a substep turns matter inside out (volume ratio of the substep {increment:.3g})"
    cells = float(health.max_speed) * float(model.dt) / model.grid.dx
    if cells >= 1:
        return Fault.STEP, f"a particle crosses {cells:.2g} cells in one substep"
    return None, ""


def is_hopeless(breaches: Sequence[Breach], substeps: int, fixed: bool) -> bool:
    """Return whether a frame is to be given up after these attempts, the last one with so many substeps."""
    crushes = sum(breach.fault is Fault.CRUSHED for breach in breaches)
    spent = len(breaches) > MAX_RETRIES or crushes >= MAX_CRUSHES or 2 * substeps > MAX_SUBSTEPS
    return spent or (fixed and breaches[-1].fault is not Fault.LEFT)


def explain_failure(
    index: int, breaches: Sequence[Breach], fixed: bool, model: Model, state: State
) -> UserError:
    """The error to raise when frame ``index``, begun at ``state``, is given up."""
    if fixed:
        return UserError(
            f"frame {index} fails with the forced substep: {breaches[-1].words}",
            do='Take a smaller `substep_dt`, or "auto"',
        )
    what = f"frame {index} cannot be simulated: {'; '.join(breach.words for breach in breaches)}"
    if breaches[-1].fault is not Fault.CRUSHED:
        return UserError(what, do="Use a stiffer material, a weaker force, or a finer grid")
    load, stiffness = _measure_load(model, state)
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


def _measure_load(model: Model, state: State) -> tuple[float, float]:
    """Pressure of inertia, rho (|a| L + |v|^2), over the body's length L, and the greatest stiffness at rest [Pa]."""
    x, v = (
        np.asarray(state.x, float),
        np.asarray(state.v, float),
    )  # what is senseless may not fit single precision
    density = (np.asarray(model.mass, float) / np.asarray(model.volume, float)).max()
    acceleration = np.linalg.norm(np.asarray(body_acceleration(model, state), float), axis=-1).max()
    load = density * (acceleration * np.ptp(x, axis=0).max() + (v**2).sum(-1).max())
    rest = dataclasses.replace(state, F=jnp.broadcast_to(jnp.eye(3, dtype=state.F.dtype), state.F.shape))
    stiffness = map_materials(model, rest, lambda material, F, history: material.stiffness(F, history))
    return float(load), float(stiffness.max())
