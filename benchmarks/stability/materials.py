"""The materials of the stress matrix, with parameters in proportion to their stiffness."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from physagent_jax.mpm import materials as laws
from physagent_jax.mpm.materials import lame_parameters

ELASTIC = ("neo-hookean", "fixed-corotated", "hencky")
PLASTIC = ("von-mises", "plasticine", "sand", "wet-sand", "foam", "snow")
FLUID = ("fluid", "cohesive-fluid")
MATERIALS = ELASTIC + PLASTIC + FLUID

SNOW_CAP = 4.0


def make_material(name: str, count: int, E: float, nu: float, dtype):
    """A block of ``count`` particles. Yield stresses are a hundredth of E; a fluid's bulk modulus is E."""

    def full(value: float):
        return jnp.full(count, value, dtype)

    mu, lam = (full(value) for value in lame_parameters(E, nu))
    match name:
        case "neo-hookean":
            return laws.NeoHookean(mu, lam)
        case "fixed-corotated":
            return laws.FixedCorotated(mu, lam)
        case "hencky":
            return laws.Hencky(mu, lam)
        case "von-mises":
            return laws.VonMises(mu, lam, full(0.01 * E), full(0.1 * E))
        case "plasticine":
            return laws.Plasticine(mu, lam, full(0.01 * E), full(0.02 * E))
        case "sand":
            return laws.DruckerPrager(mu, lam, full(np.deg2rad(35)), full(0.0))
        case "wet-sand":
            return laws.DruckerPrager(mu, lam, full(np.deg2rad(35)), full(0.005 * E))
        case "foam":
            return laws.Viscoplastic(mu, lam, full(0.01 * E), full(1e-3 * E))
        case "snow":
            return laws.Snow(mu, lam, full(0.025), full(0.0075), full(10.0), full(SNOW_CAP))
        case "fluid":
            return laws.Fluid(full(E))
        case "cohesive-fluid":
            return laws.Fluid(full(E), tension=True)
    raise ValueError(f"no material {name!r}")
