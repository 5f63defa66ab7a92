"""Material words of a sentence: what is said of the object, and what belongs to something else."""

import pytest

from physagent_jax.agents.materials import find_materials, find_meaning, mask_materials, read_material_words
from physagent_jax.scene.materials import LIBRARY
from physagent_jax.scene.priors import PRIORS, list_nouns
from tests.agents.scenes import brief, read


def called(name: str, kind: str):
    return brief(object_name=name, object_kind=kind, object_nouns=list_nouns(kind))


ROBOT = called("robot", "robot")
THING = called("scan 12", "object")


def found(sentence, scene=ROBOT):
    return [(mention.word, mention.phrase) for mention in find_materials(sentence, scene)]


@pytest.mark.parametrize(
    ("sentence", "word", "phrase"),
    [
        ("a robot made of jelly falls over", "jelly", "made of jelly"),
        ("push it to the left, made of jelly", "jelly", "made of jelly"),
        ("make the robot rubber and push it", "rubber", "make the robot rubber"),
        ("make him all jelly and let him drop", "jelly", "make him all jelly"),
        ("pull it like its made of rubber", "rubber", "made of rubber"),
        ("it falls, made entirely of rubber", "rubber", "made entirely of rubber"),
        ("Made entirely of soft rubber, the robot bounces", "soft rubber", "Made entirely of soft rubber"),
        ("the robot, which is made out of wood, tips over", "wood", "made out of wood"),
        ("make the robot out of jelly and drop it", "jelly", "make the robot out of jelly"),
        ("Made of unobtainium, the robot falls", "unobtainium", "Made of unobtainium"),
        ("make the robot out of unobtainium", "unobtainium", "make the robot out of unobtainium"),
        ("Make him out of soft rubber and push him", "soft rubber", "Make him out of soft rubber"),
        ("make it out of super wobbly jelly!!", "jelly", "make it out of super wobbly jelly"),
        ("made of cheap shiny plastic, it falls", "plastic", "made of cheap shiny plastic"),
        ("make it from crunchy peanut butter", "peanut butter", "make it from crunchy peanut butter"),
        ("it turns into incredibly sticky honey", "honey", "turns into incredibly sticky honey"),
        ("a robot made of bouncy unobtainium falls", "unobtainium", "made of bouncy unobtainium"),
        ("it moves as if it were made of rubber", "rubber", "made of rubber"),
        ("a robot carved from stone", "stone", "carved from stone"),
        ("a robot of cast iron falls", "cast iron", "robot of cast iron"),
        ("push the metal robot to the left", "metal", "metal robot"),
        ("a rubbery little robot hops", "rubbery", "rubbery little robot"),
        ("the jelly-like robot wobbles", "jelly", "jelly-like robot"),
        ("the robot is metal", "metal", "is metal"),
        ("it wobbles like jelly", "jelly", "wobbles like jelly"),
        ("it bounces back like rubber and stops", "rubber", "bounces back like rubber"),
        ("soft as jelly, the robot sags", "jelly", "soft as jelly"),
        ("the robot turns to sand", "sand", "turns to sand"),
        ("it collapses into a pile of wet sand", "wet sand", "collapses into a pile of wet sand"),
        ("it becomes liquid", "liquid", "becomes liquid"),
        ("the robot, made of chocolate, tips over", "chocolate", "made of chocolate"),
        ("the gizmo is made of jelly and falls", "jelly", "made of jelly"),  # nothing else is there
        ("The birthday parcel is made of dough and a thumb presses it", "dough", "made of dough"),
    ],
)
def test_a_material_that_is_said_of_the_object(sentence, word, phrase):
    assert found(sentence) == [(word, phrase)]
    (mention,) = find_materials(sentence, ROBOT)
    assert sentence[slice(*mention.span)] == phrase


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot falls onto the sand",
        "drop it into the water",
        "it lands on a table made of wood",
        "it lands on a table, made of wood",
        "the table is made of wood and the robot falls onto it",
        "the arms are made of wood and wave",
        "a rubber band pulls the robot",
        "a metal rod hits the robot",
        "a metal ball hits it",
        "bend the robot's metal arm",
        "pull it with a steel rope",
        "the robot drops like a stone",  # no deformation
        "it falls like sand",
        "it wobbles like water balloons",
        "the robot is not made of metal",
        "make the robot jump out of the sand",
        "this is not a metal robot",
        "it collapses into the sand",
        "the ground is metal",
        "rock the robot",
        "iron the robot",
        "the robot is made to fall",
        "",
        "\u0130\u0130\u0130 jelly",  # letters whose lower case is longer
    ],
)
def test_what_is_not_said_of_the_object(sentence):
    assert found(sentence) == []


def test_a_thing_of_unknown_kind_is_not_any_thing_that_is_named():
    assert found("a metal ball hits the object", THING) == []
    assert found("the object falls on a wooden chair", THING) == []
    assert found("the object falls on a chair made of wood", THING) == []
    assert found("a cup of water falls", THING) == []
    assert found("a metal ball falls", THING) == [("metal", "metal ball")]
    assert found("a bear of sand collapses", THING) == [("sand", "bear of sand")]


@pytest.mark.parametrize(
    ("name", "kind"), [("sand bear", "animal"), ("sandbear", "object"), ("bear", "animal")]
)
def test_a_compound_of_material_and_noun(name, kind):
    (mention,) = find_materials("a sand bear collapses", called(name, kind))
    assert (mention.word, mention.phrase) == ("sand", "sand bear")
    assert mention.named == (name == "sand bear")


@pytest.mark.parametrize(
    ("name", "kind", "sentence"),
    [
        ("water bottle", "vessel", "the water bottle falls"),
        ("ice cream cone", "object", "turn the ice cream upside down"),
        ("sand", "sand", "the sand collapses"),
        ("glass", "vessel", "the glass falls"),
        ("jelly", "jelly", "the jelly wobbles"),
    ],
)
def test_names_that_tell_no_material_beyond_the_kind(name, kind, sentence):
    assert found(sentence, called(name, kind)) == []


def test_becoming_something_is_told_apart():
    (turned,) = find_materials("the robot turns to stone", ROBOT)
    (made,) = find_materials("a robot made of stone", ROBOT)
    assert turned.turns and not made.turns


@pytest.mark.parametrize(
    ("sentence", "left"),
    [
        ("a robot made of soft jelly falls", "a robot falls"),
        ("push the metal robot left", "push the robot left"),
        ("it wobbles like jelly and stops", "it wobbles and stops"),
        ("the robot turns to sand and falls", "the robot and falls"),
        ("the robot collapses into a pile of sand", "the robot collapses"),
        ("a robot of steel falls", "a robot falls"),
        ("make the robot out of steel and drop it", "and drop it"),
        ("push the robot onto the sand", "push the robot onto the sand"),
    ],
)
def test_what_is_left_to_read_without_the_material(sentence, left):
    masked = mask_materials(sentence, find_materials(sentence, ROBOT))
    assert " ".join(masked.split()) == left and len(masked) == len(sentence)


def test_the_objects_own_name_stays_to_be_read():
    scene = called("rubber duck", "animal")
    assert mask_materials("push the rubber duck", find_materials("push the rubber duck", scene)) == (
        "push the rubber duck"
    )


def test_several_materials_are_all_found_and_each_once():
    assert [word for word, _ in found("a metal robot, made of metal, that wobbles like jelly")] == [
        "metal",
        "jelly",
    ]


def test_every_word_stands_for_a_preset_that_there_is():
    lexicon = read_material_words()
    assert {meaning.preset for meaning in lexicon.words.values()} <= {*PRIORS, *LIBRARY}
    assert lexicon.adjectives <= set(lexicon.words) and len(lexicon.words) > 100
    assert find_meaning("Wet-Sand").preset == "wet_sand" and find_meaning("unobtainium") is None
    assert find_meaning("gold").near and not find_meaning("steel").near


@pytest.mark.parametrize(
    ("words", "preset"),
    [
        ("cookie dough", "clay"),
        ("gummy bears", "ecoflex"),
        ("jelly beans", "ecoflex"),
        ("cotton candy", "pu_foam"),
        ("papier mache", "cardboard"),
        ("dark chocolate", "abs"),
        ("whipped cream", "toothpaste"),
        ("tissue paper", "cloth"),
        ("balsa wood", "pine"),
        ("stainless steel", "steel"),
        ("melted cheese", "honey"),
    ],
)
def test_common_words_stand_for_the_nearest_material(words, preset):
    truck = called("fire truck", "vehicle")
    assert found(f"build the fire truck out of {words} and drop it", truck)[0][0] == words
    assert find_meaning(words).preset == preset


def test_long_sentences_are_read_in_time():
    """Every word is looked at with a few around it: ten thousand of them are no matter of seconds."""
    assert len(find_materials("made of " * 5_000 + "jelly", ROBOT)) <= 1


@pytest.mark.parametrize(
    ("prompt", "held"),
    [
        ("somebody taps a robot made of jelly and it wobbles", True),
        ("flick the jelly robot from the left", True),
        ("poke the robot, which is made of jelly", True),
        ("the robot wobbles like jelly", True),
        ("nudge the jelly robot to the left", True),
        ("the jelly robot creeps to the left", False),
        ("kick the jelly robot to the left", False),
        ("tap the wooden robot", False),
        ("tap the jelly robot, then lift it", False),
    ],
)
def test_what_is_soft_wobbles_on_its_base(prompt, held):
    """A tap makes jelly wobble; loose on the ground, all of it would slide away, or fall over as it sways."""
    reply = read(prompt, brief(world="ground", may_be_held=True))
    assert (reply.anchor.kind in ("base", "rest")) is held
    assert not held or all(each.sudden or each.kind.value == "sway" for each in reply.expectations)
    assert not reply.unsure


@pytest.mark.parametrize(
    ("sentence", "preset"),
    [
        ("the glass robot falls and shatters", "brittle"),
        ("the robot breaks into pieces", "brittle"),
        ("a chocolate robot melts in the sun", "melt"),
        ("the robot crumbles to dust", "sand"),
        ("the robot drips down into a blob", "melt"),
        ("bend the robot and let it snap back", None),
        ("it melts into the ground", "melt"),
        ("after a break the robot does not break", None),
    ],
)
def test_a_verb_by_which_matter_gives_way_says_what_it_becomes(sentence, preset):
    meanings = [find_meaning(word) for word, _ in found(sentence)]
    assert {each.preset for each in meanings if each and each.becomes} == ({preset} if preset else set())


def test_what_snaps_is_brittle_and_what_a_part_does_is_not_of_all():
    """ "Its blade breaks in two" takes the blade off, and leaves the rest as it is."""
    ground = brief(world="ground")
    assert read("hit the robot and it snaps", ground).materials == ("breaks",)
    assert read("the robot snaps in two", ground).materials == ()  # its halves come apart
    assert read("the top of the robot breaks in two", ground).materials == ()
    assert read("the top of the robot comes off and shatters", ground).materials == ()


def test_what_gives_way_falls_only_where_nothing_else_acts():
    """A melting object sinks where it stands, a shattering one falls first, and one that is hit breaks by that."""
    still = brief(world="ground", may_be_held=True)
    melts, breaks, hit = (
        read(f"{say}", still) for say in ("it melts", "it shatters", "hit it and it breaks")
    )
    assert not melts.force_field.actions and not melts.force_field.default_drop
    assert [each.kind.value for each in melts.expectations] == ["squeeze"]
    assert breaks.force_field.default_drop and not hit.force_field.default_drop
    assert not (melts.unsure or breaks.unsure or hit.unsure)


@pytest.mark.parametrize(
    ("prompt", "word"),
    [
        ("push its arm back, its like soft wax so it stays bent", "wax"),
        ("it's like jelly and it wobbles", "jelly"),
        ("pretend it's rubber and drop it", "rubber"),
        ("make the robot bouncy n drop it", "bouncy"),
        ("drop it and let it bounce like a basketball", "basketball"),
        ("robot made outta clay is squashed", "clay"),
        ("it behaves like a water balloon and spreads out", "water balloon"),
        ("the robot is now a marshmallow, squish it", "marshmallow"),
        ("it is an ice sculpture and tips over", "ice"),
        ("the robot is a balloon, it bounces", "balloon"),
    ],
)
def test_a_likeness_of_the_whole_is_a_material(prompt, word):
    assert [each.word for each in find_materials(prompt, brief())] == [word]


@pytest.mark.parametrize("prompt", ["a basketball hits it", "it jumps on a pillow", "its rubber arm bends"])
def test_other_things_are_no_materials(prompt):
    assert not find_materials(prompt, brief())


def test_a_material_is_said_of_what_is_called_by_another_one():
    glass = called("glass-beer", "vessel")
    assert found("A beer glass made of jelly tips over", glass) == [("jelly", "made of jelly")]


def test_a_compound_noun_is_the_object_where_nothing_else_is_named():
    reply = read("The birthday parcel gets squashed", called("thing 3", "object"))
    assert not reply.not_understood and len(reply.expectations) == 1
