"""The expected motion in words, for the page and the terminal."""

from __future__ import annotations

from physagent_jax.motion.schema import Amount, DirectionTable, ExpectedMotion, MotionKind
from physagent_jax.report.directions import describe_axis, describe_direction, describe_turn
from physagent_jax.report.formats import format_fixed, format_plural, format_window


def describe_motion(expected: ExpectedMotion, table: DirectionTable) -> str:
    """Kind and direction: "rotate clockwise as we see it"."""
    kind, axis = expected.kind, expected.direction
    if axis is None:
        scales = kind in (MotionKind.STRETCH, MotionKind.SQUEEZE)
        return f"{kind.value} in all directions" if scales else kind.value
    if kind is MotionKind.ROTATE:
        return f"{kind.value} {describe_turn(axis, table)}"
    if kind in (MotionKind.STRETCH, MotionKind.SQUEEZE):
        return f"{kind.value} along {describe_axis(axis, table)}"
    return f"{kind.value} {describe_direction(axis, table)}"


def list_details(expected: ExpectedMotion, table: DirectionTable, frame_dt: float | None) -> list[str]:
    """List amount, timing, repetition, part and ending of a motion."""
    measured = expected.amount is not None and expected.amount.unit != "seconds"
    details = [] if measured else [f"strength {format_fixed(expected.strength)}"]
    if expected.amount is not None:
        details.append(describe_amount(expected.amount))
    details.append(format_window(*expected.window, frame_dt))
    if expected.sudden:
        details.append("with a blow")
    if expected.part is not None:
        end = f"the end that is {describe_direction(expected.part, table)}"
        details.append(f"everything but {end}" if expected.excludes_part else end)
    elif expected.partial:
        details.append("in a part of the object")
    if expected.repeats > 1:
        details.append(format_plural(expected.repeats, "time"))
    if expected.released:
        details.append("then let go")
    if expected.stays:
        details.append("and stays there")
    return details


def describe_amount(amount: Amount) -> str:
    """A quantity with its unit in words."""
    value = f"{amount.value:g}"
    return {
        "lengths": f"{value} body lengths",
        "metres": f"{value} m",
        "degrees": f"{value} degrees",
        "factor": f"to {value} times its size",
        "seconds": f"caused for {value} s",
    }[amount.unit]
