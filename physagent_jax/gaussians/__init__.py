"""3D Gaussians: the cloud and its files, and how it follows a deformation."""

from physagent_jax.gaussians.binding import Binding, bind, deform
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import (
    covariance_matrices,
    decompose_covariances,
    matrix_to_quat,
    quat_to_matrix,
    quats_scales_to_covariances,
    transform_covariances,
)
from physagent_jax.gaussians.export import splats_to_cloud
from physagent_jax.gaussians.formats import LoadedSplats, read_ply, read_splats
from physagent_jax.gaussians.formats.gltf_writer import write_glb
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.gaussians.formats.spz_writer import write_spz
from physagent_jax.gaussians.polar import polar_rotation
from physagent_jax.gaussians.sh import eval_sh, rotate_sh, sh_basis

__all__ = [
    "Binding",
    "GaussianCloud",
    "LoadedSplats",
    "Splats",
    "bind",
    "covariance_matrices",
    "decompose_covariances",
    "deform",
    "eval_sh",
    "matrix_to_quat",
    "polar_rotation",
    "quat_to_matrix",
    "quats_scales_to_covariances",
    "read_ply",
    "read_splats",
    "rotate_sh",
    "sh_basis",
    "splats_to_cloud",
    "transform_covariances",
    "write_glb",
    "write_ply",
    "write_spz",
]
