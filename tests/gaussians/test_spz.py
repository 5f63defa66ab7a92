"""Niantic's SPZ: files packed value by value, and what is written read again within the stated quantisation."""

import gzip
import struct

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import GaussianCloud
from physagent_jax.gaussians.covariance import quat_to_matrix
from physagent_jax.gaussians.formats import read_splats
from physagent_jax.gaussians.formats.spz_writer import write_spz
from tests.fuzz.contract import limited
from tests.gaussians.format_bytes import smallest_three, spz, spz4

BASE = dict(
    position=(4096, -2048, 1), alpha=51, colour=(128, 0, 255), scale=(160, 0, 255), rotation=(128, 128, 128)
)
IDENTITY3 = smallest_three(3, [(0, 0)] * 3)


def read(tmp_path, content):
    path = tmp_path / "a.spz"
    path.write_bytes(content)
    return read_splats(path)


@pytest.mark.parametrize("version", [2, 3])
def test_values_stand_for_what_the_layout_says(tmp_path, version):
    gaussian = BASE | (dict(rotation=IDENTITY3) if version == 3 else {})
    loaded = read(tmp_path, spz(version, [gaussian]))
    cloud = loaded.cloud
    np.testing.assert_allclose(cloud.means[0], [1, -0.5, 1 / 4096])
    np.testing.assert_allclose(np.log(cloud.scales[0]), [0, -10, 255 / 16 - 10], atol=1e-6)
    assert cloud.opacities[0] == pytest.approx(0.2)
    np.testing.assert_allclose(cloud.sh[0, 0], (np.array([128, 0, 255]) / 255 - 0.5) / 0.15, rtol=1e-6)
    assert loaded.up == "+y"
    assert any("give --up" in note for note in loaded.notes)


def test_version_1_has_half_precision_positions(tmp_path):
    cloud = read(tmp_path, spz(1, [BASE | dict(position=(0.5, -2.0, 1024.0))])).cloud
    np.testing.assert_array_equal(cloud.means[0], [0.5, -2.0, 1024.0])


def test_version_2_leaves_out_w(tmp_path):
    """x = 1/2 within a byte: a turn by 60 degrees about x."""
    quat = read(tmp_path, spz(2, [BASE | dict(rotation=(191, 128, 128))])).cloud.quats[0]
    x, y = 191 / 127.5 - 1, 128 / 127.5 - 1
    np.testing.assert_allclose(quat, [np.sqrt(1 - x * x - 2 * y * y), x, y, y], atol=1e-6)


@pytest.mark.parametrize("place", range(4))
def test_version_3_leaves_out_the_largest_of_xyzw(tmp_path, place):
    parts = [(0, 511), (1, 255), (0, 0)]
    quat = read(tmp_path, spz(3, [BASE | dict(rotation=smallest_three(place, parts))])).cloud.quats[0]
    three = np.array([511, -255, 0]) / 511 * np.sqrt(0.5)
    xyzw = np.insert(three, place, np.sqrt(1 - np.sum(three**2)))
    np.testing.assert_allclose(quat, xyzw[[3, 0, 1, 2]], atol=1e-6)


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_higher_harmonics_stand_coefficient_by_coefficient(tmp_path, degree):
    count = 3 * ((degree + 1) ** 2 - 1)
    gaussian = BASE | dict(rest=[i + 60 for i in range(count)])
    loaded = read(tmp_path, spz(2, [gaussian], degree=degree))
    expected = ((np.arange(count) + 60.0 - 128) / 128).reshape(-1, 3)[:15]
    np.testing.assert_allclose(loaded.cloud.sh[0, 1:], expected, rtol=1e-6)
    assert any("cut to degree 3" in note for note in loaded.notes) == (degree == 4)


def test_the_header_says_how_fine_positions_are(tmp_path):
    cloud = read(tmp_path, spz(2, [BASE], fractional_bits=4)).cloud
    np.testing.assert_array_equal(cloud.means[0], np.array([4096, -2048, 1]) / 16)


def coordinates(value):
    return struct.pack("<III", 0xADBE0002, 12, 0) + bytes(8) + struct.pack("<III", 0xADBE0003, 4, value)


@pytest.mark.parametrize(("value", "up"), [(4, "+y"), (6, "-y"), (12, "+z"), (14, "-z")])
def test_a_stated_coordinate_system_is_believed(tmp_path, value, up):
    """RUB, RDF, RFU and RBD: y up, y down, z up, z down; all of them right-handed."""
    loaded = read(tmp_path, spz(2, [BASE], flags=2, extensions=coordinates(value)))
    assert loaded.up == up and not loaded.notes


def test_a_left_handed_system_is_refused(tmp_path):
    with pytest.raises(UserError, match="left-handed axes.*RUF"):
        read(tmp_path, spz(2, [BASE], flags=2, extensions=coordinates(8)))


def test_version_4_has_a_stream_for_each_attribute(tmp_path):
    gaussians = [BASE | dict(rotation=IDENTITY3, position=(4096 * i, 0, 0)) for i in range(5)]
    loaded = read(tmp_path, spz4(gaussians, flags=2, extensions=coordinates(6)))
    np.testing.assert_array_equal(loaded.cloud.means[:, 0], range(5))
    assert loaded.up == "-y"
    damaged = bytearray(spz4(gaussians))
    damaged[40] += 1  # the size of the positions
    with pytest.raises(UserError, match="16 bytes of positions|bytes of positions for 5"):
        read(tmp_path, bytes(damaged))


def test_a_stream_of_version_4_that_unpacks_to_more_is_refused(tmp_path):
    """The frame says and holds a gigabyte where 45 bytes should be; not more than those are unpacked."""
    run = (2**30 - 1).to_bytes(4, "little")
    blocks = b"".join(
        (2**17 << 3 | 1 << 1 | (i == 2**13 - 1)).to_bytes(3, "little") + b"a" for i in range(2**13)
    )

    def bomb(_):
        return struct.pack("<IB", 0xFD2FB528, 0b10100000) + run + blocks

    gaussians = [BASE | dict(rotation=IDENTITY3)] * 5
    with limited(20.0), pytest.raises(UserError):
        read(tmp_path, spz4(gaussians, bomb))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (spz(2, [BASE])[:-9], "truncated or damaged|damaged SPZ"),
        (spz(2, [BASE], count=4_000_000_000), "announces more than it holds"),
        (spz(2, [BASE], count=2), "announces more than it holds"),
        (spz(2, [], count=0), "holds no Gaussians"),
        (spz(2, [BASE], degree=5), "degree 5"),
        (spz(7, [BASE]), "version 7"),
        (gzip.compress(b"NGSP", mtime=0), "no header"),
        (b"NGSP" + bytes(8), "no header"),
        (b"NGSP" + struct.pack("<I", 5) + bytes(30), "version 5"),
    ],
    ids=[
        "cut",
        "four billion announced",
        "one too many announced",
        "none",
        "degree",
        "version",
        "no header",
        "no version",
        "version 5",
    ],
)
def test_damage_is_refused_in_one_line(tmp_path, content, message):
    with pytest.raises(UserError, match=message) as refused:
        read(tmp_path, content)
    assert "\n" not in str(refused.value)


def test_a_small_file_that_unpacks_to_gigabytes_is_refused_before_it_does(tmp_path):
    count = 40_000_000
    header = struct.pack("<4sIIBBBB", b"NGSP", 2, count, 3, 12, 0, 0)
    content = gzip.compress(header + bytes(4_000_000))
    with pytest.raises(UserError, match="announces more than it holds"):
        read(tmp_path, content)


# --- writing -----------------------------------------------------------------------------------------------


def make_cloud(count=200, degree=2, seed=3):
    rng = np.random.default_rng(seed)
    quats = rng.normal(size=(count, 4))
    sh = rng.uniform(-0.9, 0.9, (count, (degree + 1) ** 2, 3))
    return GaussianCloud(
        means=np.float32(rng.normal(size=(count, 3)) * [0.5, 3, 1]),
        quats=np.float32(quats / np.linalg.norm(quats, axis=1, keepdims=True)),
        scales=np.float32(np.exp(rng.uniform(-9, 2, (count, 3)))),
        opacities=np.float32(rng.uniform(size=count)),
        sh=np.float32(sh),
    )


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_what_is_written_is_read_within_the_stated_quantisation(tmp_path, degree):
    cloud = make_cloud(degree=degree)
    write_spz(tmp_path / "a.spz", cloud)
    again = read_splats(tmp_path / "a.spz").cloud
    largest = np.abs(cloud.means).max()
    assert np.abs(again.means - cloud.means).max() <= max(2.0**-21, largest * 2.0**-23) + 1e-7 * largest
    assert np.abs(np.log(again.scales / cloud.scales)).max() <= 1 / 32 + 1e-5
    assert np.abs(again.opacities - cloud.opacities).max() <= 0.5 / 255 + 1e-6
    assert np.abs(again.sh[:, 0] - cloud.sh[:, 0]).max() <= 0.5 / (255 * 0.15) + 1e-6
    assert np.abs(again.sh[:, 1:] - cloud.sh[:, 1:]).max(initial=0) <= 0.5 / 128 + 1e-6
    sign = np.sign(np.sum(np.asarray(again.quats) * cloud.quats, axis=1, keepdims=True))
    assert np.abs(np.asarray(again.quats) * sign - cloud.quats).max() <= 0.0021
    turned = np.abs(np.asarray(quat_to_matrix(again.quats) - quat_to_matrix(cloud.quats)))
    assert turned.max() < 0.01


def test_large_coordinates_leave_fewer_fractional_bits(tmp_path):
    cloud = make_cloud(20)
    far = GaussianCloud(cloud.means * 1e5, cloud.quats, cloud.scales, cloud.opacities, cloud.sh)
    write_spz(tmp_path / "a.spz", far)
    again = read_splats(tmp_path / "a.spz").cloud
    assert np.abs(again.means - far.means).max() <= np.abs(far.means).max() * 2.0**-22
    with pytest.raises(UserError, match="too far away or too large for SPZ"):
        write_spz(
            tmp_path / "b.spz",
            GaussianCloud(cloud.means * 1e8, cloud.quats, cloud.scales, cloud.opacities, cloud.sh),
        )


def test_sizes_that_the_format_cannot_hold_are_said(tmp_path):
    cloud = make_cloud(20)
    tiny = GaussianCloud(cloud.means, cloud.quats, cloud.scales * 1e-9, cloud.opacities, cloud.sh)
    with pytest.warns(UserWarning, match="20 Gaussians are smaller than 4.5e-05"):
        write_spz(tmp_path / "a.spz", tiny)
    with pytest.warns(UserWarning, match="relative to"):
        write_spz(tmp_path / "a.spz", cloud, origin=np.array([1e6, 0, 0]))


def test_the_same_cloud_gives_the_same_bytes(tmp_path):
    for name in "ab":
        write_spz(tmp_path / name, make_cloud())
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
