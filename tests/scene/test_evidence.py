"""The chance that a part is what it is called: clear shapes are certain, pairs that miss each other are not."""

import pytest

from physagent_jax.scene.parts import find_parts
from tests.scene.test_part_roles import CAT, FIGURE, make
from tests.scene.test_parts import CUP, POT, RING, SPOUT, fill_evenly

POSED = [
    *(shape for shape in FIGURE if not (len(shape) == 3 and abs(shape[1][1]) == 0.38)),
    ((0, 0.12, 0.24), (0.02, 0.4, 0.35), 0.045),
    ((0, -0.12, 0.17), (0.02, -0.35, -0.02), 0.045),
]
"""A figure whose arms point other ways, and are set on at other heights."""


def weigh(points):
    """The least chance of each role."""
    found = {}
    for part in find_parts(points):
        found[part.roles[0]] = min(part.confidence, found.get(part.roles[0], 1.0))
    return found


@pytest.mark.parametrize("shapes", [CAT, FIGURE], ids=["cat", "figure"])
def test_what_stands_out_and_has_its_image_is_certain(shapes):
    parts = find_parts(make(shapes))
    assert parts and all(part.confidence > 0.7 and not part.unsure for part in parts)


def test_handles_and_spouts_are_certain():
    assert min(weigh(fill_evenly([*CUP, RING])).values()) > 0.7
    assert min(weigh(fill_evenly([POT, RING, SPOUT])).values()) > 0.7


def test_a_pair_that_misses_its_image_is_less_certain_than_one_that_fits():
    posed, even = weigh(make(POSED)), weigh(make(FIGURE))
    assert posed["arm"] < even["arm"] - 0.05 and posed["leg"] > posed["arm"]


def test_a_thick_loop_is_hardly_a_handle():
    """A ring whose hole is small beside its wire."""
    thick = ("ring", (0.45, 0, 0), (0.19, 0.13, 0.19))
    thin = weigh(fill_evenly([*CUP, RING]))["handle"]
    assert weigh(fill_evenly([*CUP, thick])).get("handle", 0.0) < thin
