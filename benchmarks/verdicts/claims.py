"""Claims of a motion's words in numbers, held against the particles: labels rest on this.

A clip whose true motion is not the labelled one says nothing about the planner: it is listed and not judged. The
numbers come with the motions (`motions`), the measures are taken here from the particles alone; neither the planner's
nor the perception's code is used. Lengths are body lengths (1 m), coordinates the viewer's: right, up, away.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Literal

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

Direction = tuple[float, float, float]
Part = Literal["all", "top", "bottom", "left", "right"]
ASIDE, LEAST_ASIDE = 0.3, 0.08  # of the way, and [L], that what moves may go to the side
LEAST_TILT = 15.0  # [degrees] that what turns may turn about other axes, or `ASIDE` of its turn
MOST_TURN = 40.0  # [degrees] of what is not said to turn
MOST_DRIFT = 0.12  # [L] of what is not said to move
STILL = 0.03  # [L] by which the matter of what stays still may move in the mean
APART = 0.16  # [L] between pieces: two grid cells, over which matter no longer pulls at matter
CRUMB = 0.02  # share of the matter that is no piece yet
SPREAD = 1.5  # of the root mean square radius, from which on something has flown to pieces
GONE = 0.05  # of the first picture's matter that may be left in the last of what is gone


@dataclasses.dataclass(frozen=True)
class Seen:
    """A clip's particles.

    Attributes:
        x: Positions in the viewer's axes [L], shape (T, n, 3).
        covered: Pixels that show the object, shape (T,).
        frame_dt: [s].
    """

    x: np.ndarray
    covered: np.ndarray
    frame_dt: float

    def find_frame(self, time: float) -> int:
        """The frame nearest to ``time`` [s]; the last one for what lies behind it."""
        return int(min(round(min(time, 1e6) / self.frame_dt), len(self.x) - 1))

    def select(self, part: Part) -> np.ndarray:
        """Particles of a third of the object at the start, or of all of it, shape (n,)."""
        if part == "all":
            return np.ones(self.x.shape[1], bool)
        values = self.x[0, :, 1 if part in ("top", "bottom") else 0]
        share = (values - values.min()) / max(np.ptp(values), 1e-9)
        return share > 2 / 3 if part in ("top", "right") else share < 1 / 3

    def measure_shift(self, part: Part = "all") -> np.ndarray:
        """Way of the part's mean since the start [L], shape (T, 3)."""
        mean = self.x[:, self.select(part)].mean(1)
        return mean - mean[0]

    def measure_turn(self, part: Part = "all") -> np.ndarray:
        """Rotation vectors (right-hand rule) from frame to frame, added up [degrees], shape (T, 3)."""
        x = self.x[:, self.select(part)]
        x = x - x.mean(1, keepdims=True)
        steps = [Rotation.align_vectors(after, before)[0].as_rotvec() for before, after in zip(x, x[1:])]
        # (right, up, away) is left-handed: there the same turn about the same axis has the other sign.
        return -np.degrees(np.cumsum([np.zeros(3), *steps], axis=0))

    def count_pieces(self) -> int:
        """At the end; crumbs do not count."""
        x = self.x[-1]
        pairs = KDTree(x).query_pairs(APART, output_type="ndarray")
        links = coo_matrix((np.ones(len(pairs)), pairs.T), (len(x), len(x)))
        sizes = np.bincount(connected_components(links, directed=False)[1])
        return int((sizes > CRUMB * len(x)).sum())

    def measure_spread(self) -> float:
        """Root mean square radius at the end over that at the start."""
        first, last = (np.sqrt(((x - x.mean(0)) ** 2).sum(1).mean()) for x in (self.x[0], self.x[-1]))
        return float(last / first)


@dataclasses.dataclass(frozen=True)
class Shift:
    """The part's mean moves along ``direction`` by ``low`` to ``high`` [L] between two instants, and hardly aside.

    Attributes:
        direction: Unit vector.
        low, high: [L].
        start, end: [s].
        part: Part of the object.
        against: Another part, whose own way is taken off; None = none.
        aside: Share of the way that it may go to the side.
    """

    direction: Direction
    low: float
    high: float
    start: float = 0.0
    end: float = math.inf
    part: Part = "all"
    against: Part | None = None
    aside: float = ASIDE

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        way = seen.measure_shift(self.part) - (seen.measure_shift(self.against) if self.against else 0.0)
        way = way[seen.find_frame(self.end)] - way[seen.find_frame(self.start)]
        along = float(way @ self.direction)
        aside = float(np.linalg.norm(way - along * np.asarray(self.direction)))
        if not self.low <= along <= self.high:
            return f"{self.part} moves by {along:.2f} L, said are {self.low:.2f} to {self.high:.2f}"
        if aside > max(self.aside * abs(along), LEAST_ASIDE):
            return f"{self.part} moves by {along:.2f} L and by {aside:.2f} L aside"
        return None


@dataclasses.dataclass(frozen=True)
class Reach:
    """The part's mean gets ``low`` to ``high`` [L] far along ``direction`` at some time; and back, if that is said.

    Attributes:
        direction: Unit vector.
        low, high: [L].
        part: Part of the object.
        start, end: [s].
        back: Share of the way that may be left at the end.
    """

    direction: Direction
    low: float
    high: float = math.inf
    part: Part = "all"
    start: float = 0.0
    end: float = math.inf
    back: float = math.inf

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        way = seen.measure_shift(self.part) @ np.asarray(self.direction)
        far = float(way[seen.find_frame(self.start) : seen.find_frame(self.end) + 1].max())
        if not self.low <= far <= self.high:
            return f"{self.part} gets {far:.2f} L far, said are {self.low:.2f} to {self.high:.2f}"
        if abs(way[-1]) > self.back * far:
            return f"{self.part} gets {far:.2f} L far and is {way[-1]:.2f} L away at the end"
        return None


@dataclasses.dataclass(frozen=True)
class Turn:
    """The part turns about ``axis`` by ``low`` to ``high`` [degrees] between two instants, and hardly about others.

    Attributes:
        axis: Unit vector, right-hand rule.
        low, high: [degrees].
        start, end: [s].
        part: Part of the object.
        against: Another part, whose own turn is taken off; None = none.
    """

    axis: Direction
    low: float
    high: float
    start: float = 0.0
    end: float = math.inf
    part: Part = "all"
    against: Part | None = None

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        turn = seen.measure_turn(self.part) - (seen.measure_turn(self.against) if self.against else 0.0)
        turned = turn[seen.find_frame(self.end)] - turn[seen.find_frame(self.start)]
        about = float(turned @ np.asarray(self.axis))
        if not self.low <= about <= self.high:
            return f"{self.part} turns by {about:.0f} degrees, said are {self.low:.0f} to {self.high:.0f}"
        aside = float(np.linalg.norm(turned - about * np.asarray(self.axis)))
        if aside > max(ASIDE * abs(about), LEAST_TILT):
            return f"{self.part} turns by {about:.0f} degrees and by {aside:.0f} about other axes"
        return None


@dataclasses.dataclass(frozen=True)
class Resize:
    """The extent along ``direction`` changes by ``low`` to ``high`` of itself by the end."""

    direction: Direction
    low: float
    high: float

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        ends = np.percentile(seen.x[[0, -1]] @ np.asarray(self.direction), (1, 99), axis=1)
        first, last = ends[1] - ends[0]
        change = float(last / first - 1)
        if not self.low <= change <= self.high:
            return f"it changes by {100 * change:+.0f} %, said are {100 * self.low:+.0f} to {100 * self.high:+.0f}"
        return None


@dataclasses.dataclass(frozen=True)
class Still:
    """Nothing moves."""

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        way = float(np.linalg.norm(seen.x - seen.x[0], axis=2).mean(1).max())
        return f"it moves by {way:.2f} L" if way > STILL else None


@dataclasses.dataclass(frozen=True)
class Broken:
    """Flies to pieces."""

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        spread = seen.measure_spread()
        return None if spread > SPREAD else f"it gets {spread:.2f} times as wide, and is whole"


@dataclasses.dataclass(frozen=True)
class Gone:
    """Has left the picture by the end."""

    def find_fault(self, seen: Seen) -> str | None:
        """Departure from what is said; None if there is none."""
        left = float(seen.covered[-1] / max(seen.covered[0], 1))
        return f"{100 * left:.0f} % of it are in the last picture" if left > GONE else None


Claim = Shift | Reach | Turn | Resize | Still | Broken | Gone


def find_faults(claims: Iterable[Claim], seen: Seen, tips: bool = False) -> list[str]:
    """Departures from what is said, a line each; nothing if the motion is the labelled one.

    Args:
        claims: What is said. What flies to pieces, or leaves the picture, is held to that alone.
        seen: What happens.
        tips: Whether the object may lean without that being said, as what is held at its foot does.
    """
    claims = list(claims)
    if last := [claim for claim in claims if isinstance(claim, Broken | Gone)]:
        claims = last
    faults = [fault for claim in claims if (fault := claim.find_fault(seen)) is not None]
    if last:
        return faults
    turn = float(np.linalg.norm(seen.measure_turn(), axis=1).max())
    if not tips and turn > MOST_TURN and not any(isinstance(claim, Turn) for claim in claims):
        faults.append(f"it turns by {turn:.0f} degrees, which nobody says")
    drift = float(np.linalg.norm(seen.measure_shift(), axis=1)[-1])
    if not tips and drift > MOST_DRIFT and not any(isinstance(claim, Shift | Reach) for claim in claims):
        faults.append(f"it moves by {drift:.2f} L, which nobody says")
    if (pieces := seen.count_pieces()) > 1:
        faults.append(f"it breaks into {pieces} pieces, which nobody says")
    return faults
