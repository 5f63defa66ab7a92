"""Weakly compressible fluid."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import determinant
from physagent_jax.mpm.materials.base import TORN, History


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Fluid:
    """Tait's equation of state, p = K/gamma (J^-gamma - 1)  (Monaghan 1994; Becker & Teschner 2007).

    tau = -J p I, psi = K/gamma ((J^(1-gamma) - 1)/(gamma - 1) + J - 1), so that d psi / dJ = -p.
    Only the volume is remembered: `project` keeps J^(1/3) I of F. Viscosity belongs to `Model.viscosity`.

    Attributes:
        bulk_modulus: K [Pa], shape (n,).
        exponent: gamma >= 1, static; 7 for water. The larger, the stiffer under compression.
        tension: Whether p may be negative, static. If not, there is neither stress nor energy at J > 1:
            free surfaces tear without cohesion.
    """

    bulk_modulus: jax.Array
    exponent: float = dataclasses.field(default=7.0, metadata=dict(static=True))
    tension: bool = dataclasses.field(default=False, metadata=dict(static=True))

    @property
    def count(self) -> int:
        """Particles in the block."""
        return self.bulk_modulus.shape[0]

    def initial_history(self) -> History:
        """None."""
        return ()

    def pressure(self, J: jax.Array) -> jax.Array:
        """p(J) [Pa], shape (n,)."""
        J = self._cut_expansion(J)
        return self.bulk_modulus / self.exponent * (J**-self.exponent - 1)

    def energy(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Energy of compression per rest volume [J/m^3], shape (n,)."""
        J, gamma = self._cut_expansion(determinant(F)), self.exponent
        expansion = -jnp.log(J) if gamma == 1 else (J ** (1 - gamma) - 1) / (gamma - 1)
        return self.bulk_modulus / gamma * (expansion + J - 1)

    def stress(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Kirchhoff stress -J p I [Pa], shape (n, 3, 3)."""
        J = determinant(F)
        return (-J * self.pressure(J))[:, None, None] * jnp.eye(3, dtype=F.dtype)

    def stiffness(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Since d tau_i / d ln s_j = K/gamma ((gamma - 1) J^(1-gamma) + J): three times that, at least that of J = 1.

        What has torn off weighs in with J = 1 too, because it may meet the rest in the coming steps.
        """
        J, gamma = self._cut_expansion(determinant(F)), self.exponent
        return 3 * self.bulk_modulus * jnp.maximum(((gamma - 1) * J ** (1 - gamma) + J) / gamma, 1)

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """J^(1/3) I: a fluid forgets shear, and if it bears no tension, expansion beyond `base.TORN`.

        An inverted F stays one, with its negative determinant.
        """
        del dt
        J = determinant(F)
        if not self.tension:
            J = jnp.minimum(J, TORN)
        return jnp.cbrt(J)[:, None, None] * jnp.eye(3, dtype=F.dtype), history

    def _cut_expansion(self, J: jax.Array) -> jax.Array:
        """J, without the expansion if there is no tension."""
        return J if self.tension else jnp.where(J < 1, J, 1)
