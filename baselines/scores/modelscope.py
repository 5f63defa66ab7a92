"""ModelScope text-to-video 1.7B (Wang et al. 2023): the video prior of DreamPhysics, Physics3D and OmniPhysGS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from baselines.scores import sds
from baselines.scores.diffusers_prior import DiffusersPrior, find_scheduled_form, find_scheduled_level
from physagent_jax.core.errors import UserError


class ModelScopePrior(DiffusersPrior):
    """A 3D UNet over latents of single frames; ZeroScope has the same classes.

    Components: `UNet3DConditionModel`, `AutoencoderKL`, `CLIPTextModel`, `DDIMScheduler`. Weights for instance
    ali-vilab/text-to-video-ms-1.7b.
    """

    name = "modelscope"
    licence = "CC BY-NC 4.0: not for commercial use"
    default_frames = 16
    default_size = (256, 256)
    default_settings = sds.SdsSettings(guidance=sds.PUBLISHED_GUIDANCE)

    @classmethod
    def load_components(cls, load_part: Callable[..., Any], dtype: Any) -> tuple[Any, Any, Any]:
        """As in the base."""
        return (
            load_part("diffusers", "UNet3DConditionModel", "unet", torch_dtype=dtype),
            load_part("diffusers", "AutoencoderKL", "vae"),
            load_part("diffusers", "DDIMScheduler", "scheduler"),
        )

    @classmethod
    def load_text_encoder(
        cls, load_part: Callable[..., Any], dtype: Any, device: str
    ) -> Callable[[str], Any]:
        """As in the base: CLIP's last layer."""
        tokenizer = load_part("transformers", "CLIPTokenizer", "tokenizer")
        encoder = load_part("transformers", "CLIPTextModel", "text_encoder", dtype=dtype).to(device).eval()

        def encode(prompt: str) -> Any:
            tokens = tokenizer(
                [prompt],
                padding="max_length",
                max_length=tokenizer.model_max_length,
                truncation=True,
                return_tensors="pt",
            )
            return encoder(tokens.input_ids.to(device)).last_hidden_state

        return encode

    def find_form(self) -> sds.Form:
        """As the scheduler says; epsilon for the published weights."""
        return find_scheduled_form(self.scheduler)

    def check_shape(self) -> None:
        """Height and width must survive the autoencoder's and the UNet's halvings."""
        halvings = len(self.vae.config.block_out_channels) + len(self.denoiser.config.block_out_channels) - 2
        if any(side % 2**halvings for side in self.size) or self.frames < 1:
            raise UserError(f"`size` must be multiples of {2**halvings}", got=self.size)

    def find_level(self, position: float) -> sds.Level:
        """As in the base."""
        return find_scheduled_level(self.scheduler, position)

    def encode(self, pixels: Any) -> Any:
        """Frame by frame, shape (1, channels, frames, h, w)."""
        encoded = [self._encode_frame(frame) for frame in pixels.split(1)]
        return self._torch.cat(encoded).movedim(0, 1)[None]

    def predict(self, noisy: Any, level: sds.Level, embedding: Any) -> Any:
        """As in the base."""
        return self.denoiser(noisy, int(level.time), encoder_hidden_states=embedding, return_dict=False)[0]

    def pull(self, pixels: Any, find_gradient: Callable[[Any], Any]) -> Any:
        """As in the base, one frame after another: each is encoded twice, and memory is that of one."""
        torch = self._torch
        with torch.no_grad():
            by_latent = find_gradient(self.encode(pixels))[0].movedim(1, 0)
        found = []
        for frame, slope in zip(pixels.split(1), by_latent.split(1)):
            frame = frame.detach().requires_grad_()
            found.append(torch.autograd.grad(self._encode_frame(frame), frame, slope)[0])
        return torch.cat(found)

    def _encode_frame(self, frame: Any) -> Any:
        return self.vae.encode(frame).latent_dist.mode() * self.vae.config.scaling_factor
