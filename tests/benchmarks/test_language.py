"""Replies held against what a person understands."""

import collections
import hashlib

import pytest

from benchmarks.language.__main__ import compile_sentence, read_all
from benchmarks.language.notation import (
    FILES,
    SPLITS,
    Reading,
    Sentence,
    expand_options,
    parse_reading,
    read_sentences,
    read_split,
)
from benchmarks.language.score import get_answer, make_scene, score
from benchmarks.language.totals import REQUIRED, describe_shares, find_outcome, is_met
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind, ObstacleRequest, WorldRequest

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


COUNTS = {
    "development/first": 305, "test/first": 168, "development/second": 102, "test/second": 131,
    "development/third": 240, "development/fourth": 144, "test/fourth": 96, "development/fifth": 107,
    "test/fifth": 133, "development/sixth": 225, "development/seventh": 130, "test/seventh": 110,
    "development/eighth": 240, "development/ninth": 239, "adversarial/maintainers": 185,
}  # fmt: skip
SHARES = {"first": 3, "second": 2, "fourth": 2, "fifth": 2, "seventh": 2}
"""Authors some of whose sentences are held back: one in so many."""


def test_the_corpus_is_whole_and_its_splits_are_as_they_were_drawn():
    """By the hash of the text, which the files write down: a text that is edited or moved is found."""
    corpus = {file: read_sentences(file) for file in FILES}
    assert {file: len(sentences) for file, sentences in corpus.items()} == COUNTS
    assert sum(len(read_split(split)) for split in SPLITS[:2]) == 2370
    for sentences in corpus.values():
        for each in sentences:
            share = SHARES.get(each.author, 0)
            held_back = share and hashlib.sha256(each.text.encode()).digest()[0] % share == 0
            assert (each.split == "test") == bool(held_back) and each.readings


def test_no_sentence_stands_twice():
    """Once for an object, and by one author."""
    everything = [each for file in FILES for each in read_sentences(file)]
    counts = collections.Counter((each.text, each.object_name) for each in everything)
    assert not [text for text, n in counts.items() if n > 1]
    authors = {(each.text, each.author) for each in everything}
    assert len(authors) == len({each.text for each in everything})


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


def test_a_split_that_is_not_as_required_fails():
    """Its rows that are not right are failing rows, where nothing is required none."""
    silent = Sentence("push the robot to the left", "robot", "", "refused", (Reading("refused"),))
    for split, good in (("test", False), ("adversarial", True)):
        (row,) = read_all(split, [silent])
        assert row["silent"] and row["good"] == good
    right = Sentence(silent.text, "robot", "", "move left", sentence("move left").readings)
    assert all(row["good"] for row in read_all("test", [silent, *[right] * 14]))
    assert not all(row["good"] for row in read_all("test", [silent, *[right] * 12]))
    assert compile_sentence("", ROBOT) is None


@pytest.mark.parametrize(
    ("outcome", "wrong", "answer", "fields"),
    [
        ("right", [], "refused", 1),
        ("right but marked", ["answer"], "unsure", 9),
        ("wrong and marked", ["answer", "kind"], "unsure", 9),
        ("wrong and marked", ["answer"], "unsure", 1),  # it should have been refused
        ("wrongly refused", ["answer", "kind"], "refused", 9),
        ("silently wrong", ["kind"], "motion", 9),
        ("silently wrong", ["answer"], "motion", 1),
    ],
)
def test_outcomes(outcome, wrong, answer, fields):
    assert find_outcome({"wrong": wrong, "answer": answer, "fields": fields}) == outcome


def test_what_is_required_of_a_split():
    """At least so many right, and at most so many silently wrong, whatever is marked."""
    least, most = (round(100 * share) for share in REQUIRED["test"])

    def count(right, silent):
        return collections.Counter(
            {"right": right, "silently wrong": silent, "right but marked": 100 - right - silent}
        )

    assert is_met("test", count(least, most))
    assert not is_met("test", count(least - 1, most)) and not is_met("test", count(least, most + 1))
    assert is_met("adversarial", count(0, 100))
    assert describe_shares(count(least, most)).startswith(f"100 sentences: right {least:.2f} %, ")


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


def test_readings_of_second_readers_are_as_good():
    """They follow the author's own."""
    first = read_sentences("development/first")
    (shown,) = [each for each in first if each.text == "nudge it to the right"]
    assert shown.expected == "move right slight || hit right slight" and len(shown.readings) == 2
