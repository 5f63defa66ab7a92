"""The encoding of scales and opacities: found where the values tell it, refused where they do not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import read_ply, read_splats, write_ply
from physagent_jax.gaussians.formats.encoding import ENCODINGS
from physagent_jax.scene.config import SplatEncoding
from tests.gaussians.test_ply import STANDARD, columns, random_cloud, save

UNITS = {"kilometres": 1e-3, "metres": 1.0, "millimetres": 1e3}


def scene(unit: float = 1.0, count: int = 400) -> tuple[dict, np.ndarray, np.ndarray]:
    """Other properties, standard deviations and opacities of Gaussians of 0.3 to 3 spacings in a cube of side 1."""
    rng = np.random.default_rng(1)
    rest = columns(count=count)
    means = rng.uniform(size=(count, 3)) * unit
    rest |= dict(zip("xyz", means.T))
    spacing = unit * count ** (-1 / 3)
    return rest, spacing * np.exp(rng.uniform(-1, 1, (count, 3))), rng.uniform(0.03, 0.99, count)


def store(properties: dict, scales: np.ndarray, opacities: np.ndarray, encoding: str) -> dict:
    """The properties with scales and opacities encoded."""
    first, second = encoding.split("-")
    stored = np.log(scales) if first == "log" else scales
    opacity = np.log(opacities / (1 - opacities)) if second == "logit" else opacities
    return properties | {f"scale_{i}": stored[:, i] for i in range(3)} | {"opacity": opacity}


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_encoding_is_found_from_the_values_in_any_unit(tmp_path, encoding, unit):
    """Or is left open, in large units alone, where logarithms and sizes can be the same numbers."""
    rest, scales, opacities = scene(UNITS[unit])
    path = save(tmp_path / "a.ply", store(rest, scales, opacities, encoding))
    try:
        loaded = read_splats(path)
    except UserError as error:
        assert unit == "millimetres" and f" {encoding} " in str(error)
        loaded = read_splats(path, encoding=encoding)
        assert loaded.notes == ()
    else:
        assert (loaded.notes != ()) == (encoding != "log-logit")
        assert all("--splat-encoding log-logit" in note for note in loaded.notes)
    np.testing.assert_allclose(loaded.cloud.scales, scales, rtol=1e-5)
    np.testing.assert_allclose(loaded.cloud.opacities, opacities, atol=1e-6)
    first, second = encoding.split("-")
    assert loaded.encoding.startswith(f"{first} scales, {second} opacities")


def test_scales_that_can_be_meant_both_ways_are_refused_with_both_readings(tmp_path):
    """Spacing 2: sizes of 0.5 to 1.5 fit it, and so do their exponentials, 1.6 to 4.5."""
    grid = 2.0 * np.stack(np.meshgrid(*[np.arange(6)] * 3), -1).reshape(-1, 3)
    rng = np.random.default_rng(0)
    stored = rng.uniform(0.5, 1.5, (len(grid), 3))
    properties = columns(count=len(grid)) | dict(zip("xyz", grid.T))
    properties |= {f"scale_{i}": stored[:, i] for i in range(3)}
    path = save(tmp_path / "a.ply", properties)
    with pytest.raises(UserError) as error:
        read_ply(path)
    text = str(error.value)
    assert "ambiguous" in text and "(log)" in text and "(plain)" in text
    assert "`--splat-encoding` log-logit or plain-logit (" in text
    np.testing.assert_allclose(
        read_splats(path, encoding="log-logit").cloud.scales, np.exp(stored), rtol=1e-6
    )
    np.testing.assert_allclose(read_splats(path, encoding="plain-logit").cloud.scales, stored, rtol=1e-6)


def test_opacities_that_can_be_meant_both_ways_are_refused_with_both_readings(tmp_path):
    """Alike opacities of 0.9 are 0.71 as logits."""
    rest, scales, _ = scene()
    path = save(tmp_path / "a.ply", store(rest, scales, np.full(400, 0.9), "log-plain"))
    with pytest.raises(
        UserError, match="opacities from 0.9 to 0.9, as logits 0.711 to 0.711.*log-logit or log-plain"
    ):
        read_ply(path)
    for encoding, opacity in (("log-plain", 0.9), ("log-logit", 1 / (1 + np.exp(-0.9)))):
        cloud = read_splats(path, encoding=encoding).cloud
        np.testing.assert_allclose(cloud.opacities, opacity, rtol=1e-6)


def test_a_few_gaussians_alone_can_be_open(tmp_path):
    properties = columns(count=2) | {f"scale_{i}": np.float32([0.2, 0.3]) for i in range(3)}
    with pytest.raises(UserError, match="ambiguous"):
        read_ply(save(tmp_path / "a.ply", properties))


def test_an_encoding_that_does_not_fit_is_refused(tmp_path):
    rest, scales, opacities = scene()
    path = save(tmp_path / "a.ply", store(rest, scales, opacities, "log-logit"))
    with pytest.raises(UserError, match="does not have the encoding.*scales below 0"):
        read_splats(path, encoding="plain-logit")
    with pytest.raises(UserError, match="does not have the encoding.*opacities outside 0 to 1"):
        read_splats(path, encoding="log-plain")
    with pytest.raises(UserError, match="is not known.*log_logits.*Did you mean `log-logit`"):
        read_splats(path, encoding="log_logits")


def test_a_few_values_outside_the_encoding_are_dropped_with_a_count(tmp_path):
    rest, scales, opacities = scene()
    stored = store(rest, scales, opacities, "plain-plain")
    stored["scale_1"][7] = -0.1
    loaded = read_splats(save(tmp_path / "a.ply", stored), encoding="plain-plain")
    assert loaded.cloud.count == 399 and "1 Gaussians have scales below 0" in loaded.notes[0]


def test_what_the_values_do_not_show_is_written_into_the_file(tmp_path):
    """After the element's line, where readers that count the lines of a header do not look."""
    cloud = random_cloud(0)
    write_ply(tmp_path / "a.ply", cloud)
    assert b"comment" not in (tmp_path / "a.ply").read_bytes()
    alike = dataclasses.replace(cloud, opacities=np.full(cloud.count, 0.7, np.float32))
    write_ply(tmp_path / "b.ply", alike)
    lines = (tmp_path / "b.ply").read_bytes().split(b"\n")
    assert lines[2].startswith(b"element vertex") and lines[3] == b"comment splat-encoding log-logit"
    np.testing.assert_allclose(read_ply(tmp_path / "b.ply").opacities, 0.7, rtol=1e-6)


@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_any_cloud_that_is_written_is_read_again(tmp_path, unit):
    """In large units too, where all logarithms are positive."""
    cloud = random_cloud(1, count=60)
    large = dataclasses.replace(
        cloud, scales=unit * (1.01 + np.asarray(cloud.scales)), means=unit * np.asarray(cloud.means)
    )
    write_ply(tmp_path / "a.ply", large)
    np.testing.assert_allclose(read_ply(tmp_path / "a.ply").scales, large.scales, rtol=3e-6)


@pytest.mark.parametrize("name", STANDARD)
def test_real_captures_are_of_the_standard_encoding(shared_data, name):
    loaded = read_splats(shared_data / name)
    assert loaded.encoding.startswith("log scales, logit opacities") and loaded.notes == ()
    assert not loaded.origin.any()


def test_the_names_are_those_of_scene_files():
    assert set(ENCODINGS) == set(SplatEncoding.__args__)
