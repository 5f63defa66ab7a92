"""A material of one's own: an energy, its stress, its stiffness. A bar of it swings with the textbook's period.

Run: python examples/own_material.py
"""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Grid, Model, State, rollout
from physagent_jax.mpm.materials.base import Hyperelastic


@register_dataclass
@dataclasses.dataclass(frozen=True)
class SaintVenantKirchhoff(Hyperelastic):
    """psi = mu tr(E^2) + lam/2 (tr E)^2 with Green's strain E = (F^T F - I) / 2. Not for strong compression."""

    mu: jax.Array
    lam: jax.Array

    def energy(self, F, history=()):
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        E = 0.5 * (jnp.einsum("nki,nkj->nij", F, F) - jnp.eye(3, dtype=F.dtype))
        return self.mu * (E**2).sum((1, 2)) + 0.5 * self.lam * jnp.trace(E, axis1=1, axis2=2) ** 2

    def stress(self, F, history=()):
        """Kirchhoff stress [Pa], shape (n, 3, 3): (d psi / d F) F^T, by JAX."""
        slope = jax.grad(lambda F: self.energy(F).sum())(F)
        return jnp.einsum("nij,nkj->nik", slope, F)

    def stiffness(self, F, history=()):
        """An upper bound of the tangent [Pa], shape (n,), for the time step."""
        largest = jnp.linalg.norm(F, axis=(1, 2)) ** 2
        return 3 * (2 * self.mu + 3 * self.lam) * largest**2


def main():
    """Return the period of the bar's first longitudinal mode over the exact one."""
    youngs_modulus, density, length, width = 1e5, 1000.0, 0.5, 0.1  # nu = 0: a bar without lateral motion
    side = np.arange(-width / 2 + 0.0125, width / 2, 0.025)
    along = np.arange(0.0125, length, 0.025)
    x = jnp.stack(jnp.meshgrid(along, side, side), -1).reshape(-1, 3) + jnp.array([0.25, 0.5, 0.5])
    count, volume = len(x), 0.025**3
    material = SaintVenantKirchhoff(jnp.full(count, youngs_modulus / 2), jnp.zeros(count))
    model = Model(
        Grid.whole(1.0, 20), dt=jnp.array(5e-4), gravity=None, mass=jnp.full(count, density * volume),
        volume=jnp.full(count, volume), materials=(material,),
    )  # fmt: skip
    v = jnp.zeros_like(x).at[:, 0].set(-0.01 * jnp.cos(jnp.pi * (x[:, 0] - 0.25) / length))
    _, path = rollout(model, State.at_rest(x, v), frame_count=200, substeps=4)
    stretch = np.asarray(path.x[:, -1, 0] - path.x[:, 0, 0])
    sign_changes = np.flatnonzero(np.diff(np.sign(stretch - stretch.mean())))
    period = 2 * np.diff(sign_changes).mean() * 4 * 5e-4
    return period / (2 * length / np.sqrt(youngs_modulus / density))


if __name__ == "__main__":
    ratio = main()
    print(f"period over the exact one: {ratio:.3f}")
    assert abs(ratio - 1) < 0.03
