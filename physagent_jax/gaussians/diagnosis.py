"""Signs that a cloud is not the object that its user means: said before anything is simulated.

Lengths are compared with the extent of the bulk, so that units do not matter. The limits stand well beyond what real
captures of single objects have (measured on seven, 98 to 84,130 Gaussians): a median largest standard deviation of 0.6
to 2 % of the extent, none above half of it, 0.7 to 0.9 % of needles, 60 to 99 % of the positions distinct.
"""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import GaussianCloud

MOST_BLOB = 0.1  # median of the largest standard deviation over the extent
MOST_LARGE, LARGE = 0.02, 0.5  # share of Gaussians whose standard deviation is above so much of the extent
MOST_NEEDLES, NEEDLE = 0.05, 100.0  # share of Gaussians whose longest axis is so many times the second one
FEWEST_PLACES = 0.25  # share of positions that are distinct
FEWEST = 16  # Gaussians of an object
FAINT = 0.1  # opacity that few Gaussians reach in a cloud which can hardly be seen
FEWEST_CLEAR = 0.05  # share of Gaussians that reach it
_FEWEST_JUDGED = 32  # Gaussians from which shares say something
_TRIMMED = 0.01  # share of the Gaussians on each side that may be floaters

_ENCODING = "if its scales or opacities are stored another way, say so with `--splat-encoding`"


def diagnose_cloud(cloud: GaussianCloud) -> tuple[str, ...]:
    """Sentences on what is wrong with a cloud, with numbers and the option that helps; none for a sound one.

    Args:
        cloud: The Gaussians, in any units.
    """
    means, scales = np.asarray(cloud.means, np.float64), np.asarray(cloud.scales, np.float64)
    opacities = np.asarray(cloud.opacities, np.float64)
    if len(means) < FEWEST:
        return (
            f"the object has only {len(means)} Gaussian{'s' if len(means) > 1 else ''}: lower `--opacity-threshold` "
            "or the crop if parts of it are missing",
        )
    if len(means) < _FEWEST_JUDGED:
        return ()
    extent = _measure_extent(means)
    if not extent > 0:
        return ("nearly all Gaussians share one place: the capture has no extent; export the scene again",)
    found = [
        _diagnose_size(scales, extent),
        _diagnose_needles(scales),
        _diagnose_places(means),
        _diagnose_opacity(opacities),
    ]
    return tuple(each for each in found if each is not None)


def check_cloud(cloud: GaussianCloud) -> None:
    """Refuse a cloud that has no shape to simulate: half of its Gaussians are larger than half of it.

    Args:
        cloud: The Gaussians, in any units.

    Raises:
        UserError: The cloud is such.
    """
    if cloud.count < _FEWEST_JUDGED:
        return
    extent = _measure_extent(np.asarray(cloud.means, np.float64))
    median = float(np.median(np.asarray(cloud.scales, np.float64).max(axis=1)))
    if extent > 0 and median > LARGE * extent:
        raise UserError(
            "the object's Gaussians are as large as the object, so that it has no shape",
            got=f"a median size of {median / extent:.2g} of its extent",
            do=_ENCODING[0].upper() + _ENCODING[1:],
        )


def _measure_extent(means: np.ndarray) -> float:
    """Longest side of the bulk's bounding box."""
    low, high = np.quantile(means, [_TRIMMED, 1 - _TRIMMED], axis=0)
    return float((high - low).max())


def _diagnose_size(scales: np.ndarray, extent: float) -> str | None:
    largest = scales.max(axis=1) / extent
    median, large = float(np.median(largest)), int((largest > LARGE).sum())
    if median > LARGE:
        return f"its Gaussians are as large as the object: the median size is {median:.2g} of its extent; {_ENCODING}"
    if median > MOST_BLOB:
        return (
            f"its Gaussians blur into one blob: the median size is {median:.2g} of the object's extent "
            f"(captures have 0.02 or less); {_ENCODING}"
        )
    if large > MOST_LARGE * len(scales):
        return (
            f"{large:,} of {len(scales):,} Gaussians are larger than half of the object: they hide it; "
            "a background that was captured with it can be cut off with `source.crop`"
        )
    return None


def _diagnose_needles(scales: np.ndarray) -> str | None:
    ordered = np.sort(scales, axis=1)
    needles = int((ordered[:, 2] > NEEDLE * ordered[:, 1]).sum())
    if needles <= MOST_NEEDLES * len(scales):
        return None
    return (
        f"{needles:,} of {len(scales):,} Gaussians are needles, more than {NEEDLE:g} times as long as wide: they stick "
        f"out when the object bends; train with a limit on their shape, or {_ENCODING}"
    )


def _diagnose_places(means: np.ndarray) -> str | None:
    if max(len(np.unique(column)) for column in means.T) >= FEWEST_PLACES * len(means):
        return None  # as in nearly all clouds; whole rows take longer to sort
    places = len(np.unique(means, axis=0))
    if places >= FEWEST_PLACES * len(means):
        return None
    return (
        f"its {len(means):,} Gaussians have only {places:,} distinct positions: they were rounded or copied; "
        "export the scene again"
    )


def _diagnose_opacity(opacities: np.ndarray) -> str | None:
    clear = int((opacities >= FAINT).sum())
    if clear >= FEWEST_CLEAR * len(opacities):
        return None
    return (
        f"only {clear:,} of {len(opacities):,} Gaussians have an opacity of {FAINT:g} or more: the object can hardly "
        f"be seen; raise `--opacity-threshold` to keep its solid part, or {_ENCODING}"
    )
