"""Adapters to diffusers' video models, on tiny instances of the real classes with random weights.

The reference of each gradient is torch's derivative of the published loss, 0.5 |x0 - (x0 - g).detach()|^2, written here
with diffusers' own schedulers (`add_noise`, `get_velocity`, `scale_noise`) and its own encoders.
"""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs the extra `sds`")
diffusers = pytest.importorskip("diffusers", reason="needs the extra `sds`")

from baselines.scores import open_prior, sds  # noqa: E402
from baselines.scores.cogvideox import CogVideoXPrior  # noqa: E402
from baselines.scores.modelscope import ModelScopePrior  # noqa: E402
from baselines.scores.wan import WanPrior  # noqa: E402
from physagent_jax.core.errors import UserError  # noqa: E402

PROMPT = "a ficus sways"
torch.set_num_threads(1)  # more only wait for each other on tensors this small


def make_modelscope(prediction_type="epsilon"):
    unet = diffusers.UNet3DConditionModel(
        block_out_channels=(4, 8),
        layers_per_block=1,
        sample_size=32,
        in_channels=4,
        out_channels=4,
        down_block_types=("CrossAttnDownBlock3D", "DownBlock3D"),
        up_block_types=("UpBlock3D", "CrossAttnUpBlock3D"),
        cross_attention_dim=4,
        attention_head_dim=4,
        norm_num_groups=2,
    )
    vae = diffusers.AutoencoderKL(
        block_out_channels=(8,),
        down_block_types=["DownEncoderBlock2D"],
        up_block_types=["UpDecoderBlock2D"],
        latent_channels=4,
        sample_size=32,
        norm_num_groups=2,
    )
    scheduler = diffusers.DDIMScheduler(
        beta_start=0.00085,
        beta_end=0.012,
        beta_schedule="scaled_linear",
        clip_sample=False,
        set_alpha_to_one=False,
        prediction_type=prediction_type,
    )
    return unet, vae, scheduler


def make_cogvideox():
    transformer = diffusers.CogVideoXTransformer3DModel(
        num_attention_heads=4,
        attention_head_dim=8,
        in_channels=4,
        out_channels=4,
        time_embed_dim=2,
        text_embed_dim=32,
        num_layers=1,
        sample_width=2,
        sample_height=2,
        sample_frames=9,
        patch_size=2,
        temporal_compression_ratio=4,
        max_text_seq_length=16,
    )
    vae = diffusers.AutoencoderKLCogVideoX(
        down_block_types=("CogVideoXDownBlock3D",) * 4,
        up_block_types=("CogVideoXUpBlock3D",) * 4,
        block_out_channels=(8, 8, 8, 8),
        latent_channels=4,
        layers_per_block=1,
        norm_num_groups=2,
        temporal_compression_ratio=4,
    )
    return transformer, vae, diffusers.CogVideoXDDIMScheduler(prediction_type="v_prediction")


def make_wan():
    transformer = diffusers.WanTransformer3DModel(
        patch_size=(1, 2, 2),
        num_attention_heads=2,
        attention_head_dim=12,
        in_channels=16,
        out_channels=16,
        text_dim=32,
        freq_dim=256,
        ffn_dim=32,
        num_layers=2,
        cross_attn_norm=True,
        qk_norm="rms_norm_across_heads",
        rope_max_seq_len=32,
    )
    vae = diffusers.AutoencoderKLWan(
        base_dim=3,
        z_dim=16,
        dim_mult=[1, 1, 1, 1],
        num_res_blocks=1,
        temperal_downsample=[False, True, True],
    )
    return transformer, vae, diffusers.FlowMatchEulerDiscreteScheduler(shift=7.0)


KINDS = {
    "modelscope": (ModelScopePrior, make_modelscope, (4, 4), dict(frames=4, size=(16, 16))),
    "modelscope-v": (
        ModelScopePrior,
        lambda: make_modelscope("v_prediction"),
        (4, 4),
        dict(frames=4, size=(16, 16)),
    ),
    "cogvideox": (CogVideoXPrior, make_cogvideox, (16, 32), dict(frames=9, size=(16, 16))),
    "wan": (WanPrior, make_wan, (12, 32), dict(frames=9, size=(16, 16))),
}
EACH = pytest.mark.parametrize("kind", KINDS)


def make_prior(kind, **changed):
    torch.manual_seed(0)
    family, make, tokens, shape = KINDS[kind]
    embeddings = {text: torch.randn(1, *tokens) for text in (PROMPT, "")}
    return family(*make(), **(dict(embeddings=embeddings) | shape | changed))


def make_video(prior, seed=1):
    return np.random.default_rng(seed).uniform(0.1, 0.9, (prior.frames, *prior.size, 3)).astype(np.float32)


def encode(prior, pixels):
    """By diffusers' own encoders, all frames at once."""
    vae, clip = prior.vae, 2 * pixels.permute(3, 0, 1, 2) - 1  # (3, f, h, w)
    if isinstance(prior, ModelScopePrior):
        latent = vae.encode(clip.transpose(0, 1)).latent_dist.mode() * vae.config.scaling_factor
        return latent.transpose(0, 1)[None]
    latent = vae.encode(clip[None]).latent_dist.mode()
    if isinstance(prior, CogVideoXPrior):
        return latent.permute(0, 2, 1, 3, 4) * vae.config.scaling_factor
    mean = torch.tensor(vae.config.latents_mean).view(1, 16, 1, 1, 1)
    return (latent - mean) / torch.tensor(vae.config.latents_std).view(1, 16, 1, 1, 1)


def ask(prior, noisy, step, text):
    """The denoiser, called as its pipeline does."""
    embedding, time = prior.embeddings[text], torch.tensor([step])
    if isinstance(prior, ModelScopePrior):
        return prior.denoiser(noisy, time, encoder_hidden_states=embedding).sample
    if isinstance(prior, CogVideoXPrior):
        return prior.denoiser(hidden_states=noisy, encoder_hidden_states=embedding, timestep=time).sample
    return prior.denoiser(hidden_states=noisy, timestep=time, encoder_hidden_states=embedding).sample


def find_reference_slope(prior, x0, drawn):
    """g of one draw, with the published weights, by the model's own scheduler."""
    noise, settings = torch.tensor(drawn.noise), prior.settings
    scheduler = prior.scheduler
    if isinstance(prior, WanPrior):
        index = int(np.argmin(abs(scheduler.sigmas.numpy() - float(prior.find_level(drawn.time).sigma))))
        step, share = scheduler.timesteps[index], float(scheduler.sigmas[index])
        noisy = scheduler.scale_noise(x0, scheduler.timesteps[index : index + 1], noise)
        target, weight = noise - x0, share**2
    else:
        step = int(drawn.time * 1000)
        noisy = scheduler.add_noise(x0, noise, torch.tensor([step]))
        target, weight = noise, 1 - float(scheduler.alphas_cumprod[step])
    with torch.no_grad():
        told, bare = (ask(prior, noisy, step, text) for text in (PROMPT, ""))
        output = bare + settings.guidance * (told - bare)
    if scheduler.config.get("prediction_type") == "v_prediction":
        share = scheduler.alphas_cumprod[step]
        output = share**0.5 * output + (1 - share) ** 0.5 * noisy
    return (weight if settings.weighting is sds.Weighting.VARIANCE else 1.0) * (output - target)


@EACH
@pytest.mark.parametrize("motion", [False, True])
def test_pixel_gradient_is_that_of_the_published_loss(kind, motion):
    settings = sds.SdsSettings(guidance=6.0, draws=2, motion=motion)
    prior = make_prior(kind, settings=settings)
    if kind == "wan":  # its scheduler has whole steps only, the adapter any level: meet where it has one
        positions = {}

        def find_level(position, own=prior.find_level):
            sigmas = prior.scheduler.sigmas.numpy()
            share = float(sigmas[np.argmin(abs(sigmas - own(position).sigma))])
            positions[position] = share
            return sds.Level(1000 * share, 1 - share, share)

        prior.find_level = find_level
    video = make_video(prior)
    found = prior.gradient(video, PROMPT, 5)

    leaf = torch.tensor(video, requires_grad=True)
    x0 = encode(prior, leaf)
    slope = torch.zeros_like(x0)
    draws = sds.draw(settings, 5, x0.shape)
    for drawn in draws:
        slope += find_reference_slope(prior, x0.detach(), drawn) / len(draws)
        if motion:
            still = encode(prior, torch.tensor(video[:1]).expand(leaf.shape))
            slope -= find_reference_slope(prior, still, drawn) / len(draws)
    loss = 0.5 * torch.nn.functional.mse_loss(x0, (x0 - slope).detach(), reduction="sum")
    loss.backward()
    wanted = leaf.grad.numpy()
    assert np.abs(wanted).max() > 0
    assert np.abs(found - wanted).max() < 2e-4 * np.abs(wanted).max()
    assert prior.cost.calls == 2 * 2 * (1 + motion) and prior.cost.seconds > 0


@EACH
def test_levels_are_the_schedulers(kind):
    """x_t of the adapter's shares is what the scheduler makes of a clean latent, a noise and a step."""
    prior = make_prior(kind)
    clean, noise = torch.randn(2, 1, 4, 3, 5, 5)
    if kind == "wan":
        positions = np.linspace(0, 1, 1001)[1:][::-1]  # the scheduler's steps before its shift
        shares = np.array([prior.find_level(p).sigma for p in positions])
        assert np.abs(shares - prior.scheduler.sigmas.numpy()).max() < 1e-6
        steps = np.array([prior.find_level(p).time for p in positions])
        assert np.abs(steps - prior.scheduler.timesteps.numpy()).max() < 1e-3
    for position in (0.02, 0.5, 0.9799):
        level = prior.find_level(position)
        if kind != "wan":
            assert level.time == int(position * 1000)
            wanted = prior.scheduler.add_noise(clean, noise, torch.tensor([level.time]))
            assert torch.allclose(sds.add_noise(clean, noise, level), wanted, atol=1e-5)
            velocity = prior.scheduler.get_velocity if kind == "modelscope-v" else None
            if velocity:
                wanted = velocity(clean, noise, torch.tensor([level.time]))
                assert torch.allclose(sds.make_target(sds.Form.V, clean, noise, level), wanted, atol=1e-5)


@EACH
def test_gradient_is_zero_where_the_denoiser_knows_the_noise(kind):
    """A denoiser that answers with what was drawn has nothing to say about the clip."""
    prior = make_prior(kind, settings=sds.SdsSettings(guidance=3.0))
    video = make_video(prior)
    clean = encode(prior, torch.tensor(video))
    (drawn,) = sds.draw(prior.settings, 7, clean.shape)
    level = prior.find_level(drawn.time)
    prior.predict = lambda noisy, level_, embedding: sds.make_target(
        prior.form, clean, torch.tensor(drawn.noise), level
    )
    found = prior.gradient(video, PROMPT, 7)
    prior.predict = lambda noisy, level_, embedding: noisy
    other = prior.gradient(video, PROMPT, 7)
    assert np.abs(found).max() < 1e-4 * np.abs(other).max()


@EACH
def test_a_longer_and_larger_clip_is_resampled_and_its_gradient_goes_back(kind):
    """By finite differences of <g, latent>, g fixed: the adapter's own resampling and encoding, transposed."""
    prior = make_prior(kind)
    video = np.random.default_rng(3).uniform(0.2, 0.8, (2 * prior.frames - 1, 24, 20, 3)).astype(np.float32)
    slope = {}

    def keep(form, predict, clean, drawn, settings, still=None):
        return slope.setdefault("g", torch.randn(clean.shape, generator=torch.manual_seed(1)).to(clean))

    original, sds.compute_latent_gradient = sds.compute_latent_gradient, keep
    try:
        found = prior.gradient(video, PROMPT, 0)
    finally:
        sds.compute_latent_gradient = original
    picked = np.flatnonzero(np.abs(found).sum((1, 2, 3)))
    assert picked.tolist() == list(range(0, len(video), 2))

    prior.vae.double()
    way = np.random.default_rng(4).normal(size=video.shape)

    def measure(step):
        moved = torch.tensor(video + step * way).double()[picked].permute(0, 3, 1, 2)
        shown = torch.nn.functional.interpolate(moved, prior.size, mode="bilinear", antialias=True)
        return float((slope["g"].double() * encode(prior, shown.permute(0, 2, 3, 1)).double()).sum())

    step = 1e-4
    wanted = (measure(step) - measure(-step)) / (2 * step)
    assert (found * way).sum() == pytest.approx(wanted, rel=1e-3)


@EACH
def test_frames_that_are_shown_twice_have_both_gradients(kind):
    prior = make_prior(kind)
    video = make_video(prior)[: prior.frames // 2]
    places = sds.pick_frames(len(video), prior.frames)
    apart = prior.gradient(video[places], PROMPT, 1)
    wanted = np.stack([apart[places == index].sum(0) for index in range(len(video))])
    assert np.allclose(prior.gradient(video, PROMPT, 1), wanted, atol=1e-6 * np.abs(wanted).max())


@EACH
def test_the_same_key_means_the_same_draws(kind):
    prior = make_prior(kind)
    video = make_video(prior)
    one, again, other = (prior.gradient(video, PROMPT, key) for key in (1, 1, 2))
    assert np.array_equal(one, again) and not np.array_equal(one, other)


@EACH
def test_saved_weights_are_loaded_and_their_licence_is_said(kind, tmp_path, capsys):
    family, make, tokens, shape = KINDS[kind]
    prior = make_prior(kind)
    place = "unet" if family is ModelScopePrior else "transformer"
    for part, folder in ((prior.denoiser, place), (prior.vae, "vae"), (prior.scheduler, "scheduler")):
        part.save_pretrained(tmp_path / folder)
    again = open_prior(family.name, str(tmp_path), embeddings=prior.embeddings, **shape)
    assert family.licence in capsys.readouterr().out
    video = make_video(prior)
    assert np.array_equal(again.gradient(video, PROMPT, 3), prior.gradient(video, PROMPT, 3))


def test_nothing_is_downloaded_unasked(tmp_path):
    with pytest.raises(UserError, match="download=True"):
        open_prior("wan", str(tmp_path / "nothing"))


def test_bad_shapes_prompts_and_numbers_are_refused():
    with pytest.raises(UserError, match="multiples of 16"):
        make_prior("wan", size=(24, 16))
    with pytest.raises(UserError, match="one more than a multiple of 4"):
        make_prior("wan", frames=8)
    prior = make_prior("wan")
    with pytest.raises(UserError, match="no embedding of the prompt"):
        prior.gradient(make_video(prior), "something else", 0)
    with pytest.raises(UserError, match=r"\[0, 1\]"):
        prior.gradient(255 * make_video(prior), PROMPT, 0)
    prior.predict = lambda noisy, level, embedding: noisy * float("nan")
    with pytest.raises(UserError, match="not finite"):
        prior.gradient(make_video(prior), PROMPT, 0)


def test_text_is_encoded_once_a_sentence():
    asked = []

    def encode_text(prompt):
        asked.append(prompt)
        return torch.randn(1, 12, 32)

    prior = make_prior("wan", embeddings=None, encode_text=encode_text)
    video = make_video(prior)
    prior.gradient(video, PROMPT, 0)
    prior.gradient(video, PROMPT, 1)
    assert asked == [PROMPT, ""]
