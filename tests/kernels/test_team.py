"""Several of XLA's threads run one kernel: each iteration is done once, and loops wait for the ones before."""

import re
from pathlib import Path

import jax
import jaxlib
import numpy as np
import pytest

pytest.importorskip("numba")

from numba import cfunc, njit  # noqa: E402  (after the check for Numba)

from physagent_jax.kernels import ffi, team, threads  # noqa: E402
from physagent_jax.kernels.numbers import NO_WRAPPERS  # noqa: E402

COUNT = 97
SLOTS = 64


@njit(**NO_WRAPPERS)
def mirror_twice(frame, number, members):
    """Adds one to all numbers, puts them in the opposite order and then back; and counts what each thread did."""
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


@pytest.fixture(scope="module")
def mirror():
    """The kernel as a function of x, the work of an iteration, and threads."""
    handler = cfunc(ffi.HANDLER)(handle_mirror)
    jax.ffi.register_ffi_target("test_team_mirror", jax.ffi.pycapsule(handler.ctypes), platform="cpu")
    results = tuple(jax.ShapeDtypeStruct((size,), np.float64) for size in (COUNT, COUNT, COUNT + SLOTS))

    def run(x, work, count):
        with jax.enable_x64(True):
            call = jax.ffi.ffi_call("test_team_mirror", results)
            return [np.asarray(each) for each in call(x, np.int32([work]), threads=np.int64(count))]

    yield run
    assert handler  # the code must live as long as XLA may call it


@pytest.mark.parametrize("count", [1, 2, 3, 16])
def test_every_iteration_is_done_once_and_after_the_loop_before(mirror, count):
    """Also with more threads than cores, of which most come too late."""
    x = np.random.default_rng(0).normal(size=COUNT)
    for work in [0, 1, 30] * 100:
        a, b, c = mirror(x, work, count)
        np.testing.assert_array_equal(a, x + 1)
        np.testing.assert_array_equal(b, a[::-1])
        np.testing.assert_array_equal(c[:COUNT], a)
        assert c[COUNT:].sum() <= COUNT


@pytest.mark.skipif(threads.core_count() < 2, reason="needs two cores")
def test_several_threads_take_part(mirror):
    """Who did iterations of the first loop, seen by those who also got a slot of the last one."""
    x = np.zeros(COUNT)
    assert any((mirror(x, 20_000, 2)[2][COUNT:] > 0).sum() > 1 for _ in range(20))
    assert all((mirror(x, 2_000, 1)[2][COUNT:] > 0).sum() == 1 for _ in range(5))


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
