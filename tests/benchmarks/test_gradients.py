"""The table of what gradients cost."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.gradients import MATERIALS, document, make_cube
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
    page = document({"cost": {"runs": [run], "complete": True, "rows": [row]}}, Path("a.json"), Path("b.md"))
    assert "| 20,000 | 200 | 1.5 | 6 | 4 (3.9 to 4.1) | 5 |  | 2 | 1, 9 |" in page
    assert "Not measured yet: precision" in page


@pytest.mark.parametrize("material", MATERIALS)
def test_cubes_of_other_materials_have_their_law_and_viscosity(material):
    model, state = make_cube(200, np.float32, material=material)
    law, viscosity = MATERIALS[material]
    assert type(model.materials[0]).__name__ == LAWS[law]
    assert (0 if model.viscosity is None else float(model.viscosity.max())) == viscosity
    assert state.v.shape == (200, 3)
