"""The object's ends followed by themselves: what bends, twists or swings only at one end shows here.

An end is the third of the surface seen in frame 0 that lies farthest along a world axis. Its points are fitted apart
from the rest's, link by link as the whole object's are (`follow`): a link's new points belong to the end whose earlier
points lie beside them. Where parts are asked for, ends are those of the rest: else a large shade on a slim pole would
be its own other end.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.rotations import polar, unwrap
from physagent_jax.perception.fit import Affine, fit_affine, to_matrix
from physagent_jax.perception.schema import Extent, PartMotion

DIRECTIONS = np.concatenate([s * np.eye(3)[[k]] for k in range(3) for s in (1, -1)])
"""World axes, one per end, shape (6, 3)."""
SHARE = 1 / 3
"""Share of the surface seen in frame 0 that makes an end."""
KEPT_PART = 0.5
"""Share of a part's points below which new ones are seeded: a limb turns far while the whole hardly moves."""
FEWEST = 9
"""Pairs of points below which an end's motion is not fitted."""


@dataclasses.dataclass(frozen=True)
class PartPrompt:
    """The place of a part in frame 0, as a click or a mask tells it.

    Attributes:
        limb: Number of the part.
        inside, outside: Points in the world on the part, and on the rest of the object [m], shape (k, 3), (m, 3).
    """

    limb: int
    inside: np.ndarray
    outside: np.ndarray

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Return which points lie nearer to the part than to the rest, shape (n,)."""
        nearest = np.asarray(KDTree(np.concatenate([self.inside, self.outside])).query(points)[1])
        return nearest < len(self.inside)


@dataclasses.dataclass
class Ends:
    """The poses of the six ends of the rest, and of parts that are asked for.

    Attributes:
        prompts: The parts.
        centers: Mean of each end's surface in frame 0 [m], shape (6 + p, 3).
        limits: Least coordinate along its direction that belongs to an end [m], shape (6,).
        poses: Per frame and end, the map from frame 0; None where unknown.
    """

    prompts: tuple[PartPrompt, ...]
    centers: np.ndarray
    limits: np.ndarray
    poses: list[list[Affine | None]]
    _base: list[Affine | None] = dataclasses.field(default_factory=list)
    _belongs: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 0), bool))
    _last: tuple[np.ndarray, np.ndarray] | None = None

    @classmethod
    def split(cls, surface: np.ndarray, frame_count: int, prompts: tuple[PartPrompt, ...] = ()) -> Ends:
        """The ends of a surface.

        Args:
            surface: World points seen in frame 0 [m], shape (n, 3), n >= 1.
            frame_count: How many frames will be followed.
            prompts: Parts to follow as well; those that are not seen are left out.
        """
        along = surface @ DIRECTIONS.T
        prompts = tuple(each for each in prompts if each.holds(surface).any())
        held = [each.holds(surface) for each in prompts]
        rest = ~np.any([np.zeros(len(surface), bool), *held], axis=0)
        rest |= rest.sum() < FEWEST  # the parts are all that is seen
        limits = np.quantile(along[rest], 1 - SHARE, axis=0)
        seen = [*((along >= limits).T & rest), *held]
        centers = np.stack([surface[one].mean(0) for one in seen])
        return cls(prompts, centers, limits, [[None] * len(seen) for _ in range(frame_count)])

    def start_link(self, frame: int, points: np.ndarray) -> None:
        """Says which ends new points belong to.

        Args:
            frame: Where they were seeded.
            points: World positions [m], nan where unknown, shape (N, 3).
        """
        if frame == 0:
            self.poses[0] = [Affine.identity()] * len(self.centers)
        self._base, self._belongs = list(self.poses[frame]), self._divide(frame, points)

    def find_parts(self, frame: int, points: np.ndarray) -> np.ndarray:
        """Return which points on the surface of a frame belong to each of the parts, shape (n, p)."""
        return self._divide(frame, points)[:, len(DIRECTIONS) :]

    def _divide(self, frame: int, points: np.ndarray) -> np.ndarray:
        """Return which points belong to each end and part, shape (n, 6 + p)."""
        known = np.isfinite(points[:, 0])
        belongs = np.zeros((len(points), len(self.centers)), bool)
        if frame == 0:
            for k, prompt in enumerate(self.prompts, len(DIRECTIONS)):
                belongs[known, k] = prompt.holds(points[known])
            rest = ~belongs[known].any(1)
            rest |= rest.sum() < FEWEST
            ends = points[known] @ DIRECTIONS.T >= self.limits
            belongs[known, : len(DIRECTIONS)] = ends & rest[:, None]
        elif self._last is not None and known.any():
            places, whose = self._last
            belongs[known] = whose[KDTree(places).query(points[known])[1]]
        return belongs

    def fit(
        self, frame: int, before: np.ndarray, after: np.ndarray, trust: np.ndarray, pairs: np.ndarray
    ) -> None:
        """Fit each end's motion since the link's start.

        Args:
            frame: The frame of ``after``.
            before: Positions at the link's start [m], shape (n, 3).
            after: Positions now [m], shape (n, 3).
            trust: Weights, shape (n,).
            pairs: Which of the link's points these are, bool, shape (N,).
        """
        belongs = self._belongs[pairs]
        for k, base in enumerate(self._base):
            own = belongs[:, k]
            if base is None or own.sum() < FEWEST:
                continue
            step = fit_affine(before[own], after[own], trust[own], prior=0.05, iterations=4)
            self.poses[frame][k] = step.after(base)
        self._last = after, belongs

    def bring_home(self, frame: int, part: int, least: float) -> None:
        """Put a part back to where it was at first, if it is taken to be farther off than ``least`` [m], or is lost."""
        k = len(DIRECTIONS) + part
        pose, center = self.poses[frame][k], self.centers[k]
        if pose is None or np.linalg.norm(pose(center) - center) > least:
            self.poses[frame][k] = Affine.identity()

    def loses_part(self, pairs: np.ndarray) -> bool:
        """Return whether a part has lost half of the link's points that lie on it, and enough are left to go on from.

        Args:
            pairs: Which of the link's points are left, bool, shape (N,).
        """
        had, left = self._count(pairs)
        return bool(((left < KEPT_PART * had) & (left >= FEWEST)).any())

    def drops_part(self, frame: int, pairs: np.ndarray) -> bool:
        """Return whether too few points are left of a part that was fitted in an earlier frame.

        Args:
            frame: That frame.
            pairs: Which of the link's points are left, bool, shape (N,).
        """
        had, left = self._count(pairs)
        fitted = np.array([pose is not None for pose in self.poses[frame][len(DIRECTIONS) :]], bool)
        return bool((fitted & (had >= FEWEST) & (left < FEWEST)).any())

    def _count(self, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the link on each part that is known, and how many of them are left, shape (p,)."""
        known = [pose is not None for pose in self._base]
        had, left = (np.where(known, each.sum(0), 0) for each in (self._belongs, self._belongs[pairs]))
        return had[len(DIRECTIONS) :], left[len(DIRECTIONS) :]

    def lose(self) -> None:
        """Forget which point belongs to which end: what is seeded later has no earlier neighbours."""
        self._last = None

    def describe(
        self, size: float, breadths: Sequence[tuple[Extent, ...]] = ((),) * len(DIRECTIONS)
    ) -> tuple[PartMotion, ...]:
        """Motion of each end and part, for the report.

        Args:
            size: The body length [m].
            breadths: How broad the outline of each of the six ends is; by default, not measured.
        """
        told = [*breadths, *[()] * len(self.prompts)]
        return tuple(self._describe(k, size, told[k]) for k in range(len(self.centers)))

    def _describe(self, k: int, size: float, breadths: tuple[Extent, ...]) -> PartMotion:
        poses = [frame[k] for frame in self.poses]
        turns = unwrap([None if p is None else p.rotation for p in poses])
        center, prompt = self.centers[k], self.prompts[k - len(DIRECTIONS)] if k >= len(DIRECTIONS) else None
        away = center - self.centers[: len(DIRECTIONS)].mean(0)
        direction = DIRECTIONS[k] if prompt is None else away / max(float(np.linalg.norm(away)), 1e-12)
        return PartMotion(
            direction=tuple(direction.tolist()),
            limb=None if prompt is None else prompt.limb,
            place=tuple((away / size).tolist()),
            extents=breadths,
            centroid=tuple(
                None if p is None else tuple(((p(center) - center) / size).tolist()) for p in poses
            ),
            rotation=tuple(None if v is None else tuple(np.degrees(v).tolist()) for v in turns),
            stretch=tuple(None if p is None else to_matrix(polar(p.matrix)[1]) for p in poses),
        )
