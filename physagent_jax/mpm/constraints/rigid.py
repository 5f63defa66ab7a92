"""Particles that move as one rigid body and exchange momentum with everything else through the grid."""

from __future__ import annotations

import dataclasses
import math
from functools import reduce
from operator import add

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.contact import TOUCH, Points
from physagent_jax.mpm.constraints.rotation import rotate, rotation_matrix
from physagent_jax.mpm.fields import HELD
from physagent_jax.mpm.linalg import cofactor, cross, determinant, matmul, matvec, skew, transpose
from physagent_jax.mpm.protocols import Boundary, Constraint
from physagent_jax.mpm.reductions import sum_devices
from physagent_jax.mpm.state import Grid, Model, State
from physagent_jax.mpm.transfer import Stencil, scatter_mass

CONTACT_ITERATIONS = 16
MOST_POINTS = 2048
"""Points in contact that the iterations are over: more say nothing else of a rigid body, and take ten times as long."""
REACH = 0.25 + TOUCH  # [cells] from a particle to the surface of its matter, of which a cell holds 2 x 2 x 2
_LEAST_LOAD = 1e-9  # share of the mass; less is nothing
_LEAST_INERTIA = 1e-3  # determinant, over the mass and dx^2; a lone particle's nodes have 1/8


def _list_momenta(count: int) -> np.ndarray:
    """The momentum of each step of the accelerated descent (Beck & Teboulle 2009, section 4)."""
    t = [1.0]
    for _ in range(count):
        t.append(0.5 * (1 + math.sqrt(1 + 4 * t[-1] ** 2)))
    return np.array([(now - 1) / after for now, after in zip(t, t[1:])])


_MOMENTA = _list_momenta(CONTACT_ITERATIONS)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class RigidMotion:
    """The rigid motion with the momenta of some masses.

    Attributes:
        share: Share of each point in the mass, shape (k,).
        r: Points relative to the centre of mass [m], shape (k, 3).
        center: Centre of mass [m], shape (3,).
        velocity: Velocity of the centre [m/s], shape (3,).
        spin: Angular momentum about the centre over the mass and dx^2 [rad/s], shape (3,).
        inertia: About the centre over the mass and dx^2, shape (3, 3).
        dx: [m], static.
    """

    share: jax.Array
    r: jax.Array
    center: jax.Array
    velocity: jax.Array
    spin: jax.Array
    inertia: jax.Array
    dx: float = dataclasses.field(metadata=dict(static=True))

    @staticmethod
    def of(
        mass: jax.Array,
        x: jax.Array,
        v: jax.Array,
        dx: float,
        C: jax.Array | None = None,
        axis: str | None = None,
    ) -> RigidMotion:
        """The motion of points of ``mass`` (k,) [kg] at ``x`` [m] with ``v`` [m/s], shapes (k, 3).

        With ``C`` [1/s], shape (k, 3, 3), they are APIC particles: each has the angular momentum m dx^2/4
        axial(C) (Jiang et al. 2015) and the moment of inertia m dx^2/2 about every axis of its own.
        With ``axis`` the points are split over the devices along it.
        """
        whole = sum_devices(mass.sum(), axis)
        share = mass / jnp.where(whole > 0, whole, 1)
        center = _average(share, x, axis)
        r = x - center
        # In units of dx^2 the inertia is of order one: in single precision its determinant cannot underflow.
        outer = sum_devices((share[:, None, None] / dx**2 * r[:, :, None] * r[:, None, :]).sum(0), axis)
        own = 0.0 if C is None else 0.5
        inertia = (outer[0, 0] + outer[1, 1] + outer[2, 2] + own) * jnp.eye(3, dtype=x.dtype) - outer
        spin = _average(share, cross(r, v), axis) / dx**2
        if C is not None:
            axial = [C[:, 2, 1] - C[:, 1, 2], C[:, 0, 2] - C[:, 2, 0], C[:, 1, 0] - C[:, 0, 1]]
            spin = spin + _average(share, jnp.stack(axial, axis=-1), axis) / 4
        return RigidMotion(share, r, center, _average(share, v, axis), spin, inertia, dx)

    def angular_velocity(self, turn: jax.Array | None = None) -> jax.Array:
        """The angular velocity [rad/s] that has this spin, after the body has turned by ``turn`` (3, 3)."""
        if turn is None:
            return matvec(self.invert_inertia(), self.spin)
        return matvec(turn, matvec(self.invert_inertia(), matvec(transpose(turn), self.spin)))

    def invert_inertia(self) -> jax.Array:
        """Inverse of the inertia, shape (3, 3); zero for one too small to be inverted."""
        firm = self.is_determined()
        return jnp.where(firm, cofactor(self.inertia) / jnp.where(firm, determinant(self.inertia), 1), 0)

    def is_determined(self) -> jax.Array:
        """Return whether the inertia can be inverted."""
        return determinant(self.inertia) > _LEAST_INERTIA

    def advance(self, dt: jax.Array) -> tuple[jax.Array, jax.Array, RigidMotion]:
        """Places of the points after ``dt`` [s], shape (k, 3), the turn, shape (3, 3), and the motion about it.

        It turns with the angular velocity half a turn ahead, and keeps its spin.
        """
        halfway = rotation_matrix(0.5 * dt * self.angular_velocity())
        vector = dt * self.angular_velocity(halfway)
        r = rotate(self.r, vector)
        x = self.center + dt * self.velocity + r
        return x, rotation_matrix(vector), dataclasses.replace(self, r=r)

    def field(self, velocity: jax.Array, angular_velocity: jax.Array) -> jax.Array:
        """v + w x r at the points [m/s], shape (k, 3)."""
        return velocity + cross(jnp.broadcast_to(angular_velocity, self.r.shape), self.r)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class RigidBody(Constraint):
    """Makes some particles move as one rigid body.

    Before P2G, on the nodes that carry mostly its mass, and after G2P, velocities are replaced by the rigid
    field of equal linear and angular momentum: what the body gains others lose, exactly. The nodes in between
    let it rest on soft matter without creeping into it. Against boundaries, which give way to nothing, its rigid
    motion is corrected by descent until no point of it moves into a solid; every correction is an impulse that
    the boundaries' own contact law gives, so that Coulomb's law holds at each. The points are its
    particles: nodes would feel it from 1.5 cells away, and leave a gap that is seen. A boundary that is tied to
    the grid (`Boundary.acts_on_points`) has those nodes instead.

    The body turns by exp(dt w) with w taken half a turn ahead (the explicit midpoint rule for Euler's equations:
    second order, and exact about a principal axis), and its spin is carried over unchanged: the angular
    momentum is kept exactly, the energy of a tumbling body to second order. Distances between the particles and
    F^T F never change but by round-off.

    A body that rebounds is given the impulses of the boundaries once more, times the coefficient of restitution
    (Poisson's hypothesis: Routh 1905, article 179), which keeps Coulomb's law.

    A body that is all there is (``whole``) needs no grid, and nothing is computed on one: see `mpm.gridless`.

    Attributes:
        particles: Indices, int32, shape (k,); one beyond the last particle stands for none. A body may be a
            single particle.
        restitution: Coefficient of restitution against boundaries [1], scalar; None = 0.
        least_speed: Change of the centre's velocity in a substep, in an impact without rebound, below which there is
            none: what rests would rock [m/s], scalar.
        whole: Whether it is made of all particles, static.
    """

    particles: jax.Array = dataclasses.field(metadata=HELD)
    restitution: jax.Array | None = None
    least_speed: jax.Array | float = 0.0
    whole: bool = dataclasses.field(default=False, metadata=dict(static=True))

    def before_p2g(self, model: Model, state: State) -> State:
        """Replace v and C by the rigid field of equal momenta."""
        motion = self._measure_motion(model, state)
        return self._set_motion(state, motion, motion.velocity, motion.angular_velocity())

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Make the nodes more than half of whose mass is the body's move rigidly."""
        grid, p = model.grid, self.particles
        share = scatter_mass(s.take(p), grid, self._gather_mass(model))
        owned = (sum_devices(share, model.axis) > 0.5 * node_mass).ravel()
        nodes = grid.place_nodes(free.dtype).reshape(-1, 3)
        mass = jnp.where(owned, node_mass.ravel(), 0)
        motion = RigidMotion.of(mass, nodes, free.reshape(-1, 3), grid.dx)
        v, w = self.oppose(model, motion, self._gather_mass(model), s.take(p).place_particles(grid), time)
        rigid = jnp.where(
            (owned & motion.is_determined())[:, None], motion.field(v, w), velocity.reshape(-1, 3)
        )
        return rigid.reshape(velocity.shape)

    def after_g2p(self, model: Model, before: State, after: State) -> State:
        """Move the body as a whole, with the momenta that its particles gathered."""
        p = self.particles
        motion = self._measure_motion(model, dataclasses.replace(after, x=before.x))
        x, turn, turned = motion.advance(model.dt)
        F = matmul(turn, before.F[p])
        moved = dataclasses.replace(after, x=after.x.at[p].set(x), F=after.F.at[p].set(F))
        return self._set_motion(moved, turned, motion.velocity, motion.angular_velocity(turn))

    def oppose(
        self, model: Model, motion: RigidMotion, mass: jax.Array, x: jax.Array, time: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """Velocity of the centre [m/s] and angular velocity [rad/s] after the boundaries, shapes (3,).

        Args:
            model: Its boundaries act.
            motion: Motion of the body, or of the nodes that are its own.
            mass: Masses of its particles [kg], shape (k,).
            x: Places of its particles [m], shape (k, 3).
            time: [s].
        """
        free = motion.velocity, motion.angular_velocity()
        if not model.boundaries:
            return free
        after = _project_on_boundaries(model, motion, mass, x, free, time)
        return after if self.restitution is None else self._rebound(free, after)

    def _rebound(
        self, before: tuple[jax.Array, jax.Array], after: tuple[jax.Array, jax.Array]
    ) -> tuple[jax.Array, jax.Array]:
        """Velocity of the centre and angular velocity with the impulses between ``before`` and ``after`` once more."""
        hit = ((after[0] - before[0]) ** 2).sum() > self.least_speed**2
        share = jnp.where(hit, 0.0 if self.restitution is None else self.restitution, 0)
        return after[0] + share * (after[0] - before[0]), after[1] + share * (after[1] - before[1])

    def _measure_motion(self, model: Model, state: State) -> RigidMotion:
        p, dx = self.particles, model.grid.dx
        return RigidMotion.of(self._gather_mass(model), state.x[p], state.v[p], dx, state.C[p], model.axis)

    def _gather_mass(self, model: Model) -> jax.Array:
        """[kg], shape (k,); zero where an index stands for no particle."""
        return model.mass.at[self.particles].get(mode="fill", fill_value=0)

    def _set_motion(
        self, state: State, motion: RigidMotion, velocity: jax.Array, angular: jax.Array
    ) -> State:
        """``state`` with the particles' v and C set to a rigid motion."""
        p = self.particles
        C = jnp.broadcast_to(skew(angular), (len(p), 3, 3))
        return dataclasses.replace(
            state, v=state.v.at[p].set(motion.field(velocity, angular)), C=state.C.at[p].set(C)
        )


def _project_on_boundaries(
    model: Model,
    motion: RigidMotion,
    mass: jax.Array,
    x: jax.Array,
    unopposed: tuple[jax.Array, jax.Array],
    time: jax.Array,
) -> tuple[jax.Array, jax.Array]:
    """The rigid motion after contact with the boundaries, by accelerated projected gradients (Beck & Teboulle 2009).

    With p the velocity change that a point has been given so far and s the step, its next one is s (B(v - p / s) -
    v + p / s), B the boundary's law: what is given in excess is taken back, so that what rests does not rock.

    Args:
        model: Its boundaries act.
        motion: Rigid motion of the body's nodes.
        mass: Masses of its particles [kg], shape (k,).
        x: Places of its particles [m], shape (k, 3).
        unopposed: Velocity of the centre [m/s] and angular velocity [rad/s], shapes (3,).
        time: [s].
    """
    grid, tiny = model.grid, jnp.finfo(mass.dtype).tiny
    own = mass / jnp.maximum(sum_devices(mass.sum(), model.axis), tiny)
    carried = dataclasses.replace(motion, share=own, r=x - motion.center)
    ahead = x + model.dt * carried.field(*unopposed)  # what rests would lose touch else
    points = Points(ahead, REACH * grid.dx, grid)
    sides = (
        _Side(grid, motion, [each for each in model.boundaries if not each.acts_on_points], None),
        _Side(points, carried, [each for each in model.boundaries if each.acts_on_points], model.axis),
    )
    sides = [side.choose_touched(unopposed, time) for side in sides if side.boundaries]
    inverse = motion.invert_inertia() / grid.dx**2

    def respond(changes):
        pushed = reduce(add, (side.sum_momenta(each) for side, each in zip(sides, changes)))
        return unopposed[0] + pushed[0], unopposed[1] + matvec(inverse, _find_axial(pushed[1:]))

    def descend(now, momentum):
        changes, ahead = now
        after = respond(ahead)
        new = [
            size * side.oppose(side.body.field(*after) - each / size, time)
            for side, each in zip(sides, ahead)
        ]
        return (new, [n + momentum * (n - old) for n, old in zip(new, changes)]), None

    size = 1 / jnp.maximum(sum(side.measure_load() for side in sides), _LEAST_LOAD)
    still = [jnp.zeros_like(side.body.r) for side in sides]
    return respond(jax.lax.scan(descend, (still, still), _MOMENTA.astype(x.dtype))[0][0])


@dataclasses.dataclass(frozen=True)
class _Side:
    """Places of a rigid body, and the boundaries that act there.

    Attributes:
        places: The places, as boundaries take them.
        body: The body's motion at them.
        boundaries: The boundaries.
        axis: Axis of the devices that they are split over; None = all have them all.
    """

    places: Grid | Points
    body: RigidMotion
    boundaries: list[Boundary]
    axis: str | None

    def sum_momenta(self, changes: jax.Array) -> jax.Array:
        """The momentum of velocity changes [m/s], over the body's mass, and its first moments [m], shape (4, 3)."""
        places = jnp.concatenate([jnp.ones_like(self.body.r[:, :1]), self.body.r], axis=1)
        return sum_devices((self.body.share[:, None] * places).T @ changes, self.axis)

    def oppose(self, field: jax.Array, time: jax.Array) -> jax.Array:
        """Velocity changes by the boundaries [m/s], shape (k, 3)."""
        wanted = field.reshape(*self.places.shape, 3)
        for boundary in self.boundaries:
            wanted = boundary.apply(wanted, self.places, time)  # type: ignore[arg-type]
        return jnp.where(self.body.share[:, None] > 0, wanted.reshape(-1, 3) - field, 0)

    def choose_touched(self, motion: tuple[jax.Array, jax.Array], time: jax.Array) -> _Side:
        """The same without mass where nothing is touched; of points, the touched ones alone, and `MOST_POINTS` of them.

        If more are touched, they are chosen evenly in the order in memory, which is that of cells.
        """
        body, field = self.body, self.body.field(*motion)
        touched = ((self.oppose(field, time) != 0) | (self.oppose(-field, time) != 0)).any(1)
        share = jnp.where(touched, body.share, 0)
        if not isinstance(self.places, Points) or len(touched) <= MOST_POINTS:
            return dataclasses.replace(self, body=dataclasses.replace(body, share=share))
        rank = jnp.cumsum(touched, dtype=jnp.int32)
        stride = jnp.maximum(rank[-1] / MOST_POINTS, 1)
        chosen = jnp.searchsorted(rank, 1 + (stride * jnp.arange(MOST_POINTS)).astype(jnp.int32))
        share, r, x = (
            each.at[chosen].get(mode="fill", fill_value=0) for each in (share, body.r, self.places.x)
        )
        places = dataclasses.replace(self.places, x=x)
        return dataclasses.replace(self, places=places, body=dataclasses.replace(body, share=share, r=r))

    def measure_load(self) -> jax.Array:
        """Bound of the velocity that all touched places together give each of them, over what they are given [1]."""
        body, inverse = self.body, self.body.invert_inertia() / self.body.dx**2
        turned = (body.r**2).sum(1) * jnp.trace(inverse) - (matvec(inverse, body.r) * body.r).sum(1)
        return sum_devices((body.share * (1 + turned)).sum(), self.axis)


def _find_axial(moments: jax.Array) -> jax.Array:
    """The sum of r x p, shape (3,), from that of the products r_i p_j, shape (3, 3)."""
    return jnp.stack([moments[i, j] - moments[j, i] for i, j in ((1, 2), (2, 0), (0, 1))])


def _average(share: jax.Array, values: jax.Array, axis: str | None = None) -> jax.Array:
    return sum_devices((share[:, None] * values).sum(0), axis)
