"""The estimated cost of a scene, and its refusal above a limit that an option raises."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import (
    Domain,
    Filling,
    Material,
    MaterialRegion,
    Rendering,
    SceneConfig,
    Source,
    Timing,
)
from physagent_jax.scene.cost import Limits, check_cost, estimate_cost, read_machine_memory


@pytest.fixture(scope="module")
def body(robot_path):
    return make_body(Source(path=str(robot_path), up="-y"), Filling(max_particles=1500), Domain(), ".")


def scene(**changes):
    return SceneConfig(source=Source(path="robot.ply"), **changes)


@pytest.mark.parametrize(
    ("changes", "most"),
    [
        (
            dict(rendering=Rendering(width=4096, height=4096), timing=Timing(frame_count=200)),
            "pictures of 4096",
        ),
        (dict(timing=Timing(frame_count=10_000)), "pictures of 320"),
        (
            dict(timing=Timing(frame_count=10_000), rendering=Rendering(width=16, height=16)),
            "frames of 1,500",
        ),
        (dict(domain=Domain(size=1.2, cells=1024)), "a grid of"),
    ],
)
def test_memory_is_refused_with_what_takes_most_of_it(changes, most, body):
    """Each of these took all memory, minutes after it was begun; each is told what would do."""
    cost = estimate_cost(scene(**changes), body)
    with pytest.raises(UserError, match=f"GB of memory, most of it for .*{most}.*--max-memory"):
        check_cost(cost, Limits(minutes=1e6, memory=2.0))
    check_cost(cost, Limits(minutes=1e6, memory=1.1 * cost.memory / 1e9))


@pytest.mark.parametrize(
    "changes",
    [
        dict(timing=Timing(frame_dt=100.0, frame_count=1000)),
        dict(material=Material(youngs_modulus=1e12)),
        dict(
            material_regions=(
                MaterialRegion(point=(2, 2, 2), half_size=(1, 1, 1), material=Material(youngs_modulus=1e12)),
            )
        ),
        dict(timing=Timing(substep_dt=1e-9, force_substep=True)),
    ],
)
def test_time_is_refused_with_the_substeps_that_take_it(changes, body):
    with pytest.raises(UserError, match="substeps of 1,500 particles.*--max-minutes"):
        check_cost(estimate_cost(scene(**changes), body), Limits(minutes=5))


def test_usual_scenes_are_not_refused(body):
    cost = estimate_cost(scene(), body)
    assert cost.seconds < 60 and cost.memory < 2e9
    check_cost(cost, Limits())


def test_limits_are_numbers():
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(UserError, match="--max-minutes"):
            Limits(minutes=value)
        with pytest.raises(UserError, match="--max-memory"):
            Limits(memory=value)
    assert 1e8 < read_machine_memory() < 1e15


def test_the_command_refuses_before_it_begins_and_runs_when_told_to(
    robot_path, tmp_path, capsys, monkeypatch
):
    simulate: Any = importlib.import_module(
        "physagent_jax.mpm.simulate"
    )  # its name in the package is the function's
    frames, next_frame = [], simulate.next_frame
    monkeypatch.setattr(simulate, "next_frame", lambda *given: frames.append(0) or next_frame(*given))
    arguments = ["run", "--object", robot_path, "--prompt", "push the robot to the left", "--frames", 4]
    arguments += ["--particles", 300, "--resolution", 64, "--max-iterations", 1, "--video-size", "off"]
    arguments += ["--out", tmp_path / "run"]
    arguments = [str(argument) for argument in arguments]
    assert main([*arguments, "--max-memory", "0.1"]) == 2
    assert not frames and not (tmp_path / "run").exists()
    assert "--max-memory" in capsys.readouterr().err
    assert main([*arguments, "--max-memory", "2"]) == 0
    assert len(frames) >= 3


def test_the_estimate_of_substeps_is_not_above_what_is_simulated(body):
    """The bound of matter at rest is the longest; what moves needs shorter steps."""
    from physagent_jax.mpm import stable_dt
    from physagent_jax.scene.compile import compile_scene

    config = scene(material=Material(youngs_modulus=3e5, poissons_ratio=0.2))
    compiled = compile_scene(config, body)
    duration = (config.timing.frame_count - 1) * config.timing.frame_dt
    bound = float(stable_dt(compiled.model, compiled.state))
    exact = duration / (config.timing.safety * bound)
    np.testing.assert_allclose(estimate_cost(config, body).substeps, exact, rtol=0.02)
