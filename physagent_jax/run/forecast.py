"""The time that a run still takes, estimated: until the clip of the round under way, and until the run's end."""

from __future__ import annotations

import time
from collections.abc import Callable

from physagent_jax.scene.cost import Cost

CLOSING = 1.0  # seconds of the results and the report, about
PATIENCE = 4.0  # times the steps of an object at rest, that a further round may take
BRIEF = 45.0  # [s] of simulation, as estimated, that it may always take
FIRST = 3.0  # times as much of both, that the first round may take: without it there is no clip


def find_most_substeps(cost: Cost) -> float:
    """Substeps beyond which a further round is not worth its time: nobody waits minutes for what may be no better.

    Args:
        cost: Estimated cost of a round.
    """
    each = (cost.seconds - cost.watching) / cost.substeps
    return max(PATIENCE * cost.substeps, BRIEF / max(each, 1e-9))


class Forecast:
    """Estimates that begin with what a scene should cost and go by what its frames and rounds have taken.

    A round is simulated; then its clip is drawn while its pictures are measured.

    Args:
        cost: Estimated cost of a round.
        rounds: How many rounds there are at most.
        now: Clock [s].
        patience: Factor on what the first round may take.
    """

    def __init__(
        self, cost: Cost, rounds: int, now: Callable[[], float] = time.perf_counter, *, patience: float = 1.0
    ):
        self._rounds, self._now, self._cost, self._patience = rounds, now, cost, patience
        self._simulating = max(cost.seconds - cost.watching, 0.0)  # [s] a round's simulation takes
        self._clip = self._rest = cost.watching  # [s] from its end to the clip, and to the round's end
        self.begin_round(0)

    @property
    def most_substeps(self) -> float:
        """Substeps that the round may take."""
        most = find_most_substeps(self._cost)
        return most if self._index else FIRST * self._patience * most

    def begin_round(self, index: int, substeps: float | None = None) -> None:
        """Round ``index``, counted from 0, begins.

        Args:
            index: Which one.
            substeps: Those that its scene takes at rest, once it is compiled: what is idle takes few.
        """
        if substeps is not None and not index:
            self._simulating *= min(substeps / self._cost.substeps, 1.0)
        self._index, self._begun = index, self._now()
        self._first: tuple[int, float] | None = None
        self._last: tuple[int, int, float] | None = None
        self._simulated: float | None = None
        self._shown = False

    def count_frame(self, done: int, total: int) -> None:
        """``done`` of ``total`` frames are simulated; the first call of a round tells how many came for nothing."""
        now = self._now()
        self._first = self._first or (done, now)
        self._last = (done, total, now)

    def end_simulation(self) -> None:
        """All frames are there."""
        self._simulated = self._now()
        rate = self._measure_rate()
        if rate is not None and self._last is not None:
            self._simulating = rate * self._last[1]

    def show_clip(self) -> None:
        """The round's clip is there."""
        self._shown = True
        if self._simulated is not None:
            self._clip = self._now() - self._simulated

    def end_round(self) -> None:
        """The round is judged."""
        if self._simulated is not None:
            self._rest = self._now() - self._simulated

    def find_left(self) -> tuple[float, float]:
        """Seconds until this round's clip, and until the run's end if it makes all its rounds [s]."""
        now = self._now()
        if self._simulated is None:
            frames = self._find_frames_left(now)
            clip, rest = frames + self._clip, frames + self._rest
        else:
            since = now - self._simulated
            clip, rest = max(self._clip - since, 0.0), max(self._rest - since, 0.0)
        later = self._rounds - self._index - 1
        run = rest + later * (self._simulating + self._rest) + CLOSING
        return 0.0 if self._shown else clip, run

    def _find_frames_left(self, now: float) -> float:
        """Seconds until the last frame of this round is simulated [s]."""
        rate = self._measure_rate()
        if rate is None or self._last is None:
            return max(self._simulating - (now - self._begun), 0.0)
        done, total, at = self._last
        return max(rate * (total - done) - (now - at), 0.0)

    def _measure_rate(self) -> float | None:
        """Seconds that a frame of this round takes [s]; None if there are too few."""
        if self._first is None or self._last is None or self._last[0] == self._first[0]:
            return None
        return (self._last[2] - self._first[1]) / (self._last[0] - self._first[0])
