"""Shared parts of kernels: constants of the right precision, splines, and the division of work."""

# pyright: reportCallIssue=false

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
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


@intrinsic
def _split_exponent(typing, number):
    """k and m of a normal number 2^k m, with m in [sqrt(1/2), sqrt(2))."""
    width = number.bitwidth
    digits, least = {32: (23, 0x3F3504F3), 64: (52, 0x3FE6A09E667F3BCD)}[width]  # bits of sqrt(1/2)
    word = ir.IntType(width)

    def generate(context, builder, signature, arguments):
        bits = builder.bitcast(arguments[0], word)
        exponent = builder.ashr(builder.sub(bits, word(least)), word(digits))
        rest = builder.sub(bits, builder.shl(exponent, word(digits)))
        kind = context.get_value_type(number)
        pair = builder.sitofp(exponent, kind), builder.bitcast(rest, kind)
        return context.make_tuple(builder, signature.return_type, pair)

    return types.UniTuple(number, 2)(number), generate


@intrinsic
def _ln2_high(typing, number):
    """The first digits of ln 2: its product with an exponent is exact."""
    return _make_constant(number, {32: 0.693359375, 64: float.fromhex("0x1.62e42feep-1")})


@intrinsic
def _ln2_low(typing, number):
    """The other digits."""
    return _make_constant(number, {32: -2.12194440e-4, 64: 1.90821492927058770002e-10})


@intrinsic
def _is_double(typing, number):
    """Return whether a number is float64, known as the code is compiled."""
    wide = number.bitwidth == 64
    return types.boolean(number), lambda context, builder, signature, arguments: ir.IntType(1)(int(wide))


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
def log(x):
    """Natural logarithm, off by at most 0.81 of the last place; subnormal numbers are not served.

    Unlike a call of the C library, it can be computed of several numbers at once. With f = m - 1 and s = f / (2 + f),
    log m = 2 artanh s = f - f^2 / 2 + s (f^2 / 2 + 2 s^2 / 3 + 2 s^4 / 5 + ...), where |s| < 0.172.
    """
    k, m = _split_exponent(x)
    one, zero, inf = cast_like(1, x), cast_like(0, x), cast_like(np.inf, x)
    f = m - one
    s, half = f / (m + one), cast_like(0.5, x) * f * f
    z, series = s * s, zero
    for n in range(21 if _is_double(x) else 11, 1, -2):
        series = z * (cast_like(2, x) / cast_like(n, x) + series)
    usual = k * _ln2_high(x) + (f - (half - (s * (half + series) + k * _ln2_low(x))))
    return usual if zero < x < inf else (x if x == inf else (-inf if x == zero else cast_like(np.nan, x)))


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
    """Write particle p's vector."""
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
