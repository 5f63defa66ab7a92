"""Parts under a sentence's own names: synonyms of the file's names, and adjectives that choose among several."""

import numpy as np
import pytest

from physagent_jax.forces.part import list_parts
from physagent_jax.scene.parts import named
from physagent_jax.scene.parts.aliases import find_aliases, list_wholes, read_groups
from physagent_jax.scene.parts.cells import fit_part
from tests.scene.test_part_roles import make

TOWARD = np.array([0.0, -1.0, 0.0])
# A bar with four bars that stand on it, taller and thicker to the right.
PLACES = {-0.45: (0.2, 0.03), -0.15: (0.3, 0.04), 0.15: (0.4, 0.05), 0.45: (0.5, 0.09)}
POINTS = make(
    [((-0.5, 0, 0), (0.5, 0, 0), 0.1), *(((x, 0, 0), (x, 0, h), r) for x, (h, r) in PLACES.items())], 4000
)


def make_parts(*names, roles=()):
    """The bars under some names, from the left; the first ones in the list are the shortest."""
    masks = [(abs(POINTS[:, 0] - x) < 0.1) & (POINTS[:, 2] > 0.11) for x in PLACES]
    told = dict(origin="file" if any(names) else "shape", roles=roles)
    return tuple(
        fit_part(POINTS, m, joined=True).model_copy(update=told | dict(name=n)) for n, m in zip(names, masks)
    )


def make_parts_of(points, name, mask):
    """The part that a file calls so."""
    (part,) = named.make_parts(points, [named.Group(name, mask, False)])
    return part


def find(parts, sentence, name="thing"):
    return {each.name: each.stands_for for each in find_aliases(POINTS, parts, sentence, name, TOWARD)}


@pytest.mark.parametrize(
    ("names", "sentence", "found"),
    [
        (
            ("windmill blades", "windmill paddle"),
            "the wind turns its big wheel",
            {"wheel": "windmill blades"},
        ),
        (("windmill blades", "windmill paddle"), "pull the tail vane", {"tail vane": "windmill paddle"}),
        (("hood", "roof"), "press the bonnet down", {"bonnet": "hood"}),
        (("foot", "toes"), "its sneaker taps", {"sneaker": "foot"}),
        (("pot", "leaves"), "shake the foliage", {"foliage": "leaves"}),
        (("seats", "body"), "press the seat", {"seat": "seats"}),
        (
            ("front left wheel", "front right wheel"),
            "spin the tyres",
            {"left front tyres": "front left wheel", "right front tyres": "front right wheel"},
        ),
        (
            ("back left wheel", "back right wheel"),
            "spin the rear wheels",
            {"rear wheels": "back right wheel"},
        ),
        (
            ("back wheel", "front wheel"),
            "the back tyre spins",
            {"back tyre": "back wheel"},
        ),
        (("body", "fork"), "the front fork bends", {"front fork": "fork"}),
        (("right arm", "head"), "raise the left arm", {}),
        (("hood", "roof"), "press the hood down", {}),
        (("rotor", "fan"), "turn the blade", {}),  # one is as likely as the other
        (("steering wheel", "hood"), "turn the tyres", {}),
        (("left arm", "head"), "it throws a ball and the ball falls", {}),
    ],
)
def test_a_word_is_the_part_that_the_file_calls_otherwise(names, sentence, found):
    got = find(make_parts(*names), sentence)
    assert {frozenset(k.split()): v for k, v in got.items()} == {
        frozenset(k.split()): v for k, v in found.items()
    }


def test_the_objects_own_name_is_no_part():
    assert find(make_parts("windmill blades", "tower"), "the fan turns", name="fan") == {}


def test_a_part_that_is_called_as_the_object_is_none_of_another_name():
    parts = make_parts("wind turbine 1", "wind turbine 1 blades")
    assert find(parts, "the rotor turns", name="wind-turbine") == {"rotor": "wind turbine 1 blades"}


@pytest.mark.parametrize(
    ("phrase", "index"),
    [
        ("tallest leaf", 3),
        ("lowest leaf", 0),
        ("smaller frond", 0),
        ("longest green branch", 3),
        ("thinnest twig", 0),
        ("biggest petal", 3),
    ],
)
def test_a_comparison_chooses_one_of_several(phrase, index):
    for parts in (
        make_parts(*[""] * 4, roles=("side",)),
        make_parts(*[f"{phrase.split()[-1]} {k}" for k in range(4)]),
    ):
        (alias,) = find_aliases(POINTS, parts, f"pull the {phrase} down", "plant", TOWARD)
        assert alias.name == phrase and alias.moved == parts[index].moved
        assert list_parts((*parts, alias)) == list_parts(parts)  # it is none of its own


@pytest.mark.parametrize(
    ("phrase", "index"),
    [("middle drawer", 1), ("central panel", 1), ("middlemost spike", 1), ("outermost peg", 2)],
)
def test_the_middle_one_of_several_is_found_by_its_place(phrase, index):
    noun = phrase.split()[-1]
    parts = make_parts(*[f"{noun} {k}" for k in range(3)])
    (alias,) = [each for each in find_aliases(POINTS, parts, f"pull the {phrase} out", "thing", TOWARD)]
    assert alias.name == phrase
    if index == 1:
        assert alias.moved == parts[1].moved
    assert phrase not in find(parts[:2], f"pull the {phrase} out")  # of two, none is the middle one
    assert f"middle {noun}" not in find(parts, f"press in the middle of the {noun}")


def test_a_plain_adjective_needs_parts_that_differ():
    one = make_parts("wheel 1")[0]
    alike = (one, one.model_copy(update=dict(name="wheel 2")))
    assert find(alike, "turn the big wheel") == {}
    assert find(make_parts("wheel 1", "x", "y", "wheel 2"), "turn the big wheel") == {"big wheel": "wheel 2"}


def test_one_of_several_is_the_longest_and_all_on_a_side_are_taken():
    limbs = make_parts(*[""] * 4, roles=("side",))
    for phrase in ("one of the leaves", "a leaf"):
        (alias,) = find_aliases(POINTS, limbs, f"bend {phrase} down", "plant", TOWARD)
        assert alias.name == phrase.split()[-1] and alias.moved == limbs[3].moved
    assert find(limbs, "bend the leaves down", "plant") == {}
    wheels = make_parts("front left wheel", "front right wheel", "rear left wheel", "rear right wheel")
    taken = find_aliases(POINTS, wheels, "spin the front wheels", "car", TOWARD)
    assert [each.name for each in taken] == ["front wheels"] * 2
    assert find(wheels, "spin the wheels", "car") == {}
    taken = find_aliases(POINTS, wheels, "spin the big rear wheels", "car", TOWARD)
    assert [each.name for each in taken] == ["rear wheels"] * 2
    assert find(wheels, "press the left front tyre", "car") == {"left front tyre": "front left wheel"}


def test_two_limbs_are_wings_before_a_rotor_is():
    """A rotor may be called a wing where nothing else may be."""
    rotor, (one, other) = make_parts("rotor"), make_parts("", "", roles=("arm",))
    assert find(rotor, "wobble the wings", "airplane") == {"wings": "rotor"}
    assert find((*rotor, one, other), "wobble the wings", "airplane") == {}


def test_the_tallest_tree_of_trees_is_one_of_them():
    trees = make_parts(*[""] * 4, roles=("spike",))
    (alias,) = find_aliases(POINTS, trees, "bend the tallest tree", "tall trees", TOWARD)
    assert alias.moved == trees[3].moved


def make_limb(role, side):
    part = make_parts("")[0]
    return part.model_copy(update=dict(roles=(role,), side=side))


def test_wings_before_each_other_are_left_and_right_as_it_flies():
    """It flies to the viewer's right: its left wing is the far one."""
    plane = (make_limb("wing", (0, 1, 0)), make_limb("wing", (0, -1, 0)), make_limb("nose", (1, 0, 0)))
    plane += (make_limb("tail", (-1, 0, 0)),)
    for word, index in (("left", 0), ("right", 1)):
        (alias,) = find_aliases(POINTS, plane, f"bend the {word} wing up", "plane", TOWARD)
        assert (alias.name, alias.side) == (f"{word} wing", plane[index].side)
    seen = (make_limb("wing", (-1, 0, 0)), make_limb("wing", (1, 0, 0)), make_limb("nose", (0, -1, 0)))
    assert find_aliases(POINTS, seen, "bend the left wing up", "plane", TOWARD) == ()  # the viewer's own left


def test_the_flat_pair_of_what_has_a_trunk_is_its_ears():
    limbs = (make_limb("wing", (1, 0, 0)), make_limb("wing", (-1, 0, 0)), make_limb("nose", (0, -1, 0)))
    assert [each.name for each in find_aliases(POINTS, limbs, "flap its ears", "elephant", TOWARD)] == [
        "ears"
    ] * 2
    assert find_aliases(POINTS, limbs[:2], "flap its ears", "bird", TOWARD) == ()


def test_words_that_mean_more_are_a_files_alone():
    """ "Its body length", "in the frame": no part is meant, but a file may well call one so."""
    assert find(make_parts("torso", "chassis"), "it moves by a body length in the frame") == {}
    assert find(make_parts("body", "head"), "twist its torso") == {"torso": "body"}
    assert not {"body", "frame", "top", "side", "light"} & {*read_groups("same"), *read_groups("near")}


@pytest.mark.parametrize(
    ("half", "axle"), [((0.3, 0.05, 0.3), (0, 1, 0)), ((0.3, 0.3, 0.3), None), ((0.5, 0.05, 0.2), None)]
)
def test_a_wheel_turns_about_its_thin_axis(half, axle):
    points = make([((0, 0, 0), half), ((0, 0, -0.8), (0.5, 0.5, 0.3))], 6000)
    part = fit_part(points, points[:, 2] > -0.45, joined=False)
    assert part.axle == (None if axle is None else pytest.approx(axle, abs=0.05))
    assert axle is None or part.seated


def test_a_thick_wheel_turns_about_the_line_across_the_vehicle():
    """Matter in a vehicle belongs to its nearest surface; no wheel is up on the roof, nor under what is square."""
    wheels = [((x, y, 0.25), (0.25, 0.25, 0.25)) for x in (-0.7, 0.7) for y in (-0.25, 0.25)]
    car = make([((0, 0, 0.8), (1.0, 0.5, 0.3)), *wheels], 8000)
    front = (car[:, 2] < 0.45) & (car[:, 0] > 0.4) & (car[:, 1] < 0)
    wheel = make_parts_of(car, "front left wheel", front)
    assert np.abs(wheel.axle) == pytest.approx((0, 1, 0), abs=0.05) and wheel.seated
    assert make_parts_of(car, "front left foot", front).axle is None
    for points in (car * (1, 1, -1), car * (0.5, 1, 1)):
        axle = make_parts_of(points, "front left wheel", front).axle
        assert axle is None or abs(axle[1]) < 0.5


def test_blades_turn_about_their_hub_though_they_fill_no_disc():
    rods = [
        ((0, 0, 0), (0.9 * np.sin(a), 0, 0.9 * np.cos(a)), 0.06) for a in np.radians((10.0, 130.0, 250.0))
    ]
    points = make([*rods, ((0, 0.3, 0), (0, 0.3, -2.0), 0.1)], 6000)
    axle, other = (
        fit_part(points, points[:, 1] < 0.15, joined=False, blades=blades).axle for blades in (True, False)
    )
    assert np.abs(axle) == pytest.approx((0, 1, 0), abs=0.05) and other is None
    assert make_parts_of(points, "turbine blades", points[:, 1] < 0.15).axle == axle


def test_what_is_called_a_wheel_may_be_thick():
    points = make([((0, -0.12, 0), (0, 0.12, 0), 0.2), ((0, 0, -0.8), (0.5, 0.5, 0.3))], 6000)
    thick = [
        fit_part(points, points[:, 2] > -0.45, joined=False, wheel=wheel).axle for wheel in (True, False)
    ]
    assert thick == [None, None]  # longer than it is broad: a roller
    points = points[abs(points[:, 1]) < 0.167]
    axle, other = (fit_part(points, points[:, 2] > -0.45, joined=False, wheel=w).axle for w in (True, False))
    assert axle == pytest.approx((0, 1, 0), abs=0.1) and other is None


def test_a_part_on_top_is_no_lower_one():
    """The rim on top is not the bottom rim, and a rotor below is not the one on top."""
    rim, rotor = make_parts("rim", "tail wing")
    rim, rotor = (
        p.model_copy(update=dict(side=s)) for p, s in ((rim, (0.0, 0.0, 1.0)), (rotor, (1.0, 0.0, 0.0)))
    )
    assert find((rim,), "dent the bottom rim") == {} and find((rim,), "dent the top rim") == {
        "top rim": "rim"
    }
    assert find((rotor,), "the rotor on top spins") == {} and find((rotor,), "the rotor spins")


@pytest.mark.parametrize(
    ("names", "sentence", "found"),
    [
        (("top case", "bottom case 1"), "the upper half comes off", {"upper half": "top case"}),
        (("left shell", "right shell"), "the light right half falls off", {"right half": "right shell"}),
        (("top case", "bottom case"), "squash it to half its height", {}),
        (("case", "lid"), "the top half melts", {}),
    ],
)
def test_a_half_is_one_of_two_cases(names, sentence, found):
    assert find(make_parts(*names), sentence) == found


@pytest.mark.parametrize(
    ("names", "sentence", "name", "found"),
    [
        (("bezier curve", "cube"), "the cable swings to the left", "controller", {"cable": "bezier curve"}),
        (("hot dog", "sausage", "sauce"), "squeeze the bun", "hot-dog", {"bun": "hot dog"}),
        (("cake", "cherry"), "the wrapper comes off", "cake", {"wrapper": "cake"}),
        (("cake",), "the wrapper comes off", "cake", {}),
        (("bread", "cheese"), "the bun comes off", "sandwich", {}),
    ],
)
def test_the_part_that_bears_the_own_name_is_what_bears_the_others(names, sentence, name, found):
    assert find(make_parts(*names), sentence, name) == found


def test_a_taxi_is_a_cab_and_a_truck_has_one():
    assert "cab" in list_wholes("yellow-taxi", "vehicle") and "cushion" in list_wholes("thing", "pillow")
    assert not list_wholes("truck", "vehicle")
