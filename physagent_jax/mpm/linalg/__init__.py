"""3x3 linear algebra for particle batches of shape (n, 3, 3)."""

from physagent_jax.mpm.linalg.algebra import cofactor as cofactor
from physagent_jax.mpm.linalg.algebra import cross as cross
from physagent_jax.mpm.linalg.algebra import determinant as determinant
from physagent_jax.mpm.linalg.algebra import greatest_stretch_squared as greatest_stretch_squared
from physagent_jax.mpm.linalg.algebra import matmul as matmul
from physagent_jax.mpm.linalg.algebra import matvec as matvec
from physagent_jax.mpm.linalg.algebra import skew as skew
from physagent_jax.mpm.linalg.algebra import transpose as transpose
from physagent_jax.mpm.linalg.spectral import Principal as Principal
from physagent_jax.mpm.linalg.spectral import isotropic as isotropic
from physagent_jax.mpm.linalg.spectral import singular_values as singular_values
from physagent_jax.mpm.linalg.spectral import spectral as spectral
from physagent_jax.mpm.linalg.svd import svd as svd
