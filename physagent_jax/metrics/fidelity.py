"""Physical fidelity of a recording: faults that no body shows, whatever was asked of it, from its particles' paths.

Clauses ask whether a clip shows what a sentence says. These terms ask whether a body could have moved so. A recording
may be of any simulator, or of points that a tracker followed. Each term has a bar that simulations stay below
(`BARS`), and a score of 1 up to it, above it the bar over the value. The bars are a multiple of what simulations of
the benchmark's tasks show (`benchmarks.headtohead --parts fidelity`), and hold for solids that stay in one piece.

- *noise*: what particles do from frame to frame that their neighbours do not, as the deviation of white noise;
- *sinking*: depth below the surface of a solid, deeper than at rest and than noise alone would reach;
- *slip*: the way of what is held;
- *jump*: the way that a tenth of the body goes astray within one or two frames, and not before or after;
- *flight*: velocity of the mass centre in the air that what acts does not give;
- *energy*: kinetic energy that what acts has not given, as a share of what has gone in and out;
- *pieces*: share of the particles that left the piece that they belonged to.

Energy and flight need to know what acts, and slip what is held: without, they are not rated.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np
from scipy.ndimage import grey_opening
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError

BARS: Mapping[str, float] = {
    "noise": 0.002,
    "sinking": 0.06,
    "slip": 0.01,
    "jump": 0.015,
    "flight": 0.05,
    "energy": 0.05,
    "pieces": 0.01,
}
"""Largest values that are clean."""
UNITS: Mapping[str, str] = dict.fromkeys(BARS, "L") | {"flight": "L/s", "energy": "", "pieces": ""}
"""Units of the values; L is the body length, the longest side of the rest particles' box. Others are shares."""
GROUPS = 64
"""Groups of neighbours whose means are looked at where noise must not matter."""
NEIGHBOURS, LEAST = 12, 24
"""Neighbours of a particle that are looked at, and the fewest particles of a recording."""
TORN = 3.0
"""Distance of neighbours that hold together no longer, over that at rest."""
SOME, NOISY = 0.1, 4.0
"""Share of the groups that has to jump, and the way that it goes by noise alone [deviations of a group's mean]."""
LOWEST, DEVIATIONS = 0.02, 2.05
"""Quantile of the distances that counts as the lowest point, and its place in white noise [deviations]."""
STEADY, ORDER = 5, 0.05
"""Frames in which a velocity in flight has to be too much, and what steps of first order, ten a frame, are late by."""
ALOFT, SLOW = 0.05, 0.1
"""Distance from all solids from which on nothing touches [body lengths], and the speed whose energy is the least that
counts as having gone in [body lengths/s]."""


@dataclasses.dataclass(frozen=True)
class Surroundings:
    """Facts about the scene of a recording.

    Attributes:
        solids: Signed distances [m] of places (..., 3) from the surface of each solid, negative inside; shape (...).
        held: Particles that are held where they are, shape (n,), bool; None = none.
        acceleration: All that acts but solids and holds, gravity too [m/s^2], in the time from each frame to the next,
            broadcast to (T - 1, n, 3); None = not known.
        resting: Whether nothing moves in frame 0.
        driven: Whether something leads a part along: its way is no fault, and it gives speed and energy.
    """

    solids: tuple[Callable[[np.ndarray], np.ndarray], ...] = ()
    held: np.ndarray | None = None
    acceleration: np.ndarray | None = None
    resting: bool = False
    driven: bool = False


@dataclasses.dataclass(frozen=True)
class Fidelity:
    """Values of the terms; None = not rated, for lack of knowledge or because it never applied.

    Attributes:
        noise, sinking, slip, jump: [body lengths].
        flight: [body lengths/s].
        energy, pieces: Shares.
    """

    noise: float
    sinking: float | None
    slip: float | None
    jump: float
    flight: float | None
    energy: float | None
    pieces: float

    @property
    def scores(self) -> dict[str, float]:
        """From 0 to 1 for each term that is rated; 1 = clean."""
        rated = {name: value for name in BARS if (value := getattr(self, name)) is not None}
        return {name: BARS[name] / max(value, BARS[name]) for name, value in rated.items()}

    @property
    def score(self) -> float:
        """The least of the scores."""
        return min(self.scores.values())

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the terms that are not clean."""
        return tuple(name for name, score in self.scores.items() if score < 1)


def rate_fidelity(
    x: np.ndarray, mass: np.ndarray, frame_dt: float, around: Surroundings = Surroundings()
) -> Fidelity:
    """Rate a recording.

    Args:
        x: Particle positions [m], shape (T, n, 3), T >= 4; frame 0 is taken for a pose without fault.
        mass: [kg], shape (n,).
        frame_dt: Seconds per frame [s].
        around: What stands there, holds and acts.

    Raises:
        UserError: A shape does not fit, or there are too few frames or particles.
    """
    x = np.asarray(x, np.float64)
    if x.ndim != 3 or x.shape[-1] != 3 or x.shape[0] < 4 or x.shape[1] < LEAST:
        wanted = f"(frames, particles, 3), with 4 frames and {LEAST} particles or more"
        raise UserError(f"a recording must have the shape {wanted}", got=x.shape)
    if np.shape(mass) != x.shape[1:2]:
        raise UserError("`mass` must have one number for each particle", got=np.shape(mass))
    if not np.isfinite(x).all():
        return Fidelity(np.inf, None, None, np.inf, None, None, np.inf)
    size = max(float(np.ptp(x[0], axis=0).max()), 1e-9)
    weight = np.asarray(mass, np.float64) / np.sum(mass)
    noise = _measure_noise(x) / size
    return Fidelity(
        noise=noise,
        sinking=_measure_sinking(x, around, noise * size, size),
        slip=_measure_slip(x, around, size),
        jump=_measure_jump(x, noise * size) / size,
        flight=_measure_flight(x, weight, frame_dt, around, size),
        energy=_measure_energy(x, weight, frame_dt, around, noise * size, size),
        pieces=_measure_pieces(x),
    )


def _split(rest: np.ndarray) -> list[np.ndarray]:
    """Indices of groups of neighbours of about the same size: halves across the longest side, again and again."""
    groups = [np.arange(len(rest))]
    while len(groups) < GROUPS and len(groups[0]) > NEIGHBOURS:
        halves = []
        for group in groups:
            order = group[np.argsort(rest[group, np.ptp(rest[group], axis=0).argmax()], kind="stable")]
            halves += [order[: len(order) // 2], order[len(order) // 2 :]]
        groups = halves
    return groups


def _average(x: np.ndarray, groups: list[np.ndarray]) -> np.ndarray:
    """Means of (T, n, 3) over groups, shape (groups, T, 3)."""
    return np.stack([x[:, group].mean(1) for group in groups])


def _measure_noise(x: np.ndarray) -> float:
    """The deviation of white noise that would part neighbours as much from frame to frame [m].

    Second differences in time, less those that the neighbours' best affine map tells. Half of the particles, in half of
    the frames, have to be as noisy: what a blow or a crumb does is not.
    """
    near = np.asarray(KDTree(x[0]).query(x[0], k=NEIGHBOURS + 1)[1])[:, 1:]
    offsets = x[0][near] - x[0][:, None]
    affine = np.concatenate([np.ones((*near.shape, 1)), offsets], axis=-1)
    tell = np.linalg.pinv(affine, rcond=1e-3)[
        :, 0
    ]  # shares of the neighbours in the map's value at the particle
    bends = x[2:] - 2 * x[1:-1] + x[:-2]
    apart = bends - np.einsum("nk,tnki->tni", tell, bends[:, near])
    deviations = np.linalg.norm(apart, axis=-1) / np.sqrt(6 * (1 + (tell**2).sum(-1)))
    return float(np.median(np.median(deviations, axis=1))) / 1.5382  # that of the lengths of normal triples


def _find_distances(x: np.ndarray, around: Surroundings) -> np.ndarray:
    """Distance of each particle from the nearest surface [m], shape (T, n)."""
    return np.min([solid(x) for solid in around.solids], axis=0)


def _measure_sinking(x: np.ndarray, around: Surroundings, noise: float, size: float) -> float | None:
    if not around.solids:
        return None
    low = np.quantile(_find_distances(x, around), LOWEST, axis=1)
    depth = min(low[0], 0.0) - low - DEVIATIONS * noise
    return max(0.0, float(depth.max())) / size


def _measure_slip(x: np.ndarray, around: Surroundings, size: float) -> float | None:
    if around.held is None or around.driven or not np.any(around.held):
        return None
    held = x[:, np.asarray(around.held, bool)]
    return float(np.linalg.norm(np.median(held - held[0], axis=1), axis=-1).max()) / size


def _measure_jump(x: np.ndarray, noise: float) -> float:
    """The way that a tenth of the groups goes astray in one frame, or out and back in two, beyond that of noise [m].

    Astray in one frame is what lies beside the mean of the ways before and after, beyond twice the difference of these:
    a blow or a bounce, after which all goes on otherwise, is none. In two it is what goes beyond twice the ways around:
    what swings fast is none. Before the first frame nothing is taken to move.
    """
    groups = _split(x[0])
    ways = np.pad(np.diff(_average(x, groups), axis=1), ((0, 0), (1, 0), (0, 0)))
    before, own, after = ways[:, :-2], ways[:, 1:-1], ways[:, 2:]
    once = np.linalg.norm(own - 0.5 * (before + after), axis=-1) - 2 * np.linalg.norm(after - before, axis=-1)
    lengths = np.linalg.norm(ways, axis=-1)
    around = np.maximum(lengths[:, :-3], lengths[:, 3:])
    twice = np.minimum(lengths[:, 1:-2], lengths[:, 2:-1]) - 2 * around
    most = max(float(np.quantile(each, 1 - SOME, axis=0).max()) for each in (once, twice))
    return float(max(0.0, most - NOISY * noise / np.sqrt(x.shape[1] / len(groups))))


def _measure_flight(
    x: np.ndarray, weight: np.ndarray, dt: float, around: Surroundings, size: float
) -> float | None:
    """Velocity that nothing gave, as the median of `STEADY` frames: a jump, or a blow between frames, is none."""
    if around.acceleration is None or around.driven or (around.held is not None and np.any(around.held)):
        return None
    acts, x = _begin(around, x)
    free = np.full(len(x), True)
    if around.solids:
        low = _find_distances(x, around).min(1)
        steps = np.abs(np.diff(low, prepend=low[0], append=low[-1]))
        free = low - np.maximum(steps[1:], steps[:-1]) > ALOFT * size  # nor does it touch between two frames
    centre = np.einsum("tni,n->ti", x, weight)
    acts = np.einsum("tni,n->ti", acts, weight)
    gained = (centre[2:] - 2 * centre[1:-1] + centre[:-2]) / dt - 0.5 * dt * (acts[1:] + acts[:-1])
    allowed = ORDER * dt * np.linalg.norm(acts, axis=-1).max()
    aloft = free[2:] & free[1:-1] & free[:-2]
    worst, flight = None, []
    for one, good in zip(gained, aloft):
        flight = [*flight, one] if good else []
        if len(flight) >= STEADY:
            steady = np.linalg.norm(np.median(np.cumsum(flight, axis=0)[-STEADY:], axis=0))
            worst = max(worst or 0.0, float(steady - allowed) / size)
    return worst


def _begin(around: Surroundings, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations between frames, and the frames; before what rests in frame 0, one more in which nothing acts."""
    acts = np.broadcast_to(np.asarray(around.acceleration, np.float64), (len(x) - 1, *x.shape[1:]))
    begun = np.concatenate([np.zeros_like(acts[:1]), acts]), np.concatenate([x[:1], x])
    return begun if around.resting else (acts, x)


def _measure_energy(
    x: np.ndarray, weight: np.ndarray, dt: float, around: Surroundings, noise: float, size: float
) -> float | None:
    """Kinetic energy of groups' means, at most that of the particles, against the work since frame 0.

    What stores energy, or loses it, only lowers the kinetic one, and that of noise is taken off. Speeds of one or two
    frames alone are cut: they are jumps.
    """
    if around.acceleration is None or around.driven:
        return None
    groups = _split(x[0])
    acts, x = _begin(around, x)
    share = np.array([weight[group].sum() for group in groups])
    speeds = np.linalg.norm(np.diff(_average(x, groups), axis=1), axis=-1) / dt
    kinetic = 0.5 * np.einsum("g,gt->t", share, grey_opening(speeds, (1, 3), mode="nearest") ** 2)
    first = 0.5 * float(share @ speeds[:, 0] ** 2)
    ways = np.diff(x, axis=0)
    work = 0.25 * np.einsum("tni,tni,n->t", acts[1:] + acts[:-1], ways[1:] + ways[:-1], weight)
    spent = np.concatenate([[0.0], np.cumsum(work)])
    turnover = first + np.abs(work).sum() + 0.5 * (SLOW * size) ** 2
    pull = np.linalg.norm(np.einsum("tni,n->ti", acts, weight), axis=-1).max()
    of_noise = 3 * noise**2 / (x.shape[1] / len(groups) * dt**2) + 3 * pull * noise / np.sqrt(x.shape[1])
    return max(0.0, float((kinetic - first - spent).max() - of_noise) / turnover)


def _measure_pieces(x: np.ndarray) -> float:
    """Share of the particles that the largest parts of the first frame's pieces have lost, in the worst frame.

    Neighbours hold together until they are `TORN` times as far apart as at rest, or as is usual.
    """
    length, near = map(np.asarray, KDTree(x[0]).query(x[0], k=NEIGHBOURS + 1))
    one, other = np.repeat(np.arange(len(near)), NEIGHBOURS), near[:, 1:].ravel()
    reach = TORN * np.maximum(length[:, 1:].ravel(), np.median(length[:, 1]))

    def label(frame: np.ndarray) -> np.ndarray:
        kept = np.linalg.norm(frame[one] - frame[other], axis=-1) <= reach
        links = coo_array((np.ones(kept.sum(), bool), (one[kept], other[kept])), shape=(len(near),) * 2)
        return connected_components(links, directed=False)[1]

    rest = label(x[0])
    pieces = [np.flatnonzero(rest == piece) for piece in range(rest.max() + 1)]
    kept = [sum(np.bincount(now[piece]).max() for piece in pieces) for now in map(label, x[1:])]
    return 1.0 - float(min(kept)) / len(near)
