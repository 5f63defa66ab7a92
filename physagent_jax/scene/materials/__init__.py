"""The named library: real materials with documented values, and what it costs to simulate them."""

from physagent_jax.scene.materials.cost import stable_step as stable_step
from physagent_jax.scene.materials.cost import substeps as substeps
from physagent_jax.scene.materials.describe import describe as describe
from physagent_jax.scene.materials.entry import NamedMaterial as NamedMaterial
from physagent_jax.scene.materials.library import LIBRARY as LIBRARY
from physagent_jax.scene.materials.library import find_material as find_material
from physagent_jax.scene.materials.soften import scaled_for as scaled_for
from physagent_jax.scene.materials.soften import softened as softened
from physagent_jax.scene.materials.soften import with_youngs_modulus as with_youngs_modulus
