"""Several of XLA's threads run one kernel: each iteration is done once, and loops wait for the ones before."""

import contextlib
import re
import sys
import time
from pathlib import Path

import jax
import jaxlib
import numpy as np
import pytest

pytest.importorskip("numba")

from numba import cfunc, njit  # noqa: E402  (after the check for Numba)

from physagent_jax.kernels import account, ffi, team, threads  # noqa: E402
from physagent_jax.kernels.numbers import NO_WRAPPERS  # noqa: E402
from physagent_jax.kernels.words import add_word, pause, read_own_clock, read_shared  # noqa: E402

COUNT = 97
SLOTS = 64


@njit(**NO_WRAPPERS)
def mirror_twice(frame, number, members):
    """Add one to all numbers, put them in the opposite order and then back; count what each thread did."""
    x, work = ffi.get_operand(frame, 0, number, 1), ffi.get_operand(frame, 1, np.int32, 1)[0]
    a, b, c = (
        ffi.get_result(frame, 0, number, 1),
        ffi.get_result(frame, 1, number, 1),
        ffi.get_result(frame, 2, number, 1),
    )
    done = 0
    for i in team.share_loop(members, 0, COUNT):
        waste = x[i]
        for _ in range(work):
            waste = np.sin(waste)
        a[i] = x[i] + (2 if waste > 1e9 else 1)
        done += 1
    for i in team.share_loop(members, 1, COUNT):
        b[i] = a[COUNT - 1 - i]
    for i in team.share_loop(members, 2, COUNT + SLOTS):
        if i < COUNT:
            c[i] = b[COUNT - 1 - i]
        else:
            c[i], done = done, 0


def handle_mirror(frame):
    return team.run_in_team(frame, np.float64, mirror_twice)


@njit(**NO_WRAPPERS)
def meet(frame, number, members):
    """Two iterations, of which the first to begin waits for the other one, and then works on if that has come.

    The operand has the looks of waiting and of work, the result how many have begun, whether they met, and for how
    long the first one's thread has had a core [ns].
    """
    looks_of, words = ffi.get_operand(frame, 0, number, 1), ffi.get_result(frame, 0, number, 1)
    patience, work = looks_of[0], looks_of[1]
    for _ in team.share_loop(members, 0, 1):
        words[:] = 0
    for _ in team.share_loop(members, 1, 2):
        address, looks, begun = words.ctypes.data, 0, read_own_clock()
        if add_word(address, 0, 1) == 0:
            while read_shared(address, 0) < 2 and looks < patience:
                looks += 1
                pause()
            words[1] = read_shared(address, 0) == 2
            while words[1] and looks < patience + work:
                looks += 1
                pause()
            words[2] = read_own_clock() - begun


def handle_meeting(frame):
    return team.run_in_team(frame, np.int64, meet)


@pytest.fixture(autouse=True)
def balanced():
    """An account of helpers that knows nothing of earlier tests, or of other programs."""
    account.words[:] = 0
    yield
    account.words[:] = 0


@pytest.fixture(scope="module")
def mirror():
    """The kernel as a function of x, the work of an iteration, and threads."""
    results = tuple(jax.ShapeDtypeStruct((size,), np.float64) for size in (COUNT, COUNT, COUNT + SLOTS))
    with make_call("test_team_mirror", handle_mirror, results) as call:
        yield lambda x, work, count: call(x, np.int32([work]), threads=np.int64(count))


@pytest.fixture(scope="module")
def meeting():
    """Return whether two iterations met, and for how long one worked, by looks (see `meet`) and threads."""
    result = (jax.ShapeDtypeStruct((3,), np.int64),)
    with make_call("test_team_meeting", handle_meeting, result) as call:
        yield lambda looks, count, work=0: call(np.int64([looks, work]), threads=np.int64(count))[0][1:]


@contextlib.contextmanager
def make_call(name, handle, results):
    """A handler as a function of arrays and attributes, in double precision."""
    handler = cfunc(ffi.HANDLER)(handle)
    jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(handler.ctypes), platform="cpu")

    def run(*arrays, **attributes):
        with jax.enable_x64(True):
            return [np.asarray(each) for each in jax.ffi.ffi_call(name, results)(*arrays, **attributes)]

    yield run
    assert handler  # the code must live as long as XLA may call it


@pytest.mark.parametrize("count", [1, 2, 3, 16])
@pytest.mark.parametrize("works", [[0, 1, 30] * 100, [20_000] * 10], ids=["short", "long"])
def test_every_iteration_is_done_once_and_after_the_loop_before(mirror, works, count):
    """Also with more threads than cores, of which most come too late; whoever waits for a long one sleeps."""
    x = np.random.default_rng(0).normal(size=COUNT)
    for work in works:
        a, b, c = mirror(x, work, count)
        np.testing.assert_array_equal(a, x + 1)
        np.testing.assert_array_equal(b, a[::-1])
        np.testing.assert_array_equal(c[:COUNT], a)
        assert c[COUNT:].sum() <= COUNT


@pytest.mark.skipif(threads.core_count() < 2, reason="needs two cores")
def test_several_threads_take_part(meeting):
    """One iteration waits for another, for about a second; a busy machine may need several tries to run both."""
    assert any(meeting(10_000_000, 2)[0] for _ in range(60))
    assert not any(meeting(1000, 1)[0] for _ in range(5))


@pytest.mark.skipif(sys.platform not in ("linux", "darwin"), reason="no clock")
@pytest.mark.skipif(threads.core_count() < 2, reason="needs two cores")
def test_a_thread_that_waits_gives_way(meeting):
    """While the other one works: processor time is counted, which other programs take none of."""
    for _ in range(60):
        before = time.process_time_ns()
        met, worked = meeting(10_000_000, 2, 10_000_000)
        used = time.process_time_ns() - before
        if met:
            assert used - worked < 0.5 * worked
            return
    pytest.fail("no helper has come")


def test_no_helpers_are_asked_while_they_cost_more_than_they_bring(mirror, meeting):
    account.words[account.UNTIL] = np.iinfo(np.int64).max
    assert not any(meeting(100_000, 16)[0] for _ in range(20))
    x = np.arange(COUNT, dtype=float)
    np.testing.assert_array_equal(mirror(x, 0, 16)[0], x + 1)


@njit
def settle(worked, waited):
    account.note_work(worked)
    account.note_wait(waited)
    return account.is_resting()


@pytest.mark.skipif(sys.platform not in ("linux", "darwin"), reason="no clock")
def test_the_account_of_helpers():
    """They rest once they have cost so much more than they brought, longer each time, and are tried again."""
    most, least = account.MOST, -account.LEAST
    assert not settle(0, least // 2) and not settle(least, least)
    rests = []
    for _ in range(10):
        assert settle(0, 2 * least)
        rests.append(account.words[account.REST])
        account.words[account.UNTIL] = 1  # it is long ago
        assert not settle(0, 0)
    assert (
        rests[0] == account.SHORTEST_REST and rests[1] == 2 * rests[0] and rests[-1] == account.LONGEST_REST
    )
    assert not settle(100 * most, 0) and account.words[account.BALANCE] == most
    assert account.words[account.REST] == 0  # all is well again: the next rest is a short one
    assert not settle(0, most + least // 2) and settle(0, least)


def test_xla_has_its_functions_where_they_are_called():
    """The words of XLA_FFI_Api, in the header of the jaxlib that is installed."""
    header = (Path(jaxlib.__file__).parent / "include/xla/ffi/api/c_api.h").read_text()
    functions = re.findall(r"_XLA_FFI_API_STRUCT_FIELD\(XLA_FFI_(\w+)\);", header)
    first = 6  # after the structure's size, its extension, three words of version, and XLA's own
    assert functions.index("ThreadPool_Schedule") + first == ffi.SCHEDULE_TASK
    assert functions.index("Error_Destroy") + first == ffi.DESTROY_ERROR
    assert re.search(
        r"struct XLA_FFI_CallFrame \{[^}]*? api;[^}]*? ctx;[^}]*? stage;[^}]*? args;[^}]*? rets;[^}]*? attrs;",
        header,
    )
