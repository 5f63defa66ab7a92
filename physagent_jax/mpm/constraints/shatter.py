"""Matter that is in fragments from a moment on, each of them rigid and on its own way."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.constraints.rigid import RigidBody, RigidMotion
from physagent_jax.mpm.fields import END, FOREVER, HELD, START
from physagent_jax.mpm.linalg import cross, matmul, skew
from physagent_jax.mpm.pieces import place_seeds
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.transfer import Stencil, find_walls

_CORNERS = 96  # of a fragment, at which it meets boundaries
_CLOCK = 0.25  # of a substep, by which the clock's round-off is far less
_SEED = 11
_ALONG, _UP = (
    (0.5, 1.4),
    (0.1, 0.5),
)  # speeds along the ground and upwards, over that of the burst, least and most
_ASTRAY = 0.5  # of the way along the ground that is chance: what lies over the middle has to go somewhere
_SPIN = 1.2  # [rad] by which a fragment turns as it goes as far as the object reaches, at most
_RESTITUTION = 0.2
_FALLS_ON = 0.3  # share of the speed downwards that a fragment keeps


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Shatter(Constraint):
    """Breaks the particles into fragments, which fly away from the place that the object stands on or hits.

    From ``start`` on each fragment is a rigid body of its own. Boundaries oppose it as they do a `RigidBody`, at its
    corners; fragments pass through each other. Through a grid those that touch would cling together. What else acts on
    the particles is felt by each fragment, where there is no grid (`mpm.gridless`); with one, gravity alone is.

    Attributes:
        particles: Indices of the particles fragment by fragment, the corners first, int32, shape (fragments x k,);
            one beyond the last particle stands for none.
        along: Velocity along the ground over that of the burst, less that from the middle outwards, shape
            (fragments, 3).
        outwards: The same from the middle of the ground that it stands on outwards, shape (fragments,).
        up: The same upwards, shape (fragments, 3).
        spin: Angular velocity [rad/s], shape (fragments, 3).
        speed: Speed of the burst [m/s], scalar.
        way: Unit vector upwards, shape (3,).
        start: When it breaks [s], scalar.
        end: When nothing of it acts any more [s], static.
    """

    particles: jax.Array = dataclasses.field(metadata=HELD)
    along: jax.Array
    outwards: jax.Array
    up: jax.Array
    spin: jax.Array
    speed: jax.Array
    way: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: float = dataclasses.field(default=FOREVER, metadata={**END, "static": True})

    @staticmethod
    def of(x: np.ndarray, count: int, way: np.ndarray, speed: jax.Array, start: jax.Array) -> Shatter:
        """The fragments of what is at ``x`` [m], shape (n, 3), and their chances.

        Args:
            x: Places at rest.
            count: Number of fragments.
            way: Unit vector upwards, shape (3,).
            speed: Speed of the burst [m/s], scalar.
            start: When it breaks [s], scalar.
        """
        chance, dtype = np.random.default_rng(_SEED), speed.dtype
        labels = np.asarray(KDTree(place_seeds(x, min(count, len(x)))).query(x)[1])
        rows = [_put_corners_first(x, np.flatnonzero(labels == each)) for each in np.unique(labels)]
        width = max(map(len, rows))
        particles = np.full((len(rows), width), len(x), np.int32)
        for row, own in zip(particles, rows):
            row[: len(own)] = own
        astray = chance.normal(size=(len(rows), 3))
        astray -= np.outer(astray @ way, way)
        astray /= np.maximum(np.linalg.norm(astray, axis=1, keepdims=True), 1e-9)
        level, rise = (chance.uniform(*each, size=(len(rows), 1)) for each in (_ALONG, _UP))
        turns = chance.normal(size=(len(rows), 3)) * _SPIN / np.ptp(x, axis=0).max()
        numbers = (_ASTRAY * level * astray, (1 - _ASTRAY) * level[:, 0], rise * way, turns, way)
        along, outwards, up, spin, upwards = (jnp.asarray(each, dtype) for each in numbers)
        owners = jnp.asarray(particles.ravel())
        return Shatter(owners, along, outwards, up, spin * speed, speed, upwards, start)

    def is_broken(self, time: jax.Array, dt: jax.Array) -> jax.Array:
        """Return whether it is in fragments during the substep ``dt`` [s] that begins at ``time`` [s]."""
        return time + _CLOCK * dt >= self.start

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Leave the grid as it is: fragments do not go by it."""
        del model, free, node_mass, s, time
        return velocity

    def after_g2p(self, model: Model, before: State, after: State) -> State:
        """Put the fragments where they have gone under gravity."""
        fall = 0.0 if model.gravity is None else model.dt * model.gravity
        moved = self.move(model, before, dataclasses.replace(before, v=before.v + fall))
        broken = self.is_broken(before.time, model.dt)
        put = {
            name: jnp.where(broken, getattr(moved, name), getattr(after, name))
            for name in ("x", "v", "C", "F")
        }
        return dataclasses.replace(after, **put)

    def move(self, model: Model, state: State, forced: State) -> State:
        """The state after a substep with every fragment moved.

        Args:
            model: Its boundaries act.
            state: At the start.
            forced: The same with the v and C that forces have left.
        """
        solid = tuple(each for each in model.boundaries if each.acts_on_points)
        model, rows = model.replace(boundaries=solid), self.particles.reshape(len(self.along), -1)
        low, high = find_walls(model.wall, model.grid)
        mass = model.mass.at[rows].get(mode="fill", fill_value=0)
        x = state.x[rows]
        held = mass > 0
        foot = jnp.where(held, x @ self.way, jnp.inf).min() * self.way
        middle = (mass[..., None] * x).sum((0, 1)) / mass.sum()
        base = middle + foot - (middle @ self.way) * self.way
        reach = jnp.where(held, jnp.sqrt(((x - base) ** 2).sum(-1)), 0).max()
        bursts = self.is_broken(state.time, model.dt) & ~self.is_broken(state.time - model.dt, model.dt)
        out = (mass[..., None] * (x - base)).sum(1) / mass.sum(1)[:, None]
        out = out - (out @ self.way)[:, None] * self.way
        out = out / jnp.maximum(jnp.sqrt((out**2).sum(-1, keepdims=True)), 0.1 * reach)
        kick = jnp.where(bursts, self.speed * (self.along + self.outwards[:, None] * out + self.up), 0)
        spin = jnp.where(bursts, self.spin, 0)

        def advance(p, mass, x, kick, spin):
            motion = RigidMotion.of(mass, x, forced.v[p], model.grid.dx, forced.C[p])
            falls = jnp.minimum(motion.velocity @ self.way, 0) * self.way
            slowed = jnp.where(bursts, (1 - _FALLS_ON) * falls, 0)
            free = dataclasses.replace(
                motion,
                velocity=motion.velocity - slowed + kick,
                spin=motion.spin + motion.inertia @ spin,
            )
            body = RigidBody(p[:_CORNERS], jnp.asarray(_RESTITUTION, x.dtype), 0.3 * self.speed)
            v, w = body.oppose(model, free, mass[:_CORNERS], x[:_CORNERS], state.time)
            place, turn, turned = dataclasses.replace(free, velocity=v, spin=motion.inertia @ w).advance(
                model.dt
            )
            w = turned.angular_velocity(turn)
            # A fragment stops at the domain's wall as a whole.
            beyond = jnp.where(
                mass[:, None] > 0, jnp.minimum(high - place, 0) + jnp.maximum(low - place, 0), 0
            )
            beyond = beyond.min(0) + beyond.max(0)
            place, velocity = place + beyond, jnp.where(beyond != 0, 0, turned.velocity)
            v = velocity + cross(jnp.broadcast_to(w, turned.r.shape), turned.r)
            C = jnp.broadcast_to(skew(w), (len(p), 3, 3))
            return place, v, C, matmul(turn, forced.F[p])

        moved = jax.vmap(advance)(rows, mass, x, kick, spin)
        put = {
            name: getattr(forced, name).at[self.particles].set(each.reshape(-1, *each.shape[2:]), mode="drop")
            for name, each in zip(("x", "v", "C", "F"), moved)
        }
        return dataclasses.replace(forced, **put)


def _put_corners_first(x: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The indices ``own`` with those first that lie farthest out, each in its direction, `_CORNERS` of them."""
    ways = np.random.default_rng(_SEED).normal(size=(4 * _CORNERS, 3))
    farthest = np.unique((x[own] @ ways.T).argmax(0))
    first = own[farthest[:: -(-len(farthest) // _CORNERS)]]
    return np.concatenate([first, np.setdiff1d(own, first)])
