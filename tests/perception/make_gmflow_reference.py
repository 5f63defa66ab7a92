"""Flow of the published code of GMFlow on networks and pictures that this file makes of seeds.

`python tests/perception/make_gmflow_reference.py FOLDER CHECKPOINT`, where torch is installed, writes the numbers
that the tests compare with. ``FOLDER`` holds the published package `gmflow`; without ``CHECKPOINT`` its numbers stay.
"""

import sys
import zlib
from pathlib import Path

import numpy as np

EXPECTED = Path(__file__).parent / "gmflow_expected.npz"
TINY = {"one scale": (1, 8), "two scales": (2, 4)}
"""Scales, and pixels along a cell of the finest."""
CHANNELS, LAYERS, EXPANSION = 16, 2, 4
PAIRS, FEW = 10, 16


def list_shapes(scales: int, factor: int) -> dict[str, tuple[int, ...]]:
    """Shapes of the weights of a small network; the encoder's own widths are always the published ones."""
    c, shapes = CHANNELS, {"backbone.conv1.weight": (64, 3, 7, 7)}
    for k, (taken, given) in enumerate(((64, 64), (64, 96), (96, 128))):
        for block, size in enumerate((taken, given)):
            place = f"backbone.layer{k + 1}.{block}"
            shapes |= {
                f"{place}.conv1.weight": (given, size, 3, 3),
                f"{place}.conv2.weight": (given, given, 3, 3),
            }
        if k:
            place = f"backbone.layer{k + 1}.0.downsample.0"
            shapes |= {f"{place}.weight": (given, taken, 1, 1), f"{place}.bias": (given,)}
    shapes |= {"backbone.conv2.weight": (c, 128, 1, 1), "backbone.conv2.bias": (c,)}
    if scales == 2:
        shapes["backbone.trident_conv.weight"] = (c, c, 3, 3)
    for layer in range(LAYERS):
        for part in ("self_attn", "cross_attn_ffn"):
            place = f"transformer.layers.{layer}.{part}"
            shapes |= {f"{place}.{name}.weight": (c, c) for name in ("q_proj", "k_proj", "v_proj", "merge")}
            norms = ("norm1",) if part == "self_attn" else ("norm1", "norm2")
            shapes |= {f"{place}.{norm}.{leaf}": (c,) for norm in norms for leaf in ("weight", "bias")}
        wide = 2 * c * EXPANSION
        shapes |= {f"{place}.mlp.0.weight": (wide, 2 * c), f"{place}.mlp.2.weight": (c, wide)}
    for name in ("q_proj", "k_proj"):
        shapes |= {f"feature_flow_attn.{name}.weight": (c, c), f"feature_flow_attn.{name}.bias": (c,)}
    last = 9 * factor**2
    shapes |= {"upsampler.0.weight": (256, 2 + c, 3, 3), "upsampler.0.bias": (256,)}
    return shapes | {"upsampler.2.weight": (last, 256, 1, 1), "upsampler.2.bias": (last,)}


def draw_weights(scales: int, factor: int) -> dict[str, np.ndarray]:
    """Weights so small that likeness stays vague: each name is its own seed.

    A network that chooses between cells far apart would make large differences of rounding errors.
    """
    weights = {}
    for name, shape in list_shapes(scales, factor).items():
        drawn = np.random.RandomState(zlib.crc32(name.encode())).standard_normal(shape)
        if len(shape) > 1:
            drawn *= np.sqrt(1 / np.prod(shape[1:]))
        elif name.endswith("weight"):
            drawn = 0.4 + 0.1 * drawn
        else:
            drawn *= 0.2
        weights[name] = drawn.astype(np.float32)
    return weights


def draw_pair(seed: int, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Two pictures of one texture, the second turned, stretched and moved; uint8, shape (height, width, 3)."""
    draw = np.random.RandomState(seed)
    waves = draw.standard_normal((60, 2))
    waves *= (
        2
        * np.pi
        / np.exp(draw.uniform(np.log(5), np.log(90), (60, 1)))
        / np.linalg.norm(waves, axis=1)[:, None]
    )
    phases, colours = draw.uniform(0, 2 * np.pi, 60), draw.standard_normal((60, 3)) / 60**0.5
    turn, size, shift = np.radians(draw.uniform(-25, 25)), draw.uniform(0.9, 1.1), draw.uniform(-12, 12, 2)
    y, x = np.mgrid[:height, :width]
    places = np.stack([x - width / 2, y - height / 2], -1)
    moved = size * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    def paint(at: np.ndarray) -> np.ndarray:
        shade = 0.5 + 0.2 * np.sin(at @ waves.T + phases) @ (2 * colours)
        return np.rint(255 * np.clip(shade, 0, 1)).astype(np.uint8)

    return paint(places), paint((places - shift) @ np.linalg.inv(moved).T)


def thin(flow: np.ndarray, step: int) -> np.ndarray:
    """Some of the pixels."""
    return np.asarray(flow)[..., step // 2 :: step, step // 2 :: step, :]


def main(folder: str, checkpoint: str = "") -> None:
    """Write what the published code says."""
    sys.path.insert(0, folder)
    import torch
    from gmflow.gmflow import GMFlow

    def ask(network, pair):
        first, second = (torch.tensor(each[None].astype(np.float32) / np.float32(255)) for each in pair)
        options = dict(attn_splits_list=[2, 8], corr_radius_list=[-1, 4], prop_radius_list=[-1, 1])
        options = {name: value[: network.num_scales] for name, value in options.items()}
        with torch.no_grad():
            said = network(first.movedim(-1, 1), second.movedim(-1, 1), pred_bidir_flow=True, **options)
        return said.movedim(1, -1).numpy()

    expected = dict(np.load(EXPECTED)) if EXPECTED.exists() else {}
    for name, (scales, factor) in TINY.items():
        sizes = dict(feature_channels=CHANNELS, num_transformer_layers=LAYERS, ffn_dim_expansion=EXPANSION)
        network = GMFlow(num_scales=scales, upsample_factor=factor, **sizes).eval()
        network.load_state_dict(
            {key: torch.tensor(value) for key, value in draw_weights(scales, factor).items()}
        )
        expected[name] = thin(ask(network, draw_pair(0, 64, 96)), 4)
    if checkpoint:
        network = GMFlow().eval()
        network.load_state_dict(torch.load(checkpoint, weights_only=True, map_location="cpu"))
        pairs = [ask(network, draw_pair(seed, 128, 128)) for seed in range(PAIRS)]
        expected["checkpoint"] = np.stack([thin(pair, FEW) for pair in pairs])
    np.savez_compressed(EXPECTED, **expected)


if __name__ == "__main__":
    main(*sys.argv[1:])
