"""Programs end, whatever the CPU kernels are doing."""

import re

import pytest

from tests.conftest import REPOSITORY
from tests.kernels.processes import QUICKLY, begun, ended, ran

IN_FLIGHT = """
import os, signal, sys
import jax, jax.numpy as jnp
from physagent_jax.mpm import Grid, Model, NeoHookean, State, rollout
x = jnp.stack(jnp.meshgrid(*[jnp.linspace(0.4, 0.6, 8)] * 3), -1).reshape(-1, 3)
one = jnp.ones(len(x))
model = Model(Grid.whole(1.0, 20), jnp.array(1e-3), None, one, 1e-3 * one, (NeoHookean(4e3 * one, 6e3 * one),))
end, _ = rollout(model, State.at_rest(x), frame_count=5, substeps=200)
print(end.x.shape, flush=True)
"""
ENDINGS = {
    "": 0,
    "sys.exit(3)": 3,
    "raise ValueError('no more')": 1,
    "os.kill(os.getpid(), signal.SIGTERM)": -15,
}


@pytest.fixture(scope="module")
def endings():
    """Exit codes of processes that end while a rollout is in flight, all at once."""
    processes = {ending: begun(IN_FLIGHT + ending, **QUICKLY) for ending in ENDINGS}
    return {ending: ended(process) for ending, process in processes.items()}


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_program_ends_while_a_rollout_is_in_flight(endings, ending):
    """Before, an XLA thread that asked for Python's lock was ended by Python, and the process waited for it."""
    code, out, err = endings[ending]
    assert code == ENDINGS[ending], err
    assert out == "(512, 3)\n"


def test_all_code_of_the_pages_as_one_file_runs_and_ends():
    """The last line leaves a rollout in flight, too; the fall after 0.1 s is g t^2 / 2, to the order of the method.

    The robot is coarse here: what is asserted does not depend on its particles and cells, and how long it takes does.
    """
    pages = "\n".join((REPOSITORY / name).read_text() for name in ("README.md", "docs/library.md"))
    program = "\n".join(re.findall(r"```python\n(.*?)```", pages, re.DOTALL))
    fine, coarse = "max_particles=2000", "max_particles=1000, cells=32"
    assert program.count(fine) == program.count("load_object") == 2
    code, out, err = ran(program.replace(fine, coarse), **QUICKLY)
    assert code == 0, err
    value, gradient = out.split("Array(")[1:3]
    height, slope = float(value.split(",")[0]), float(gradient.split("]")[0].split(",")[-1])
    assert height == pytest.approx(0.5 - 9.8 * 0.1**2 / 2, abs=1e-3)
    assert slope == pytest.approx(0.1**2 / 2, rel=0.05)
    assert "(3, 5, 512, 3)" in out
