"""Depth from pictures alone by Depth Anything 3 (Lin et al. 2025), in a process of its own.

Its package needs a NumPy below 2, which this one cannot share: another Python runs `depth_anything_3_process`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.foreign_python import Foreign, find_python, run_python
from physagent_jax.core.model_files import is_identifier, locate_folder
from physagent_jax.core.npy import read_npz
from physagent_jax.perception.backends.depth_anything import METRIC, check_height, scale_inverse
from physagent_jax.perception.backends.still import anchor_depth
from physagent_jax.perception.lift import keep_possible_depth
from physagent_jax.perception.protocols import Depth, DepthEstimator
from physagent_jax.render.camera import Camera

WEIGHTS = "depth-anything/DA3METRIC-LARGE"
_SCRIPT = Path(__file__).with_name("depth_anything_3_process.py")
_MOST_BYTES = 2**34  # of an answer
_TOLD = Foreign("`depth_anything_3`")
_EXAMPLE = '{"name": "depth_anything_3", "options": {"python": "/path/venv/bin/python"}}'
_RELATIVE = "Depth was estimated from the pictures by {}, in a unit of its own."


class DepthAnything3(DepthEstimator):
    """Depth Anything 3, frame by frame, all of them on the scale of frame 0 by what stands still (`still`).

    Args:
        weights: A folder with config.json and model.safetensors, or "owner/name" in the hub's cache.
        python: Python that has the package `depth_anything_3`.
        device: Device of torch; "auto" = a GPU if there is one.
        download: Whether files that are missing may be fetched.
        timeout: Longest time for a clip [s].
        ground_height: Height of the ground in the pictures, for models without metres [m]; None = none is known.

    Raises:
        UserError: The Python or the weights are missing, or an option is out of range.
    """

    def __init__(
        self,
        weights: str = WEIGHTS,
        *,
        python: str | None = None,
        device: str = "auto",
        download: bool = False,
        timeout: float = 3600.0,
        ground_height: float | None = None,
    ):
        self._python = find_python(python, _TOLD, _EXAMPLE)
        self._place = locate_folder(weights, "`depth_anything_3`", download=download is True)
        self.label = weights if is_identifier(weights) else Path(self._place).resolve().name
        if isinstance(timeout, bool) or not isinstance(timeout, int | float) or not 0 < timeout <= 86_400:
            raise UserError("`timeout` must be above 0 and at most 86400 s", got=repr(timeout)[:80])
        self._device, self._download, self._timeout = str(device), download is True, float(timeout)
        self._ground_height = check_height(ground_height)

    @property
    def name(self) -> str:
        """The model and its weights."""
        return f"depth_anything_3:{self.label}"

    def estimate(self, frames: np.ndarray, camera: Camera, measured: np.ndarray | None) -> Depth:
        """Depth of every pixel; a measured channel is not looked at. See `protocols.DepthEstimator`.

        Raises:
            UserError: The process fails, takes too long, or answers something else than depth.
        """
        del measured
        raw, metric = self._ask(frames, camera)
        z, notes = anchor_depth(keep_possible_depth(raw), frames)
        if metric:
            return Depth(keep_possible_depth(z), notes=(METRIC.format(self.name), *notes))
        if self._ground_height is not None:
            return scale_inverse(1 / z, camera, self._ground_height, self.name, notes)
        return Depth(keep_possible_depth(z), False, notes=(_RELATIVE.format(self.name), *notes))

    def _ask(self, frames: np.ndarray, camera: Camera) -> tuple[np.ndarray, bool]:
        """The model's depth of each frame, at the pictures' size, and whether it is in metres."""
        focal = float(np.asarray(camera.K)[0, 0])
        with tempfile.TemporaryDirectory() as folder:
            asked, answer = (str(Path(folder, f"{name}.npz")) for name in ("asked", "answer"))
            np.savez(asked, frames=frames, focal=focal, weights=self._place, device=self._device)
            self._run(asked, answer)
            found = read_npz(
                answer, ("depth", "metric"), most=_MOST_BYTES, what="the answer of `depth_anything_3`"
            )
        depth, metric = found.get("depth"), found.get("metric")
        if (
            depth is None
            or metric is None
            or depth.ndim != 3
            or len(depth) != len(frames)
            or depth.dtype.kind != "f"
        ):
            got = {name: f"{array.dtype} {array.shape}" for name, array in found.items()}
            raise UserError("`depth_anything_3` must answer one depth per frame", got=got)
        size = frames.shape[2], frames.shape[1]
        resized = [
            cv2.resize(each.astype(np.float32), size, interpolation=cv2.INTER_LINEAR) for each in depth
        ]
        return np.stack(resized), bool(metric)

    def _run(self, asked: str, answer: str) -> None:
        """Run the other Python; the script is its standard input: beside it lies a module with the package's name."""
        run_python(
            self._python,
            ["-", asked, answer],
            told=_TOLD,
            folder=Path(asked).parent,
            timeout=self._timeout,
            script=_SCRIPT.read_text(),
            environment={} if self._download else {"HF_HUB_OFFLINE": "1"},
        )
