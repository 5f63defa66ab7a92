"""Segmentation by a salient-object network in an ONNX file, such as ISNet (Qin et al. 2022) or U2-Net (2020)."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import find_models_folder
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import check_regular, shorten
from physagent_jax.perception.backends.colour import remove_specks
from physagent_jax.perception.protocols import Masks, Segmenter, SegmentPrompt

EXTRA = "salient"
FILE = "salient.onnx"
_MOST_BYTES = 2**32
_IMAGENET = (123.675, 116.28, 103.53), (58.395, 57.12, 57.375)
_PREPARED = {1024: ((128.0,) * 3, (256.0,) * 3), 320: _IMAGENET}
"""Mean and deviation [8-bit levels] by the input's size: ISNet takes 1024 pixels a side, U2-Net 320."""


@dataclasses.dataclass(frozen=True)
class _Network:
    """A network that is ready to run.

    Attributes:
        run: From a picture, float32, shape (1, 3, height, width), to its outputs.
        sides: Height and width of its input; None = any.
    """

    run: Callable[[np.ndarray], Any]
    sides: tuple[int | None, int | None]


class SalientSegmenter(Segmenter):
    """The object is what the network calls salient, frame by frame: it takes no prompt and has no memory.

    Args:
        weights: ONNX file with one picture in, (1, 3, height, width) in RGB, and the map first among what comes out,
            0..1; None = ``salient.onnx`` in `find_models_folder`.
        size: Side of the input, for a network that takes any [px].
        mean, deviation: From 8-bit levels to what the network takes, (level - mean) / deviation; one number, or one per
            channel; None = by the input's size.
        threshold: Value of the map above which a pixel is on the object.
        runtime: "onnxruntime", "openvino", or "auto" = the first that is installed.

    Raises:
        UserError: File or package are missing, the file is no such network, or an option is out of range.
    """

    def __init__(
        self,
        weights: str | None = None,
        *,
        size: int | None = None,
        mean: float | list[float] | None = None,
        deviation: float | list[float] | None = None,
        threshold: float = 0.5,
        runtime: str = "auto",
    ):
        if weights is not None and not isinstance(weights, str):
            raise UserError("`weights` of `salient` must be a path", got=repr(weights)[:80])
        file = find_models_folder() / FILE if weights is None else Path(weights).expanduser()
        if weights is None and not file.exists():
            raise UserError(
                "`salient` needs a network in an ONNX file",
                got=f"none, looked for at {shorten(file)}",
                do="Give the option `weights`; `physagent models` tells where one comes from, and its licence",
            )
        check_regular(file, most=_MOST_BYTES, what="the network of `salient`")
        (threshold,) = _read_numbers("threshold", threshold, 1)
        self._label, self._threshold = file.stem, threshold
        self._network = _load(file, runtime)
        self._sides = _choose_sides(self._network.sides, size)
        prepared = _PREPARED.get(self._sides[0], (None, None))
        self._mean, self._deviation = (
            _read_numbers(what, standard if value is None else value, 3)
            for what, value, standard in zip(("mean", "deviation"), (mean, deviation), prepared)
        )
        if not np.all(self._deviation):
            raise UserError("`deviation` must not be 0")

    @property
    def name(self) -> str:
        """The segmenter and its network."""
        return f"salient:{self._label}"

    def segment(self, frames: np.ndarray, prompt: SegmentPrompt | None) -> Masks:
        """Masks of the object; see `protocols.Segmenter`. It takes no prompt."""
        if prompt is not None:
            raise UserError("a salient-object network takes no prompt", do="Leave it out, or choose `sam2`")
        return Masks(np.stack([remove_specks(self._look(frame) > self._threshold) for frame in frames]))

    def _look(self, frame: np.ndarray) -> np.ndarray:
        """The network's map of a picture at the picture's size, shape (H, W)."""
        height, width = self._sides
        small = cv2.resize(frame, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32)
        fed = ((small - self._mean) / self._deviation).astype(np.float32).transpose(2, 0, 1)[None]
        try:
            seen = np.asarray(self._network.run(np.ascontiguousarray(fed)), np.float32)
        except Exception as error:  # each runtime raises its own
            raise UserError("the network of `salient` cannot be run", got=shorten(error)) from None
        if seen.ndim < 2 or seen.size != seen.shape[-1] * seen.shape[-2]:
            raise UserError("the network of `salient` must make one map first", got=seen.shape)
        return cv2.resize(seen.reshape(seen.shape[-2:]), frame.shape[1::-1], interpolation=cv2.INTER_LINEAR)


def _load(file: Path, runtime: object) -> _Network:
    loaders = {"onnxruntime": _load_onnxruntime, "openvino": _load_openvino}
    if runtime != "auto" and runtime not in loaders:
        raise UserError(
            "`runtime` of `salient` is not known",
            got=repr(runtime)[:80],
            do=f"Known: auto, {', '.join(loaders)}",
        )
    missing: UserError | None = None
    for name in loaders if runtime == "auto" else (str(runtime),):
        try:
            package = import_package(name, "`salient`", EXTRA)
        except UserError as error:
            missing = missing or error
            continue
        try:
            return loaders[name](package, file)
        except Exception as error:  # each runtime raises its own
            raise UserError(
                f"{shorten(file)} is no network that {name} can read", got=shorten(error)
            ) from None
    assert missing is not None
    raise missing


def _load_onnxruntime(package: Any, file: Path) -> _Network:
    options = package.SessionOptions()
    options.add_session_config_entry(
        "session.intra_op.allow_spinning", "0"
    )  # waiting threads leave others the cores
    session = package.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    fed, made = session.get_inputs()[0], session.get_outputs()[0]
    sides = [side if isinstance(side, int) else None for side in fed.shape[-2:]]
    return _Network(lambda x: session.run([made.name], {fed.name: x})[0], (sides[0], sides[1]))


def _load_openvino(package: Any, file: Path) -> _Network:
    model = package.Core().compile_model(str(file), "CPU")
    sides = [
        side.get_length() if side.is_static else None for side in list(model.input(0).partial_shape)[-2:]
    ]
    return _Network(lambda x: model([x])[model.output(0)], (sides[0], sides[1]))


def _choose_sides(fixed: tuple[int | None, int | None], size: object) -> tuple[int, int]:
    """Height and width of what is fed.

    Raises:
        UserError: The network takes any, and no size is given; or it takes another.
    """
    if size is not None and (isinstance(size, bool) or not isinstance(size, int) or not 16 <= size <= 4096):
        raise UserError("`size` of `salient` must be 16 to 4096 pixels", got=repr(size)[:80])
    height, width = (size if side is None else side for side in fixed)
    if not isinstance(height, int) or not isinstance(width, int):
        raise UserError("the network takes pictures of any size", do="Give the option `size` of `salient`")
    if size is not None and (height, width) != (size, size):
        raise UserError(f"the network takes {width} x {height} pixels", got=size, do="Leave `size` out")
    return height, width


def _read_numbers(what: str, value: object, count: int) -> np.ndarray:
    """``count`` finite numbers; one stands for all of them.

    Raises:
        UserError: They are none.
    """
    if value is None:
        raise UserError(
            f"`{what}` of `salient` is not known for an input of this size", do="Give `mean` and `deviation`"
        )
    try:
        numbers = np.broadcast_to(np.asarray(value, np.float32), count)
    except (TypeError, ValueError):
        numbers = np.full(count, np.nan)
    if not np.isfinite(numbers).all():
        raise UserError(f"`{what}` of `salient` must be {count} numbers, or one", got=repr(value)[:80])
    return numbers
