"""Shared parts of adapters to the video models of `diffusers`: components, not pipelines; a differentiable encoder.

A prior is made of components that the caller has (`__init__`), or loads them (`load`) from a folder or a hub id that
the caller names. Nothing is downloaded unless that is asked for.
"""

from __future__ import annotations

import abc
import importlib
import time
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.scores import sds
from baselines.scores.protocol import Cost, Key
from physagent_jax.core.errors import MissingPackageError, UserError


def import_optional(name: str) -> Any:
    """A module of the extra `sds`.

    Raises:
        MissingPackageError: It is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        what = f"real score priors need `{name.split('.')[0]}` ({error})"
        raise MissingPackageError(what, "sds") from None


class DiffusersPrior(abc.ABC):
    """A score prior of a pretrained denoiser, its autoencoder and its text encoder.

    Args:
        denoiser: UNet or transformer.
        vae: Autoencoder; its mean is taken, not a sample.
        scheduler: Scheduler of the model: its noise levels, and what the denoiser predicts.
        frames, size: Length of the clips and (height, width) [px] that the model is shown; others are made so, by
            leaving frames out and by bilinear interpolation.
        settings: How the gradient is estimated; None = the model's usual.
        encode_text: Maps a sentence to the embedding that the denoiser takes, shape (1, tokens, channels).
        embeddings: Embeddings known by their sentence, asked first; "" is the one without a prompt.
        device: Where to run: "cpu", "cuda".
    """

    name: ClassVar[str]
    licence: ClassVar[str]
    default_frames: ClassVar[int]
    default_size: ClassVar[tuple[int, int]]
    default_settings: ClassVar[sds.SdsSettings]
    toy = False

    def __init__(
        self,
        denoiser: Any,
        vae: Any,
        scheduler: Any,
        *,
        frames: int | None = None,
        size: tuple[int, int] | None = None,
        settings: sds.SdsSettings | None = None,
        encode_text: Callable[[str], Any] | None = None,
        embeddings: Mapping[str, Any] | None = None,
        device: str = "cpu",
    ):
        self._torch = import_optional("torch")
        self.denoiser = denoiser.to(device).eval().requires_grad_(False)
        self.vae = vae.to(device).eval().requires_grad_(False)
        self.scheduler = scheduler
        self.frames = self.default_frames if frames is None else frames
        self.size = self.default_size if size is None else tuple(size)
        self.settings = settings or self.default_settings
        self.cost = Cost()
        self._encode_text, self._device = encode_text, device
        self.embeddings = dict(embeddings or {})
        self.form = self.find_form()
        self.check_shape()

    @classmethod
    def load(
        cls,
        weights: str,
        *,
        download: bool = False,
        device: str = "cpu",
        dtype: str = "float32",
        embeddings: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> DiffusersPrior:
        """Load the components and say under which licence their weights are.

        Args:
            weights: Folder with the model's subfolders, or a hub id.
            download: Whether what is not on this machine may be fetched from the hub.
            device: As in the class.
            dtype: Type of denoiser and text encoder: "float32", "float16" or "bfloat16". The autoencoder stays
                in single
                precision, in which its gradient is finite.
            embeddings: As in the class; with these no text encoder is loaded.
            options: Others of the class.

        Raises:
            UserError: The extra is not installed, or the weights are not there.
        """
        torch = import_optional("torch")
        precision = getattr(torch, dtype)

        def load_part(place: str, name: str, subfolder: str, **more: Any) -> Any:
            source = getattr(import_optional(place), name)
            try:
                return source.from_pretrained(
                    weights, subfolder=subfolder, local_files_only=not download, **more
                )
            except (OSError, ValueError) as error:
                raise UserError(
                    f"`{subfolder}` of {cls.name} cannot be read ({str(error).splitlines()[0][:150]})",
                    got=weights,
                    do="Give a folder with the model, or a hub id with `download=True`",
                ) from None

        denoiser, vae, scheduler = cls.load_components(load_part, precision)
        encode = None
        if embeddings is None:
            encode = cls.load_text_encoder(load_part, precision, device)
        print(f"{cls.name}: weights of {weights}, {cls.licence}")
        return cls(
            denoiser, vae, scheduler, device=device, encode_text=encode, embeddings=embeddings, **options
        )

    @classmethod
    @abc.abstractmethod
    def load_components(cls, load_part: Callable[..., Any], dtype: Any) -> tuple[Any, Any, Any]:
        """Denoiser, autoencoder and scheduler; ``load_part(module, class, subfolder, **options)`` loads one."""

    @classmethod
    @abc.abstractmethod
    def load_text_encoder(
        cls, load_part: Callable[..., Any], dtype: Any, device: str
    ) -> Callable[[str], Any]:
        """``encode_text`` of the class."""

    @abc.abstractmethod
    def find_form(self) -> sds.Form:
        """The denoiser's prediction form."""

    @abc.abstractmethod
    def check_shape(self) -> None:
        """Refuse `frames` and `size` that the model cannot take."""

    @abc.abstractmethod
    def find_level(self, position: float) -> sds.Level:
        """The noise level at a position in [0, 1]."""

    @abc.abstractmethod
    def encode(self, pixels: Any) -> Any:
        """Latent of frames in [-1, 1], shape (frames, 3, height, width); differentiable."""

    @abc.abstractmethod
    def predict(self, noisy: Any, level: sds.Level, embedding: Any) -> Any:
        """The denoiser's answer, in the latent's shape."""

    def gradient(
        self, video: np.ndarray, prompt: str, key: Key, *, still: np.ndarray | None = None
    ) -> np.ndarray:
        """As in `ScorePrior`."""
        begun, torch = time.perf_counter(), self._torch
        video = sds.check_video(video)
        prompted, bare = (self._embed(text) for text in (prompt, ""))
        picked = sds.pick_frames(len(video), self.frames)
        shown = torch.tensor(video[picked], device=self._device).requires_grad_()
        resized = self._resize(shown)

        def find_gradient(clean: Any) -> Any:
            drawn = sds.draw(self.settings, key, clean.shape)
            with torch.no_grad():
                beside = self._encode_still(video if still is None else still, picked)
                return sds.compute_latent_gradient(
                    self.form,
                    lambda noisy, level, told: self._call(noisy, level, prompted if told else bare),
                    clean,
                    [(self.find_level(each.time), torch.tensor(each.noise).to(clean)) for each in drawn],
                    self.settings,
                    beside,
                )

        by_resized = self.pull(resized.detach(), find_gradient)
        (by_shown,) = torch.autograd.grad(resized, shown, by_resized)
        gradient = np.zeros(video.shape, np.float32)
        np.add.at(gradient, picked, by_shown.cpu().numpy())
        if not np.isfinite(gradient).all():
            raise UserError(
                f"the gradient of {self.name} is not finite",
                do="Load it with `dtype='float32'` or 'bfloat16'",
            )
        self.cost.seconds += time.perf_counter() - begun
        return gradient

    def pull(self, pixels: Any, find_gradient: Callable[[Any], Any]) -> Any:
        """The gradient by the pixels from that by their latent, which ``find_gradient`` gives for a latent."""
        pixels.requires_grad_()
        latent = self.encode(pixels)
        (gradient,) = self._torch.autograd.grad(latent, pixels, find_gradient(latent.detach()))
        return gradient

    def _embed(self, prompt: str) -> Any:
        if prompt not in self.embeddings:
            if self._encode_text is None:
                raise UserError(
                    f"{self.name} has no text encoder and no embedding of the prompt",
                    got=repr(prompt),
                    do="Give `encode_text`, or `embeddings` with it and with ''",
                )
            with self._torch.no_grad():
                self.embeddings[prompt] = self._encode_text(prompt)
        found = self._torch.as_tensor(self.embeddings[prompt])
        return found.to(device=self._device, dtype=next(self.denoiser.parameters()).dtype)

    def _resize(self, frames: Any) -> Any:
        """Frames (f, H, W, 3) in [0, 1] as (f, 3, height, width) in [-1, 1]."""
        resize = self._torch.nn.functional.interpolate
        moved = frames.permute(0, 3, 1, 2)
        return 2 * resize(moved, self.size, mode="bilinear", align_corners=False, antialias=True) - 1

    def _encode_still(self, clip: np.ndarray, picked: np.ndarray) -> Any:
        """Latent of the still clip; a moving clip is stopped at its first frame."""
        if not self.settings.motion:
            return None
        frames = self._torch.tensor(sds.repeat_first(sds.check_video(clip))[picked], device=self._device)
        return self.encode(self._resize(frames))

    def _call(self, noisy: Any, level: sds.Level, embedding: Any) -> Any:
        """`predict`, counted, with the denoiser in its own precision."""
        self.cost.calls += 1
        own = next(self.denoiser.parameters()).dtype
        return self.predict(noisy.to(own), level, embedding).to(noisy.dtype)


def find_scheduled_form(scheduler: Any) -> sds.Form:
    """The denoiser's prediction form, from a DDPM-like scheduler's configuration.

    Raises:
        UserError: It is the clean sample.
    """
    said = scheduler.config.prediction_type
    if said not in (sds.Form.EPSILON, sds.Form.V):
        raise UserError("the scheduler's prediction type is not supported", got=said)
    return sds.Form(said)


def find_scheduled_level(scheduler: Any, position: float) -> sds.Level:
    """The level of a DDPM-like scheduler, whose steps are whole numbers."""
    count = scheduler.config.num_train_timesteps
    step = min(int(position * count), count - 1)
    share = float(scheduler.alphas_cumprod[step])
    return sds.Level(step, share**0.5, (1 - share) ** 0.5)
