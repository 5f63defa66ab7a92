"""The paper's preset, damped as it is, does what its sentences say: from the pictures, checked by particles."""

import numpy as np
import pytest

from physagent_jax.metrics.motion import measure_true_motion
from physagent_jax.run.finished import open_run
from tests.run.specs import made, small


@pytest.mark.parametrize("world", ["ground", pytest.param("free", marks=pytest.mark.slow)])
def test_the_readmes_sentence_succeeds_and_the_particles_agree(robot_path, tmp_path, world):
    spec = small(
        robot_path, preset="paper", world=world, frames=50, particles=8000, resolution=240,
    )  # fmt: skip
    spec = spec.model_copy(update={"overrides": spec.overrides.model_copy(update={"cells": 72})})
    run = open_run(made(spec, tmp_path / "run").path)
    assert run.manifest is not None and run.scene is not None and run.best is not None
    assert run.scene.transfer.damping_rate == pytest.approx(2.5, rel=0.01)
    assert run.manifest.verdict == "SUCCESS"
    truth = measure_true_motion(np.asarray(run.motion().x, np.float64))
    left = -np.array(truth.centroid)[:, 0]
    assert 0.4 < left[-1] < 1.8 and left[-1] == pytest.approx(left.max(), rel=0.05)
    assert np.abs(np.array(truth.centroid)[:, 2]).max() < 0.1
    assert max(truth.rotation_degrees) < 30
