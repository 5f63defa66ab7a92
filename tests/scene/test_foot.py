"""The straight edges of an object's foot."""

import numpy as np
import pytest

from physagent_jax.scene.foot import find_foot_edges

RANDOM = np.random.default_rng(0)


@pytest.mark.parametrize("degrees", [0, 30])
def test_a_box_has_four_edges_where_its_sides_are(degrees):
    corners = RANDOM.uniform(-0.5, 0.5, (20_000, 3)) * [1.0, 0.6, 0.8]
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    edges = find_foot_edges(corners @ [[c, s, 0], [-s, c, 0], [0, 0, 1]])
    ways = np.array([way for way, _ in edges])
    assert len(edges) == 4
    np.testing.assert_allclose(sorted(abs(ways @ [c, s, 0])), [0, 0, 1, 1], atol=1e-9)
    size = 1.0 if degrees == 0 else c + 0.6 * s
    assert sorted(reach * size for _, reach in edges) == pytest.approx([0.3, 0.3, 0.5, 0.5], abs=0.03)


def test_what_stands_on_a_round_foot_has_none():
    angles = RANDOM.uniform(0, 2 * np.pi, 20_000)
    can = np.stack([np.cos(angles), np.sin(angles), RANDOM.uniform(0, 3, 20_000)], axis=1)
    assert find_foot_edges(can) == []
