"""CogVideoX-2B (Yang et al. 2024): Apache-2.0, a diffusion transformer over latents of four frames each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from baselines.scores import sds
from baselines.scores.diffusers_prior import DiffusersPrior, find_scheduled_form, find_scheduled_level
from physagent_jax.core.errors import UserError

_TOKENS = 226


class CogVideoXPrior(DiffusersPrior):
    """The 2B model; the 5B ones rotate their positions and have another licence: they are refused.

    Components: `CogVideoXTransformer3DModel`, `AutoencoderKLCogVideoX`, `T5EncoderModel`, `CogVideoXDDIMScheduler`.
    Weights for instance zai-org/CogVideoX-2b.
    """

    name = "cogvideox"
    licence = "Apache-2.0 (CogVideoX-2b)"
    default_frames = 17
    default_size = (256, 384)
    default_settings = sds.SdsSettings(guidance=6.0)

    @classmethod
    def load_components(cls, load_part: Callable[..., Any], dtype: Any) -> tuple[Any, Any, Any]:
        """As in the base."""
        return (
            load_part("diffusers", "CogVideoXTransformer3DModel", "transformer", torch_dtype=dtype),
            load_part("diffusers", "AutoencoderKLCogVideoX", "vae"),
            load_part("diffusers", "CogVideoXDDIMScheduler", "scheduler"),
        )

    @classmethod
    def load_text_encoder(
        cls, load_part: Callable[..., Any], dtype: Any, device: str
    ) -> Callable[[str], Any]:
        """As in the base: T5 over padded text, the padding not masked."""
        tokenizer = load_part("transformers", "AutoTokenizer", "tokenizer")
        encoder = load_part("transformers", "T5EncoderModel", "text_encoder", dtype=dtype).to(device).eval()

        def encode(prompt: str) -> Any:
            tokens = tokenizer(
                [prompt], padding="max_length", max_length=_TOKENS, truncation=True, return_tensors="pt"
            )
            return encoder(tokens.input_ids.to(device)).last_hidden_state

        return encode

    def find_form(self) -> sds.Form:
        """As the scheduler says; v for the published weights."""
        return find_scheduled_form(self.scheduler)

    def check_shape(self) -> None:
        """Refuse sizes that the autoencoder or the patches do not divide, and models with rotated positions."""
        if self.denoiser.config.use_rotary_positional_embeddings:
            raise UserError("CogVideoX with rotary positions is not supported", do="Take CogVideoX-2b")
        shrink = 2 ** (len(self.vae.config.block_out_channels) - 1) * self.denoiser.config.patch_size
        ratio = self.vae.config.temporal_compression_ratio
        if any(side % shrink for side in self.size) or self.frames % ratio != 1:
            raise UserError(
                f"`size` must be multiples of {shrink}, and `frames` one more than a multiple of {ratio}",
                got=f"{self.size}, {self.frames}",
            )

    def find_level(self, position: float) -> sds.Level:
        """As in the base."""
        return find_scheduled_level(self.scheduler, position)

    def encode(self, pixels: Any) -> Any:
        """Shape (1, latent frames, channels, h, w)."""
        latent = self.vae.encode(pixels.movedim(0, 1)[None]).latent_dist.mode()
        return latent.movedim(1, 2) * self.vae.config.scaling_factor

    def predict(self, noisy: Any, level: sds.Level, embedding: Any) -> Any:
        """As in the base."""
        when = self._torch.tensor([int(level.time)], device=noisy.device)
        return self.denoiser(noisy, embedding, when, return_dict=False)[0]
