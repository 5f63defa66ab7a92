"""The gradient baseline: its gradient is right, its loss falls, and its run folder is like any other."""

import dataclasses
import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from baselines.oracle_gradient import optimise
from baselines.path_tasks import TASKS, Parameters, make_task
from baselines.run import main
from physagent_jax.forces.skills import compile_force_field
from physagent_jax.mpm import rollout


def in_double_precision(task):
    """The same task with every float in float64."""

    def widen(tree):
        return jax.tree.map(lambda a: a.astype(jnp.float64) if a.dtype == jnp.float32 else a, tree)

    scene = dataclasses.replace(task.scene, model=widen(task.scene.model), state=widen(task.scene.state))
    return dataclasses.replace(task, scene=scene, target=widen(task.target))


@pytest.mark.parametrize("name", ["push", "drop"])
def test_the_gradient_agrees_with_central_differences(name, tmp_path, x64):
    task = in_double_precision(make_task(TASKS[name], tmp_path, frame_count=6, particles=300))
    loss = jax.jit(task.loss)
    at = Parameters.of(task.spec.start_vector, task.spec.start_magnitude, np.float64)
    gradient = np.asarray(jax.jit(jax.grad(task.loss))(at).push)
    h = 1e-5
    for axis in range(3):
        step = h * jnp.eye(3)[axis]
        difference = (loss(Parameters(at.push + step)) - loss(Parameters(at.push - step))) / (2 * h)
        np.testing.assert_allclose(gradient[axis], difference, rtol=1e-6, atol=1e-12)


def test_the_hidden_force_has_zero_loss_and_adam_goes_there(tmp_path):
    task = make_task(TASKS["push"], tmp_path, frame_count=6, particles=300)
    hidden = Parameters.of(task.spec.hidden_vector, task.spec.hidden_magnitude)
    assert float(task.loss(hidden)) < 1e-10
    _, history = optimise(task, iterations=8)
    losses = [step.loss for step in history]
    assert losses[-1] < 0.5 * losses[0]


def test_parameters_mean_what_the_skill_library_means(tmp_path):
    """The optimiser's force, written as JSON and compiled by the library, gives the same path."""
    task = make_task(TASKS["drop"], tmp_path, frame_count=6, particles=300)
    sought = Parameters.of((0.2, -0.5, 0.4), 1.1)
    config = task.solution(sought).config
    rest = np.asarray(task.scene.state.x)
    volume = np.asarray(task.scene.model.volume)
    forces, _ = compile_force_field(
        config.force_field, config.scaling, rest, volume, frame_dt=0.04, frame_count=6
    )
    model = task.scene.model.replace(forces=forces)
    _, states = rollout(model, task.scene.state, frame_count=5, substeps=task.substeps)
    path = (states.x * model.mass[:, None]).sum(1) / model.mass.sum()
    np.testing.assert_allclose(path, task.centroid_path(sought), atol=1e-5)


def test_a_run_folder_is_left(tmp_path, capsys):
    out = tmp_path / "run"
    assert (
        main(
            ["--task", "push", "--iterations", "2", "--out", str(out), "--frames", "5", "--particles", "200"]
        )
        == 0
    )
    printed = capsys.readouterr().out
    lines = [line.split()[0] for line in printed.splitlines()]
    assert lines[:3] == ["iteration", "0", "1"] and "report:" in printed
    steps = json.loads((out / "optimisation.json").read_text())
    assert len(steps) == 2 and steps[0]["loss"] > 0
    assert {"manifest.json", "scene.json", "video.mp4", "motion.npz", "report.html"} <= {
        p.name for p in out.iterdir()
    }


def test_bad_options_are_refused(tmp_path, capsys):
    assert main(["--task", "push", "--iterations", "0", "--out", str(tmp_path / "x")]) == 2
    assert "--iterations" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--frames", "1"], "frame_count"),
        (["--frames", "1000000"], "frame_count"),
        (["--particles", "-5"], "max_particles"),
        (["--learning-rate", "nan"], "--learning-rate"),
    ],
)
def test_options_out_of_range_are_refused_in_one_line(options, message, tmp_path, capsys):
    assert main(["--task", "push", *options, "--out", str(tmp_path / "x")]) == 2
    assert message in capsys.readouterr().err
