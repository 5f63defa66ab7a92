"""Object files on the command line: how they were read is said, what is open is refused, the option settles it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.gaussians import read_ply
from physagent_jax.scene.config import load_scene
from tests.gaussians.test_ply import save
from tests.test_cli import no_cache, refused  # noqa: F401

pytestmark = pytest.mark.usefixtures("quick_plans")


def store(path, cloud, encode_scales, encode_opacities):
    """A cloud as a PLY with values encoded in one way or another."""
    columns = dict(zip("xyz", np.asarray(cloud.means).T))
    columns |= {f"f_dc_{i}": np.asarray(cloud.sh[:, 0, i]) for i in range(3)}
    columns |= {f"scale_{i}": encode_scales(np.asarray(cloud.scales[:, i])) for i in range(3)}
    columns |= {f"rot_{i}": np.asarray(cloud.quats[:, i]) for i in range(4)}
    columns["opacity"] = encode_opacities(np.asarray(cloud.opacities))
    return save(path, columns)


@pytest.fixture
def robot(robot_path):
    return read_ply(robot_path, opacity_threshold=0.1)


@pytest.fixture
def plain(tmp_path, robot):
    """Values without logarithm and logit."""
    return store(tmp_path / "plain.ply", robot, np.array, np.array)


@pytest.fixture
def alike(tmp_path, robot):
    """Opacities of 0.9, which can be 0.71 as logits."""
    return store(tmp_path / "alike.ply", robot, np.log, lambda o: np.full_like(o, 0.9))


PLAN = ("push it to the left", "--up", "-y", "--kind", "robot")


def test_a_plan_says_how_the_file_was_read(capsys, robot_path, plain):
    assert main(["plan", "--object", str(robot_path), *PLAN]) == 0
    out = capsys.readouterr().out
    assert "\nobject: 3DGS PLY: log scales, logit opacities, SH of degree 2, float32 positions; 3,83" in out
    assert "assumed: " not in out or "--splat-encoding" not in out
    assert main(["plan", "--object", str(plain), *PLAN, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["object"].startswith("3DGS PLY: plain scales, plain opacities")
    assert any("stores scales plain and opacities plain" in each for each in said["assumptions"])


def test_an_open_encoding_is_refused_before_anything_is_simulated(capsys, alike, tmp_path):
    words = ["ambiguous", "as logits 0.711", "`--splat-encoding` log-logit or log-plain"]
    refused(capsys, ["plan", "--object", alike, *PLAN], *words)
    run = ["run", "--object", alike, "--prompt", *PLAN, "--out", tmp_path / "run"]
    refused(capsys, run, *words)
    assert not (tmp_path / "run").exists()


def test_the_option_settles_what_is_open(capsys, alike):
    for encoding, opacities in (("log-plain", "plain"), ("log-logit", "logit")):
        assert main(["plan", "--object", str(alike), *PLAN, "--splat-encoding", encoding, "--json"]) == 0
        said = json.loads(capsys.readouterr().out)
        assert said["object"].startswith(f"3DGS PLY: log scales, {opacities} opacities")


def test_a_wrong_encoding_is_refused_before_anything_is_simulated(capsys, plain, tmp_path):
    """Plain sizes of a hundredth of the object, taken as logarithms, are as large as it."""
    words = ["as large as the object", "median size of 1", "--splat-encoding"]
    refused(capsys, ["plan", "--object", plain, *PLAN, "--splat-encoding", "log-logit"], *words)
    run = ["run", "--object", plain, "--prompt", *PLAN, "--out", tmp_path / "run"]
    refused(capsys, [*run, "--splat-encoding", "log-logit"], *words)


def test_a_translated_scene_keeps_the_encoding(capsys, alike, tmp_path):
    config, scene = tmp_path / "config.json", tmp_path / "scene.json"
    config.write_text(json.dumps({"substep_dt": 1e-4, "frame_num": 10, "n_grid": 32, "material": "jelly"}))
    translate = ["import-physgaussian", str(config), "--object", str(alike), "--out", str(scene)]
    refused(capsys, translate, "ambiguous")
    assert main([*translate, "--splat-encoding", "log-plain"]) == 0
    assert load_scene(scene).source.splat_encoding == "log-plain"
