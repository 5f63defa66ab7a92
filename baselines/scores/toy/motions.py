"""Motions to learn, the words for them, and how a sentence is read: what the toy prior takes for text."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField

FRAMES = 16

WORDS = (
    "move",
    "stretch",
    "squeeze",
    "turn",
    "tilt",
    "sway",
    "still",
    "left",
    "right",
    "up",
    "down",
    "sideways",
)
"""The condition is which of these a sentence contains."""

SYNONYMS = {
    "move": "push pushes pushed pull pulls pulled hit hits knock kick shove throw throws blow blows moves slide slides "
    "drift drifts fly flies wind",
    "move down": "drop drops fall falls falling sink sinks lower",
    "move up": "lift lifts rise rises raise raises jump jumps",
    "stretch": "stretches stretched elongate lengthen tear",
    "squeeze": "squeezes compress compresses flatten crush press presses",
    "turn": "turns spin spins rotate rotates twist twists twirl",
    "tilt": "tilts lean leans tip tips topple bend bends",
    "sway": "sways swing swings shake shakes oscillate oscillates wobble",
    "still": "rest rests motionless static",
    "left": "leftwards leftward",
    "right": "rightwards rightward",
    "up": "upwards upward taller vertically",
    "down": "downwards downward",
    "sideways": "horizontally wider lengthwise",
}
_MEANING = {word: (word,) for word in WORDS} | {
    each: tuple(meaning.split()) for meaning, words in SYNONYMS.items() for each in words.split()
}


def read_prompt(prompt: str) -> np.ndarray:
    """The words of `WORDS` that a sentence means, 0 or 1, float32, shape (words,).

    Raises:
        UserError: It contains none of them.
    """
    known = {word for each in re.findall("[a-z]+", prompt.lower()) for word in _MEANING.get(each, ())}
    if not known:
        raise UserError(
            "the toy prior knows no word of the prompt",
            got=prompt,
            do=f"It knows {', '.join(WORDS)} and a few synonyms",
        )
    return np.array([word in known for word in WORDS], np.float32)


def _shift(x: float, z: float) -> Callable[[np.random.Generator], tuple[Action, ...]]:
    """Go one way, all the time or from one hit: across the picture, at most 15 degrees off."""

    def draw(rng: np.random.Generator) -> tuple[Action, ...]:
        angle = np.deg2rad(rng.uniform(-15, 15))
        vector = (
            x * np.cos(angle) - z * np.sin(angle),
            rng.uniform(-0.2, 0.2),
            x * np.sin(angle) + z * np.cos(angle),
        )
        if rng.random() < 0.5:
            return (_act(ActionType.TRANSLATION, vector, rng.uniform(0.6, 1.5)),)
        begin = float(rng.integers(0, 4))
        return (_act(ActionType.IMPULSE, vector, rng.uniform(0.6, 1.5), (begin, begin + 2)),)

    return draw


def _one(kind: ActionType, vector: tuple[float, float, float], sign: int | None = 1):
    """One action about or along an axis that is a little off; ``sign`` None = either."""

    def draw(rng: np.random.Generator) -> tuple[Action, ...]:
        off = tuple(np.asarray(vector) + rng.uniform(-0.15, 0.15, 3))
        return (_act(kind, off, (sign or rng.choice([-1, 1])) * rng.uniform(0.9, 1.6)),)

    return draw


def _sway(rng: np.random.Generator) -> tuple[Action, ...]:
    """To one side, back past the middle, and again."""
    side = rng.choice([-1, 1]) * rng.uniform(1.0, 1.5)
    ends = (0.0, 3.5, 11.0, float(FRAMES - 1))
    return tuple(
        _act(ActionType.TRANSLATION, (1, 0, 0), sign * side, window)
        for sign, window in zip((1, -1, 1), zip(ends, ends[1:]))
    )


def _act(kind: ActionType, vector, magnitude: float, window: tuple[float, float] | None = None) -> Action:
    x, y, z = (float(each) for each in vector)
    return Action(action_type=kind, vector=(x, y, z), magnitude=float(magnitude), active_time=window)


MOTIONS: dict[str, Callable[[np.random.Generator], tuple[Action, ...]]] = {
    "move left": _shift(-1, 0),
    "move right": _shift(1, 0),
    "move up": _shift(0, 1),
    "move down": _shift(0, -1),
    "stretch sideways": _one(ActionType.SCALE, (1, 0, 0)),
    "stretch up": _one(ActionType.SCALE, (0, 0, 1)),
    "squeeze sideways": _one(ActionType.SCALE, (1, 0, 0), -1),
    "turn": _one(ActionType.TORQUE, (0, 0, 1), None),
    "tilt left": _one(ActionType.TORQUE, (0, 1, 0), -1),
    "tilt right": _one(ActionType.TORQUE, (0, 1, 0)),
    "sway": _sway,
    "still": lambda rng: (),
}
"""Actions that show a motion, by its prompt, for a viewer who looks along +y; z is up."""


def draw_force_field(prompt: str, rng: np.random.Generator) -> ForceField:
    """A force field that shows the motion."""
    return ForceField(default_drop=False, actions=MOTIONS[prompt](rng))
