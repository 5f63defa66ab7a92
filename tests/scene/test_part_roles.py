"""Roles of the parts of animals, people and planes that are built of bars and plates."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import find_parts, marking

SIDES = (1, -1)


def make(shapes, count=20_000, seed=0):
    """Points inside a union of shapes, jittered on a lattice as a body's particles are.

    A shape is a bar with round ends (end, end, radius), or an ellipsoid (centre, half sizes); z is up.
    """
    chance = np.random.default_rng(seed)
    boxes = [(np.min(s[:-1], 0) - s[-1], np.max(s[:-1], 0) + s[-1]) for s in shapes]
    low, high = np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)
    share = contain(shapes, chance.uniform(low, high, (100_000, 3))).mean()
    step = (share * np.prod(high - low) / count) ** (1 / 3)
    grid = np.stack(np.meshgrid(*(np.arange(a, b, step) for a, b in zip(low, high)), indexing="ij"), -1)
    points = grid.reshape(-1, 3) + chance.uniform(-0.3, 0.3, (grid.size // 3, 3)) * step
    return points[contain(shapes, points)]


def contain(shapes, points):
    inside = np.zeros(len(points), bool)
    for shape in shapes:
        if len(shape) == 3:
            start, end, radius = map(np.asarray, shape)
            way = end - start
            along = ((points - start) @ way / (way @ way)).clip(0, 1)
            inside |= np.linalg.norm(points - start - along[:, None] * way, axis=1) <= radius
        else:
            inside |= (((points - shape[0]) / np.asarray(shape[1])) ** 2).sum(1) <= 1
    return inside


def turn(points, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


# Looking along +x.
CAT = [
    ((-0.4, 0, 0), (0.35, 0, 0), 0.15),
    ((0.4, 0, 0.05), (0.6, 0, 0.25), 0.06),
    ((0.68, 0, 0.3), (0.17, 0.13, 0.13)),
    *(((0.64, 0.09 * k, 0.37), (0.62, 0.12 * k, 0.5), 0.035) for k in SIDES),
    *(((x, 0.09 * k, 0), (x, 0.09 * k, -0.4), 0.05) for x in (0.35, -0.4) for k in SIDES),
    ((-0.5, 0, 0.05), (-0.6, 0, 0.8), 0.04),
]
PLANE = [
    ((-0.5, 0, 0), (0.5, 0, 0), 0.07),
    *(((0.0, 0.27 * k, 0), (0.11, 0.27, 0.02)) for k in SIDES),
    *(((-0.46, 0.13 * k, 0.03), (0.06, 0.14, 0.02)) for k in SIDES),
    ((-0.48, 0, 0.13), (0.07, 0.02, 0.14)),
]
FIGURE = [
    ((0, 0, -0.05), (0, 0, 0.2), 0.13),
    ((0, 0, 0.3), (0, 0, 0.4), 0.05),
    ((0, 0, 0.48), (0.12, 0.12, 0.12)),
    *(((0, 0.08 * k, 0.56), (0, 0.13 * k, 0.68), 0.035) for k in SIDES),
    *(((0, 0.12 * k, 0.22), (0.02, 0.38 * k, 0.05), 0.045) for k in SIDES),
    *(((0, 0.08 * k, -0.1), (0, 0.1 * k, -0.55), 0.055) for k in SIDES),
]
FISH = [
    ((0, 0, 0), (0.4, 0.13, 0.2)),
    ((-0.35, 0, 0), (-0.5, 0, 0), 0.05),
    ((-0.58, 0, 0), (0.12, 0.03, 0.2)),
    *(((0.05, 0.17 * k, -0.03), (0.07, 0.12, 0.03)) for k in SIDES),
]
BIG_EARS = [
    ((0, 0, -0.1), (0, 0, 0.1), 0.16),
    ((0, 0, 0.42), (0.22, 0.22, 0.22)),
    *(((0, 0.4 * k, 0.45), (0.04, 0.22, 0.2)) for k in SIDES),
    *(((0, 0.15 * k, 0.1), (0, 0.28 * k, -0.1), 0.04) for k in SIDES),
    *(((-0.02, 0.1 * k, -0.3), (0.12, 0.1 * k, -0.3), 0.07) for k in SIDES),
]
IMP = [
    ((0, 0, 0), (0.3, 0.3, 0.32)),
    *(((0, 0.17 * k, 0.22), (0, 0.36 * k, 0.4), 0.07) for k in SIDES),
    *(((-0.12, 0.42 * k, 0.05), (0.025, 0.2, 0.1)) for k in SIDES),
]
TRUNK = ((0.2, 0, 0.4), (0.38, 0, 0.12), 0.05)
CACTUS = [
    ((0, 0, -0.5), (0, 0, 0.5), 0.15),
    *(((0.05 * k, 0, z), (0.28 * k, 0, z), 0.1) for k, z in ((1, -0.2), (-1, 0.1))),
    *(((0.28 * k, 0, z), (0.28 * k, 0, z + 0.25), 0.1) for k, z in ((1, -0.2), (-1, 0.1))),
]
HAND = [
    ((0, 0, -0.5), (0, 0, -0.3), 0.12),
    ((0, 0, 0), (0.08, 0.25, 0.3)),
    *(((0, y, 0.2), (0, 1.5 * y, 0.65 - abs(y)), 0.05) for y in (-0.18, -0.06, 0.06, 0.18)),
    ((0.02, 0.2, -0.1), (0.05, 0.5, 0.15), 0.055),
]

CAKE = [
    ((0, 0, 0), (0.5, 0.5, 0.2)),
    *(
        ((0.25 * x, 0.25 * y, 0.1), (0.25 * x, 0.25 * y, 0.42), 0.035)
        for x, y in np.stack([np.cos(np.arange(5) * 0.4 * np.pi), np.sin(np.arange(5) * 0.4 * np.pi)], 1)
    ),
]


def list_roles(points):
    return sorted(part.roles[0] for part in find_parts(points))


@pytest.mark.parametrize("degrees", [0, 35])
@pytest.mark.parametrize(
    ("shapes", "roles"),
    [
        (CAT, "ear ear head leg leg leg leg tail"),
        (PLANE, "nose tail wing wing"),
        (FIGURE, "arm arm ear ear head leg leg"),
        (BIG_EARS, "arm arm ear ear head leg leg"),
        (FISH, "nose tail wing wing"),
        (IMP, "ear ear wing wing"),
        (CAKE, "spike spike spike spike spike"),
    ],
    ids="cat plane figure big_ears fish imp cake".split(),
)
def test_limbs_are_called_what_a_person_calls_them(shapes, roles, degrees):
    """A tail that stands up is no head, a tailplane no wing, an arm no ear; whichever way the thing is turned."""
    assert list_roles(turn(make(shapes), degrees)) == roles.split()


def test_a_lone_limb_in_front_of_a_figure_is_its_trunk():
    assert list_roles(make([*BIG_EARS, TRUNK], count=8000)).count("nose") == 1


def test_stout_arms_of_a_column_are_limbs_though_nothing_thin_is_found(monkeypatch):
    """A thing has limbs, too, that see little of the rest and are clearly apart."""
    monkeypatch.setattr(marking, "find_limbs", lambda points, lattice: [])
    sides = [part for part in find_parts(make(CACTUS, count=12_000)) if part.roles[0] == "side"]
    assert sorted(part.side[0] > 0 for part in sides) == [False, True]
    assert all(0.08 < part.share < 0.25 for part in sides)


def test_a_column_beside_an_upright_arm_is_no_part_of_it():
    """A narrow gap parts them: seeds on either side of it tell which is which."""
    points = make(CACTUS, count=12_000)
    column = (np.abs(points[:, 0]) < 0.15) & (points[:, 2] > 0.1)
    (arm,) = (part for part in find_parts(points) if part.roles[0] == "side" and part.side[0] > 0)
    assert not (make_region_mask(arm.moved, points) & column).any()


def test_what_no_rule_tells_has_no_wrong_name():
    """Fingers are no ears, and the palm that they are on no head."""
    assert not {"head", "ear", "tail", "leg", "wing"} & set(list_roles(make(HAND)))


@pytest.mark.parametrize(
    "tail",
    [
        [((-0.6, 0, 0.08), (0.13, 0.03, 0.24))],
        [
            ((-0.56, 0, 0.02), (0.12, 0.03, 0.12)),
            *(((-0.56, 0, 0), (-0.68, 0, z), 0.025) for z in (0.22, -0.2)),
        ],
    ],
    ids="blade fork".split(),
)
def test_the_tail_of_a_fish_that_lies_on_its_fins_is_no_head(tail):
    fins = [((x, 0.1 * k, -0.14), (x - 0.1, 0.2 * k, -0.24), 0.03) for k in SIDES for x in (0.3, -0.15)]
    body = [((0, 0, 0), (0.45, 0.13, 0.2)), ((-0.35, 0, 0.03), (-0.5, 0, 0.03), 0.06)]
    assert list_roles(make([*body, *tail, *fins])) == ["leg", "leg", "leg", "leg", "tail"]


def test_wings_are_the_pair_in_front_of_the_tail():
    places = {part.roles[0]: part.side[0] for part in find_parts(make(PLANE))}
    assert places["tail"] < -0.5 < places["wing"]


def test_a_pose_keeps_the_pairs():
    """One arm up and one down are a pair still: they hang on joints that are each other's image."""
    arms = [shape for shape in FIGURE if not (len(shape) == 3 and abs(shape[1][1]) == 0.38)]
    posed = [
        *arms,
        ((0, 0.12, 0.22), (0.02, 0.4, 0.3), 0.045),
        ((0, -0.12, 0.22), (0.02, -0.35, 0.02), 0.045),
    ]
    assert list_roles(make(posed)).count("arm") == 2
