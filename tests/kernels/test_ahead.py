"""Kernels compiled ahead in processes of their own are found, and whoever fails is not missed."""

import io
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("numba")

from physagent_jax.cli import main  # noqa: E402  (after the check for Numba)
from physagent_jax.kernels import ahead, store  # noqa: E402
from physagent_jax.mpm.kernels import AHEAD as TRANSFERS  # noqa: E402
from physagent_jax.render.kernels import AHEAD as BLENDING  # noqa: E402
from tests.kernels.processes import ran  # noqa: E402

P2G, G2P, BLEND = "physagent_p2g_float32", "physagent_g2p_float32", "physagent_blend"
TARGETS = TRANSFERS | BLENDING


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """The processes that are begun where no kernel has been compiled on this machine.

    They are stand-ins, which say that P2G and the picture's kernel are done, and end.
    """
    scripts = []

    class Process:
        """Says what it was asked."""

        def __init__(self, command, **_):
            scripts.append(command[-1])
            self.stdin, self.stdout = None, io.StringIO(f"{BLEND}\n{P2G}\n")

        def communicate(self):
            scripts.append("over")

    monkeypatch.setattr(store, "find_folder", lambda: tmp_path)
    monkeypatch.setattr(ahead, "running", {})
    monkeypatch.setattr(ahead.subprocess, "Popen", Process)
    return scripts


def test_one_process_compiles_what_is_missing(begun, tmp_path):
    """Present kernels are left alone, and a running compilation is not begun twice."""
    (tmp_path / G2P).mkdir()
    store.seal(tmp_path / G2P)
    ahead.start_compiling(TARGETS)
    ahead.start_compiling(TARGETS)
    (script,) = begun
    assert P2G in script and BLEND in script and G2P not in script


def test_waiting_ends_with_the_kernel_or_the_process(begun):
    """Waiting ends with the kernel or the process; news of another kernel is noted meanwhile."""
    ahead.start_compiling(TARGETS)
    ahead.wait_for(BLEND)
    assert set(ahead.running) == {P2G, G2P}
    ahead.wait_for(BLEND)
    assert "over" not in begun
    ahead.wait_for(G2P)
    assert not ahead.running and begun[1:] == ["over"]


def test_threads_that_begin_together_begin_one_process(begun):
    ask_all(lambda: ahead.start_compiling(TARGETS))
    assert len(begun) == 1


def test_a_kernel_that_is_done_waits_for_no_other(begun):
    """Whoever listens for a kernel that takes long lets others have what it hears."""
    ahead.start_compiling(TARGETS)
    process = next(iter(ahead.running.values()))
    listening, go_on = threading.Event(), threading.Event()
    lines = iter([f"{BLEND}\n", f"{P2G}\n"])

    def readline():
        line = next(lines, "")
        if line.startswith(P2G):
            listening.set()
            assert go_on.wait(60)
        return line

    process.stdout = SimpleNamespace(readline=readline)
    thread = threading.Thread(target=ahead.wait_for, args=(G2P,), daemon=True)
    thread.start()
    assert listening.wait(60)
    ask_all(lambda: ahead.wait_for(BLEND))  # the thread goes on listening for G2P
    go_on.set()
    ask_all(lambda: ahead.wait_for(P2G))
    thread.join(60)
    assert not thread.is_alive() and not ahead.running and begun[1:] == ["over"]


def ask_all(call):
    """Call from several threads; one that waits for ever fails the test."""
    threads = [threading.Thread(target=call, daemon=True) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not any(thread.is_alive() for thread in threads)


FORK_BESIDE = """
import os, subprocess, sys
from physagent_jax.kernels import ahead
helper = subprocess.Popen(
    [sys.executable, "-c", "import sys; print('first', flush=True); sys.stdin.read()"],
    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
)
ahead.running.update(first=helper, second=helper)
ahead.wait_for("first")
child, waiter = os.pipe()
if (pid := os.fork()) == 0:
    assert not ahead.running
    ahead.wait_for("second")
    os.read(child, 1)
    os._exit(0)
helper.stdin.close()  # what ends the helper, unless the forked process keeps its pipe open
assert helper.wait(60) == 0
assert set(ahead.running) == {"second"}
os.write(waiter, b".")
sys.exit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="one process only")
def test_helpers_are_their_parents_and_not_a_forked_processs():
    """It neither waits for them nor keeps them alive."""
    code, _, err = ran(FORK_BESIDE)
    assert code == 0, err


def test_commands_that_play_begin_before_they_read_their_arguments(begun):
    """A help text compiles nothing."""
    for arguments in (["run", "--help"], ["simulate", "-h"], ["materials", "--nonsense"]):
        with pytest.raises(SystemExit):
            main(arguments)
    assert not begun
    with pytest.raises(SystemExit):
        main(["run", "--nonsense"])
    assert len(begun) == 1


def in_a_process(script, folder):
    """The output of ``script`` with an empty store, or with one that another left in ``folder``."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    command = [sys.executable, "-c", f"from physagent_jax.kernels import ahead, store; {script}"]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()


def test_every_target_ahead_is_one_that_a_handler_makes(tmp_path):
    """A process compiles the smallest of them and says so; what cannot be made it leaves out, and goes on."""
    targets = {"nonsense": (BLENDING[BLEND][0], "nonsense"), **BLENDING}
    script = f'ahead.compile_all({targets!r}); print(store.is_stored("{BLEND}"), store.is_stored("nonsense"))'
    assert in_a_process(script, tmp_path) == [BLEND, "True", "False"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="one process only")
@pytest.mark.parametrize("ending", ["os._exit(0)", "os.kill(os.getpid(), signal.SIGKILL)", "sys.exit(1)"])
def test_helpers_end_with_the_process_that_began_them(tmp_path, ending):
    """However it ends. They compile for ever here, and are a session of their own, which Ctrl-C does not reach."""
    slow = "import os, time; from physagent_jax.kernels import ahead\n"
    slow += "ahead._compile = lambda *target: (print(os.getpid(), flush=True), time.sleep(1000))\n"
    slow += (
        f"print(os.getpid(), flush=True); ahead.compile_all({dict(list(TARGETS.items())[::2])!r}, parent=0)"
    )
    script = f"""
import os, signal, subprocess, sys
from physagent_jax.kernels import ahead
helper = ahead.subprocess.Popen
def popen(command, **options):
    return helper([*command[:-1], {slow!r}], **options)
ahead.subprocess.Popen = popen
ahead.start_compiling({TARGETS!r})
process = next(iter(ahead.running.values()))
print(*(process.stdout.readline().strip() for _ in range(2)), flush=True)
assert os.getsid(process.pid) == process.pid != os.getsid(0)
{ending}"""
    command = [sys.executable, "-c", script]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    helpers = subprocess.run(command, env=environment, capture_output=True, text=True).stdout.split()
    assert len(helpers) == 2
    end = time.monotonic() + 240
    while any(alive(int(helper)) for helper in helpers) and time.monotonic() < end:
        time.sleep(0.05)
    assert not any(alive(int(helper)) for helper in helpers)


def alive(pid):
    """Return whether a process is at work; one that has ended may wait for somebody to ask."""
    try:
        os.kill(pid, 0)
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def test_nothing_here_needs_numba():
    """The reference path serves without Numba: commands can be imported, and begin nothing."""
    script = (
        "import sys; sys.modules['numba'] = None\n"
        "from physagent_jax.kernels import ahead\n"
        "import physagent_jax.run.replay, physagent_jax.run.loop\n"
        f"ahead.start_compiling({TARGETS!r}); assert not ahead.running"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)
