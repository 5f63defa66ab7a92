"""Answers that fit a schema: what is read, what is refused, and how a model is asked again."""

import json
from typing import Literal

import pytest

from physagent_jax.agents.llm.structured import LONGEST_ANSWER, ask, extract_object
from physagent_jax.agents.trace import AgentError, Trace
from physagent_jax.chat.base import ChatMessage, Generation, ModelError, Usage
from physagent_jax.core.strict import Strict

PROMPT = (ChatMessage("system", "Read."), ChatMessage("user", "push it left", (b"\x89PNG",)))


class Push(Strict):
    """A push."""

    way: Literal["left", "right"]
    times: int = 1


class Answering:
    """Answers in turn; errors among the answers are raised."""

    name, has_eyes = "answering:1", True

    def __init__(self, *answers):
        self.answers, self.asked, self.schemas = list(answers), [], []

    def generate(self, messages, schema=None):
        self.asked.append(list(messages))
        self.schemas.append(schema)
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        if isinstance(answer, Generation):
            return answer
        return Generation(answer, None, Usage(100, 10), 0.5, "answering-2026")

    def close(self):
        pass


@pytest.mark.parametrize(
    "text",
    [
        '{"way": "left"}',
        '```json\n{"way": "left"}\n```',
        'Here you are: {"way": "left"} Good luck!',
        '<think>right? {"way": "right"}</think>{"way": "left"}',
        '<THINKING>\nright\n</THINKING>\n```\n{"way": "left"}```',
        'maybe right</think> {"way": "left"}',
        '{"way": "left"}{"way": "right"}',
        'In {words}: {"way": "left"}',
        '{\n "way" : "left" }',
    ],
)
def test_first_object_is_read(text):
    assert extract_object(text)[0] == {"way": "left"}


def test_what_is_left_out_is_told():
    assert extract_object('{"a": 1}')[1] == () == extract_object('```json\n{"a": 1}\n```')[1]
    assert "second object" in extract_object('{"a": 1} {"b": 2}')[1][0]
    assert "Thoughts" in extract_object('<think>x</think>{"a": 1}')[1][0]
    assert "Text around" in extract_object('Yes: {"a": 1}')[1][0]


def test_brackets_in_strings_are_no_brackets():
    value = {"a": 'brace } and "quote" \\', "b": {"c": "{"}}
    assert extract_object(f"x {json.dumps(value)} y")[0] == value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no JSON object"),
        ("left", "no JSON object"),
        ("{'way': 'left'}", "no JSON object"),
        ('[{"way": "left"}]', "list of objects"),
        ('{"way": "le', "ends within its JSON object"),
        ('{"a": [{"way": "left"}, {"b"', "ends within its JSON object"),
        ('{"way": "left",}', "not valid JSON"),
        ('{"a": NaN}', "NaN"),
        ('{"a": -Infinity}', "Infinity"),
        ('{"a": 1e999}', "too large"),
        ('{"a": ' * 2000 + "1" + "}" * 2000, "nested too deeply"),
        ('{"a": ' * 60_000, "not read"),
        ('<think>{"way": "left"}', "within its thoughts"),
        ('{"way": "\\ud800"}', "half a character"),
        ("x" * (LONGEST_ANSWER + 1), "not read"),
    ],
)
def test_anything_else_is_refused(text, words):
    """An inner object of half an answer among it: it is not what was asked for."""
    with pytest.raises(ValueError, match=words):
        extract_object(text)


def test_the_schema_is_stated_and_asked_for():
    model = Answering('{"way": "left"}')
    reply = ask(model, PROMPT, Push)
    assert reply.value == Push(way="left")
    system, user = model.asked[0]
    assert system.text.startswith("Read.") and '"enum":["left","right"]' in system.text
    assert user == PROMPT[1]
    assert model.schemas[0]["required"] == ["way"]
    assert reply.trace == Trace(
        model="answering-2026",
        messages=(*({"role": m.role, "text": m.text, "pictures": len(m.pictures)} for m in model.asked[0]),
                  {"role": "assistant", "text": '{"way": "left"}'}),
        raw_reply='{"way": "left"}',
        input_tokens=100,
        output_tokens=10,
        latency_seconds=0.5,
    )  # fmt: skip


def test_the_schema_can_be_left_to_the_prompt():
    model = Answering('{"way": "left"}')
    ask(model, PROMPT, Push, state_schema=False)
    assert model.asked[0] == list(PROMPT) and model.schemas[0] is not None


def test_a_refused_answer_is_asked_for_again_with_the_reason():
    model = Answering('{"way": "up", "speed": 3}', '{"way": "right", "times": 2}')
    reply = ask(model, PROMPT, Push)
    assert reply.value == Push(way="right", times=2)
    answer, order = model.asked[1][2:]
    assert answer == ChatMessage("assistant", '{"way": "up", "speed": 3}')
    assert "way: Input should be 'left' or 'right'" in order.text and "speed" in order.text
    trace = reply.trace
    assert [m.role for m in trace.messages] == ["system", "user", "assistant", "user", "assistant"]
    assert len(trace.validation_errors) == 1 and "way" in trace.validation_errors[0]
    assert (trace.input_tokens, trace.output_tokens, trace.latency_seconds) == (200, 20, 1.0)
    assert trace.raw_reply == '{"way": "right", "times": 2}'


def test_a_check_of_the_caller_refuses_too():
    def check(push):
        if push.times > 3:
            raise ValueError("at most 3 times")

    model = Answering('{"way": "left", "times": 9}', '{"way": "left", "times": 3}')
    assert ask(model, PROMPT, Push, validate=check).value.times == 3
    assert "at most 3 times" in model.asked[1][-1].text


def test_when_no_answer_fits_the_error_has_all_of_them():
    model = Answering("no", "", "never {")
    with pytest.raises(
        AgentError, match="answering:1 gave no usable answer in 3 tries: .*no JSON object"
    ) as caught:
        ask(model, PROMPT, Push)
    trace = caught.value.trace
    assert [m.text for m in trace.messages if m.role == "assistant"] == ["no", "", "never {"]
    assert len(trace.validation_errors) == 3 and trace.input_tokens == 300
    assert trace.messages[-1].role == "assistant"


def test_an_error_of_the_model_keeps_the_exchange_and_its_failures():
    error = ModelError("it is gone", do="Start it", latency_seconds=2.0, failures=("HTTP 500", "HTTP 500"))
    with pytest.raises(AgentError, match="it is gone. Start it.") as caught:
        ask(Answering("no", error), PROMPT, Push)
    trace = caught.value.trace
    assert trace.validation_errors[1:] == ("HTTP 500", "HTTP 500") and trace.latency_seconds == 2.5
    assert sum(m.role == "assistant" for m in trace.messages) == 1


def test_an_answer_that_was_cut_is_told_to_be_shorter():
    cut = Generation('{"way": "le', None, Usage(), 0.1, "m", failures=("HTTP 429",), cut=True)
    model = Answering(cut, '{"way": "left"}')
    reply = ask(model, PROMPT, Push)
    assert "limit of tokens" in model.asked[1][-1].text
    assert reply.trace.validation_errors[0] == "HTTP 429"


def test_a_long_answer_is_neither_kept_whole_nor_sent_back_whole():
    model = Answering("x" * 1_000_000, '{"way": "left"}')
    reply = ask(model, PROMPT, Push)
    assert len(model.asked[1][2].text) < 3_000
    assert len(reply.trace.model_dump_json()) < 50_000
