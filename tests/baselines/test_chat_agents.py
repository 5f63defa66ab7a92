"""Agents that ask a chat model, on a task: what the model answers is all that acts."""

from __future__ import annotations

import pytest

from baselines.evaluation import Evaluator
from baselines.methods import make_method
from baselines.protocol import Budget
from physagent_jax.chat.registry import locate_model
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from tests.agents.llm.scripted import ScriptedModel, push
from tests.baselines.tiny import FRAMES, act, make_tiny_task

LEFT = {"motion": "push", "relation": "to", "word": "left"}
HARDER = {"reason": "too weak", "default_drop": False, "actions": [push(1.4)]}


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tiny")
    made = make_tiny_task(folder, act("translation", (-1, 0, 0), 1.2, (0, FRAMES - 1)), ForceField())
    made.spec.sentence = "push it to the left"
    return made


def run(task, model, **options):
    evaluator = Evaluator(task, Budget(6.0), oracle=False)
    make_method("chat_agents", dict(model=model, **options)).search(evaluator)
    return evaluator


def test_a_model_reads_and_its_calls_are_charged(task):
    model = ScriptedModel(LEFT)
    evaluator = run(task, model, rounds=1)
    (only,) = evaluator.evaluations
    assert only.force_field.actions and (evaluator.spent, evaluator.model_calls) == (1.0, 1)
    assert evaluator.tokens == 110
    assert "The force field library" not in model.system  # a clause is read in words


@pytest.mark.parametrize("skills", [True, False])
def test_no_rule_reads_in_a_models_place(task, skills):
    model = ScriptedModel(*["no idea"] * 9)
    with pytest.raises(UserError, match="no usable answer"):
        run(task, model, skills=skills)


def test_without_skills_a_model_has_the_schema_alone(task):
    model = ScriptedModel({"actions": [push(0.4)]}, HARDER)
    evaluator = run(task, model, skills=False, rounds=2)
    asked = [messages[0].text for messages in model.asked]
    assert len(asked) == 2 and not any("`torque`" in text or "hits the ground" in text for text in asked)
    assert [each.force_field.actions[0].magnitude for each in evaluator.evaluations] == [0.4, 1.4]


def test_without_skills_nothing_is_mended(task):
    """The hard rules would cut the magnitude to their range; here the schema sends it back."""
    wild = {"actions": [push(9.0)]}
    model = ScriptedModel(wild, {"actions": [push(1.0)]})
    evaluator = run(task, model, skills=False, rounds=1)
    assert evaluator.model_calls == 2 and evaluator.evaluations[0].force_field.actions[0].magnitude == 1.0


def test_rounds_end_where_a_model_has_no_other_answer(task):
    model = ScriptedModel({"actions": [push(0.4)]}, *["no idea"] * 9)
    assert len(run(task, model, skills=False).evaluations) == 1


@pytest.mark.parametrize(
    ("place", "name"),
    [("a/b.gguf", "llama"), ("told.jsonl", "replay"), ("http://localhost:8000/v1#small", "openai")],
)
def test_a_model_is_known_by_its_place(place, name):
    assert locate_model(place)[0] == name


@pytest.mark.parametrize("place", ["", "http://localhost:8000/v1"])
def test_a_place_without_a_model_is_refused(place):
    with pytest.raises(UserError):
        locate_model(place)
