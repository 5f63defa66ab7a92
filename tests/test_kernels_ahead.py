"""Kernels compiled ahead in processes of their own are found, and whoever fails is not missed."""

import os
import subprocess
import sys

import pytest

pytest.importorskip("numba")

from physagent_jax.kernels import ahead, store  # noqa: E402  (after the check for Numba)


@pytest.fixture
def empty_store(tmp_path, monkeypatch):
    """No kernel has been compiled yet on this machine, as far as anybody knows."""
    monkeypatch.setattr(store, "_folder", lambda: tmp_path)
    monkeypatch.setattr(ahead, "_running", {})
    return tmp_path


def test_missing_kernels_are_compiled_each_in_a_process(empty_store, monkeypatch):
    """What is there is left alone, what is being compiled is not begun twice, and waiting ends."""
    begun = []

    class Process:
        """Says what it was asked."""

        def __init__(self, command, **_):
            begun.append(command[-1])

        def wait(self):
            begun.append("waited")

    monkeypatch.setattr(ahead.subprocess, "Popen", Process)
    store.note("physagent_g2p_float32")
    ahead.begin()
    ahead.begin()
    assert len(begun) == 2 and "'p2g', 'float32'" in begun[0] and "'blend'" in begun[1]
    ahead.wait_for("physagent_p2g_float32")
    ahead.wait_for("physagent_p2g_float32")
    assert begun[2:] == ["waited"]


def test_every_target_ahead_is_one_that_a_handler_makes(tmp_path):
    """A fresh process compiles the smallest of them into an empty store, and a second one finds it there."""
    name = "physagent_blend"
    module, *arguments = ahead.PLAYING[name]
    script = (
        f"from physagent_jax.kernels import ahead, store; print(store.has({name!r})); "
        f"ahead.compile_one({module!r}, {arguments!r}); print(store.has({name!r}))"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    runs = [
        subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        )
        for _ in range(2)
    ]
    assert [run.stdout.split() for run in runs] == [["False", "True"], ["True", "True"]]


def test_nothing_here_needs_numba():
    """Where it is missing the reference path serves: the commands must still be importable, and begin nothing."""
    script = (
        "import sys; sys.modules['numba'] = None\n"
        "from physagent_jax.kernels import ahead\n"
        "import physagent_jax.cli.playing, physagent_jax.synthesis\n"
        "ahead.begin(); assert not ahead._running"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)
