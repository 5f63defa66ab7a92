"""Finite rotations from rotation vectors."""

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.mpm.constraints.rotation import rotation_matrix


def test_matrices_of_many_vectors_are_those_of_each():
    vectors = np.random.default_rng(0).normal(size=(5, 3)).astype(np.float32)
    expected = Rotation.from_rotvec(vectors).as_matrix()
    np.testing.assert_allclose(rotation_matrix(jnp.asarray(vectors)), expected, atol=2e-6)
    np.testing.assert_allclose(rotation_matrix(jnp.asarray(vectors[0])), expected[0], atol=2e-6)
