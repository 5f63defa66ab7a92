"""Nouns that an object of a kind may be called, whatever its file is called."""

import pytest

from physagent_jax.scene.priors import list_nouns
from tests.agents.scenes import brief, read

NOUNS = [
    ("spot", "animal", "shove the calf hard to the right"),
    ("cat", "animal", "the kitten jumps up"),
    ("teapot", "vessel", "the kettle rattles"),
    ("tree", "plant", "the oak sways"),
    ("plane", "vehicle", "the aircraft rises"),
    ("boat", "vehicle", "the sailboat rocks to the left"),
    ("st-peter", "object", "the saint falls over"),
    ("demosthenes", "object", "the orator falls over"),
    ("deer", "object", "the deer head hops up"),  # of a trophy, all of it
    ("robot", "robot", "the robot bobbles back and forth"),
    ("grapes", "food", "the bunch slides to the left"),
    ("pancakes", "food", "the stack topples over"),
]


@pytest.mark.parametrize(("name", "kind", "sentence"), NOUNS)
def test_a_noun_that_can_only_be_the_object_is_no_doubt(name, kind, sentence):
    scene = brief(object_name=name, object_kind=kind, object_nouns=list_nouns(kind), world="ground")
    assert not read(sentence, scene).unsure


@pytest.mark.parametrize("sentence", ["tip the flurb over", "the kitten jumps up"])
def test_a_noun_that_may_be_another_thing_is_doubted(sentence):
    scene = brief(
        object_name="teapot", object_kind="vessel", object_nouns=list_nouns("vessel"), world="ground"
    )
    assert read(sentence, scene).unsure


@pytest.mark.parametrize("rest", ["before it stops", "until it settles"])
@pytest.mark.parametrize("noun", ["flurb", "heap"])
def test_what_the_subject_of_a_later_pronoun_does_is_not_lost(noun, rest):
    """It was taken for another thing's doing, as "it" seemed to be the object."""
    scene = brief(
        object_name="plant", object_kind="object", object_nouns=list_nouns("object"), world="ground"
    )
    reply = read(f"the {noun} rolls to the right {rest}", scene)
    assert [each.kind.value for each in reply.expectations] == ["move", "rotate", "still"]


def test_another_thing_stays_another_thing():
    reply = read("the robot falls over while a bird flies past it", brief(world="ground"))
    assert {each.kind.value for each in reply.expectations} == {"rotate", "fall"}


@pytest.mark.parametrize(
    "sentence",
    [
        "the dish spins on the spot",
        "the dish is made of rubber and it slides to the left",
        "the bucket is pressed flat",
    ],
)
@pytest.mark.parametrize("name", ["tajine", "bathtub"])
def test_a_noun_for_a_part_that_the_object_lacks_is_the_object(name, sentence):
    """A dish was taken for an antenna of which nobody knows the place."""
    scene = brief(object_name=name, object_kind="object", object_nouns=list_nouns("object"), world="ground")
    reply = read(sentence, scene)
    assert not (reply.unknown_parts or reply.unsure)
    assert all(each.part is None and not each.partial for each in reply.expectations)


def test_a_noun_for_a_part_stays_one_beside_the_object_or_on_top_of_it():
    scene = brief(
        object_name="tajine", object_kind="object", object_nouns=list_nouns("object"), world="ground"
    )
    for sentence in (
        "bend the dish on top of it to the left",
        "the dish of the tajine bends",
        "the head turns",
    ):
        assert read(sentence, scene).unknown_parts or read(sentence, scene).expectations[0].part
