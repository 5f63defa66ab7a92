"""First use of the kernels: from threads at the same time, and from processes that were spawned or forked."""

import multiprocessing
import os

import numpy as np
import pytest

pytest.importorskip("numba")

from tests.kernels.first_use import compute_gradient  # noqa: E402  (after the check for Numba)
from tests.kernels.processes import QUICKLY, ran  # noqa: E402

needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
PROGRAM = """
import sys
sys.argv = ["program"]
from tests.kernels import first_use
if __name__ == "__main__":
    print({})
"""


def run_program(call, **environment):
    """The output of a call of `tests.kernels.first_use`, in its own interpreter and compiled quickly."""
    code, out, err = ran(PROGRAM.format(call), **QUICKLY, **environment)
    assert code == 0, err
    return np.array(out.strip("[]\n").split(","), float)


@pytest.fixture(scope="module")
def answers():
    """Gradients of the three shapes, which one thread computes after the other; their kernels are on disk then."""
    return [compute_gradient(40 + shape) for shape in range(3)]


def test_twelve_threads_whose_first_gradient_it_is(answers):
    """XLA takes a handler's name once: before, all threads but one failed."""
    got = run_program("first_use.compute_in_threads(12, 3)")
    np.testing.assert_allclose(got, np.tile(answers, 4), rtol=1e-4)


@pytest.mark.slow
def test_twelve_threads_where_no_kernel_has_been_compiled(answers, tmp_path):
    got = run_program("first_use.compute_in_threads(12, 3)", NUMBA_CACHE_DIR=str(tmp_path))
    np.testing.assert_allclose(got, np.tile(answers, 4), rtol=1e-4)
    assert not [path for path in tmp_path.rglob(".*")]


@pytest.mark.parametrize("method", ["spawn", pytest.param("forkserver", marks=pytest.mark.slow)])
def test_processes_that_begin_together(answers, method):
    """After their parent has computed."""
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip("the system cannot begin processes so")
    got = run_program(f"[first_use.compute_gradient(41), *first_use.compute_in_processes({method!r}, 2)]")
    np.testing.assert_allclose(got, [answers[1], answers[0], answers[0]], rtol=1e-4)


FORKING = """
import os, signal, sys
from tests.kernels import first_use
from physagent_jax.core.errors import UserError
{before}
child = os.fork()
if child == 0:
    signal.alarm(first_use.LIMIT)
    try:
        print(first_use.compute_gradient(), flush=True)
    except UserError as error:
        print(error, flush=True)
    os._exit(0)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@needs_fork
def test_a_forked_process_computes_if_nothing_was_computed_before(answers):
    code, out, err = ran(FORKING.format(before=""), **QUICKLY)
    assert code == 0, err
    assert float(out) == pytest.approx(answers[0], rel=1e-4)


@needs_fork
def test_a_process_forked_from_one_that_computes_is_refused_in_one_line():
    """Before, it hung: a forked process has none of the threads to which XLA gives the work."""
    code, out, err = ran(FORKING.format(before="print(first_use.compute_gradient(), flush=True)"), **QUICKLY)
    assert code == 0, err
    gradient, line = out.splitlines()
    assert float(gradient) and "forked" in line and 'get_context("spawn")' in line
