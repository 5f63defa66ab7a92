"""The transfer kernels of NVIDIA GPUs as JAX functions; their derivatives are those of `mpm.transfer`.

Sums over particles are made in no fixed order, so that results differ by round-off from run to run.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.kernels import cuda, ffi
from physagent_jax.mpm import transfer
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.materials.neo_hookean import NeoHookean
from physagent_jax.mpm.state import Grid

_SOURCE = Path(__file__).with_name("transfer.cu")
_NUMBERS = {"p2g": 0, "g2p": 8}  # of the kernels, each in all its variants


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def p2g(form: str, grid: Grid, x, v, C, tau, mass, volume, dv, dt) -> jax.Array:
    """As `transfer.p2g`."""
    return _scatter(form, grid, x, v, C, tau, None, mass, volume, dv, dt)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def p2g_neo_hookean(form: str, grid: Grid, x, v, C, F, mu, lam, mass, volume, dv, dt) -> jax.Array:
    """`p2g` with the stress of `materials.NeoHookean`, which never goes through memory."""
    return _scatter(form, grid, x, v, C, F, (mu, lam), mass, volume, dv, dt)


def _scatter(form, grid, x, v, C, S, lame, mass, volume, dv, dt) -> jax.Array:
    count = len(x)
    mu, lam = lame or (mass, mass)
    vectors, matrices, numbers = (
        dict(x=x, v=v),
        dict(C=C, S=S),
        dict(mu=mu, lam=lam, mass=mass, volume=volume),
    )
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(vectors, (count, 3))
    shapes |= dict.fromkeys(matrices, (count, 3, 3))
    shapes |= dict.fromkeys(numbers, (count,)) | dict(dv=(3,), origin=(3,))
    operands = vectors | matrices | numbers | dict(dv=dv, origin=grid.origin)
    ffi.check_operands("p2g", operands, shapes, x.dtype, origin="int32")
    nodes = jnp.zeros((*grid.shape, 4), x.dtype)
    given = [*operands.values(), _list_sizes(count, grid), _stack_scalars(x.dtype, dt, grid.dx), nodes]
    aliases = {"input_output_aliases": {len(given) - 1: 0}}
    return _launch("p2g", form, lame is not None, [nodes], given, count, **aliases)[0]


@partial(jax.custom_vjp, nondiff_argnums=(0, 1))
def g2p(form: str, wall: int, grid: Grid, x, v, C, F, velocity, dt) -> transfer.Moved:
    """As `transfer.g2p`. ``v`` and ``C`` only lend their memory."""
    return _gather(form, wall, grid, x, v, C, F, velocity, dt, in_place=True)


def _gather(form, wall, grid, x, v, C, F, velocity, dt, *, in_place: bool) -> transfer.Moved:
    """Write over ``x``, ``v``, ``C``, ``F`` if ``in_place``: where they are kept too, XLA would copy them first."""
    count, dtype = len(x), x.dtype
    operands = dict(x=x, v=v, C=C, F=F, velocity=velocity, origin=grid.origin)
    shapes: dict[str, tuple[int, ...]] = dict(x=(count, 3), v=(count, 3), C=(count, 3, 3), F=(count, 3, 3))
    shapes |= dict(velocity=(*grid.shape, 3), origin=(3,))
    ffi.check_operands("g2p", operands, shapes, dtype, origin="int32")
    walls = transfer.find_walls(wall, grid)
    extremes, counts = jnp.full(4, math.inf, dtype), jnp.zeros(3, jnp.int32)
    given = [*operands.values(), _list_sizes(count, grid), _stack_scalars(dtype, dt, grid.dx, *walls)]
    aliases = {len(given): 4, len(given) + 1: 5} | ({k: k for k in range(4)} if in_place else {})
    made = _launch(
        "g2p", form, False, [x, v, C, F, extremes, counts], [*given, extremes, counts], count,
        input_output_aliases=aliases,
    )  # fmt: skip
    x, v, C, F, (J, minus_J, increment, minus_square), (lost, outside, beyond) = made
    health = Health(J, -minus_J, increment, jnp.sqrt(-minus_square), lost == 0, outside, beyond)
    return transfer.Moved(x, v, C, F, health)


def _launch(kernel, form, neo_hookean, results, operands, count, **options) -> list[jax.Array]:
    """A variant of a kernel, with a thread for each of ``count`` particles."""
    dtype = operands[0].dtype
    single, gradient = dtype == np.float32, form == "gradient"
    macros = dict(
        REAL="float" if single else "double",
        SINGLE=int(single),
        GRADIENT=int(gradient),
        NEO_HOOKEAN=int(neo_hookean),
    )
    number = _NUMBERS[kernel] + 4 * single + 2 * gradient + neo_hookean
    described = [jax.ShapeDtypeStruct(each.shape, each.dtype) for each in results]
    return cuda.launch(number, _SOURCE, kernel, macros, described, operands, count, **options)


def _list_sizes(count: int, grid: Grid) -> jax.Array:
    return jnp.asarray([count, *grid.shape], jnp.int32)


def _stack_scalars(dtype, *numbers) -> jax.Array:
    return jnp.stack([jnp.asarray(number, dtype) for number in numbers])


def _reference_neo_hookean(form, grid, x, v, C, F, mu, lam, *others):
    return transfer.p2g(form, grid, x, v, C, NeoHookean(mu, lam).stress(F), *others)


def _define_derivatives(function: Any, reference, fixed: int) -> None:
    """Take the derivatives of ``reference``, whose first ``fixed`` arguments and the grid have none."""

    def forward(*arguments):
        return function(*arguments), arguments[fixed:]

    def backward(*arguments):
        *options, (grid, *operands), cotangent = arguments
        return (None, *jax.vjp(partial(reference, *options, grid), *operands)[1](cotangent))

    function.defvjp(forward, backward)


_define_derivatives(p2g, transfer.p2g, 1)
_define_derivatives(p2g_neo_hookean, _reference_neo_hookean, 1)


def _g2p_forward(form, wall, grid, *operands):
    return _gather(form, wall, grid, *operands, in_place=False), (grid, *operands)


def _g2p_backward(form, wall, residuals, cotangent):
    grid, *operands = residuals
    return (None, *jax.vjp(partial(transfer.g2p, form, wall, grid), *operands)[1](cotangent))


g2p.defvjp(_g2p_forward, _g2p_backward)
