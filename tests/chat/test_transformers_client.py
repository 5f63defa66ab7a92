"""Models of folders in process: a tiny one with random weights and a real tokenizer of its own."""

import pytest

from physagent_jax.agents.llm.structured import ask
from physagent_jax.agents.trace import AgentError
from physagent_jax.chat.base import ChatMessage, ModelError
from physagent_jax.chat.transformers_client import TransformersModel
from physagent_jax.core.errors import UserError
from physagent_jax.motion.schema import Judgement

torch = pytest.importorskip("torch", reason="the extra `models` is not installed")
transformers = pytest.importorskip("transformers", reason="the extra `models` is not installed")

TEMPLATE = (
    "{% for m in messages %}<|{{ m.role }}|>{{ m.content }}<|end|>{% endfor %}"
    "{% if add_generation_prompt %}<|assistant|>{% endif %}"
)
ASKED = [ChatMessage("system", "Be brief."), ChatMessage("user", "left?")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A Llama of two layers over bytes."""
    from tokenizers import Tokenizer, decoders, models, pre_tokenizers

    folder = tmp_path_factory.mktemp("tiny")
    letters = sorted(pre_tokenizers.ByteLevel.alphabet())
    tokenizer = Tokenizer(models.BPE(vocab={letter: i for i, letter in enumerate(letters)}, merges=[]))
    tokenizer.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    tokenizer.decoder = decoders.ByteLevel()
    fast = transformers.PreTrainedTokenizerFast(
        tokenizer_object=tokenizer,
        eos_token="<|end|>",
        additional_special_tokens=["<|system|>", "<|user|>", "<|assistant|>"],
    )
    fast.chat_template = TEMPLATE
    fast.save_pretrained(folder)
    torch.manual_seed(0)
    config = transformers.LlamaConfig(
        vocab_size=len(fast),
        hidden_size=16,
        intermediate_size=32,
        num_hidden_layers=2,
        num_attention_heads=2,
        num_key_value_heads=1,
        max_position_embeddings=4096,
        eos_token_id=fast.eos_token_id,
    )
    transformers.LlamaForCausalLM(config).save_pretrained(folder)
    return folder


@pytest.fixture(scope="module")
def model(folder):
    model = TransformersModel(path=folder, device="cpu", max_tokens=12)
    yield model
    model.close()


def test_the_answer_is_the_greedy_one(folder, model):
    """Token by token the most likely one of the whole prompt, as the model itself gives it."""
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    weights = transformers.AutoModelForCausalLM.from_pretrained(folder).eval()
    text = "<|system|>Be brief.<|end|><|user|>left?<|end|><|assistant|>"
    tokens = tokenizer(text, return_tensors="pt", add_special_tokens=False)["input_ids"]
    prompt = tokens.shape[1]
    for _ in range(12):
        with torch.no_grad():
            best = weights(tokens).logits[0, -1].argmax()
        tokens = torch.cat([tokens, best.reshape(1, 1)], dim=1)
        if best == tokenizer.eos_token_id:
            break
    answer = model.generate(ASKED)
    assert answer.text == tokenizer.decode(tokens[0, prompt:], skip_special_tokens=True)
    assert (answer.usage.input_tokens, answer.usage.output_tokens) == (prompt, tokens.shape[1] - prompt)
    assert answer.cut == (tokens[0, -1] != tokenizer.eos_token_id)
    assert model.generate(ASKED).text == answer.text
    assert answer.model == folder.name and model.name == f"transformers:{folder.name}"


def test_random_weights_end_in_one_error(model):
    with pytest.raises(AgentError, match="no usable answer in 3 tries") as caught:
        ask(model, ASKED, Judgement)
    assert len(caught.value.trace.validation_errors) == 3 and caught.value.trace.output_tokens <= 36


def test_pictures_are_refused(model):
    with pytest.raises(ModelError, match="takes no pictures"):
        model.generate([ChatMessage("user", "see", (b"\x89PNG",))])


def test_folders_that_hold_no_model_are_errors(folder, tmp_path):
    with pytest.raises(UserError, match="no model in the folder"):
        TransformersModel(path=tmp_path)
    (tmp_path / "config.json").write_text('{"model_type": "nonsense"}')
    with pytest.raises(ModelError, match="cannot be loaded"):
        TransformersModel(path=tmp_path)
    bare = tmp_path / "bare"
    bare.mkdir()
    for file in folder.iterdir():
        if "template" not in file.name:
            (bare / file.name).write_bytes(file.read_bytes())
    with pytest.raises(UserError, match="no chat template"):
        TransformersModel(path=bare, device="cpu")


def test_nothing_is_downloaded(folder, monkeypatch):
    """Without a network, and with a name that a hub might have."""
    monkeypatch.chdir(folder)
    with pytest.raises(UserError, match="no model in the folder gpt2"):
        TransformersModel(path="gpt2")
