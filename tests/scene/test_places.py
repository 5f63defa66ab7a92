"""Regions that a word names by their place: where they lie, what they leave alone, and what is not found."""

import numpy as np
import pytest

from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.forces.regions import grade_part, make_region_mask
from physagent_jax.forces.schema import Bend
from physagent_jax.scene.parts import Frame, find_parts, find_places
from physagent_jax.scene.parts.places import read_places
from tests.scene.test_part_roles import CAT, FIGURE, make

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))


@pytest.fixture(scope="module")
def known():
    """Points and parts of a cat that looks along +x, and of a figure with its arms along x."""
    return {name: (x := make(shapes), find_parts(x)) for name, shapes in (("cat", CAT), ("man", turn_up()))}


def turn_up():
    """The figure turned about the vertical, so that its left and right are the viewer's."""

    def turn(value):
        x, y, z = value
        return (y, -x, z)

    return [
        tuple(turn(each) if np.ndim(each) else each for each in shape[:2]) + shape[2:] for shape in FIGURE
    ]


def find(known, name, *words, called="thing"):
    points, parts = known[name]
    return points, find_places(points, parts, words, called, VIEWER)


@pytest.mark.parametrize(
    ("name", "word", "low", "high"),
    [
        ("cat", "muzzle", (0.7, -0.13, 0.15), (0.9, 0.13, 0.42)),
        ("cat", "forehead", (0.6, -0.15, 0.3), (0.9, 0.15, 0.45)),
        ("cat", "chest", (0.15, -0.2, -0.2), (0.6, 0.2, 0.2)),
        ("cat", "belly", (-0.4, -0.2, -0.2), (0.35, 0.2, 0.02)),
        ("cat", "rump", (-0.65, -0.2, -0.1), (-0.2, 0.2, 0.2)),
        ("man", "nose", (-0.13, -0.15, 0.36), (0.13, 0.0, 0.6)),
        ("man", "chest", (-0.2, -0.15, 0.05), (0.2, 0.03, 0.45)),
        ("man", "belly", (-0.2, -0.15, -0.25), (0.2, 0.03, 0.15)),
        ("man", "roof", (-0.2, -0.2, 0.3), (0.2, 0.2, 0.75)),
    ],
)
def test_a_word_for_a_place_is_a_region_of_its_parent(known, name, word, low, high):
    points, (region,) = find(known, name, word)
    inside = make_region_mask(region.moved, points)
    within = ((points >= np.subtract(low, 0.04)) & (points <= np.add(high, 0.04))).all(1)
    assert region.name == word and region.origin == "place" and 0.003 < inside.mean() < 0.35
    assert (inside & within).sum() > 0.95 * inside.sum()


def test_of_two_sides_each_is_a_region(known):
    points, regions = find(known, "man", "shoulders")
    assert [each.name for each in regions] == ["left shoulder", "right shoulder"]
    left, right = (points[make_region_mask(each.moved, points)] for each in regions)
    assert (
        left[:, 0].max() < -0.02 < 0.02 < right[:, 0].min() and min(left[:, 2].min(), right[:, 2].min()) > 0
    )


def test_each_limb_has_its_own_middle(known):
    points, knees = find(known, "cat", "knee")
    assert len(knees) == 4
    for knee in knees:
        height = points[make_region_mask(knee.moved, points)][:, 2]
        assert -0.38 < height.min() and height.max() < -0.1


def test_a_hand_turns_at_the_wrist(known):
    """It is the end of the arm, and its joint is where the arm goes on."""
    points, wrists = find(known, "man", "wrist")
    low, box = points.min(0), np.ptp(points, axis=0)
    for wrist in wrists:
        own, joint = points[make_region_mask(wrist.moved, points)], low + np.asarray(wrist.joint) * box
        assert not wrist.seated and abs(joint[0]) < abs(own[:, 0]).mean() < abs(own[:, 0]).max()
        assert np.dot(wrist.arm, own.mean(0) - joint) > 0


def test_its_edges_are_soft_and_the_rest_stays(known):
    points, (region,) = find(known, "cat", "muzzle")
    size = float(np.ptp(points, axis=0).max())
    bend = Bend(joint=region.joint, rest=region.rest, reach=2.0, depth=float(np.linalg.norm(region.arm)))
    inside, share, _ = grade_part(bend, points)
    assert np.linalg.norm(region.arm) > 0.04 and inside.mean() < 0.1
    assert 0.1 < (share > 0.95).mean() < 0.7 and (share < 0.5).mean() > 0.1
    out = points[inside][share > 0.95].mean(0) - points[inside].mean(0)
    assert out[0] > 0.01 * size  # its tip goes farthest


@pytest.mark.parametrize(
    ("name", "word"), [("cat", "elbow"), ("cat", "horn"), ("cat", "axe"), ("man", "tail"), ("cat", "head")]
)
def test_what_has_no_parent_or_no_place_is_not_found(known, name, word):
    assert find(known, name, word)[1] == ()


def test_of_a_ball_only_ends_are_found():
    points = make([((0, 0, 0), (0.3, 0.3, 0.3))], count=4000)
    words = ("nose", "chest", "knee", "shoulder", "forehead", "rim")
    assert [each.name for each in find_places(points, (), words, "ball", VIEWER)] == ["rim"]
    names = [each.name for each in find_places(points, (), words, "monkey head", VIEWER)]
    assert names == ["nose", "forehead", "rim"]


def test_a_figure_without_legs_has_its_belly_above_the_ground_and_no_hips(known):
    points, parts = known["man"]
    parts = tuple(part for part in parts if part.roles[0] != "leg")
    assert find_places(points, parts, ("hip",), "", VIEWER) == ()
    (belly,) = find_places(points, parts, ("belly",), "", VIEWER)
    height = points[make_region_mask(belly.moved, points)][:, 2] - points[:, 2].min()
    assert height.min() > 0.2 * np.ptp(points[:, 2])


def test_the_head_of_a_tool_has_no_face(known):
    points, parts = known["cat"]
    handle = parts[0].model_copy(update=dict(roles=("handle",)))
    assert find_places(points, (*parts, handle), ("muzzle", "forehead"), "hammer", VIEWER) == ()


def test_a_part_that_is_named_or_sticks_out_is_no_region(known):
    points, parts = known["cat"]
    assert (
        find_places(
            points, (parts[0].model_copy(update=dict(name="chin", origin="file")),), ("chin",), "", VIEWER
        )
        == ()
    )
    nose = parts[0].model_copy(update=dict(roles=("nose",)))
    assert find_places(points, (*parts, nose), ("muzzle",), "", VIEWER) == ()


def test_the_grammar_knows_all_words_for_places():
    lexicon = read_lexicon()
    assert set(read_places()) <= lexicon.parts.keys() | lexicon.unplaced


def test_a_figure_whose_arms_lie_on_it_has_them_at_its_sides():
    """They hang from the shoulder; a figure with arms of its own has no others."""
    slim = [shape for shape in turn_up() if not (len(shape) == 3 and abs(shape[1][0]) == 0.38)]
    points = make(slim)
    known = {"slim": (points, find_parts(points)), "man": (x := make(turn_up()), find_parts(x))}
    _, (left, right) = find(known, "slim", "flippers")
    assert [left.name, right.name] == ["left flipper", "right flipper"] and not left.seated
    assert left.arm[2] < -0.1 and left.side[0] < -0.3 < 0.3 < right.side[0]
    assert find(known, "man", "flippers")[1] == ()


def test_ears_that_do_not_stick_out_are_at_the_top_of_the_head():
    bald = [shape for shape in turn_up() if not (len(shape) == 3 and abs(shape[1][0]) == 0.13)]
    points = make(bald)
    _, ears = find({"bald": (points, find_parts(points))}, "bald", "ears")
    assert [each.name for each in ears] == ["left ear", "right ear"]


def test_the_crust_of_a_disc_is_two_flaps_at_its_edge():
    points = make([((0, 0, 0), (0.5, 0.5, 0.03))])
    left, right = find_places(points, (), ("crust",), "pizza", VIEWER)
    inside = make_region_mask(left.moved, points)
    assert (left.name, right.name) == ("left crust", "right crust")
    away = np.hypot(*points[inside, :2].T)
    assert points[inside, 0].max() < 0 and np.quantile(away, 0.1) > 0.3
    assert left.arm[0] < -0.03 and not left.seated  # it is lifted about its inner edge


def test_the_head_of_a_tall_statue_is_its_top_and_nods_about_its_lower_end():
    points = make([((0, 0, 0), (0.15, 0.12, 0.5))])
    (head,) = find_places(points, (), ("head",), "statue", VIEWER)
    assert points[make_region_mask(head.moved, points), 2].min() > 0.15 and head.arm[2] > 0.05
    assert find_places(make([((0, 0, 0), (0.5, 0.3, 0.3))]), (), ("head",), "statue", VIEWER) == ()


def test_a_tall_statue_has_folded_wings_at_its_sides_and_a_nose():
    """Its shape shows neither; they are where a figure has them."""
    points = make([((0, 0, 0), (0.2, 0.2, 0.5))])
    left, right = find_places(points, (), ("wings",), "falcon", VIEWER)
    assert left.side[0] < -0.3 < 0.3 < right.side[0] and left.arm[2] < -0.1
    (nose,) = find_places(points, (), ("nose",), "falcon", VIEWER)
    assert points[make_region_mask(nose.moved, points)][:, 2].min() > 0.1


def test_a_leg_of_which_only_the_foot_sticks_out_reaches_to_the_hip(known):
    points, parts = known["man"]
    feet = tuple(
        part.model_copy(update=dict(arm=(0.05, 0.0, -0.05))) if "leg" in part.roles[:1] else part
        for part in parts
    )
    found = find_places(points, feet, ("leg",), "", VIEWER)
    assert [each.name for each in found] == ["left leg", "right leg"]
    high = points[~make_region_mask(found[0].rest, points)][:, 2].max() - points[:, 2].min()
    assert high > 0.3 * np.ptp(points[:, 2]) and found[0].arm[2] < -0.1
    assert find(known, "man", "leg")[1] == ()
    stout = np.concatenate([points, make([((0, 0, -0.3), (0.2, 0.15, 0.3))])])  # a penguin has but feet
    assert find_places(stout, feet, ("leg",), "", VIEWER) == ()


def test_an_animal_whose_tail_lies_on_it_has_it_at_its_rear(known):
    points, parts = known["cat"]
    (tail,) = find_places(points, tuple(p for p in parts if "tail" not in p.roles), ("tail",), "", VIEWER)
    own = points[make_region_mask(tail.moved, points)]
    assert tail.side[0] < -0.5 and tail.arm[2] < 0 and abs(own[:, 1]).max() < 0.1


def test_a_jaw_turns_about_its_back(known):
    _, (jaw,) = find(known, "cat", "mouth")
    assert jaw.arm[0] > 0.03 and not jaw.seated


def test_the_cap_of_a_mushroom_is_what_is_broad_above_its_foot():
    points = make([((0, 0, 0), (0, 0, 0.4), 0.2), ((0, 0, 0.7), (0.5, 0.5, 0.25))])
    (cap,) = find_places(points, (), ("cap",), "mushroom", VIEWER)
    inside = make_region_mask(cap.moved, points)
    assert points[inside, 2].min() > 0.3 and inside[points[:, 2] > 0.6].all()
    assert cap.arm[2] > 0.2 and not cap.seated
    (stem,) = find_places(points, (), ("stem",), "mushroom", VIEWER)
    bends = make_region_mask(stem.moved, points)
    assert (
        bends[inside].mean() > 0.98 and not bends[points[:, 2] < 0].any()
    )  # it bears the cap, and its foot stays
    assert find_places(make([((0, 0, 0), (0.4, 0.4, 0.5))]), (), ("cap", "stem"), "egg", VIEWER) == ()


def test_a_part_whose_name_ends_with_a_number_is_no_region(known):
    """ "Both arms" were one of "left arm 2" and "right arm 2", and a region beside it."""
    points, parts = known["man"]
    body = [part for part in parts if not {"arm", "wing"} & {*part.roles}]
    named = [part.model_copy(update=dict(name=f"{part.roles[0]} wing 2")) for part in body[:1]]
    assert find_places(points, body, ["wing"], "thing", VIEWER)
    assert not find_places(points, [*named, *body[1:]], ["wing"], "thing", VIEWER)
