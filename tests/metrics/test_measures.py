"""The measures of clauses, against motions whose measures are known exactly."""

import numpy as np
import pytest
from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.targets import Target, hash_target
from physagent_jax.metrics.task_judge import judge

FRAMES, DT = 25, 0.04
LAST = FRAMES - 1
RNG = np.random.default_rng(3)
REST = RNG.uniform((-0.4, -0.25, -0.5), (0.4, 0.25, 0.5), (600, 3)) + (1.0, 2.0, 1.5)
MASS = RNG.uniform(0.5, 1.5, 600)
SIZE = float(np.ptp(REST, axis=0).max())
CENTRE = MASS @ REST / MASS.sum()
TIME = np.linspace(0.0, 1.0, FRAMES)
X, Y, Z = np.eye(3).tolist()


def rotate(axis, degrees):
    a, angle = np.asarray(axis, float) / np.linalg.norm(axis), np.radians(degrees)
    K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def affine(matrices, shifts=0.0):
    """About the mass centre, shifts in body lengths."""
    x = np.einsum("tij,nj->tni", np.asarray(matrices), REST - CENTRE) + CENTRE
    return x + SIZE * np.broadcast_to(shifts, (FRAMES, 3))[:, None]


def shift(path):
    return affine(np.tile(np.eye(3), (FRAMES, 1, 1)), path)


def spin(axis, degrees):
    return affine([rotate(axis, degrees * t) for t in TIME])


def ask(*clauses):
    return Target.model_validate({"clauses": clauses})


def see(x, clause):
    """The first number that a clause sees; the window is the whole clip unless it says otherwise."""
    return judge(ask({"window": (0, LAST), **clause}), x, MASS, DT).clauses[0].seen


def end(direction):
    """Particles of an end, as the motion report has it: a third of the mass."""
    order = np.argsort(-(REST @ direction), kind="stable")
    before = np.cumsum(MASS[order]) - MASS[order]
    return order[before < MASS.sum() / 3]


def test_a_straight_way_has_its_length_and_direction():
    way = np.outer(TIME**2, [0.3, -0.4, 0.0])
    distance = {"kind": "distance", "target": 0.5, "tolerance": 0.1}
    assert see(shift(way), distance) == pytest.approx(0.5, abs=2e-5)
    assert see(shift(way), distance | {"along": X}) == pytest.approx(0.3, abs=1e-6)
    assert see(shift(way), distance | {"along": [0, 1, 0]}) == pytest.approx(-0.4, abs=1e-6)
    assert see(shift(way), distance | {"along": X, "window": (6, 12)}) == pytest.approx(
        0.3 * (0.25 - 1 / 16), abs=1e-6
    )
    for toward, angle in (([3, -4, 0], 0.0), ([-3, 4, 0], 180.0), (Z, 90.0), (X, 53.1301)):
        assert see(shift(way), {"kind": "direction", "toward": toward}) == pytest.approx(angle, abs=0.12)


def test_what_is_too_little_to_be_seen_has_no_direction():
    assert see(shift(np.zeros(3)), {"kind": "direction", "toward": X}) == pytest.approx(90.0)
    assert see(shift(np.outer(TIME, [0.001, 0, 0])), {"kind": "direction", "toward": X}) > 80.0


def test_the_farthest_place_is_found_where_it_comes_back():
    path = np.outer(np.sin(np.pi * TIME), [-0.4, 0, 0])
    there = {"kind": "distance", "target": 0.4, "tolerance": 0.1, "along": [-1, 0, 0], "when": "peak"}
    assert see(shift(path), there) == pytest.approx(0.4, abs=1e-6)
    assert see(shift(path), there | {"along": X, "target": -0.4}) == pytest.approx(-0.4, abs=1e-6)
    assert see(shift(path), there | {"along": X, "target": 0.0}) == pytest.approx(-0.4, abs=1e-6)
    assert see(shift(path), there | {"when": "end"}) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("degrees", [-170.0, 35.0, 360.0, 800.0])
def test_a_turn_about_an_axis_is_its_angle_beyond_half_turns_too(degrees):
    axis = [1, 2, 2]
    turn = {"kind": "turn", "axis": axis, "target": 90, "tolerance": 20}
    assert see(spin(axis, degrees), turn) == pytest.approx(degrees, abs=0.01)
    assert see(spin([-1, -2, -2], degrees), turn) == pytest.approx(-degrees, abs=0.01)
    assert see(spin([2, -1, 0], degrees), turn) == pytest.approx(0.0, abs=0.01)
    assert see(spin(axis, degrees), turn | {"window": (6, 18)}) == pytest.approx(degrees / 2, abs=0.01)
    assert see(spin(axis, degrees), turn | {"part": Z}) == pytest.approx(degrees, abs=0.02)


def test_a_stretch_is_no_turn_and_a_turn_no_stretch():
    S = np.array([[1.3, 0.1, 0], [0.1, 0.8, 0], [0, 0, 1.1]])
    pulled = affine([np.eye(3) + t * (S - np.eye(3)) for t in TIME])
    for axis in (X, Y, Z):
        assert see(pulled, {"kind": "turn", "axis": axis, "target": 0, "tolerance": 20}) == pytest.approx(
            0, abs=0.01
        )
        assert see(spin([1, 1, 0], 120), {"kind": "stretch", "along": axis, "target": 0, "tolerance": 0.1}
                   ) == pytest.approx(0, abs=1e-4)  # fmt: skip
    turned = affine([rotate([0, 1, 1], 70 * t) @ (np.eye(3) + t * (S - np.eye(3))) for t in TIME])
    for x in (pulled, turned):
        stretch = {"kind": "stretch", "target": 0.3, "tolerance": 0.1}
        assert see(x, stretch | {"along": X}) == pytest.approx(np.hypot(1.3, 0.1) - 1, abs=1e-4)
        assert see(x, stretch | {"along": Z, "part": X}) == pytest.approx(0.1, abs=1e-4)
        assert see(x, stretch) == pytest.approx(np.linalg.det(S) ** (1 / 3) - 1, abs=1e-4)
        half = np.linalg.norm((np.eye(3) + 0.5 * (S - np.eye(3)))[:, 0])
        assert see(x, stretch | {"along": X, "window": (12, LAST)}) == pytest.approx(
            np.hypot(1.3, 0.1) / half - 1, abs=1e-4
        )


def test_one_end_moves_turns_and_stretches_by_itself():
    top = end(np.array(Z))
    x = np.tile(REST, (FRAMES, 1, 1))
    arm = REST[top] - MASS[top] @ REST[top] / MASS[top].sum()
    for frame, t in enumerate(TIME):
        x[frame, top] += arm @ rotate(Z, 50 * t).T - arm + SIZE * t * np.array([0.2, 0, 0])
    moved = {"kind": "distance", "along": X, "target": 0.2, "tolerance": 0.05, "part": Z}
    twist = {"kind": "turn", "axis": Z, "target": 50, "tolerance": 10, "part": Z, "against": [0, 0, -1]}
    assert see(x, moved) == pytest.approx(0.2, abs=1e-5)
    assert see(x, moved | {"part": [0, 0, -1]}) == pytest.approx(0.0, abs=1e-6)
    assert see(x, moved | {"part": None}) == pytest.approx(0.2 * MASS[top].sum() / MASS.sum(), abs=1e-5)
    assert see(x, twist) == pytest.approx(50, abs=0.01)
    assert see(x, twist | {"part": [0, 0, -1], "against": Z}) == pytest.approx(-50, abs=0.01)


@pytest.mark.parametrize("periods", [1, 2, 3])
def test_a_sine_over_whole_periods_has_its_amplitude_and_frequency(periods):
    path = np.outer(0.1 * np.sin(2 * np.pi * periods * TIME), X)
    frequency = periods / (LAST * DT)
    sway = {"kind": "oscillation", "window": (0, LAST), "along": X, "target": 0.1, "tolerance": 0.03}
    sway |= {"frequency": frequency, "frequency_tolerance": 0.2 * frequency}
    seen = judge(ask(sway), shift(path), MASS, DT)
    assert seen.success
    assert seen.clauses[0].seen == pytest.approx(0.1, rel=0.035)  # frames miss the extremes
    assert seen.clauses[1].seen == pytest.approx(frequency, rel=0.004)
    assert not judge(ask(sway | {"along": Y}), shift(path), MASS, DT).success
    twice = np.outer(0.1 * np.sin(4 * np.pi * periods * TIME), X)
    assert not judge(ask(sway), shift(twice), MASS, DT).success


def test_the_order_of_two_motions_is_the_time_between_them():
    """Each goes its way in four frames, at an even speed: the middles are 12 frames apart."""
    early, late = (np.clip((np.arange(FRAMES) - begin) / 4, 0, 1) for begin in (2, 14))
    x = shift(0.3 * np.outer(early, X) + 0.3 * np.outer(late, Z))
    order = {"kind": "order", "first": {"along": X}, "second": {"along": Z}, "target": 12, "tolerance": 4}
    assert see(x, order) == pytest.approx(12.0, rel=0.01)
    assert see(x, order | {"first": {"along": Z}, "second": {"along": X}}) == pytest.approx(-12.0, rel=0.01)
    assert see(shift(0.3 * np.outer(early, X)), order) == pytest.approx(
        0.0, abs=0.01
    )  # the second is missing
    top, ends = end(np.array(Z)), np.tile(REST, (FRAMES, 1, 1))
    bottom = end(-np.array(Z))
    ends[:, top] += 0.3 * late[:, None, None] * np.array(X)
    ends[:, bottom] += 0.3 * early[:, None, None] * np.array(X)
    parts = {"first": {"along": X, "part": [0, 0, -1]}, "second": {"along": X, "part": Z}}
    assert see(ends, order | parts) == pytest.approx(12.0, rel=0.02)


def test_rest_is_the_particles_own_displacement():
    assert see(shift(np.zeros(3)), {"kind": "rest"}) == 0.0
    assert see(shift(np.outer(TIME, [0.03, 0.04, 0])), {"kind": "rest"}) == pytest.approx(0.05, abs=2e-5)
    turned = spin(Z, 20)
    arm = REST - CENTRE
    expected = np.sqrt(MASS @ ((arm @ rotate(Z, 20).T - arm) ** 2).sum(1) / MASS.sum()) / SIZE
    assert see(turned, {"kind": "rest"}) == pytest.approx(expected, abs=2e-5)
    assert see(turned, {"kind": "rest", "window": (0, 6)}) < 0.3 * expected


def test_what_hangs_together_passes_and_what_comes_apart_does_not():
    rigid, whole = spin([1, 1, 1], 200), {"kind": "integrity", "window": (0, LAST)}
    assert judge(ask(whole), rigid, MASS, DT).clauses[0].seen == 0.0
    pulled = affine([np.diag([1 + 0.5 * t, 1, 1]) for t in TIME])
    assert judge(ask(whole), pulled, MASS, DT).success
    torn = np.tile(REST, (FRAMES, 1, 1))
    torn[:, end(np.array(Z))] += 0.4 * TIME[:, None, None] * np.array(Z)
    assert judge(ask(whole), torn, MASS, DT).error > 3
    burst = affine([np.eye(3) * (1 + 2 * t) for t in TIME])
    assert judge(ask(whole), burst, MASS, DT).error > 10
    stray = np.tile(REST, (FRAMES, 1, 1))
    stray[:, 5] += 0.4 * TIME[:, None] * np.array(X)
    assert judge(ask(whole), stray, MASS, DT).success
    copies = np.concatenate([rigid, rigid], axis=1)  # particles may be there twice
    assert judge(ask(whole), copies, np.concatenate([MASS, MASS]) / 2, DT).error == pytest.approx(0, abs=1e-3)


def test_a_stored_path_is_followed_or_missed_by_its_largest_distance():
    way = np.outer(TIME**2, [0.3, -0.4, 0.1])
    path = {"kind": "path", "places": [{"centres": way.tolist()}], "tolerance": 0.05}
    assert see(shift(way), path) == pytest.approx(0.0, abs=1e-6)
    assert see(shift(1.1 * way), path) == pytest.approx(0.1 * np.sqrt(0.26), abs=2e-5)


def test_seen_and_wanted_make_margin_error_and_success():
    x = shift(np.outer(TIME, [0.6, 0, 0]))
    right = {"kind": "distance", "window": (0, LAST), "along": X, "target": 0.5, "tolerance": 0.1625}
    aside = {"kind": "distance", "window": (0, LAST), "along": Y, "target": 0.0, "tolerance": 0.1}
    seen = judge(ask(right, aside), x, MASS, DT)
    assert seen.success and seen.error == pytest.approx(0.1 / 0.1625, rel=1e-4)
    assert [c.margin for c in seen.clauses] == pytest.approx([1 - 0.1 / 0.1625, 1.0], rel=1e-4)
    assert not judge(ask(right | {"tolerance": 0.09}, aside), x, MASS, DT).success


def test_what_is_not_finite_is_no_success():
    x = shift(np.zeros(3))
    still = ask({"kind": "rest", "window": (0, LAST)})
    assert judge(still, x, MASS, DT).success
    x[7, 3, 1] = np.nan
    seen = judge(still, x, MASS, DT)
    assert not seen.success and seen.error == np.inf


def test_a_target_that_does_not_fit_the_clip_is_refused():
    with pytest.raises(UserError, match="the clip ends with frame 24"):
        judge(ask({"kind": "rest", "window": (0, 30)}), shift(np.zeros(3)), MASS, DT)
    with pytest.raises(UserError, match="mass"):
        judge(ask({"kind": "rest", "window": (0, 3)}), shift(np.zeros(3)), MASS[:-1], DT)


@pytest.mark.parametrize(
    ("clause", "message"),
    [
        ({"kind": "distance", "target": 0.6, "tolerance": 0.3}, "at most a third"),
        ({"kind": "distance", "target": 0.6, "tolerance": 0.1, "window": (4, 4)}, "must end after"),
        ({"kind": "direction", "toward": [0, 0, 0]}, "zero vector"),
        ({"kind": "path", "places": [{"centres": [[0, 0, 0]]}]}, "25 frames"),
        ({"kind": "oscillation", "along": X, "target": 0.1, "tolerance": 0.03, "frequency": 2.0,
          "frequency_tolerance": 1.0}, "at most a third"),
        ({"kind": "distance", "target": 0.6, "tolerance": 0.1, "colour": "red"}, "Extra inputs"),
    ],
)  # fmt: skip
def test_clauses_that_make_no_sense_are_refused(clause, message):
    with pytest.raises(ValidationError, match=message):
        ask({"window": (0, LAST), **clause})


def test_the_hash_is_of_what_is_asked_for():
    clause = {"kind": "distance", "window": (0, LAST), "along": [2, 0, 0], "target": 0.6, "tolerance": 0.1}
    same = ask({**clause, "along": [1, 0, 0], "when": "end", "part": None})
    assert hash_target(ask(clause)) == hash_target(same)
    for change in ({"target": 0.61}, {"along": [1, 0.01, 0]}, {"window": (0, 23)}, {"kind": "stretch"}):
        assert hash_target(ask(clause | change)) != hash_target(same)
