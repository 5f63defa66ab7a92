"""Holds against motions: single motions, and every sentence of the corpus."""

from __future__ import annotations

import functools

import pytest

from benchmarks.language.notation import Clause, Sentence, read_split
from benchmarks.language.score import make_scene, score
from benchmarks.language.totals import REQUIRED
from physagent_jax.agents.grammar.semantic import read_sentence
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.motion.holds import (
    Hold,
    HoldOrigin,
    describe_yielding,
    find_impossible,
    find_leaving,
    refuse_impossible,
)
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.run.holding import UP, find_hold
from physagent_jax.run.reading import Release, read_let_go
from physagent_jax.run.spec import AnchorChoice
from tests.agents.scenes import asked, brief

ROOTED = brief(object_name="plant", object_kind="plant", anchored="it is rooted", world="ground")
BASE = Hold("base", HoldOrigin.OPTION)

LEAVES = [
    "drop the plant",
    "the plant falls over to the right",
    "throw the plant to the left",
    "throw the plant into the air",
    "launch the plant to the left",
    "lift the plant",
    "pick up the plant, carry it to the left, and set it down",
    "the plant jumps three times",
    "kick the plant upwards",
    "roll the plant to the right",
    "turn the plant over",
    "spin the plant",
    "rotate the plant by 90 degrees",
    "push the plant 30 cm to the left",
    "slide the plant to the left",
    "move the plant away from us",
    "the plant is carried to the right",
    "let go of the plant",
    "push the plant away",
    "shove the plant aside",
    "push the plant out of the way",
    "push the plant off the table",
    "drag the plant across the floor",
    "drag the plant to the other side",
    "pull the plant closer",
    "pull the plant away from the wall",
    "pull the plant over here",
    "shove the plant into the corner",
    "carry the plant off",
    "haul the plant away",
    "slide the plant across the table",
    "slide the plant off the table",
    "move the plant out of the way",
    "the plant is pushed aside",
    "the plant is dragged off to the left",
    "a hand pushes the plant away to the left",
    "push the plant slowly away to the right",
    "someone shoves the plant away, then it stands still",
    "push the plant to the left, out of the picture",
    "push the plant out of the frame",
    "pull the plant off to the side",
    "drag the plant to the left",
    "kick the plant away",
    "pull the plant closer to the camera",
    "push away the plant",
]
KEEPS = [
    "a strong wind bends the plant to the left",
    "a storm blows the plant to the left",
    "bend the plant 30 degrees to the left",
    "bend the plant 10 cm to the left",
    "push the plant to the left",
    "pull the plant towards us",
    "the wind moves the plant to the left",
    "the plant moves",
    "push the plant to the left three times",
    "hit the plant from the right",
    "the plant sways in the wind",
    "shake the plant",
    "stretch the plant upwards",
    "squash the plant",
    "twist the plant",
    "lift the top of the plant",
    "turn the top of the plant by 90 degrees",
    "the plant droops",
    "the plant bobs up and down",
    "the plant sways but does not fall over",
    "the plant is still",
    "push the plant away from the camera",
    "push the plant away from us",
    "pull the plant towards the camera",
    "push the plant backwards",
    "push the plant to the side",
    "bend the plant away",
    "bend the plant away from the wall",
    "the plant leans away from us",
    "lean the plant away from the window",
    "the plant bends aside",
    "the plant sways off to the left and back",
    "a wind pushes the plant to the left",
    "a wind pushes the plant away from us",
    "a breeze blows the plant aside",
    "push the top of the plant away",
    "push the leaves aside",
    "push the plant away, then let it spring back",
    "pull the plant aside and let it swing back",
    "push the plant back and forth",
    "pull the plant to the left and let go",
    "gently nudge the plant to the left",
    "do not push the plant away",
    "stretch the plant away from the ground",
    "twist the plant away from the camera",
    "the plant bends out of the way",
    "drag the plant to the left, then release it",
    "push the plant off balance",
    "push the plant out of shape",
    "a hand from off screen pushes the plant to the left",
    "push the plant into a bow",
]


def expect(kind: MotionKind, **values) -> ExpectedMotion:
    return ExpectedMotion(kind=kind, window=(0, 48), **values)


def plan(*motions: ExpectedMotion, **field) -> tuple[ExpectedMotion, ...]:
    return SemanticReply(force_field=ForceField(**field), expectations=motions).plan


@pytest.mark.parametrize("sentence", LEAVES)
def test_what_falls_rises_flies_or_turns_needs_the_object_free(sentence):
    assert find_leaving(read_sentence(sentence, ROOTED).plan, UP) is not None


@pytest.mark.parametrize("sentence", KEEPS)
def test_what_bends_sways_stretches_or_twists_keeps_the_hold(sentence):
    assert find_leaving(read_sentence(sentence, ROOTED).plan, UP) is None


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot jumps forward and stays there",
        "knock the robot over, it stays like that",
        "the robot slides to the left and stops, still standing there",
    ],
)
def test_what_stays_where_it_went_is_held_by_nobody(sentence):
    """Its base was held from the start, and it could not go there."""
    reply = read_sentence(sentence, brief(world="ground"))
    assert reply.anchor.kind is None
    assert [each.kind for each in reply.expectations].count(MotionKind.STILL) == 1


def test_up_is_where_gravity_does_not_pull():
    """The same move is a lift in one scene and a push in another."""
    move = plan(expect(MotionKind.MOVE, direction=(0, 1, 0)))
    assert find_leaving(move, (0.0, 1.0, 0.0)) and not find_leaving(move, UP)


def test_a_plan_without_expectations_is_judged_by_its_force_field():
    """Models may give none."""
    up = Action(action_type=ActionType.TRANSLATION, vector=(0, 0, 1), magnitude=1.0)
    left = up.model_copy(update={"vector": (-1.0, 0.0, 0.0)})
    assert find_leaving(plan(default_drop=True), UP) and find_leaving(plan(actions=(up,)), UP)
    assert not find_leaving(plan(actions=(left,)), UP) and not find_leaving(plan(), UP)
    still = expect(MotionKind.STILL)  # what the sentence says goes before gravity that it names
    assert not find_leaving(plan(still, default_drop=True), UP)


@pytest.mark.parametrize(
    ("motion", "impossible"),
    [
        (expect(MotionKind.FALL), True),
        (expect(MotionKind.FALL, partial=True), False),
        (expect(MotionKind.MOVE, direction=(0, 0, 1), sudden=True), True),
        (expect(MotionKind.MOVE, direction=(-1, 0, 0), sudden=True, leaves_place=True), True),
        (expect(MotionKind.MOVE, direction=(-1, 0, 0), sudden=True), False),
        (expect(MotionKind.MOVE, direction=(0, 0, 1)), False),  # it is stretched
        (expect(MotionKind.ROTATE, direction=(0, 0, 1)), False),  # it is twisted
        (expect(MotionKind.ROTATE, direction=(0, 1, 0), amount={"value": 180, "unit": "degrees"}), True),
        (expect(MotionKind.SWAY, direction=(1, 0, 0), repeats=3), False),
    ],
)
def test_what_a_held_object_cannot_do(motion, impossible):
    assert (find_impossible(BASE, plan(motion), UP) is not None) == impossible


def test_an_impossible_motion_is_refused_with_both_ways_out():
    said = Hold("base", HoldOrigin.SENTENCE, "hold base")
    throw = plan(expect(MotionKind.MOVE, direction=(0, 0, 1), sudden=True, words="throw"))
    with pytest.raises(UserError, match=r"'throw' is impossible .* held at its base .*'hold base'") as caught:
        refuse_impossible(said, throw, UP, whole=False)
    assert "nothing holds it" in caught.value.do and "bend" in caught.value.do
    push = plan(expect(MotionKind.MOVE, direction=(1, 0, 0), words="push"))
    refuse_impossible(said, push, UP, whole=False)
    with pytest.raises(UserError, match="held as a whole"):
        refuse_impossible(said, push, UP, whole=True)
    refuse_impossible(said, plan(expect(MotionKind.STILL)), UP, whole=True)


def test_a_lift_of_what_is_held_is_said_to_stretch_it():
    lift = plan(expect(MotionKind.MOVE, direction=(0, 0, 1), words="lift"))
    assert "only stretch" in str(describe_yielding(BASE, lift, UP))
    assert describe_yielding(BASE, plan(expect(MotionKind.MOVE, direction=(1, 0, 0))), UP) is None


@pytest.mark.parametrize(
    ("choice", "sentence", "origin"),
    [
        ("auto", "drop it", HoldOrigin.KIND),
        ("auto", "drop the potted plant", HoldOrigin.KIND),
        ("auto", "hold the pot and throw it", HoldOrigin.SENTENCE),
        ("auto", "a plant hanging from the ceiling swings", HoldOrigin.SENTENCE),
        ("auto", "uproot the plant and throw it", None),
        ("base", "drop it", HoldOrigin.OPTION),
        ("none", "hold the pot and throw it", None),
    ],
)
def test_who_holds_it(choice, sentence, origin):
    hold = find_hold(AnchorChoice(kind=choice), "plant", read_sentence(sentence, ROOTED).anchor)
    assert (hold and hold.origin) == origin


# The corpus


@functools.cache
def settle_all() -> list[tuple[Sentence, SemanticReply, Hold | None]]:
    """Every sentence that is read, its settled plan, and what holds the object then.

    Every object is rooted as plants are, whatever its kind. Where the sentence itself holds another kind, the plan is
    the one of that kind, and so is the hold.
    """
    settled = []
    for sentence in [each for split in REQUIRED for each in read_split(split)]:
        scene = make_scene(sentence.object_name).model_copy(update={"anchored": "rooted"})
        try:
            reply = read_sentence(sentence.text, scene)
        except UserError:
            continue
        kind = scene.object_kind if reply.anchor.kind in ("base", "top") else "plant"
        hold = find_hold(AnchorChoice(), kind, reply.anchor)
        motion = find_leaving(reply.plan, UP)
        if hold and hold.origin is HoldOrigin.KIND and motion:
            free = asked(sentence.text, scene.model_copy(update={"anchored": None}))
            reply = read_let_go(Reply(reply), Release(motion, hold, False), free, _read).value
            hold = find_hold(AnchorChoice(), kind, reply.anchor)
        settled.append((sentence, reply, hold))
    return settled


def _read(context) -> Reply[SemanticReply]:
    return Reply(read_sentence(context.prompt, context.brief))


def test_no_plan_of_the_corpus_holds_by_the_kind_what_it_needs_free():
    """Nor does one leave a fall or a leap unsaid that the sentence's own hold makes impossible."""
    settled = settle_all()
    assert len(settled) > 2000 and sum(hold is None for _, _, hold in settled) > 600
    for sentence, reply, hold in settled:
        whole = [each for each in reply.expectations if not each.partial and each.part is None]
        falls = any(each.kind is MotionKind.FALL for each in whole)
        leaps = any(
            each.kind is MotionKind.MOVE and each.sudden and each.direction and each.direction[2] > 0.9
            for each in whole
        )
        if hold is None or not falls and not leaps:
            continue
        assert hold.origin is HoldOrigin.SENTENCE, sentence.text
        if hold.place == "base" or falls:
            with pytest.raises(UserError, match="impossible"):
                refuse_impossible(hold, reply.plan, UP, whole=False)


def test_holds_are_what_the_authors_of_the_corpus_understand():
    """If every object were rooted: free in all that they take for a fall or a rise, held in all that only bends.

    A sentence whose motions are misread says nothing about holds.
    """
    counts, wrong = {True: 0, False: 0}, []
    for sentence, reply, hold in settle_all():
        needed = _is_free_for_author(sentence)
        fixed = hold and hold.origin is not HoldOrigin.KIND
        if needed is None or reply.unsure or fixed or not _are_motions_right(sentence, reply):
            continue
        counts[needed] += 1
        if (hold is None) != needed:
            wrong.append(sentence)
    assert not wrong, [each.text for each in wrong if each.split != "test"]
    assert counts[True] > 150 and counts[False] > 350


def _are_motions_right(sentence: Sentence, reply: SemanticReply) -> bool:
    fields = score(sentence, reply, make_scene(sentence.object_name))
    return all(right for name, right in fields if name != "anchor")


def _is_free_for_author(sentence: Sentence) -> bool | None:
    """Return whether its author lets the object go in all readings, or holds it in all; None if they leave it open."""
    readings = [[clause for group in each.groups for clause in group] for each in sentence.readings]
    anchors = {each.anchor for each in sentence.readings}
    if any(each.answer != "motion" for each in sentence.readings):
        return None
    if all(any(map(_leaves, clauses)) for clauses in readings) and not anchors & {"base", "top"}:
        return True
    if all(all(map(_bends, clauses)) for clauses in readings) and "none" not in anchors:
        return False
    return None


def _leaves(clause: Clause) -> bool:
    rises = clause.kind in ("hit", "move") and clause.direction == "up"
    return not clause.part and (clause.kind == "fall" or rises)


def _bends(clause: Clause) -> bool:
    return bool(clause.part) or clause.kind in ("sway", "lean", "stretch", "squeeze", "still")
