"""Inputs at the edge of sense, and beyond it: each has to work or to be refused in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.stability.scenario import DENSITY, SIZE, Run, Scenario, build
from physagent_jax.mpm import Contact, DomainBox, HalfSpace, NeoHookean

Expected = Literal["pass", "refused", "either"]
EVERY_KIND = ("neo-hookean", "fixed-corotated", "hencky", "von-mises", "sand", "snow", "cohesive-fluid")


@dataclasses.dataclass(frozen=True)
class Edge:
    """A degenerate input.

    Attributes:
        name: What is odd about it.
        scenario: What it is made from; names it with ``name``.
        change: What is done to the scenario's run.
        expected: Verdict; "either" where both make sense.
    """

    name: str
    scenario: Scenario
    change: Callable[[Run], Run]
    expected: Expected = "pass"

    def build(self) -> Run:
        """The changed run."""
        return self.change(build(self.scenario))


def edges() -> Iterator[Edge]:
    """All degenerate inputs."""
    for material in EVERY_KIND:
        thrown = Scenario(material, wall="corner")
        yield Edge("a single particle", thrown, lambda run: _select(run, slice(0, 1)))
        yield Edge("all particles in two points", thrown, _make_coincident)
        yield Edge("particles on nodes", thrown, _put_on_nodes)
        yield Edge(
            "particles on the wall's plane", thrown, lambda run: _move(run, run.state.x - 0.75 * _get_dx(run))
        )
        yield Edge(
            "equal and paired stretches", thrown, lambda run: _strain(run, slice(None), (1.1, 1.1, 0.9))
        )
        yield Edge("mass ratio 10^4", Scenario(material, wall="resting"), _put_heavy_on_light)
    for material in ("neo-hookean", "hencky", "sand"):
        thrown = Scenario(material, wall="corner")
        yield Edge("F = diag(0.01, 1, 1)", thrown, lambda run: _strain(run, 0, (0.01, 1.0, 1.0)))
    for material in EVERY_KIND:
        calm = Scenario(material)
        yield Edge("F = diag(-1, 1, 1)", calm, lambda run: _strain(run, 0, (-1.0, 1.0, 1.0)), "refused")
        yield Edge("squeezed to nothing", calm, squeezed, "either")
    for material in ("fluid", "cohesive-fluid", "sand", "neo-hookean"):
        yield Edge("thrown into a corner at 17 m/s", Scenario(material, wall="corner"), _hurl)
    calm = Scenario("neo-hookean")
    for name, change in MALFORMED.items():
        yield Edge(name, calm, change, "refused")


def _get_dx(run: Run) -> float:
    return run.model.grid.dx


def _change_state(run: Run, **changes) -> Run:
    return dataclasses.replace(run, state=dataclasses.replace(run.state, **changes))


def _change_model(run: Run, **changes) -> Run:
    return dataclasses.replace(run, model=run.model.replace(**changes))


def _move(run: Run, x: jax.Array) -> Run:
    return _change_state(run, x=x)


def _select(run: Run, chosen: slice) -> Run:
    """The same scene with fewer particles."""
    count = len(run.state.x)

    def cut(leaf):
        return leaf[chosen] if getattr(leaf, "ndim", 0) and leaf.shape[0] == count else leaf

    model = run.model
    parts = dict(mass=cut(model.mass), volume=cut(model.volume), materials=jax.tree.map(cut, model.materials))
    return dataclasses.replace(run, model=model.replace(**parts), state=jax.tree.map(cut, run.state))


def _make_coincident(run: Run) -> Run:
    half = len(run.state.x) // 2
    x = jnp.where(
        jnp.arange(len(run.state.x))[:, None] < half, run.state.x[0], run.state.x[0] + 1.4 * _get_dx(run)
    )
    return _move(run, x)


def _put_on_nodes(run: Run) -> Run:
    return _move(run, jnp.round(run.state.x / _get_dx(run)) * _get_dx(run))


def _strain(run: Run, chosen: int | slice, stretches: tuple[float, float, float]) -> Run:
    stretch = jnp.diag(jnp.asarray(stretches, run.state.F.dtype))
    return _change_state(run, F=run.state.F.at[chosen].set(stretch))


def _put_heavy_on_light(run: Run) -> Run:
    upper = run.state.x[:, 2] > run.state.x[:, 2].mean()
    shorter = dataclasses.replace(run, frame_dt=run.frame_dt / 50)  # the light half's bound is a hundredth
    return _change_model(shorter, mass=jnp.where(upper, run.model.mass, 1e-4 * run.model.mass))


def _hurl(run: Run) -> Run:
    return _change_state(run, v=jnp.full_like(run.state.v, -10.0))


def squeezed(run: Run) -> Run:
    """Between two walls that meet at the end of the clip."""
    x, dtype, dx = run.state.x, run.state.x.dtype, _get_dx(run)
    duration = 8 * run.frame_dt
    low, high = float(x[:, 0].min()) - dx, float(x[:, 0].max()) + dx
    walls = []
    for place, side in ((low, 1.0), (high, -1.0)):
        speed = side * (high - low) / 2 / duration
        walls.append(
            HalfSpace(
                jnp.asarray([place, 0, 0], dtype),
                jnp.asarray([side, 0, 0], dtype),
                jnp.zeros((), dtype),
                jnp.zeros((), dtype),
                jnp.asarray(1e9, dtype),
                Contact.SEPARATE,
                jnp.asarray([speed, 0, 0], dtype),
            )
        )
    moving = _change_model(run, boundaries=(*walls, DomainBox(3)), gravity=jnp.zeros_like(run.model.gravity))
    return dataclasses.replace(moving, walls_rest=False)


def _set_first(leaf: jax.Array, value: float) -> jax.Array:
    return leaf.at[(0,) * leaf.ndim].set(value)


def _scale_stiffness(run: Run, factor: float) -> Run:
    solid = run.model.materials[0]
    assert isinstance(solid, NeoHookean)
    return _change_model(run, materials=(NeoHookean(factor * solid.mu, factor * solid.lam),))


MALFORMED: dict[str, Callable[[Run], Run]] = {
    "a position is NaN": lambda run: _change_state(run, x=_set_first(run.state.x, np.nan)),
    "a velocity is infinite": lambda run: _change_state(run, v=_set_first(run.state.v, np.inf)),
    "F is NaN": lambda run: _change_state(run, F=_set_first(run.state.F, np.nan)),
    "F is singular": lambda run: _change_state(run, F=_set_first(run.state.F, 0.0)),
    "a particle is outside the domain": lambda run: _change_state(
        run, x=_set_first(run.state.x, -0.3 * SIZE)
    ),
    "a mass is zero": lambda run: _change_model(run, mass=_set_first(run.model.mass, 0.0)),
    "a mass is negative": lambda run: _change_model(run, mass=_set_first(run.model.mass, -DENSITY)),
    "a volume is zero": lambda run: _change_model(run, volume=_set_first(run.model.volume, 0.0)),
    "a volume is negative": lambda run: _change_model(run, volume=_set_first(run.model.volume, -1e-5)),
    "gravity is NaN": lambda run: _change_model(run, gravity=run.model.gravity * np.nan),
    "E is NaN": lambda run: _scale_stiffness(run, np.nan),
    "E is negative": lambda run: _scale_stiffness(run, -1.0),
    "E is infinite": lambda run: _scale_stiffness(run, np.inf),
    "arrays of different lengths": lambda run: _change_model(run, mass=run.model.mass[:-1]),
    "fewer materials than particles": lambda run: _change_model(
        run, materials=jax.tree.map(lambda leaf: leaf[:-1], run.model.materials)
    ),
    "a negative substep": lambda run: dataclasses.replace(run, options=dict(substep_dt=-1e-4)),
    "a safety of two": lambda run: dataclasses.replace(run, options=dict(safety=2.0)),
    "a safety of zero": lambda run: dataclasses.replace(run, options=dict(safety=0.0)),
    "faster than a thousand cells per step": lambda run: _change_state(run, v=_set_first(run.state.v, 1e7)),
}
