"""CLIP in Flax: the same numbers as the classes of `transformers`, from folders as these write them."""

import json
import shutil
import sys

import numpy as np
import pytest

from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.metrics.clip_similarity import load_clip
from tests.metrics.make_tiny_clip import FOLDER, LENGTH, SENTENCES, SIZE, draw_pictures, draw_pixels

jax = pytest.importorskip("jax")
for package in ("flax.nnx", "safetensors", "tokenizers"):
    pytest.importorskip(package, reason="needs the extra `clip`")

from flax import nnx  # noqa: E402
from safetensors.numpy import load_file, save_file  # noqa: E402

from physagent_jax.metrics import clip_encoder  # noqa: E402
from physagent_jax.metrics.clip_checkpoint import make_model, read_config, read_tensors  # noqa: E402
from physagent_jax.metrics.clip_encoder import ClipEncoder  # noqa: E402
from physagent_jax.metrics.clip_pictures import Preparation  # noqa: E402
from physagent_jax.metrics.clip_words import Words  # noqa: E402

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # to compile takes longest

EXPECTED = json.loads((FOLDER / "expected.json").read_text())


@pytest.fixture
def folder(tmp_path):
    """The tiny model, to be changed."""
    return shutil.copytree(FOLDER, tmp_path / "clip")


def read_model(folder):
    return make_model(read_config(folder / "config.json"), read_tensors(folder))


def encode(sentences):
    words = Words(FOLDER, LENGTH)
    return tuple(np.concatenate(each) for each in zip(*map(words.encode, sentences)))


def change(path, **values):
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def test_the_tiny_model_says_what_the_reference_says_of_it():
    """Stored numbers of the original classes; the weights are of 16 bits and converted."""
    model, (ids, mask), pixels = read_model(FOLDER), encode(SENTENCES), draw_pixels(3)
    np.testing.assert_allclose(model.encode_text(ids, mask), EXPECTED["text"], atol=1e-5)
    np.testing.assert_allclose(model.encode_pictures(pixels), EXPECTED["pictures"], atol=1e-5)
    np.testing.assert_allclose(model(ids, mask, pixels), EXPECTED["logits"], atol=2e-4)  # up to 14


def test_tokens_are_those_of_the_reference():
    """A sentence that is too long keeps its end."""
    ids, mask = encode(SENTENCES)
    assert [row[: known.sum()].tolist() for row, known in zip(ids, mask)] == EXPECTED["ids"]
    assert mask.sum(1).max() == LENGTH and EXPECTED["ids"][-1][-1] == 1


def test_a_tokenizer_file_says_the_same_as_vocabulary_and_merges(folder):
    words = Words(folder, LENGTH)
    words.tokenizer.save(str(folder / "tokenizer.json"))
    (folder / "vocab.json").unlink()
    again = Words(folder, LENGTH)
    for sentence in SENTENCES:
        assert np.array_equal(words.encode(sentence)[0], again.encode(sentence)[0])


def test_pictures_of_another_size_are_compared_as_the_reference_does():
    """Of 8 bits, but for colours on the border between two; others are not rounded, and that shows."""
    encoder = load_clip(FOLDER)
    rgb = draw_pictures(3, 40, 28)
    for colours, tolerance in ((rgb, 2e-4), (np.float32(rgb) / 255, 5e-3)):
        found = np.stack([encoder.compare(colours, sentence) for sentence in SENTENCES], 1)
        np.testing.assert_allclose(found, EXPECTED["cosines"], atol=tolerance)


@pytest.mark.parametrize("activation", ["quick_gelu", "gelu"])
@pytest.mark.parametrize("eos", [2, 7])
def test_random_models_are_equal_to_torch(tmp_path, activation, eos):
    """Both towers, masks with holes, and both rules for the end of a sentence."""
    torch = pytest.importorskip("torch", reason="the reference needs torch, which no extra of CLIP brings")
    transformers = pytest.importorskip("transformers", reason="the reference needs transformers")
    torch.manual_seed(eos)
    common = dict(num_hidden_layers=2, hidden_act=activation)
    text = dict(hidden_size=32, intermediate_size=48, num_attention_heads=4, vocab_size=20, **common)
    text |= dict(max_position_embeddings=9, eos_token_id=eos, bos_token_id=0, pad_token_id=1)
    vision = dict(
        hidden_size=24, intermediate_size=40, num_attention_heads=2, image_size=12, patch_size=4, **common
    )
    config = transformers.CLIPConfig(text_config=text, vision_config=vision, projection_dim=16)
    reference = transformers.CLIPModel(config).eval()
    with torch.no_grad():
        for weight in reference.parameters():
            weight.add_(0.1 * torch.randn(weight.shape))
    reference.save_pretrained(tmp_path)
    rng = np.random.default_rng(0)
    ids = rng.integers(3, 20, (5, 9))
    ids[np.arange(5), [2, 4, 5, 7, 8]] = 7
    mask = (rng.uniform(size=ids.shape) < 0.7) | (np.arange(9) == 0)
    pixels = rng.normal(size=(4, 12, 12, 3)).astype(np.float32)
    with torch.no_grad():
        said = reference(
            torch.tensor(ids), torch.tensor(pixels).movedim(-1, 1), torch.tensor(mask.astype(int))
        )
    model = read_model(tmp_path)
    np.testing.assert_allclose(model.encode_text(ids, mask), said.text_embeds, atol=1e-5)
    np.testing.assert_allclose(model.encode_pictures(pixels), said.image_embeds, atol=1e-5)
    np.testing.assert_allclose(model(ids, mask, pixels), said.logits_per_image, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("kind", ["float16", "bfloat16"])
def test_weights_of_16_bits_are_converted(folder, kind):
    """In bfloat16 three digits are left."""
    path = folder / "model.safetensors"
    whole = load_file(path)
    save_file({name: value.astype(np.dtype(kind)) for name, value in whole.items()}, path)
    model = read_model(folder)
    assert all(leaf.dtype == np.float32 for leaf in jax.tree.leaves(nnx.state(model)))
    wanted = np.asarray(EXPECTED["pictures"])
    np.testing.assert_allclose(
        model.encode_pictures(draw_pixels(3)), wanted, atol=1e-5 if kind == "float16" else 0.05
    )


def test_long_clips_go_in_batches_that_are_compiled_once(monkeypatch):
    """Two hundred pictures: thirteen batches of sixteen; the same cosines as one by one, in any order."""
    traced = []

    def prepare(rgb, how):
        traced.append(rgb.shape)
        return kept(rgb, how)

    kept = clip_encoder.prepare
    monkeypatch.setattr(clip_encoder, "prepare", prepare)
    encoder, rgb = load_clip(FOLDER), draw_pictures(200, 18, 22)
    found = encoder.compare(rgb, "left")
    assert np.array_equal(found, encoder.compare(rgb, "left")) and traced == [(16, 18, 22, 3)]
    order = np.random.default_rng(0).permutation(200)
    np.testing.assert_allclose(encoder.compare(rgb[order], "left"), found[order], atol=1e-6)
    alone = [encoder.compare(each[None], "left")[0] for each in rgb[:3]]
    np.testing.assert_allclose(found[:3], alone, atol=1e-6)
    assert encoder.compare(rgb[:17], "left").shape == (17,) and traced[1:] == [(1, 18, 22, 3), (9, 18, 22, 3)]


def test_the_gradient_by_the_pixels_is_that_of_differences():
    """In double precision, in random directions, at a size that is resized and cropped."""
    with jax.enable_x64(True):
        config = read_config(FOLDER / "config.json")
        model = make_model(config, read_tensors(FOLDER), np.float64)
        encoder = ClipEncoder(model, Preparation.read(FOLDER, SIZE), Words(FOLDER, LENGTH), "double")
        rng = np.random.default_rng(0)
        rgb, sentence = rng.uniform(0.2, 0.8, (3, 21, 26, 3)), encoder.embed("left")

        def measure(colours):
            return encoder.cosines(colours, sentence).mean()

        slope = np.asarray(jax.grad(measure)(rgb))
        assert slope.shape == rgb.shape and np.abs(slope).max() > 1e-5
        for _ in range(3):
            way = rng.normal(size=rgb.shape)
            difference = (measure(rgb + 1e-5 * way) - measure(rgb - 1e-5 * way)) / 2e-5
            assert float(difference) == pytest.approx((slope * way).sum(), rel=1e-6, abs=1e-9)


def test_a_still_picture_and_the_name(folder):
    encoder = load_clip(folder)
    assert encoder.name == "clip" and encoder.compare(draw_pictures(1, 16, 16), "a").shape == (1,)


def test_older_configurations_say_some_values_twice(folder):
    """The second ones count."""
    path = folder / "config.json"
    known = read_config(path)
    text = json.loads(path.read_text())["text_config"]
    change(
        path, text_config=text | {"hidden_size": 9, "eos_token_id": 2}, text_config_dict={"hidden_size": 8}
    )
    assert read_config(path).text_config == known.text_config.model_copy(update={"eos_token_id": 2})
    change(path, text_config=None, text_config_dict=None)
    assert read_config(path).text_config.hidden_size == 512


def break_config(folder):
    change(folder / "config.json", model_type="siglip")


def break_heads(folder):
    change(folder / "config.json", vision_config={"hidden_size": 8, "num_attention_heads": 3})


def break_preparation(folder):
    change(folder / "preprocessor_config.json", resample=2)


def break_crop(folder):
    change(folder / "preprocessor_config.json", crop_size={"height": 8, "width": 8})


def break_words(folder):
    (folder / "merges.txt").write_text("x y z\n")


def remove_words(folder):
    for path in (*folder.glob("vocab*"), *folder.glob("tokenizer*")):
        path.unlink()


def add_words(folder):
    tokens = json.loads((folder / "vocab.json").read_text())
    change(folder / "vocab.json", more=len(tokens))


def cut_weights(folder):
    path = folder / "model.safetensors"
    path.write_bytes(path.read_bytes()[:500])


def change_weights(folder, edit):
    path = folder / "model.safetensors"
    tensors = dict(load_file(path))
    edit(tensors)
    save_file(tensors, path)


@pytest.mark.parametrize(
    "spoil, message",
    [
        (lambda folder: (folder / "config.json").unlink(), "holds no CLIP model"),
        (break_config, "siglip"),
        (break_heads, "multiple of"),
        (break_preparation, "resample"),
        (break_crop, "of the model's size, 16"),
        (break_words, "tokenizer cannot be read"),
        (remove_words, "no tokenizer"),
        (add_words, "more tokens than the model"),
        (cut_weights, "weights cannot be read"),
        (lambda folder: (folder / "model.safetensors").unlink(), "no weights"),
        (lambda folder: change_weights(folder, lambda each: each.pop("logit_scale")), "lacks a weight"),
        (lambda folder: change_weights(folder, lambda each: each.update(b=np.zeros(2))), "not of its model"),
        (
            lambda folder: change_weights(folder, lambda each: each.update(logit_scale=np.zeros(2))),
            "must have the shape",
        ),
    ],
)
def test_folders_that_are_no_clip_model_are_refused(folder, spoil, message):
    spoil(folder)
    with pytest.raises(UserError, match=message):
        load_clip(folder)


def test_a_missing_package_is_named_with_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "physagent_jax.metrics.clip_encoder", None)
    with pytest.raises(MissingPackageError, match=r"physagent-jax\[clip\]"):
        load_clip(FOLDER)
