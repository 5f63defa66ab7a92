import math

import pytest

from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.priors import (
    PRIORS,
    UNKNOWN,
    choose_anchor,
    choose_material,
    find_hard_kind,
    guess_kind,
)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("ficus_02.ply", "plant"),
        ("TelephonePlant", "plant"),
        ("a potted plant", "plant"),
        ("plant in a pot", "plant"),
        ("the guitar", "instrument"),
        ("spot", "animal"),
        ("toy cows", "animal"),
        ("toy robot", "robot"),
        ("robot.ply", "robot"),
        ("a loaf of rye", "food"),
        ("jelly", "jelly"),
        ("raspberry pudding", "jelly"),
        ("basketball", "ball"),
        ("Cushions", "pillow"),
        ("dining chair", "furniture"),
        ("teddy", "toy"),
        ("a pile of sand", "sand"),
        ("lumps of clay", "clay"),
        ("a slice of bread", "food"),
        ("clay pot", "vessel"),
        ("water bottle", "vessel"),
        ("snowman", "snow"),
        ("trash can", "metal"),
        ("splash of water", "liquid"),
        ("bottle-oil.gltf", "vessel"),
        ("oil_bottle", "vessel"),
        ("glass-wine", "vessel"),
        ("bowl_soup", "vessel"),
        ("bucket-sand", "metal"),
        ("plate soup", UNKNOWN),
        ("pizza-box", UNKNOWN),
        ("bread basket", UNKNOWN),
        ("oil_barrel", "tool"),
        ("cake-slicer", "tool"),
        ("hot-dog", "food"),
        ("clay lump", "clay"),
        ("coffee_grinder.glb", UNKNOWN),
        ("snow plough", UNKNOWN),
        ("a sand pile", "sand"),
        ("milk_sh0_lowpoly.ply", "liquid"),
        ("carpet", UNKNOWN),  # no car
        ("point_cloud.ply", UNKNOWN),
        ("", UNKNOWN),
    ],
)
def test_names_tell_kinds(name, kind):
    assert guess_kind(name) == kind


@pytest.mark.parametrize(
    ("name", "sentence", "kind"),
    [
        ("massa", "The statue is suddenly hit from the left", "statue"),
        ("scan 01", "a man pushes the statue", "statue"),
        ("scan", "knock over the old stone lion statue", "statue"),
        ("scan", "the statue falls on the table", "statue"),
        ("scan", "the seat of the stool turns", "furniture"),
        ("Jeep", "tip it over", "vehicle"),
        ("Rusty_Blaster", "it is dropped", "tool"),
        ("scan", "a car hits the bear", None),
        ("scan", "throw the ball at a wall", None),
        ("scorpion low resolution", "the statue of it is hit", "statue"),
        ("scorpion low resolution", "the scorpion falls on the table", None),
        ("scan", "tip it onto the table", None),
        ("scan", "can it drop?", None),
        ("", "", None),
    ],
)
def test_names_and_sentences_tell_what_is_hard(name, sentence, kind):
    assert find_hard_kind(name, sentence, others={"man"}) == kind


def test_no_word_belongs_to_two_kinds():
    words = [word for prior in PRIORS.values() for word in prior.words]
    assert len(words) == len(set(words))


@pytest.mark.parametrize("kind", PRIORS)
def test_materials_are_soft_enough_to_be_seen_moving_and_say_why(kind):
    material = choose_material(kind)
    assert 5e3 <= material.youngs_modulus <= 3e5
    assert 50 <= material.density <= 2000
    assert material.reason and kind in material.reason


@pytest.mark.parametrize(
    ("kind", "model"),
    [
        ("sand", MaterialModel.DRUCKER_PRAGER),
        ("snow", MaterialModel.SNOW),
        ("clay", MaterialModel.VON_MISES),
        ("metal", MaterialModel.VON_MISES),
        ("liquid", MaterialModel.FLUID),
        ("plant", MaterialModel.NEO_HOOKEAN),
    ],
)
def test_matter_that_does_not_spring_back_has_its_own_law(kind, model):
    assert choose_material(kind).model is model


@pytest.mark.parametrize("kind", ["clay", "metal"])
def test_clay_and_metal_stand_under_their_weight_and_are_dented_by_a_fall(kind):
    material, gravity, length = choose_material(kind), 9.8, 1.0
    speed = math.sqrt(2 * gravity * 0.5 * length)
    impact = math.sqrt(material.density * material.youngs_modulus) * speed  # rho c v
    assert material.density * gravity * length < material.yield_stress < 0.5 * impact


@pytest.mark.parametrize(
    ("name", "sentence", "kind"),
    [
        ("honey.gltf", "tip the jar over and let it roll away", "vessel"),
        ("oil.obj", "someone knocks the oil bottle over", "vessel"),
        ("honey.gltf", "the honey flows over the floor", "liquid"),
        ("water.ply", "it splashes", "liquid"),
    ],
)
def test_what_is_called_by_a_substance_is_what_the_sentence_calls_it(name, sentence, kind):
    """A jar of honey was a liquid, and burst."""
    assert guess_kind(name, sentence) == kind


def test_sound_in_the_liquid_is_ten_times_as_fast_as_its_fall():
    material = choose_material("liquid")
    speed = math.sqrt(material.bulk_modulus / material.density)
    assert speed == pytest.approx(10 * math.sqrt(2 * 9.8 * 0.5), rel=0.02)


def test_an_unlisted_kind_gets_the_material_of_an_unknown_object():
    assert choose_material("nebula") == choose_material(UNKNOWN)


def test_plants_are_rooted_and_others_are_free():
    plant = choose_anchor("plant")
    assert plant.kind == "base" and 0 < plant.fraction < 0.5 and "rooted" in plant.reason
    assert all(choose_anchor(kind).kind == "none" for kind in PRIORS if kind != "plant")


def test_the_prompt_wins_over_the_kind():
    free = choose_anchor("plant", "none", "is thrown")
    assert free.kind == "none" and "is thrown" in free.reason
    assert choose_anchor("robot", "top", "hangs").kind == "top"
    assert choose_anchor("robot", "base", "glued to the table").kind == "base"
