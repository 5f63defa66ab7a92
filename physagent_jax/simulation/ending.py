"""The ending of a clip for people: what the object does after the last planned frame, until it rests.

Agents plan the planned frames alone, and the motion report is of those; where a sentence tells how the object is left,
perception looks at the ending by itself. A clip that stops in mid-motion looks broken, so the
simulation goes on a little. Actions end with the planned frames, and what moves comes to rest or is seen to go.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.forces.opposition import RISES
from physagent_jax.forces.schema import Action, ForceField, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.forces.swinging import find_runs, is_swing
from physagent_jax.mpm import Frame, simulate
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.compile.idle import is_led_to_end
from physagent_jax.scene.config import DomainBox
from physagent_jax.simulation.recording import Recording
from physagent_jax.simulation.rolling import Rolling

LONGEST = 1.0  # [s] beyond the planned frames
STILL = 0.04  # [sizes / s]; what is slower looks still
CRUMBS = 0.02  # share of the particles that may be faster: crumbs do not keep the clip going
NEAR = 2.0  # cells from the domain's wall at which it is felt
STEADY = 0.5  # [s] for which what was swung on the ground stands by itself at most
RESTING = 0.2  # [s] for which it must look still: at the turning point of a swing it does for a moment

Moved = tuple[np.ndarray, np.ndarray]
"""Positions [m], shape (T, n, 3), and deformation gradients, shape (T, n, 3, 3), of particles in a clip's frames."""


def simulate_ending(recording: Recording, moved: Moved | None = None) -> Moved:
    """The same as `go_on`, which ``moved`` is the result of if it is given, of the body's particles."""
    x, F = moved or go_on(recording)
    return x[:, recording.scene.back], F[:, recording.scene.back]


def go_on(recording: Recording) -> Moved:
    """Positions and deformation gradients of the model's particles, the ending included.

    What is held, carried or steadied up to the last planned frames is seen so at the end:
    letting it go would undo what was asked. An ending that cannot be simulated is cut short, with a warning: the
    planned frames are what counts.
    """
    scene, dt = recording.scene, recording.scene.config.timing.frame_dt
    x, F = recording.x, recording.F
    speeds = np.linalg.norm(np.diff(x[-2:], axis=0), axis=2) / dt
    wanted = max(int(np.ceil(RESTING / dt)), 1)
    still = wanted if _is_still(speeds[0], scene) else 0  # planned frames are there for long enough
    more: list[Frame] = []
    if not still and not _is_kept(scene):
        for frame in _simulate_on(scene, recording.last, int(np.ceil(LONGEST / dt))):
            more.append(frame)
            still = still + 1 if _is_still(np.linalg.norm(np.asarray(frame.state.v), axis=1), scene) else 0
            if still >= wanted:
                break
    if not more:
        return x, F
    rolling = Rolling.of(scene)
    for each in x[1:]:
        rolling.advance(each)
    shown = [rolling.show(frame).state for frame in more]
    return tuple(  # type: ignore[return-value]
        np.concatenate([each, np.stack([np.asarray(getattr(state, name)) for state in shown])])
        for each, name in ((x, "x"), (F, "F"))
    )


def _simulate_on(scene: CompiledScene, last: Frame, count: int):
    timing = scene.config.timing
    frames = simulate(
        scene.windowed,
        scene.state,
        frame_count=last.index + 1 + count,
        frame_dt=timing.frame_dt,
        substep_dt=None if timing.substep_dt == "auto" else timing.substep_dt,
        safety=timing.safety,
        force_substep=timing.force_substep,
        ledger=scene.config.ledger,
        begin=last,
        tell_limits=False,
    )
    dx, before = scene.config.domain.dx, _measure_clearance(scene, last)
    try:
        for frame in frames:
            left = _measure_clearance(scene, frame)
            if ((left < NEAR * dx) & (left < before - 0.5 * dx)).any():
                return  # it comes to the domain's wall, which nobody sees
            yield frame
    except UserError as error:
        warnings.warn(f"the clip stops before it rests: {error.what}", UserWarning, stacklevel=2)


def _measure_clearance(scene: CompiledScene, frame: Frame) -> np.ndarray:
    """Distances of the particles from the domain's six walls [m]; those of a domain box stand inside its faces."""
    x, size, dx = np.asarray(frame.state.x)[scene.back], scene.config.domain.size, scene.config.domain.dx
    inside = max((each.padding for each in scene.config.boundaries if isinstance(each, DomainBox)), default=0)
    return np.concatenate([x.min(axis=0), size - x.max(axis=0)]) - inside * dx


def _is_kept(scene: CompiledScene) -> bool:
    """Return whether a skill keeps the object as it was asked to be until the planned frames end.

    It holds something where it was brought, leads a part of what is held, carries or rocks the object, or swings it to
    and fro: what is pushed over the ground is held upright, gives back what it was given, and is left where it stood.
    """
    timing, field = scene.config.timing, scene.config.force_field
    last = timing.frame_count - 1
    carrying = [each for each in (*field.actions, *field.constraints) if _carries(each)]
    free = scene.config.anchor.kind == "none"
    swung = [field.actions[run[-1]] for run in find_runs(field) if free and _swings(field, run)]
    return is_led_to_end(scene.config) or any(
        each.active_time is None or each.active_time[1] >= last - spare
        for entries, spare in ((carrying, 0.0), (swung, STEADY / timing.frame_dt))
        for each in entries
    )


def _swings(field: ForceField, run: list[int]) -> bool:
    pushes = [field.actions[index] for index in run]
    return pushes[0].region is None and is_swing(pushes)


def _carries(entry: Action | VelocityConstraint) -> bool:
    """Return whether a skill lifts all of the object for as long as it acts."""
    skill, lift = get_skill(entry), entry.vector[2] * math.copysign(1.0, entry.magnitude)
    return entry.region is None and "move" in skill.causes and not skill.is_sudden and lift > RISES


def _is_still(speeds: np.ndarray, scene: CompiledScene) -> bool:
    return float(np.quantile(speeds, 1 - CRUMBS)) < STILL * scene.body.extent
