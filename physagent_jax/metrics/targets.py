"""Targets of tasks: clauses over the true paths of an object's particles. Pure data, no arrays.

A clause names what is measured (`metrics.measures` says how), of the whole object or of one end of it, in which frames,
the value that is wanted and the tolerance: it is met where the value differs by at most the tolerance. Lengths are in
body lengths (the longest side of the rest particles' box), angles in degrees, times in frames, frequencies in Hz.
Directions are the scene's, not the viewer's, and frame 0 is the rest pose.

How wide a tolerance is follows from what has to fail, and from what people see:

- Half and twice of a success must fail: a value is allowed to differ by a third of the target (`WIDEST`) at most.
- The contrary and what goes aside must fail: 30 degrees for a direction, where a neighbouring one of the viewer's six
  words begins at 45.
- What is not wanted (`target` 0) may be as large as what people do not notice or forgive: 0.05 body lengths of motion
  pass for rest, and a fifth of a change of shape for none.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Direction, Positive, Strict, Vector

WIDEST = 1 / 3
"""Largest tolerance, as a share of the value that is asked for: half and twice of it miss."""

Frame = Annotated[int, Field(ge=0, le=100_000)]
Window = tuple[Frame, Frame]
Length = Annotated[float, Field(ge=-100.0, le=100.0)]
Angle = Annotated[float, Field(ge=-10_000.0, le=10_000.0)]


class _Clause(Strict):
    """The base of all clauses.

    Attributes:
        window: First and last frame that are looked at, inclusive; what is measured is what happens between them.
        part: An end of the object: the third of its mass that lies farthest along this direction at rest; None = all.
    """

    window: Window
    part: Direction | None = None

    @model_validator(mode="after")
    def _check_window(self):
        if self.window[0] >= self.window[1]:
            raise ValueError(f"`window` must end after it begins (got {list(self.window)})")
        target, tolerance = getattr(self, "target", None), getattr(self, "tolerance", None)
        if target and tolerance is not None:
            check_width(target, tolerance)
        return self


class Direct(_Clause):
    """The angle between the object's displacement over the window and ``toward``.

    Attributes:
        toward: The direction that is wanted.
        tolerance: [degrees].
    """

    kind: Literal["direction"] = "direction"
    toward: Direction
    tolerance: Annotated[float, Field(gt=0, le=45)] = 30.0


class Distance(_Clause):
    """The distance of the object's mass centre from its place in the window's first frame.

    Attributes:
        along: Direction that the way is measured along; None = the displacement's length.
        when: At the window's end, or where it is greatest.
        target, tolerance: [body lengths].
    """

    kind: Literal["distance"] = "distance"
    along: Direction | None = None
    when: Literal["end", "peak"] = "end"
    target: Length
    tolerance: Positive


class Turn(_Clause):
    """The right-handed rotation about an axis since the window's first frame, beyond 180 degrees too.

    Attributes:
        axis: Direction of the axis.
        against: An end, as ``part``, whose own turn is taken off: the twist between the two; None = in the scene.
        when: At the window's end, or where it is greatest.
        target, tolerance: [degrees].
    """

    kind: Literal["turn"] = "turn"
    axis: Direction
    against: Direction | None = None
    when: Literal["end", "peak"] = "end"
    target: Angle
    tolerance: Positive


class Stretch(_Clause):
    """Change of length of what lies along a direction at rest, over its length in the window's first frame.

    It is the best affine map's, so a rotation is none.

    Attributes:
        along: The direction, which turns with the object; None = the mean of all, by the cube root of the volume.
        when: At the window's end, or where it is greatest.
        target, tolerance: [1]; shorter is negative.
    """

    kind: Literal["stretch"] = "stretch"
    along: Direction | None = None
    when: Literal["end", "peak"] = "end"
    target: Annotated[float, Field(gt=-1.0, le=10.0)]
    tolerance: Positive


class Oscillation(_Clause):
    """To and fro: half of the way from one extreme to the other, and how often.

    Attributes:
        along: The line.
        target, tolerance: Target and tolerance of the amplitude [body lengths].
        frequency: Wanted [Hz].
        frequency_tolerance: [Hz].
    """

    kind: Literal["oscillation"] = "oscillation"
    along: Direction
    target: Annotated[float, Field(gt=0, le=100)]
    tolerance: Positive
    frequency: Positive
    frequency_tolerance: Positive

    @model_validator(mode="after")
    def _check_frequency(self) -> Oscillation:
        check_width(self.frequency, self.frequency_tolerance)
        return self


class Event(Strict):
    """A motion, for `Order`.

    Attributes:
        part: As for clauses.
        along: Its direction; what goes the other way does not count.
    """

    part: Direction | None = None
    along: Direction


class Order(_Clause):
    """One motion, then another: the time from the middle of the first to the middle of the second.

    Attributes:
        first, second: The motions; ``part`` of the clause itself is not used.
        target, tolerance: [frames].
    """

    kind: Literal["order"] = "order"
    part: None = None
    first: Event
    second: Event
    target: Annotated[float, Field(gt=0, le=100_000)]
    tolerance: Positive


class Rest(_Clause):
    """Nothing moves: root mean square displacement of the particles from the window's first frame, at its greatest.

    Attributes:
        tolerance: [body lengths].
    """

    kind: Literal["rest"] = "rest"
    tolerance: Positive = 0.05


class Integrity(_Clause):
    """It hangs together: how much neighbours part beyond ``limit`` times their distance at rest, on average.

    A quarter of the links that are twice as long as allowed count as much as a twentieth that are six times as long.
    Crushing is not seen.

    Attributes:
        limit: Factor up to which a link may grow for nothing.
        tolerance: Mean growth beyond it [rest lengths]: a few strays pass, a limb that comes off does not.
    """

    kind: Literal["integrity"] = "integrity"
    part: None = None
    limit: Annotated[float, Field(ge=1.0, le=100.0)] = 1.8
    tolerance: Positive = 0.01


class Follow(Strict):
    """The position of a part.

    Attributes:
        part: As for clauses.
        centres: Displacement of its mass centre from frame 0 in the frames of the window [body lengths].
    """

    part: Direction | None = None
    centres: tuple[Vector, ...]


class Path(_Clause):
    """Stored paths are followed: the distance from them at its greatest.

    Attributes:
        places: The paths; ``part`` of the clause itself is not used.
        tolerance: [body lengths].
    """

    kind: Literal["path"] = "path"
    part: None = None
    places: Annotated[tuple[Follow, ...], Field(min_length=1)]
    tolerance: Positive = 0.05

    @model_validator(mode="after")
    def _check_length(self) -> Path:
        count = self.window[1] - self.window[0] + 1
        if wrong := [len(place.centres) for place in self.places if len(place.centres) != count]:
            raise ValueError(f"each path must have the window's {count} frames (got {wrong[0]})")
        return self


Clause = Annotated[
    Direct | Distance | Turn | Stretch | Oscillation | Order | Rest | Integrity | Path,
    Field(discriminator="kind"),
]


class Target(Strict):
    """The target of a task.

    Attributes:
        clauses: All of them have to be met.
    """

    clauses: Annotated[tuple[Clause, ...], Field(min_length=1, max_length=64)]

    @property
    def last_frame(self) -> int:
        """The last frame that a clause looks at."""
        return max(clause.window[1] for clause in self.clauses)


def check_width(target: float, tolerance: float) -> None:
    """Refuse a tolerance with which half or twice of the target would pass.

    Raises:
        ValueError: It is wider than `WIDEST` of the target.
    """
    if tolerance > WIDEST * abs(target) * (1 + 1e-9):
        raise ValueError(
            f"the tolerance must be at most a third of the target, or half of it would pass (got {tolerance:g} of "
            f"{target:g})"
        )


def hash_target(target: Target) -> str:
    """SHA-256 of the target's numbers: two targets that ask for the same have the same."""
    text = json.dumps(_round(target.model_dump(mode="json")), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _round(value):
    """Numbers to nine digits: unit vectors come out of different machines with another last one."""
    rounders: dict[type, Callable] = {
        float: lambda number: float(f"{number:.9g}") + 0.0,
        list: lambda items: [_round(item) for item in items],
        dict: lambda items: {key: _round(item) for key, item in items.items()},
    }
    return rounders.get(type(value), lambda other: other)(value)
