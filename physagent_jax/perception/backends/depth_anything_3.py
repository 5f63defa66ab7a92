"""Depth from pictures alone by Depth Anything 3 (Lin et al. 2025), in a process of its own.

Its package needs a NumPy below 2, which this one cannot share: another Python runs `depth_anything_3_process`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import is_identifier, locate_folder
from physagent_jax.core.npy import read_npz
from physagent_jax.core.reading import shorten
from physagent_jax.perception.backends.depth_anything import METRIC, check_height, scale_inverse
from physagent_jax.perception.backends.still import anchor_depth
from physagent_jax.perception.lift import keep_possible_depth
from physagent_jax.perception.protocols import Depth, DepthEstimator
from physagent_jax.render.camera import Camera

WEIGHTS = "depth-anything/DA3METRIC-LARGE"
_SCRIPT = Path(__file__).with_name("depth_anything_3_process.py")
_MOST_BYTES = 2**34  # of an answer
_LAST_LINES = 3
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
        self._python = _find_python(python)
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
        """Run the other Python, without this one's own paths."""
        own = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
        environment = {name: value for name, value in os.environ.items() if name not in own}
        if not self._download:
            environment["HF_HUB_OFFLINE"] = "1"
        try:
            done = subprocess.run(
                # As standard input: beside the script lies a module with the name of the package.
                [self._python, "-", asked, answer],
                input=_SCRIPT.read_text(),
                env=environment,
                cwd=Path(asked).parent,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=self._timeout,
            )
        except subprocess.TimeoutExpired:
            raise UserError(
                f"`depth_anything_3` took longer than {self._timeout:g} s", do="Raise its option `timeout`"
            ) from None
        except OSError as error:
            raise UserError("`depth_anything_3` cannot be started", got=shorten(error)) from None
        if done.returncode:
            last = " | ".join(done.stderr.strip().splitlines()[-_LAST_LINES:]) or "it says nothing"
            raise UserError(
                f"`depth_anything_3` failed with exit code {done.returncode}",
                got=shorten(last, 400),
                do="Mend the Python that its option `python` names",
            )


def _find_python(python: object) -> str:
    """The program that ``python`` names.

    Raises:
        UserError: It names none.
    """
    do = 'Give the option `python`: {"name": "depth_anything_3", "options": {"python": "/path/venv/bin/python"}}'
    if python is None:
        raise UserError(
            "`depth_anything_3` needs a Python that has its package, whose NumPy is another", do=do
        )
    if not isinstance(python, str) or (found := shutil.which(os.path.expanduser(python))) is None:
        raise UserError("`python` of `depth_anything_3` is no program", got=shorten(repr(python)), do=do)
    return found
