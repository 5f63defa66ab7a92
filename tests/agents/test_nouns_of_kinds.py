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
