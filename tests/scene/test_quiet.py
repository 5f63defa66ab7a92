"""Half a second of nothing, as a viewer sees it: whatever is loaded stays where it is."""

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


@pytest.mark.filterwarnings("ignore:only .* particles per grid cell")
@pytest.mark.parametrize("hold", ["none", "base"])
@pytest.mark.parametrize("name", [*OBJECTS, *PROCEDURAL])
@pytest.mark.parametrize("soft", [False, True], ids=["own", "soft"])
def test_nothing_moves_while_nothing_acts(folder, name, hold, soft):
    if name in PROCEDURAL:
        found = {"path": str(folder / f"{name}.ply"), "up": "+z"}
        write_ply(found["path"], PROCEDURAL[name](0))
    else:
        found = export(name, folder)
    parts = {"material": {"youngs_modulus": 2e4}} if soft else {}
    scene, _ = scene_of(
        found["path"], frames=FRAMES, cells=64, particles=3000, object=found, anchor={"kind": hold}, **parts
    )
    assert measure_motion(scene) < MOST
