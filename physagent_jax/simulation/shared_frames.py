"""The past that two scenes share: frames which their force fields cannot have made different.

A round of the loop takes them over from the round before instead of simulating and rendering them again. That is sound
because nothing in a frame depends on what comes after it:

* A force follows from the particles and the clock alone and is zero before its window opens. A push or a turn does not
  know when its window will close (`Skill.is_memoryless`); an impulse is spread over its window and a stretch grows with
  it, so these are compared as a whole.
* A held particle is held within its window only.
* The time step looks ahead (`mpm.frame`), but to the end of the frame that is about to be simulated.
* The grid window goes by the particles.

The clock sums substeps in single precision, so a window may open a little before or after its frame: one frame is given
away. Everything else of a scene has to be equal.
"""

from __future__ import annotations

import math

from physagent_jax.forces.schema import Action, ForceField, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.scene.config import SceneConfig

CLOCK_SLACK = 1  # frames; by as much the clock may be off (`is_clock_right`)
STRIDE = 8  # frames between places from which a push that is cut short can go on
Timed = Action | VelocityConstraint


def find_last_shared_frame(one: SceneConfig, other: SceneConfig) -> int | None:
    """The last frame that is the same in both scenes; the files that they name must not have changed in between.

    Returns:
        0 if only the rest pose is, frame_count - 1 if everything is; None if they differ in anything but what acts
        when (the object, its material, gravity, ...), or in the record that is asked for.
    """
    if _select_all_else(one) != _select_all_else(other):
        return None
    last = one.timing.frame_count - 1
    instants = sorted({0.0, *_collect_bounds(one), *_collect_bounds(other)})
    if _select_past(one, instants[-1]) == _select_past(other, instants[-1]):
        return last
    agreed = max(
        instant for instant in instants if _select_past(one, instant) == _select_past(other, instant)
    )
    return min(max(0, math.floor(agreed) - CLOCK_SLACK), last)


def find_restart_frames(config: SceneConfig) -> tuple[int, ...]:
    """Frames at which a scene that shares this one's past is likely to part from it, in order.

    The remedies of an executor begin where something begins or ends, or cut a push short.
    """
    instants = set(_collect_bounds(config))
    for timed in _list_items(config.force_field):
        if get_skill(timed).is_memoryless:
            first, last = _get_window(timed, config)
            instants |= set(range(math.floor(first) + STRIDE, math.ceil(last), STRIDE))
    frames = {math.floor(instant) - CLOCK_SLACK for instant in instants}
    return tuple(sorted(frame for frame in frames if 0 < frame < config.timing.frame_count - 2))


def is_clock_right(time: float, frame: int, frame_dt: float) -> bool:
    """Return whether a state's clock ``time`` [s] is so near its frame's that `CLOCK_SLACK` makes up for the rest."""
    return abs(time - frame * frame_dt) < 0.25 * CLOCK_SLACK * frame_dt


def _select_all_else(config: SceneConfig) -> SceneConfig:
    """The scene without what acts when."""
    gravity_only = ForceField(default_drop=config.force_field.default_drop)
    return config.model_copy(update=dict(force_field=gravity_only))


def _select_past(config: SceneConfig, instant: float) -> tuple:
    """The force field that can act up to ``instant`` [frames], in its own order: so sums round alike."""
    field = config.force_field
    return _select_begun(field.actions, config, instant), _select_begun(field.constraints, config, instant)


def _select_begun(items: tuple[Timed, ...], config: SceneConfig, instant: float) -> tuple[Timed, ...]:
    begun = []
    for timed in items:
        first, last = _get_window(timed, config)
        if first >= instant:
            continue
        known: dict = {}
        if (held := _find_held_until(timed)) is not None:
            known["held_until"] = min(held, instant) if instant > last else None
        if get_skill(timed).is_memoryless:
            last = min(last, instant)
        begun.append(timed.model_copy(update=dict(active_time=(first, last), **known)))
    return tuple(begun)


def _collect_bounds(config: SceneConfig) -> set[float]:
    """The frames at which windows open and close."""
    bounds = {
        float(bound) for timed in _list_items(config.force_field) for bound in _get_window(timed, config)
    }
    return bounds | {
        held for timed in _list_items(config.force_field) if (held := _find_held_until(timed)) is not None
    }


def _list_items(field: ForceField) -> tuple[Timed, ...]:
    return (*field.actions, *field.constraints)


def _find_held_until(timed: Timed) -> float | None:
    return timed.held_until if isinstance(timed, VelocityConstraint) else None


def _get_window(timed: Timed, config: SceneConfig) -> tuple[float, float]:
    """As `forces.parameters` has it [frames]."""
    return timed.active_time or (0, config.timing.frame_count - 1)
