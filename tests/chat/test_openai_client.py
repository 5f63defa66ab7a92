"""The client of compatible servers, against a real one on loopback."""

import base64
import email.utils
import json
import threading
import time

import pytest

pytest.importorskip("openai", reason="the extra `llm` is not installed")

from benchmarks.agents.server import Answer, ScriptedServer, complete
from physagent_jax.chat.base import ChatMessage, ModelError
from physagent_jax.chat.openai_client import COMMON_KEY, LONGEST_BODY, OWN_KEY, OpenAIModel
from physagent_jax.core.errors import UserError

KEY = "sk-test-0123456789abcdef"
ASKED = [ChatMessage("system", "Be brief."), ChatMessage("user", "left or right?")]
OPEN = {"type": "object", "properties": {"way": {"type": "string"}}}
CLOSED = {**OPEN, "required": ["way"], "additionalProperties": False}


@pytest.fixture(autouse=True)
def key(monkeypatch):
    for name in (COMMON_KEY, "OPENAI_BASE_URL"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(OWN_KEY, KEY)


class Asked:
    """Some requests and their outcomes: answers or errors, the server and the pauses."""

    def __init__(self, *answers, times=1, schema=None, messages=ASKED, **options):
        self.pauses, self.outcomes = [], []
        with ScriptedServer(lambda _, number: answers[min(number, len(answers) - 1)]) as self.server:
            model = OpenAIModel(**{"model": "m", "url": self.server.url, "timeout": 20.0, **options})
            model.sleep = self.pauses.append
            for _ in range(times):
                try:
                    self.outcomes.append(model.generate(messages, schema))
                except ModelError as error:
                    self.outcomes.append(error)
            model.close()
        self.requests, self.outcome = self.server.requests, self.outcomes[-1]


def test_what_is_sent_and_what_comes_back():
    asked = Asked(complete('{"way": "left"}'), max_tokens=77, seed=5)
    answer = asked.outcome
    assert (answer.text, answer.parsed, answer.model) == ('{"way": "left"}', {"way": "left"}, "scripted")
    assert (answer.usage.input_tokens, answer.usage.output_tokens) == (11, 7)
    assert answer.latency_seconds > 0 and answer.failures == () and not answer.cut
    assert asked.requests == [
        {
            "model": "m",
            "messages": [{"role": m.role, "content": m.text} for m in ASKED],
            "temperature": 0.0,
            "max_tokens": 77,
            "seed": 5,
        }
    ]
    headers = {name.lower(): value for name, value in asked.server.headers[0].items()}
    assert headers["authorization"] == f"Bearer {KEY}" and headers["accept-encoding"] == "identity"


def test_a_schema_is_asked_of_the_server_and_strict_only_where_it_can_be():
    for schema, strict in ((OPEN, False), (CLOSED, True)):
        (request,) = Asked(complete("{}"), schema=schema).requests
        asked = {"name": "answer", "schema": schema, "strict": strict}
        assert request["response_format"] == {"type": "json_schema", "json_schema": asked}


def test_pictures_go_as_data_urls():
    picture = b"\x89PNG\r\n\x1a\n 123"
    (request,) = Asked(complete(""), messages=[ChatMessage("user", "see", (picture,))], eyes=True).requests
    text, image = request["messages"][0]["content"]
    assert text == {"type": "text", "text": "see"}
    head, data = image["image_url"]["url"].split(",")
    assert head == "data:image/png;base64" and base64.b64decode(data) == picture


def refusal(words, status=400):
    return Answer(json.dumps({"error": {"message": words}}).encode(), status)


@pytest.mark.parametrize("status", [400, 404, 422])
def test_a_server_without_schemas_is_asked_for_plain_json_and_then_for_text(status):
    """The next request does not try again what it rejected."""
    answers = [refusal("unknown response_format", status)] * 2 + [complete("{}")]
    asked = Asked(*answers, times=2, schema=OPEN)
    formats = [request.get("response_format", {}).get("type") for request in asked.requests]
    assert formats == ["json_schema", "json_object", None, None]
    assert [len(outcome.failures) for outcome in asked.outcomes] == [2, 0]
    assert asked.pauses == []


def test_parameters_that_a_model_rejects_are_left_out():
    answers = [
        refusal("Unsupported parameter: 'max_tokens'. Use 'max_completion_tokens' instead."),
        refusal("'temperature' does not support 0.0"),
        complete("yes"),
    ]
    asked = Asked(*answers, max_tokens=9)
    last = asked.requests[-1]
    assert asked.outcome.text == "yes" and last["max_completion_tokens"] == 9
    assert "max_tokens" not in last and "temperature" not in last


def test_a_rejection_of_anything_else_is_final():
    asked = Asked(refusal("the context is too long"), schema=None)
    assert len(asked.requests) == 1 and "HTTP 400" in str(asked.outcome)
    assert "context is too long" in str(asked.outcome)


@pytest.mark.parametrize("status", [408, 429, 500, 502, 503])
def test_busy_servers_are_asked_again_with_growing_pauses(status):
    asked = Asked(Answer(b"busy", status), retries=5)
    assert len(asked.requests) == 6
    assert asked.pauses == [0.5, 1.0, 2.0, 4.0, 8.0]
    assert "in 6 attempts" in str(asked.outcome) and f"HTTP {status}: busy" in str(asked.outcome)
    assert len(asked.outcome.failures) == 6


def test_the_answer_after_a_failure_says_so():
    asked = Asked(Answer(b"", 500), complete("yes"))
    assert asked.outcome.text == "yes" and asked.outcome.failures == ("HTTP 500",)


def test_pauses_that_a_server_asks_for_are_kept():
    asked = Asked(Answer(b"", 429, (("Retry-After", "7"),)), complete("yes"))
    assert asked.pauses == [7.0]
    when = email.utils.formatdate(time.time() + 50, usegmt=True)
    (pause,) = Asked(Answer(b"", 503, (("Retry-After", when),)), complete("yes")).pauses
    assert 0 < pause <= 50
    past = email.utils.formatdate(0, usegmt=True)
    assert Asked(Answer(b"", 429, (("Retry-After", past),)), complete("yes")).pauses == [0.0]
    assert Asked(Answer(b"", 429, (("Retry-After", "soon"),)), complete("yes")).pauses == [0.5]


def test_a_server_that_asks_to_wait_too_long_is_not_waited_for():
    asked = Asked(Answer(b"", 429, (("Retry-After", "3600"),)))
    assert asked.pauses == [] and "asks to wait 3600 s" in str(asked.outcome)


def test_a_spent_account_is_not_asked_again():
    assert len(Asked(refusal("insufficient_quota", 429)).requests) == 1


def test_silence_ends_at_the_time_out():
    asked = Asked(Answer(manner="silent"), timeout=0.05, retries=5)
    assert asked.outcome.failures == ("no answer within 0.05 s",) * 2  # one more try, not five


def test_an_answer_drop_by_drop_ends_at_the_time_out():
    """Each byte comes in time; the whole does not."""
    begun = time.monotonic()
    asked = Asked(Answer(complete("x" * 5_000).body, manner="drip"), timeout=0.2, retries=0)
    assert "no answer within 0.2 s" in str(asked.outcome)
    assert time.monotonic() - begun < 60  # the whole would take 100 s


def test_half_an_answer_is_one_clear_error():
    whole = complete("x" * 1_000).body
    asked = Asked(Answer(whole, manner="half"), retries=1)
    assert len(asked.requests) == 2 and "the connection failed" in str(asked.outcome)
    asked = Asked(Answer(whole, announced=40))
    assert len(asked.requests) == 1 and "no whole chat completion" in str(asked.outcome)


@pytest.mark.parametrize("status", [200, 500])
def test_a_body_without_end_is_not_read(status):
    asked = Asked(Answer(b"x" * (LONGEST_BODY + 1), status), retries=0)
    assert "more than 4,194,304 bytes" in str(asked.outcome)
    assert sum(map(len, asked.outcome.failures)) < 500


def test_redirections_are_not_followed():
    with ScriptedServer(lambda *_: complete("yes")) as other:
        asked = Asked(Answer(b"", 307, (("Location", f"{other.url}/chat/completions"),)))
        assert "HTTP 307" in str(asked.outcome) and other.requests == []


@pytest.mark.parametrize(
    "answer",
    [
        refusal(f"bad key {KEY}", 401),
        refusal("x" * 290 + KEY, 500),  # where an excerpt would end within the key
        Answer(f"<html>{KEY}".encode()),
        Answer(b"x" * 110 + KEY.encode()),
        complete("yes", model=KEY),
        complete(f"the key is {KEY}"),
        Answer(complete(KEY).body.replace(b"sk-", b"\\u0073k-")),  # spelt with an escape
    ],
)
def test_the_key_is_in_nothing_that_comes_back(answer):
    outcome = Asked(answer, retries=0).outcome
    told = [repr(outcome), str(outcome), *outcome.failures]
    assert not any(KEY[:12] in text for text in told)


def test_the_key_comes_from_the_environment_alone(monkeypatch):
    monkeypatch.setenv(COMMON_KEY, "sk-common-0123456789")
    monkeypatch.delenv(OWN_KEY)
    asked = Asked(complete(""))
    assert "sk-common-0123456789" in str(asked.server.headers[0])
    with pytest.raises(ValueError, match="api_key"):
        OpenAIModel(model="m", url="http://127.0.0.1:1/v1", api_key="sk")
    monkeypatch.setenv(OWN_KEY, "two words")
    with pytest.raises(UserError, match="characters that no key can have") as caught:
        OpenAIModel(model="m")
    assert "two words" not in str(caught.value)


def test_the_common_key_goes_to_no_other_machine_without_encryption(monkeypatch):
    from physagent_jax.chat.openai_client import read_key

    monkeypatch.delenv(OWN_KEY)
    monkeypatch.setenv(COMMON_KEY, "sk-common-0123456789")
    assert read_key(None) == read_key("https://example.org/v1") == read_key("http://localhost:8000/v1") != ""
    assert read_key("http://192.0.2.1:8000/v1") == ""
    monkeypatch.setenv(OWN_KEY, KEY)
    assert read_key("http://192.0.2.1:8000/v1") == KEY


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("127.0.0.1:8000", "cannot be used"),
        ("ftp://127.0.0.1/v1", "cannot be used"),
        ("http://", "cannot be used"),
        ("http://[::1", "cannot be used"),
        ("http://host:port/v1", "cannot be used"),
        ("http://me:secret@host/v1", "holds a password"),
        ("http://host/v1?key=secret", "holds a password or a query"),
    ],
)
def test_addresses_that_cannot_be_used_are_refused(url, words):
    with pytest.raises(UserError, match=words) as caught:
        OpenAIModel(model="m", url=url)
    assert "secret" not in str(caught.value)


def test_the_address_may_come_from_the_environment(monkeypatch):
    with ScriptedServer(lambda *_: complete("yes")) as server:
        monkeypatch.setenv("OPENAI_BASE_URL", server.url)
        model = OpenAIModel(model="m")
        assert model.generate(ASKED).text == "yes"
        model.close()
    monkeypatch.setenv("OPENAI_BASE_URL", "http://me:secret@host/v1")
    with pytest.raises(UserError, match="holds a password"):
        OpenAIModel(model="m")


def test_a_proxy_sees_nothing_that_stays_on_this_machine(monkeypatch):
    for name in ("http_proxy", "HTTP_PROXY", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:1")
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.delenv("NO_PROXY", raising=False)
    assert Asked(complete("yes"), retries=0).outcome.text == "yes"


def test_nothing_listens():
    with ScriptedServer(lambda *_: complete("")) as server:
        url = server.url
    model = OpenAIModel(model="m", url=url, retries=1)
    model.sleep = lambda _: None
    with pytest.raises(ModelError, match="in 2 attempts: the connection failed.*Check that the server runs"):
        model.generate(ASKED)
    model.close()


def test_no_thread_is_left():
    before = threading.active_count()
    Asked(complete("yes"), times=3)
    assert threading.active_count() == before
