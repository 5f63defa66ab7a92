"""Time that compilation adds to the first result and that an iteration takes, as the benchmark reports it."""

import pytest

from benchmarks import clips
from benchmarks.startup import JOB, iteration, summary, write_tables
from physagent_jax.kernels import use_cpu
from physagent_jax.run.manifest import FirstClip, Manifest, Stages


def row(number, state, seconds):
    stages = {"compile": 0.25 * seconds, "simulate": 0.5 * seconds}
    return {"round": number, "programs": state, "seconds": seconds, "stages": stages}


ROWS = [
    row(0, "cold", 30.0),
    row(0, "warm", 12.0),
    row(1, "cold", 20.0),
    row(1, "warm", 16.0),
    row(2, "cold", 28.0),
]


def repeat(number, simulate):
    stages = {
        "compile": 9.0,
        "simulate": simulate,
        "render": 1.0,
        "perceive": 2.0,
        "agents": 0.5,
        "write": 7.0,
    }
    return {"round": number, "stages": stages, "particles": 20000, "frames": 50, "substeps": 1300}


ITERATIONS = [repeat(0, 3.0), repeat(1, 5.0), repeat(2, 4.0)]


def test_compilation_is_what_cold_runs_take_longer():
    found = summary(ROWS)
    assert found["cold"] == {"median": 28.0, "range": [20.0, 30.0]}
    assert found["warm"] == {"median": 14.0, "range": [12.0, 16.0]}
    assert found["share_of_compilation"] == pytest.approx(0.5)


def test_an_iteration_is_its_four_stages_without_compiling_and_writing():
    found = iteration(ITERATIONS)
    assert (found["median"], found["range"], found["particles"]) == (7.5, [6.5, 8.5], 20000)


def section(rows):
    run = dict(command="c", machine="m", git_revision="abc", load_average=[0.1], quick=False, seconds=1.0)
    return {"runs": [run], "complete": True, "rows": [row | {"run": 0, "job": "j"} for row in rows]}


def test_the_tables_show_each_run_and_what_is_left_of_it():
    tables = write_tables({"first": section(ROWS), "iteration": section(ITERATIONS)})
    stages = tables["stages"].splitlines()
    assert "| 1 | cold | 7.5 | 15.0 | 7.5 | 30.0 |" in stages
    assert sum(line.startswith(("| 1 |", "| 2 |", "| 3 |")) for line in stages) == len(ROWS)
    assert "| 2 | 9.0 | 5.0 | 1.0 | 2.0 | 0.5 | 7.0 | 1300 |" in tables["iteration"]
    assert "**7.5 s** (6.5 to 8.5" in tables["iteration"] and "50%" in tables["first"]


def clip(case, seconds, **changes):
    stages = dict.fromkeys(clips.STAGES, 0.0) | {
        "start": 2.0,
        "draw": 3.0,
        "simulate": (seconds or 5.0) - 5.0,
    }
    known = {"particles": 20000, "frames": 50, "stages": stages, "code": 0}
    return {"case": case, "sentence": "push it", "seconds": seconds, **known, **changes}


def test_the_seconds_until_a_clip_are_those_of_its_stages():
    stages = Stages(prepare=1.0, compile=2.0, simulate=10.0, render=1.5, agents=0.5)
    first = FirstClip(seconds=18.0, draw=2.5, stages=stages)
    manifest = Manifest(command="", prompt="", versions={}, platform="", seed=0, inputs={}, first_clip=first)
    found = clips.split_stages(20.0, manifest)
    assert found["start"] == 2.0 and found["draw"] == 2.5 and found["rest"] == pytest.approx(0.5)
    assert sum(found.values()) == pytest.approx(20.0)


def test_the_tables_of_clips_show_each_sentence_and_where_the_seconds_go():
    rows = [clip("01-robot", 25.0), clip("02-cow", 75.0), clip("03-ball", None, code=2)]
    tables = write_tables({"clips": section(rows)})
    assert "1 of 2 first clips are there within 45 s" in tables["clips"]
    assert "| 02-cow | push it | 20,000 | 50 | 75 |" in tables["clips"]
    assert "| 03-ball | push it |  |  | refused |" in tables["clips"]
    assert "| simulate | 45.0 | 70.0 | 90% |" in tables["clip stages"]
    assert "| start | 2.0 | 2.0 | 4% |" in tables["clip stages"]


@pytest.mark.slow
def test_a_clip_is_timed_by_the_line_that_names_it(tmp_path, monkeypatch):
    """The kernels are those of this machine, and the rest is compiled quickly: how long it takes is not the matter.

    Slow: a whole run in a process that finds nothing compiled.
    """
    if use_cpu():
        from physagent_jax.kernels import store  # needs Numba

        (tmp_path / "cache" / "physagent_jax").mkdir(parents=True, mode=0o700)
        (tmp_path / "cache" / "physagent_jax" / "kernels").symlink_to(store.find_folder().parent)
    monkeypatch.setenv("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
    options = ("--frames", "3", "--particles", "300", "--resolution", "64", "--max-iterations", "1")
    small = (*options, "--video-size", "64x48")
    row = clips.time_clip((*JOB, *small), tmp_path / "run", tmp_path)
    assert row["code"] == 0 and row["frames"] == 3 and 0 < row["stages"]["draw"] < row["seconds"]
    assert sum(row["stages"].values()) == pytest.approx(row["seconds"], abs=0.1)


def test_a_run_that_is_refused_has_no_clip(tmp_path):
    row = clips.time_clip(("--object", "nothing.ply", "--prompt", "push it"), tmp_path / "run", tmp_path)
    assert row["seconds"] is None and row["code"] == 2 and row["good"] and "nothing.ply" in row["message"]
