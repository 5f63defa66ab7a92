"""The named library: real materials with documented values, and what it costs to simulate them."""

from physagent_jax.scene.materials.cost import count_substeps as count_substeps
from physagent_jax.scene.materials.cost import stable_step as stable_step
from physagent_jax.scene.materials.describe import describe_material as describe_material
from physagent_jax.scene.materials.entry import NamedMaterial as NamedMaterial
from physagent_jax.scene.materials.library import LIBRARY as LIBRARY
from physagent_jax.scene.materials.library import find_material as find_material
from physagent_jax.scene.materials.soften import is_hard as is_hard
from physagent_jax.scene.materials.soften import replace_youngs_modulus as replace_youngs_modulus
from physagent_jax.scene.materials.soften import soften_for as soften_for
from physagent_jax.scene.materials.soften import soften_material as soften_material
