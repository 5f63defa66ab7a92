"""Other numbers put into a compiled scene's model and state, traced or not."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.core.errors import UserError
from physagent_jax.mpm import Model, State
from physagent_jax.mpm.materials import FixedCorotated, Hencky, NeoHookean
from physagent_jax.mpm.numbers import cast, put_numbers
from physagent_jax.mpm.step import kirchhoff_stress
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.materials import ParticleMaterials
from physagent_jax.scene.compile.origins import Origins
from physagent_jax.scene.parameters import MaterialParameters, SceneParameters

_ROUNDS = 16  # in which stretches are found that have the stresses
_MOST_STRAIN = 0.2  # by which such a round may change any stretch


def put_materials(
    model: Model,
    state: State,
    materials: ParticleMaterials,
    origins: Origins,
    parameters: SceneParameters,
    volume: np.ndarray,
) -> tuple[ParticleMaterials, Model]:
    """``model`` with other materials, and who has which.

    Args:
        model: Model of the scene.
        state: For its precision.
        materials: Who has which.
        origins: Where its constraints came from.
        parameters: Those of materials are looked at.
        volume: Rest volumes of the particles [m^3], shape (n,).

    Raises:
        UserError: A number is neither a scalar nor one per particle, or a body has several coefficients of
            restitution.
    """
    given = [{} if each is None else each.get_given() for each in parameters.materials]
    names = {name for each in given for name in each}
    if not names:
        return materials, model
    materials = materials.with_numbers(given, state.x.dtype)
    changes: dict[str, Any] = {}
    if "density" in names:
        changes["mass"] = materials.leaf(materials.density * volume)
    if "viscosity" in names:
        known = np.asarray(model.viscosity, np.float64)
        own = tuple(
            {"viscosity": known[materials.choice == index][0]} if (materials.choice == index).any() else {}
            for index in range(len(materials.choices))
        )
        made = materials.with_numbers(own, state.x.dtype).with_numbers(materials.numbers, state.x.dtype)
        changes["viscosity"] = made.leaf(made.get_values("viscosity"))
    if names - {"density", "viscosity", "restitution"}:
        changes["materials"] = materials.build_materials()
    if "restitution" in names:
        model = origins.replace(
            model, bodies=_put_restitution(model, state, materials, origins, parameters.materials)
        )
    return materials, model.replace(**changes)


def _put_restitution(
    model: Model,
    state: State,
    materials: ParticleMaterials,
    origins: Origins,
    given: tuple[MaterialParameters | None, ...],
) -> tuple[Any, ...]:
    """The model's rigid bodies with other coefficients of restitution."""
    bodies = list(origins.split_constraints(model)[0])
    for place, (index, _) in enumerate(materials.find_rigid_bodies()):
        numbers = given[index]
        if numbers is None or numbers.restitution is None:
            continue
        if np.shape(numbers.restitution) != ():
            raise UserError("A body has one coefficient of restitution", got=np.shape(numbers.restitution))
        bodies[place] = dataclasses.replace(
            bodies[place], restitution=cast(numbers.restitution, state.x.dtype)
        )
    return tuple(bodies)


def put_own(
    model: Model,
    state: State,
    origins: Origins,
    config: c.SceneConfig,
    parameters: SceneParameters,
    mass: jax.Array,
) -> Model:
    """``model`` with other numbers in the scene's own force terms, constraints and boundaries.

    Args:
        model: With its new masses.
        state: For its precision.
        origins: Where its forces and constraints came from.
        config: The scene.
        parameters: What is put in.
        mass: Before [kg], shape (n,): a force per particle gives a heavier one less.
    """
    dtype = state.x.dtype
    _, own, impulses = origins.split_forces(model)
    motions = origins.split_constraints(model)[2]
    if parameters.forces:
        own = tuple(put_numbers(part, given, dtype) for part, given in zip(own, parameters.forces))
    if model.mass is not mass:
        impulsive = [each for each in config.constraints if isinstance(each, c.ParticleImpulse)]
        impulses = tuple(
            part
            if each.force is None
            else dataclasses.replace(part, weight=part.weight * (mass / model.mass))
            for part, each in zip(impulses, impulsive)
        )
    if parameters.constraints:
        kinds = [isinstance(each, c.ParticleImpulse) for each in config.constraints]
        pools = {True: iter(impulses), False: iter(motions)}
        made = [
            (kind, put_numbers(next(pools[kind]), given, dtype))
            for kind, given in zip(kinds, parameters.constraints)
        ]
        impulses, motions = (tuple(part for kind, part in made if kind is wanted) for wanted in (True, False))
    if parameters.friction:
        boundaries = tuple(
            part if given is None else dataclasses.replace(part, friction=cast(given, dtype))
            for part, given in zip(model.boundaries, parameters.friction)
        )
        model = model.replace(boundaries=boundaries)
    return origins.replace(model, terms=own, impulses=impulses, motions=motions)


def put_rest(model: Model, state: State, parameters: SceneParameters) -> tuple[Model, State]:
    """``model`` and ``state`` with another gravity, drag and velocity.

    Raises:
        UserError: The velocity is of the wrong shape.
    """
    dtype = state.x.dtype
    if parameters.gravity is not None:
        model = model.replace(gravity=cast(parameters.gravity, dtype))
    if parameters.damping_rate is not None:
        model = model.replace(damping_rate=cast(parameters.damping_rate, dtype))
    if (velocity := parameters.velocity) is not None:
        if np.shape(velocity) not in ((3,), state.v.shape):
            raise UserError(
                f"`parameters.velocity` must have the shape (3,) or {state.v.shape}", got=np.shape(velocity)
            )
        if isinstance(velocity, Tracer):
            v = jnp.broadcast_to(velocity, state.v.shape)
        else:
            v = np.broadcast_to(np.asarray(velocity), state.v.shape)
        state = dataclasses.replace(state, v=cast(v, dtype))
    return model, state


def keep_balance(before: Model, after: Model, state: State) -> State:
    """``state`` with the stretches with which other laws bear the weight that there is now.

    The stress of a body in equilibrium depends on its weight and not on its stiffness: it is scaled by the density and
    by gravity's length along its old way, and each particle gets the stretch with which its law has that stress. That
    is exact for one material; a gravity that turns, or densities in another proportion, need a scene compiled anew.

    Args:
        before: In which ``state`` is in equilibrium.
        after: With other materials, masses or gravity.
        state: The state of elastic matter (`scene.compile.equilibrium`).
    """
    elastic = all(isinstance(law, NeoHookean | FixedCorotated | Hencky) for law in before.materials)
    if not elastic or all(map(_is_same, *map(jax.tree.leaves, map(_list_loads, (before, after))))):
        return state
    return dataclasses.replace(state, F=_find_stretches(before, after, state))


@jax.jit
def _find_stretches(before: Model, after: Model, state: State) -> jax.Array:
    assert before.gravity is not None and after.gravity is not None
    length = (after.gravity @ before.gravity) / (before.gravity @ before.gravity)
    weight = length * after.mass / before.mass
    wanted = weight[:, None, None] * kirchhoff_stress(before, state)
    mu, lam = (_join(after, name)[:, None, None] for name in ("mu", "lam"))
    identity = jnp.eye(3, dtype=state.F.dtype)

    def approach(F, _):
        missing = wanted - kirchhoff_stress(after, dataclasses.replace(state, F=F))
        pressure = jnp.trace(missing, axis1=1, axis2=2)[:, None, None] * identity
        strain = (missing - lam / (3 * lam + 2 * mu) * pressure) / (2 * mu)
        largest = jax.lax.stop_gradient(jnp.abs(strain).max((1, 2), keepdims=True))
        strain = strain * jnp.minimum(1.0, _MOST_STRAIN / jnp.maximum(largest, 1e-12))
        return F + jnp.einsum("nij,njk->nik", strain, F, precision=jax.lax.Precision.HIGHEST), None

    return jax.lax.scan(approach, state.F, None, length=_ROUNDS)[0]


def _list_loads(model: Model) -> tuple[Any, ...]:
    return model.materials, model.mass, model.gravity


def _is_same(one: jax.Array, other: jax.Array) -> bool:
    traced = isinstance(one, Tracer) or isinstance(other, Tracer)
    return one is other or (not traced and np.array_equal(one, other))


def _join(model: Model, name: str) -> jax.Array:
    laws: list[Any] = list(model.materials)
    return jnp.concatenate([jnp.broadcast_to(getattr(law, name), (law.count,)) for law in laws])
