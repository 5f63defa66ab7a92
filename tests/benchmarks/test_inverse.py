"""Inverse problems: the optimisers on problems with known answers, tracks, and rows that fail on a wrong gradient."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.inverse import landscape
from benchmarks.inverse.experiment import Data, Experiment
from benchmarks.inverse.fitting import (
    LM_STEPS,
    Failed,
    descend_adam,
    descend_in_stages,
    descend_levenberg_marquardt,
)
from benchmarks.inverse.markdown import write_tables
from benchmarks.inverse.measuring import LEVENBERG_MARQUARDT, measure_fit
from benchmarks.inverse.problems import JELLY, Problem
from benchmarks.inverse.scenes import DX, FRAMES, TRACKS, Block
from benchmarks.inverse.unknowns import UNKNOWNS

SMALL = Block(JELLY, substeps=8, cells=(3, 3, 3), low=(9.0, 9.0, 12.0), floor=None)
TRUTH = np.array([0.8, -0.4, 1.2])


@pytest.fixture(scope="module")
def thrown():
    """A small cube in free flight, whose velocity is sought."""
    starts = {"wrong": {"velocity": np.array([-0.5, 0.6, 0.3])}}
    return Experiment(Problem("thrown", SMALL, {"velocity": TRUTH}, starts))


@pytest.fixture(scope="module")
def row(thrown):
    return measure_fit(thrown, "wrong", LEVENBERG_MARQUARDT)


class Decay:
    """a e^(-b t) through five points of a = 2, b = 3; it cannot be computed for b below 0.2."""

    t, failures = np.linspace(0.0, 1.0, 5), 0

    def compute_residuals(self, u):
        if u[1] < 0.2:
            self.failures += 1
            raise Failed("too slow")
        return np.asarray(self._respond(jnp.asarray(u)))

    def compute_gradient(self, u):
        r = self.compute_residuals(u)
        return 0.5 * float(r @ r), self.compute_jacobian(u, r).T @ r

    def compute_jacobian(self, u, residuals, columns=None):
        del residuals
        jacobian = np.asarray(jax.jacobian(self._respond)(jnp.asarray(u)))
        return jacobian if columns is None else jacobian[:, list(columns)]

    def _respond(self, u):
        return 100.0 * (u[0] * jnp.exp(-u[1] * self.t) - 2.0 * jnp.exp(-3.0 * self.t))


def test_levenberg_marquardt_finds_a_decay_and_never_gets_worse(x64):
    """From where a step leads to what cannot be computed."""
    fit = Decay()
    steps = list(descend_levenberg_marquardt(fit, np.array([0.2, 1.0]), np.ones(2)))
    assert fit.failures > 0
    losses = [step.loss for step in steps]
    assert losses == sorted(losses, reverse=True) and len(steps) <= LM_STEPS + 1
    np.testing.assert_allclose(steps[-1].u, [2.0, 3.0], atol=1e-3)


def test_stages_seek_their_own_coordinates_and_end_where_the_whole_does(x64):
    first, both = np.array([True, False]), np.array([True, True])

    def search(fit, start, sought):
        return descend_levenberg_marquardt(fit, start, np.ones(sought.sum()))

    steps = list(descend_in_stages(Decay(), np.array([0.2, 1.0]), (first, both), search))
    early = [step.u for step in steps if step.u[1] == 1.0]
    t, decay = Decay.t, 2.0 * np.exp(-3.0 * Decay.t)  # the best factor of e^-t
    assert early[-1][0] == pytest.approx((decay @ np.exp(-t)) / (np.exp(-t) @ np.exp(-t)), rel=1e-4)
    np.testing.assert_allclose(steps[-1].u, [2.0, 3.0], atol=1e-3)


def test_adam_finds_a_decay_and_comes_back_from_what_cannot_be_computed(x64):
    fit = Decay()
    steps = list(descend_adam(fit, np.array([0.3, 0.25]), 5))
    assert fit.failures > 0
    np.testing.assert_allclose(steps[-1].u, [2.0, 3.0], rtol=0.02)
    with pytest.raises(Failed):
        list(descend_adam(Decay(), np.array([1.0, 0.1]), 5))


@pytest.mark.parametrize("name", UNKNOWNS)
def test_coordinates_are_those_of_the_value_and_spreads_are_linear(name):
    unknown = UNKNOWNS[name]
    value = 0.31 if unknown.size == 1 else np.array([0.4, -1.0, 2.0])
    u = unknown.encode(value)
    np.testing.assert_allclose(unknown.decode(u), value, rtol=1e-12)
    np.testing.assert_allclose(unknown.decode(jnp.asarray(u)), value, rtol=1e-5)
    assert unknown.find_error(value, value) == 0 < unknown.find_error(1.01 * value, value)
    covariance = np.diag(np.full(unknown.size, 1e-4))
    assert unknown.spread(u, 4 * covariance) == pytest.approx(2 * unknown.spread(u, covariance), rel=1e-3)


def test_a_logarithm_is_off_by_its_relative_error_and_friction_by_its_cone():
    modulus, friction = UNKNOWNS["youngs_modulus"], UNKNOWNS["friction"]
    assert modulus.find_error(1.02e4, 1e4) == pytest.approx(0.02)
    assert modulus.spread(modulus.encode(1e4), np.array([[1e-4]])) == pytest.approx(0.01, rel=0.02)
    assert friction.find_error(1.0, np.tan(np.radians(30))) == pytest.approx(15.0)


def test_tracks_of_a_finer_block_are_of_the_same_points():
    tracks = []
    for finer in (1, 2):
        scene = SMALL.build(finer)
        x = np.asarray(scene.state.x)[scene.back][SMALL.find_tracks(finer)]
        assert x.shape == (TRACKS, finer**3, 3)
        tracks.append(x.mean(1))
    np.testing.assert_allclose(*tracks, atol=1e-6)
    low, high = DX * 9.25, DX * 11.75  # on the surface, in x and y
    inside = (tracks[0][:, :2] > low + 1e-6) & (tracks[0][:, :2] < high - 1e-6)
    assert not (inside.all(1) & (np.abs(tracks[0][:, 2] - 13.5 * DX) < 1.2 * DX)).any()


def test_tracks_in_free_flight_are_the_discrete_parabola(thrown):
    """x0 + v t + g t (t + dt) / 2 of symplectic Euler; and noise has the deviation that is asked for."""
    t = SMALL.frame_dt * np.arange(1, FRAMES + 1)[:, None]
    path = TRUTH * t + 0.5 * np.array(SMALL.gravity) * t * (t + SMALL.frame_dt / SMALL.substeps)
    moved = thrown.observed - thrown.observed[:1] + path[:1, None]
    np.testing.assert_allclose(moved, np.broadcast_to(path[:, None], moved.shape), atol=1e-5)
    noisy = Experiment(thrown.problem, Data(noise=1e-3))
    assert np.std(noisy.observed - thrown.observed) == pytest.approx(1e-3 * SMALL.extent, rel=0.05)


def test_a_velocity_is_found_and_the_row_is_good(row):
    assert row["good"] and row["met"] and row["gradient_error"] < 1e-3
    assert np.linalg.norm(np.array(row["found"]["velocity"]) - TRUTH) < 1e-3 * np.linalg.norm(TRUTH)
    t = SMALL.frame_dt * np.arange(1, FRAMES + 1)  # dx / dv = t, for each of the tracks
    least = np.sqrt(3 / (TRACKS * (t**2).sum())) * 1e-3 * SMALL.extent / np.linalg.norm(TRUTH)
    assert row["standard_errors"]["velocity"] == pytest.approx(least, rel=0.01)
    assert row["condition"] == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("spoil", [lambda g: 1.1 * g, lambda g: g * [1, 1, -1]])
def test_a_row_with_a_wrong_gradient_is_not_good(thrown, spoil, monkeypatch):
    right = Experiment.compute_gradient

    def wrong(self, u):
        loss, gradient = right(self, u)
        return loss, spoil(gradient)

    monkeypatch.setattr(Experiment, "compute_gradient", wrong)
    row = measure_fit(thrown, "wrong", LEVENBERG_MARQUARDT)
    assert not row["good"] and row["gradient_error"] > 0.05


def test_what_the_tracks_do_not_tell_is_not_sought():
    """E of what flies freely: its derivative is exactly zero."""
    starts = {"wrong": {"youngs_modulus": 9e4}}
    flying = Problem("flying", SMALL, {"youngs_modulus": 3e4}, starts, identified=False)
    row = measure_fit(Experiment(flying), "wrong", LEVENBERG_MARQUARDT)
    assert row["good"] and not row["fitted"] and row["unidentified"] == ["youngs_modulus"]
    assert row["identified"] == 0 and row["eigenvalues"][0] < 0.1 * row["least"]


def test_the_page_shows_what_was_found_missed_and_not_sought(row):
    row = {"run": 0, "job": "j"} | row
    missed = row | {"met": False, "steps_to_tolerance": None}
    hidden = row | {"fitted": False, "identified": 2, "unidentified": ["velocity z"]}
    run = {"quick": False, "seconds": 3.0, "command": "c", "machine": "m", "load_average": [0.1]}
    run["git_revision"] = "r"
    sections = {"exact": [row, missed], "unidentifiable": [hidden]}
    result = {part: {"runs": [run], "complete": True, "rows": rows} for part, rows in sections.items()}
    page = "\n".join(write_tables(result).values())
    assert "Levenberg-Marquardt: 1 of 2 within their bars" in page
    assert "| (0.8, -0.4, 1.2) |" in page and "| never of " in page and "| 2 of 3 | velocity z |" in page
    assert "Not measured yet: noise, finer, landscape" in page


class Cubic:
    """A loss u^3 / 3 + 4 u^2 about 0, and its derivative times a factor."""

    def __init__(self, factor):
        self.factor = factor
        truth = {"velocity": np.zeros(3)}
        self.problem = Problem("cubic", SMALL, truth, {})

    def compute_loss(self, u):
        return u[1] ** 3 / 3 + 4 * u[1] ** 2

    def compute_gradient(self, u):
        return self.compute_loss(u), self.factor * np.array([0.0, u[1] ** 2 + 8 * u[1], 0.0])


@pytest.mark.parametrize(
    ("factor", "smooth", "share"), [(1.0, True, 1.0), (1.2, False, 1.0), (-1.0, False, 1 / 7)]
)
def test_a_slice_is_smooth_where_gradients_are_the_losses_own(factor, smooth, share, monkeypatch):
    """A cubic is its own interpolation; at the truth itself no way is downhill."""
    monkeypatch.setattr(landscape, "prepare", lambda name, data: Cubic(factor))
    (row,) = landscape.measure_slice(landscape.Slice("a", "cubic", 1, 2.0, "smooth"), 7)
    assert (row["roughness"] < 1e-12) == smooth
    assert row["towards_truth"] == pytest.approx(share)
