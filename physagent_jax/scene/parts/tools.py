"""The blade and the handle of a tool, by the surfaces that it is built of: a sword, a knife, an axe, a pizza cutter.

A tool is long, and its surfaces lie one after the other along it: those at one end are the handle, and the thinner
ones at the other end are the blade. A guard, which is broad and short, goes with the handle. A blade that is a disc is
all that turns with it, and what goes along the whole tool is the shaft of a blade that sits across its end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_MOST = 20  # surfaces
_LONG = 1.6  # length over breadth, at least
_SLIM = 0.36  # breadth over the tool's length of what is no disc, at most
_LEAST = 0.12  # of the length that a handle and a blade have, at least
_OVERLAP = 0.15  # of the length that both may share
_ALIKE = 0.15  # of the longer one's length, by which two ends alike differ
_GUARD = 0.9  # breadth over the broadest, from which on what is shorter than broad is a guard
_DISC = 0.25  # breadth of a disc over the tool's length, at least
_FLAT, _ROUND = (
    0.3,
    0.9,
)  # its thickness over its breadth, at most; its lesser over its larger spread, at least
_SWEPT, _THICK = 1.06, 4.0  # of a disc's radius and of its thickness, within which what turns with it lies
_SHAFT = 0.75  # of the length, from which on what is slim is a shaft
_HEAD = 0.1  # share of the object that a blade on a shaft has at least


class Tool(NamedTuple):
    """The particles of a tool's blade and of its handle, shape (n,) each, and whether the blade is a disc."""

    blade: np.ndarray
    handle: np.ndarray
    turns: bool = False


def find_tool(points: np.ndarray, labels: np.ndarray) -> Tool | None:
    """The blade and the handle of a tool; None if it is none, or does not show them.

    Args:
        points: Particles at rest [m], shape (n, 3).
        labels: The surface that each belongs to, from 0, shape (n,).
    """
    axes = np.linalg.eigh(np.cov(points.T))[1][:, ::-1]
    own = points @ axes
    low, size = own.min(0), np.ptp(own, axis=0)
    if not 0 < labels.max() < _MOST or size[0] < _LONG * size[1]:
        return None
    own = (own - low) / size[0]
    masks = [labels == k for k in range(labels.max() + 1)]
    ends = np.array([(own[mask].min(0), own[mask].max(0)) for mask in masks])
    return _find_disc(own, labels, masks) or _find_shaft(own, masks, ends) or _find_split(own, labels, ends)


def _find_disc(own: np.ndarray, labels: np.ndarray, masks: list[np.ndarray]) -> Tool | None:
    """The broadest disc at one end with all that lies within it, and what is left."""
    best = None
    for mask in masks:
        place = own[mask]
        spread, axes = np.linalg.eigh(np.cov(place.T)) if len(place) > 3 else (np.ones(3), np.eye(3))
        across = (place - place.mean(0)) @ axes
        breadth, off = float(np.ptp(across, axis=0)[1:].min()), abs(float(place[:, 0].mean()) - 0.5)
        round_ = spread[0] < _FLAT**2 * spread[1] and spread[1] > _ROUND**2 * spread[2]
        if round_ and breadth > max(_DISC, best[0] if best else 0.0) and off > 0.5 * breadth - 0.3:
            best = breadth, mask, axes
    if best is None:
        return None
    breadth, mask, axes = best
    off = (own - 0.5 * (own[mask].min(0) + own[mask].max(0))) @ axes
    near = np.hypot(off[:, 1], off[:, 2]) < _SWEPT * 0.5 * breadth
    near &= np.abs(off[:, 0]) < _THICK * float(np.abs(off[mask, 0]).max())
    inside = np.bincount(labels, near) > 0.95 * np.bincount(labels)
    blade = mask | inside[labels]
    return Tool(blade, ~blade, turns=True)


def _find_shaft(own: np.ndarray, masks: list[np.ndarray], ends: np.ndarray) -> Tool | None:
    """The broadest piece beside a slim one that goes along all of the tool, and what is left."""
    long = np.flatnonzero(np.ptp(ends, axis=1)[:, 0] > _SHAFT)
    heads = [k for k, mask in enumerate(masks) if k not in long and mask.mean() > _HEAD]
    if len(long) != 1 or not heads:
        return None
    head = max(heads, key=lambda k: float(np.ptp(ends[k], axis=0)[1]))
    shaft = masks[int(long[0])]
    apart = abs(float(own[masks[head], 1].mean() - own[shaft, 1].mean()))
    return Tool(masks[head], ~masks[head]) if apart > float(own[shaft, 1].std()) else None


def _find_split(own: np.ndarray, labels: np.ndarray, ends: np.ndarray) -> Tool | None:
    """The thinner and the thicker end of what is built of pieces one after the other."""
    sides = np.ptp(ends, axis=1)
    broad = sides[:, 1:].max(1)
    guards = {*np.flatnonzero((broad > sides[:, 0]) & (broad > _GUARD * broad.max()))}
    order = np.argsort(ends.mean(1)[:, 0])
    found = []
    for count in range(1, len(order)):
        first, second = order[:count], order[count:]
        reach, start = float(ends[first, 1, 0].max()), float(ends[second, 0, 0].min())
        longer = first if reach > 1 - start else second
        lengths = reach, 1 - start
        if min(lengths) > _LEAST and not guards & {*longer} and reach - start < _OVERLAP:
            found.append((reach - start, first))
    outer = sides[order[[0, -1]]]
    # A rolling pin has a handle at either end.
    twins = np.abs(outer[0] - outer[1]).max() < _ALIKE * outer.max()
    if not found or twins or broad.max() > _SLIM:
        return None
    lower = np.isin(labels, min(found, key=lambda each: each[0])[1])
    thick = [np.linalg.eigvalsh(np.cov(own[mask, 1:].T))[0] for mask in (lower, ~lower)]
    return Tool(lower, ~lower) if thick[0] < thick[1] else Tool(~lower, lower)
