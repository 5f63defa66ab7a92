"""Forms that a model fills in: their conversion into an intent, and that the compiler knows all their words."""

import itertools
import json
import re
from importlib import resources
from typing import get_args

import pytest
from pydantic import ValidationError

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.intent import Relation
from physagent_jax.agents.llm.fields import PaperForm, build_field, expect_motions
from physagent_jax.agents.llm.forms import (
    MOTIONS,
    PARTS,
    ClauseForm,
    SentenceForm,
    check_words,
    join_clauses,
    list_motions,
    make_intent,
)
from physagent_jax.agents.llm.splitting import split_clauses
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.skills import register_skill, unregister_skill
from physagent_jax.forces.skills.impulse import Impulse
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief

ROBOT = brief(world="ground", frames_fixed=False)
KINDS = {
    "push": "move", "pull": "move", "blow": "move", "lift": "move", "lower": "move", "hit": "move", "throw": "move",
    "jump": "move", "roll": "move rotate", "bend": "move rotate", "topple": "fall rotate move",
    "sway": "sway", "shake": "sway", "stretch": "stretch", "swell": "stretch", "explode": "stretch move",
    "squeeze": "squeeze", "flatten": "squeeze", "shrink": "squeeze", "spin": "rotate", "twist": "rotate",
    "flip": "rotate", "fall": "fall", "stand still": "still",
}  # fmt: skip
"""Kinds of motion of which one has to be seen, after what each motion is said to cover."""


def compile_one(*forms: dict) -> SemanticReply:
    filled = [ClauseForm.model_validate(form) for form in forms]
    texts = [form["motion"] for form in forms]
    return compile_intent(join_clauses(filled, texts, ["then"] * len(forms)), ROBOT)


@pytest.mark.parametrize("motion", KINDS)
def test_the_compiler_makes_of_every_motion_what_the_model_is_told_of_it(motion):
    reply = compile_one({"motion": motion, "word": "left"} if "move" in KINDS[motion] else {"motion": motion})
    assert {each.kind.value for each in reply.expectations} & set(KINDS[motion].split())
    assert not reply.not_understood


def test_letting_go_ends_what_acted_before():
    reply = compile_one({"motion": "stretch"}, {"motion": "let go"})
    assert reply.expectations[0].kind is MotionKind.STRETCH and reply.expectations[0].released
    assert set(MOTIONS) == {*KINDS, "let go"}


WAYS = {"left": (-1, 0, 0), "right": (1, 0, 0), "up": (0, 0, 1), "down": (0, 0, -1), "toward": (0, -1, 0)}


@pytest.mark.parametrize("word", WAYS)
def test_to_and_from_are_opposite_ways(word):
    to = compile_one({"motion": "push", "relation": "to", "word": word}).expectations[0]
    come = compile_one({"motion": "push", "relation": "from", "word": word}).expectations[0]
    assert to.direction == pytest.approx(WAYS[word])
    assert come.direction == pytest.approx([-c for c in WAYS[word]])


def test_two_directions_are_added():
    (motion,) = compile_one({"motion": "push", "word": "up", "and_word": "left"}).expectations
    assert motion.direction == pytest.approx((-(0.5**0.5), 0, 0.5**0.5))


def test_every_line_and_side_is_known():
    words = [
        word for word in get_args(get_args(ClauseForm.model_fields["word"].annotation)[0]) if word not in WAYS
    ]
    for motion, word in itertools.product(("stretch", "squeeze"), words):
        if word in ("away", "back"):
            continue
        relation = "from" if word.endswith("sides") else "to" if word.endswith("ward") else "along"
        reply = compile_one({"motion": motion, "relation": relation, "word": word})
        assert reply.expectations[0].kind.value == motion and not reply.not_understood, word


@pytest.mark.parametrize("part", PARTS)
def test_every_part_is_a_part(part):
    (motion,) = compile_one({"motion": "push", "word": "left", "part": part}).expectations
    assert motion.partial
    ends = {"top": (0, 0, 1), "bottom": (0, 0, -1), "left": (-1, 0, 0), "right": (1, 0, 0), "front": (0, -1, 0),
            "back": (0, 1, 0), "middle": None}  # fmt: skip
    assert motion.part == (None if ends[part] is None else pytest.approx(ends[part]))


def test_strengths_rise():
    found = [
        compile_one({"motion": "push", "word": "left", "strength": each}).expectations[0].strength
        for each in ("gentle", "plain", "strong", "violent")
    ]
    assert found == sorted(set(found)) and found[1] == 1.0 and found[-1] == 1.6


def test_amounts_times_and_settings():
    (turn,) = compile_one({"motion": "spin", "number": 90, "unit": "degrees"}).expectations
    assert turn.amount is not None and (turn.amount.value, turn.amount.unit) == (90, "degrees")
    (longer,) = compile_one({"motion": "stretch", "number": 2, "unit": "times"}).expectations
    assert longer.amount is not None and (longer.amount.value, longer.amount.unit) == (2, "factor")
    (late,) = compile_one({"motion": "push", "word": "left", "starts": 1, "lasts": 0.4}).expectations
    assert late.window[0] == pytest.approx(25, abs=1)
    (swing,) = compile_one({"motion": "sway", "times": 3}).expectations
    assert swing.repeats == 3
    assert compile_one({"motion": "spin", "setting": "no gravity"}).world.gravity == "none"
    assert (
        compile_one({"motion": "push", "word": "left", "setting": "held at its base"}).anchor.kind == "base"
    )
    (wall,) = compile_one({"motion": "push", "word": "right", "wall": "right"}).world.obstacles
    assert wall.direction == pytest.approx((1, 0, 0))


def test_what_a_model_writes_for_not_said_is_left_out():
    said = {"motion": "push", "word": "none", "part": None, "turning": "", "strength": "plain"}
    assert ClauseForm.model_validate(said) == ClauseForm(motion="push")
    for wrong in (
        {"motion": "dance"},
        {"motion": "push", "vector": [1, 0, 0]},
        {"motion": "push", "number": -1},
    ):
        with pytest.raises(ValidationError):
            ClauseForm.model_validate(wrong)


def test_a_whole_sentence():
    form = SentenceForm.model_validate(
        {
            "clauses": [
                {"words": "push it left", "motion": "push", "word": "left"},
                {"words": "spin", "motion": "spin", "order": "together"},
                {"words": "a red light", "motion": "nothing"},
            ],
            "material": "jelly",
            "unclear": ["sashay"],
        }
    )
    intent = make_intent(form)
    assert [(each.motion, each.order, each.text) for each in intent.clauses] == [
        ("push", "then", "push it left"),
        ("spin", "together", "spin"),
    ]
    assert intent.clauses[0].ways[0].relation is Relation.TO
    assert (intent.materials, intent.unknown, intent.ignored) == (("jelly",), ("sashay",), ("a red light",))


def test_an_invented_clause_is_refused():
    said = "push it to the left, gently"
    for words, fault in (("push it left, Gently!", None), ("then twist it", "'then'"), ("!", "empty")):
        form = SentenceForm.model_validate({"clauses": [{"words": words, "motion": "push"}]})
        if fault is None:
            check_words(form, said)
        else:
            with pytest.raises(ValueError, match=fault):
                check_words(form, said)


def list_examples(name: str) -> list[tuple[str, str]]:
    """Sentences of a prompt's examples with their answers."""
    text = resources.files("physagent_jax.agents.llm").joinpath("prompts", f"{name}.md").read_text("utf-8")
    return re.findall(r'^"(.+)" ->\s(\{.+\})$', text, re.MULTILINE)


def test_the_examples_of_the_prompts_are_answers_that_fit():
    whole, single = list_examples("semantic"), list_examples("semantic_clause")
    assert len(whole) == 4 and len(single) == 8
    for sentence, answer in whole:
        form = SentenceForm.model_validate_json(answer)
        check_words(form, sentence)
        if form.clauses:
            reply = compile_intent(make_intent(form), ROBOT)
            assert reply.expectations and not reply.unsure, sentence
    for clause, answer in single:
        intent = join_clauses([ClauseForm.model_validate_json(answer)], [clause], ["then"])
        assert not intent.clauses or not compile_intent(intent, ROBOT).unsure, clause


@pytest.mark.parametrize(
    ("sentence", "pieces"),
    [
        ("push it up and to the left", ["push it up and to the left"]),
        ("push it left, then right", ["push it left", "right"]),
        ("squeeze it from top and bottom, hard", ["squeeze it from top and bottom, hard"]),
        ("lift it 1.5 metres. Twist it", ["lift it 1.5 metres", "Twist it"]),
        ("it rises while spinning", ["it rises", "+spinning"]),
        ("it rises and spins", ["it rises", "+spins"]),
        ("spin it after pushing it left", ["pushing it left", "spin it"]),
        ("before it falls, shake it", ["shake it", "it falls"]),
        ("after a kick it flies, and then drops", ["a kick it flies", "drops"]),
        ("as hard as possible push it", ["as hard as possible push it"]),
        ("push it", ["push it"]),
        (",,", [",,"]),
    ],
)
def test_a_sentence_is_cut_into_clauses_in_the_order_of_time(sentence, pieces):
    found = split_clauses(sentence)
    assert [("+" if order == "together" else "") + text for text, order in found] == pieces


def test_the_papers_form_is_mended_by_the_hard_rules():
    text = json.dumps(
        {
            "default_drop": False,
            "gravity": 3,
            "actions": [
                {"action_type": "translation", "vector": [-3, 0, 0], "magnitude": 9, "active_time": [10, 90]},
                {"action_type": "scale", "vector": [0, 0, 1], "magnitude": -1, "path": "/etc"},
                {"action_type": "torque", "vector": [0, 0, 0], "magnitude": 1},
            ],
        }
    )
    field, repairs = build_field(PaperForm.model_validate_json(text), brief())
    assert [(a.magnitude, a.active_time) for a in field.actions] == [(1.6, (10, 48)), (-1, None)]
    assert {each.rule for each in repairs} == {
        "known_skills",
        "unit_vectors",
        "magnitude_range",
        "window_in_clip",
    }
    push, press = expect_motions(field, brief())
    assert (push.kind, push.direction, push.window) == (MotionKind.MOVE, (-1, 0, 0), (10, 48))
    assert press.kind is MotionKind.SQUEEZE
    (fall,) = expect_motions(build_field(PaperForm(default_drop=True, actions=()), brief())[0], brief())
    assert fall.kind is MotionKind.FALL


@pytest.mark.parametrize(("word", "name"), [("vortex", "vortex"), ("gust", "wind_gust")])
def test_a_skill_is_reached_by_its_own_word(word, name):
    assert word in list_motions()
    reply = compile_one({"motion": word, "word": "left"} if word == "gust" else {"motion": word})
    assert [action.action_type.value for action in reply.force_field.actions] == [name]
    field, repairs = build_field(
        PaperForm.model_validate({"actions": [{"action_type": name, "vector": [0, 0, 1]}]}), ROBOT
    )
    assert not repairs and expect_motions(field, ROBOT)[0].kind is reply.expectations[0].kind


def test_a_skill_that_is_registered_later_reaches_the_form_and_its_schema():
    class Blast(Impulse):
        name, nouns, verbs = "blast_wave", ("blast wave",), ()

    register_skill(Blast())
    try:
        assert "blast wave" in ClauseForm.model_json_schema()["properties"]["motion"]["enum"]
        assert ClauseForm(motion="blast wave").motion == "blast wave"
        assert "blast_wave" in str(PaperForm.model_json_schema())
    finally:
        unregister_skill("blast_wave")
    with pytest.raises(ValidationError):
        ClauseForm(motion="blast wave")
