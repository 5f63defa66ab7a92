"""Findings of a second, simpler reading: words without a motion, and motions that do not go together.

Beside each reading that is doubted stands a near neighbour that is not. Composed sentences are held against the
readings of what they are composed of.
"""

import itertools

import pytest

from physagent_jax.agents.rules.language.accounting import find_unused
from physagent_jax.agents.rules.language.clauses import Clause
from physagent_jax.agents.rules.language.coherence import find_incoherences
from physagent_jax.agents.rules.language.cross_check import Outcome, find_disagreements
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.reading import find_mentions
from physagent_jax.agents.rules.language.tokens import tokenise
from physagent_jax.agents.schema import Amount, ExpectedMotion, MotionKind
from tests.agents.scenes import read
from tests.agents.tellings import ground

NAMES = frozenset({"robot"})
LEFT, RIGHT, UP, DOWN = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def see(kind: str, direction=None, window=(0, 49), words="", **more) -> ExpectedMotion:
    return ExpectedMotion(kind=MotionKind(kind), direction=direction, window=window, words=words, **more)


def doubt(prompt: str, *motions: ExpectedMotion, anchor=None, obstacles=()) -> list[str]:
    """The doubts about a sentence of which these motions were read."""
    outcome = Outcome(motions, (), anchor, obstacles, ground().directions)
    return find_disagreements(tokenise(prompt), find_mentions(prompt, NAMES), NAMES, outcome)


@pytest.mark.parametrize(
    ("prompt", "motions", "told"),
    [
        ("push it left and up", [see("move", LEFT)], "up"),
        ("push it left, then right", [see("move", LEFT)], "right"),
        ("push it, then it sinks", [see("move", LEFT)], "sinks"),
        ("the wind makes it spin", [see("move", LEFT)], "spin"),
        ("push its upper body left", [see("move", LEFT)], "upper body"),
        ("pull it out to twice its length", [see("move", LEFT)], "to twice its length"),
        ("push it until it is half as tall", [see("move", DOWN)], "half as tall"),
        ("3.2 squeeze it", [see("squeeze", UP, repeats=3)], "3.2"),
        ("the whole robot slides left", [see("move", LEFT, partial=True, part=UP)], "whole"),
        ("its foot clamped, it is pushed left", [see("move", LEFT)], "clamped"),
        ("stretch it and release it", [see("stretch", RIGHT)], "release"),
    ],
)
def test_a_word_without_a_trace_is_told(prompt, motions, told):
    """A reading that lacks what the word says is doubted, by that word."""
    (text,) = doubt(prompt, *motions)
    assert f"'{told}" in text or f"{told}'" in text


@pytest.mark.parametrize(
    ("prompt", "motions", "more"),
    [
        ("push it left and up", [see("move", (-0.7, 0.0, 0.7))], {}),
        ("push it left, then right", [see("move", LEFT), see("move", RIGHT)], {}),
        ("push it left, not right", [see("move", LEFT)], {}),
        ("push it, then it sinks", [see("move", LEFT), see("move", DOWN)], {}),
        ("the wind makes it spin", [see("rotate", UP)], {}),
        ("push it but do not spin it", [see("move", LEFT)], {}),
        ("push its upper body left", [see("move", LEFT, partial=True, part=UP)], {}),
        ("pull it out to twice its length", [see("stretch", RIGHT)], {}),
        (
            "move it left by half its height",
            [see("move", LEFT, amount=Amount(value=0.5, unit="lengths"))],
            {},
        ),
        ("squeeze it 3 times", [see("squeeze", UP, repeats=3)], {}),
        ("the whole robot slides left", [see("move", LEFT)], {}),
        ("its foot clamped, it is pushed left", [see("move", LEFT)], {"anchor": "base"}),
        ("stretch it and release it", [see("stretch", RIGHT, released=True)], {}),
        ("push it left against a wall", [see("move", LEFT)], {"obstacles": [LEFT]}),
    ],
)
def test_a_word_with_its_trace_is_not(prompt, motions, more):
    """The same words where something that was read has what they say."""
    assert doubt(prompt, *motions, **more) == []


@pytest.mark.parametrize(
    ("prompt", "obstacles", "doubted"),
    [
        ("push it left against a wall", [], True), ("push it left", [LEFT], True),
        ("no wall, just push it left", [LEFT], True), ("no wall, just push it left", [], False),
        ("push it left, there is a wall on the left", [LEFT, RIGHT], True),
        ("walls left and right, push it left", [LEFT, RIGHT], False),
    ],
)  # fmt: skip
def test_walls_are_counted(prompt, obstacles, doubted):
    assert bool(doubt(prompt, see("move", LEFT), obstacles=obstacles)) == doubted


@pytest.mark.parametrize(
    ("prompt", "motions", "anchor", "doubted"),
    [
        ("it bows and exits left", [see("rotate", RIGHT, words="a"), see("move", LEFT, words="b")], None, True),
        ("it bows as it exits", [see("rotate", RIGHT, words="a"), see("move", LEFT, words="b")], None, False),
        ("it topples, slowly", [see("rotate", RIGHT, words="a"), see("fall", words="a")], None, False),
        ("it rises and sinks as told", [see("move", UP, words="a"), see("move", DOWN, words="b")], None, True),
        ("its arm and its leg rise", [see("move", UP, words="a", partial=True, part=LEFT),
                                      see("move", UP, words="b", partial=True, part=RIGHT)], None, False),
        ("swing, robot, swing", [see("sway", LEFT, (0, 20)), see("sway", LEFT, (20, 49))], None, True),
        ("swing, then swing", [see("sway", LEFT, (0, 20)), see("sway", LEFT, (20, 49))], None, False),
        ("it hangs and drops", [see("fall")], "top", True),
        ("it hangs and swings", [see("sway", LEFT)], "top", False),
        ("it leaps, nailed down", [see("move", UP, sudden=True)], "base", True),
        ("it is bent, nailed down", [see("move", LEFT)], "base", False),
    ],
)  # fmt: skip
def test_motions_that_do_not_go_together_are_told(prompt, motions, anchor, doubted):
    found = find_incoherences(tokenise(prompt), motions, anchor, ground().directions)
    assert bool(found) == doubted


def test_a_verb_that_no_clause_takes_up_is_told():
    """The grammar's own product with a clause taken away: its verb and its way are missed."""
    mentions = find_mentions("push it left, then spin it", NAMES)
    push, spin = (next(m for m in mentions if m.words == word) for word in ("push", "spin"))
    way = next(m for m in mentions if m.words == "left")
    both = [Clause(Join.THEN, push, modifiers=[way]), Clause(Join.THEN, spin)]
    assert find_unused(mentions, both) == []
    (text,) = find_unused(mentions, both[:1])
    assert "'spin'" in text
    headless = [Clause(Join.THEN, None, modifiers=[way]), Clause(Join.THEN, push), Clause(Join.THEN, spin)]
    (text,) = find_unused(mentions, headless)
    assert "'left'" in text


PARTS = {
    "push it to the left": ("pushing it to the left", "it is pushed to the left"),
    "lift it": ("lifting it", "it is lifted"),
    "shake its head": ("shaking its head", "its head is shaken"),
    "kick it to the right": ("kicking it to the right", "it is kicked to the right"),
    "spin it clockwise": ("spinning it clockwise", "it is spun clockwise"),
    "squash it to half its height": ("squashing it to half its height", "it is squashed to half its height"),
    "drop it": ("dropping it", "it is dropped"),
    "shove it away from us": ("shoving it away from us", "it is shoved away from us"),
}


def tell(prompt: str) -> list[tuple]:
    """The motions of a sentence in their order, without times; none where it is marked."""
    reply = read(prompt, ground())
    if reply.unsure:
        return []
    return [
        (m.kind, m.direction, m.partial, m.sudden, m.amount and m.amount.unit)
        for m in sorted(reply.expectations, key=lambda m: m.window)
    ]


@pytest.mark.parametrize(
    "pattern",
    [
        "{a}, then {b}", "after {ai}, {b}", "{b} after {ai}", "before {bi}, {a}", "once {ap}, {b}",
        "{a}; next, {b}", "{a}, wait half a second, then {b}", "{ap} first and then {bp}", "{b}, but first {a}",
        "{a}, and after a short pause {b}", "let a second pass, then {a} and after that {b}",
        "{a} until the middle of the clip, then {b}", "{a} and {b} at once",
    ],
)  # fmt: skip
def test_what_is_composed_means_its_parts_or_is_marked(pattern):
    """No composition of two clear sentences is read as something else than both, in their order."""
    for (a, (ai, ap)), (b, (bi, bp)) in itertools.permutations(PARTS.items(), 2):
        told = tell(pattern.format(a=a, b=b, ai=ai, bi=bi, ap=ap, bp=bp))
        told = [each for each in told if each[0] is not MotionKind.STILL]
        assert not told or told == tell(a) + tell(b), (pattern, a, b)


@pytest.mark.parametrize(
    "pattern",
    [
        "{a}, don't {b}", "don't {b}, {a}", "instead of {bi}, {a}", "{a} rather than {bi}", "do not {b} but {a}",
        "last time you had to {b}, now {a}", "{a} and do nothing more", "it turns out that {ap}",
        "{a} up in the attic", "{a} back in the nineties", "{a} as if to {b}",
    ],
)  # fmt: skip
def test_what_is_denied_or_elsewhere_is_left_out_or_marked(pattern):
    """Of two sentences only the one that is told to happen is read."""
    for (a, (ai, ap)), (b, (bi, bp)) in itertools.permutations(PARTS.items(), 2):
        told = tell(pattern.format(a=a, b=b, ai=ai, bi=bi, ap=ap, bp=bp))
        assert not told or told == tell(a), (pattern, a, b)


@pytest.mark.parametrize(
    ("unclear", "clear"),
    [
        ("throw it against the robot's friend", "throw it to the left"),
        ("blow on it, from where you are sitting", "blow on it from the left"),
        ("first gently, then hard, push it to the left", "first push it gently to the left, then hard"),
        ("push it up half its height and down again", "push it up half its height"),
        ("don't push it hard to the right, rock it", "don't push it to the right, rock it"),
        ("turn its right side toward the camera", "turn its head to the right"),
        ("the robot raises its left arm and lowers it again", "the robot raises its left arm"),
        ("put it down in the cellar", "put it down"),
    ],
)  # fmt: skip
def test_what_was_misread_is_marked(unclear, clear):
    assert read(unclear, ground()).unsure
    assert not read(clear, ground()).unsure


@pytest.mark.parametrize(
    ("unclear", "told", "clear"),
    [
        ("drag it past us", "told by 'past'", "drag it past us to the left"),
        ("push it gently to the left and hard", "'gently' and 'hard'", "push it gently to the left"),
        ("spin it clockwise, counterclockwise", "'clockwise' and", "spin it clockwise, then counterclockwise"),
        ("push it to the left and shake it at once", "'at once'", "push it to the left at once"),
        ("let a second pass, then push it to the left", "'pass'", "wait a second, then push it to the left"),
        ("nothing may move except the head, which nods", "part or of the rest",
         "nothing moves except its head, which nods"),
        ("push it to the left, not", "'not' denies", "push it to the left, not up"),
    ],
)  # fmt: skip
def test_the_mark_says_why(unclear, told, clear):
    """The sentence that tells what is unclear names the words; without them nothing is."""
    assert any(told in text for text in read(unclear, ground()).unsure)
    assert read(clear, ground()).unsure == ()


def test_a_jump_up_and_down_bobs_and_what_is_tossed_about_sways():
    """To and fro is one motion: nothing of it ends in a fall of its own."""
    for prompt, way in (("it jumps up and down", UP), ("it is tossed to and fro", LEFT)):
        (motion,) = read(prompt, ground()).expectations
        assert motion.kind is MotionKind.SWAY and motion.direction == way


def test_the_way_before_now_is_kept():
    """ "To the right now" is no "right now"."""
    assert tell("tip it over to the right now") == tell("tip it over to the right")


def test_what_is_not_hit_is_not_held():
    """A denied blow at a part holds nothing; a part that does not move is held."""
    assert read("don't hit it on the head, tilt it to the left", ground()).anchor.kind is None
    assert read("tilt it to the left, but its base does not tilt", ground()).anchor.kind == "base"
