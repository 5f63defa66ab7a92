"""Parts that stick out of closed-form shapes, and the regions that hold them."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import find_parts
from physagent_jax.scene.parts.lattice import make_lattice

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
COW = [
    *BEAST,
    *(("ball", (0.45, y, 0.38), (0.04, 0.12, 0.04)) for y in (0.15, -0.15)),
    *(("box", (0.45, y, 0.46), (0.02, 0.02, 0.09)) for y in (0.05, -0.05)),
]
POT = ("ball", (0, 0, 0), (0.4, 0.4, 0.32))
RING = ("ring", (0.45, 0, 0), (0.2, 0.05, 0.2))
SPOUT = ("box", (-0.47, 0, 0.1), (0.15, 0.06, 0.06))
LID = [("tube", (0, 0, 0.35), (0.1, 0.1, 0.08)), ("tube", (0, 0, 0.42), (0.2, 0.2, 0.04))]
KNOB = [("tube", (0, 0, 0.48), (0.04, 0.04, 0.04)), ("ball", (0, 0, 0.57), (0.09, 0.09, 0.09))]
CUP = [("tube", (0, 0, 0), (0.35, 0.06, 0.4)), ("box", (0, 0, -0.37), (0.24, 0.24, 0.03))]
JAR = [
    ("tube", (0, 0, 0), (0.3, 0.3, 0.3)),
    ("tube", (0, 0, 0.34), (0.08, 0.08, 0.06)),
    ("ball", (0, 0, 0.48), (0.13, 0.13, 0.13)),
]
LEGS = [("box", (x, y, -0.3), (0.04, 0.04, 0.26)) for x in (0.22, -0.22) for y in (0.22, -0.22)]
CHAIR = [("box", (0, 0, 0), (0.27, 0.27, 0.04)), ("box", (0, 0.23, 0.34), (0.27, 0.04, 0.3)), *LEGS]
BIRD = [
    ("ball", (0, 0, 0), (0.2, 0.36, 0.2)),
    ("ball", (0, -0.42, 0.15), (0.12, 0.12, 0.12)),
    *(("box", (x, 0, 0.05), (0.3, 0.12, 0.03)) for x in (0.4, -0.4)),
    *(("box", (x, 0, -0.27), (0.03, 0.03, 0.15)) for x in (0.08, -0.08)),
]

IMP = [
    ("ball", (0, 0, 0), (0.4, 0.35, 0.4)),
    *(("box", (x, 0, 0.44), (0.04, 0.04, 0.14)) for x in (0.2, -0.2)),
    *(("box", (x, 0, 0.1), (0.12, 0.05, 0.06)) for x in (0.47, -0.47)),
]


def contain(solids, points):
    """A mask of the points in a union of boxes, ellipsoids, upright rings and tubes (kind, centre, half sizes).

    Sizes of a ring across y are its radius, that of its wire, and its radius again; of a tube its radius, the thickness
    of its wall, and half its height.
    """
    inside = np.zeros(len(points), bool)
    for kind, centre, half in solids:
        away = points - centre
        if kind == "ring":
            inside |= np.hypot(np.hypot(away[:, 0], away[:, 2]) - half[0], away[:, 1]) <= half[1]
        elif kind == "tube":
            radius = np.hypot(away[:, 0], away[:, 1])
            wall = (radius <= half[0]) & (radius >= half[0] - half[1])
            inside |= wall & (np.abs(away[:, 2]) <= half[2])
        else:
            q = away / half
            inside |= (np.abs(q) <= 1).all(1) if kind == "box" else (q**2).sum(1) <= 1
    return inside


def find_box(solids):
    low = np.min([np.subtract(c, np.max(s)) for _, c, s in solids], axis=0)
    return low, np.max([np.add(c, np.max(s)) for _, c, s in solids], axis=0)


def fill(solids, count=20_000, seed=0):
    """Points inside a union of solids, anywhere."""
    chance = np.random.default_rng(seed)
    low, high = find_box(solids)
    found, total = [], 0
    while total < count:
        points = chance.uniform(low, high, (100_000, 3))
        found.append(points[contain(solids, points)])
        total += len(found[-1])
    return np.concatenate(found)[:count]


def fill_evenly(solids, count=20_000, seed=0):
    """Points inside a union of solids, jittered on a lattice as a body's particles are."""
    chance = np.random.default_rng(seed)
    low, high = find_box(solids)
    share = contain(solids, chance.uniform(low, high, (200_000, 3))).mean()
    step = (share * np.prod(high - low) / count) ** (1 / 3)
    grid = np.stack(np.meshgrid(*(np.arange(a, b, step) for a, b in zip(low, high)), indexing="ij"), -1)
    points = grid.reshape(-1, 3) + chance.uniform(-0.3, 0.3, (grid.size // 3, 3)) * step
    return points[contain(solids, points)]


def list_roles(points):
    return sorted(part.roles[0] for part in find_parts(points))


@pytest.mark.parametrize(
    ("solids", "roles"),
    [
        (MAN, ["arm", "arm", "head", "leg", "leg"]),
        (BEAST, ["head", "leg", "leg", "leg", "leg", "tail"]),
        (RABBIT, ["ear", "ear", "head"]),
        (IMP, ["ear", "ear", "horn", "horn"]),
        ([("box", (0, 0, 0), (1, 0.5, 0.5))], []),
        ([("box", (0, 0, 0), (0.5, 0.5, 0.5))], []),
        ([("box", (0, 0, 0), (1, 0.7, 0.1))], []),
        ([("ball", (0, 0, 0), (0.5, 0.5, 0.5))], []),
    ],
    ids=["man", "beast", "rabbit", "imp", "box", "cube", "slab", "ball"],
)
def test_the_parts_of_known_shapes_are_found(solids, roles):
    assert list_roles(fill(solids)) == roles
    assert list_roles(fill_evenly(solids)) == roles


@pytest.mark.parametrize(
    ("solids", "roles"),
    [
        (COW, ["ear", "ear", "head", "horn", "horn", "leg", "leg", "leg", "leg", "tail"]),
        (BIRD, ["head", "leg", "leg", "wing", "wing"]),
        (CHAIR, ["back", "leg", "leg", "leg", "leg"]),
        ([*CUP, RING], ["handle"]),
        ([*CUP, ("ring", (0.41, 0, 0), (0.2, 0.06, 0.2))], ["handle"]),
        (CUP, []),
        ([POT, RING, SPOUT, *LID, *KNOB], ["handle", "knob", "lid", "spout"]),
        ([POT, ("ring", (0, 0, 0.3), (0.25, 0.04, 0.25)), SPOUT], ["handle", "spout"]),
    ],
    ids="cow bird chair mug tankard cup teapot kettle".split(),
)
def test_parts_are_told_by_what_is_around_them(solids, roles):
    """Two pairs on a head are horns and ears, a flat pair wings, a loop a handle, and across from it is a spout."""
    assert list_roles(fill_evenly(solids)) == roles


@pytest.mark.parametrize(
    ("solids", "roles"),
    [
        (JAR, ["top"]),
        ([("tube", (0, 0, 0), (0.3, 0.3, 0.06)), ("box", (0.5, 0, 0), (0.25, 0.04, 0.03))], ["side"]),
        ([POT, RING, ("ring", (-0.45, 0, 0), (0.2, 0.05, 0.2))], ["side", "side"]),
        (
            [("ball", (0, 0, 0.2), (0.4, 0.4, 0.2)), ("tube", (0, 0, -0.25), (0.08, 0.08, 0.3))],
            ["bottom", "top"],
        ),
    ],
    ids=["jar", "pan", "two handles", "mushroom"],
)
def test_a_part_that_may_be_several_things_is_named_by_its_place_alone(solids, roles):
    """A knob may be a head, and a stem a leg: what the object does not tell is left to the sentence."""
    assert list_roles(fill_evenly(solids)) == roles


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


def test_a_surface_with_holes_encloses_the_same():
    """Few particles on it beside many: the solid must not leak, or nothing is as thick as it is."""
    chance = np.random.default_rng(0)
    ball = chance.normal(size=(12_000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    thinned = ball[(ball[:, 0] < 0.2) | (chance.random(len(ball)) < 0.5)]
    whole, holed = make_lattice(ball), make_lattice(thinned)
    volumes = [len(each.places) * each.spacing**3 for each in (whole, holed)]
    assert volumes[0] > 3.5 and volumes[1] > 0.8 * volumes[0]


LANDER = [
    ("box", (0, 0, 0), (0.3, 0.3, 0.25)),
    *LEGS,
    ("tube", (0, 0, 0.3), (0.04, 0.04, 0.08)),
    ("ball", (0, 0, 0.45), (0.13, 0.13, 0.08)),
]


def test_what_stands_on_legs_has_other_parts_too():
    """A lander has a dish; alone on top, it may be a head as well."""
    roles = sorted(part.roles for part in find_parts(fill_evenly(LANDER)))
    assert roles == [("leg",)] * 4 + [("top", "head")]
