"""Parts that are taken for want of surer ones: figures on a base, branches of numbered pieces, the likeliest limb."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from physagent_jax.forces.part import Part
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import (
    Frame,
    branch_numbered,
    find_places,
    guess_parts,
    join_chains,
)
from physagent_jax.scene.parts.branches import find_branches, is_numbered
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.figures import add_figure, is_figure_on_base
from physagent_jax.scene.parts.guesses import read_guesses
from physagent_jax.scene.parts.heading import find_overhang
from physagent_jax.scene.parts.looks import Looks
from physagent_jax.scene.parts.roles import Roles
from tests.scene.test_part_roles import make

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))
# A long body with its head raised at -x, a slim tail at +x and a small spike on its back.
WORM = [
    ((-0.6, 0, 0.1), (0.6, 0, 0.1), 0.12),
    ((-0.6, 0, 0.1), (-0.7, 0, 0.7), 0.1),
    ((-0.7, 0, 0.7), (-1.0, 0, 0.7), 0.1),
]
TAIL, SPIKE = ((0.6, 0, 0.1), (1.1, 0, 0.2), 0.04), ((0.0, 0, 0.1), (0.0, 0, 0.4), 0.03)
WINGED = [((0, 0, 0), (0.1, 0.1, 0.4)), *(((0.25 * k, 0.1, 0.1), (0.2, 0.03, 0.3)) for k in (1, -1))]


def list_worm():
    points = make([*WORM, TAIL, SPIKE], count=6000)
    masks = [points[:, 0] > 0.74, (points[:, 2] > 0.24) & (np.abs(points[:, 0]) < 0.1)]
    return points, [
        fit_part(points, mask, joined=True).model_copy(update=dict(roles=("side",))) for mask in masks
    ]


def test_the_limb_that_looks_most_like_a_tail_is_taken_for_it_and_is_unsure():
    points, limbs = list_worm()
    (tail,) = guess_parts(points, limbs, ["tail"], VIEWER)
    assert (
        tail.name == "tail" and tail.roles == ("tail",) and tail.unsure and tail.stands_for == "side (part 1)"
    )
    (horn,) = guess_parts(points, limbs, ["horns"], VIEWER)
    assert horn.stands_for == "side (part 2)"


def test_what_is_known_is_not_guessed():
    points, limbs = list_worm()
    known = [each.model_copy(update=dict(roles=("tail",))) for each in limbs]
    assert not guess_parts(points, known, ["tail"], VIEWER)
    assert not guess_parts(points, [limbs[1]], ["wings", "axe"], VIEWER)  # none looks so


def test_a_claw_is_the_arm_that_is_known():
    points, limbs = list_worm()
    arms = [each.model_copy(update=dict(roles=("arm",), unsure=False)) for each in limbs]
    assert not guess_parts(points, arms, ["claw"], VIEWER)


def test_the_other_one_of_a_pair_is_the_image_of_the_one_that_is_found():
    points = make(WINGED, count=6000)
    limb = fit_part(points, points[:, 0] > 0.12, joined=True).model_copy(update=dict(roles=("side",)))
    left, right = sorted(guess_parts(points, [limb], ["wings"], VIEWER), key=lambda part: part.name)
    assert (left.name, right.name) == ("left wing", "right wing")
    mask = make_region_mask(left.moved, points)
    assert (points[mask, 0] < 0).mean() > 0.95 and mask.sum() > 0.4 * (points[:, 0] < -0.12).sum()
    assert np.allclose(left.arm, np.array(right.arm) * (-1, 1, 1), atol=0.15)


def test_every_row_of_guesses_has_measures_that_are_known():
    points = make(WINGED, count=600)
    colours = np.repeat([(0.2, 0.8, 0.2), (0.5, 0.4, 0.3)], (200, len(points) - 200), axis=0)
    whole = np.ones(len(points), bool)
    known = set(Looks(points, whole, VIEWER.toward, VIEWER.toward, colours).measure(points[:, 0] > 0.12))
    assert all(
        set(row) <= known | {"words", "role", "pair", "many", "limb", "spins", "rolls"} and set(row) & known
        for row in read_guesses().values()
    )


def test_what_juts_out_high_up_over_nothing_tells_the_front():
    front = find_overhang(make(WORM, count=6000))
    assert front is not None and np.allclose(front, (-1, 0, 0), atol=0.1)
    assert find_overhang(make([((0, 0, 0), (0.3, 0.3, 0.5))], count=3000)) is None  # all around
    assert find_overhang(make(WORM[:1], count=3000)) is None  # flat


def make_pieces():
    """Points of a box with an arm and its grip on top, and the box's lid, with the piece of each."""
    pieces = [
        ((0, 0, 0), (0.3, 0.3, 0.3)),
        ((0, 0, 0.35), (0.2, 0.2, 0.04)),
        ((0.25, 0, 0.44), (0.3, 0.04, 0.04)),
        ((0.5, 0, 0.6), (0.04, 0.04, 0.12)),
    ]
    clouds = [make([piece], count=count) for piece, count in zip(pieces, (4000, 300, 200, 80))]
    return np.concatenate(clouds), np.repeat(range(4), [len(each) for each in clouds])


def test_a_crank_is_all_that_hangs_on_the_rest_by_its_arm():
    points, labels = make_pieces()
    found = [frozenset(labels[mask]) for mask in find_branches(points, labels)]
    assert {frozenset((3,)), frozenset((2, 3))} <= set(found)


def test_numbered_pieces_are_branches_that_turn_about_their_inner_end():
    points, labels = make_pieces()
    pieces = [
        fit_part(points, labels == k, joined=False).model_copy(update=dict(name=f"mill {k}", origin="file"))
        for k in range(4)
    ]
    parts = branch_numbered(points, pieces, "coffee mill")
    assert all(not part.name and part.roles for part in parts)
    (crank,) = guess_parts(points, parts, ["crank"], VIEWER)
    assert crank.axle == (0.0, 0.0, 1.0) and crank.arm[0] > 0.3 and crank.joint[0] < 0.6
    assert branch_numbered(points, pieces[:1], "coffee mill") == (pieces[0],)


@pytest.mark.parametrize(("name", "numbered"), [("mill 3", True), ("wheel 3", False), ("mill", False)])
def test_only_the_objects_own_name_with_a_number_says_nothing(name, numbered):
    part = Part.model_construct(name=name)
    assert is_numbered(part, ("coffee", "mill")) == numbered


def test_a_figure_on_its_base_has_parts_of_its_own():
    """In the frame of the whole; a lid on a figure is its head."""
    points = make(
        [((0, 0, 0), (0.45, 0.45, 0.6)), ((0, 0, 1.0), (0.15, 0.15, 0.5)), ((0, 0, 1.5), (0.1, 0.1, 0.1))]
    )
    above = points[:, 2] > 0.62
    figure = fit_part(points, above, joined=True).model_copy(
        update=dict(roles=("top", "head"), arm=(0, 0, 0.4))
    )

    def find(own):
        assert own[:, 2].min() > 0.55
        return (fit_part(own, own[:, 2] > 1.38, joined=True).model_copy(update=dict(roles=("lid",))),)

    assert is_figure_on_base(figure)
    plain, head = add_figure(points, [figure], find)
    mask = make_region_mask(head.moved, points)
    assert plain.roles == ("top",) and head.roles == ("head",)
    assert points[mask, 2].min() > 1.3 and mask.sum() > 0.6 * (points[:, 2] > 1.38).sum()
    assert abs(head.joint[2] - (1.4 + 0.6) / 2.2) < 0.05 and head.share < 0.1
    assert add_figure(points, [head], find) == (head,)


def test_sections_with_names_make_a_limb():
    sections = [
        ((0, 0, 0), (0.3, 0.2, 0.3)),
        ((0.42, 0, 0.1), (0.13, 0.06, 0.06)),
        ((0.66, 0, 0.1), (0.12, 0.06, 0.06)),
    ]
    clouds = [make([piece], count=count) for piece, count in zip(sections, (3000, 200, 200))]
    points, labels = np.concatenate(clouds), np.repeat(range(3), [len(each) for each in clouds])
    names = ("body", "upper right arm", "right hand")
    parts = [
        fit_part(points, labels == k, joined=False).model_copy(update=dict(name=name, origin="file"))
        for k, name in enumerate(names)
    ]
    *same, arm = join_chains(points, parts)
    assert same == parts and arm.name == "right arm" and not arm.seated and arm.arm[0] > 0.35
    assert make_region_mask(arm.moved, points).sum() == (labels > 0).sum()
    assert (
        join_chains(points, [*parts[:2], parts[2].model_copy(update=dict(name="right arm"))])[-1].name
        == "right arm"
    )
    assert join_chains(points, parts[:2]) == tuple(parts[:2])


def test_the_upper_part_of_what_has_a_front_is_its_head_and_of_a_statue_a_slab():
    points = make([((0, 0, 0), (0.2, 0.2, 0.5)), ((0, 0, 0.7), (0.1, 0.1, 0.4))], count=4000)
    upper = fit_part(points, points[:, 2] > 0.5, joined=True)
    upper = upper.model_copy(update=dict(roles=("top", "head"), arm=(0, 0, 0.4)))
    assert not find_places(
        points, [upper.model_copy(update=dict(front=(1, 0, 0)))], ["head"], "thing", VIEWER
    )
    (head,) = find_places(points, [upper], ["head"], "thing", VIEWER)
    assert head.origin == "place"


@pytest.mark.parametrize(
    ("length", "covered", "stands"), [(0.1, 0.3, False), (0.1, 0.8, True), (0.3, 0.3, True)]
)
def test_ragged_edges_below_a_pedestal_are_no_legs(length, covered, stands):
    """Legs are long, or most of what is on the ground is theirs."""
    roles: Any = Roles.__new__(Roles)
    roles.places = np.array([(0.0, 0.0, 0.01)] * 100 + [(0.0, 0.0, 1.0)] * 50)
    roles.low, roles.size, roles.height = np.zeros(3), 1.0, 1.0
    edge = SimpleNamespace(nodes=np.arange(round(100 * covered)), length=length)
    roles.limbs = [edge]
    assert roles.bear([0]) is stands


def test_what_sits_on_top_is_told_by_the_sentence_though_its_noun_is_not_known():
    points, limbs = list_worm()
    told = dict(shells=SimpleNamespace(candidates=[make_region_mask(limbs[1].moved, points)], are_cut=bool))
    words = "the little gizmo on the roof wobbles".split()
    (part,) = guess_parts(points, limbs, words, VIEWER, sentence=" ".join(words), **told)
    assert part.name == "gizmo" and part.unsure
    assert not guess_parts(points, limbs, words, VIEWER, sentence="the gizmo wobbles", **told)


def test_shells_that_are_most_of_the_object_are_no_part_of_it():
    points, limbs = list_worm()
    bulk = points[:, 0] < 0.7
    told = dict(shells=SimpleNamespace(candidates=[bulk], are_cut=bool))
    assert bulk.mean() > 0.5 and not guess_parts(points, limbs, ["head"], VIEWER, **told)


@pytest.mark.parametrize("rivals", [False, True])
def test_a_surface_that_looks_like_nothing_else_is_certain(rivals):
    """A bottle's cap is a surface of its own; of two that lie side by side on top either may be meant."""
    points = np.random.default_rng(0).uniform((-0.1, -0.1, 0.0), (0.1, 0.1, 1.0), (4000, 3))
    top, label = points[:, 2] > 0.94, np.abs(points[:, 2] - 0.3) < 0.1
    shells = [top & (points[:, 0] < 0), top & (points[:, 0] > 0)] if rivals else [top, label]
    told = dict(shells=SimpleNamespace(candidates=shells, are_cut=bool))
    (part,) = guess_parts(points, [], ["cap"], VIEWER, **told)
    assert part.unsure is rivals and part.joint[2] > 0.8


@pytest.mark.parametrize("alone", [False, True])
def test_a_slim_cork_is_certain_where_no_other_piece_is_like_one(alone):
    points = np.random.default_rng(0).uniform((-0.1, -0.1, 0.0), (0.1, 0.1, 1.0), (4000, 3))
    cork = (points[:, 2] > 0.75) & (np.hypot(points[:, 0], points[:, 1]) < 0.06)
    foot, collar = points[:, 2] < 0.1, np.abs(points[:, 2] - 0.7) < 0.05
    told = dict(shells=SimpleNamespace(candidates=[cork, foot if alone else collar], are_cut=bool))
    (part,) = guess_parts(points, [], ["cork"], VIEWER, **told)
    assert part.unsure is not alone and part.joint[2] > 0.7


def test_a_hat_may_be_more_than_half_of_a_head_that_the_file_names():
    points = np.random.default_rng(0).uniform((-0.1, -0.1, 0.0), (0.1, 0.1, 1.0), (4000, 3))
    hat, badge = points[:, 2] > 0.84, np.abs(points[:, 2] - 0.9) < 0.02
    head = fit_part(points, points[:, 2] > 0.7, joined=False).model_copy(
        update=dict(name="figure", origin="file")
    )
    shells = [hat, badge & (points[:, 1] < -0.08), points[:, 2] < 0.3]
    told = dict(shells=SimpleNamespace(candidates=shells, are_cut=bool))
    (part,) = guess_parts(points, [head], ["hat"], VIEWER, **told)
    assert part.share == pytest.approx(hat.mean(), abs=0.01) and not part.unsure


def test_twin_pieces_that_nothing_else_is_like_are_certain():
    """Of two handles alike "one of the handles" was unsure."""
    points = np.random.default_rng(0).uniform((-1.0, -0.2, 0.0), (1.0, 0.2, 0.4), (20000, 3))
    slim = (np.abs(points[:, 2] - 0.3) < 0.05) & (np.abs(points[:, 1]) < 0.05)
    left, right = (slim & (points[:, 0] * s > 0.4) for s in (-1, 1))
    shells = [left, right, np.abs(points[:, 0]) < 0.2]
    told = dict(shells=SimpleNamespace(candidates=shells, are_cut=bool, labels=left + 2 * right))
    for word, count in (("handles", 2), ("handle", 1)):
        found = guess_parts(points, [], [word], VIEWER, **told)
        assert len(found) == count and not any(each.unsure for each in found)
