"""The environment of a command, and the messages about impossible ones."""

import sys

import jax
import pytest

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.kernels.threads import thread_count
from tests.kernels.processes import QUICKLY, begun, ended

MAIN = "import sys; from physagent_jax.cli import main; sys.exit(main({}))"
BAD = {
    "NUMBA_NUM_THREADS": ["0", "-1", "abc", "", "1" * 5000],
    "PHYSAGENT_COMPILE_CACHE": ["/dev/null", "/proc/nothing"],
}
IN_PROCESSES = [  # what JAX reads once, as it is imported
    ("JAX_PLATFORMS", "nonsense"),
    ("JAX_PLATFORMS", "tpu"),
    ("JAX_DISABLE_JIT", "1"),
    ("JAX_ENABLE_X64", "maybe"),
    ("XLA_FLAGS", "--nonsense=1"),
    ("XLA_FLAGS", "nonsense"),
]


def one_line(text, variable):
    return text.startswith("physagent: ") and text.count("\n") == 1 and variable in text


@pytest.mark.parametrize(
    "variable, value", [(name, value) for name, values in BAD.items() for value in values]
)
def test_a_variable_that_makes_no_sense_is_refused_in_one_line(variable, value, monkeypatch, capsys):
    monkeypatch.setenv(variable, value)
    folder = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", None)
    try:
        assert main(["materials"]) == 2
    finally:
        jax.config.update("jax_compilation_cache_dir", folder)
    assert one_line(capsys.readouterr().err, variable)


def test_what_jax_does_not_accept_is_refused_in_one_line():
    """JAX settings that XLA or JAX would die of are refused in one line; `JAX_DISABLE_JIT` would take hours."""
    script = MAIN.format(["materials"])
    processes = {pair: begun(script, **dict([pair])) for pair in IN_PROCESSES}
    for (variable, value), process in processes.items():
        code, _, err = ended(process)
        assert code == 2 and one_line(err, variable), (variable, value, err)


def test_a_gpu_that_is_not_there_is_refused_in_one_line(monkeypatch, capsys):
    """With JAX's own complaint, or none: without its plugin, JAX 0.10 fails with an empty assertion."""
    for error in (RuntimeError("Unable to initialize backend 'cuda'\nmore"), AssertionError()):
        monkeypatch.setattr("jax.devices", lambda error=error: (_ for _ in ()).throw(error))
        monkeypatch.setenv("JAX_PLATFORMS", "cuda")
        assert main(["materials"]) == 2
        assert one_line(capsys.readouterr().err, "JAX_PLATFORMS=cuda")


@pytest.mark.parametrize("value", BAD["NUMBA_NUM_THREADS"])
def test_a_number_of_threads_that_is_none_is_refused_in_a_library_too(value, monkeypatch):
    """With no thread at all, kernels would give back memory as they found it."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", value)
    with pytest.raises(UserError, match="NUMBA_NUM_THREADS"):
        thread_count.__wrapped__()


@pytest.mark.parametrize("arguments", [["schema"], ["run", "--help"]])
def test_help_and_schemas_come_whatever_the_environment(arguments, monkeypatch, capsys):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "0")
    monkeypatch.setattr("jax.devices", None)
    try:
        assert main(arguments) == 0
    except SystemExit as end:
        assert not end.code
    assert capsys.readouterr().out


TINY = """
import jax.numpy as jnp, numpy as np
from physagent_jax.kernels import describe_kernels
from physagent_jax.mpm import Grid, Model, NeoHookean, State, simulate
x = np.random.default_rng(0).uniform(0.4, 0.6, (60, 3)).astype(np.float32)
one = np.ones(60, np.float32)
model = Model(Grid.whole(1.0, 16), np.float32(1e-3), np.array([0, 0, -9.8]), one, one, (NeoHookean(4e3 * one, one),))
*_, last = simulate(model, State.at_rest(jnp.asarray(x)), frame_count=3, frame_dt=0.01)
print(describe_kernels("auto"), float(last.state.x[:, 2].mean() - x[:, 2].mean()))
"""


def test_one_core_and_no_numba_are_enough():
    """A body falls by g t^2 / 2 either way."""
    without = "import sys; sys.modules['numba'] = None\n" + TINY
    lone = "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n" + TINY
    scripts = (without, lone if sys.platform == "linux" else TINY)
    processes = [begun(script, **QUICKLY) for script in scripts]
    results = [ended(process) for process in processes]
    assert results[0][1].startswith("reference ")
    for code, out, err in results:
        assert code == 0, err
        assert float(out.split()[-1]) == pytest.approx(-9.8 * 0.02**2 / 2, rel=0.1)
    if sys.platform == "linux" and results[1][1].startswith("cpu"):
        assert results[1][1].startswith("cpu (1 threads)")
