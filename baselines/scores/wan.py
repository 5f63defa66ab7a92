"""Wan 2.1 T2V 1.3B (Wan Team 2025): Apache-2.0, the default of the real priors. It predicts a flow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from baselines.scores import sds
from baselines.scores.diffusers_prior import DiffusersPrior
from physagent_jax.core.errors import UserError

_TOKENS = 512


class WanPrior(DiffusersPrior):
    """A flow transformer over latents of four frames each.

    Components: `WanTransformer3DModel`, `AutoencoderKLWan`, `UMT5EncoderModel`, and a flow scheduler, of which the
    shift is read. Weights for instance Wan-AI/Wan2.1-T2V-1.3B-Diffusers. The autoencoder cannot recompute its
    activations, so clips are short and small by default.
    """

    name = "wan"
    licence = "Apache-2.0"
    default_frames = 17
    default_size = (256, 256)
    default_settings = sds.SdsSettings(guidance=5.0, weighting=sds.Weighting.UNIFORM)

    @classmethod
    def load_components(cls, load_part: Callable[..., Any], dtype: Any) -> tuple[Any, Any, Any]:
        """As in the base."""
        return (
            load_part("diffusers", "WanTransformer3DModel", "transformer", torch_dtype=dtype),
            load_part("diffusers", "AutoencoderKLWan", "vae"),
            load_part("diffusers", "FlowMatchEulerDiscreteScheduler", "scheduler"),
        )

    @classmethod
    def load_text_encoder(
        cls, load_part: Callable[..., Any], dtype: Any, device: str
    ) -> Callable[[str], Any]:
        """As in the base: UMT5 over the words, zeros behind them."""
        tokenizer = load_part("transformers", "AutoTokenizer", "tokenizer")
        encoder = load_part("transformers", "UMT5EncoderModel", "text_encoder", dtype=dtype).to(device).eval()

        def encode(prompt: str) -> Any:
            tokens = tokenizer(
                [prompt], padding="max_length", max_length=_TOKENS, truncation=True, return_tensors="pt"
            ).to(device)
            hidden = encoder(tokens.input_ids, tokens.attention_mask).last_hidden_state
            return hidden * tokens.attention_mask[..., None]

        return encode

    def find_form(self) -> sds.Form:
        """A flow."""
        return sds.Form.FLOW

    def check_shape(self) -> None:
        """Refuse sizes that the autoencoder or the patches do not divide."""
        across = self.vae.config.scale_factor_spatial * self.denoiser.config.patch_size[-1]
        along = self.vae.config.scale_factor_temporal
        if any(side % across for side in self.size) or self.frames % along != 1:
            raise UserError(
                f"`size` must be multiples of {across}, and `frames` one more than a multiple of {along}",
                got=f"{self.size}, {self.frames}",
            )

    def find_level(self, position: float) -> sds.Level:
        """s = shift p / (1 + (shift - 1) p): the model's own schedule puts more steps where there is more noise."""
        said = self.scheduler.config
        shift = float(said.get("flow_shift") or said.get("shift") or 1.0)
        share = shift * position / (1 + (shift - 1) * position)
        return sds.Level(share * said.num_train_timesteps, 1 - share, share)

    def encode(self, pixels: Any) -> Any:
        """Standardised by channel, shape (1, channels, latent frames, h, w)."""
        latent = self.vae.encode(pixels.movedim(0, 1)[None]).latent_dist.mode()
        mean, deviation = (
            self._torch.tensor(getattr(self.vae.config, name)).to(latent).view(1, -1, 1, 1, 1)
            for name in ("latents_mean", "latents_std")
        )
        return (latent - mean) / deviation

    def predict(self, noisy: Any, level: sds.Level, embedding: Any) -> Any:
        """As in the base."""
        when = self._torch.tensor([level.time], device=noisy.device, dtype=self._torch.float32)
        return self.denoiser(noisy, when, embedding, return_dict=False)[0]
