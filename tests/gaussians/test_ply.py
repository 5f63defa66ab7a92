"""PLY files: what trainers write is read, what is written others can read, what is wrong is named."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import GaussianCloud, read_ply, write_ply
from physagent_jax.gaussians.formats.ply_header import read_ply_header

BASE = ("x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2")
ROTATION = ("rot_0", "rot_1", "rot_2", "rot_3")
STANDARD = [
    "pc_short_100_sh3_inria.ply",
    "playbot_8k_sh3_inria_layout.ply",
    "playbot_31k_sh2.ply",
    "guitar_sh0.ply",
]


def columns(degree=0, count=5, seed=0) -> dict[str, np.ndarray]:
    """Random properties of Gaussians as they stand in a file."""
    rng = np.random.default_rng(seed)
    names = [*BASE, *ROTATION, *(f"f_rest_{i}" for i in range(3 * ((degree + 1) ** 2 - 1)))]
    return {name: rng.normal(size=count).astype(np.float32) for name in names}


def save(path, properties, element="vertex", **options):
    dtype = [(name, values.dtype) for name, values in properties.items()]
    table = np.rec.fromarrays(list(properties.values()), dtype=dtype)
    PlyData([PlyElement.describe(np.asarray(table), element)], **options).write(str(path))
    return path


def random_cloud(degree, count=20, seed=0) -> GaussianCloud:
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    return GaussianCloud(
        means=rng.normal(size=(count, 3)).astype(np.float32),
        quats=(quats / np.linalg.norm(quats, axis=1, keepdims=True)).astype(np.float32),
        scales=np.exp(rng.uniform(-19, 1, (count, 3))).astype(np.float32),
        opacities=rng.uniform(0.01, 0.99, count).astype(np.float32),
        sh=rng.normal(size=(count, (degree + 1) ** 2, 3)).astype(np.float32),
    )


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_values_and_channel_major_sh_are_read_in_any_order(tmp_path, degree):
    properties = columns(degree)
    shuffled = dict(sorted(properties.items(), key=lambda item: hash(item[0]) % 97))
    shuffled["extra"] = np.arange(5, dtype=np.uint8)
    cloud = read_ply(save(tmp_path / "a.ply", shuffled))

    def get(*names):
        return np.stack([properties[n] for n in names], -1)

    assert cloud.sh_degree == degree
    np.testing.assert_array_equal(cloud.means, get("x", "y", "z"))
    np.testing.assert_allclose(cloud.scales, np.exp(get("scale_0", "scale_1", "scale_2")), rtol=1e-6)
    np.testing.assert_allclose(cloud.opacities, 1 / (1 + np.exp(-properties["opacity"])), rtol=1e-6)
    quats = get(*ROTATION)
    np.testing.assert_allclose(cloud.quats, quats / np.linalg.norm(quats, axis=1, keepdims=True), rtol=1e-5)
    higher = (degree + 1) ** 2 - 1
    for channel in range(3):
        np.testing.assert_array_equal(cloud.sh[:, 0, channel], properties[f"f_dc_{channel}"])
        for k in range(higher):
            np.testing.assert_array_equal(
                cloud.sh[:, 1 + k, channel], properties[f"f_rest_{channel * higher + k}"]
            )


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_round_trip(tmp_path, degree):
    cloud = random_cloud(degree)
    write_ply(tmp_path / "a.ply", cloud)
    again = read_ply(tmp_path / "a.ply")
    for name in ("means", "quats", "scales", "opacities", "sh"):
        np.testing.assert_allclose(
            getattr(again, name), getattr(cloud, name), rtol=3e-6, atol=1e-7, err_msg=name
        )


def test_written_file_has_the_inria_layout(tmp_path):
    """Names, order and types as the original trainer writes them, checked by an independent reader."""
    cloud = random_cloud(3)
    write_ply(tmp_path / "a.ply", cloud)
    data = PlyData.read(str(tmp_path / "a.ply"))
    expected = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"]
    expected += [f"f_rest_{i}" for i in range(45)] + ["opacity", "scale_0", "scale_1", "scale_2", *ROTATION]
    assert [p.name for p in data["vertex"].properties] == expected
    assert data.byte_order == "<" and not data.text
    assert {p.val_dtype for p in data["vertex"].properties} == {"f4"}
    np.testing.assert_allclose(data["vertex"]["f_rest_17"], cloud.sh[:, 3, 1])  # green, third of fifteen
    np.testing.assert_allclose(data["vertex"]["scale_1"], np.log(cloud.scales[:, 1]), rtol=1e-6)


def test_infinite_logits_are_read_and_written_finite(tmp_path):
    properties = columns()
    properties["opacity"][:2] = np.inf, -np.inf
    cloud = read_ply(save(tmp_path / "a.ply", properties))
    assert cloud.opacities[0] == 1 and cloud.opacities[1] == 0
    write_ply(tmp_path / "b.ply", cloud)
    written = PlyData.read(str(tmp_path / "b.ply"))["vertex"]
    assert all(np.isfinite(written[p.name]).all() for p in written.properties)
    np.testing.assert_allclose(read_ply(tmp_path / "b.ply").opacities, cloud.opacities, atol=2e-7)


def test_a_file_may_be_overwritten_by_its_own_cloud(tmp_path):
    path = save(tmp_path / "a.ply", columns())
    cloud = read_ply(path)
    write_ply(path, cloud)
    np.testing.assert_array_equal(read_ply(path).means, cloud.means)


def test_ascii_and_big_endian_files_are_read(tmp_path):
    binary = read_ply(save(tmp_path / "a.ply", columns(1)))
    for name, options in {"text": dict(text=True), "big": dict(byte_order=">")}.items():
        other = read_ply(save(tmp_path / f"{name}.ply", columns(1), **options))
        np.testing.assert_allclose(other.sh, binary.sh, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "value"), [("x", np.nan), ("scale_2", np.inf), ("scale_0", 200), ("opacity", np.nan)]
)
def test_gaussians_that_are_not_finite_are_dropped_with_a_warning(tmp_path, name, value):
    properties = columns()
    properties[name][3] = value
    with pytest.warns(UserWarning, match="dropped 1 Gaussians"):
        cloud = read_ply(save(tmp_path / "a.ply", properties))
    np.testing.assert_array_equal(cloud.means[:, 1], np.delete(properties["y"], 3))


def test_zero_quaternions_become_the_identity_with_a_warning(tmp_path):
    properties = columns()
    for name in ROTATION:
        properties[name][2] = 0
    with pytest.warns(UserWarning, match="1 quaternions of norm zero"):
        cloud = read_ply(save(tmp_path / "a.ply", properties))
    np.testing.assert_array_equal(cloud.quats[2], [1, 0, 0, 0])


def test_opacity_threshold_keeps_the_order(tmp_path):
    properties = columns()
    properties["opacity"][:] = [-3, 3, -1, 1, 0]
    cloud = read_ply(save(tmp_path / "a.ply", properties), opacity_threshold=0.5)
    np.testing.assert_array_equal(cloud.means[:, 0], properties["x"][[1, 3, 4]])


def broken_files():
    """Name, what to write, what the message must say."""
    lacking = columns(1)
    del lacking["rot_3"], lacking["opacity"], lacking["f_rest_4"]
    infinite = columns()
    infinite["y"][:] = np.nan
    faint = columns()
    faint["opacity"][:] = -9
    return {
        "no-gaussian": (lacking, "opacity, rot_3"),
        "sh-of-no-degree": (
            columns() | {f"f_rest_{i}": np.zeros(5, np.float32) for i in range(12)},
            "got 12",
        ),
        "sh-with-a-hole": (
            columns() | {f"f_rest_{i}": np.zeros(5, np.float32) for i in (0, 1, 9)},
            "f_rest_2",
        ),
        "empty": (columns(count=0), "holds no Gaussians"),
        "infinite": (infinite, "not finite"),
        "faint": (faint, "opacity_threshold=0.1 (got 0.000123 at most)"),
    }


@pytest.mark.parametrize("name", broken_files())
def test_unusable_content_is_named(tmp_path, name):
    properties, message = broken_files()[name]
    with pytest.raises(UserError) as error:
        read_ply(save(tmp_path / "a.ply", properties), opacity_threshold=0.1)
    assert message in str(error.value) and "a.ply" in str(error.value)


def test_unreadable_files_are_named(tmp_path):
    path = tmp_path / "a.ply"
    with pytest.raises(UserError, match="there is no file"):
        read_ply(path)
    whole = save(path, columns()).read_bytes()
    path.write_bytes(whole[:-7])
    with pytest.raises(UserError, match="truncated"):
        read_ply(path)
    for content in (b"", b"\x89PNG\r\n\x1a\n", b"solid cube", whole[:40]):
        path.write_bytes(content)
        with pytest.raises(UserError, match="not a readable PLY"):
            read_ply(path)
    for element in ("face", "chunk"):
        save(path, columns(), element=element)
        with pytest.raises(UserError, match=f"no element `vertex` .got {element}"):
            read_ply(path)
    with pytest.raises(UserError, match="opacity_threshold"):
        read_ply(path, opacity_threshold=2.0)


def test_bundled_robot(robot_path):
    cloud = read_ply(robot_path)
    assert (cloud.count, cloud.sh_degree) == (PlyData.read(str(robot_path))["vertex"].count, 2)
    np.testing.assert_allclose(np.linalg.norm(cloud.quats, axis=1), 1, atol=1e-6)


@pytest.mark.parametrize("name", STANDARD)
def test_real_captures_survive_a_round_trip(tmp_path, shared_data, name):
    cloud = read_ply(shared_data / name)
    assert cloud.count == PlyData.read(str(shared_data / name))["vertex"].count
    write_ply(tmp_path / name, cloud)
    again = read_ply(tmp_path / name)
    np.testing.assert_array_equal(again.means, cloud.means)
    np.testing.assert_allclose(again.scales, cloud.scales, rtol=3e-6)
    np.testing.assert_allclose(again.opacities, cloud.opacities, atol=1e-6)


# --- counts and values beyond sense ----------------------------------------------------------------------


def with_count(tmp_path, count, **options):
    """A good file of five Gaussians whose header announces ``count``."""
    data = save(tmp_path / "a.ply", columns(), **options).read_bytes()
    (tmp_path / "a.ply").write_bytes(data.replace(b"element vertex 5", b"element vertex %s" % count))
    return tmp_path / "a.ply"


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize(
    "count", [b"6000", b"99999999999999", b"-1", b"18446744073709551617", b"9" * 5000, b"5.5"]
)
def test_counts_beyond_the_file_are_refused_before_memory_is_taken(tmp_path, count, text):
    with pytest.raises(UserError, match="announces more than it holds|a count of") as error:
        read_ply(with_count(tmp_path, count, text=text))
    assert len(str(error.value)) < 400


HEADER = b"ply\nformat %s 1.0\nelement face %d\nproperty list %s int vertex_indices\nend_header\n"


def lists(tmp_path, body, *, order=b"binary_little_endian", count=1, length=b"uchar"):
    (tmp_path / "a.ply").write_bytes(HEADER % (order, count, length) + body)
    return tmp_path / "a.ply"


def test_lengths_of_lists_are_held_against_the_file(tmp_path):
    """Rows of 3, 4 and 2 entries take 13 + 17 + 9 bytes, in either byte order."""
    for order, end in ((b"binary_little_endian", "<"), (b"binary_big_endian", ">")):
        rows = [struct.pack(f"{end}B{n}i", n, *range(n)) for n in (3, 4, 2)]
        read_ply_header(lists(tmp_path, b"".join(rows), order=order, count=3))
        read_ply_header(lists(tmp_path, rows[0] * 50, order=order, count=50))
        for body, count in ((b"".join(rows)[:-1], 3), (rows[0] * 50, 51), (b"\xff" + rows[0], 1)):
            with pytest.raises(UserError, match="announces more"):
                read_ply_header(lists(tmp_path, body, order=order, count=count))
    for length, content in (
        (b"char", b"\xff"),
        (b"int", b"\xff" * 4),
        (b"uint", b"\xff" * 4),
        (b"float", b"\0" * 4),
    ):
        with pytest.raises(UserError, match="announces more"):
            read_ply_header(lists(tmp_path, content + bytes(100), length=length))


@pytest.mark.parametrize(
    "header",
    [
        b"ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nend_header\n",
        b"ply\nformat binary_middle_endian 1.0\nelement vertex 1\nproperty float x\nend_header\n1234",
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quaternion x\nend_header\n1 2 3",
        b"ply\nformat ascii 1.0\nproperty float x\nend_header\n",
        b"ply\nelement vertex 1\nproperty float x\nend_header\n1234",
        b"ply\nformat ascii 1.0\nelement vertex\nend_header\n",
        b"ply" + b"x" * 3_000_000,
    ],
)
def test_headers_that_make_no_sense_are_refused(tmp_path, header):
    (tmp_path / "a.ply").write_bytes(header)
    with pytest.raises(UserError, match="a.ply is (not a readable PLY|truncated)"):
        read_ply(tmp_path / "a.ply")


@pytest.mark.parametrize(
    ("name", "value"), [("x", 1e30), ("f_dc_1", 1e300), ("scale_1", 50), ("f_rest_3", -1e9)]
)
def test_values_that_float32_cannot_compute_with_are_dropped_with_a_warning(tmp_path, name, value):
    properties = {key: values.astype(np.float64) for key, values in columns(1).items()}
    properties[name][3] = value
    with pytest.warns(UserWarning, match="dropped 1 Gaussians with values beyond .*1e"):
        cloud = read_ply(save(tmp_path / "a.ply", properties))
    np.testing.assert_allclose(cloud.means[:, 1], np.delete(properties["y"], 3), rtol=1e-6)
    properties[name][:] = value
    with pytest.raises(UserError, match="all Gaussians in .* beyond"):
        read_ply(tmp_path / save(tmp_path / "a.ply", properties))


@pytest.mark.parametrize("factor", [1e300, 1e-300])
def test_the_length_of_a_quaternion_does_not_matter(tmp_path, factor):
    properties = {key: values.astype(np.float64) for key, values in columns().items()}
    expected = read_ply(save(tmp_path / "a.ply", properties))
    for name in ROTATION:
        properties[name][:] *= factor
    cloud = read_ply(save(tmp_path / "b.ply", properties))
    np.testing.assert_allclose(cloud.quats, expected.quats, rtol=1e-6)


def test_opacity_logits_may_have_any_size(tmp_path):
    properties = {key: values.astype(np.float64) for key, values in columns().items()}
    properties["opacity"][:2] = 1e300, -1e300
    np.testing.assert_array_equal(read_ply(save(tmp_path / "a.ply", properties)).opacities[:2], [1, 0])
