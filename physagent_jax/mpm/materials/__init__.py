"""Constitutive models, one concept per file."""

from physagent_jax.mpm.materials.base import Material as Material
from physagent_jax.mpm.materials.base import lame_parameters as lame_parameters
from physagent_jax.mpm.materials.fixed_corotated import FixedCorotated as FixedCorotated
from physagent_jax.mpm.materials.neo_hookean import NeoHookean as NeoHookean
