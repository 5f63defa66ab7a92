"""Fidelity: what a body can do is clean, and each fault lowers its own term alone."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.fidelity import Surroundings, rate_fidelity

DT, FRAMES, COUNT = 0.04, 26, 1200
GRAVITY = np.array([0.0, 0.0, -9.81])
SIDES = np.array([1.0, 0.6, 0.5])
RNG = np.random.default_rng(0)
REST = RNG.random((COUNT, 3)) * SIDES
MASS = RNG.uniform(0.5, 1.5, COUNT)
TIME = DT * np.arange(FRAMES)[:, None, None]
UP = np.array([0.0, 0.0, 1.0])


def ground(height):
    return lambda x: x[..., 2] - height


def fall(speed=(0.4, 0.0, 1.0)):
    """A rigid body that is thrown, turns, and falls."""
    centre = REST.mean(0)
    cos, sin = np.cos(3 * TIME[:, 0, 0]), np.sin(3 * TIME[:, 0, 0])
    turns = np.zeros((FRAMES, 3, 3))
    turns[:, 0, 0], turns[:, 0, 1], turns[:, 1, 0], turns[:, 1, 1], turns[:, 2, 2] = cos, -sin, sin, cos, 1
    turned = np.einsum("tij,nj->tni", turns, REST - np.average(REST, axis=0, weights=MASS))
    return centre + turned + TIME * np.array(speed) + 0.5 * TIME**2 * GRAVITY


def sway():
    """A body that is held at its base and bends to and fro, as its lowest mode, under nothing."""
    x = np.repeat(REST[None], FRAMES, axis=0)
    x[..., 0] += 0.2 * (REST[:, 2] / SIDES[2]) ** 2 * np.sin(6 * TIME[..., 0])
    return x


def lie():
    return np.repeat(REST[None], FRAMES, axis=0)


FALLING = Surroundings((ground(-6.0),), acceleration=GRAVITY)
HELD = Surroundings((ground(0.0),), held=REST[:, 2] < 0.05)
LYING = Surroundings((ground(0.0),), acceleration=GRAVITY, resting=True)
CLIPS = {"fall": (fall(), FALLING), "sway": (sway(), HELD), "lie": (lie(), LYING)}


def shake(x, share=0.01):
    return x + share * np.random.default_rng(1).normal(size=x.shape)


def sink(x, depth=0.09):
    return x - np.linspace(0, depth, len(x))[:, None, None] * UP


def jump(x, frame=12, way=0.2):
    moved = x.copy()
    moved[frame:] += way * np.array([0.0, 1.0, 0.0])
    return moved


def scatter(x, share=0.03):
    gone, moved = np.random.default_rng(2).permutation(COUNT)[: int(share * COUNT)], x.copy()
    moved[:, gone] += np.linspace(0, 1.5, len(x))[:, None, None] * (REST[gone] - REST.mean(0)) / 0.5
    return moved


def leave(x):
    """A corner goes off as one piece."""
    corner, moved = (REST / SIDES).max(1) < 0.3, x.copy()
    moved[:, corner] -= np.linspace(0, 1.5, len(x))[:, None, None]
    return moved


@pytest.mark.parametrize("name", CLIPS)
def test_what_a_body_can_do_is_clean(name):
    x, around = CLIPS[name]
    found = rate_fidelity(x, MASS, DT, around)
    assert found.score == 1 and not found.faults
    assert found.noise < 1e-3 and found.pieces == 0


def test_a_free_fall_has_no_energy_and_no_velocity_from_nowhere():
    found = rate_fidelity(*CLIPS["fall"][:1], MASS, DT, FALLING)
    assert found.flight == pytest.approx(0, abs=1e-9)
    assert found.energy == pytest.approx(0, abs=2e-3)  # a mean of frames lies beside the path by g dt^2 / 8
    assert found.slip is None


@pytest.mark.parametrize(
    ("clip", "change", "term"),
    [
        *((clip, shake, "noise") for clip in CLIPS),
        ("lie", sink, "sinking"),
        *((clip, jump, "jump") for clip in ("fall", "lie")),
        *((clip, scatter, "pieces") for clip in ("fall", "sway")),
        ("fall", leave, "pieces"),
    ],
)
def test_a_fault_lowers_its_own_term_alone(clip, change, term):
    x, around = CLIPS[clip]
    found = rate_fidelity(change(x), MASS, DT, around)
    assert found.faults == (term,), found
    assert found.score < 0.8


def test_noise_is_measured_as_it_is():
    for share in (0.003, 0.01, 0.03):
        x = shake(fall(), share)
        length = np.ptp(x[0], axis=0).max()  # noise makes it longer
        assert rate_fidelity(x, MASS, DT).noise * length == pytest.approx(share, rel=0.05)


def test_what_is_held_may_not_go():
    x, around = CLIPS["sway"]
    found = rate_fidelity(sink(x), MASS, DT, Surroundings(held=around.held))
    assert found.faults == ("slip",) and found.slip == pytest.approx(0.09, rel=0.05)
    led = rate_fidelity(sink(x), MASS, DT, Surroundings(held=around.held, driven=True))
    assert led.slip is None and not led.faults
    known = rate_fidelity(sink(x), MASS, DT, Surroundings(acceleration=GRAVITY, driven=True))
    assert (known.flight, known.energy) == (None, None)


def test_an_obstacle_is_solid_too():
    def ball(x):
        return np.linalg.norm(x - np.array([0.5, 0.3, -1.0]), axis=-1) - 0.5

    found = rate_fidelity(sink(lie(), 0.9), MASS, DT, Surroundings((ball,)))
    assert found.faults == ("sinking",)


def test_a_body_may_not_hang_in_the_air_nor_fall_too_fast():
    for x in (lie(), fall() + 0.5 * TIME**2 * GRAVITY):
        assert "flight" in rate_fidelity(x, MASS, DT, FALLING).faults
    drift = rate_fidelity(
        lie() + 0.09 * TIME * [1, 0, 0], MASS, DT, Surroundings(acceleration=[0, 0, 0], resting=True)
    )
    assert "flight" in drift.faults


def test_a_ball_may_not_bounce_higher_than_it_fell():
    """Heights by closed forms: it falls for half a second, and comes back with a share of its speed."""

    def bounce(share):
        t = TIME[:, 0, 0]
        height = np.where(t < 0.5, 1.22625 - 4.905 * t**2, 4.905 * share * (t - 0.5) - 4.905 * (t - 0.5) ** 2)
        return REST + height[:, None, None] * UP

    found = {share: rate_fidelity(bounce(share), MASS, DT, LYING) for share in (0.6, 1.0, 1.4)}
    assert not found[0.6].faults and not found[1.0].faults
    assert found[1.4].faults == ("energy",)


def test_what_is_not_known_is_not_rated():
    found = rate_fidelity(fall(), MASS, DT)
    assert (found.sinking, found.slip, found.flight, found.energy) == (None,) * 4
    assert set(found.scores) == {"noise", "jump", "pieces"} and found.score == 1


def test_a_stretch_tears_nothing():
    growth = 1 + np.linspace(0, 1, FRAMES)[:, None, None] * [0.5, -0.2, -0.2]
    assert not rate_fidelity(REST * growth, MASS, DT).faults


def test_what_is_no_recording_is_refused_and_what_is_not_finite_has_no_fidelity():
    with pytest.raises(UserError, match="frames, particles, 3"):
        rate_fidelity(REST, MASS, DT)
    with pytest.raises(UserError, match="`mass`"):
        rate_fidelity(lie(), MASS[1:], DT)
    broken = lie()
    broken[3, 5] = np.nan
    assert rate_fidelity(broken, MASS, DT).score == 0


def test_steps_of_first_order_are_no_fault():
    """A push to and fro of 80 m/s^2 in twelve steps a frame, speeds before places: half a step too fast."""
    pushes = 80.0 * np.array([1.0, -1.0, -1.0, 1.0] * (FRAMES // 4 + 1))[: FRAMES - 1]
    speeds = np.cumsum(np.repeat(pushes, 12)) * DT / 12
    places = np.concatenate([[0.0], np.cumsum(speeds)[11::12] * DT / 12])
    acts = pushes[:, None, None] * np.array([1.0, 0.0, 0.0])
    x = REST + places[:, None, None] * np.array([1.0, 0.0, 0.0])
    assert not rate_fidelity(x, MASS, DT, Surroundings(acceleration=acts, resting=True)).faults
