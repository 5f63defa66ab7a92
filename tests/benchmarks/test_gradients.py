"""The table of what gradients cost."""

import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.gradients.cube import MATERIALS, make_cube
from benchmarks.gradients.markdown import write_tables
from benchmarks.gradients.profile import Machine, count_bytes, count_operations, measure_profile, reverse
from benchmarks.peers.scene import Material

LAWS = {
    Material.JELLY: "FixedCorotated",
    Material.NEO_HOOKEAN: "NeoHookean",
    Material.METAL: "VonMises",
    Material.SAND: "DruckerPrager",
    Material.FLUID: "Fluid",
}


def test_the_page_shows_ratio_aim_and_memory_and_what_is_missing():
    row = {
        "run": 0,
        "job": "20 x 200",
        "particles": 20_000,
        "substeps": 200,
        "forward_ms": 1.5,
        "gradient_ms": 6.0,
    }
    row |= {"ratio": 4.0, "ratio_range": [3.9, 4.1], "aim": 5.0, "memory_gb": None, "allowed_gb": 2.0}
    row |= {"first_seconds": [1.0, 9.0]}
    run = {
        "quick": False,
        "seconds": 3.0,
        "command": "c",
        "machine": "m",
        "load_average": [0.1],
        "git_revision": "r",
    }
    page = "\n".join(write_tables({"cost": {"runs": [run], "complete": True, "rows": [row]}}).values())
    assert "| 20,000 | 200 | 1.5 | 6 | 4 (3.9 to 4.1) | 5 |  | 2 | 1, 9 |" in page
    assert "Not measured yet: precision" in page


@pytest.mark.parametrize("material", MATERIALS)
def test_cubes_of_other_materials_have_their_law_and_viscosity(material):
    model, state = make_cube(200, np.float32, material=material)
    law, viscosity = MATERIALS[material]
    assert type(model.materials[0]).__name__ == LAWS[law]
    assert (0 if model.viscosity is None else float(model.viscosity.max())) == viscosity
    assert state.v.shape == (200, 3)


def test_bytes_and_operations_of_a_product_are_those_that_it_has():
    """A matrix times a vector: 2 n^2 operations on n^2 + 2 n numbers; its derivative by the vector alone likewise."""
    n = 64
    matrix, vector = jnp.ones((n, n), jnp.float32), jnp.ones(n, jnp.float32)
    multiply = matrix.__matmul__
    assert count_bytes(multiply, (vector,)) == 4 * 2 * n
    assert count_operations(multiply, (vector,)) == pytest.approx(2 * n**2, rel=0.05)
    pull, arguments = reverse(multiply, (vector,))
    assert np.allclose(pull(*arguments)[0], n) and count_bytes(pull, arguments) == 4 * 3 * n
    assert count_operations(pull, arguments) == pytest.approx(2 * n**2, rel=0.05)
    assert Machine(1e9, 1e10).find_floor(2e6, 1e6) == 2 and Machine(1e9, 1e8).find_floor(2e6, 1e6) == 10


def test_the_profile_has_every_stage_and_the_whole():
    rows = measure_profile(300, 5, 1)
    assert [row["stage"] for row in rows][3:] == ["sum of the stages", "substep, as it runs"]
    for row in rows[:3]:
        assert row["forward_ms"] > 0 and row["reverse_ms"] > 0
        assert (
            row["reverse_bytes"] > row["forward_bytes"] / 2
            and row["reverse_operations"] > row["forward_operations"]
        )
    assert rows[3]["reverse_floor_ms"] == pytest.approx(sum(row["reverse_floor_ms"] for row in rows[:3]))
