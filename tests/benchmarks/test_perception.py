"""The perception benchmark's clips are what they say, and its counts count."""

import numpy as np
import pytest

from benchmarks.perception import scenes
from benchmarks.perception.markdown import FIGURES, condense, summarize, write_tables
from benchmarks.perception.motions import LOOK, MOTIONS
from physagent_jax.core.rotations import polar


@pytest.fixture(scope="module")
def sight():
    frames, scenes.FRAMES = scenes.FRAMES, 3
    yield scenes.film("loaf", MOTIONS["right 0.5"], 3.2)
    scenes.FRAMES = frames


def test_the_object_moves_as_it_should(sight):
    moved = (sight.means[-1].mean(0) - sight.means[0].mean(0)) / sight.size
    assert moved == pytest.approx((0.5, 0, 0), abs=1e-6)
    columns = [np.nonzero(a > 0.5)[1].mean() for a in sight.alpha]
    z = float(np.median(sight.depth[0][sight.alpha[0] > 0.5]))
    assert columns[-1] - columns[0] == pytest.approx(0.5 / z * sight.camera.K[0, 0], rel=0.1)


@pytest.mark.parametrize("background", scenes.BACKGROUNDS)
def test_depth_is_what_a_camera_has(sight, background):
    rgb, clean = scenes.compose(sight, background, "none", 1)
    noisy = scenes.compose(sight, background, "camera", 1)[1]
    assert rgb.dtype == np.uint8 and rgb.shape[:3] == clean.shape
    everywhere = np.isfinite(clean) & (clean > 0)
    assert everywhere.all() == (background != "plain")
    missing = everywhere & ~np.isfinite(noisy)
    assert 0.01 < missing.sum() / everywhere.sum() < 0.25
    both = everywhere & np.isfinite(noisy)
    assert np.std((noisy - clean)[both] / clean[both] ** 2) == pytest.approx(0.0012, rel=0.1)
    assert (sight.depth[sight.alpha > 0.5] <= clean[sight.alpha > 0.5] + 0.3).all()


def test_motions_are_in_the_plane_or_not():
    for name, motion in MOTIONS.items():
        R, S = polar(motion.matrix(1.0))
        tilt = np.degrees(np.arccos(np.clip(LOOK @ R @ LOOK, -1, 1)))
        assert motion.in_plane == (tilt < 1), name
        assert np.allclose(motion.matrix(0.0), np.eye(3)) and np.allclose(motion.shift(0.0), 0)
        assert S == pytest.approx(np.diag(motion.factors(1.0)), abs=1e-9)


def test_what_is_not_observed_is_counted_apart():
    rows = [{"displacement": e, "displacement_stated": 0.02} for e in (0.01, 0.04, None, 0.015)]
    counted = summarize(rows, FIGURES[0])
    assert counted["unobservable"] == 0.25
    assert counted["within"] == counted["covered"] == pytest.approx(2 / 3)


def make_row(**other):
    names = {
        f"{name}_stated"
        for name in ("displacement", "across", "along", "rotation", "axis", "stretch", "outline")
    }
    names |= {
        "displacement",
        "direction",
        "across",
        "along",
        "rotation",
        "angle",
        "axis",
        "stretch",
        "outline",
    }
    row = dict.fromkeys(names, 0.012345678) | {"motion": "nothing", "object": "loaf", "distance": "near"}
    row |= {"background": "plain", "noise": "none", "pieces": 1, "still": True, "false_swing": False}
    row |= dict.fromkeys(("has_direction", "in_plane", "turns", "swings"), False)
    return row | {"job": "loaf: nothing", "run": 0, "notes": ["long"], "text": "longer"} | other


def test_a_summary_has_what_tables_need():
    rows = [make_row(displacement=0.09), make_row(displacement=None, depth=0.5, depth_stated=1.0)]
    run = {"machine": "M", "load_average": [1.0], "git_revision": "r", "quick": False, "seconds": 1.0}
    summary = condense({"rgb": {"runs": [run], "complete": True, "rows": rows}})
    assert "longer" not in str(summary) and "0.01235" in str(summary)
    tables = write_tables(summary)
    assert "| rgb | displacement | 3% | 2 | 0% | 50% |" in tables["all"]
    assert "| rgb | 0.09 | 0.0123 | 0.0123 |" in tables["worst"]
    assert "| rgb | 2 | 1.0 |" in tables["runs"]
