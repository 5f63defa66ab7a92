"""The toy prior as a `ScorePrior`: for tests of the machinery, never evidence about video models."""

from __future__ import annotations

import dataclasses
import json
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from baselines.scores import sds
from baselines.scores.protocol import Cost, Key
from baselines.scores.toy.motions import read_prompt
from baselines.scores.toy.validation import LEAST_ACCURACY, Validation
from physagent_jax.core.errors import MissingPackageError, UserError

try:
    import orbax.checkpoint as ocp  # pyright: ignore[reportMissingImports]
    from flax import nnx  # pyright: ignore[reportMissingImports]

    from baselines.scores.toy.model import ModelConfig, ToyVideoModel
except ImportError as error:
    raise MissingPackageError(f"the toy prior needs flax and orbax ({error})", "toy") from None

_RECORD, _WEIGHTS = "toy_prior.json", "weights"
SETTINGS = sds.SdsSettings(
    guidance=3.0, time_range=(0.3, 0.95), draws=4, antithetic=True, weighting=sds.Weighting.UNIFORM
)


class ToyPrior:
    """A small denoiser trained by `baselines.scores.toy.train`.

    Args:
        model: The denoiser.
        validation: How it did on held-out clips.
        settings: How the gradient is estimated.

    Raises:
        UserError: Its validation is below `LEAST_ACCURACY`.
    """

    name = "toy prior"
    toy = True
    licence = "Apache-2.0"
    default_settings = SETTINGS

    def __init__(self, model: ToyVideoModel, validation: Validation, settings: sds.SdsSettings = SETTINGS):
        if not validation.accuracy >= LEAST_ACCURACY:
            raise UserError(
                f"the toy prior finds the prompt of too few held-out clips: at least {LEAST_ACCURACY:.0%} are needed",
                got=f"{validation.accuracy:.0%}",
                do="Train it longer: python -m baselines.scores.toy.train",
            )
        self.validation, self.settings, self.cost = validation, settings, Cost()
        self._config = model.config
        graph, state = nnx.split(model)
        self._predict = jax.jit(lambda *args: nnx.merge(graph, state)(*args))

    @staticmethod
    def load(weights: str | Path, settings: sds.SdsSettings = SETTINGS) -> ToyPrior:
        """Load what `save` wrote.

        Raises:
            UserError: There is none in the folder, or it is refused.
        """
        folder = Path(weights).resolve()
        if not (folder / _RECORD).exists():
            raise UserError(
                "there is no toy prior in the folder",
                got=weights,
                do="Train it: python -m baselines.scores.toy.train",
            )
        record = json.loads((folder / _RECORD).read_text())
        config = ModelConfig(**record["config"])
        graph, abstract = nnx.split(nnx.eval_shape(lambda: ToyVideoModel(config, rngs=nnx.Rngs(0))))
        with ocp.StandardCheckpointer() as checkpointer:
            state = checkpointer.restore(folder / _WEIGHTS, abstract)
        return ToyPrior(nnx.merge(graph, state), Validation(**record["validation"]), settings)

    def gradient(
        self, video: np.ndarray, prompt: str, key: Key, *, still: np.ndarray | None = None
    ) -> np.ndarray:
        """As in `ScorePrior`."""
        begun = time.perf_counter()
        video = sds.check_video(video)
        shown, pull = jax.vjp(self.encode, video)
        words = jnp.asarray(read_prompt(prompt))
        beside = None
        if self.settings.motion:
            beside = self.encode(sds.repeat_first(video if still is None else sds.check_video(still)))
        by_latent = sds.compute_latent_gradient(
            sds.Form.FLOW,
            lambda noisy, level, told: self._call(noisy, level, words if told else 0 * words),
            shown,
            [
                (sds.Level(each.time, 1 - each.time, each.time), jnp.asarray(each.noise))
                for each in sds.draw(self.settings, key, shown.shape)
            ],
            self.settings,
            beside,
        )
        gradient = np.asarray(pull(by_latent)[0])
        self.cost.seconds += time.perf_counter() - begun
        return gradient

    def encode(self, video: jax.Array | np.ndarray) -> jax.Array:
        """A clip as the model is shown it, in [-1, 1], shape (frames, size, size, 3); linear.

        Its border is repeated until pictures are square.
        """
        frames, size = self._config.frames, self._config.size
        picked = jnp.asarray(video)[sds.pick_frames(len(video), frames)]
        _, height, width, _ = picked.shape
        lacking = [(max(height, width) - side) for side in (height, width)]
        margins = [(0, 0), *((each // 2, each - each // 2) for each in lacking), (0, 0)]
        square = jnp.pad(picked, margins, mode="edge")
        return 2 * jax.image.resize(square, (frames, size, size, 3), "linear", antialias=True) - 1

    def _call(self, noisy: jax.Array, level: sds.Level, words: jax.Array) -> jax.Array:
        self.cost.calls += 1
        return self._predict(noisy[None], jnp.full(1, level.sigma, noisy.dtype), words[None])[0]


def save(folder: Path, model: ToyVideoModel, validation: Validation, trained: dict) -> None:
    """Write the weights by orbax, and a record of what they are.

    Args:
        folder: Where to; weights there are replaced.
        model: What was trained.
        validation: How it did.
        trained: How, for the record.
    """
    folder = folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    with ocp.StandardCheckpointer() as checkpointer:
        checkpointer.save(folder / _WEIGHTS, nnx.state(model), force=True)
    record = dict(
        config=dataclasses.asdict(model.config), validation=dataclasses.asdict(validation), trained=trained
    )
    (folder / _RECORD).write_text(json.dumps(record, indent=2) + "\n")
