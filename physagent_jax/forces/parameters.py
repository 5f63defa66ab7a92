"""The continuous part of a force field as a pytree: what a gradient method moves.

What an action is (its skill, its region) stays in the `ForceField`; its vector, magnitude and window are here, as
arrays. `forces.compilation.compile_force_field` takes them in place of the force field's own numbers, traced or not.
"""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.core.strict import normalise_direction
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ForceField, VelocityConstraint, is_too_short

Array = jax.Array | np.ndarray
_SHORTEST = 0.01  # [frames] of a window that has closed; what single precision tells from none with a margin


@register_dataclass
@dataclasses.dataclass(frozen=True)
class ActionParameters:
    """Of one action or velocity constraint.

    Attributes:
        vector: Direction or axis, shape (3,). One that is no unit vector acts as one with its length times the
            magnitude.
        magnitude: M, scalar.
        window: First and last frame [frames], shape (2,).
    """

    vector: Array
    magnitude: Array
    window: Array

    @staticmethod
    def of(item: Action | VelocityConstraint, frame_count: int) -> ActionParameters:
        """An entry's own numbers, in double precision on the host."""
        first, last = item.active_time or (0, frame_count - 1)
        return ActionParameters(
            np.asarray(item.vector, np.float64),
            np.asarray(item.magnitude, np.float64),
            np.asarray([first, last], np.float64),
        )


@register_dataclass
@dataclasses.dataclass(frozen=True)
class ForceFieldParameters:
    """Of a whole force field, entry by entry.

    Attributes:
        actions: As `ForceField.actions`.
        constraints: As `ForceField.constraints`.
    """

    actions: tuple[ActionParameters, ...] = ()
    constraints: tuple[ActionParameters, ...] = ()

    @staticmethod
    def of(force_field: ForceField, frame_count: int) -> ForceFieldParameters:
        """A force field's own numbers, in double precision on the host.

        Args:
            force_field: What to take them from.
            frame_count: Frames of the clip, for windows that are the whole of it.
        """
        return ForceFieldParameters(
            tuple(ActionParameters.of(item, frame_count) for item in force_field.actions),
            tuple(ActionParameters.of(item, frame_count) for item in force_field.constraints),
        )

    def with_gains(self, force_field: ForceField) -> ForceFieldParameters:
        """The parameters with each magnitude times its entry's gain, as forces are made of them."""

        def apply(values: ActionParameters, item: Action | VelocityConstraint) -> ActionParameters:
            if item.gain == 1.0:
                return values
            return dataclasses.replace(values, magnitude=item.gain * values.magnitude)

        return ForceFieldParameters(
            tuple(map(apply, self.actions, force_field.actions)),
            tuple(map(apply, self.constraints, force_field.constraints)),
        )

    def to_force_field(self, force_field: ForceField, frame_count: int) -> ForceField:
        """The force field with these numbers, each moved to the nearest that the library allows.

        Vectors are made unit vectors and magnitudes brought into the range with their sign kept; windows begin inside
        the clip and have a length. A window that is the whole clip stays unsaid where the force field does not say it.

        Args:
            force_field: What each entry is.
            frame_count: Frames of the clip.

        Raises:
            UserError: The parameters are not this force field's, a number is not finite, or a vector is zero.
        """
        check_entries(self, force_field)
        return force_field.model_copy(
            update={
                group: tuple(
                    _make_entry(item, values, frame_count, f"{group}[{index}]")
                    for index, (item, values) in enumerate(
                        zip(getattr(force_field, group), getattr(self, group))
                    )
                )
                for group in ("actions", "constraints")
            }
        )


def check_entries(parameters: ForceFieldParameters, force_field: ForceField) -> None:
    """Refuse parameters of another force field.

    Raises:
        UserError: The numbers of entries differ.
    """
    for group in ("actions", "constraints"):
        given, wanted = len(getattr(parameters, group)), len(getattr(force_field, group))
        if given != wanted:
            raise UserError(
                f"`parameters.{group}` must have one entry per entry of the force field, {wanted}",
                got=given,
                do="Begin with `ForceFieldParameters.of(force_field, frame_count)`",
            )


def _make_entry(item, values: ActionParameters, frame_count: int, place: str):
    vector, magnitude, window = (
        np.asarray(part, np.float64) for part in (values.vector, values.magnitude, values.window)
    )
    if not all(np.isfinite(part).all() for part in (vector, magnitude, window)):
        raise UserError(f"`parameters.{place}` must be finite", got=repr(values))
    size = np.clip(np.abs(magnitude), MAGNITUDE_MIN, MAGNITUDE_MAX)
    direction = item.vector
    if tuple(vector.tolist()) != direction:
        try:
            direction = normalise_direction(tuple(vector.tolist()))
        except ValueError as error:
            raise UserError(f"`parameters.{place}.vector`: {error}") from None
    return item.model_copy(
        update={
            "vector": direction,
            "magnitude": float(np.copysign(size, magnitude)),
            "active_time": _read_window(item, window, frame_count),
        }
    )


def _read_window(
    item: Action | VelocityConstraint, window: np.ndarray, frame_count: int
) -> tuple[float, float] | None:
    end = float(frame_count - 1)
    first, last = (float(frame) for frame in window)
    if item.active_time is None and (first, last) == (0.0, end):
        return None
    first = min(max(first, 0.0), end - _SHORTEST)
    if last <= first or is_too_short(first, last):
        last = first + _SHORTEST * max(1.0, 1e-3 * end)
    return first, last
