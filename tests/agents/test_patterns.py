"""The documented language: its patterns hold, the page shows them, and what is outside is refused or marked."""

import sys
from pathlib import Path

import pytest

from benchmarks.language.notation import Sentence, expand_options, parse_reading
from benchmarks.language.page import describe_patterns
from benchmarks.language.score import make_scene, score
from physagent_jax.agents.compiler.words import suggest_motions
from physagent_jax.agents.grammar.patterns import read_patterns
from physagent_jax.agents.grammar.semantic import read_intent, read_sentence
from physagent_jax.core.errors import UserError

PAGE = Path(__file__).parents[2] / "docs" / "sentences.md"
EXAMPLES = [(pattern, example) for pattern in read_patterns() for example in pattern.examples]
# Sentences of README, the first-results page and the examples, as a person understands them.
PUBLIC = [
    ("robot", "a strong wind pushes the robot to the left", "move left strong"),
    ("robot", "push the robot gently to the left", "move left slight"),
    ("robot", "rotate the robot by 90 degrees", "rotate +-up =90deg"),
    ("guitar", "drop the guitar", "fall"),
    ("guitar", "someone hits the guitar hard from the left", "hit right strong"),
    ("guitar", "lift the guitar up and hold it there", "move up stays"),
    ("plant", "a strong wind bends the plant to the left, then lets go", "lean left strong released"),
    ("plant", "the plant sways gently in the breeze", "sway * slight x*"),
    ("plant", "hit the top of the plant from the right", "hit left on up"),
    ("jelly", "the jelly wobbles and then comes to rest", "sway * slight x* ; still || sway * x* ; still"),
    ("jelly", "squash the jelly to half its height", "squeeze up =0.5x"),
    ("jelly", "stretch the jelly sideways", "stretch right"),
    ("loaf", "squeeze the loaf from both sides", "squeeze right"),
    ("loaf", "twist the loaf of bread", "rotate * any on left & rotate * any on right"),
    ("cow", "push the cow to the right, then lift it up, then drop it", "move right ; move up ; fall"),
    ("cow", "shake the cow violently", "sway * strong x*"),
    ("cow", "pull the cow's head to the left", "move left on up"),
    ("bunny", "throw the bunny up into the air", "hit up ; fall"),
    ("bunny", "the bunny is floating in space and slowly spins", "rotate +-up slight | gravity none"),
    ("ball", "throw the ball against the wall on the right", "hit right any | wall right"),
    ("ball", "kick the ball hard to the left", "hit left strong"),
    ("ball", "roll the ball to the right", "move right any & rotate away any"),
    ("plant", "the plant sways in the wind", "sway * any x*"),
    ("plant", "bend the plant 30 degrees to the left, then let go", "lean left =30deg released"),
    ("robot", "lift it a little", "move up slight"),
]


def find_wrong(name: str, text: str, reading: str) -> list[str]:
    """Fields that differ from a reading in the notation of the corpus."""
    readings = tuple(
        each for choice in reading.split(" || ") for each in expand_options(parse_reading(choice.strip()))
    )
    brief = make_scene(name)
    try:
        reply = read_sentence(text, brief)
    except UserError:
        reply = None
    return [
        field
        for field, right in score(Sentence(text, name, "", reading, readings), reply, brief)
        if not right
    ]


@pytest.mark.parametrize(("pattern", "example"), EXAMPLES, ids=[example for _, example in EXAMPLES])
def test_pattern(pattern, example):
    assert not find_wrong(pattern.object, example, pattern.reading)


@pytest.mark.parametrize(("name", "text", "reading"), PUBLIC, ids=[row[1] for row in PUBLIC])
def test_public_sentence(name, text, reading):
    assert not find_wrong(name, text, reading)


def test_a_wrong_reading_is_found():
    assert find_wrong("robot", "push the robot to the left", "move right") == ["direction"]
    assert find_wrong("robot", "flimflam the robot", "move right")


def test_the_page_shows_the_patterns():
    assert PAGE.read_text(encoding="utf-8") == describe_patterns()
    assert len(read_patterns()) >= 60
    assert len({pattern.name for pattern in read_patterns()}) == len(read_patterns())


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("flimflam the robot", "flimflam"),
        ("the robot flimflams", "flimflams"),
        ("a bird flies past the robot", "flies"),
        ("the camera spins around the robot", "spins"),
        ("pan the camera to the left", "pan"),
        ("the door slams behind the robot", "slams"),
    ],
)
def test_what_is_done_by_others_or_unknown_is_refused(text, word):
    with pytest.raises(UserError) as refused:
        read_intent(text, make_scene("robot"))
    assert f"'{word}'" in str(refused.value)
    assert sum(f'"{pattern.form}"' in str(refused.value) for pattern in read_patterns()) == 2


def test_the_nearest_known_motions_are_named():
    assert suggest_motions("pusch")[0] == "push"
    with pytest.raises(UserError, match="nearest known motions are push"):
        read_intent("pusch the robot", make_scene("robot"))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("push the robot to the left, cinematic lighting", "cinematic"),
        ("at dusk the robot spins", "dusk"),
        ("the gleaming robot spins", "gleaming"),
        ("the rusty robot spins", "rusty"),
        ("the robot spins in the orchard", "orchard"),
        ("the robot spins, volumetric fog, award winning", "volumetric"),
        ("a blacksmith hits the robot from the left", "blacksmith"),
        ("the robot leans left, golden hour, 35mm", "35mm"),
    ],
)
def test_looks_scenery_and_whoever_acts_are_ignored(text, word):
    intent = read_intent(text, make_scene("robot"))
    assert word in intent.ignored and not intent.unknown and len(intent.clauses) == 1


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("push the robot to the left and paint it", "paint"),
        ("the robot spins and flimflams", "flimflams"),
        ("push the red part to the left", "red"),
        ("spin its gizmo", "gizmo"),
        ("push the robot to the left in a spiral", "spiral"),
        ("bend the robot into a pretzel", "pretzel"),
        ("hit the robot on the forehead", "forehead"),
        ("push the robot to the left 17", "17"),
    ],
)
def test_verbs_parts_paths_and_numbers_are_doubtful(text, word):
    intent = read_intent(text, make_scene("robot"))
    assert word in intent.unknown


@pytest.mark.parametrize(
    "text", ["push the robot left ", "gently ", "a ", "word ", "left, no wait, ", "not push "]
)
def test_the_work_of_reading_grows_with_the_length(text):
    """Four times the words are some four times the calls, not the sixteen times of a reader of all pairs."""

    def count_calls(count: int) -> int:
        calls = 0

        def note(_frame, event, _argument):
            nonlocal calls
            calls += event in ("call", "c_call")

        sys.setprofile(note)
        try:
            read_intent(text * count, make_scene("robot"))
        except UserError:
            pass
        finally:
            sys.setprofile(None)
        return calls

    assert count_calls(800) < 6 * count_calls(200)


def test_more_clauses_than_an_intent_holds_are_a_doubt():
    intent = read_intent("push the robot to the left, then " * 150 + "lift it", make_scene("robot"))
    assert len(intent.clauses) == 100 and intent.doubts[0] == "Only the first 100 of 151 motions are read."


@pytest.mark.parametrize(
    "text",
    [
        "a heavy plate comes down and squashes the robot",
        "a giant hand comes down and squashes the robot",
        "a big ball rolls in and squashes the robot",
    ],
)
def test_the_way_of_what_acts_is_not_the_objects(text):
    (clause,) = read_intent(text, make_scene("robot")).clauses
    assert clause.motion == "squash"
