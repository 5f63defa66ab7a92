"""Seats, table tops, backs and arms: the level face of what bears something, and what stands up beside it."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import Frame, find_places
from physagent_jax.scene.parts.decks import find_deck

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))
STEP = 0.02
# Two corners of each box; it is open towards the viewer.
SOFA = [
    ((-0.5, -0.3, 0), (0.5, 0.2, 0.2)),
    ((-0.5, 0.2, 0), (0.5, 0.3, 0.5)),
    *(((x, -0.3, 0), (x + 0.1, 0.2, 0.35)) for x in (-0.5, 0.4)),
]
TABLE = [
    ((-0.5, -0.3, 0.4), (0.5, 0.3, 0.44)),
    *(((x, y, 0), (x + 0.06, y + 0.06, 0.4)) for x in (-0.5, 0.44) for y in (-0.3, 0.24)),
]
STAIRS = [((x, -0.3, 0), (x + 0.5, 0.3, h)) for x, h in ((-0.5, 0.3), (0, 0.6))]


def fill(boxes):
    """Points of a lattice inside boxes, jittered."""
    low, high = np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)
    grid = np.stack(np.meshgrid(*(np.arange(a, b, STEP) for a, b in zip(low, high)), indexing="ij"), -1)
    points = grid.reshape(-1, 3) + STEP / 2
    inside = [((points > a) & (points < b)).all(1) for a, b in boxes]
    kept = points[np.logical_or.reduce(inside)]
    return kept + np.random.default_rng(0).uniform(-0.3, 0.3, kept.shape) * STEP


def turn(points):
    return points[:, [1, 0, 2]] * (-1, 1, 1)


def find(points, *words):
    return {
        each.name: points[make_region_mask(each.moved, points)]
        for each in find_places(points, (), words, "", VIEWER)
    }


def test_a_seat_lies_between_its_arms_and_before_its_back():
    found = find(fill(SOFA), "seat", "backrest", "armrests")
    seat = found["seat"]
    assert seat[:, 2].max() < 0.22 and seat[:, 1].max() < 0.2 and abs(seat[:, 0]).max() < 0.4
    assert found["backrest"][:, 1].min() > 0.17 and found["backrest"][:, 2].min() > 0.18
    assert found["left armrest"][:, 0].max() < -0.37 and found["right armrest"][:, 0].min() > 0.37
    assert found["left armrest"][:, 2].max() < 0.4


def test_arms_of_what_looks_aside_are_told_by_its_own_front():
    points = turn(fill(SOFA))
    deck = find_deck(points)
    assert deck is not None and deck.front == pytest.approx((1, 0, 0))
    assert set(find(points, "armrests")) == {"left armrest", "right armrest"}


def test_arms_of_furniture_are_found_by_the_plain_word():
    assert set(find(fill(SOFA), "arm")) == {"left arm", "right arm"}


def test_a_table_has_a_top_and_neither_back_nor_arms():
    found = find(fill(TABLE), "tabletop", "backrest", "armrest", "arm")
    assert set(found) == {"tabletop"} and found["tabletop"][:, 2].min() > 0.37


def test_of_two_faces_as_large_none_is_the_seat():
    assert find_deck(fill(STAIRS)) is None and find(fill(STAIRS), "seat") == {}
