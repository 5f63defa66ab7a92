"""The ends and sections of an object: where it is told apart by how broad it is along its axis, not by what sticks out.

A shoe has its toe where it is low, a blade its tip where it is thin, a boat its bow where it is pointed. What is
broad at one end and slim elsewhere has a handle, a stem or a neck. Where the shape does not tell such a difference,
nothing is named.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.forces.part import PartRole
from physagent_jax.scene.parts.lattice import Lattice, find_pieces

Found = tuple[np.ndarray, tuple[PartRole, ...]]
"""Nodes of a part, shape (k,), and its roles."""

_BINS = 40  # along an axis
_LONG = 1.7  # spread along the axis over the next largest, from which on an object is long
_CONTRAST = 1.6  # breadth of the broad over the slim, at least
_LEVEL = 0.35  # of the way from slim to broad, from which on a slice is broad
_THIN = 0.4  # breadth of the slim over the length along the axis, at most
_SLIM = 0.25  # of the length, of the longest slim section, at least
_ROUND = 2  # slices at an end that may be slim where it is broad
_GUARD = 0.12  # of the length: a broad section that is shorter parts two slim ones
_END = 0.25  # of the length: an end
_FLARED = 1.3  # breadth of an end over the least behind it, from which on it has fins
_EVEN = 1.15  # the same of an end without
_POINTED = 1.3  # breadth of one end over the other's, from which on that is the point
_LOW = 0.65  # height of a toe over that of the heel's end, at most
_SOLE = (0.06, 0.75)  # of the height that is a sole; of the length that it is long, at least
_FLAT = 0.2  # height over length of a shoe, at least
_HEEL = 0.35  # of the height
_UPRIGHT = 0.8  # cosine
_BODY = frozenset(("leg", "handle", "spout", "ear", "horn", "thumb", "finger"))
"""Roles of objects whose parts stick out: their shape along an axis tells nothing more."""

_FIGURE = frozenset(("head", "arm", "wing"))
"""Roles of objects that are told apart by their limbs rather than by how broad they are."""


@dataclasses.dataclass(frozen=True)
class _Profile:
    """The breadth of an object along an axis.

    Attributes:
        along: Place of each node along it, from 0 to 1, shape (n,).
        breadth: Larger side of the box of each slice across the axis [m], shape (bins,).
        length: Extent along the axis [m].
    """

    along: np.ndarray
    breadth: np.ndarray
    length: float

    def pick(self, low: float, high: float) -> np.ndarray:
        """The nodes between two places, shape (k,)."""
        return np.flatnonzero((self.along >= low) & (self.along <= high))


def find_ends(lattice: Lattice, known: frozenset[str]) -> list[Found]:
    """The ends and sections of an upright object.

    Args:
        lattice: Its solid.
        known: Roles of what sticks out of it.
    """
    if known & _BODY:
        return []
    places = lattice.places - lattice.places.mean(0)
    spread, axes = np.linalg.eigh(np.cov(places.T))
    long, up = axes[:, 2] * np.sign(axes[2, 2] or 1.0), np.array([0.0, 0.0, 1.0])
    plain = not known & _FIGURE
    found = _find_toe(places, lattice.spacing) if plain and "top" not in known else []
    lies = bool(spread[2] > _LONG**2 * spread[1] and long[2] < _UPRIGHT)
    if lies and not found:
        profile = _measure(places, long, lattice.spacing)
        found = [] if "head" in known else _find_sections(profile, upright=False)
        found = found or _find_front(profile)
    if plain and not lies:
        found = found or _find_sections(_measure(places, up, lattice.spacing), upright=True)
    return [(nodes, roles) for nodes, roles in found if _is_one_piece(lattice, nodes)]


def _measure(places: np.ndarray, axis: np.ndarray, spacing: float) -> _Profile:
    along = places @ axis
    length = max(float(np.ptp(along)), 1e-12)
    along = (along - along.min()) / length
    aside = np.cross(axis, np.eye(3)[0 if abs(axis[2]) > _UPRIGHT else 2])
    aside /= np.linalg.norm(aside)
    across = places @ np.stack([aside, np.cross(axis, aside)]).T
    index = np.minimum((along * _BINS).astype(int), _BINS - 1)
    known = np.unique(index)
    breadth = [np.ptp(across[index == k], axis=0).max() + spacing for k in known]
    return _Profile(along, np.interp(np.arange(_BINS), known, breadth), length)


def _find_sections(profile: _Profile, *, upright: bool) -> list[Found]:
    """The slim and the broad sections along the axis (upwards), if they are clearly apart."""
    slim, broad = np.quantile(profile.breadth, 0.2), profile.breadth.max()
    if broad < _CONTRAST * slim or slim > _THIN * profile.length:
        return []
    is_broad = profile.breadth > slim + _LEVEL * (broad - slim)
    for end in (is_broad, is_broad[::-1]):  # a broad end is rounded
        end[:_ROUND] |= end[_ROUND]
    starts = [0, *(np.flatnonzero(np.diff(is_broad.astype(int))) + 1), _BINS]
    kinds = "".join("B" if is_broad[a] else "s" for a in starts[:-1])
    lengths = np.diff(starts) / _BINS
    slims = [length for length, kind in zip(lengths, kinds) if kind == "s"]
    if not slims or max(slims) < _SLIM:
        return []
    a, b = starts[1] / _BINS, starts[-2] / _BINS
    below, above, between = profile.pick(0.0, a), profile.pick(b, 1.0), profile.pick(a, b)
    match kinds:
        case "sB" if upright:
            return [(below, ("stem", "handle")), (above, ("top", "crown", "head", "blade"))]
        case "Bs" if upright:
            return [(above, ("neck",))]
        case "BsB" if upright:
            return [(between, ("stem",)), (above, ("top", "crown"))]
        case "sB" | "Bs" | "BsB":
            sizes = [profile.breadth[: starts[1]].sum(), profile.breadth[starts[-2] :].sum()]
            first = kinds == "Bs" or kinds == "BsB" and sizes[0] > sizes[1]
            if kinds == "BsB" and max(sizes) < _CONTRAST * min(sizes):  # a bone, a dumbbell
                return []
            head, handle = (below, profile.pick(a, 1.0)) if first else (above, profile.pick(0.0, b))
            grip = profile.pick(1 - _END, 1.0) if first else profile.pick(0.0, _END)
            return [(handle, ("handle",)), (head, ("head", "blade")), (grip, ("grip",))]
        case "sBs" if upright and lengths[1] > _GUARD and lengths[0] > lengths[2]:
            return [
                (below, ("stem",)),
                (profile.pick(a, 1.0), ("top", "crown")),
            ]  # a hat with a knob, a mushroom
        case "sBs" if lengths[1] < _GUARD and max(slims) > 2 * min(slims):
            blade, handle = (below, above) if lengths[0] > lengths[2] else (above, below)
            tip = profile.pick(0.0, _END) if lengths[0] > lengths[2] else profile.pick(1 - _END, 1.0)
            return [(blade, ("blade",)), (handle, ("handle",)), (tip, ("tip",))]
    return []


def _find_front(profile: _Profile) -> list[Found]:
    """The bow and the stern of what is long and lies: fins make a stern broader than what is before it.

    Without fins the bow is the end that is clearly more pointed.
    """
    ends = [profile.pick(0.0, _END), profile.pick(1 - _END, 1.0)]
    sides = [profile.breadth, profile.breadth[::-1]]
    flares = [each[: _BINS // 7].max() / each[_BINS // 7 : 2 * _BINS // 5].min() for each in sides]
    breadths = [each[: _BINS // 8].mean() for each in sides]
    if max(flares) > _FLARED and min(flares) < _EVEN:
        front = int(np.argmin(flares))
        return [(ends[front], ("nose", "bow")), (ends[1 - front], ("stern",))]
    if max(breadths) > _POINTED * min(breadths):
        front = int(np.argmin(breadths))
        return [(ends[front], ("tip", "bow")), (ends[1 - front], ("stern",))]
    return []


def _find_toe(places: np.ndarray, spacing: float) -> list[Found]:
    """The toe and the heel of what stands on a long sole and is low at one end."""
    level = np.linalg.eigh(np.cov(places[:, :2].T))[1][:, 1]
    height = places[:, 2] - places[:, 2].min()
    tall = float(height.max())
    profile = _measure(places, np.array([*level, 0.0]), spacing)
    sole = profile.along[height < _SOLE[0] * tall]
    tops = [float(height[profile.pick(*each)].max()) for each in ((0.0, _END), (1 - _END, 1.0))]
    if tall < _FLAT * profile.length or np.ptp(sole) < _SOLE[1] or min(tops) > _LOW * max(tops):
        return []
    ends = [profile.pick(0.0, _END), profile.pick(1 - _END, 1.0)]
    toe, other = ends if tops[0] < tops[1] else ends[::-1]
    return [(toe, ("toe",)), (other[height[other] < _HEEL * tall], ("heel",))]


def _is_one_piece(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Return whether a section is some but not all of the object, and holds together."""
    if not 0 < len(nodes) < len(lattice.places):
        return False
    labels = find_pieces(lattice.make_mask(nodes))
    sizes = np.bincount(labels.ravel())[1:]
    return bool(sizes.max() > 0.95 * sizes.sum())
