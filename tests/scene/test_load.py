import hashlib

import numpy as np
import pytest
import trimesh

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import read_ply, write_ply
from physagent_jax.scene.config import Source
from physagent_jax.scene.load import hash_file, load_object
from tests.scene.clouds import cloud_of


def test_gaussians_are_read_with_the_opacity_threshold(robot_path):
    cloud = load_object(Source(path=robot_path.name, opacity_threshold=0.5), robot_path.parent).cloud
    expected = read_ply(robot_path, opacity_threshold=0.5)
    assert 0 < cloud.count == expected.count < read_ply(robot_path).count


def test_an_absolute_path_ignores_the_base_folder(robot_path, tmp_path):
    assert load_object(Source(path=str(robot_path)), tmp_path).cloud.count > 3000


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".OBJ"])
def test_meshes_are_sampled_whatever_their_format(tmp_path, suffix):
    trimesh.creation.icosphere(subdivisions=2).export(
        tmp_path / f"ball{suffix}", file_type=suffix[1:].lower()
    )
    cloud = load_object(Source(path=f"ball{suffix}", surface_samples=300), tmp_path).cloud
    assert cloud.count == 300
    np.testing.assert_allclose(np.linalg.norm(cloud.means, axis=1), 1.0, atol=0.06)


def test_a_ply_of_gaussians_with_faces_beside_them_is_gaussians(tmp_path):
    write_ply(tmp_path / "a.ply", cloud_of(np.eye(3)))
    data = (tmp_path / "a.ply").read_bytes()
    faces = b"element face 0\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "b.ply").write_bytes(data.replace(b"end_header\n", faces))
    assert load_object(Source(path="b.ply"), tmp_path).cloud.count == 3


def test_the_hash_is_sha256_of_the_bytes(tmp_path):
    (tmp_path / "x.bin").write_bytes(b"abc")
    # FIPS 180-2, appendix B.1
    assert hash_file(tmp_path / "x.bin") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    with pytest.raises(UserError, match="cannot read"):
        hash_file(tmp_path / "gone")


def test_a_changed_file_is_refused(robot_path):
    right = hashlib.sha256(robot_path.read_bytes()).hexdigest()
    load_object(Source(path=str(robot_path), sha256=right), ".")
    with pytest.raises(UserError, match="not the file that this scene was made with"):
        load_object(Source(path=str(robot_path), sha256="0" * 64), ".")


@pytest.mark.parametrize("suffix", [".spz", ".splat", ".ksplat", ".sog"])
def test_other_splat_formats_are_named_with_what_to_do(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_bytes(b"\x00" * 64)
    with pytest.raises(UserError, match=r"not supported.*\.ply"):
        load_object(Source(path=f"a{suffix}"), tmp_path)


def test_unknown_missing_and_pointless_files_are_refused(tmp_path):
    (tmp_path / "a.txt").write_text("hello")
    with pytest.raises(UserError, match=r"unknown kind.*\.txt"):
        load_object(Source(path="a.txt"), tmp_path)
    with pytest.raises(UserError, match="there is no object file"):
        load_object(Source(path="b.ply"), tmp_path)
    (tmp_path / "c.ply").write_text("solid")
    with pytest.raises(UserError, match="no PLY"):
        load_object(Source(path="c.ply"), tmp_path)
    trimesh.PointCloud(np.eye(3)).export(tmp_path / "d.ply")
    with pytest.raises(UserError, match="neither faces nor 3D Gaussians"):
        load_object(Source(path="d.ply"), tmp_path)


def test_a_compressed_ply_says_what_to_convert_to(shared_data):
    with pytest.raises(UserError, match="compressed PLY"):
        load_object(Source(path="guitar.compressed.ply"), shared_data)
