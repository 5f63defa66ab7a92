"""The transfer kernels as JAX functions, with their derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, cast

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import ffi
from physagent_jax.kernels.numbers import SHARES_PER_THREAD
from physagent_jax.kernels.threads import choose_team, thread_count
from physagent_jax.mpm import inertia, transfer
from physagent_jax.mpm.health import Health
from physagent_jax.mpm.kernels.adjoint import TOTALS
from physagent_jax.mpm.kernels.handlers import register_handler
from physagent_jax.mpm.kernels.transfer import HEALTH_FIELDS, NUMBERS, PADDING
from physagent_jax.mpm.materials.neo_hookean import NeoHookean
from physagent_jax.mpm.materials.viscous import viscous_stress
from physagent_jax.mpm.state import Grid

_BY_NUMBER = (3, 0, 1, 2)  # how the kernels want arrays over the grid, major to minor

_R = TypeVar("_R")


def _custom_vjp(*fixed: int) -> Callable[[Callable[..., _R]], jax.custom_vjp[_R]]:
    """`jax.custom_vjp` by all arguments but those numbered ``fixed``, with the result's type kept."""
    return cast(Any, partial(jax.custom_vjp, nondiff_argnums=fixed))


@_custom_vjp(0)
def p2g(form: str, grid: Grid, x, v, C, tau, mass, volume, dv, dt) -> jax.Array:
    """As `transfer.p2g`."""
    return _scatter(form, grid, x, v, C, tau, mass, volume, dv, dt)


@_custom_vjp(0)
def p2g_neo_hookean(
    form: str, grid: Grid, x, v, C, F, mu, lam, mass, volume, dv, dt
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """`p2g` with the stress of `materials.NeoHookean`, which never goes through memory; with ``x`` and ``F``.

    Who goes on with these saves a reverse pass the sum of two derivatives by each: it is made on the way as well.
    """
    return _scatter(form, grid, x, v, C, F, mass, volume, dv, dt, lame=(mu, lam)), x, F


@_custom_vjp(0)
def p2g_kelvin_voigt(
    form: str, grid: Grid, x, v, C, F, mu, lam, viscosity, rate, mass, volume, dv, dt
) -> jax.Array:
    """Also with `materials.viscous_stress` at the velocity gradient ``rate`` [1/s], shape (n, 3, 3); only the nodes."""
    return _scatter(form, grid, x, v, C, F, mass, volume, dv, dt, lame=(mu, lam), viscous=(viscosity, rate))


@_custom_vjp(0)
def p2g_apart(
    form: str, grid: Grid, x, v, C, tau, lame, viscous, mass, volume, dv, push, unit, dt
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """As `transfer.p2g_apart`, or with ``tau`` = F the stress of `materials.NeoHookean` where ``lame`` is (mu, lam).

    ``viscous`` are viscosity and velocity gradient as of `p2g_kelvin_voigt`, or None; only beside ``lame``. ``x`` and
    ``tau`` come back as of `p2g_neo_hookean`.
    """
    options = dict(lame=lame, viscous=viscous, apart=(push, unit))
    return _scatter(form, grid, x, v, C, tau, mass, volume, dv, dt, **options), x, tau


def _scatter(
    form, grid, x, v, C, tau, mass, volume, dv, dt, *, lame=None, viscous=None, apart=None
) -> jax.Array:
    """``tau`` is F where ``lame`` are the parameters of a neo-Hookean law; ``apart`` are push and unit."""
    count, nothing = len(x), jnp.zeros(1, x.dtype)
    mu, lam = lame or (nothing, nothing)
    viscosity, rate = viscous or (nothing, C)
    _check(
        "p2g",
        grid,
        dict(x=x, v=v, C=C, tau=tau, mu=mu, lam=lam, viscosity=viscosity, rate=rate)
        | dict(mass=mass, volume=volume, dv=dv),
        dict(x=(count, 3), v=(count, 3), C=(count, 3, 3), tau=(count, 3, 3), mass=(count,), volume=(count,))
        | dict.fromkeys(("mu", "lam"), (count,) if lame else (1,))
        | dict(viscosity=(count,) if viscous else (1,), rate=(count, 3, 3), dv=(3,)),
    )
    parts, size = thread_count(), NUMBERS * grid.shape[0] * grid.shape[1] * grid.shape[2] + PADDING
    options = form == "gradient", lame is not None, viscous is not None
    grids, kernel, more = 1, "p2g", ()
    if apart is not None:
        push, unit = apart
        ffi.check_operands("p2g_apart", dict(push=push), dict(push=(len(push), 3)), x.dtype)
        grids, kernel, more, options = 2, "p2g_apart", (push,), (*options, len(push) == count, unit)
    nodes = jax.ShapeDtypeStruct((*grid.shape, grids * NUMBERS), x.dtype)
    private = jax.ShapeDtypeStruct((grids * parts, size), x.dtype)
    call = jax.ffi.ffi_call(
        register_handler(kernel, x.dtype.name),
        (nodes, private, _describe_touched(parts)),
        vmap_method="sequential",
        output_layouts=(_BY_NUMBER, None, None),
    )
    scalars = _stack_scalars(x.dtype, dt, grid.dx, *options)
    particles = x, v, C, tau, mu, lam, viscosity, rate, mass, volume, dv, *more
    return call(*particles, grid.origin, scalars, **choose_team())[0]


@jax.custom_vjp
def grid_velocity(nodes: jax.Array, least: jax.Array) -> jax.Array:
    """As `transfer.grid_velocity`, which XLA joins with what follows; only its derivative is a kernel."""
    return transfer.grid_velocity(nodes, least)


@_custom_vjp(0)
def aggregate(aggregation: float, nodes: jax.Array, unit: jax.Array, least: jax.Array) -> jax.Array:
    """As `inertia.aggregate`, of which the derivative is made with box sums."""
    return _aggregate(aggregation, nodes, unit, least, jnp.zeros_like(unit))


@_custom_vjp(0)
def aggregated_velocity(aggregation: float, nodes, unit, least, empty) -> jax.Array:
    """As `inertia.aggregated_velocity`, of which the derivative is made with box sums."""
    return _aggregate(aggregation, nodes, unit, least, empty)


def _aggregate(aggregation: float, nodes, unit, least, empty) -> jax.Array:
    nx, ny, nz = nodes.shape[:3]
    ffi.check_operands("aggregate", dict(nodes=nodes), dict(nodes=(nx, ny, nz, 8)), nodes.dtype)
    call = jax.ffi.ffi_call(
        register_handler("aggregate", nodes.dtype.name),
        tuple(jax.ShapeDtypeStruct((nx, ny, nz, k), nodes.dtype) for k in (3, 3, 4)),
        vmap_method="sequential",
        input_layouts=(_BY_NUMBER, None),
        output_layouts=(_BY_NUMBER,) * 3,
    )
    bare = inertia.NEXT_TO_NOTHING * least * unit
    scalars = _stack_scalars(nodes.dtype, aggregation, unit, bare, empty)
    return call(nodes, scalars, **choose_team())[0]


@jax.custom_vjp
def sum_neighbours(values: jax.Array) -> jax.Array:
    """As `inertia.sum_neighbours`."""
    nx, ny, nz, numbers = values.shape
    ffi.check_operands(
        "sum_neighbours", dict(values=values), dict(values=(nx, ny, nz, numbers)), values.dtype
    )
    call = jax.ffi.ffi_call(
        register_handler("sum_neighbours", values.dtype.name),
        jax.ShapeDtypeStruct(values.shape, values.dtype),
        vmap_method="sequential",
        input_layouts=(_BY_NUMBER,),
        output_layouts=_BY_NUMBER,
    )
    return call(values, **choose_team())


@_custom_vjp(0)
def sharpened_velocity(beta: float, nodes, opposed, unit, least, empty) -> jax.Array:
    """As `inertia.sharpened_velocity`."""
    nx, ny, nz = nodes.shape[:3]
    operands, shapes, shape = {"nodes": nodes}, {"nodes": (nx, ny, nz, 8)}, (nx, ny, nz, 3)
    if opposed is not None:
        operands["opposed"], shapes["opposed"] = opposed, shape
    ffi.check_operands("sharpened_velocity", operands, shapes, nodes.dtype)
    call = jax.ffi.ffi_call(
        register_handler("sharpened_velocity", nodes.dtype.name),
        jax.ShapeDtypeStruct(shape, nodes.dtype),
        vmap_method="sequential",
        input_layouts=(_BY_NUMBER, _BY_NUMBER, None),
        output_layouts=_BY_NUMBER,
    )
    return call(nodes, *_stack_sharpening(beta, nodes, opposed, unit, least, empty), **choose_team())


def _stack_sharpening(beta: float, nodes, opposed, unit, least, empty) -> tuple[jax.Array, jax.Array]:
    """Velocities and scalars that the kernels take beside the nodes; one number in place of no velocities."""
    bare = inertia.NEXT_TO_NOTHING * least
    scalars = _stack_scalars(nodes.dtype, beta, inertia.FULL / unit, bare, empty, opposed is None)
    return jnp.zeros((1,) * 4, nodes.dtype) if opposed is None else opposed, scalars


@_custom_vjp(0, 1)
def g2p(form: str, wall: int, grid: Grid, x, v, C, F, velocity, dt) -> transfer.Moved:
    """As `transfer.g2p`. ``v`` and ``C`` only lend their memory."""
    return _gather(form, wall, grid, x, v, C, F, velocity, dt, in_place=True)


def _gather(form, wall, grid, x, v, C, F, velocity, dt, *, in_place: bool) -> transfer.Moved:
    """Write over ``x``, ``v``, ``C``, ``F`` if ``in_place``: where they are kept too, XLA would copy them first."""
    count = len(x)
    _check(
        "g2p",
        grid,
        dict(x=x, v=v, C=C, F=F, velocity=velocity),
        dict(x=(count, 3), v=(count, 3), C=(count, 3, 3), F=(count, 3, 3), velocity=(*grid.shape, 3)),
    )
    shares, size = (
        thread_count() * SHARES_PER_THREAD,
        NUMBERS * grid.shape[0] * grid.shape[1] * grid.shape[2] + PADDING,
    )
    results = tuple(jax.ShapeDtypeStruct(like.shape, x.dtype) for like in (x, v, C, F))
    results += tuple(jax.ShapeDtypeStruct(shape, x.dtype) for shape in ((shares, HEALTH_FIELDS), (size,)))
    # A particle's old x and F are read before its new ones are written: they may lie in the same place.
    call = jax.ffi.ffi_call(
        register_handler("g2p", x.dtype.name),
        results,
        vmap_method="sequential",
        input_layouts=(None, None, None, None, _BY_NUMBER, None, None),
        input_output_aliases={k: k for k in range(4)} if in_place else None,
    )
    walls = transfer.find_walls(wall, grid)
    scalars = _stack_scalars(x.dtype, dt, grid.dx, form == "gradient", *walls)
    x, v, C, F, health, _ = call(x, v, C, F, velocity, grid.origin, scalars, **choose_team())
    least_J, most_J, least_increment, speed, nonfinite, outside, beyond = health.T
    return transfer.Moved(
        *(x, v, C, F),
        Health(
            least_J.min(),
            most_J.max(),
            least_increment.min(),
            speed.max(),
            nonfinite.sum() == 0,
            outside.sum().astype(jnp.int32),
            beyond.sum().astype(jnp.int32),
        ),
    )


@_custom_vjp(0, 1)
def stop(
    form: str, wall: int, grid: Grid, x, F, velocity, dt, new_x, new_v, beyond
) -> tuple[jax.Array, jax.Array]:
    """As `transfer.stop`, of what `g2p` made of ``x``, ``F`` and ``velocity``.

    A reverse pass needs to know of ``beyond`` alone: where none was stopped, nothing else is asked for, and else G2P is
    done again.
    """
    del form, x, F, velocity, dt
    return transfer.stop(*transfer.find_walls(wall, grid), new_x, new_v, beyond)


def _check(kernel: str, grid: Grid, operands: dict[str, jax.Array], shapes: dict[str, tuple[int, ...]]):
    """`ffi.check_operands`, and that a stencil has room in the window: beyond it the kernels would write elsewhere."""
    if min(grid.shape) < 3:
        raise UserError(
            f"the kernel {kernel} takes windows of three nodes or more along each axis", got=grid.shape
        )
    operands, shapes = operands | {"origin": grid.origin}, shapes | {"origin": (3,)}
    ffi.check_operands(kernel, operands, shapes, operands["x"].dtype, origin="int32")


def _stack_scalars(dtype, *numbers) -> jax.Array:
    return jnp.stack([jnp.asarray(number, dtype) for number in numbers])


def _pull_p2g(grid, operands, cotangent, passed=None):
    """Derivatives by ``operands`` of `_scatter`, mu and lam among them.

    ``passed`` are those by x and F of what takes them from a neo-Hookean P2G, and are added.
    """
    x, v, C, tau, mu, lam, mass, volume, dv, dt = operands
    shares = thread_count() * SHARES_PER_THREAD
    results = tuple(_describe_flat(like) for like in operands[:8])
    results += (jax.ShapeDtypeStruct((shares, TOTALS), x.dtype), _describe_padded_grid(grid, x.dtype))
    call = jax.ffi.ffi_call(
        register_handler("p2g_adjoint", x.dtype.name),
        results,
        vmap_method="sequential",
        input_layouts=(*(None,) * 10, _BY_NUMBER, *(None,) * 3),
        input_output_aliases={} if passed is None else {11: 0, 12: 3},
    )
    scalars = _stack_scalars(x.dtype, dt, grid.dx, passed is not None)
    passed = [each.reshape(-1) for each in passed or (mu, mu)]
    fixed = mass, volume, dv, grid.origin, cotangent
    *bars, totals, _ = call(x, v, C, tau, mu, lam, *fixed, *passed, scalars, **choose_team())
    bars = [bar.reshape(like.shape) for bar, like in zip(bars, operands)]
    total = totals.sum(0)
    return (*bars, total[:3], total[3])


def _p2g_forward(form, grid, *operands):
    return p2g(form, grid, *operands), (grid, operands)


def _p2g_backward(form, residuals, cotangent):
    grid, operands = residuals
    if form != "mls":  # the classical form has no adjoint kernel
        return (None, *jax.vjp(partial(transfer.p2g, form, grid), *operands)[1](cotangent))
    x, v, C, tau, *others = operands
    nothing = jnp.zeros(1, x.dtype)
    operands = x, v, C, tau, nothing, nothing, *others
    bars = _pull_p2g(grid, operands, cotangent)
    return (None, *bars[:4], *bars[6:])


def _p2g_neo_hookean_forward(form, grid, *operands):
    return p2g_neo_hookean(form, grid, *operands), (grid, operands)


def _p2g_neo_hookean_backward(form, residuals, cotangents):
    (grid, operands), (cotangent, *passed) = residuals, cotangents
    if form == "mls":
        return (None, *_pull_p2g(grid, operands, cotangent, passed))

    def reference(x, v, C, F, mu, lam, mass, volume, dv, dt):
        tau = NeoHookean(mu, lam).stress(F)
        return transfer.p2g(form, grid, x, v, C, tau, mass, volume, dv, dt), x, F

    return (None, *jax.vjp(reference, *operands)[1](tuple(cotangents)))


def _p2g_kelvin_voigt_forward(form, grid, *operands):
    return p2g_kelvin_voigt(form, grid, *operands), (grid, operands)


def _p2g_kelvin_voigt_backward(form, residuals, cotangent):
    grid, operands = residuals

    def unfused(
        x, v, C, F, mu, lam, viscosity, rate, *others
    ):  # the stress through memory; `p2g` has an adjoint
        tau = NeoHookean(mu, lam).stress(F) + viscous_stress(viscosity, rate, F)
        return p2g(form, grid, x, v, C, tau, *others)

    return (None, *jax.vjp(unfused, *operands)[1](cotangent))


def _p2g_apart_forward(form, grid, *operands):
    return p2g_apart(form, grid, *operands), (grid, operands)


def _p2g_apart_backward(form, residuals, cotangents):
    grid, operands = residuals
    x, v, C, tau, lame, viscous, *others = operands
    if form != "mls" or viscous is not None:  # there is no adjoint kernel

        def unfused(x, v, C, tau, lame, viscous, *others):  # the stress through memory
            stress = tau if lame is None else NeoHookean(*lame).stress(tau)
            stress = stress if viscous is None else stress + viscous_stress(viscous[0], viscous[1], tau)
            if form != "mls":
                return transfer.p2g_apart(form, grid, x, v, C, stress, *others), x, tau
            return p2g_apart(form, grid, x, v, C, stress, None, None, *others)[0], x, tau

        return (None, *jax.vjp(unfused, *operands)[1](tuple(cotangents)))
    mass, volume, dv, push, unit, dt = others
    count, shares = len(x), thread_count() * SHARES_PER_THREAD
    mu, lam = lame or (jnp.zeros(1, x.dtype),) * 2
    particles = x, v, C, tau, mu, lam, mass, volume
    padded = _describe_padded_grid(grid, x.dtype)
    results = tuple(_describe_flat(like) for like in (*particles, push))
    results += tuple(jax.ShapeDtypeStruct(s, x.dtype) for s in ((shares, 2 * TOTALS), (2 * padded.size,)))
    call = jax.ffi.ffi_call(
        register_handler("p2g_apart_adjoint", x.dtype.name),
        results,
        vmap_method="sequential",
        input_layouts=(*(None,) * 11, _BY_NUMBER, *(None,) * 3),
        input_output_aliases={12: 0, 13: 3},
    )
    pushed, (cotangent, *passed) = len(push) == count, cotangents
    scalars = _stack_scalars(x.dtype, dt, grid.dx, unit, lame is not None, pushed)
    passed = [each.reshape(-1) for each in passed]
    *bars, totals, _ = call(*particles, dv, push, grid.origin, cotangent, *passed, scalars, **choose_team())
    bars = [bar.reshape(like.shape) for bar, like in zip(bars, (*particles, push))]
    total = totals.sum(0)
    by_push = bars[8] if pushed else total[None, 4:7]
    by_lame = None if lame is None else (bars[4], bars[5])
    return (None, *bars[:4], by_lame, None, *bars[6:8], total[:3], by_push, jnp.zeros_like(unit), total[3])


def _aggregate_forward(aggregation, *operands):
    return aggregate(aggregation, *operands), operands


def _aggregated_velocity_forward(aggregation, *operands):
    return aggregated_velocity(aggregation, *operands), operands


def _aggregate_backward(reference, aggregation, operands, cotangent):
    nodes, *constants = operands

    def compute(nodes):
        return reference(aggregation, nodes, *constants, sum_neighbours=sum_neighbours)

    return (*jax.vjp(compute, nodes)[1](cotangent), *map(jnp.zeros_like, constants))


def _sum_neighbours_forward(values):
    return sum_neighbours(values), None


def _sum_neighbours_backward(_, cotangent):
    return (sum_neighbours(cotangent),)


def _sharpened_velocity_forward(beta, *operands):
    return sharpened_velocity(beta, *operands), operands


def _sharpened_velocity_backward(beta, operands, cotangent):
    nodes, opposed, *constants = operands
    velocities, scalars = _stack_sharpening(beta, *operands)
    call = jax.ffi.ffi_call(
        register_handler("sharpened_velocity_adjoint", nodes.dtype.name),
        tuple(jax.ShapeDtypeStruct(each.shape, nodes.dtype) for each in (nodes, velocities)),
        vmap_method="sequential",
        input_layouts=(_BY_NUMBER, _BY_NUMBER, _BY_NUMBER, None),
        output_layouts=(_BY_NUMBER, _BY_NUMBER),
    )
    by_nodes, by_opposed = call(nodes, velocities, cotangent, scalars, **choose_team())
    return (by_nodes, None if opposed is None else by_opposed, *map(jnp.zeros_like, constants))


def _grid_velocity_forward(nodes, least):
    return grid_velocity(nodes, least), (nodes, least)


def _grid_velocity_backward(residuals, cotangent):
    nodes, least = residuals
    call = jax.ffi.ffi_call(
        register_handler("grid_velocity_adjoint", nodes.dtype.name),
        jax.ShapeDtypeStruct(nodes.shape, nodes.dtype),
        vmap_method="sequential",
        input_layouts=(_BY_NUMBER, None, _BY_NUMBER),
        output_layouts=_BY_NUMBER,
    )
    return call(nodes, least[None], cotangent, **choose_team()), jnp.zeros_like(least)


def _g2p_forward(form, wall, grid, *operands):
    return _gather(form, wall, grid, *operands, in_place=False), (grid, operands)


def _g2p_backward(form, wall, residuals, cotangent):
    grid, operands = residuals
    if form != "mls":
        return (None, *jax.vjp(partial(transfer.g2p, form, wall, grid), *operands)[1](cotangent))
    x, v, C, F, velocity, dt = operands
    parts = thread_count()
    padded = _describe_padded_grid(grid, x.dtype)
    results = _describe_flat(x), _describe_flat(F), jax.ShapeDtypeStruct((*grid.shape, NUMBERS), x.dtype)
    results += tuple(jax.ShapeDtypeStruct((parts, size), x.dtype) for size in (padded.size, TOTALS))
    call = jax.ffi.ffi_call(
        register_handler("g2p_adjoint", x.dtype.name),
        (*results, _describe_touched(parts), padded),
        vmap_method="sequential",
        input_layouts=(None, None, _BY_NUMBER, *(None,) * 6),
        output_layouts=(None, None, _BY_NUMBER, *(None,) * 4),
    )
    bars = cotangent.x, cotangent.v, cotangent.C, cotangent.F  # what `Health` holds has no derivative
    scalars = _stack_scalars(x.dtype, dt, grid.dx)
    made = call(x, F, velocity, grid.origin, *bars, scalars, **choose_team())
    by_x, by_F, nodes, _, totals, _, _ = made
    by_x, by_F = by_x.reshape(x.shape), by_F.reshape(F.shape)
    return (None, by_x, jnp.zeros_like(v), jnp.zeros_like(C), by_F, nodes[..., :3], totals[:, 3].sum())


def _stop_forward(form, wall, grid, *operands):
    *again, _, _, beyond = operands
    return stop(form, wall, grid, *operands), (grid, again, beyond)


def _stop_backward(form, wall, residuals, cotangents):
    grid, (x, F, velocity, dt), beyond = residuals

    def mask(by_x, by_v):
        moved = _gather(form, wall, grid, x, x, F, F, velocity, dt, in_place=False)
        out, leading = transfer.find_stopped(*transfer.find_walls(wall, grid), moved.x, moved.v)
        return jnp.where(out, 0, by_x), jnp.where(leading, 0, by_v)

    by_x, by_v = jax.lax.cond(beyond > 0, mask, lambda *same: same, *cotangents)
    return (None, None, None, None, None, by_x, by_v, None)


def _describe_touched(parts: int) -> jax.ShapeDtypeStruct:
    """Room for the first and last + 1 of the planes that each share of the particles touches."""
    return jax.ShapeDtypeStruct((parts, 2), jnp.int32)


def _describe_flat(like: jax.Array) -> jax.ShapeDtypeStruct:
    """A derivative by ``like`` in one dimension, so that XLA adds it to others in one loop instead of three."""
    return jax.ShapeDtypeStruct((like.size,), like.dtype)


def _describe_padded_grid(grid: Grid, dtype) -> jax.ShapeDtypeStruct:
    """Room for all numbers of a grid's nodes and `PADDING`."""
    return jax.ShapeDtypeStruct((NUMBERS * math.prod(grid.shape) + PADDING,), dtype)


p2g.defvjp(_p2g_forward, _p2g_backward)
p2g_neo_hookean.defvjp(_p2g_neo_hookean_forward, _p2g_neo_hookean_backward)
p2g_kelvin_voigt.defvjp(_p2g_kelvin_voigt_forward, _p2g_kelvin_voigt_backward)
p2g_apart.defvjp(_p2g_apart_forward, _p2g_apart_backward)
grid_velocity.defvjp(_grid_velocity_forward, _grid_velocity_backward)
aggregate.defvjp(_aggregate_forward, partial(_aggregate_backward, inertia.aggregate))
aggregated_velocity.defvjp(
    _aggregated_velocity_forward, partial(_aggregate_backward, inertia.aggregated_velocity)
)
sum_neighbours.defvjp(_sum_neighbours_forward, _sum_neighbours_backward)
sharpened_velocity.defvjp(_sharpened_velocity_forward, _sharpened_velocity_backward)
g2p.defvjp(_g2p_forward, _g2p_backward)
stop.defvjp(_stop_forward, _stop_backward)
