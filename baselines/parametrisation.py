"""The numbers of a force field as one vector of comparable, dimensionless unknowns.

An action or constraint is u = |M| v, three numbers whose length is the magnitude: displacements are linear in it before
anything is touched, and no angle has a pole. The sign of M is part of what the action is: a squeeze is not a stretch
the other way round. With windows, two more: beginning and length, in clips. Where directions are known, u = |M| alone.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.parameters import ActionParameters, ForceFieldParameters
from physagent_jax.forces.schema import ForceField

SHORTEST = 1.0
"""[frames] of a window, at least."""

_EDGE = 1e-6  # within which an unknown is at its range's end


@dataclasses.dataclass(frozen=True)
class Parametrisation:
    """Unknowns of the force fields that differ from one another by numbers only.

    Attributes:
        template: Says what each action and constraint is.
        frame_count: Frames of the clip.
        windows: Whether windows are sought too; else they are the template's.
        directions: Whether these are sought; else they are the template's.
    """

    template: ForceField
    frame_count: int
    windows: bool = False
    directions: bool = True

    @property
    def entries(self) -> tuple:
        """Actions, then constraints."""
        return (*self.template.actions, *self.template.constraints)

    @property
    def width(self) -> int:
        """Unknowns of an entry's strength and direction."""
        return 3 if self.directions else 1

    @property
    def stride(self) -> int:
        """Unknowns of an entry."""
        return self.width + (2 if self.windows else 0)

    @property
    def size(self) -> int:
        """Unknowns in all."""
        return self.stride * len(self.entries)

    def encode(self, force_field: ForceField) -> np.ndarray:
        """The unknowns of a force field like the template, shape (size,)."""
        values, clip = [], self.frame_count - 1
        for item in (*force_field.actions, *force_field.constraints):
            size = abs(item.magnitude)
            values += (size * np.asarray(item.vector)).tolist() if self.directions else [size]
            if self.windows:
                first, last = item.active_time or (0, clip)
                values += [first / clip, (last - first) / clip]
        return np.array(values, float)

    def project(self, u: np.ndarray) -> np.ndarray:
        """The nearest unknowns that the skill library allows."""
        rows = np.array(u, float).reshape(-1, self.stride)
        for row, item in zip(rows, self.entries):
            if self.directions:
                size = float(np.linalg.norm(row[:3]))
                if size < 1e-12:
                    row[:3] = MAGNITUDE_MIN * np.asarray(item.vector)
                else:
                    row[:3] *= min(max(size, MAGNITUDE_MIN), MAGNITUDE_MAX) / size
            else:
                row[0] = min(max(row[0], MAGNITUDE_MIN), MAGNITUDE_MAX)
            if self.windows:
                least = SHORTEST / (self.frame_count - 1)
                row[-2] = min(max(row[-2], 0.0), 1.0 - least)
                row[-1] = min(max(row[-1], least), 1.0 - row[-2])
        return rows.reshape(-1)

    def list_blocked(self, u: np.ndarray, way: np.ndarray) -> np.ndarray:
        """Directions in which the library's range ends at ``u`` and ``way`` leads out of it.

        Args:
            u: Unknowns within the range.
            way: Where one would go, shape (size,).

        Returns:
            Orthonormal rows, shape (k, size).
        """
        blocked, clip = [], self.frame_count - 1
        for place in range(0, self.size, self.stride):
            strength = np.zeros(self.size)
            numbers = u[place : place + self.width]
            size = float(np.linalg.norm(numbers))
            strength[place : place + self.width] = numbers / size
            outwards = float(strength @ way)
            if (size >= MAGNITUDE_MAX - _EDGE and outwards > 0) or (
                size <= MAGNITUDE_MIN + _EDGE and outwards < 0
            ):
                blocked.append(strength)
            if self.windows:
                first, length = place + self.width, place + self.width + 1
                ends = (first, u[first] <= _EDGE, -1.0), (length, u[length] <= SHORTEST / clip + _EDGE, -1.0)
                blocked += [
                    np.eye(self.size)[index] for index, there, side in ends if there and side * way[index] > 0
                ]
                whole = np.zeros(self.size)
                whole[[first, length]] = np.sqrt(0.5)
                if u[first] + u[length] >= 1.0 - _EDGE and whole @ way > 0:
                    blocked.append(whole)
        if not blocked:
            return np.zeros((0, self.size))
        basis, r = np.linalg.qr(np.stack(blocked, axis=1))
        return basis[:, np.abs(np.diag(r)) > _EDGE].T

    def decode(self, u: np.ndarray) -> ForceField:
        """The force field nearest to ``u``."""
        return self.to_parameters(self.project(u)).to_force_field(self.template, self.frame_count)

    def to_parameters(self, u: np.ndarray) -> ForceFieldParameters:
        """The same numbers as the simulator takes them; not projected, for steps across the range's edge."""
        rows, made = np.asarray(u, float).reshape(-1, self.stride), []
        for row, item in zip(rows, self.entries):
            known = ActionParameters.of(item, self.frame_count)
            size = float(np.linalg.norm(row[: self.width]))
            vector = row[:3] / size if size and self.directions else known.vector
            magnitude = np.asarray(math.copysign(size, item.magnitude))
            window = known.window
            if self.windows:
                window = (self.frame_count - 1) * np.array([row[-2], row[-2] + row[-1]])
            made.append(ActionParameters(vector, magnitude, window))
        count = len(self.template.actions)
        return ForceFieldParameters(tuple(made[:count]), tuple(made[count:]))

    def pull_back(self, force_field: ForceField, gradient: ForceFieldParameters) -> np.ndarray:
        """A gradient by the simulator's numbers as one by the unknowns, shape (size,).

        Along v it is the derivative by the magnitude, across v that by the vector over |M|. What the simulator does
        with vectors that are no unit vectors does not enter: where an object is held, what M = 1 means goes by v.
        """
        values, clip = [], self.frame_count - 1
        slopes = (*gradient.actions, *gradient.constraints)
        for item, slope in zip((*force_field.actions, *force_field.constraints), slopes):
            v, by_vector = np.asarray(item.vector), np.asarray(slope.vector, float)
            along = float(slope.magnitude) * math.copysign(1.0, item.magnitude)
            across = (by_vector - (by_vector @ v) * v) / abs(item.magnitude)
            values += (along * v + across).tolist() if self.directions else [along]
            if self.windows:
                first, last = np.asarray(slope.window, float)
                values += [clip * (first + last), clip * last]
        return np.array(values, float)
