"""Regions of vehicles, towers, trees and statues on a base, of which the file names nothing."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.motion.limbs import find_named_front
from physagent_jax.scene.parts import Frame, find_parts, find_places
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.heading import find_heading
from tests.scene.test_decks import SOFA, fill
from tests.scene.test_part_roles import CAT, make

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))
# Two corners of each box. Its hood is long, on the left.
CAR = [
    ((-0.5, -0.2, 0.08), (0.5, 0.2, 0.25)),
    ((-0.1, -0.18, 0.25), (0.4, 0.18, 0.42)),
    *(((x, y, 0), (x + 0.14, y + 0.06, 0.14)) for x in (-0.4, 0.26) for y in (-0.2, 0.14)),
]
TREE = [((0, 0, -0.5), (0, 0, 0.1), 0.06), ((0, 0, 0.3), (0.3, 0.3, 0.28))]
STATUE = [
    ((0, 0, -0.4), (0.22, 0.22, 0.1)),
    ((0, 0, -0.25), (0, 0, 0.3), 0.1),
    ((0, 0, 0.42), (0.09, 0.09, 0.1)),
]


def find(points, *words, parts=(), name="thing"):
    """The particles of each region by its name."""
    found = find_places(points, parts, words, name, VIEWER)
    return {each.name: points[make_region_mask(each.moved, points)] for each in found}


def test_a_car_is_lower_in_front():
    told = find_heading(fill(CAR), ())
    assert told is not None
    heading, chance = told
    assert heading == pytest.approx((-1, 0, 0)) and 0.6 <= chance < 1
    assert find_heading(fill(SOFA[:1]), ()) is None  # a block has no front


def test_names_tell_the_front_for_certain():
    points = fill(CAR)
    rear = fit_part(points, points[:, 0] < -0.4, joined=True).model_copy(
        update=dict(name="rear bumper", origin="file")
    )
    assert find_heading(points, (rear,)) == (pytest.approx((1, 0, 0)), 1.0)


@pytest.mark.parametrize(
    "front, rear", [("f tyre", "b tyre"), ("roda frente", "roda traseira"), ("Rad vorn", "Rad hinten")]
)
def test_letters_beside_each_other_and_other_languages_tell_the_front(front, rear):
    """A bicycle with the parts "f pneu" and "b pneu" rode backwards."""
    points = fill(CAR)
    parts = [
        fit_part(points, chosen, joined=True).model_copy(update=dict(name=name, origin="file"))
        for name, chosen in (
            (front, points[:, 0] > 0.3),
            (rear, points[:, 0] < -0.3),
            ("b seat", abs(points[:, 0]) < 0.1),
        )
    ]
    assert find_heading(points, parts) == (pytest.approx((1, 0, 0)), 1.0)
    assert find_named_front(parts) == pytest.approx((1, 0, 0), abs=0.1)


@pytest.mark.parametrize(
    ("word", "names", "low", "high"),
    [
        ("hood", {"hood"}, (-0.5, -0.2, 0.1), (-0.15, 0.2, 0.3)),
        ("trunk", {"trunk"}, (0.2, -0.2, 0.15), (0.5, 0.2, 0.42)),
        ("windscreen", {"windscreen"}, (-0.25, -0.2, 0.25), (0.0, 0.2, 0.43)),
        ("cab", {"cab"}, (-0.25, -0.2, 0.25), (0.3, 0.2, 0.43)),
        ("bumpers", {"front bumper", "rear bumper"}, (-0.5, -0.2, 0.0), (0.5, 0.2, 0.25)),
        ("headlight", {"left headlight", "right headlight"}, (-0.5, -0.2, 0.08), (-0.4, 0.2, 0.3)),
    ],
)
def test_parts_of_a_car_lie_where_they_do_on_all_cars(word, names, low, high):
    found = find(fill(CAR), word)
    assert set(found) == names
    for own in found.values():
        inside = ((own >= np.subtract(low, 0.04)) & (own <= np.add(high, 0.04))).all(1)
        assert len(own) > 20 and inside.mean() > 0.95


def test_a_car_has_four_wheels_at_its_lower_corners():
    found = find(fill(CAR), "wheels")
    assert len(found) == 4 and all(own[:, 2].max() < 0.2 for own in found.values())
    assert found["front left wheel"][:, 0].max() < -0.1 < 0.1 < found["rear left wheel"][:, 0].min()
    sides = [np.sign(found[f"front {side} wheel"][:, 1].mean()) for side in ("left", "right")]
    assert sides[0] * sides[1] < 0


def test_an_animal_has_no_hood_and_no_wheels():
    points = make(CAT)
    assert find(points, "hood", "wheel", "door", parts=find_parts(points)) == {}


def test_a_trunk_and_a_tower_are_what_is_left():
    points = make(TREE)
    crown = fit_part(points, points[:, 2] > 0.08, joined=True).model_copy(update=dict(roles=("top", "crown")))
    assert find(points, "trunk", parts=(crown,))["trunk"][:, 2].max() < 0.15
    sails = fit_part(points, points[:, 2] > 0.08, joined=True).model_copy(
        update=dict(name="blades", origin="file")
    )
    assert find(points, "tower", parts=(sails,))["tower"][:, 2].max() < 0.15


def test_the_part_called_as_the_object_is_its_main_body():
    points = make(TREE)
    masks = dict(windmill=points[:, 2] < 0.0, blades=points[:, 2] > 0.3)
    parts = [
        fit_part(points, m, joined=True).model_copy(update=dict(name=n, origin="file"))
        for n, m in masks.items()
    ]
    assert find(points, "tower", parts=parts, name="Windmill")["tower"][:, 2].max() < 0.05


def test_a_statue_on_a_base_has_a_head_of_its_own_and_a_pedestal():
    """The figure is found as one part on top of its base; it is no head."""
    points = make(STATUE)
    figure = fit_part(points, points[:, 2] > -0.28, joined=True).model_copy(
        update=dict(roles=("top",), origin="shape")
    )
    found = find(points, "head", "pedestal", parts=(figure,))
    assert found["head"][:, 2].min() > 0.15 and found["pedestal"][:, 2].max() < -0.2


def test_the_back_of_a_sofa_is_its_back():
    assert find(fill(SOFA), "back")["back"][:, 1].min() > 0.17
