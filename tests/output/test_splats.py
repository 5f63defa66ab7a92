"""Per-frame files of 3D Gaussians: the same frames in every format, with the axes that each prescribes."""

import warnings

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.gaussians import rotate_sh, write_ply
from physagent_jax.gaussians.covariance import covariance_matrices, quats_scales_to_covariances
from physagent_jax.gaussians.formats import read_splats
from physagent_jax.output.splats import find_frame_turn, write_splat_frames
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Domain, Filling, Source
from physagent_jax.scene.placement import find_up_rotation
from physagent_jax.scene.procedural import make_jelly

UPS = ("+z", "-y", "+y", "+x")


def make_frames(folder, up, form):
    """Two frames, the second one sheared; the object's file has ``up``."""
    write_ply(folder / "object.ply", make_jelly(0, count=300))
    source = Source(path="object.ply", up=up)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        body = make_body(source, Filling(cells=8, max_particles=200), Domain(size=2.0, cells=16), folder)
    x = np.asarray(body.particles.x)
    shear = np.array([[1, 0, 0.3], [0, 1.1, 0], [0, 0, 0.9]])
    positions = np.stack([x, (x - 1) @ shear.T + 1])
    gradients = np.stack([np.tile(each, (len(x), 1, 1)) for each in (np.eye(3), shear)])
    return write_splat_frames(folder / form, body, positions, gradients, form=form, up=up)


def covariances(cloud):
    return covariance_matrices(
        quats_scales_to_covariances(jnp.asarray(cloud.quats), jnp.asarray(cloud.scales))
    )


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("form", ["spz", "glb"])
def test_every_format_shows_the_frames_of_the_ply_with_y_up(tmp_path, up, form):
    turn = find_up_rotation("+y").T @ find_up_rotation(up)
    ups = {"+z": (0, 0, 1), "-y": (0, -1, 0), "+y": (0, 1, 0), "+x": (1, 0, 0)}
    np.testing.assert_array_equal(turn @ ups[up], [0, 1, 0])
    pairs = zip(make_frames(tmp_path, up, "ply"), make_frames(tmp_path, up, form))
    for expected, found in pairs:
        assert found.suffix == f".{form}"
        ply, loaded = read_splats(expected).cloud, read_splats(found)
        assert loaded.up == "+y"
        close = 1e-6 if form == "glb" else 2e-6
        np.testing.assert_allclose(loaded.cloud.means, np.asarray(ply.means) @ turn.T, atol=close)
        one, other = covariances(loaded.cloud), turn @ covariances(ply) @ turn.T
        apart = np.linalg.norm(one - other, axis=(1, 2)) / np.linalg.norm(other, axis=(1, 2))
        assert apart.max() < (1e-4 if form == "glb" else 0.1)
        turned = rotate_sh(ply.sh, jnp.asarray(turn, jnp.float32))
        np.testing.assert_allclose(loaded.cloud.sh, turned, atol=1e-4 if form == "glb" else 0.02)


def test_a_ply_keeps_the_axes_of_the_object_file():
    for up in UPS:
        np.testing.assert_array_equal(find_frame_turn("ply", up), np.eye(3))
        np.testing.assert_array_equal(find_frame_turn("glb", "+y"), np.eye(3))
