"""Measures of a target's clauses on a clip: the same numbers for the judge and for methods that minimise."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.metrics.clips import Clip, compute_root
from physagent_jax.metrics.targets import (
    Clause,
    Direct,
    Distance,
    Event,
    Integrity,
    Order,
    Oscillation,
    Path,
    Rest,
    Stretch,
    Turn,
)

VISIBLE = 0.02
"""Length below which a motion has no direction and no order [body lengths]."""
_FAINT = 0.005  # [body lengths] root mean square of a swing that has no frequency
LINKED, NEIGHBOURS = 800, 12  # particles whose links are looked at, and links of each


@dataclasses.dataclass(frozen=True)
class Measure:
    """One number that a clause asks for.

    Attributes:
        name: What it is, for people.
        seen: On the clip, scalar; may be traced.
        wanted: What the clause asks for.
        tolerance: By how much it may differ.
        unit: Unit of all three.
        parts: What it is made of, in tolerances, where that says more to a least-squares method than the number
            itself; zero where the target is hit.
    """

    name: str
    seen: jax.Array
    wanted: float
    tolerance: float
    unit: str
    parts: jax.Array | None = None

    @property
    def miss(self) -> jax.Array:
        """Seen less wanted [tolerances]."""
        return (self.seen - self.wanted) / self.tolerance


def measure_clause(clause: Clause, clip: Clip) -> list[Measure]:
    """The numbers of a clause; most have one."""
    return _MEASURES[type(clause)](clause, clip)


def _measure_direction(clause: Direct, clip: Clip) -> list[Measure]:
    """Angle to the wanted direction; less than `VISIBLE` counts as going across it.

    A way across of `VISIBLE`^2 / the way itself is added, which is `VISIBLE` at rest and nothing to speak of later.
    """
    first, last = clause.window
    centre = clip.centre(clause.part)
    way, toward = centre[last] - centre[first], jnp.asarray(clause.toward, centre.dtype)
    along = way @ toward
    square = jnp.sum((way - along * toward) ** 2) + VISIBLE**4 / (VISIBLE**2 + way @ way)
    angle = jnp.degrees(jnp.arctan2(jnp.sqrt(square), along))
    return [Measure(_name("direction", clause, clause.toward), angle, 0.0, clause.tolerance, "degrees")]


def _measure_distance(clause: Distance, clip: Clip) -> list[Measure]:
    first, last = clause.window
    centre = clip.centre(clause.part)[first : last + 1]
    way = centre - centre[0]
    if clause.along is None:
        values = compute_root(jnp.sum(way**2, -1))
    else:
        values = way @ jnp.asarray(clause.along, way.dtype)
    seen = _pick(values, clause.when, clause.target)
    name = _name("distance" if clause.when == "end" else "farthest", clause, clause.along)
    return [Measure(name, seen, clause.target, clause.tolerance, "body lengths")]


def _measure_turn(clause: Turn, clip: Clip) -> list[Measure]:
    first, last = clause.window
    angles = clip.turned(clause.part, clause.axis)
    if clause.against is not None:
        angles = angles - clip.turned(clause.against, clause.axis)
    seen = _pick((angles - angles[first])[first : last + 1], clause.when, clause.target)
    name = _name("turn" if clause.against is None else "twist", clause, clause.axis)
    return [Measure(name, seen, clause.target, clause.tolerance, "degrees")]


def _measure_stretch(clause: Stretch, clip: Clip) -> list[Measure]:
    first, last = clause.window
    maps = clip.maps(clause.part)[first : last + 1]
    if clause.along is None:
        lengths = jnp.cbrt(jnp.maximum(jnp.linalg.det(maps), 1e-6))
    else:
        lengths = jnp.linalg.norm(maps @ jnp.asarray(clause.along, maps.dtype), axis=-1)
    seen = _pick(lengths / lengths[0] - 1.0, clause.when, clause.target)
    return [Measure(_name("stretch", clause, clause.along), seen, clause.target, clause.tolerance, "")]


def _measure_oscillation(clause: Oscillation, clip: Clip) -> list[Measure]:
    """Half of the greatest way, and the frequency at which a sine of that spread would have that mean square speed.

    Means are by the trapezoidal rule, so that both are exact for a sine over whole periods.
    """
    first, last = clause.window
    path = clip.centre(clause.part)[first : last + 1] @ jnp.asarray(clause.along, clip.x.dtype)
    weight = np.ones(last - first + 1)
    weight[[0, -1]] = 0.5
    weight = jnp.asarray(weight / weight.sum(), path.dtype)
    amplitude = 0.5 * (path.max() - path.min())
    spread = weight @ (path - weight @ path) ** 2
    step = compute_root(jnp.mean(jnp.diff(path) ** 2)) / jnp.sqrt(spread + _FAINT**2)
    frequency = jnp.arcsin(jnp.minimum(0.5 * step, 0.999)) / (np.pi * clip.frame_dt)
    name = _name("amplitude", clause, clause.along)
    return [
        Measure(name, amplitude, clause.target, clause.tolerance, "body lengths"),
        Measure(
            _name("frequency", clause, clause.along),
            frequency,
            clause.frequency,
            clause.frequency_tolerance,
            "Hz",
        ),
    ]


def _measure_order(clause: Order, clip: Clip) -> list[Measure]:
    """Mean time of the one motion's way after that of the other's; nothing where one of them is not seen."""
    times, shown = zip(*(_find_middle(event, clause, clip) for event in (clause.first, clause.second)))
    lag = (times[1] - times[0]) * shown[0] * shown[1]
    name = f"lag of {_say_event(clause.second)} behind {_say_event(clause.first)}{_say_window(clause)}"
    return [Measure(name, lag, clause.target, clause.tolerance, "frames")]


def _find_middle(event: Event, clause: Order, clip: Clip) -> tuple[jax.Array, jax.Array]:
    """Mean time of what is gone along a direction [frames], and whether that is to be seen, 0 to 1."""
    first, last = clause.window
    path = clip.centre(event.part)[first : last + 1] @ jnp.asarray(event.along, clip.x.dtype)
    gone = jnp.maximum(jnp.diff(path), 0.0)
    times = jnp.arange(first, last) + 0.5
    total = gone.sum()
    return (gone @ times.astype(path.dtype)) / (total + 1e-6), total**2 / (total**2 + VISIBLE**2)


def _measure_rest(clause: Rest, clip: Clip) -> list[Measure]:
    first, last = clause.window
    seen = clip.moved(clause.part, first)[: last - first + 1].max()
    return [Measure(_name("rest", clause, None), seen, 0.0, clause.tolerance, "body lengths")]


def _measure_integrity(clause: Integrity, clip: Clip) -> list[Measure]:
    first, last = clause.window
    growth = clip.link_growth(LINKED, NEIGHBOURS)[first : last + 1]
    seen = jnp.maximum(growth - clause.limit, 0.0).mean(1).max()
    return [Measure(_name("parting of neighbours", clause, None), seen, 0.0, clause.tolerance, "")]


def _measure_path(clause: Path, clip: Clip) -> list[Measure]:
    first, last = clause.window
    misses = []
    for place in clause.places:
        centre = clip.centre(place.part)
        misses.append((centre - centre[0])[first : last + 1] - jnp.asarray(place.centres, centre.dtype))
    miss = jnp.stack(misses)
    distance = compute_root(jnp.sum(miss**2, -1))
    parts = miss.ravel() / (clause.tolerance * np.sqrt(distance.size))
    name = f"distance from the stored paths{_say_window(clause)}"
    return [Measure(name, distance.max(), 0.0, clause.tolerance, "body lengths", parts)]


_MEASURES: dict[type, Callable[..., list[Measure]]] = {
    Direct: _measure_direction,
    Distance: _measure_distance,
    Turn: _measure_turn,
    Stretch: _measure_stretch,
    Oscillation: _measure_oscillation,
    Order: _measure_order,
    Rest: _measure_rest,
    Integrity: _measure_integrity,
    Path: _measure_path,
}


def _pick(values: jax.Array, when: str, target: float) -> jax.Array:
    """The last value, or that which goes farthest the target's way; either way, if the target is 0."""
    if when == "end":
        return values[-1]
    if target:
        return values.max() if target > 0 else values.min()
    return jnp.where(values.max() >= -values.min(), values.max(), values.min())


def _name(what: str, clause: Clause, direction: tuple[float, float, float] | None) -> str:
    along = "" if direction is None else f" along {_say(direction)}"
    return f"{what}{along}{_say_part(clause.part)}{_say_window(clause)}"


def _say(direction: tuple[float, float, float]) -> str:
    return "(" + ", ".join(f"{c:.3g}" for c in direction) + ")"


def _say_part(part: tuple[float, float, float] | None) -> str:
    return "" if part is None else f" of the end {_say(part)}"


def _say_event(event: Event) -> str:
    return f"motion along {_say(event.along)}{_say_part(event.part)}"


def _say_window(clause: Clause) -> str:
    return f", frames {clause.window[0]} to {clause.window[1]}"
