"""A force's effect, place and time in words."""

from __future__ import annotations

from physagent_jax.forces.schema import BoxRegion, CellsRegion, HalfSpaceRegion, Region
from physagent_jax.motion.schema import DirectionTable
from physagent_jax.report.directions import describe_direction
from physagent_jax.report.formats import format_number, format_quantity, format_seconds, format_vector
from physagent_jax.scene.config import (
    FOREVER,
    Attractor,
    Envelope,
    ForceTerm,
    PulseEnvelope,
    RampEnvelope,
    SineEnvelope,
    Turbulence,
    Uniform,
    Vortex,
    Wind,
)


def describe_force_term(term: ForceTerm, table: DirectionTable) -> str:
    """A term of the scene in words."""
    match term:
        case Wind():
            words = _describe_wind(term, table)
        case Attractor():
            verb = "attracts" if term.strength >= 0 else "repels"
            words = f"{format_vector(term.point)} m {verb} with {format_number(abs(term.strength))} m/s\u00b2 at 1 m"
            words += f", falling off with power {format_number(term.power)}"
        case Vortex():
            words = _describe_vortex(term, table)
        case Turbulence():
            scale = format_quantity(term.length_scale, "m")
            words = f"turbulence of {format_number(term.strength)} m/s\u00b2 on scales of {scale}"
            words += f" and {format_seconds(term.time_scale)}, seed {term.seed}"
        case Uniform():
            words = f"uniform acceleration {format_vector(term.acceleration)} m/s\u00b2"
    where = "" if term.region is None else f"; region: {describe_region(term.region)}"
    return words + _describe_envelope(term.envelope) + where


def _describe_wind(wind: Wind, table: DirectionTable) -> str:
    words = "still air"
    if wind.speed > 0 and wind.direction is not None:
        words = f"wind blowing {describe_direction(wind.direction, table)} at {format_number(wind.speed)} m/s"
    drags = [(wind.linear_drag, "1/s"), (wind.quadratic_drag, "1/m")]
    words += ", drag " + " and ".join(f"{format_number(value)} {unit}" for value, unit in drags if value)
    if wind.center is not None:
        words += (
            f", within {format_quantity(wind.radius, 'm')} of the line through {format_vector(wind.center)} m"
        )
    return words


def _describe_vortex(vortex: Vortex, table: DirectionTable) -> str:
    sides = [(vortex.swirl, "around it"), (vortex.inward, "towards it"), (vortex.axial, "along it")]
    parts = ", ".join(f"{format_number(value)} m/s\u00b2 {side}" for value, side in sides if value)
    axis = f"{describe_direction(vortex.axis, table)} through {format_vector(vortex.point)} m"
    return f"vortex about an axis pointing {axis}, core {format_quantity(vortex.core, 'm')}: {parts}"


def _describe_envelope(envelope: Envelope) -> str:
    words = ""
    match envelope:
        case RampEnvelope():
            sides = [(envelope.rise, "rising"), (envelope.fall, "falling")]
            words = "".join(f", {verb} over {format_seconds(value)}" for value, verb in sides if value)
        case PulseEnvelope():
            words = ", one smooth pulse"
        case SineEnvelope():
            words = f", swinging at {format_number(envelope.frequency)} Hz"
    return words + describe_span(envelope.start, envelope.end)


def describe_span(start: float, end: float) -> str:
    """The window of a boundary, a constraint or a term; empty if it is always open."""
    if start == 0 and end >= FOREVER:
        return ""
    return (
        f", from {format_seconds(start)}"
        if end >= FOREVER
        else f", {format_seconds(start)} to {format_seconds(end)}"
    )


def describe_region(region: Region | None) -> str:
    """Describe the region of an action."""
    if region is None:
        return "the whole object"
    if isinstance(region, BoxRegion):
        limited = [axis for axis in range(3) if region.low[axis] > 0 or region.high[axis] < 1]
        if len(limited) == 1:
            return _describe_slab(region, limited[0])
        return f"a box from {format_vector(region.low)} to {format_vector(region.high)} of the bounding box"
    if isinstance(region, HalfSpaceRegion):
        return f"beyond {format_vector(region.point)} of the bounding box, towards {format_vector(region.normal)}"
    if isinstance(region, CellsRegion):
        return f"the {region.label}" if region.label else "a part that sticks out"
    ball = f"a ball of radius {format_number(region.radius)} body lengths"
    return f"{ball} about {format_vector(region.center)} of the bounding box"


def _describe_slab(region: BoxRegion, axis: int) -> str:
    low, high = max(0.0, region.low[axis]), min(1.0, region.high[axis])
    percent = f"{format_number(100 * (high - low))} % along {'xyz'[axis]}"
    if high == 1.0:
        return f"the {'upper' if axis == 2 else 'high'} {percent}"
    if low == 0.0:
        return f"the {'lower' if axis == 2 else 'low'} {percent}"
    return f"{format_number(100 * low)}\u2013{format_number(100 * high)} % along {'xyz'[axis]}"
