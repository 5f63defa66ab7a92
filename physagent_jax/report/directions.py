"""Directions in the viewer's words, derived from the reference camera and world up."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.motion.schema import DirectionTable
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import CameraConfig

# A component below this share of a unit vector is not worth a word (about 9 degrees).
NEGLIGIBLE = 0.15
SLIGHT = 0.45
ALIGNED = 0.95

WORDS = (("right", "left"), ("up", "down"), ("towards us", "away from us"))
AXES = ("left\u2013right", "vertical", "viewing")
# What a positive (right-hand) turn about right, up and toward looks like to the viewer.
TURNS = (
    ("the top tips towards us", "the top tips away from us"),
    ("counter-clockwise seen from above", "clockwise seen from above"),
    ("counter-clockwise as we see it", "clockwise as we see it"),
)


def make_direction_table(camera: CameraConfig) -> DirectionTable:
    """The viewer's six directions as the agents are told them."""
    return DirectionTable(**find_viewer_directions(camera))


def find_components(vector: Sequence[float], table: DirectionTable) -> tuple[float, float, float]:
    """A world vector along the viewer's (right, up, toward)."""
    return _dot(vector, table.right), _dot(vector, table.up), _dot(vector, table.toward)


def describe_direction(vector: Sequence[float], table: DirectionTable) -> str:
    """A unit direction in words: "left", "right and slightly up"."""
    ranked = sorted(zip(find_components(vector, table), WORDS), key=lambda pair: -abs(pair[0]))
    words = []
    for value, (positive, negative) in ranked:
        if abs(value) < NEGLIGIBLE:
            continue
        word = positive if value > 0 else negative
        words.append(f"slightly {word}" if abs(value) < SLIGHT else word)
    return " and ".join(words) if len(words) < 3 else f"{words[0]}, {words[1]} and {words[2]}"


def describe_axis(axis: Sequence[float], table: DirectionTable) -> str:
    """An axis without sense, in words: "the left-right axis"."""
    values = [abs(value) for value in find_components(axis, table)]
    largest = max(range(3), key=values.__getitem__)
    if values[largest] >= ALIGNED:
        return f"the {AXES[largest]} axis"
    return f"an axis pointing {describe_direction(axis, table)}"


def describe_turn(axis: Sequence[float], table: DirectionTable) -> str:
    """A right-hand turn about ``axis`` as the viewer sees it."""
    values = find_components(axis, table)
    largest = max(range(3), key=lambda i: abs(values[i]))
    sense = TURNS[largest][0 if values[largest] > 0 else 1]
    return sense if abs(values[largest]) >= ALIGNED else f"mostly {sense}"


def label_world_axes(table: DirectionTable) -> tuple[str, str, str]:
    """The world axes with the viewer's word for each: ("x (right)", "y (away from us)", "z (up)")."""
    labels = []
    for name, unit in zip("xyz", ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        aligned = max(abs(value) for value in find_components(unit, table)) >= ALIGNED
        labels.append(f"{name} ({describe_direction(unit, table)})" if aligned else name)
    return tuple(labels)


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(p * q for p, q in zip(a, b))
