"""Half a second of nothing, as a viewer sees it: whatever is loaded stays where it is."""

from typing import Any

import numpy as np
import pytest

from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import PROCEDURAL
from physagent_jax.simulation.simulate import simulate_frames
from tests.scene.quiet_objects import OBJECTS, export
from tests.scene.test_equilibrium import scene_of

FRAMES = 14  # of 0.04 s
MOST = 0.01  # [L]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("quiet")


def measure_motion(scene):
    """The way [L] that all but a hundredth of the particles stay below."""
    rest, most = np.asarray(scene.state.x), 0.0
    for frame in simulate_frames(scene):
        way = np.linalg.norm(np.asarray(frame.state.x) - rest, axis=1)
        assert np.isfinite(way).all()
        most = max(most, float(np.percentile(way, 99)))
    return most / scene.body.extent


CASES = [
    *((name, hold, None) for name in (*OBJECTS, *PROCEDURAL) for hold in ("none", "base")),
    *((name, "top", None) for name in ("tree", "table", "shoe", "vase", "lamp", *PROCEDURAL)),
    *((name, "none", 2e4) for name in ("table", "shoe", "jelly", "plant")),
    *((name, "none", 2e6) for name in ("vase", "loaf")),
]


USUAL = [
    ("tree", "base", None),
    ("lamp", "base", None),
    ("statue", "none", None),
    ("table", "none", 2e4),
    ("vase", "none", None),
    ("plant", "base", None),
    ("jelly", "none", None),
    ("tree", "top", None),
]
"""One case of each kind of object; all of them take minutes."""


def load(folder, name, hold, youngs_modulus, **size):
    path = folder / f"{name}.ply"
    if name in PROCEDURAL and not path.exists():
        write_ply(path, PROCEDURAL[name](0))
    found = {"path": str(path), "up": "+z"} if name in PROCEDURAL else export(name, folder)
    parts: dict[str, Any] = {} if youngs_modulus is None else {"material": {"youngs_modulus": youngs_modulus}}
    return scene_of(found["path"], frames=FRAMES, object=found, anchor={"kind": hold}, **size, **parts)[0]


@pytest.mark.filterwarnings("ignore:the object is thinly filled")
@pytest.mark.parametrize(
    ("name", "hold", "youngs_modulus"),
    [case if case in USUAL else pytest.param(*case, marks=pytest.mark.slow) for case in CASES],
)
def test_nothing_moves_while_nothing_acts(folder, name, hold, youngs_modulus):
    assert set(USUAL) <= set(CASES)
    assert measure_motion(load(folder, name, hold, youngs_modulus, cells=64, particles=3000)) < MOST


@pytest.mark.slow
@pytest.mark.parametrize(("name", "hold", "youngs_modulus"), CASES)
def test_nothing_moves_at_the_default_size(folder, name, hold, youngs_modulus):
    assert measure_motion(load(folder, name, hold, youngs_modulus, cells=96, particles=20_000)) < MOST
