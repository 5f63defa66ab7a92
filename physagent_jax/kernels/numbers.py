"""What the kernels share: constants of the right precision, splines, and the division of work."""

# pyright: reportCallIssue=false

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

NO_WRAPPERS: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""For what compiled code alone calls: doors for Python are a tenth of the work of compiling.

Only handlers are kept on disk (`store`), each with all that it calls.
"""
BODY: dict[str, Any] = {**NO_WRAPPERS, "inline": "always"}  # of a handler

OPTIONS = {
    **NO_WRAPPERS,
    "boundscheck": False,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz"},  # not "nnan": what is not finite has to be noticed
    "nogil": True,
}
INLINE = {**OPTIONS, "forceinline": True}  # for what is called per particle: arrays are costly to pass

SHARES_PER_THREAD = 8
"""Into how many a thread's work is cut where whoever is free takes the next: cores are seldom equally fast."""


@intrinsic
def cast_like(typing, constant, number):
    """``constant`` in the precision of ``number``: Numba would compute float32 with float64 constants in float64."""

    def generate(context, builder, signature, arguments):
        return context.cast(builder, arguments[0], signature.args[0], number)

    return number(types.unliteral(constant), number), generate


@intrinsic
def smallest_normal(typing, number):
    """About the smallest normal number of the precision of ``number``."""
    return _make_constant(number, {32: 1.2e-38, 64: 2.3e-308})


@intrinsic
def roundoff(typing, number):
    """Half the distance from 1 to the next number of the precision of ``number``."""
    return _make_constant(number, {32: 2.0**-24, 64: 2.0**-53})


def _make_constant(number, by_width: dict[int, float]):
    def generate(context, builder, signature, arguments):
        return context.get_constant(number, by_width[number.bitwidth])

    return number(number), generate


@njit(**INLINE)
def lowest_node(scaled, count):
    """Lowest of the three nodes of a stencil, and the distance to it in cells; kept inside the window.

    A particle outside deposits on the rim, as the reference does; NaN counts as zero, so that nothing is written
    elsewhere.
    """
    low = np.floor(scaled - cast_like(0.5, scaled))
    inside = (
        min(max(low, cast_like(0, scaled)), cast_like(count - 3, scaled))
        if low == low
        else cast_like(0, scaled)
    )
    return int(inside), scaled - low


@njit(**INLINE)
def spline(f):
    """Quadratic B-spline weights of the three nodes, f cells from the lowest."""
    a, b, c = cast_like(1.5, f) - f, f - cast_like(1, f), f - cast_like(0.5, f)
    half = cast_like(0.5, f)
    return half * a * a, cast_like(0.75, f) - b * b, half * c * c


@njit(**INLINE)
def spline_derivative(f):
    """Their derivatives by the particle's position in cells."""
    return f - cast_like(1.5, f), cast_like(2, f) - cast_like(2, f) * f, f - cast_like(0.5, f)


@njit(**INLINE)
def extract(values, i):
    """``values[i]`` for a tuple of three, which LLVM keeps in registers."""
    return values[0] if i == 0 else (values[1] if i == 1 else values[2])


@njit(**INLINE)
def load_columns(matrices, p):
    """Columns of particle p's matrix."""
    M = matrices
    return (
        (M[p, 0, 0], M[p, 1, 0], M[p, 2, 0]),
        (M[p, 0, 1], M[p, 1, 1], M[p, 2, 1]),
        (M[p, 0, 2], M[p, 1, 2], M[p, 2, 2]),
    )


@njit(**INLINE)
def store_vector(vectors, p, a):
    """Writes particle p's vector."""
    vectors[p, 0], vectors[p, 1], vectors[p, 2] = a[0], a[1], a[2]


@njit(**INLINE)
def scale(factor, a):
    """Factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@njit(**INLINE)
def dot(a, b):
    """A . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INLINE)
def load_row(matrices, p, i):
    """Row i of particle p's matrix."""
    return matrices[p, i, 0], matrices[p, i, 1], matrices[p, i, 2]


@njit(**INLINE)
def determinant(a, b, c):
    """Of the matrix with rows a, b, c."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


@njit(**INLINE)
def split_range(count, part, parts):
    """First and last + 1 of the ``part``-th of ``parts`` nearly equal shares."""
    return part * count // parts, (part + 1) * count // parts
