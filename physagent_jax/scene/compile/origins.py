"""The origins of a model's forces and constraints in a scene."""

from __future__ import annotations

import dataclasses
from itertools import accumulate
from typing import Any

from physagent_jax.mpm import Model


@dataclasses.dataclass(frozen=True)
class Origins:
    """Numbers of them, in the order in which the model has them.

    Attributes:
        skills: Forces of the force field.
        terms: Force terms of the scene.
        impulses: Impulses among the scene's constraints, which are forces too.
        bodies: Constraints of rigid bodies.
        grips: Velocity constraints of the force field.
        motions: Prescribed motions among the scene's constraints; after them comes what is held still, if anything.
    """

    skills: int
    terms: int
    impulses: int
    bodies: int
    grips: int
    motions: int

    def split_forces(self, model: Model) -> tuple[tuple[Any, ...], ...]:
        """The forces of skills, of terms, of impulses."""
        return _split(model.forces, self.skills, self.terms, self.impulses)

    def split_constraints(self, model: Model) -> tuple[tuple[Any, ...], ...]:
        """The constraints of rigid bodies, of grips, of prescribed motions, and what is held still."""
        count = len(model.constraints) - self.bodies - self.grips - self.motions
        return _split(model.constraints, self.bodies, self.grips, self.motions, count)

    def replace(self, model: Model, **groups: tuple[Any, ...]) -> Model:
        """``model`` with other forces or constraints in some of the groups, which the fields name."""
        forces = dict(zip(("skills", "terms", "impulses"), self.split_forces(model))) | groups
        constraints = (
            dict(zip(("bodies", "grips", "motions", "held"), self.split_constraints(model))) | groups
        )
        return model.replace(
            forces=(*forces["skills"], *forces["terms"], *forces["impulses"]),
            constraints=(
                *constraints["bodies"],
                *constraints["grips"],
                *constraints["motions"],
                *constraints["held"],
            ),
        )


def _split(parts: tuple[Any, ...], *counts: int) -> tuple[tuple[Any, ...], ...]:
    return tuple(parts[end - count : end] for count, end in zip(counts, accumulate(counts)))
