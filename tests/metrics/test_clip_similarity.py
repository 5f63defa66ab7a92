"""CLIPsim: the formula with vectors that are known, and a small CLIP of random weights against its own parts."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clip_similarity import TransformersClip, measure_clip_similarity

WORDS = ("l", "e", "f", "t", "a", "t</w>", "left</w>", "le", "ft</w>", "push</w>")


class Known:
    """An encoder whose pictures are unit vectors in the plane: red is the cosine with every sentence."""

    name = "known"

    def compare(self, rgb, sentence):
        """The mean of the red channel, from 0 to 1."""
        return rgb[..., 0].mean((1, 2)) / 255.0


def make_clip(frames=5, size=24, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (frames, size, size, 3), np.uint8)


def test_it_is_the_mean_over_the_frames_beside_that_of_the_first():
    rgb = np.zeros((4, 2, 2, 3), np.uint8)
    rgb[1:, ..., 0] = np.array([51, 102, 255])[:, None, None]
    said = measure_clip_similarity(rgb, "push it left", Known())
    assert said.mean == pytest.approx((0 + 0.2 + 0.4 + 1) / 4) and said.still == 0.0 and said.model == "known"


@pytest.mark.parametrize(
    "rgb", [np.zeros((0, 2, 2, 3), np.uint8), np.zeros((2, 2, 3), np.uint8), np.zeros((1, 2, 2, 3))]
)
def test_what_is_no_clip_is_refused(rgb):
    with pytest.raises(UserError, match="8 bits"):
        measure_clip_similarity(rgb, "push it left", Known())


def test_only_a_clip_model_gives_clipsim():
    other = SimpleNamespace(config=SimpleNamespace(model_type="siglip"))
    with pytest.raises(UserError, match="siglip"):
        TransformersClip(other, None, "x")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A CLIP model of random weights as its makers keep theirs: config, weights, tokens, picture sizes."""
    torch = pytest.importorskip("torch", reason="needs the extra `clip`")
    transformers = pytest.importorskip("transformers", reason="needs the extra `clip`")
    place = tmp_path_factory.mktemp("clip")
    tokens = ["<|startoftext|>", "<|endoftext|>", *WORDS]
    (place / "vocab.json").write_text(json.dumps({each: i for i, each in enumerate(tokens)}))
    (place / "merges.txt").write_text("#version: 0.2\nl e\nf t</w>\nle ft</w>\n")
    tokenizer = transformers.CLIPTokenizer(
        str(place / "vocab.json"), str(place / "merges.txt"), model_max_length=12
    )
    images = transformers.CLIPImageProcessor(
        size={"shortest_edge": 16}, crop_size={"height": 16, "width": 16}
    )
    transformers.CLIPProcessor(images, tokenizer).save_pretrained(place)
    torch.manual_seed(0)
    small = dict(hidden_size=32, intermediate_size=64, num_hidden_layers=2, num_attention_heads=4)
    config = transformers.CLIPConfig(
        text_config=dict(
            **small, vocab_size=len(tokens), max_position_embeddings=12, eos_token_id=1, bos_token_id=0
        ),
        vision_config=dict(**small, image_size=16, patch_size=8),
        projection_dim=24,
    )
    transformers.CLIPModel(config).save_pretrained(place)
    return place


def test_a_model_from_a_folder_says_what_its_parts_say(folder):
    """Towers and projections one by one, a picture at a time, against the whole in batches of sixteen."""
    import torch
    import transformers

    model = transformers.CLIPModel.from_pretrained(folder).eval()
    processor = transformers.CLIPProcessor.from_pretrained(folder)
    rgb = make_clip(18)
    encoder = TransformersClip.load(folder)
    found = encoder.compare(rgb, "left left a left")
    with torch.no_grad():
        tokens = processor.tokenizer("left left a left", return_tensors="pt")
        words = model.text_projection(model.text_model(**tokens).pooler_output)[0].double().numpy()
        expected = []
        for picture in rgb:
            pixels = processor.image_processor(picture, return_tensors="pt")
            seen = model.visual_projection(model.vision_model(**pixels).pooler_output)[0].double().numpy()
            expected.append(seen @ words / np.linalg.norm(seen) / np.linalg.norm(words))
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert np.ptp(found) > 1e-4 and encoder.name == folder.name
    assert not np.allclose(found, encoder.compare(rgb, "a"), atol=1e-4)


def test_order_does_not_matter_and_long_sentences_are_cut(folder):
    encoder, rgb = TransformersClip.load(folder), make_clip(4)
    one, other = (measure_clip_similarity(each, "left " * 40, encoder) for each in (rgb, rgb[::-1]))
    assert one.mean == pytest.approx(other.mean, abs=1e-7) and one.still != pytest.approx(
        other.still, abs=1e-6
    )


def test_a_folder_without_a_model_is_refused(folder, tmp_path):
    with pytest.raises(UserError, match="holds no CLIP model"):
        TransformersClip.load(tmp_path)
