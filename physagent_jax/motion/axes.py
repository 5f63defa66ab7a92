"""Axes of turns whose sense is told by where a side or the top goes."""

from __future__ import annotations

from physagent_jax.core.strict import Vector
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.vectors import cosine, cross, normalise


def find_turn_towards(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the viewer's side (or, for toward and away, the top) moves along ``direction``."""
    toward, up = brief.directions.toward, brief.directions.up
    reference = up if abs(cosine(direction, toward)) > 0.7 else toward
    return normalise(cross(reference, direction)) or up


def find_lean_axis(direction: Vector, brief: SceneBrief) -> Vector:
    """Axis about which the top moves along ``direction``."""
    return normalise(cross(brief.directions.up, direction)) or brief.directions.toward
