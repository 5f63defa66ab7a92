"""The looks of a part among the rest: how high, how far out, how slim, how green it is, as measures from 0 to 1."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from physagent_jax.scene.parts.coloured import HUES, find_hue

_LARGE = 0.08  # share of the object from which on a part is large
_GROUND = 0.2  # of the height, from which on a part's lowest place is off the ground
_SIDES = np.array([(1.0, 0, 0), (-1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0)])
_SEEN = 0.2  # cosine to the viewer of a side that is seen
_COLUMNS = 24  # along the longest side, from above
_MOSTLY = 0.5  # share of a part in a hue, from which on it has that
_TELLING = 0.02, 0.97  # shares of the object in a hue, between which it tells parts apart


@dataclasses.dataclass(frozen=True)
class Looks:
    """An object in which the looks of parts are measured.

    Attributes:
        points: Particles [m], shape (n, 3).
        whole: Those among which parts are compared, shape (n,).
        front: The level way in which it looks, shape (3,); None = not told.
        toward: The way to the viewer, shape (3,).
        colours: Colours of the particles, 0 .. 1, shape (n, 3); None = not known.
    """

    points: np.ndarray
    whole: np.ndarray
    front: np.ndarray | None
    toward: np.ndarray
    colours: np.ndarray | None = None

    def knows(self, row: dict[str, Any]) -> bool:
        """Return whether what a row weighs most can be measured: without a front, nothing is ahead."""
        most = max(value for key, value in row.items() if isinstance(value, int))
        return self.front is not None or most not in (row.get("ahead"), row.get("behind"))

    def score(
        self, masks: Sequence[np.ndarray], row: dict[str, Any], *, coloured: bool = True
    ) -> list[float]:
        """The mean of the measures of each part by their weights, 0 .. 1; those that are not known do not count.

        Args:
            masks: The particles of each, shape (n,).
            row: The weights by the names of the measures.
            coloured: Whether their colours count: a limb's border is not one of colours, as a shell's is.
        """
        known = [self.measure(mask) for mask in masks]
        hues = {hue for hue in HUES if coloured and any(each.get(hue, 0.0) > _MOSTLY for each in known)}
        names = [key for key in row if key not in HUES or key in hues]
        told = [{key: row[key] for key in names if key in each} for each in known]
        return [
            sum(weights[key] * each[key] for key in weights) / max(sum(weights.values()), 1e-9)
            for weights, each in zip(told, known)
        ]

    def measure(self, mask: np.ndarray) -> dict[str, float]:
        """The measures of a part, by their names in `guesses.yaml`."""
        own, whole = self.points[mask], self.points[self.whole]
        middle, centre, low = whole.mean(0), own.mean(0), whole[:, 2].min()
        reach = np.linalg.norm((whole - middle)[:, :2], axis=1).max()
        variance, axes = np.linalg.eigh(np.cov(own.T))
        spread = np.sqrt(variance.clip(1e-18))
        height = max(float(np.ptp(whole[:, 2])), 1e-12)
        large = min(float(mask.sum() / self.whole.sum()) / _LARGE, 1.0)
        flat, slim = 1 - spread[0] / spread[1], 1 - spread[1] / spread[2]
        told = dict(
            high=(own[:, 2].max() - low) / height,
            raised=(np.percentile(own[:, 2], 10) - low) / height,
            low=1 - (centre[2] - low) / height,
            away=np.linalg.norm((own - middle)[:, :2], axis=1).max() / reach,
            aside=np.linalg.norm((centre - middle)[:2]) / reach,
            centred=1 - np.linalg.norm((centre - middle)[:2]) / reach,
            slim=slim,
            flat=flat,
            disc=flat * (1 - slim),
            round=max(1 - slim, 1 - flat),
            stout=1 - slim,
            level=flat * abs(axes[2, 0]),
            upright=flat * np.hypot(*axes[:2, 0]),
            large=large,
            small=1 - large,
            long=np.ptp(own, axis=0).max() / np.ptp(whole, axis=0).max(),
            open=1 - self._measure_covered(mask, 1),
            hung=1 - self._measure_covered(mask, -1),
            grounded=1 - (own[:, 2].min() - low) / (_GROUND * height),
            toward=max(self._measure_outside(own, way) for way in _SIDES if way @ self.toward > _SEEN),
            rear=self._measure_outside(own, -self.toward),
        )
        if self.front is not None:
            along = float((centre - middle) @ self.front / np.abs((whole - middle) @ self.front).max())
            told |= dict(ahead=max(along, 0.0), behind=max(-along, 0.0))
        told |= {hue: has[mask].mean() for hue, has in self._hues.items()}
        return {key: float(np.clip(value, 0.0, 1.0)) for key, value in told.items()}

    @functools.cached_property
    def _hues(self) -> dict[str, np.ndarray]:
        """The particles of each hue that a part of the object has and another has not, shape (n,) each."""
        if self.colours is None:
            return {}
        found = {key: find_hue(self.colours, key) for key in HUES}
        low, high = _TELLING
        return {key: has for key, has in found.items() if low < has[self.whole].mean() < high}

    @functools.cached_property
    def _columns(self) -> tuple[np.ndarray, dict[int, np.ndarray], float]:
        """The column of each particle, shape (n, 2), each column's top and bottom [m], and the side of one [m]."""
        low = self.points.min(0)
        side = max(float(np.ptp(self.points, axis=0).max()), 1e-12) / _COLUMNS
        column = ((self.points[:, :2] - low[:2]) / side).astype(int)
        return column, {sign: _find_tops(column, sign * self.points[:, 2]) for sign in (1, -1)}, side

    def _measure_covered(self, mask: np.ndarray, sign: int) -> float:
        """The share of a part's columns in which something else is above it (``sign`` 1), or below it (-1)."""
        column, ends, side = self._columns
        mine = np.full(ends[sign].shape, -np.inf)
        np.maximum.at(mine, tuple(column[mask].T), sign * self.points[mask, 2])
        here = np.isfinite(mine)
        return float((ends[sign][here] > mine[here] + 0.5 * side).mean())

    def _measure_outside(self, own: np.ndarray, way: np.ndarray) -> float:
        """The place of a part's middle that way, from the object's middle (0) to its farthest end (1)."""
        along = self.points @ way
        low, high = np.quantile(along, (0.01, 0.99))
        return 2 * float(own.mean(0) @ way - low) / max(float(high - low), 1e-12) - 1


def _find_tops(column: np.ndarray, height: np.ndarray) -> np.ndarray:
    tops = np.full(column.max(0) + 1, -np.inf)
    np.maximum.at(tops, tuple(column.T), height)
    return tops
