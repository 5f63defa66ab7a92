"""Real small models behind the agents: by llama.cpp's own HTTP server with the client, and in process."""

import pytest

pytest.importorskip("xllamacpp", reason="the extra `llama` is not installed")
pytest.importorskip("openai", reason="the extra `llm` is not installed")

from benchmarks.agents.models import MODELS
from benchmarks.agents.roles import make_context
from physagent_jax.agents.registry import make_agents
from physagent_jax.chat.llama_client import LlamaModel
from physagent_jax.chat.openai_client import OWN_KEY, OpenAIModel

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", params=["qwen2.5-coder-0.5b", "qwen2.5-coder-1.5b"])
def model(request):
    file = MODELS[request.param].find()
    if file is None:
        pytest.skip(f"no model: `python -m benchmarks.agents.models {request.param}` fetches it")
    model = LlamaModel(path=file, threads=1, context=4096, max_tokens=300)
    yield model
    model.close()


@pytest.mark.parametrize("form", ["by-clause", "clauses"])
def test_a_reading_is_the_same_in_process_and_by_http(model, form, monkeypatch):
    """The models are held to the schema, so that no answer is refused for its shape."""
    monkeypatch.setenv(OWN_KEY, model.key)
    client = OpenAIModel(model="any", url=model.url, max_tokens=300)
    replies = [
        make_agents(semantic=("model", {"form": form}), model=each).semantic.compile(make_context())
        for each in (model, client)
    ]
    client.close()
    inside, outside = replies
    assert inside.value.force_field == outside.value.force_field
    assert inside.trace.raw_reply == outside.trace.raw_reply
    assert inside.trace.input_tokens == outside.trace.input_tokens > 300
    assert not any("valid JSON" in error for error in inside.trace.validation_errors)
    print(form, model.name, inside.trace.raw_reply, inside.trace.input_tokens, inside.trace.output_tokens)
