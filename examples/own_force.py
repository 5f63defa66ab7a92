"""A force of one's own, in a simulation that fits step and grid to the motion: a swarm around a moving point.

Run: python examples/own_force.py
"""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Grid, Model, NeoHookean, State, lame_parameters, simulate


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Leash:
    """A spring from every particle to a point that walks along a circle; `mpm.protocols.BodyForce` says what is needed.

    Attributes:
        center: Center of the circle [m], shape (3,).
        radius: [m].
        rate: Rate of the walk [rad/s].
        stiffness: [1/s^2].
    """

    center: jax.Array
    radius: jax.Array
    rate: jax.Array
    stiffness: jax.Array

    def acceleration(self, x, v, mass, time, dt):
        """[m/s^2], shape (n, 3)."""
        angle = self.rate * (time + dt / 2)
        point = self.center + self.radius * jnp.stack([jnp.cos(angle), jnp.sin(angle), 0 * angle])
        return self.stiffness * (point - x)

    def gradient(self, x, time, dt):
        """d acceleration / d x [1/s^2], shape (3, 3)."""
        return -self.stiffness * jnp.eye(3, dtype=x.dtype)


def main():
    """Return the path of the cube's centre and the exact one of a point on that spring, from rest [m]."""
    axis = np.arange(0.3125, 0.3875, 0.025)
    x = jnp.stack(jnp.meshgrid(axis, axis, axis), -1).reshape(-1, 3) + jnp.array([0.15, 0.15, 0.15])
    count, volume = len(x), 0.025**3
    mu, lam = lame_parameters(1e5, 0.3)
    leash = Leash(jnp.array([0.5, 0.5, 0.5]), jnp.array(0.1), jnp.array(4.0), jnp.array(100.0))
    model = Model(
        Grid.whole(1.0, 20), dt=jnp.array(1e-3), gravity=None, mass=jnp.full(count, 1000 * volume),
        volume=jnp.full(count, volume), materials=(NeoHookean(jnp.full(count, mu), jnp.full(count, lam)),),
        forces=(leash,),
    )  # fmt: skip
    frames = list(simulate(model, State.at_rest(x), frame_count=20, frame_dt=0.02))
    path = np.stack([np.asarray(frame.state.x).mean(0) for frame in frames])
    # x'' = k (c + r (cos wt, sin wt) - x): forced and free oscillation, W = sqrt(k).
    t, W, w = 0.02 * np.arange(20)[:, None], 10.0, 4.0
    amplitude = 0.1 * W**2 / (W**2 - w**2)
    start = path[0] - 0.5
    exact = amplitude * np.hstack([np.cos(w * t), np.sin(w * t), 0 * t])
    exact += (start - amplitude * np.array([1.0, 0, 0])) * np.cos(W * t)
    exact -= amplitude * np.array([0, w / W, 0]) * np.sin(W * t)
    return path, exact + 0.5


if __name__ == "__main__":
    path, exact = main()
    error = np.abs(path - exact).max()
    print(f"largest distance from the exact path: {1000 * error:.2f} mm")
    assert error < 2e-3
