"""A tiny CLIP of random weights in `tiny_clip/`, and beside it what the classes of `transformers` say of it.

`python -m tests.metrics.make_tiny_clip`, with the packages torch and transformers.
"""

import json
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "tiny_clip"
BEGIN, END = "<|startoftext|>", "<|endoftext|>"
TOKENS = (
    BEGIN,
    END,
    "l",
    "e",
    "f",
    "t",
    "a",
    "s",
    "'",
    "t</w>",
    "a</w>",
    "left</w>",
    "s</w>",
    "push</w>",
    "le",
    "ft</w>",
)
MERGES = "#version: 0.2\nl e\nf t</w>\nle ft</w>\n"
LENGTH, SIZE = 12, 16
SENTENCES = ("left", "a left  LEFT", "push it, a left's", "left " * 40, "<|endoftext|> left")


def draw_pictures(count: int, height: int, width: int) -> np.ndarray:
    """Waves of other lengths in every picture and colour, uint8, shape (count, height, width, 3)."""
    t, y, x, c = np.ogrid[:count, :height, :width, :3]
    waves = np.sin(0.3 * (t + 1) * x + c) * np.cos(0.2 * y * (c + 1) - t)
    return np.uint8(np.round(127.5 * (1 + waves)))


def draw_pixels(count: int) -> np.ndarray:
    """Normalised pictures, float32, shape (count, SIZE, SIZE, 3)."""
    return (draw_pictures(count, SIZE, SIZE) / 127.5 - 1).astype(np.float32)


def main() -> None:
    """Make the folder anew."""
    import torch
    import transformers

    FOLDER.mkdir(exist_ok=True)
    (FOLDER / "vocab.json").write_text(json.dumps({each: i for i, each in enumerate(TOKENS)}) + "\n")
    (FOLDER / "merges.txt").write_text(MERGES)
    tokenizer = transformers.CLIPTokenizer.from_pretrained(str(FOLDER), model_max_length=LENGTH)
    images = transformers.CLIPImageProcessor(
        size={"shortest_edge": SIZE}, crop_size={"height": SIZE, "width": SIZE}
    )
    images.save_pretrained(FOLDER)
    small = dict(hidden_size=8, intermediate_size=16, num_hidden_layers=2, num_attention_heads=2)
    config = transformers.CLIPConfig(
        text_config=dict(
            **small, vocab_size=len(TOKENS), max_position_embeddings=LENGTH, bos_token_id=0, eos_token_id=1
        ),
        vision_config=dict(**small, image_size=SIZE, patch_size=8),
        projection_dim=8,
    )
    torch.manual_seed(0)
    model = transformers.CLIPModel(config)
    with torch.no_grad():
        for weight in model.parameters():
            if weight.ndim:
                weight.add_(0.3 * torch.randn(weight.shape))
    model.half().save_pretrained(FOLDER)
    model = model.float().eval()
    tokens = tokenizer(list(SENTENCES), return_tensors="pt", padding=True, truncation=True)
    pixels = torch.tensor(draw_pixels(3)).movedim(-1, 1)
    pictures = images(list(draw_pictures(3, 40, 28)), return_tensors="pt")["pixel_values"]
    with torch.no_grad():
        said = model(tokens.input_ids, pixels, tokens.attention_mask)
        shown = model(tokens.input_ids, pictures, tokens.attention_mask)
    found = dict(
        ids=[ids[mask > 0].tolist() for ids, mask in zip(tokens.input_ids, tokens.attention_mask)],
        text=said.text_embeds.tolist(),
        pictures=said.image_embeds.tolist(),
        logits=said.logits_per_image.tolist(),
        cosines=(shown.image_embeds @ shown.text_embeds.T).tolist(),
        versions={each.__name__: each.__version__ for each in (torch, transformers)},
    )
    (FOLDER / "expected.json").write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
