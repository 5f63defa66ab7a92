"""Constitutive models, one concept per file."""

from physagent_jax.mpm.materials.base import History as History
from physagent_jax.mpm.materials.base import Material as Material
from physagent_jax.mpm.materials.base import lame_parameters as lame_parameters
from physagent_jax.mpm.materials.base import respond as respond
from physagent_jax.mpm.materials.brittle import Brittle as Brittle
from physagent_jax.mpm.materials.drucker_prager import DruckerPrager as DruckerPrager
from physagent_jax.mpm.materials.fixed_corotated import FixedCorotated as FixedCorotated
from physagent_jax.mpm.materials.fluid import Fluid as Fluid
from physagent_jax.mpm.materials.hencky import Hencky as Hencky
from physagent_jax.mpm.materials.neo_hookean import NeoHookean as NeoHookean
from physagent_jax.mpm.materials.plasticine import Plasticine as Plasticine
from physagent_jax.mpm.materials.plasticine import (
    softening_from_deviator_norm as softening_from_deviator_norm,
)
from physagent_jax.mpm.materials.rigid import Rigid as Rigid
from physagent_jax.mpm.materials.snow import Snow as Snow
from physagent_jax.mpm.materials.viscoplastic import Viscoplastic as Viscoplastic
from physagent_jax.mpm.materials.viscous import viscous_stress as viscous_stress
from physagent_jax.mpm.materials.von_mises import VonMises as VonMises
from physagent_jax.mpm.materials.von_mises import (
    hardening_from_deviator_norm as hardening_from_deviator_norm,
)
from physagent_jax.mpm.materials.von_mises import (
    yield_stress_from_deviator_norm as yield_stress_from_deviator_norm,
)
