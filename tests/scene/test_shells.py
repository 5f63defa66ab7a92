"""Shells of a mesh: found in a file, and taken for what a word means."""

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.mesh_files import read_shells
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.parts import Frame, find_shells, guess_parts
from physagent_jax.scene.parts.cells import fit_part
from physagent_jax.scene.parts.guesses import read_guesses
from physagent_jax.scene.parts.looks import Looks
from physagent_jax.scene.parts.shells import Shells

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))
WHEELS = [(x, y, 0.15) for x in (-0.5, 0.5) for y in (-0.35, 0.35)]
# A car that looks along -x: a body, a cab, a sign on its roof and four wheels.
CAR = [
    ((1.8, 0.6, 0.3), (0, 0, 0.35)),
    ((0.8, 0.55, 0.3), (0.2, 0, 0.65)),
    ((0.15, 0.2, 0.1), (0.2, 0, 0.85)),
    *(((0.3, 0.1, 0.3), place) for place in WHEELS),
]


def make_box(size, middle):
    box = trimesh.creation.box(size)
    box.apply_translation(middle)
    return box


def make_car(count=7000):
    boxes = [make_box(*each) for each in CAR]
    boxes[3:] = [
        trimesh.creation.cylinder(
            0.15, 0.1, transform=trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0))
        )
        for _ in WHEELS
    ]
    for wheel, place in zip(boxes[3:], WHEELS):
        wheel.apply_translation(place)
    points = [box.sample(max(200, int(count * box.area / 5)), seed=0) for box in boxes]
    surfaces = [MeshPart(np.asarray(box.vertices), np.asarray(box.faces)) for box in boxes]
    return np.concatenate(points), find_shells(np.concatenate(points), surfaces)


@pytest.fixture(scope="module")
def car():
    return make_car()


def write(tmp_path, mesh):
    path = tmp_path / "thing.glb"
    path.write_bytes(trimesh.Scene([mesh]).export(file_type="glb"))
    return path


def test_surfaces_that_touch_nowhere_are_shells_of_their_own(tmp_path):
    both = trimesh.util.concatenate([make_box((1, 1, 1), (0, 0, 0)), make_box((1, 1, 1), (3, 0, 0))])
    assert sorted(len(each.faces) for each in read_shells(write(tmp_path, both))) == [12, 12]
    assert not read_shells(write(tmp_path, make_box((1, 1, 1), (0, 0, 0))))


def test_a_shell_that_meets_another_one_along_edges_alone_is_told_from_it(tmp_path):
    both = trimesh.util.concatenate([make_box((1, 1, 1), (0, 0, 0)), make_box((1, 0.2, 1), (0, 0.6, 0))])
    both.merge_vertices()  # a door that fills its frame shares its corners
    corners = [each.vertices[each.faces].reshape(-1, 3) for each in read_shells(write(tmp_path, both))]
    ranges = {(round(float(each[:, 1].min()), 1), round(float(each[:, 1].max()), 1)) for each in corners}
    assert ranges >= {(-0.5, 0.5), (0.5, 0.7)} and (-0.5, 0.7) not in ranges


def test_many_crumbs_are_no_shells(tmp_path):
    crumbs = trimesh.util.concatenate([make_box((1, 1, 1), (3 * k, 0, 0)) for k in range(520)])
    assert not read_shells(write(tmp_path, crumbs))


def test_a_part_that_is_about_a_shell_has_its_border(car):
    points, shells = car
    sign = shells.labels == 2
    rough = sign | (points[:, 2] > 0.79) & (np.abs(points[:, :2] - (0.2, 0)) < 0.1).all(1)
    part = fit_part(points, rough, joined=True).model_copy(update=dict(roles=("top",)))
    assert shells.snap(rough).tolist() == sign.tolist()
    assert (
        abs(shells.snap_part(part).share - sign.mean()) < 1e-3 and part.share > shells.snap_part(part).share
    )
    assert shells.snap(points[:, 1] > 0) is None and find_shells(points).snap(sign) is None


def test_a_blade_with_a_socket_bends_at_its_neck_and_a_head_on_a_handle_is_all_of_its_shell():
    """It was the shell that turned, about the neck: its socket came off the handle."""
    shaft, plate = make_box((1.0, 0.06, 0.06), (0, 0, 0)), make_box((0.25, 0.3, 0.04), (0.62, 0, 0))
    points = np.concatenate([each.sample(2500, seed=0) for each in (shaft, plate)])
    neck = dict(roles=("head", "blade"), joint=(0.8, 0.5, 0.5))
    blade = fit_part(points, points[:, 0] > 0.5, joined=True).model_copy(update=neck)
    for border, kept in ((0.2, True), (0.49, False)):
        shells = Shells(points, (points[:, 0] > border).astype(int))
        assert (shells.snap_part(blade) == blade) is kept


def test_of_a_pair_of_antlers_the_tips_tell_all_that_sticks_out():
    """Not what of them is sunk in the head."""
    boxes = [
        make_box((1, 1, 1), (0, 0, 0)),
        *(make_box((0.12, 0.12, 1.0), (x, 0, 0.6)) for x in (-0.3, 0.3)),
    ]
    chance, counts = np.random.default_rng(0), (14000, 300, 300)
    points = [chance.uniform(*box.bounds, (count, 3)) for box, count in zip(boxes, counts)]
    surfaces = [MeshPart(np.asarray(box.vertices), np.asarray(box.faces)) for box in boxes]
    points = np.concatenate(points)
    shells = find_shells(points, surfaces)
    tips = [
        fit_part(points, (points[:, 2] > 0.95) & (sign * points[:, 0] > 0), joined=True).model_copy(
            update=dict(roles=("horn",))
        )
        for sign in (-1, 1)
    ]
    for part in shells.snap_parts(tips):
        own = ~make_region_mask(part.rest, points)
        assert part.roles == ("horn",) and points[own, 2].min() == pytest.approx(0.5, abs=0.12)
        assert part.arm[2] > 0.25 and part.neck[0] > 0
    lone = shells.snap_parts(tips[:1])[0]
    assert lone.moved == tips[0].moved  # what has no like beside it may be a horn on its head


def test_a_border_across_small_shells_is_that_of_no_part(car):
    points, shells = car
    assert shells.are_cut((points[:, 2] < 0.15) & (points[:, 0] < 0))
    assert not shells.are_cut(shells.labels == 3)


def test_what_hangs_on_the_rest_by_a_shell_is_looked_at_with_it(car):
    points, shells = car
    wanted = np.isin(shells.labels, (1, 2))  # the cab with its sign
    assert any((mask == wanted).all() for mask in shells.candidates)


@pytest.mark.parametrize("words", [["sign"], ["siren"]])
def test_the_shell_on_top_is_taken_for_a_sign_as_nothing_else_looks_like_one(car, words):
    points, shells = car
    (part,) = guess_parts(points, (), words, VIEWER, shells)
    assert part.name == words[0] and not part.unsure and abs(part.share - (shells.labels == 2).mean()) < 1e-3


def test_wheels_are_all_shells_alike_and_are_named_by_their_sides(car):
    points, shells = car
    wheels = guess_parts(points, (), ["wheels"], VIEWER, shells)
    assert len(wheels) == 4 and len({part.name for part in wheels}) == 4
    assert all(part.axle is not None and abs(part.axle[1]) > 0.9 for part in wheels)
    (one,) = guess_parts(points, (), ["wheel"], VIEWER, shells)  # the one that is seen
    assert one.side[1] < 0


def test_a_word_of_the_object_s_own_name_is_no_part(car):
    points, shells = car
    assert not guess_parts(points, (), ["sign"], VIEWER, shells, "road sign")


def test_words_that_need_shells_take_no_limb():
    points, shells = make_car(2000)
    limb = fit_part(points, shells.labels == 2, joined=True).model_copy(update=dict(roles=("top",)))
    assert guess_parts(points, (limb,), ["sign"], VIEWER) == ()
    assert read_guesses()["tail"]["limb"] and "limb" not in read_guesses()["sign"]


def test_measures_tell_a_plate_that_lies_from_a_rod_that_stands():
    chance = np.random.default_rng(0)
    plate = chance.uniform((-1, -1, 0), (1, 1, 0.1), (800, 3))
    rod = chance.uniform((-0.05, -0.05, 0.1), (0.05, 0.05, 1), (400, 3))
    points, own = np.concatenate([plate, rod]), np.arange(1200) >= 800
    looks = Looks(points, np.ones(1200, bool), None, VIEWER.toward)
    lying, standing = looks.measure(~own), looks.measure(own)
    assert lying["level"] > 0.8 > 0.2 > standing["level"] and standing["slim"] > 0.8 > 0.3 > lying["slim"]
    assert (
        lying["grounded"] > 0.9 and standing["raised"] > 0.1 and standing["open"] > 0.9 > lying["hung"] - 0.2
    )
    assert "ahead" not in standing


def test_a_shell_that_has_a_name_is_nothing_else(car):
    points, shells = car
    named = fit_part(points, shells.labels == 2, joined=False).model_copy(
        update=dict(name="lamp", origin="file")
    )
    assert all(
        abs(part.share - named.share) > 0.005
        for part in guess_parts(points, (named,), ["sign"], VIEWER, shells)
    )


def test_parts_of_what_has_one_surface_stay_as_they_are(car):
    """The rest of a part may have no particle at all where there are sixty."""
    points, _ = car
    part = fit_part(points, points[:, 2] > 0.5, joined=True)
    nowhere = part.model_copy(
        update=dict(rest=part.rest.model_copy(update=dict(inside=((9.0, 9.0, 9.0),) * 3)))
    )
    assert Shells(points, np.zeros(len(points), int)).snap_parts([nowhere]) == [nowhere]


def make_shells(*boxes):
    """Points of boxes, each a shell of its own."""
    points = [make_box(*each).sample(600, seed=0) for each in boxes]
    return np.concatenate(points), Shells(np.concatenate(points), np.repeat(range(len(boxes)), 600))


FRUIT = [
    ((1, 1, 1), (0, 0, 0)),
    ((0.12, 0.12, 0.6), (0, 0, 0.8)),
    *(((0.5, 0.3, 0.04), (x, 0, 0.6)) for x in (-0.4, 0.4)),
]
PURPLE, BROWN, GREEN, GREY = (0.5, 0.4, 0.6), (0.5, 0.4, 0.3), (0.5, 0.75, 0.65), (0.5, 0.5, 0.5)


@pytest.mark.parametrize("fruit", [PURPLE, (0.8, 0.2, 0.2)])
def test_leaves_are_the_shells_that_are_green(fruit):
    points, shells = make_shells(*FRUIT)
    colours = np.repeat([fruit, BROWN, GREEN, GREEN], 600, axis=0)
    words = "the leaves on top flap".split()
    found = guess_parts(points, (), words, VIEWER, shells, "fruit", " ".join(words), colours)
    assert sorted(part.name for part in found) == ["left leaf", "right leaf"]
    (stem,) = guess_parts(points, (), ["stem"], VIEWER, shells, "fruit", "", colours)
    assert abs(stem.side[0]) < 0.1


def test_a_hue_that_all_or_none_of_the_object_has_tells_nothing():
    points, shells = make_shells(*FRUIT)
    whole, mask = np.ones(len(points), bool), shells.labels == 2
    grey, green, mixed = (
        Looks(points, whole, None, VIEWER.toward, np.repeat(each, 600, axis=0)).measure(mask)
        for each in ([GREY] * 4, [GREEN] * 4, [PURPLE, BROWN, GREEN, GREEN])
    )
    assert "green" not in grey and "green" not in green and mixed["green"] == 1.0 and mixed["brown"] == 0.0


@pytest.mark.parametrize("name", ["ferris wheel", "waterwheel"])
@pytest.mark.parametrize("rest", ["its legs stay put", "the base doesn't move", "the stand is held in place"])
def test_what_turns_on_a_stand_that_stays_is_all_but_the_stand(name, rest):
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0))
    rims = [trimesh.creation.annulus(0.42, 0.5, 0.05, transform=turn) for _ in range(2)]
    for rim, y in zip(rims, (-0.1, 0.1)):
        rim.apply_translation((0, y, 0.7))
    spokes = [make_box((0.9, 0.1, 0.05), (0, 0, 0.7)), make_box((0.05, 0.1, 0.9), (0, 0, 0.7))]
    legs = [make_box((0.06, 0.04, 0.75), (0, y, 0.37)) for y in (-0.2, 0.2)]
    points = np.concatenate([each.sample(600, seed=0) for each in (*rims, *spokes, *legs)])
    shells = Shells(points, np.repeat(range(6), 600))
    sentence = f"the wheel turns while {rest}"
    (wheel,) = guess_parts(points, (), ["wheel"], VIEWER, shells, name, sentence)
    assert wheel.name == "wheel" and wheel.axle is not None and abs(wheel.axle[1]) > 0.99
    assert wheel.share == pytest.approx(4 / 6, abs=0.02)
    assert not guess_parts(points, (), ["wheel"], VIEWER, shells, name, "the wheel turns")
