"""Digits, ends and sections: parts that words name by place, found on closed-form shapes."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import find_parts

TURN = np.array([[np.cos(0.4), -np.sin(0.4), 0], [np.sin(0.4), np.cos(0.4), 0], [0, 0, 1.0]])


def fill(low, high, inside, count=8000):
    """Points inside a solid, anywhere in its box."""
    chance, found = np.random.default_rng(0), []
    while sum(map(len, found)) < count:
        points = chance.uniform(low, high, (50_000, 3))
        found.append(points[inside(points)])
    return np.concatenate(found)[:count]


def is_in_rods(points, rods):
    """Mask of the points in rods with round ends: two ends and a radius each."""
    mask = np.zeros(len(points), bool)
    for start, end, radius in rods:
        start, end = np.asarray(start, float), np.asarray(end, float)
        way = end - start
        share = ((points - start) @ way / (way @ way)).clip(0, 1)
        mask |= np.linalg.norm(points - start - share[:, None] * way, axis=1) <= radius
    return mask


def make_hand(thumb=True):
    """A hand that stands on its wrist, its thumb to the left."""
    rods = [((x, 0, 0.4), (1.5 * x, 0, 0.4 + length), 0.05) for x, length in FINGERS]
    rods += [((-0.15, 0, 0.1), (-0.45, 0, 0.4), 0.06)] if thumb else []

    def is_inside(points):
        palm = (np.abs(points - [0, 0, 0.2]) <= [0.22, 0.07, 0.22]).all(1)
        return palm | is_in_rods(points, rods)

    return fill((-0.6, -0.1, -0.1), (0.5, 0.1, 1.0), is_inside, 12_000)


FINGERS = [(-0.17, 0.42), (-0.055, 0.5), (0.06, 0.45), (0.17, 0.35)]


def make_shoe():
    """A shaft on the heel's half of a long, low sole."""

    def is_inside(points):
        x, y, z = points.T
        low = (np.abs(x) < 0.5) & (np.abs(y) < 0.15) & (z < 0.2)
        return low | ((x < -0.1) & (x > -0.5) & (np.abs(y) < 0.14) & (z < 0.55))

    return fill((-0.6, -0.2, 0), (0.6, 0.2, 0.6), is_inside)


def make_mallet():
    """A long handle along x, a head at its low end."""

    def is_inside(points):
        head = (np.abs(points - [-0.45, 0, 0]) <= [0.08, 0.2, 0.06]).all(1)
        return head | is_in_rods(points, [((-0.4, 0, 0), (0.5, 0, 0), 0.04)])

    return fill((-0.6, -0.25, -0.1), (0.6, 0.25, 0.1), is_inside)


def make_sword():
    def is_inside(points):
        guard = (np.abs(points - [0.3, 0, 0]) <= [0.02, 0.15, 0.02]).all(1)
        return guard | is_in_rods(points, [((-0.5, 0, 0), (0.5, 0, 0), 0.03)])

    return fill((-0.6, -0.2, -0.1), (0.6, 0.2, 0.1), is_inside)


def make_spade(*, twin=False):
    """A broad plate at high x, and a bar across the other end of a long shaft, or a plate there as well."""

    def is_inside(points):
        plate = (np.abs(points - [0.4, 0, 0]) <= [0.1, 0.16, 0.02]).all(1)
        plate |= twin & (np.abs(points + [0.4, 0, 0]) <= [0.1, 0.16, 0.02]).all(1)
        shaft, bar = ((-0.5, 0, 0), (0.4, 0, 0), 0.03), ((-0.48, -0.1, 0), (-0.48, 0.1, 0), 0.03)
        return plate | is_in_rods(points, [shaft, bar])

    return fill((-0.6, -0.25, -0.1), (0.6, 0.25, 0.1), is_inside)


def make_maraca():
    """A thin handle along x, and at its high end a ball with a nub."""
    rods = [((-0.5, 0, 0), (0.4, 0, 0), 0.03), ((0.29, 0, 0), (0.3, 0, 0), 0.11)]
    return fill((-0.6, -0.25, -0.25), (0.6, 0.25, 0.25), lambda points: is_in_rods(points, rods))


def make_mushroom():
    def is_inside(points):
        radius, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        cap = (radius <= 0.35 * np.sqrt(np.clip(1 - ((z - 0.6) / 0.4) ** 2, 0, 1))) & (z > 0.6)
        return cap | ((radius <= 0.08) & (z <= 0.6) & (z >= 0))

    return fill((-0.4, -0.4, 0), (0.4, 0.4, 1.0), is_inside)


def make_ship():
    """A hull with a pointed end at high x."""

    def is_inside(points):
        x, y, z = points.T
        return (np.abs(y) < np.where(x > 0.2, 0.15 * (0.5 - x) / 0.3, 0.15)) & (np.abs(x) < 0.5) & (z < 0.15)

    return fill((-0.6, -0.2, 0), (0.6, 0.2, 0.2), is_inside)


def make_fish():
    """A full body, and a thin tall fin at low x."""

    def is_inside(points):
        x, y, z = points.T
        body = (((x - 0.1) / 0.4) ** 2 + (y / 0.12) ** 2 + (z / 0.15) ** 2) <= 1
        fin = (x < -0.25) & (x > -0.5) & (np.abs(y) < 0.02) & (np.abs(z) < 0.6 * (-0.2 - x))
        return body | fin

    return fill((-0.6, -0.2, -0.2), (0.6, 0.2, 0.2), is_inside)


def find(points):
    """Mean place in the object's box of what moves, by first role."""
    low, size = points.min(0), np.ptp(points, axis=0)
    parts = find_parts(points)
    masks = {role: make_region_mask(part.moved, points) for part in parts for role in part.roles}
    return {role: ((points[mask] - low) / size).mean(0) for role, mask in masks.items()}


@pytest.mark.parametrize("turn", [np.eye(3), TURN])
def test_a_hand_has_a_thumb_and_its_fingers_in_order(turn):
    points = make_hand()
    parts = find_parts(points @ turn.T)
    names = ("thumb", "forefinger", "middlefinger", "ringfinger", "littlefinger")
    assert sorted(part.roles[0] for part in parts) == sorted(names)
    by_name = {part.roles[0]: part for part in parts}
    across = [make_region_mask(by_name[name].moved, points @ turn.T) @ points[:, 0] for name in names]
    counts = [make_region_mask(by_name[name].moved, points @ turn.T).sum() for name in names]
    assert np.all(np.diff(np.divide(across, counts)) > 0)
    assert all("finger" in by_name[name].roles for name in names[1:])


def test_horns_and_ears_of_a_head_are_no_fingers():
    """They may be as slim and as many, but they are each other's images."""
    rods = [((0, 0.15 * y, 0.8), (-0.2, 0.25 * y, 1.6), 0.05) for y in (1, -1)]
    rods += [((0, 0.4 * y, 0.7), (-0.1, 0.9 * y, 1.4), 0.05) for y in (1, -1)]

    def is_inside(points):
        return (np.linalg.norm((points - [0, 0, 0.45]) / [0.6, 0.55, 0.5], axis=1) <= 1) | is_in_rods(
            points, rods
        )

    roles = {
        role
        for part in find_parts(fill((-0.7, -1, -0.1), (0.7, 1, 1.7), is_inside, 12_000))
        for role in part.roles
    }
    assert roles and not {"finger", "thumb"} & roles


def test_no_thumb_is_named_where_no_finger_stands_apart():
    roles = {part.roles for part in find_parts(make_hand(thumb=False))}
    assert roles == {("finger",)}


@pytest.mark.parametrize(
    ("make", "places"),
    [
        (make_shoe, dict(toe=(0, 0.85), heel=(0, 0.1))),
        (make_mallet, dict(handle=(0, 0.55), head=(0, 0.08), grip=(0, 0.9))),
        (make_sword, dict(blade=(0, 0.35), handle=(0, 0.92), tip=(0, 0.1))),
        (make_spade, dict(handle=(0, 0.4), head=(0, 0.9), blade=(0, 0.9), grip=(0, 0.1))),
        (make_maraca, dict(handle=(0, 0.3), head=(0, 0.8), grip=(0, 0.1))),
        (make_mushroom, dict(crown=(2, 0.8))),
        (make_ship, dict(tip=(0, 0.85), stern=(0, 0.1))),
        (make_fish, dict(nose=(0, 0.88), stern=(0, 0.08))),
    ],
)
def test_ends_and_sections_lie_where_they_are(make, places):
    found = find(make())
    for role, (axis, where) in places.items():
        assert found[role][axis] == pytest.approx(where, abs=0.12), role


def test_what_a_stem_bears_goes_along_and_its_foot_stays():
    points = make_mushroom()
    (stem,) = (part for part in find_parts(points) if "stem" in part.roles)
    moved, rest = (make_region_mask(region, points) for region in (stem.moved, stem.rest))
    assert points[moved, 2].min() > 0.5 and points[rest, 2].max() < 0.2
    assert 0.2 < stem.joint[2] < 0.4 and stem.arm[2] > 0.5


def test_of_two_ends_that_are_alike_none_is_the_head():
    assert not {"head", "blade", "handle"} & find(make_spade(twin=True)).keys()


def test_a_plain_shape_has_no_ends():
    chance = np.random.default_rng(0)
    ball = chance.normal(size=(6000, 3))
    ball *= (chance.random((6000, 1)) ** (1 / 3)) / np.linalg.norm(ball, axis=1, keepdims=True)
    bar = chance.uniform((-1, -0.2, -0.2), (1, 0.2, 0.2), (6000, 3))
    for points in (ball, bar):
        assert not {"toe", "heel", "tip", "bow", "nose", "stern", "blade", "stem", "crown", "handle"} & {
            role for part in find_parts(points) for role in part.roles
        }
