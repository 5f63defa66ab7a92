"""Relatives of the 3DGS PLY: RGB colours, two scales, doubles, missing and additional properties, points."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import read_ply, read_splats, write_ply
from physagent_jax.gaussians.formats import FORMATS, find_format, read_head
from tests.gaussians.test_ply import ROTATION, columns, random_cloud, save

SCALES = ("scale_0", "scale_1", "scale_2")
Y00 = 0.5 / np.sqrt(np.pi)  # the constant spherical harmonic


def with_colours(values: np.ndarray) -> dict[str, np.ndarray]:
    """Properties of Gaussians with red, green and blue in place of f_dc, values of shape (n, 3)."""
    properties = {n: v for n, v in columns(count=len(values)).items() if not n.startswith("f_dc")}
    return properties | dict(zip(("red", "green", "blue"), np.ascontiguousarray(values.T)))


def render_colour(sh: np.ndarray) -> np.ndarray:
    """The colour of degree 0 that the 3DGS paper's code draws."""
    return 0.5 + Y00 * np.asarray(sh[:, 0])


COLOURS = np.array([[0, 51, 255], [255, 102, 0], [26, 217, 38], [128, 1, 254], [7, 8, 9]])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (COLOURS.astype(np.uint8), "0 to 255"),
        ((COLOURS * 257).astype(np.uint16), "0 to 65535"),
        (COLOURS.astype(np.float32), "0 to 255"),
        ((COLOURS / 255).astype(np.float32), "0 to 1"),
        (COLOURS / 255, "0 to 1"),
    ],
)
def test_rgb_colours_of_any_type_are_read(tmp_path, values, words):
    loaded = read_splats(save(tmp_path / "a.ply", with_colours(values)))
    assert loaded.format_name == "RGB splat PLY" and f"RGB colours of {words}" in loaded.encoding
    np.testing.assert_allclose(render_colour(loaded.cloud.sh), COLOURS / 255, atol=2e-7)
    assert loaded.notes == () and not loaded.origin.any()


def test_colours_of_no_range_are_refused(tmp_path):
    with pytest.raises(UserError, match="neither in 0 to 1 nor in 0 to 255 .*256"):
        read_ply(save(tmp_path / "a.ply", with_colours(COLOURS + 1.0)))


def test_coefficients_go_before_rgb_colours(tmp_path):
    """Some exporters write both; f_dc is what was trained."""
    both = columns() | {name: np.zeros(5, np.uint8) for name in ("red", "green", "blue")}
    loaded = read_splats(save(tmp_path / "a.ply", both))
    assert loaded.format_name == "3DGS PLY"
    np.testing.assert_array_equal(loaded.cloud.sh[:, 0, 1], both["f_dc_1"])


@pytest.mark.parametrize("span", [255, 1])
def test_coefficients_that_are_rgb_colours_are_told_from_their_values(tmp_path, span):
    """Up to 255 they can be nothing else; up to 1 they can be meant as they are, which is said."""
    rgb = np.random.default_rng(0).uniform(size=(200, 3))
    rgb[0] = 0, 1, 0.5
    stored = columns(count=200) | {f"f_dc_{i}": span * rgb[:, i] for i in range(3)}
    loaded = read_splats(save(tmp_path / "a.ply", stored))
    assert len(loaded.notes) == 1 and "RGB colours" in loaded.notes[0]
    if span == 255:
        np.testing.assert_allclose(render_colour(loaded.cloud.sh), rgb, atol=1e-6)
    else:
        np.testing.assert_allclose(loaded.cloud.sh[:, 0], rgb, atol=1e-6)


def test_two_scales_are_flat_gaussians(tmp_path):
    """2DGS (Huang et al. 2024, section 4.1): the normal is the third column of the rotation."""
    properties = columns()
    del properties["scale_2"]
    loaded = read_splats(save(tmp_path / "a.ply", properties))
    assert loaded.format_name == "2DGS PLY" and "flat along the third axis" in loaded.encoding
    np.testing.assert_allclose(loaded.cloud.scales[:, 1], np.exp(properties["scale_1"]), rtol=1e-6)
    np.testing.assert_array_equal(loaded.cloud.scales[:, 2], 0)


def test_flat_gaussians_with_rgb_colours(tmp_path):
    properties = with_colours(COLOURS.astype(np.uint8))
    del properties["scale_2"]
    loaded = read_splats(save(tmp_path / "a.ply", properties))
    assert loaded.format_name == "2DGS PLY"
    np.testing.assert_allclose(render_colour(loaded.cloud.sh), COLOURS / 255, atol=2e-7)


def test_doubles_are_read_like_floats(tmp_path):
    single = columns(3)
    double = {name: values.astype(np.float64) for name, values in single.items()}
    one, other = (
        read_splats(save(tmp_path / "a.ply", each)) for each in (single, dict(reversed(double.items())))
    )
    for name in ("means", "quats", "scales", "opacities", "sh"):
        np.testing.assert_array_equal(getattr(one.cloud, name), getattr(other.cloud, name))
    assert "float32" in one.encoding and "float64" in other.encoding


@pytest.mark.parametrize("degree", [4, 5])
def test_bands_above_the_third_are_left_out_with_a_note(tmp_path, degree):
    each = (degree + 1) ** 2 - 1
    rest = np.random.default_rng(0).normal(size=(5, 3, each)).astype(np.float32)
    names = {f"f_rest_{i}": rest.reshape(5, -1)[:, i] for i in range(3 * each)}
    loaded = read_splats(save(tmp_path / "a.ply", columns() | names))
    assert loaded.cloud.sh_degree == 3
    np.testing.assert_array_equal(loaded.cloud.sh[:, 1:], rest[:, :, :15].transpose(0, 2, 1))
    assert len(loaded.notes) == 1 and f"degree {degree}" in loaded.notes[0]


def test_what_is_wholly_missing_is_assumed_with_a_note(tmp_path):
    properties = columns()
    for name in ("opacity", *ROTATION):
        del properties[name]
    loaded = read_splats(save(tmp_path / "a.ply", properties))
    np.testing.assert_array_equal(loaded.cloud.opacities, 1)
    np.testing.assert_array_equal(loaded.cloud.quats, np.tile([1, 0, 0, 0], (5, 1)))
    assert ["opacity" in note or "rot_" in note for note in loaded.notes] == [True, True]


@pytest.mark.parametrize("name", ["rot_2", "scale_0", "y", "f_dc_1"])
def test_what_is_missing_in_part_is_refused(tmp_path, name):
    properties = columns()
    del properties[name]
    with pytest.raises(UserError, match=f"lacks the properties {name}[.]"):
        read_ply(save(tmp_path / "a.ply", properties))


def test_faces_beside_gaussians_are_noted(tmp_path):
    data = save(tmp_path / "a.ply", columns()).read_bytes()
    faces = b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    rows = struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 1, 2, 3)
    (tmp_path / "a.ply").write_bytes(data.replace(b"end_header\n", faces) + rows)
    loaded = read_splats(tmp_path / "a.ply")
    assert loaded.cloud.count == 5 and "2 faces" in loaded.notes[0]


def test_a_mesh_with_colours_is_no_splat(tmp_path):
    header = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float opacity\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    (tmp_path / "a.ply").write_text(header + "0 0 0 9 9 9 1\n1 0 0 9 9 9 1\n0 1 0 9 9 9 1\n3 0 1 2\n")
    assert find_format(read_head(tmp_path / "a.ply"), tmp_path / "a.ply") is None


def test_points_are_refused_in_words(tmp_path):
    points = {name: columns()[name] for name in "xyz"}
    colours = {name: np.zeros(5, np.uint8) for name in ("red", "green", "blue")}
    for properties, words in ((points, "5 points"), (points | colours, "5 points with colours")):
        with pytest.raises(UserError, match=f"point cloud.*{words}.*Train 3D Gaussians"):
            read_splats(save(tmp_path / "a.ply", properties))


def colmap_points(count: int, track: int = 2) -> bytes:
    """COLMAP's points3D.bin, from its documentation."""
    rng = np.random.default_rng(0)
    data = struct.pack("<Q", count)
    for index in range(count):
        data += struct.pack("<QdddBBBdQ", index + 1, *rng.normal(size=3), 9, 8, 7, 0.5, track)
        data += struct.pack(f"<{2 * track}I", *range(2 * track))
    return data


def test_points_of_colmap_are_refused_in_words(tmp_path):
    text = "# 3D point list with one line of data per point:\n#   POINT3D_ID, X, Y, Z, R\n1 0 0 0 9 9 9 0.5 1 2\n"
    for name, content in (
        ("points3D.txt", text.encode()),
        ("points3D.bin", colmap_points(100)),
        ("few.bin", colmap_points(3)),
        ("long.bin", colmap_points(2000, 7)),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(UserError, match=f"{name} holds the points of a COLMAP.*Train"):
            read_splats(tmp_path / name)


def test_other_bytes_are_no_points_of_colmap(tmp_path):
    rng = np.random.default_rng(0)
    for content in (rng.bytes(5000), bytes(5000), b"\x01" * 5000, b"solid ball\n" * 500):
        (tmp_path / "a.bin").write_bytes(content)
        with pytest.raises(UserError, match="unknown kind"):
            read_splats(tmp_path / "a.bin")


def test_the_registry_holds_formats_that_can_be_told(tmp_path):
    for each in FORMATS:
        assert each.name and all(suffix.startswith(".") for suffix in each.suffixes)
        assert not each.matches(b"") and not each.matches(b"\x89PNG\r\n\x1a\n")
    (tmp_path / "a.dat").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(UserError) as error:
        read_splats(tmp_path / "a.dat")
    assert all(each.name in str(error.value) for each in FORMATS if each.suffixes)


def test_reading_says_how_many_the_file_holds(tmp_path):
    cloud = random_cloud(1, count=50)
    write_ply(tmp_path / "a.ply", cloud)
    loaded = read_splats(tmp_path / "a.ply", opacity_threshold=0.7)
    assert loaded.count_in_file == 50 and loaded.cloud.count == np.sum(np.asarray(cloud.opacities) >= 0.7)
    assert f"only {loaded.cloud.count} of 50" in loaded.notes[0]
    assert loaded.encoding == "log scales, logit opacities, SH of degree 1, float32 positions"


@pytest.mark.parametrize("name", ["rgb_colours", "two_scales", "projected", "activated", "extra_elements"])
def test_variants_of_one_object_have_one_shape(shared_data, name):
    """The same 1,500 Gaussians, written in other ways by another program."""
    folder = shared_data / "reports" / "in"
    plain, other = (read_splats(folder / f"{each}.ply") for each in ("plain", name))
    shift = np.asarray(other.cloud.means, np.float64) + other.origin - np.asarray(plain.cloud.means)
    assert np.ptp(shift, axis=0).max() < 1e-6
    flat = 2 if name == "two_scales" else 3
    np.testing.assert_allclose(other.cloud.scales[:, :flat], plain.cloud.scales[:, :flat], rtol=2e-6)
    np.testing.assert_allclose(other.cloud.opacities, plain.cloud.opacities, atol=1e-6)
    np.testing.assert_allclose(
        np.clip(render_colour(other.cloud.sh), 0, 1), np.clip(render_colour(plain.cloud.sh), 0, 1), atol=0.003
    )


def test_points_of_the_same_object_are_refused(shared_data):
    with pytest.raises(UserError, match="point cloud.*1,500 points with colours"):
        read_splats(shared_data / "reports" / "in" / "points_rgb.ply")
