"""Depth Anything 3 in a process of its own, by a Python that has it: pictures in one file, depth in another.

Run as ``python - ASKED ANSWER < depth_anything_3_process.py``; it imports nothing of this project. ASKED is a .npz with

- ``frames``: pictures, uint8, shape (T, H, W, 3),
- ``focal``: focal length [px],
- ``weights``: a folder or "owner/name", ``device``: of torch, or "auto".

ANSWER is a .npz with

- ``depth``: z-depth of each frame at the model's own size, float32, shape (T, h, w),
- ``metric``: whether it is in metres.
"""

import sys

import numpy as np

CANONICAL_FOCAL = 300.0  # [px] at which the metric model's answer is in metres, by its README


def main(asked: str, answer: str) -> None:
    """Answer what is asked."""
    import torch  # pyright: ignore[reportMissingImports]
    from depth_anything_3.api import DepthAnything3  # pyright: ignore[reportMissingImports]

    with np.load(asked, allow_pickle=False) as file:
        frames, focal = file["frames"], float(file["focal"])
        weights, device = str(file["weights"]), str(file["device"])
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    model = DepthAnything3.from_pretrained(weights).to(device)
    depths, metric = [], False
    for frame in frames:
        seen = model.inference([frame])
        depth = np.asarray(seen.depth[0], np.float32)
        metric = bool(seen.is_metric)
        if (
            "metric" in model.model_name
        ):  # the nested model has done this itself, with a focal length that it estimated
            depth, metric = depth * (focal * depth.shape[1] / frame.shape[1] / CANONICAL_FOCAL), True
        depths.append(depth)
    np.savez(answer, depth=np.stack(depths), metric=metric)


if __name__ == "__main__":
    main(*sys.argv[1:])
