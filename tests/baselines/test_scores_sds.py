"""The arithmetic of score distillation against densities whose scores are known in closed form. No video model is used.

For x_0 ~ N(mu, s^2) the best denoiser of x_t = alpha x_0 + sigma e answers E[e | x_t] = sigma (x_t - alpha mu) /
(alpha^2 s^2 + sigma^2), and E[x_0 | x_t] follows from it.
"""

import dataclasses
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from baselines.scores import Cost, ScorePrior, SdsSettings, change_settings, open_prior, sds
from baselines.scores.bridge import distil
from physagent_jax.core.errors import UserError

SHAPE = (3, 4, 5, 3)
LEVELS = {
    sds.Form.EPSILON: sds.Level(300, 0.8, 0.6),
    sds.Form.V: sds.Level(300, 0.8, 0.6),
    sds.Form.FLOW: sds.Level(400, 0.6, 0.4),
}
FORMS = pytest.mark.parametrize("form", list(sds.Form))


def denoise(form, noisy, level, mean, spread):
    """The answer of the best denoiser of N(mean, spread^2)."""
    scale = level.alpha**2 * spread**2 + level.sigma**2
    noise = level.sigma * (noisy - level.alpha * mean) / scale
    clean = mean + level.alpha * spread**2 * (noisy - level.alpha * mean) / scale
    return sds.make_target(form, clean, noise, level)


@dataclasses.dataclass
class GaussianPrior:
    """All clips that it knows are N(mean, spread^2), independent in every pixel."""

    mean: np.ndarray
    spread: float
    form: sds.Form
    settings: SdsSettings
    name: str = "gaussian"
    toy: bool = True
    licence: str = "none"
    cost: Cost = dataclasses.field(default_factory=Cost)

    def gradient(self, video, prompt, key, *, still=None):
        def predict(noisy, level, told):
            self.cost.calls += 1
            return denoise(self.form, noisy, level, self.mean if told else 0.5, self.spread)

        drawn = [
            (self.find_level(each.time), each.noise) for each in sds.draw(self.settings, key, video.shape)
        ]
        beside = sds.repeat_first(video) if still is None else still
        return sds.compute_latent_gradient(self.form, predict, video, drawn, self.settings, beside)

    def find_level(self, share):
        if self.form is sds.Form.FLOW:
            return sds.Level(share, 1 - share, share)
        return sds.Level(share, (1 - share**2) ** 0.5, share)


def draw_clip(seed):
    return np.random.default_rng(seed).uniform(0, 1, SHAPE)


@FORMS
def test_gradient_is_the_score_of_the_noised_density(form):
    """w (e_hat - e) = -w sigma (d log p_t / d x_t) - w e, and d log p_t / d x_t of a Gaussian is known."""
    rng, level = np.random.default_rng(0), LEVELS[form]
    clean, noise, mean, spread = rng.normal(size=SHAPE), rng.normal(size=SHAPE), rng.normal(size=SHAPE), 0.7
    settings = SdsSettings(guidance=1)
    found = sds.compute_latent_gradient(
        form, lambda x, lv, told: denoise(form, x, lv, mean, spread), clean, [(level, noise)], settings
    )
    noisy = level.alpha * clean + level.sigma * noise
    score = -(noisy - level.alpha * mean) / (level.alpha**2 * spread**2 + level.sigma**2)
    wanted = -level.sigma * score - noise
    if form is sds.Form.FLOW:
        wanted = wanted / (1 - level.sigma)  # v_hat - v = (e_hat - e) / (1 - s)
    assert np.allclose(found, level.sigma**2 * wanted)


@FORMS
def test_nothing_is_asked_of_a_denoiser_that_knows_the_noise(form):
    clean, noise, level = draw_clip(0), draw_clip(1), LEVELS[form]
    output = sds.make_target(form, clean, noise, level)
    assert np.abs(sds.compute_misfit(form, output, clean, noise, level)).max() < 1e-12
    assert np.abs(sds.compute_misfit(form, output + 1, clean, noise, level)).max() > 0.1


@FORMS
def test_guidance_is_linear_in_the_two_answers(form):
    """g(s) = g(0) + s (g(1) - g(0)); the published 100 on top of the conditional answer is s = 101."""
    rng = np.random.default_rng(2)
    clean, noise, told, bare = (rng.normal(size=SHAPE) for _ in range(4))

    def find(guidance):
        return sds.compute_latent_gradient(
            form,
            lambda x, level, prompted: told if prompted else bare,
            clean,
            [(LEVELS[form], noise)],
            SdsSettings(guidance=guidance),
        )

    assert np.allclose(find(5.0), find(0.0) + 5 * (find(1.0) - find(0.0)))
    level = LEVELS[form]
    published = told + 100 * (told - bare)
    wanted = level.sigma**2 * sds.compute_misfit(form, published, clean, noise, level)
    assert np.allclose(find(sds.PUBLISHED_GUIDANCE), wanted)


@FORMS
def test_descent_finds_the_mean_of_the_prior(form):
    """Distillation seeks the mode, here the mean; theta is a colour per frame, so the best is the mean per frame."""
    mean = draw_clip(3)
    prior = GaussianPrior(mean, 0.3, form, SdsSettings(guidance=1, draws=2, antithetic=True))
    assert isinstance(prior, ScorePrior)
    theta = jnp.full((SHAPE[0], 1, 1, 3), 0.5)
    render = jax.jit(lambda theta: jnp.broadcast_to(theta, SHAPE))
    for index in range(150):
        _, slope = distil(render, theta, prior, "a motion", index)
        theta = theta - 0.02 * slope
    wanted = mean.mean((1, 2), keepdims=True)
    assert np.abs(np.asarray(theta) - wanted).max() < 0.02 < np.abs(0.5 - wanted).max()


@FORMS
def test_a_still_clip_has_no_motion_gradient_and_appearance_cancels(form):
    """Of a prior with the wrong colours, what is left is linear in the difference of the two clips."""
    prior = GaussianPrior(draw_clip(4), 0.3, form, SdsSettings(guidance=2, motion=True))
    still = np.broadcast_to(draw_clip(5)[:1], SHAPE)
    assert np.abs(prior.gradient(still, "", 0)).max() == 0
    moving = still + np.arange(SHAPE[0])[:, None, None, None] * 0.1
    found = prior.gradient(moving, "", 0)
    assert np.all(found[0] == 0)
    # The same denoiser and noise on both clips: only the mean of x_t differs, by alpha (moving - still).
    other = dataclasses.replace(prior, mean=prior.mean + 0.3)
    assert np.allclose(found, other.gradient(moving, "", 0))
    plain = dataclasses.replace(prior, settings=dataclasses.replace(prior.settings, motion=False))
    shifted = dataclasses.replace(other, settings=plain.settings)
    assert np.abs(plain.gradient(moving, "", 0) - shifted.gradient(moving, "", 0)).max() > 0.01


def test_calls_are_counted():
    for motion, guidance, calls in ((False, 1, 4), (False, 2, 8), (True, 2, 16)):
        settings = SdsSettings(guidance=guidance, motion=motion, draws=4)
        prior = GaussianPrior(draw_clip(4), 0.3, sds.Form.FLOW, settings)
        prior.gradient(draw_clip(5), "", 0)
        assert prior.cost.calls == calls


def test_settings_are_changed_by_plain_data():
    found = change_settings(SdsSettings(guidance=3.0), dict(draws=4, weighting="uniform", motion=True))
    assert found == SdsSettings(guidance=3.0, draws=4, weighting=sds.Weighting.UNIFORM, motion=True)
    assert found.weighting is sds.Weighting.UNIFORM
    for wrong in (dict(colour=1), dict(weighting="some"), dict(draws=0)):
        with pytest.raises(UserError):
            change_settings(SdsSettings(), wrong)


def test_without_torch_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    for name in ("wan", "modelscope", "cogvideox"):
        with pytest.raises(UserError, match=r"physagent-jax\[sds\]"):
            open_prior(name, "somewhere")


def test_draws_are_those_of_the_key_and_antithetic_ones_cancel():
    settings = SdsSettings(draws=4, antithetic=True, time_range=(0.2, 0.4))
    one = sds.draw(settings, jax.random.key(3), SHAPE)
    again = sds.draw(settings, jax.random.key(3), SHAPE)
    other = sds.draw(settings, jax.random.key(4), SHAPE)
    assert all(np.array_equal(a.noise, b.noise) and a.time == b.time for a, b in zip(one, again))
    assert not np.array_equal(one[0].noise, other[0].noise)
    assert np.abs(sum(each.noise for each in one)).max() == 0 and one[0].time == one[1].time != one[2].time
    many = sds.draw(SdsSettings(draws=400, time_range=(0.2, 0.4)), 0, SHAPE)
    times, noise = np.array([each.time for each in many]), np.stack([each.noise for each in many])
    assert 0.2 <= times.min() < 0.21 and 0.39 < times.max() <= 0.4
    assert abs(noise.mean()) < 0.02 and abs(noise.std() - 1) < 0.02


def test_antithetic_draws_lessen_the_variance():
    """The noise's own part of the gradient is odd in it and cancels exactly for a linear denoiser."""
    video = draw_clip(6)

    def spread(antithetic):
        settings = SdsSettings(guidance=1, draws=2, antithetic=antithetic, time_range=(0.499, 0.501))
        prior = GaussianPrior(draw_clip(7), 0.5, sds.Form.EPSILON, settings)
        return np.std([prior.gradient(video, "", key) for key in range(40)], axis=0).mean()

    assert spread(True) < 0.02 * spread(False)


def test_frames_are_picked_evenly():
    assert sds.pick_frames(31, 16).tolist() == list(range(0, 31, 2))
    assert sds.pick_frames(4, 4).tolist() == [0, 1, 2, 3]
    assert sds.pick_frames(2, 4).tolist() == [0, 0, 1, 1]


def test_wrong_settings_clips_and_names_are_refused():
    with pytest.raises(UserError, match="time_range"):
        SdsSettings(time_range=(0.9, 0.1))
    with pytest.raises(UserError, match="even"):
        SdsSettings(draws=3, antithetic=True)
    with pytest.raises(UserError, match="floats"):
        sds.check_video(np.zeros(SHAPE, np.uint8))
    with pytest.raises(UserError, match="lie in"):
        sds.check_video(np.full(SHAPE, np.nan))
    with pytest.raises(UserError, match="no such score prior"):
        open_prior("sora", "somewhere")
