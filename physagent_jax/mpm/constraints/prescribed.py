"""Particles whose motion is prescribed: held fixed, translated, or turned about an axis."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.constraints.rotation import rotate, rotation_matrix
from physagent_jax.mpm.edges import window_value
from physagent_jax.mpm.fields import EDGE, END, HELD, PER_HELD, START
from physagent_jax.mpm.linalg import cross, matmul, skew
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.mpm.reductions import find_mass_centre, sum_devices
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import Stencil, gather_affine, scatter_mass

_CLOCK = 0.25  # of a substep, by which the clock's round-off is far less


@register_dataclass
@dataclasses.dataclass(frozen=True)
class PrescribedMotion(Constraint):
    """A rigid velocity field u(x) = velocity + angular_velocity x (x - center) for some particles.

    It acts on the particles before P2G, on the grid nodes that carry mostly their mass (otherwise the free
    neighbours would drag the shared nodes along, and the clamp would be soft), and on the particles after G2P,
    so that they follow the prescribed path exactly. A window is held against the clock a quarter of a substep
    later, so that round-off decides nothing. With an ``end`` per particle they are let go one by one.

    Attributes:
        particles: Indices, int32, shape (k,); one beyond the last particle stands for none.
        velocity: [m/s], shape (3,), or one after the other in equal parts of the window, shape (parts, 3).
        angular_velocity: [rad/s], shape (3,).
        center: A point of the axis [m], shape (3,); None = the present mean of the particles, which then stays.
        about: Weights of the particles in that mean, shape (k,); None = all count alike, by their mass.
        carried: Whether u comes on top of the mean velocity of the particles that ``about`` weighs, and ``center`` is
            given from their mean place: a limb that swings on what moves. Their own ``end`` is before ``start``.
        turns: How what carries it turns meanwhile, one after the other: angular velocity [rad/s], begin and end [s],
            shape (n, 5); None = it does not turn.
        start, end: Active for start <= time < end [s], scalars or one per particle, shape (k,).
        edge: Width of the window's smooth edges [s], scalar: within them each substep goes a share of the way from the
            free motion to the prescribed one; None = hard.
        share: Share of u that each particle goes with, so that what is one skin bends evenly, shape (k,); None = all.
        rigid: Whether F turns with the motion and nothing in it bends: a piece of its own. What shares nodes with other
            matter would otherwise be strained as that moves away.
        whole: Whether it leads all particles, static.
    """

    particles: jax.Array = dataclasses.field(metadata=HELD)
    velocity: jax.Array
    angular_velocity: jax.Array
    center: jax.Array | None
    start: jax.Array = dataclasses.field(metadata={**PER_HELD, **START})
    end: jax.Array = dataclasses.field(metadata={**PER_HELD, **END})
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)
    share: jax.Array | None = dataclasses.field(default=None, metadata=PER_HELD)
    about: jax.Array | None = dataclasses.field(default=None, metadata=PER_HELD)
    turns: jax.Array | None = None
    rigid: bool = dataclasses.field(default=False, metadata=dict(static=True))
    carried: bool = dataclasses.field(default=False, metadata=dict(static=True))
    whole: bool = dataclasses.field(default=False, metadata=dict(static=True))

    @property
    def leads_as_one(self) -> bool:
        """True if all particles move alike, in the same window."""
        shared = self.share is not None or self.edge is not None or self.carried
        return self.whole and not shared and jnp.ndim(self.start) == jnp.ndim(self.end) == 0

    @staticmethod
    def fixed(particles: jax.Array, dtype=jnp.float32, *, rigid: bool = False) -> PrescribedMotion:
        """Hold ``particles`` where they are, for ever."""
        zero, forever = jnp.zeros(3, dtype), jnp.asarray(jnp.inf, dtype)
        return PrescribedMotion(particles, zero, zero, zero, jnp.zeros((), dtype), forever, rigid=rigid)

    @staticmethod
    def read_clock(time: jax.Array, dt: jax.Array) -> jax.Array:
        """The time that windows are held against [s], a part of a substep ``dt`` after ``time``."""
        return time + _CLOCK * dt

    def active(self, time: jax.Array) -> jax.Array:
        """Return whether each particle is held at ``time`` [s], shape (k,)."""
        return jnp.broadcast_to((self.start <= time) & (time < self.end), self.particles.shape)

    def find_share(self, time: jax.Array) -> jax.Array:
        """The share to which each particle is held at ``time`` [s], in [0, 1], shape (k,); needs an edge."""
        assert self.edge is not None
        return jnp.broadcast_to(window_value(time, self.start, self.end, self.edge), self.particles.shape)

    def locate(self, model: Model, x: jax.Array, time: jax.Array) -> PrescribedMotion:
        """The motion of one velocity and centre that it is at ``time`` [s], with its particles at ``x`` [m], (k, 3)."""
        motion = self
        if self.velocity.ndim > 1:
            parts = len(self.velocity)
            part = jnp.floor(parts * (time - self.start) / (self.end - self.start)).astype(jnp.int32)
            motion = dataclasses.replace(self, velocity=self.velocity[jnp.clip(part, 0, parts - 1)])
        if self.center is not None and not self.carried:
            return motion
        mean = self._average(model, x)
        if self.center is None:
            return dataclasses.replace(motion, center=mean)
        arm, spin, speed = (
            self._turn(each, time) for each in (self.center, motion.angular_velocity, motion.velocity)
        )
        return dataclasses.replace(motion, center=mean + arm, angular_velocity=spin, velocity=speed)

    def find_drift(
        self, model: Model, x: jax.Array, v: jax.Array, time: jax.Array, places: jax.Array | None = None
    ) -> jax.Array:
        """The velocity that u comes on top of [m/s], shape (3,) or that of ``places``, else of ``x``.

        Args:
            model: Its particles have masses.
            x: Places of its particles [m], shape (k, 3).
            v: Their velocities [m/s], shape (k, 3).
            time: [s].
            places: Other places, shape (..., 3) [m].
        """
        if not self.carried:
            return jnp.zeros(3, self.velocity.dtype)
        drift, places = self._average(model, v), x if places is None else places
        if self.turns is None:
            return drift
        spin = jnp.broadcast_to(self._find_spin(time), places.shape)
        return drift + cross(spin, places - self._average(model, x))

    def _find_spin(self, time: jax.Array) -> jax.Array:
        """The angular velocity of what carries it [rad/s], shape (3,)."""
        if self.turns is None:
            return jnp.zeros(3, self.velocity.dtype)
        acts = (self.turns[:, 3:4] <= time) & (time < self.turns[:, 4:])
        return jnp.where(acts, self.turns[:, :3], 0).sum(0)

    def _turn(self, vector: jax.Array, time: jax.Array) -> jax.Array:
        """A vector that goes along with the turns of what carries it, shape (3,)."""
        for turn in () if self.turns is None else self.turns:
            vector = rotate(vector, turn[:3] * jnp.clip(time - turn[3], 0, turn[4] - turn[3]))
        return vector

    def _average(self, model: Model, values: jax.Array) -> jax.Array:
        """The mean of a vector of its particles, shape (3,), by their mass and what ``about`` tells."""
        mass = model.mass.at[self.particles].get(mode="fill", fill_value=0)
        return find_mass_centre(values, mass if self.about is None else self.about * mass, model.axis)

    def field(self, x: jax.Array) -> jax.Array:
        """All of u(x) [m/s], shape (..., 3); the centre must be known (`locate`)."""
        assert self.center is not None
        return self.velocity + cross(jnp.broadcast_to(self.angular_velocity, x.shape), x - self.center)

    def displace(self, x: jax.Array, dt: jax.Array) -> jax.Array:
        """Positions of its particles after ``dt`` [s]: an exact rotation about the axis and a translation."""
        assert self.center is not None
        turn, way = self._divide(self.angular_velocity * dt), self._divide(self.velocity * dt)
        return self.center + rotate(x - self.center, turn) + way

    def _divide(self, value: jax.Array) -> jax.Array:
        """Each particle's share of a vector, shape (k, 3); the vector itself where all go with all of it."""
        return value if self.share is None else self.share[:, None] * value

    def prescribe(self, model: Model, x: jax.Array) -> jax.Array:
        """u(x) of its particles [m/s], as the window begins."""
        places = x.at[self.particles].get(mode="fill", fill_value=0)
        speeds = self._divide(self.locate(model, places, self.start).field(places))
        return jnp.zeros_like(x).at[self.particles].set(speeds)

    def before_p2g(self, model: Model, state: State) -> State:
        """Give the held particles their velocity and velocity gradient."""
        p, clock = self.particles, self.read_clock(state.time, model.dt)
        choose = self._make_choice(clock)
        x, v = state.x[p], state.v[p]
        motion = self.locate(model, x, clock)
        v = choose(self.find_drift(model, x, v, clock) + self._divide(motion.field(x)), v)
        C = choose(skew(self._divide(motion.angular_velocity) + self._find_spin(clock)), state.C[p])
        return dataclasses.replace(state, v=state.v.at[p].set(v), C=state.C.at[p].set(C))

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Impose u on the nodes more than half of whose mass is held."""
        del free
        p = self.particles
        own = s.take(p)
        mass = model.mass.at[p].get(mode="fill", fill_value=0)
        clock = self.read_clock(time, model.dt)
        share = None if self.edge is None else self.find_share(clock)
        active = self.active(clock) if share is None else share > 0
        held = sum_devices(scatter_mass(own, model.grid, jnp.where(active, mass, 0)), model.axis)
        node_mask = held > 0.5 * node_mass
        motion = self.locate(model, own.place_particles(model.grid), clock)
        wanted = motion.field(model.grid.place_nodes(velocity.dtype))
        if self.share is not None:
            led = scatter_mass(own, model.grid, jnp.where(active, self.share * mass, 0))
            wanted = (sum_devices(led, model.axis) / jnp.where(node_mask, held, 1))[..., None] * wanted
        if self.carried:
            speeds, nodes = (
                gather_affine(own, model.grid, velocity)[0],
                model.grid.place_nodes(velocity.dtype),
            )
            places = own.place_particles(model.grid)
            wanted = wanted + self.find_drift(model, places, speeds, clock, nodes)
        if share is not None:
            part = sum_devices(scatter_mass(own, model.grid, share * mass), model.axis)
            wanted = velocity + (part / jnp.where(node_mask, held, 1))[..., None] * (wanted - velocity)
        return jnp.where(node_mask[..., None], wanted, velocity)

    def after_g2p(self, model: Model, before: State, after: State) -> State:
        """Put the held particles exactly where the prescription has them."""
        p, clock = self.particles, self.read_clock(before.time, model.dt)
        choose, motion = self._make_choice(clock), self.locate(model, before.x[p], clock)
        drift = self.find_drift(model, before.x[p], after.v[p], clock)
        own = motion.displace(before.x[p], model.dt)  # its own path; the centre goes along
        x = choose(own + model.dt * drift, after.x[p])
        v = choose(drift + self._divide(motion.field(own)), after.v[p])
        moved = dataclasses.replace(after, x=after.x.at[p].set(x), v=after.v.at[p].set(v))
        if not self.rigid:
            return moved
        spin = self._divide(motion.angular_velocity) + self._find_spin(clock)
        F = choose(matmul(rotation_matrix(spin * model.dt), before.F[p]), after.F[p])
        return dataclasses.replace(moved, F=after.F.at[p].set(F))

    def _make_choice(self, time: jax.Array):
        """A function of the prescribed and the free value, (k, ...), that gives what holds at ``time`` [s]."""
        hard = self.edge is None
        held = self.active(time) if hard else self.find_share(time)

        def choose(prescribed: jax.Array, free: jax.Array) -> jax.Array:
            each = held.reshape(-1, *(1,) * (free.ndim - 1))
            if hard:
                return jnp.where(each, prescribed, free)
            return jnp.where(each < 1, free + each * (prescribed - free), prescribed)

        return choose
