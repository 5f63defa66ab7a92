"""Compiled programs: read from disk if they are whole and made for this machine, let go before they are too many."""

import logging
import os
import re
import sys
import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.kernels import programs
from physagent_jax.mpm import Grid, Model, NeoHookean, State, simulate
from tests.conftest import forget_oldest
from tests.kernels.processes import ran

MISMATCH = (
    "E1122 15:57:54.644995 15662 cpu_aot_loader.cc:195] Loading XLA:CPU AOT result. Target machine feature +{} is not  "
    "supported on the host machine. This could lead to execution errors such as SIGILL.\n"
)


def compile_programs(count):
    """A tiny simulation whose arrays have a shape of their own."""
    x = np.random.default_rng(count).uniform(0.4, 0.6, (count, 3)).astype(np.float32)
    one = np.ones(count, np.float32)
    model = Model(
        Grid.whole(1.0, 16), np.float32(1e-3), None, one, 1e-3 * one, (NeoHookean(4e3 * one, 6e3 * one),)
    )
    *_, last = simulate(model, State.at_rest(jnp.asarray(x)), frame_count=2, frame_dt=1e-3)
    return np.asarray(last.state.x)


needs_maps = pytest.mark.skipif(not programs.count_mappings(), reason="the system does not count mappings")


@needs_maps
def test_programs_are_let_go_when_they_take_too_many_mappings():
    """And what was let go is compiled again, with the same results."""
    before = compile_programs(60)
    mapping_count = programs.count_mappings()
    assert not programs.release_programs(mapping_count + 1000)
    assert programs.release_programs(mapping_count - 1)
    assert programs.count_mappings() < mapping_count
    assert np.array_equal(compile_programs(60), before)


@needs_maps
def test_a_simulation_begins_by_looking_whether_there_are_too_many(monkeypatch):
    compile_programs(61)
    mapping_count = programs.count_mappings()
    monkeypatch.setattr(programs, "count_granted", lambda: (mapping_count - 1) / programs.SHARE)
    monkeypatch.setattr(programs, "compiled_count", programs.looked_at + programs.LOOK)
    compile_programs(61)
    assert programs.count_mappings() < mapping_count


def test_nothing_is_let_go_while_something_is_traced():
    let_go = []
    jax.jit(lambda x: let_go.append(programs.release_programs(-1)) or x)(1.0)
    assert let_go == [False]


@needs_maps
@pytest.mark.slow
def test_many_different_runs_stay_within_their_mappings(monkeypatch):
    """150 runs of different shapes in one process."""
    limit = programs.count_mappings() + 6000
    monkeypatch.setattr(programs, "count_granted", lambda: limit / programs.SHARE)
    most = 0
    for count in range(62, 212):
        compile_programs(count)
        most = max(most, programs.count_mappings())
    assert most < limit + 2500  # those of one look to the next


@pytest.mark.parametrize("feature, foreign", [("prefer-no-gather", []), ("avx512f", ["avx512f"])])
def test_of_what_xla_writes_only_differences_in_tuning_are_left_out(capfd, feature, foreign):
    """A feature that the processor lacks is told, so that the program is not used."""
    with programs.compare_machine() as found:
        os.write(2, f"one\n{MISMATCH.format(feature)}two\n".encode())
    assert found == foreign
    assert capfd.readouterr().err == "one\ntwo\n"


COMPUTE = """
import logging; logging.basicConfig(format="%(message)s")
import jax, jax.numpy as jnp
from pathlib import Path
from physagent_jax.kernels import programs
programs.keep_on_disk(Path("{folder}"))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
print(float(jax.jit(lambda x: jnp.cumsum(jnp.sin(x) @ x.T, 0).sum())(jnp.ones((50, 60)))))
"""


def test_what_is_read_from_disk_is_whole_and_says_nothing(tmp_path):
    """The second process finds every file damaged, says so, and leaves them whole; the third reads all."""
    script = COMPUTE.format(folder=tmp_path)
    code, value, err = ran(script)
    assert code == 0 and not err
    kept = {path: path.read_bytes() for path in tmp_path.glob("*-cache")}
    assert len(kept) >= 2
    damages = [b"", b"random", *(content[: len(content) // 2] for content in kept.values())]
    for path, damage in zip(kept, damages):
        path.write_bytes(damage)
    code, again, err = ran(script)
    lines = err.splitlines()
    assert code == 0 and again == value
    assert len(lines) == min(len(kept), len(damages)) and all("compiled again" in line for line in lines)
    assert ran(script) == (0, value, "")


TWICE = """
import threading
import jax, jax.numpy as jnp
from pathlib import Path
from physagent_jax.kernels import programs
threads = [threading.Thread(target=programs.keep_on_disk, args=(Path("{folder}"),)) for _ in range(4)]
[thread.start() for thread in threads], [thread.join() for thread in threads]
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
print(float(jax.jit(lambda x: jnp.cumsum(jnp.sin(x) @ x.T, 0).sum())(jnp.ones((50, 60)))))
"""


def test_asking_several_times_for_one_folder_is_as_good_as_once(tmp_path):
    """Before, the first program that was read from disk waited for itself."""
    code, value, err = ran(TWICE.format(folder=tmp_path))
    assert code == 0 and not err
    assert ran(TWICE.format(folder=tmp_path)) == (0, value, "")


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_half_a_program_is_never_under_its_name(tmp_path):
    """Failures of the store: a full disk, and a process that reads while this one writes."""
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))\n"
    code, value, err = ran(limit + COMPUTE.format(folder=tmp_path))
    assert code == 0 and "cannot write" in err
    assert not list(tmp_path.iterdir())
    assert ran(COMPUTE.format(folder=tmp_path)) == (0, value, "")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.filterwarnings("ignore:os.fork")
def test_a_process_forked_while_a_program_is_read_keeps_its_stderr(capfd):
    """Forking waits until stderr is what it was: what is written meanwhile goes into a file that is gone then."""
    reading, forks = threading.Event(), threading.Event()

    def read():
        with programs.compare_machine():
            reading.set()
            forks.wait(60)

    os.register_at_fork(before=forks.set)
    thread = threading.Thread(target=read)
    thread.start()
    assert reading.wait(60)
    child = os.fork()
    if child == 0:
        os.write(2, b"from the child\n")
        with programs.compare_machine():
            os.write(2, b"and more\n")
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    thread.join()
    assert capfd.readouterr().err == "from the child\nand more\n"


def test_programs_compiled_in_threads_are_all_counted():
    before = programs.compiled_count
    threads = [
        threading.Thread(target=lambda shape=shape: jax.jit(lambda x: x + 1)(jnp.ones((3, 5 + shape, 7))))
        for shape in range(8)
    ]
    [thread.start() for thread in threads], [thread.join() for thread in threads]
    assert programs.compiled_count >= before + 8


def test_a_program_for_another_processor_is_compiled_again(tmp_path, monkeypatch, caplog):
    """As XLA would say on loading, if the folder had come from another machine."""
    reads = []

    def read(key, *arguments):
        reads.append(key)
        os.write(2, MISMATCH.format("avx9").encode())
        return "program", 1

    monkeypatch.setattr(programs.compilation_cache, "get_executable_and_time", read)
    monkeypatch.setattr(programs.jax.config, "update", lambda *_: None)
    programs.keep_on_disk(tmp_path)
    (tmp_path / "key-cache").write_bytes(b"")
    with caplog.at_level(logging.WARNING):
        assert programs.compilation_cache.get_executable_and_time("key", None) == (None, None)
    assert re.search("processor with avx9", caplog.text) and reads == ["key"]
    assert not (tmp_path / "key-cache").exists()


def test_of_what_tests_keep_the_programs_used_longest_ago_go_first(tmp_path):
    for age, name in enumerate(("new", "read", "old", "older")):
        path = tmp_path / f"{name}-cache"
        path.write_bytes(bytes(10))
        os.utime(path, (1e9 if name == "read" else 1e9 - age, 1e9 - age))
    forget_oldest(tmp_path, kept=25)
    assert {path.name for path in tmp_path.iterdir()} == {"new-cache", "read-cache"}
