"""Models of GGUF files in process, and behind llama.cpp's own server; the smallest real one, if it is at hand."""

import os
import signal
import subprocess
import sys
import threading
import time
from typing import Literal

import pytest

from benchmarks.agents.models import MODELS
from physagent_jax.agents.llm.structured import ask
from physagent_jax.chat.base import ChatMessage, ModelError
from physagent_jax.chat.llama_client import LlamaModel, count_free_cores
from physagent_jax.core.errors import UserError
from physagent_jax.core.strict import Strict

xllamacpp = pytest.importorskip("xllamacpp", reason="the extra `llama` is not installed")

FILE = MODELS["smollm2-135m"].find()
needs_model = pytest.mark.skipif(
    FILE is None, reason="no model: `python -m benchmarks.agents.models smollm2-135m` fetches it (93 MB)"
)
STORY = [ChatMessage("user", "Write a long story about a dog.")]
PROGRAM = """
import sys
from physagent_jax.chat.base import ChatMessage
from physagent_jax.chat.llama_client import LlamaModel
model = LlamaModel(path=sys.argv[1], threads=1, context=256, max_tokens=4)
print(len(model.generate([ChatMessage("user", "hi")]).text) > 0)
if sys.argv[2] == "close":
    model.close()
"""


class Push(Strict):
    """A push."""

    way: Literal["left", "right"]
    strength: Literal["gentle", "strong"]


@pytest.fixture(scope="module")
def model():
    model = LlamaModel(path=FILE, threads=1, context=512, max_tokens=200)
    yield model
    model.close()


@needs_model
def test_a_schema_is_enforced_in_process(model):
    """A model this small writes no JSON by itself; token by token it can write nothing else."""
    reply = ask(model, [ChatMessage("user", "a strong wind from the right")], Push)
    assert isinstance(reply.value, Push)
    assert reply.trace.validation_errors == () and reply.trace.model == "smollm2-135m"
    assert reply.trace.input_tokens > 20 and 5 < reply.trace.output_tokens < 60
    assert reply.trace.latency_seconds > 0 and model.name == "llama:smollm2-135m"


@needs_model
def test_a_real_server_is_asked_by_http(model, monkeypatch):
    """The client of servers with llama.cpp's own: the same answer as in process, and by the same schema."""
    pytest.importorskip("openai", reason="the extra `llm` is not installed")
    from physagent_jax.chat.openai_client import OWN_KEY, OpenAIModel

    monkeypatch.setenv(OWN_KEY, model.key)
    client = OpenAIModel(model="any", url=model.url, max_tokens=200, timeout=300)
    prompt = [ChatMessage("user", "a strong wind from the right")]
    reply = ask(client, prompt, Push)
    assert reply.value == ask(model, prompt, Push).value  # greedy: the same again
    assert reply.trace.validation_errors == () and reply.trace.output_tokens > 5
    monkeypatch.setenv(OWN_KEY, "sk-wrong-0123456789")
    with pytest.raises(ModelError, match="HTTP 401"):
        OpenAIModel(model="any", url=model.url).generate(prompt)
    client.close()


@needs_model
def test_prompts_that_take_turns_are_read_once(model):
    """Two agents with long prompts of their own, asked in turn: the second time, only what is new is read."""
    read = []
    for word in ("dog ", "sea ") * 2:
        usage = model._complete([ChatMessage("user", word * 80)], None)["usage"]
        read.append(usage["prompt_tokens"] - usage["prompt_tokens_details"]["cached_tokens"])
    assert min(read[:2]) > 60 and max(read[2:]) < 5


@needs_model
def test_requests_that_cannot_be_answered_are_errors(model):
    for messages, schema, words in (
        ([ChatMessage("user", "left " * 1000)], None, "exceeds the available context size"),
        ([ChatMessage("user", "hi")], {"type": "nonsense"}, "schema"),
        ([ChatMessage("user", "hi", (b"\x89PNG",))], None, "image"),
    ):
        with pytest.raises(ModelError, match=words):
            model.generate(messages, schema)


@needs_model
def test_the_time_out_and_the_limit_of_tokens_hold():
    model = LlamaModel(path=FILE, threads=1, context=256, max_tokens=5, timeout=300)
    answer = model.generate(STORY)
    assert answer.cut and answer.usage.output_tokens == 5
    model.close()
    model = LlamaModel(path=FILE, threads=1, context=256, timeout=0.01)
    with pytest.raises(ModelError, match="no answer within 0.01 s"):
        model.generate(STORY)
    model.close()


@needs_model
def test_an_interruption_ends_the_answer(monkeypatch):
    """Control-C does not wait for the whole story: the next token is told to be the last one."""
    taken = []

    class Interrupted:
        def __init__(self, params):
            self.server = xllamacpp_server(params)
            self.listening_address = self.server.listening_address

        def handle_chat_completions(self, request, take):
            def interrupt(chunk):
                taken.append(chunk)
                if len(taken) == 3:
                    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
                    end = time.monotonic() + 100
                    while not take(chunk) and time.monotonic() < end:
                        time.sleep(0.01)
                return take(chunk)

            return self.server.handle_chat_completions(request, interrupt)

    xllamacpp_server = xllamacpp.Server
    monkeypatch.setattr(xllamacpp, "Server", Interrupted)
    model = LlamaModel(path=FILE, threads=1, context=256, max_tokens=200)
    # A shell that starts its commands in the background has them ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            model.generate(STORY)
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(taken) == 3
    model.close()


@needs_model
@pytest.mark.parametrize(("end", "code"), [("close", 0), ("keep", 0)])
def test_a_program_ends_with_its_own_exit_code(end, code):
    """With the model closed or not; llama.cpp's threads keep nothing alive."""
    command = [sys.executable, "-c", PROGRAM, str(FILE), end]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (code, "True\n", "")


def test_files_that_are_no_models_are_errors(tmp_path):
    (tmp_path / "bad.gguf").write_bytes(b"GGUF" + b"\0" * 100)
    with pytest.raises(ModelError, match="bad.gguf cannot be loaded"):
        LlamaModel(path=tmp_path / "bad.gguf")
    with pytest.raises(UserError, match="a folder"):
        LlamaModel(path=tmp_path)


def test_free_cores_are_those_without_load(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    for load, free in ((0.0, 8), (2.2, 6), (7.9, 1), (30.0, 1)):
        monkeypatch.setattr(os, "getloadavg", lambda load=load: (load, 0, 0), raising=False)
        assert count_free_cores() == free
