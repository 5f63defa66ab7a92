"""Chat models by name: what is missing or wrong is one error that says what to do."""

import sys

import pytest

from physagent_jax.chat.base import ChatMessage, Generation, Usage
from physagent_jax.chat.registry import make_model
from physagent_jax.chat.replay import Recorder, ReplayModel
from physagent_jax.core.errors import MissingPackageError, UserError


@pytest.fixture
def files(tmp_path):
    """A file and a folder that look like models until they are read."""
    (tmp_path / "model.gguf").write_bytes(b"GGUF")
    (tmp_path / "config.json").write_text("{}")
    return {"llama": {"path": str(tmp_path / "model.gguf")}, "transformers": {"path": str(tmp_path)}}


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [("openai", "openai", "llm"), ("llama", "xllamacpp", "llama"), ("transformers", "torch", "models")],
)
def test_a_missing_package_names_the_extra(monkeypatch, files, name, package, extra):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingPackageError) as caught:
        make_model((name, files.get(name, {"model": "m"})))
    told = str(caught.value)
    assert told.startswith(f"the chat model `{name}` needs a package (") and package in told
    assert told.endswith(f"Install the extra: pip install 'physagent-jax[{extra}]'.")


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ("opnai", "is not known .got 'opnai'.. Did you mean `openai`"),
        ("openai", "field `model`: Field required"),
        (("openai", {"model": ""}), "field `model`"),
        (("openai", {"model": "m", "temprature": 1}), "field `temprature`"),
        (("openai", {"model": "m", "timeout": 0}), "field `timeout`.*greater than or equal"),
        (("openai", {"model": "m", "retries": 1000}), "field `retries`"),
        (("http://127.0.0.1:8000/v1", {}), "field `model`: Field required"),
        (("ftp://127.0.0.1", {"model": "m"}), "address cannot be used"),
        (("llama", {"path": "absent.gguf"}), "there is no model's file absent.gguf"),
        (("llama", {"path": "x", "threads": 0}), "field `threads`"),
        (("transformers", {"path": "absent"}), "no model in the folder absent"),
        (("transformers", {}), "field `path`: Field required"),
        (("replay", {"path": "absent.jsonl"}), "there is no cassette absent.jsonl"),
        ("replay", "needs the options `path`"),
    ],
)
def test_wrong_choices_are_one_error(choice, words):
    with pytest.raises(UserError, match=words) as caught:
        make_model(choice)
    assert "\n" not in str(caught.value)


def test_an_address_is_a_server():
    pytest.importorskip("openai", reason="the extra `llm` is not installed")
    model = make_model(("http://127.0.0.1:8000/v1", {"model": "m", "eyes": True}))
    assert model.name == "openai:m" and model.has_eyes
    model.close()


def test_answers_are_recorded_where_it_is_asked(tmp_path):
    class Fixed:
        name, has_eyes = "fixed:1", False

        def generate(self, messages, schema=None):
            return Generation("yes", None, Usage(), 0.0, "fixed")

        def close(self):
            pass

    asked = [ChatMessage("user", "yes?")]
    Recorder(Fixed(), tmp_path / "first.jsonl").generate(asked)
    choice = ("replay", {"path": str(tmp_path / "first.jsonl")})
    assert isinstance(make_model(choice), ReplayModel)
    model = make_model(choice, record=tmp_path / "second.jsonl")
    assert isinstance(model, Recorder) and model.generate(asked).text == "yes"
    assert '"text":"yes"' in (tmp_path / "second.jsonl").read_text()
