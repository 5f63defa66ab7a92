"""Real classes of published models with tiny random weights, made on the spot."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

SIDE = 64


def import_torch(*others: str) -> None:
    """Skip the test where torch or ``others`` are missing. One thread: several wait for each other."""
    for package in ("torch", *others):
        pytest.importorskip(package, reason="the extra `vision` is not installed")
    import torch

    torch.set_num_threads(1)


def make_sam2(folder: Path) -> None:
    """`Sam2VideoModel` with a million random weights; it is biased to find that an object is there."""
    import torch
    import transformers as hf

    torch.manual_seed(0)
    vision = hf.Sam2VisionConfig(
        backbone_config=hf.Sam2HieraDetConfig(
            hidden_size=8,
            num_attention_heads=1,
            image_size=[SIDE, SIDE],
            blocks_per_stage=[1, 1, 2, 1],
            embed_dim_per_stage=[8, 16, 32, 64],
            num_attention_heads_per_stage=[1, 1, 2, 4],
            window_size_per_stage=[4, 2, 2, 2],
            global_attention_blocks=[3],
            window_positional_embedding_background_size=[2, 2],
        ),
        backbone_channel_list=[64, 32, 16, 8],
        backbone_feature_sizes=[[16, 16], [8, 8], [4, 4]],
        fpn_hidden_size=128,
    )
    config = hf.Sam2VideoConfig(
        vision_config=vision.to_dict(),
        prompt_encoder_config=dict(hidden_size=128, image_size=SIDE, mask_input_channels=4),
        mask_decoder_config=dict(hidden_size=128, mlp_dim=16, num_attention_heads=2, iou_head_hidden_dim=16),
        image_size=SIDE,
        memory_attention_hidden_size=128,
        memory_attention_num_layers=1,
        memory_attention_feed_forward_hidden_size=32,
        memory_attention_rope_feat_sizes=[4, 4],
        memory_encoder_hidden_size=128,
        mask_downsampler_embed_dim=128,
        memory_fuser_num_layers=1,
        memory_fuser_embed_dim=128,
        memory_fuser_intermediate_dim=32,
        num_maskmem=3,
    )
    model = hf.Sam2VideoModel(config)
    with torch.no_grad():
        model.mask_decoder.pred_obj_score_head.proj_out.bias.fill_(10.0)
    model.save_pretrained(folder)
    size = dict(height=SIDE, width=SIDE)
    quarter = dict(height=SIDE // 4, width=SIDE // 4)
    hf.Sam2VideoProcessor(
        image_processor=hf.Sam2ImageProcessor(size=size, mask_size=quarter),
        video_processor=hf.Sam2VideoVideoProcessor(size=size),
        target_size=SIDE,
    ).save_pretrained(folder)


def make_depth_anything(folder: Path, kind: str) -> None:
    """`DepthAnythingForDepthEstimation`, "metric" (up to 20 m) or "relative"."""
    import torch
    import transformers as hf

    torch.manual_seed(0)
    backbone = hf.Dinov2Config(
        hidden_size=16,
        num_hidden_layers=4,
        num_attention_heads=2,
        image_size=56,
        patch_size=14,
        mlp_ratio=2,
        out_indices=[1, 2, 3, 4],
        reshape_hidden_states=False,
    )
    config = hf.DepthAnythingConfig(
        backbone_config=backbone,
        reassemble_hidden_size=16,
        neck_hidden_sizes=[8, 8, 8, 8],
        fusion_hidden_size=8,
        head_hidden_size=8,
        depth_estimation_type=kind,
        max_depth=20 if kind == "metric" else 1,
    )
    hf.DepthAnythingForDepthEstimation(config).save_pretrained(folder)
    hf.DPTImageProcessor(
        size=dict(height=56, width=56), ensure_multiple_of=14, keep_aspect_ratio=True
    ).save_pretrained(folder)


# --- ONNX, by its protocol buffers (onnx.proto, Apache-2.0): numbers of fields are those of the format --------------


def make_onnx(path: Path, height: int | None, width: int | None, gain: float, shift: float) -> None:
    """A network that maps a picture to sigmoid(gain * mean over the channels + shift); None = any side."""
    floats = {name: struct.pack("<f", value) for name, value in (("gain", gain), ("shift", shift))}
    nodes = [
        _field(3, "mean") + _field(4, "ReduceMean") + _field(1, "x") + _field(2, "m") + _field(5, _AXES),
        _field(4, "Mul") + _field(1, "m") + _field(1, "gain") + _field(2, "g"),
        _field(4, "Add") + _field(1, "g") + _field(1, "shift") + _field(2, "s"),
        _field(4, "Sigmoid") + _field(1, "s") + _field(2, "y"),
    ]
    graph = b"".join(_field(1, node) for node in nodes) + _field(2, "map")
    for name, raw in floats.items():
        graph += _field(5, _field(2, 1) + _field(8, name) + _field(9, raw))
    graph += _field(11, _describe("x", (1, 3, height, width))) + _field(
        12, _describe("y", (1, 1, height, width))
    )
    path.write_bytes(_field(1, 8) + _field(7, graph) + _field(8, _field(1, "") + _field(2, 13)))


def _field(number: int, value: int | str | bytes) -> bytes:
    """A field: a whole number, or text, bytes or a message with its length before it."""
    if isinstance(value, int):
        return _varint(number << 3) + _varint(value)
    data = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(data)) + data


def _varint(value: int) -> bytes:
    low = bytes([value & 0x7F | (0x80 if value > 0x7F else 0)])
    return low + (_varint(value >> 7) if value > 0x7F else b"")


def _describe(name: str, sides: tuple[int | None, ...]) -> bytes:
    shape = b"".join(
        _field(1, _field(2, f"side{index}") if side is None else _field(1, side))
        for index, side in enumerate(sides)
    )
    return _field(1, name) + _field(2, _field(1, _field(1, 1) + _field(2, shape)))


_AXES = _field(1, "axes") + _field(8, 1) + _field(20, 7)
