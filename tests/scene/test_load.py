import hashlib

import numpy as np
import pytest
import trimesh

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import formats, read_ply, read_splats, write_ply
from physagent_jax.gaussians.formats import FORMATS, SplatData
from physagent_jax.gaussians.formats.gltf_writer import write_glb
from physagent_jax.output.splats import write_splat_frames
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import ObjectChoice, RunSpec
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Domain, Filling, Source
from physagent_jax.scene.config.source import MESH_SUFFIXES
from physagent_jax.scene.load import hash_file, load_object
from physagent_jax.scene.placement import place
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


def test_other_splat_formats_are_named_with_what_to_do(tmp_path):
    (tmp_path / "a.ksplat").write_bytes(b"\x00" * 64)
    with pytest.raises(UserError, match=r"a .ksplat file.*not read.*\.ply"):
        load_object(Source(path="a.ksplat"), tmp_path)


@pytest.mark.parametrize("suffix", [".spz", ".splat", ".sog"])
def test_a_file_that_is_not_what_its_name_says_is_refused(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_bytes(b"\x00" * 64)
    with pytest.raises(UserError, match=r"no readable file of the format.*Copy or export"):
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


def test_gaussians_in_a_glb_are_no_mesh(tmp_path):
    cloud = cloud_of(np.eye(3))
    write_glb(tmp_path / "a.glb", cloud)
    loaded = load_object(Source(path="a.glb"), tmp_path)
    assert "KHR_gaussian_splatting" in loaded.format_name and loaded.up == "+y"
    np.testing.assert_array_equal(loaded.cloud.means, cloud.means)


def test_an_unknown_kind_is_answered_with_all_that_are_known(tmp_path):
    (tmp_path / "a.txt").write_text("hello")
    with pytest.raises(UserError) as error:
        load_object(Source(path="a.txt"), tmp_path)
    assert all(f"{each.name} (" in str(error.value) for each in FORMATS if each.suffixes)
    assert all(suffix in str(error.value) for suffix in MESH_SUFFIXES)


def test_an_encoding_means_nothing_for_a_mesh(tmp_path):
    trimesh.creation.icosphere(subdivisions=1).export(tmp_path / "ball.obj")
    with pytest.raises(UserError, match="`splat_encoding` means nothing for the mesh .*ball.obj"):
        load_object(Source(path="ball.obj", splat_encoding="log-logit"), tmp_path)


def test_the_source_says_how_the_file_is_encoded(tmp_path):
    """Alike opacities: 0.9 is open, and the scene file settles it."""
    cloud = cloud_of(np.random.default_rng(0).uniform(size=(50, 3)), opacity=0.7109495)
    write_ply(tmp_path / "a.ply", cloud)  # logit(0.7109495) = 0.9
    data = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "a.ply").write_bytes(data.replace(b"comment splat-encoding log-logit\n", b""))
    with pytest.raises(UserError, match="ambiguous"):
        load_object(Source(path="a.ply"), tmp_path)
    for encoding, opacity in (("log-logit", 0.7109495), ("log-plain", 0.9)):
        loaded = load_object(Source(path="a.ply", splat_encoding=encoding), tmp_path)
        np.testing.assert_allclose(loaded.cloud.opacities, opacity, rtol=1e-5)


def test_what_a_reader_notes_is_warned_of(tmp_path):
    means = np.random.default_rng(0).uniform(size=(500, 3)) + [5e5, 5.4e6, 0]
    write_ply(tmp_path / "a.ply", cloud_of(means))
    with pytest.warns(UserWarning, match="coarse lattice"):
        load_object(Source(path="a.ply"), tmp_path)


FAR = np.array([500_000.0, 5_400_000.0, 300.0])


@pytest.fixture
def far(tmp_path):
    """Gaussians in a box of 2 by 1 by 1 far away, as doubles; their positions relative to `FAR`."""
    offsets = np.random.default_rng(3).uniform(0, 1, (400, 3)) * [2, 1, 1]
    write_ply(tmp_path / "far.ply", cloud_of(offsets, opacity=0.8), origin=FAR)
    return tmp_path, np.float32(offsets)


def test_a_crop_is_in_the_units_of_the_file_wherever_that_lies(far):
    folder, offsets = far
    low, high = FAR + [0.5, 0, 0], FAR + [1.5, 1, 0.5]
    source = Source(path="far.ply", crop=tuple(np.stack([low, high], 1).ravel().tolist()))
    loaded = load_object(source, folder)
    cloud, placement = place(loaded.cloud, source, Domain(size=2.0), loaded.origin)
    inside = ((offsets > [0.5, 0, 0]) & (offsets < [1.5, 1, 0.5])).all(1)
    assert cloud.count == inside.sum()
    np.testing.assert_allclose(placement.to_source(cloud.means) - FAR, offsets[inside], atol=1e-6)
    np.testing.assert_allclose(placement.to_world(FAR + offsets[inside]), cloud.means, atol=1e-6)


def test_a_turned_crop_is_in_the_turned_frame(far):
    """A quarter turn about z brings (x, y) to (-y, x)."""
    folder, offsets = far
    low, high = [-FAR[1] - 0.5, FAR[0], 0], [-FAR[1], FAR[0] + 1, 1000]
    source = Source(
        path="far.ply",
        crop=tuple(np.stack([low, high], 1).ravel().tolist()),
        rotation_degrees=(90.0,),
        rotation_axes=(2,),
    )
    loaded = load_object(source, folder)
    cloud, _ = place(loaded.cloud, source, Domain(size=2.0), loaded.origin)
    assert cloud.count == ((offsets[:, 1] < 0.5) & (offsets[:, 0] < 1)).sum()


def test_written_frames_lie_where_the_file_does(far):
    folder, offsets = far
    source = Source(path="far.ply", extent=1.0, up="-y")
    body = make_body(source, Filling(cells=8, max_particles=300), Domain(size=2.0, cells=16), folder)
    at_rest = np.broadcast_to(np.eye(3), (1, len(body.particles.x), 3, 3))
    (path,) = write_splat_frames(folder / "splats", body, body.particles.x[None], at_rest)
    written = read_splats(path)
    found = np.asarray(written.cloud.means, np.float64) + written.origin - FAR
    np.testing.assert_allclose(found, offsets, atol=2e-6)


def test_a_prescribed_up_axis_is_found(tmp_path, monkeypatch, robot_path):
    assert load_object(Source(path=robot_path.name), robot_path.parent).up is None
    trimesh.creation.icosphere(subdivisions=1).export(tmp_path / "ball.glb")
    assert load_object(Source(path="ball.glb"), tmp_path).up == "+y"

    class UpFormat:
        name, suffixes = "a format that prescribes up", (".up",)

        def matches(self, head):
            return head.startswith(b"up")

        def read(self, path, encoding):
            values = np.random.default_rng(0).uniform(0.1, 0.9, (20, 3))
            quats = np.tile([1.0, 0, 0, 0], (20, 1))
            return SplatData(values, quats, values, values[:, 0], values[:, None], "plain", up="-x")

    monkeypatch.setattr(formats, "FORMATS", (UpFormat(), *FORMATS))
    (tmp_path / "a.up").write_bytes(b"up")
    assert load_object(Source(path="a.up"), tmp_path).up == "-x"
    with pytest.warns(
        UserWarning, match="changes nothing, because a format that prescribes up has one encoding"
    ):
        load_object(Source(path="a.up", splat_encoding="log-logit"), tmp_path)
    run = resolve(RunSpec(object=ObjectChoice(path="a.up"), prompt="it falls"), tmp_path)
    assert run.template.source.up == "-x" and not any("up axis" in text for text in run.warnings)
