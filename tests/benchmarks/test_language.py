"""Replies held against what a person understands."""

import collections

import pytest

from benchmarks.language.__main__ import compile_sentence, read_split
from benchmarks.language.notation import (
    FILES,
    LIMIT,
    Reading,
    Sentence,
    expand_options,
    parse_reading,
    read_sentences,
)
from benchmarks.language.score import get_answer, make_scene, score
from physagent_jax.agents.schema import (
    Amount,
    ExpectedMotion,
    MotionKind,
    ObstacleRequest,
    SemanticReply,
    WorldRequest,
)
from physagent_jax.forces.schema import Action, ActionType, ForceField

ROBOT = make_scene("robot")
LEFT, RIGHT, UP, DOWN = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def sentence(expected: str) -> Sentence:
    readings = tuple(
        each for text in expected.split(" || ") for each in expand_options(parse_reading(text.strip()))
    )
    return Sentence("said", "robot", "", expected, readings)


def reply(*motions: ExpectedMotion, actions=(), **more) -> SemanticReply:
    return SemanticReply(force_field=ForceField(actions=actions), expectations=motions, **more)


def move(direction=LEFT, window=(0, 49), **more) -> ExpectedMotion:
    return ExpectedMotion(kind=MotionKind.MOVE, direction=direction, window=window, **more)


def wrong(expected: str, given: SemanticReply | None) -> set[str]:
    return {name for name, right in score(sentence(expected), given, ROBOT) if not right}


@pytest.mark.parametrize(("author", "held_back"), [("first", 1 / 3), ("second", 1 / 2)])
def test_the_files_are_large_and_split_by_hash(author, held_back):
    """Hundreds of different sentences, all of them readable, about the stated share held back."""
    sentences = read_sentences(author)
    assert len(sentences) >= 150
    assert all(each.readings for each in sentences)
    twice = [
        text for text, n in collections.Counter((s.text, s.object_name) for s in sentences).items() if n > 1
    ]
    assert not twice
    share = sum(each.split == "test" for each in sentences) / len(sentences)
    assert abs(share - held_back) < 0.09
    others = {s.text for other in FILES if other != author for s in read_sentences(other)}
    assert not others & {s.text for s in sentences}


@pytest.mark.parametrize(
    ("expected", "given", "fields"),
    [
        ("move left", reply(move()), set()),
        ("move left", reply(move(RIGHT)), {"direction"}),
        ("move left", reply(move(strength=1.6)), {"strength"}),
        ("move left slight", reply(move(strength=0.5)), set()),
        ("hit left", reply(move()), {"kind"}),
        ("hit left", reply(move(sudden=True)), set()),
        ("move left x3", reply(move(repeats=2)), {"repeats"}),
        ("move left =0.5L", reply(move()), {"amount"}),
        ("move left =0.5L", reply(move(amount=Amount(value=0.8, unit="metres"))), set()),
        ("move left =0.5L", reply(move(amount=Amount(value=2, unit="factor"))), {"amount"}),
        ("move left", reply(move(amount=Amount(value=2, unit="lengths"))), {"amount"}),
        ("move left on up", reply(move(partial=True, part=UP)), set()),
        ("move left except up", reply(move(partial=True, part=UP)), {"part"}),
        ("move left", reply(move(partial=True, part=UP)), {"part"}),
        ("move left stays", reply(move()), {"state"}),
        ("move left", reply(move(stays=True)), {"state"}),
        ("move * noted", reply(move()), {"state"}),
        ("move left ; move right", reply(move(), move(RIGHT, (25, 49))), set()),
        ("move left ; move right", reply(move(), move(RIGHT)), {"order"}),
        ("move left & move right", reply(move(window=(0, 20)), move(RIGHT, (25, 49))), {"order"}),
        ("move left ; ?still", reply(move()), set()),
        ("move left || move right", reply(move(RIGHT)), set()),
        ("lean left", reply(ExpectedMotion(kind=MotionKind.ROTATE, direction=(0, -1, 0), window=(0, 9))), set()),
        ("rotate up", reply(ExpectedMotion(kind=MotionKind.ROTATE, direction=DOWN, window=(0, 9))), {"direction"}),
        ("sway right", reply(ExpectedMotion(kind=MotionKind.SWAY, direction=LEFT, window=(0, 9), repeats=4)), set()),
        ("move left", reply(move(), unsure=("What?",)), {"answer"}),
        ("unsure", reply(move(), unsure=("What?",)), set()),
        ("unsure", None, set()),
        ("refused", reply(move(), unsure=("What?",)), {"answer"}),
        ("unsure", reply(move()), {"answer"}),
        ("move left | gravity none", reply(move()), {"world"}),
        ("move left", reply(move(), world=WorldRequest(gravity="none")), {"world"}),
        ("move left | wall *", reply(move(), world=WorldRequest(obstacles=(ObstacleRequest(direction=LEFT),))), set()),
        ("move left | anchor base", reply(move()), {"anchor"}),
    ],
)  # fmt: skip
def test_fields(expected, given, fields):
    """Each departure from what is understood is found, and nothing else."""
    assert wrong(expected, given) == fields


def test_told_times_are_looked_for_in_causes():
    """The cause's window counts, in seconds of frames of 0.04 s."""
    push = Action(action_type=ActionType.TRANSLATION, vector=LEFT, active_time=(25, 37))
    assert not wrong("move left for=0.5", reply(move(), actions=(push,)))
    assert not wrong("move left from=1", reply(move(), actions=(push,)))
    assert wrong("move left for=1", reply(move(), actions=(push,))) == {"time"}


def test_a_refused_sentence_has_no_right_field():
    """All fields of a motion are missing, and nothing is silent about it."""
    assert wrong("move left", None) == {
        "answer", "kind", "direction", "strength", "amount", "repeats", "part", "time", "state",
    }  # fmt: skip
    assert get_answer(None) == "refused"


def test_silent_errors_fail_the_benchmark_beyond_the_limit():
    """A sentence that is misread without a word is a failing row, where there are too many of them."""
    right = Sentence("push the robot to the left", "robot", "", "move left", (Reading("refused"),))
    (row,) = read_split([right])
    assert row["silent"] and not row["good"]
    good = [sentence_of("push the robot to the left", "move left")] * round(2 / LIMIT)
    assert all(row["good"] for row in read_split([right, *good]))
    assert compile_sentence("", ROBOT) is None


def sentence_of(text: str, expected: str) -> Sentence:
    return Sentence(text, "robot", "", expected, sentence(expected).readings)


def test_a_fall_may_begin_with_the_lean_that_it_follows_and_with_nothing_else():
    turn = ExpectedMotion(kind=MotionKind.ROTATE, direction=(0.0, -1.0, 0.0), window=(0, 49))
    fall = ExpectedMotion(kind=MotionKind.FALL, window=(0, 49))
    later = ExpectedMotion(kind=MotionKind.FALL, window=(25, 49))
    short = ExpectedMotion(kind=MotionKind.ROTATE, direction=(0.0, -1.0, 0.0), window=(0, 25))
    assert not wrong("lean left any ; ?fall", reply(turn, fall))
    assert not wrong("lean left any ; ?fall", reply(short, later))
    assert not wrong("lean left any ; ?fall", reply(turn))
    assert wrong("lean left any ; fall", reply(turn, fall))  # asked for one after the other
    assert wrong("move left any ; ?fall", reply(move(), fall))


def test_readings_that_were_added_can_be_left_out():
    """Without them a sentence has fewer readings, never others; who added none is read the same."""
    for author in FILES:
        pairs = list(zip(read_sentences(author), read_sentences(author, own_words=True), strict=True))
        assert all(own.text == both.text for both, own in pairs)
        assert all(both.expected.startswith(own.expected) for both, own in pairs)
        assert all(set(map(str, own.readings)) <= set(map(str, both.readings)) for both, own in pairs)
        fewer = sum(own.expected != both.expected for both, own in pairs)
        assert fewer == {"first": 188, "second": 140, "seventh": 132}.get(author, 0)
