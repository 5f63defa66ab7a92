"""PlayCanvas SOG: bundles of small lossless images against the formulas of the format."""

import io
import json
import struct
import zipfile

import cv2
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats import read_splats
from physagent_jax.gaussians.formats.lossless_image import decode_image
from tests.gaussians.format_bytes import small_sog, sog_files, webp, zipped


def read(tmp_path, content):
    path = tmp_path / "a.sog"
    path.write_bytes(content)
    return read_splats(path)


def at(images, name, index):
    return images[name].reshape(-1, 4)[index].astype(float)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("bands", [1, 2, 3])
def test_pixels_stand_for_what_the_layout_says(tmp_path, version, bands):
    meta, images = small_sog(version, bands=bands)
    cloud = read(tmp_path, zipped(sog_files(meta, images))).cloud
    assert cloud.count == 3 and cloud.sh_degree == bands
    for i in range(3):
        level = (at(images, "means_l.webp", i)[:3] + 256 * at(images, "means_u.webp", i)[:3]) / 65535
        log = np.array(meta["means"]["mins"]) + level * np.subtract(
            meta["means"]["maxs"], meta["means"]["mins"]
        )
        np.testing.assert_allclose(cloud.means[i], np.sign(log) * (np.exp(np.abs(log)) - 1), rtol=2e-6)
        *three, tag = at(images, "quats.webp", i)
        three = (np.array(three) / 255 - 0.5) * np.sqrt(2)
        quat = np.insert(three, int(tag) - 252, np.sqrt(max(1 - np.sum(three**2), 0)))
        np.testing.assert_allclose(cloud.quats[i], quat / np.linalg.norm(quat), atol=1e-6)
        scale, colour = at(images, "scales.webp", i), at(images, "sh0.webp", i)
        palette = images["shN_centroids.webp"].reshape(64, -1, 4)[int(at(images, "shN_labels.webp", i)[0])]
        if version == 2:
            book = np.linspace(-3, 2, 256)
            expected = np.exp(book[scale[:3].astype(int)]), book[colour[:3].astype(int)], colour[3] / 255
            rest = book[palette[:, :3]]
        else:
            low, high = (np.array(meta["scales"][key]) for key in ("mins", "maxs"))
            clow, chigh = (np.array(meta["sh0"][key]) for key in ("mins", "maxs"))
            plain = clow + (chigh - clow) * colour / 255
            expected = np.exp(low + (high - low) * scale[:3] / 255), plain[:3], 1 / (1 + np.exp(-plain[3]))
            rest = -0.5 + 1.25 * palette[:, :3] / 255
        np.testing.assert_allclose(cloud.scales[i], expected[0], rtol=2e-6)
        np.testing.assert_allclose(cloud.sh[i, 0], expected[1], rtol=1e-5, atol=1e-6)
        assert cloud.opacities[i] == pytest.approx(expected[2], abs=1e-6)
        np.testing.assert_allclose(cloud.sh[i, 1:], rest, rtol=1e-5, atol=1e-6)


def test_a_folder_reads_as_its_bundle(tmp_path):
    files = sog_files(*small_sog())
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    one, other = (
        read_splats(tmp_path / "meta.json").cloud,
        read(tmp_path, zipped(files, zipfile.ZIP_DEFLATED)).cloud,
    )
    np.testing.assert_array_equal(one.means, other.means)
    np.testing.assert_array_equal(one.sh, other.sh)


def test_lossless_pixels_survive_whatever_their_opacity():
    Image = pytest.importorskip("PIL.Image", reason="OpenCV's writer clears pixels without opacity")
    pixels = np.random.default_rng(0).integers(0, 256, (37, 53, 4)).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "WEBP", lossless=True, exact=True)
    decoded = decode_image(stream.getvalue(), "it", least=1, most=10_000, flat=False)
    np.testing.assert_array_equal(decoded, pixels)


def test_a_rotation_without_a_component_is_said(tmp_path):
    meta, images = small_sog()
    images["quats.webp"][0, 0, 3] = 100
    loaded = read(tmp_path, zipped(sog_files(meta, images)))
    assert any("1 quaternions of norm zero" in note for note in loaded.notes)


def change(meta=None, files=None, **images):
    """A bundle with something changed; a value of None leaves a file out."""
    tree, pictures = small_sog()
    tree |= meta or {}
    made = sog_files(tree, pictures) | (files or {})
    return zipped({name: data for name, data in made.items() if data is not None})


def lossy():
    done, data = cv2.imencode(".webp", np.zeros((2, 2, 3), np.uint8), [cv2.IMWRITE_WEBP_QUALITY, 50])
    assert done
    return data.tobytes()


def oversized():
    """A WebP whose header tells 16,384 x 16,384 pixels."""
    data = bytearray(webp(np.zeros((2, 2, 4))))
    place = data.index(b"VP8L") + 9
    data[place : place + 4] = struct.pack("<I", 0x3FFF | 0x3FFF << 14)
    if b"VP8X" in data:
        data[data.index(b"VP8X") + 12 : data.index(b"VP8X") + 18] = b"\xff\x3f\0" * 2
    return bytes(data)


SMALL_BOOK = {"codebook": [0.0, 1.0], "files": ["scales.webp"]}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (change(files={"quats.webp": None}), "no entry quats.webp"),
        (change(files={"meta.json": None}), "no entry meta.json"),
        (change(meta={"count": 5}), "2 x 2 pixels"),
        (change(meta={"count": 4_000_000_000}), "announces more than it holds"),
        (change(meta={"scales": SMALL_BOOK}), "codebook of 2"),
        (change(meta={"version": 3}), "version"),
        (change(files={"sh0.webp": lossy()}), "compressed with loss"),
        (change(files={"sh0.webp": b"GIF89a"}), "no image that is read"),
        (change(files={"sh0.webp": webp(np.zeros((2, 2, 4)))[:-8]}), "damaged image|no image"),
        (change(files={"sh0.webp": webp(np.zeros((2, 2, 4)))[:27]}), "damaged image"),
        (change(files={"means_l.webp": oversized()}), "16384 x 16384 pixels"),
        (change(files={"meta.json": b"{"}), "not valid JSON"),
        (change()[:-60], "damaged SOG bundle"),
    ],
)
def test_damage_is_refused_in_one_line(tmp_path, content, message, capfd):
    with pytest.raises(UserError, match=message) as refused:
        read(tmp_path, content)
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")  # libraries say nothing of their own


def test_an_entry_that_unpacks_to_far_more_is_refused_before_it_does(tmp_path):
    files = sog_files(*small_sog()) | {"quats.webp": bytes(64 * 2**20)}
    with pytest.raises(UserError, match="unpacks to far more"):
        read(tmp_path, zipped(files, zipfile.ZIP_DEFLATED))


@pytest.mark.parametrize("name", ["../secret.webp", "/etc/passwd", "a\\b.webp", ".."])
def test_names_outside_the_folder_are_refused(tmp_path, name):
    meta, _ = small_sog()
    meta["quats"]["files"] = [name]
    (tmp_path / "meta.json").write_text(json.dumps(meta))
    for file, data in sog_files(*small_sog()).items():
        if file != "meta.json":
            (tmp_path / file).write_bytes(data)
    with pytest.raises(UserError, match="outside its folder"):
        read_splats(tmp_path / "meta.json")
