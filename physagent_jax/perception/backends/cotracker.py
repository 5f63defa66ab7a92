"""Point tracks by CoTracker 3 (Karaev et al. 2024), from a checkout of its authors' repository."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import find_models_folder
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import check_regular, shorten
from physagent_jax.perception.backends.pretrained import EXTRA, choose_device
from physagent_jax.perception.protocols import Tracker, Tracks

CHECKOUT, CHECKPOINT = "co-tracker", "checkpoints/scaled_offline.pth"
_ENTRY = "cotracker3_offline"
_MOST_BYTES = 2**32  # of a checkpoint


class CoTracker(Tracker):
    """CoTracker 3 offline: all points of a query are followed together, through occlusion too.

    Its code and weights are CC BY-NC 4.0. The code is that of the folder, which is run; weights are read as data.

    Args:
        path: Checkout of the repository; None = ``co-tracker`` in `find_models_folder`.
        weights: Checkpoint; None = ``checkpoints/scaled_offline.pth`` in the checkout.
        device: Device of torch; "auto" = a GPU if there is one.
        points: Points followed together, at most; fewer take less memory.

    Raises:
        UserError: Checkout or weights are missing or do not fit, or an option is out of range.
    """

    def __init__(
        self, path: str | None = None, *, weights: str | None = None, device: str = "auto", points: int = 512
    ):
        if isinstance(points, bool) or not isinstance(points, int) or not 1 <= points <= 100_000:
            raise UserError("`points` must be 1 to 100000", got=repr(points)[:80])
        for what, value in (("path", path), ("weights", weights)):
            if value is not None and not isinstance(value, str):
                raise UserError(f"`{what}` of `cotracker` must be a path", got=repr(value)[:80])
        folder = find_models_folder() / CHECKOUT if path is None else Path(path).expanduser()
        file = folder / CHECKPOINT if weights is None else Path(weights).expanduser()
        if not (folder / "hubconf.py").is_file():
            raise UserError(
                "there is no checkout of co-tracker in this folder",
                got=shorten(folder),
                do="Give the option `path`; `physagent models` tells where it comes from, and its licence",
            )
        check_regular(file, most=_MOST_BYTES, what="the checkpoint of `cotracker`")
        torch = self._torch = import_package("torch", "`cotracker`", EXTRA)
        self._device, self._label, self.points = choose_device(torch, device), file.stem, points
        try:
            predictor = torch.hub.load(str(folder), _ENTRY, source="local", pretrained=False)
            state = torch.load(file, map_location="cpu", weights_only=True)
            predictor.model.load_state_dict(state.get("model", state))
            self._predictor: Any = predictor.to(self._device).eval()
        except Exception as error:  # code of the folder and its packages raise anything
            raise UserError(
                f"the tracker in {shorten(folder)} cannot be loaded",
                got=shorten(f"{type(error).__name__}: {error}"),
            ) from None

    @property
    def name(self) -> str:
        """The model and its weights."""
        return f"cotracker:{self._label}"

    def encode(self, frames: np.ndarray, masks: np.ndarray) -> CoTrackerClip:
        """The clip on the device; the predictor computes its features anew for each query."""
        del masks
        video = self._torch.from_numpy(np.ascontiguousarray(frames)).permute(0, 3, 1, 2)[None]
        return CoTrackerClip(self, video)

    def predict(self, video: Any, queries: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The predictor's answer for points.

        Args:
            video: Pictures, a tensor of uint8, shape (1, T, 3, H, W).
            queries: Points (t, x, y), pixel centres at integers, shape (N, 3).

        Returns:
            Positions [px], shape (T, N, 2); whether they are visible, shape (T, N); their confidence, 0..1, shape
            (T, N): that of the model if it tells one, else 1.
        """
        torch, model = self._torch, self._predictor.model
        told: list[Any] = []
        # The predictor keeps visibility after a threshold and drops the model's confidence.
        inner, own = model.forward, "forward" in vars(model)

        def listen(*args: Any, **kwargs: Any) -> Any:
            told.append(inner(*args, **kwargs))
            return told[-1]

        model.forward = listen
        try:
            with torch.inference_mode():
                asked = torch.as_tensor(queries, dtype=torch.float32, device=self._device)[None]
                xy, visible = self._predictor(video.to(self._device).float(), queries=asked)
        finally:
            if own:
                model.forward = inner
            else:
                del model.forward
        xy, visible = xy[0].float().cpu().numpy(), visible[0].cpu().numpy() > 0
        sure = np.ones(visible.shape)
        if told and len(told[0]) > 3:
            sure = told[0][2][0, :, : len(queries)].float().cpu().numpy()
        return xy, visible, sure


@dataclasses.dataclass(frozen=True)
class CoTrackerClip:
    """Implements `protocols.EncodedClip`; points are followed forwards only.

    Attributes:
        tracker: The tracker.
        video: Pictures, a tensor of uint8, shape (1, T, 3, H, W).
    """

    tracker: CoTracker
    video: Any

    def track(self, queries: np.ndarray, until: int | None = None) -> Tracks:
        """Tracks of ``queries``, invisible before their frames and from ``until`` on."""
        count = self.video.shape[1]
        xy = np.repeat(np.asarray(queries, np.float64)[None, :, 1:], count, axis=0)
        visible, sure = np.zeros(xy.shape[:2], bool), np.zeros(xy.shape[:2])
        starts = queries[:, 0].astype(int)
        first, last = int(starts.min(initial=count)), count if until is None else min(until, count)
        if first < last:
            for begin in range(0, len(queries), self.tracker.points):
                some = slice(begin, begin + self.tracker.points)
                span = slice(first, last)
                moved = self.tracker.predict(self.video[:, span], queries[some] - (first, 0.5, 0.5))
                xy[span, some], visible[span, some], sure[span, some] = moved[0] + 0.5, moved[1], moved[2]
        visible &= np.arange(count)[:, None] >= starts
        return Tracks(xy, visible, sure)
