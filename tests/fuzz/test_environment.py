"""Machines as they are: one core, no Numba, other encodings, variables that make no sense."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.fuzz.processes import REPOSITORY, contents, environment, run, said


def command(base_folder, *arguments, env=None, program=None) -> tuple[int, str, str]:
    """Exit code, output and errors of the installed command's entry point."""
    line = program or [
        sys.executable,
        "-c",
        "import sys; from physagent_jax.cli import main; sys.exit(main())",
    ]
    done = subprocess.run(
        [*line, *map(str, arguments)], cwd=base_folder, env=env, capture_output=True, timeout=240
    )
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


ASCII = {
    "LANG": "C",
    "LC_ALL": "C",
    "PYTHONIOENCODING": "ascii",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
}


def test_a_terminal_of_ascii_shows_tables(tmp_path):
    env = environment(tmp_path, **ASCII)
    code, out, errors = command(tmp_path, "materials", env=env)
    assert code == 0, errors
    assert "steel" in out and "Traceback" not in errors


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "utf-16"])
@pytest.mark.parametrize(
    "arguments",
    [["materials", "steel"], ["materials", "--json"], ["schema", "scene"], ["--help"], ["run", "--help"],
    ["simulate", "機.json", "--out", "ü"]],
)  # fmt: skip
def test_every_command_speaks_in_any_encoding(arguments, encoding, tmp_path):
    env = environment(tmp_path, **{**ASCII, "PYTHONIOENCODING": encoding})
    code, _, errors = command(tmp_path, *arguments, env=env)
    assert code in (0, 2) and "Traceback" not in errors, errors


@pytest.mark.slow
def test_a_run_on_a_terminal_of_ascii(base, tmp_path):
    code, errors = run(base, tmp_path / "run", env=environment(base, **ASCII))
    assert code == 0, errors


@pytest.mark.parametrize(
    "changes",
    [
        {"NUMBA_NUM_THREADS": "0"},
        pytest.param({"NUMBA_NUM_THREADS": "-3"}, marks=pytest.mark.slow),
        pytest.param({"NUMBA_NUM_THREADS": "many"}, marks=pytest.mark.slow),
        pytest.param({"JAX_PLATFORMS": "cuda"}, marks=pytest.mark.slow),
        pytest.param({"JAX_PLATFORMS": "nonsense"}, marks=pytest.mark.slow),
        pytest.param({"JAX_ENABLE_X64": "perhaps"}, marks=pytest.mark.slow),
        pytest.param({"JAX_DISABLE_JIT": "1"}, marks=pytest.mark.slow),
        pytest.param({"PHYSAGENT_COMPILE_CACHE": "/proc/none"}, marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_a_variable_that_makes_no_sense_is_told_in_one_line(changes, base, tmp_path):
    code, errors = run(base, tmp_path / "run", env=environment(base, **changes))
    assert code == 2, errors[-2000:]
    assert len(said(errors)) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"XDG_CACHE_HOME": "/proc/none"}, {"XDG_CACHE_HOME": "/dev/null"}, {"HOME": "/nowhere", "XDG_CACHE_HOME": ""},
        {"NUMBA_CACHE_DIR": "/proc/none"}, {"TMPDIR": "/nowhere"},
    ],
    ids=str,
)  # fmt: skip
def test_a_folder_for_caches_that_cannot_be_costs_time_only(changes, base, tmp_path):
    code, errors = run(base, tmp_path / "run", env=environment(base, **changes))
    assert code == 0, errors[-2000:]
    assert "Traceback" not in errors


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["emptied", "cut", "garbled"])
def test_damaged_caches_cost_time_only(damage, base, tmp_path):
    """Every file of JAX's and Numba's caches."""
    own = tmp_path / "base"
    subprocess.run(["cp", "-r", base, own], check=True)
    damaged = 0
    for path in (own / "caches").rglob("*"):
        if path.is_file():
            content = path.read_bytes()
            new = {"emptied": b"", "cut": content[: len(content) // 2], "garbled": content[::-1]}[damage]
            path.write_bytes(new)
            damaged += 1
    assert damaged > 3
    for attempt in ("first", "second"):
        code, errors = run(own, tmp_path / attempt)
        assert code == 0, errors[-2000:]
    assert contents(tmp_path / "second").keys() == contents(base / "undisturbed").keys()


@pytest.mark.slow
def test_one_core_is_enough(base, tmp_path):
    core = str(min(os.sched_getaffinity(0)))
    code, errors = run(base, tmp_path / "run", prefix=("taskset", "-c", core))
    assert code == 0, errors
    assert contents(tmp_path / "run").keys() == contents(base / "undisturbed").keys()


@pytest.mark.slow
def test_without_numba_a_run_takes_longer_and_is_the_same_in_kind(base, tmp_path):
    stub = tmp_path / "stub" / "numba"
    stub.mkdir(parents=True)
    (stub / "__init__.py").write_text('raise ImportError("there is no Numba here")\n')
    env = environment(base, PYTHONPATH=os.pathsep.join([str(stub.parent), str(REPOSITORY)]))
    code, errors = run(base, tmp_path / "run", env=env)
    assert code == 0, errors[-2000:]
    found = contents(tmp_path / "run")
    assert found["manifest.json"]["kernels"] == "reference"
    assert found.keys() == contents(base / "undisturbed").keys()


@pytest.mark.slow
@pytest.mark.parametrize("what", ["prompt", "out", "object"])
def test_arguments_that_are_not_utf8(what, base, tmp_path):
    """A prompt is refused or understood; a name of a file is used as it is."""
    odd = b"push it left \xff\xfe"
    values = {
        "prompt": b"push it left",
        "out": os.fsencode(tmp_path / "run"),
        "object": os.fsencode(base / "object.ply"),
    }
    values[what] = odd if what == "prompt" else values[what] + odd
    line = [sys.executable, "-m", "tests.fuzz.interrupted", "none", "0", "--", "run", "--frames", "2",
    "--particles", "60",
            "--resolution", "32", "--max-iterations", "1"]  # fmt: skip
    arguments = [part for name, value in values.items() for part in (f"--{name}".encode(), value)]
    done = subprocess.run(
        [*map(os.fsencode, line), *arguments],
        cwd=base,
        env=environment(base),
        capture_output=True,
        timeout=240,
    )
    errors = done.stderr.decode("utf-8", "replace")
    assert done.returncode in (0, 2), errors
    assert len(said(errors)) == (1 if done.returncode else 0)


def test_a_command_in_a_pipe_that_closes_says_nothing(tmp_path):
    """`physagent materials | head -1`."""
    line = f"{sys.executable} -c 'import sys; from physagent_jax.cli import main; sys.exit(main())' materials | head -1"
    done = subprocess.run(
        ["bash", "-c", line], cwd=tmp_path, env=environment(tmp_path), capture_output=True, text=True
    )
    assert "Traceback" not in done.stderr, done.stderr
