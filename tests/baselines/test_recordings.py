"""Recordings: simulations of tasks are clean, what the judge of clauses lets pass is not, and files of others enter."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from baselines.recordings import main, rate
from baselines.tasks import load_tasks, load_witnesses, make_task

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks" / "tasks"
TASKS = {spec.name: spec for spec in load_tasks(FOLDER)}
WITNESSES = load_witnesses(FOLDER)
QUICK = "impulse-loaf-right"
UP = np.array([0.0, 0.0, 1.0])


def shake(x, length):
    return x + 0.01 * length * np.random.default_rng(0).normal(size=x.shape)


def sink(x, length):
    return x - np.linspace(0, 0.09 * length, len(x))[:, None, None] * UP


def jump(x, length):
    """The pose of the end, from frame 1 on."""
    return np.concatenate([x[:1], np.repeat(x[-1:], len(x) - 1, axis=0)])


WRONG = [
    (QUICK, sink, "sinking"),
    *(
        pytest.param(name, change, term, marks=pytest.mark.slow)
        for name, change, term in (
            ("sway-plant", shake, "noise"),
            ("sway-plant", sink, "slip"),
            ("stretch-loaf-flat", jump, "jump"),
            ("twist-robot-clockwise", jump, "jump"),
            ("twist-robot-clockwise", shake, "noise"),
        )
    ),
]
"""Task, change of its witness's clip that no body could make, and the term that it lowers."""


@cache
def simulate(name, folder):
    task = make_task(TASKS[name], folder)
    x = np.asarray(task.simulate(WITNESSES[name]), np.float64)
    return task, x, float(np.ptp(x[0], axis=0).max())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("objects")


@pytest.mark.parametrize(("name", "change", "term"), WRONG)
def test_what_no_body_could_do_lowers_its_own_term(name, change, term, folder):
    task, x, length = simulate(name, folder)
    clean = rate(task, WITNESSES[name], x)
    assert task.judge(x).success and clean.score == 1
    changed = change(x, length)
    assert change is shake or task.judge(changed).success  # a clause of integrity sees noise as well
    assert rate(task, WITNESSES[name], changed).faults == (term,)


def test_a_file_of_another_simulator_is_judged(folder, tmp_path, capsys):
    _, x, length = simulate(QUICK, folder)
    np.savez(tmp_path / "clip.npz", x=sink(x[:, ::2], length))
    assert main([str(tmp_path / "clip.npz"), "--task", QUICK]) == 0
    told = capsys.readouterr().out
    assert (
        "success, error" in told
        and "flight: not rated" in told
        and "fidelity 0." in told
        and ": sinking" in told
    )


@pytest.mark.parametrize("arrays", [{}, {"x": np.zeros((5, 30, 3))}])
def test_a_file_that_is_no_recording_is_refused(arrays, tmp_path, capsys):
    np.savez(tmp_path / "clip.npz", **arrays)
    assert main([str(tmp_path / "clip.npz"), "--task", QUICK]) == 2
    assert "`x`" in capsys.readouterr().err
    (tmp_path / "clip.txt").write_text("no")
    assert main([str(tmp_path / "clip.txt"), "--task", QUICK]) == 2
