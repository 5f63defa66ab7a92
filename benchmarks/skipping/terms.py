"""Terms that a scene does not have, and terms whose time window is closed."""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
import numpy as np

from benchmarks.skipping.base import Pair, Sizes, Skip
from benchmarks.skipping.scene import SIDE, SIZE, both, changed, cube
from physagent_jax.forces.envelope import FOREVER, Envelope
from physagent_jax.forces.terms import Turbulence, UniformAcceleration, Wind
from physagent_jax.mpm import Contact, Fluid, HalfSpace, Model, PrescribedMotion
from physagent_jax.mpm import State as Particles
from physagent_jax.mpm.plan import find_acting

TINY = 1e-30  # of a rate or share: present in the program, without effect in float32
_BOTTOM = 0.5 * (SIZE - SIDE)  # of the cube [m]
_OVER, _TO_COME = (-2.0, -1.0), (1e3, 2e3)  # windows [s]; the run takes place in between


def _to_scalar(value: float):
    return jnp.asarray(value, jnp.float32)


def _make_plane(height: float, start: float = -FOREVER, end: float = FOREVER, velocity=None) -> HalfSpace:
    """A floor at ``height`` [m] that separates, with friction."""
    return HalfSpace(
        point=jnp.asarray([0.0, 0.0, height], jnp.float32),
        normal=jnp.asarray([0.0, 0.0, 1.0], jnp.float32),
        friction=_to_scalar(0.3),
        start=_to_scalar(start),
        end=_to_scalar(end),
        contact=Contact.SEPARATE,
        velocity=velocity,
    )


def _remove_weight(model: Model, state: Particles) -> Model:
    del state
    return model.replace(gravity=jnp.zeros(3, jnp.float32))


def _remove_forces(model: Model, state: Particles) -> Model:
    del state
    zero = jnp.zeros(3, jnp.float32)
    return model.replace(forces=(UniformAcceleration(zero, _to_scalar(-FOREVER), _to_scalar(FOREVER)),))


def _remove_damping(model: Model, state: Particles) -> Model:
    del state
    return model.replace(damping_rate=TINY)


def _remove_blending(model: Model, state: Particles) -> Model:
    del state
    return model.replace(rpic_damping=TINY)


def _put_out_of_reach(model: Model, state: Particles) -> Model:
    del state
    return model.replace(boundaries=(_make_plane(-1.0),))


def _remove_viscosity(model: Model, state: Particles) -> Model:
    del state
    return model.replace(viscosity=jnp.zeros_like(model.mass))


def _compare_floor_at_rest(sizes: Sizes) -> Pair:
    model, state = cube(sizes)
    resting = _make_plane(_BOTTOM + 0.1)
    moving = _make_plane(_BOTTOM + 0.1, velocity=jnp.zeros(3, jnp.float32))
    return both(model.replace(boundaries=(resting,)), model.replace(boundaries=(moving,)), state, sizes)


def _compare_inviscid_fluid(sizes: Sizes) -> Pair:
    model, state = cube(sizes, lambda mu, lam: Fluid(lam, tension=True))
    return both(model, _remove_viscosity(model, state), state, sizes)


def _close_forces(window: tuple[float, float]):
    def change(model: Model, state: Particles) -> Model:
        del state
        closed = Envelope.constant(*map(_to_scalar, window))
        direction = jnp.asarray([1.0, 0.0, 0.0], jnp.float32)
        strength = dict(strength=_to_scalar(5.0), length_scale=_to_scalar(0.2), time_scale=_to_scalar(0.1))
        gusts = Turbulence.from_seed(0, envelope=closed, **strength)
        wind = Wind(direction, _to_scalar(3.0), _to_scalar(1.0), _to_scalar(0.1), closed)
        return model.replace(forces=(wind, gusts))

    return change


def _close_floor(model: Model, state: Particles) -> Model:
    del state
    return model.replace(boundaries=(_make_plane(_BOTTOM + 0.1, *_TO_COME),))


def _close_grip(model: Model, state: Particles) -> Model:
    """Hold the lowest tenth of the cube, before the run begins."""
    low = np.flatnonzero(np.asarray(state.x[:, 2]) < _BOTTOM + 0.1 * SIDE)
    still = jnp.zeros(3, jnp.float32)
    grip = PrescribedMotion(jnp.asarray(low, jnp.int32), still, still, still, *map(_to_scalar, _OVER))
    return model.replace(constraints=(grip,))


def _compare_closed(change: Callable[[Model, Particles], Model]) -> Callable[[Sizes], Pair]:
    """The cube with what `mpm.simulate` keeps of a change in the first second, against all of it."""

    def build(sizes: Sizes) -> Pair:
        model, state = cube(sizes)
        whole = change(model, state)
        return both(find_acting(whole, 0.0, 1.0).select(whole), whole, state, sizes)

    return build


_ALWAYS = "in every substep, and dropped"

SKIPS = (
    Skip("gravity", "the gravity term, where there is none", "gravity of zero", changed(_remove_weight)),
    Skip("forces", "force terms, where there are none", "a uniform force of zero", changed(_remove_forces)),
    Skip(
        "damping",
        "the global damping of grid velocities, where there is none",
        f"a damping rate of {TINY:g} 1/s",
        changed(_remove_damping),
    ),
    Skip(
        "rpic blend",
        "the blend of APIC and RPIC, where it is all APIC",
        f"an RPIC share of {TINY:g}",
        changed(_remove_blending),
    ),
    Skip(
        "boundaries",
        "obstacles, where there are none",
        "a floor with friction far below, which touches nothing",
        changed(_put_out_of_reach),
    ),
    Skip(
        "obstacle at rest",
        "the change to an obstacle's frame and back, where it rests",
        "a floor in contact that moves at 0 m/s",
        _compare_floor_at_rest,
    ),
    Skip(
        "viscosity of a solid",
        "the viscous stress, where there is none; neo-Hookean matter makes it inside P2G, as its own",
        "a viscosity of 0 Pa s",
        changed(_remove_viscosity),
    ),
    Skip(
        "viscosity of a fluid",
        "the viscous stress, where there is none",
        "a viscosity of 0 Pa s",
        _compare_inviscid_fluid,
    ),
    Skip(
        "forces that are over",
        "force terms (wind, turbulence of 32 modes) whose window has ended",
        f"evaluated {_ALWAYS}",
        _compare_closed(_close_forces(_OVER)),
    ),
    Skip(
        "forces to come",
        "the same before their window begins",
        f"evaluated {_ALWAYS}",
        _compare_closed(_close_forces(_TO_COME)),
    ),
    Skip(
        "obstacle to come",
        "an obstacle before its window begins, though matter is inside it",
        f"contact is computed {_ALWAYS}",
        _compare_closed(_close_floor),
    ),
    Skip(
        "grip that is over",
        "a prescribed motion of a tenth of the particles whose window has ended",
        f"evaluated {_ALWAYS}; and the stress is made anew after it",
        _compare_closed(_close_grip),
    ),
)
