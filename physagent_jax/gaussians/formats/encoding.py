"""The encoding of stored scales and opacities: given, stated by the file, or found from the values.

The 3DGS layout stores the logarithm of a scale and the logit of an opacity. Some exporters store them plain, without
a word in the file. The values tell which it is:

- Scales: a negative one is a logarithm. Otherwise both readings are held against the spacing of the Gaussians: trained
  scenes have a median standard deviation between `_LEAST_SIZE` and `_MOST_SIZE` spacings (0.2 to 4 in real captures).
  Where one reading alone is in that range, it is the one.
- Opacities: one outside [0, 1] is a logit. Otherwise they are plain if the scales are plain too, or if they spread over
  `_SPREAD` of the range: the logits of a scene do not end at 0 and at 1.

What is left open is refused, because a wrong guess would be a wrong object.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name

ENCODINGS = ("log-logit", "plain-plain", "log-plain", "plain-logit")
"""The names of encodings, "scales-opacities", as `--splat-encoding` takes them."""

STANDARD = ENCODINGS[0]
COMMENT = "splat-encoding"
"""The key of a PLY comment that states the encoding: "splat-encoding log-logit"."""

_LEAST_SIZE, _MOST_SIZE = 0.1, 10.0  # median standard deviation over the spacing of neighbours
_SPREAD = 0.5
_FEWEST_SPREAD = 50  # opacities from which their spread says something
_FEWEST_SPACED = 4  # Gaussians from which their spacing says something
_MOST_SPACED = 20_000  # of which the spacing is measured
_NEIGHBOURS = 8
_MOST_BAD = 0.5  # share of values outside an encoding's range, above which the encoding is refused


@dataclasses.dataclass(frozen=True)
class Decoded:
    """Scales and opacities in linear units.

    Attributes:
        scales: Standard deviations [file units], shape (n, k); NaN where the encoding has no such value.
        opacities: In [0, 1], shape (n,); NaN likewise.
        words: The encoding in words ("log scales, logit opacities").
        notes: Sentences that a user should read before a run.
    """

    scales: np.ndarray
    opacities: np.ndarray
    words: str
    notes: tuple[str, ...]


def decode(
    means: np.ndarray,
    scales: np.ndarray,
    opacities: np.ndarray,
    *,
    shown: str,
    given: str | None = None,
    stated: str | None = None,
    plain_opacities: bool = False,
) -> Decoded:
    """Decode stored scales and opacities.

    Args:
        means: Positions [file units], float64, shape (n, 3).
        scales: Stored scales, float64, shape (n, k).
        opacities: Stored opacities, float64, shape (n,).
        shown: The file's name, for messages.
        given: The user's encoding, one of `ENCODINGS`; None = none.
        stated: The encoding that the file states; None = none.
        plain_opacities: Whether the opacities are known to be plain.

    Raises:
        UserError: ``given`` is no encoding or does not fit the values, or the values fit two encodings.
    """
    if given is not None and given not in ENCODINGS:
        raise explain_unknown_name("the encoding `splat_encoding`", given, ENCODINGS)
    notes: list[str] = []
    said = given or (stated if stated in ENCODINGS else None)
    if said is not None:
        scale_code, opacity_code = said.split("-")
        opacity_code = "plain" if plain_opacities else opacity_code
    else:
        scale_code, opacity_code = _find_codes(means, scales, opacities, shown, plain_opacities)
        plain = [
            f"{what} plain"
            for what, code in (("scales", scale_code), ("opacities", opacity_code))
            if code == "plain"
        ]
        if plain and not (plain_opacities and scale_code == "log"):
            notes.append(
                f"{shown}: its values show that it stores {' and '.join(plain)}, unlike the 3DGS layout "
                f"(log scales, logit opacities), and it is read so; `--splat-encoding {STANDARD}` reads the layout's"
            )
    with np.errstate(over="ignore"):  # what overflows is dropped
        if scale_code == "log":
            scales = np.exp(scales)
        else:
            scales = _blank(scales, scales < 0, "scales below 0, as plain scales never are", shown, notes)
        if opacity_code == "logit":
            opacities = 1.0 / (1.0 + np.exp(-opacities))
        else:
            outside = (opacities < 0) | (opacities > 1)
            opacities = _blank(opacities, outside, "opacities outside 0 to 1", shown, notes)
    words = f"{scale_code} scales, {opacity_code} opacities"
    return Decoded(scales, opacities, words, tuple(notes))


def find_stated(comments: Iterable[str]) -> str | None:
    """The encoding that the comments of a PLY header state; None = none."""
    words = [comment.split() for comment in comments]
    return next((each[1] for each in words if len(each) == 2 and each[0] == COMMENT), None)


def is_evident(means: np.ndarray, scales: np.ndarray, opacities: np.ndarray) -> bool:
    """Return whether stored values show by themselves that they are of the `STANDARD` encoding.

    Args:
        means: Positions [file units], shape (n, 3).
        scales: Stored logarithms of scales, shape (n, 3).
        opacities: Stored logits, shape (n,).
    """
    try:
        return _find_codes(means, scales, opacities, "", False) == ("log", "logit")
    except UserError:
        return False


def _find_codes(
    means: np.ndarray, scales: np.ndarray, opacities: np.ndarray, shown: str, plain_opacities: bool
) -> tuple[str, str]:
    """The encodings of scales and opacities from their values.

    Raises:
        UserError: The values fit two of them.
    """
    whole = np.isfinite(means).all(axis=1) & np.isfinite(scales).all(axis=1) & ~np.isnan(opacities)
    if not whole.any():
        return "log", "logit"  # all are dropped, which is said then
    means, scales, opacities = means[whole], scales[whole], opacities[whole]
    scale_code, sizes = _find_scale_code(means, scales)
    opacity_code = "plain" if plain_opacities else _find_opacity_code(opacities, scale_code)
    if scale_code is not None and opacity_code is not None:
        return scale_code, opacity_code
    open_ones = []
    if scale_code is None:
        open_ones.append(f"scales from {scales.min():.3g} to {scales.max():.3g}, {sizes}")
    if opacity_code is None:
        low, high = 1.0 / (1.0 + np.exp(-np.array([opacities.min(), opacities.max()])))
        open_ones.append(
            f"opacities from {opacities.min():.3g} to {opacities.max():.3g}, as logits {low:.3g} to {high:.3g}"
        )
    fitting = [
        name
        for name in ENCODINGS
        if scale_code in (None, name.split("-")[0]) and opacity_code in (None, name.split("-")[1])
    ]
    raise UserError(
        f"{shown}: the encoding of its values is ambiguous: they can be meant as they are, or as logarithms and logits",
        got="; ".join(open_ones),
        do=f"Say which it is with `--splat-encoding` {' or '.join(fitting)} (`splat_encoding` in Python and in files)",
    )


def _find_scale_code(means: np.ndarray, scales: np.ndarray) -> tuple[str | None, str]:
    """The encoding of scales, None if both or neither fit; and their sizes in both readings, in words."""
    if (scales < 0).any():
        return "log", ""
    with np.errstate(over="ignore"):
        sizes = {
            code: float(np.median(each.max(axis=1)))
            for code, each in (("log", np.exp(scales)), ("plain", scales))
        }
    spacing = _measure_spacing(means)
    if spacing is None:
        words = " or ".join(f"{size:.3g} ({code})" for code, size in sizes.items())
        return None, f"a median size of {words}"
    ratios = {code: size / spacing for code, size in sizes.items()}
    fitting = [code for code, ratio in ratios.items() if _LEAST_SIZE <= ratio <= _MOST_SIZE]
    words = " or ".join(f"{ratio:.3g} ({code})" for code, ratio in ratios.items())
    return (
        fitting[0] if len(fitting) == 1 else None
    ), f"a median size of {words} times the spacing of Gaussians"


def _find_opacity_code(opacities: np.ndarray, scale_code: str | None) -> str | None:
    """The encoding of opacities; None if it is open."""
    if ((opacities < 0) | (opacities > 1)).any():
        return "logit"
    if scale_code == "plain":
        return "plain"
    return "plain" if len(opacities) >= _FEWEST_SPREAD and np.ptp(opacities) >= _SPREAD else None


def _measure_spacing(means: np.ndarray) -> float | None:
    """Median distance to the nearest neighbour at another place [file units]; None if that says nothing."""
    if len(means) < _FEWEST_SPACED:
        return None
    tried = means[:: max(1, len(means) // _MOST_SPACED)]
    tree: Any = KDTree(means)  # scipy annotates `query` for a single neighbour only
    distances = np.asarray(tree.query(tried, k=min(_NEIGHBOURS, len(means)))[0])
    nearest = np.where(distances > 0, distances, np.inf).min(axis=1)
    nearest = nearest[np.isfinite(nearest)]
    return float(np.median(nearest)) if len(nearest) else None


def _blank(values: np.ndarray, bad: np.ndarray, what: str, shown: str, notes: list[str]) -> np.ndarray:
    """Values with NaN in the rows that the encoding does not have.

    Raises:
        UserError: That are most of them.
    """
    rows = np.asarray(bad.reshape(len(bad), -1).any(axis=1))
    if rows.sum() > _MOST_BAD * len(rows):
        raise UserError(
            f"{shown} does not have the encoding that was given",
            got=f"{rows.sum():,} of {len(rows):,} Gaussians with {what}",
            do="Choose another `--splat-encoding`, or leave it out",
        )
    if rows.any():
        notes.append(f"{shown}: {rows.sum():,} Gaussians have {what}; they are dropped")
    return np.where(rows.reshape(-1, *[1] * (values.ndim - 1)), np.nan, values)
