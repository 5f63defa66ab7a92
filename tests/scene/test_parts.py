"""Parts that stick out of closed-form shapes, and the regions that hold them."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import find_parts

MAN = [
    ("box", (0, 0, 0), (0.15, 0.1, 0.3)),
    ("ball", (0, 0, 0.42), (0.15, 0.15, 0.15)),
    ("box", (0.3, 0, 0.2), (0.2, 0.06, 0.06)),
    ("box", (-0.3, 0, 0.2), (0.2, 0.06, 0.06)),
    ("box", (0.09, 0, -0.45), (0.06, 0.085, 0.2)),
    ("box", (-0.09, 0, -0.45), (0.06, 0.085, 0.2)),
]
BEAST = [
    ("box", (0, 0, 0), (0.4, 0.15, 0.15)),
    ("box", (0.45, 0, 0.25), (0.1, 0.08, 0.15)),
    ("box", (-0.5, 0, 0.1), (0.15, 0.03, 0.03)),
    *(("box", (x, y, -0.3), (0.05, 0.05, 0.2)) for x in (0.33, -0.33) for y in (0.1, -0.1)),
]
RABBIT = [
    ("ball", (0, 0, 0), (0.3, 0.3, 0.35)),
    ("ball", (0, 0, 0.45), (0.18, 0.18, 0.18)),
    ("ball", (0.09, 0, 0.75), (0.05, 0.03, 0.2)),
    ("ball", (-0.09, 0, 0.75), (0.05, 0.03, 0.2)),
]


def fill(solids, count=20_000, seed=0):
    """Points inside a union of boxes and ellipsoids (kind, centre, half sizes)."""
    chance = np.random.default_rng(seed)
    low = np.min([np.subtract(c, s) for _, c, s in solids], axis=0)
    high = np.max([np.add(c, s) for _, c, s in solids], axis=0)
    found, total = [], 0
    while total < count:
        points = chance.uniform(low, high, (100_000, 3))
        inside = np.zeros(len(points), bool)
        for kind, centre, half in solids:
            q = (points - centre) / half
            inside |= (np.abs(q) <= 1).all(1) if kind == "box" else (q**2).sum(1) <= 1
        found.append(points[inside])
        total += inside.sum()
    return np.concatenate(found)[:count]


def list_roles(points):
    return sorted(part.roles[0] for part in find_parts(points))


@pytest.mark.parametrize(
    ("solids", "roles"),
    [
        (MAN, ["arm", "arm", "head", "leg", "leg"]),
        (BEAST, ["head", "leg", "leg", "leg", "leg", "tail"]),
        (RABBIT, ["ear", "ear", "head"]),
        ([("box", (0, 0, 0), (1, 0.5, 0.5))], []),
        ([("box", (0, 0, 0), (0.5, 0.5, 0.5))], []),
        ([("box", (0, 0, 0), (1, 0.7, 0.1))], []),
        ([("ball", (0, 0, 0), (0.5, 0.5, 0.5))], []),
    ],
    ids=["man", "beast", "rabbit", "box", "cube", "slab", "ball"],
)
def test_the_parts_of_known_shapes_are_found(solids, roles):
    assert list_roles(fill(solids)) == roles


def test_neither_size_nor_order_nor_place_matters():
    points = fill(MAN)
    moved = np.random.default_rng(1).permutation(points) * 7.5 + (3, -2, 40)
    assert list_roles(moved) == list_roles(points)


def test_regions_hold_the_arm_beyond_its_joint_and_all_else():
    points = fill(MAN)
    (left,) = [part for part in find_parts(points) if part.roles[0] == "arm" and part.side[0] < 0]
    moved, rest = make_region_mask(left.moved, points), make_region_mask(left.rest, points)
    assert not (moved & rest).any()
    assert points[moved, 0].max() < -0.15  # beyond the shoulder
    assert moved.sum() > 0.5 * (points[:, 0] < -0.2).sum()
    assert rest[points[:, 0] > -0.1].mean() > 0.98
    joint = points.min(0) + np.array(left.joint) * np.ptp(points, axis=0)
    np.testing.assert_allclose(joint, (-0.15, 0, 0.2), atol=0.12)  # a tenth of the height, or less
    assert left.arm[0] < -0.1 and abs(left.arm[0]) > 3 * np.abs(left.arm[1:]).max()
