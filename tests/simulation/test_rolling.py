"""Wheels that turn as far as a vehicle goes."""

import numpy as np
import pytest

from physagent_jax.simulation.rolling import Rolling, Wheel

RADIUS, UP, AXLE = 0.1, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def make_wheel(middle) -> Wheel:
    """A ring of points about the world's x axis."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack(
        [0.02 * (-1.0) ** np.arange(24), RADIUS * np.cos(angles), RADIUS * np.sin(angles)], axis=1
    )
    return Wheel(np.arange(24), middle + ring, np.asarray(middle, float), AXLE, RADIUS)


def follow(way: np.ndarray, height: float = RADIUS) -> np.ndarray:
    """The places of a wheel's points relative to its hub, after it has gone along ``way`` [m], shape (frames, 3)."""
    wheel = make_wheel((0.0, 0.0, height))
    rolling = Rolling([wheel], np.zeros(3), UP)
    x = wheel.rest
    for shift in way[1:]:
        x = wheel.rest + shift
        rolling.advance(x)
    return rolling.turn(x, np.tile(np.eye(3), (24, 1, 1)))[0] - wheel.hub - way[-1]


def turn(points: np.ndarray, angle: float) -> np.ndarray:
    """Points turned about the axle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T


@pytest.mark.parametrize("length", [0.05, 0.7, -1.3])
def test_a_wheel_turns_by_its_way_over_its_radius(length):
    way = np.linspace(0.0, length, 9)[:, None] * np.array([0.0, 1.0, 0.0])
    rest = make_wheel((0.0, 0.0, 0.0)).rest
    # Right-handed about x, the top of what goes along y goes ahead where it turns the other way.
    np.testing.assert_allclose(follow(way), turn(rest, -length / RADIUS), atol=1e-9)


def test_the_place_on_the_ground_stands_still():
    step = 1e-4
    way = np.array([0.0, step])[:, None] * np.array([0.0, 1.0, 0.0])
    rest = make_wheel((0.0, 0.0, 0.0)).rest
    lowest = rest[:, 2].argmin()
    moved = follow(way)[lowest] + way[-1] - rest[lowest]
    assert np.abs(moved).max() < 0.01 * step


def test_what_slides_along_its_axle_does_not_roll():
    way = np.linspace(0.0, 0.5, 5)[:, None] * AXLE
    np.testing.assert_allclose(follow(way), make_wheel((0.0, 0.0, 0.0)).rest, atol=1e-12)


def test_what_is_carried_through_the_air_does_not_begin_to_roll():
    way = np.linspace(0.0, 0.5, 5)[:, None] * np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(follow(way, height=5 * RADIUS), make_wheel((0.0, 0.0, 0.0)).rest, atol=1e-12)


def test_the_matter_of_a_wheel_turns_with_it():
    wheel = make_wheel((0.0, 0.0, RADIUS))
    rolling = Rolling([wheel], np.zeros(3), UP)
    rolling.advance(wheel.rest + (0.0, 0.3, 0.0))
    F = rolling.turn(wheel.rest, np.tile(np.eye(3), (24, 1, 1)))[1]
    np.testing.assert_allclose(F[0], turn(np.eye(3), -3.0).T, atol=1e-9)


def test_a_wheel_of_a_vehicle_that_turns_about_the_upright_rolls_along_its_own_way():
    wheel = make_wheel((1.0, 0.0, RADIUS))
    rolling, steps, total = Rolling([wheel], np.zeros(3), UP), 400, 0.5 * np.pi
    x = wheel.rest
    for angle in np.linspace(0.0, total, steps + 1)[1:]:
        c, s = np.cos(angle), np.sin(angle)
        x = wheel.rest @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        rolling.advance(x)
    turned = rolling.turn(x, np.tile(np.eye(3), (24, 1, 1)))[0] - (0.0, 1.0, RADIUS)
    rest = turn(wheel.rest - wheel.hub, -total / RADIUS) @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).T
    np.testing.assert_allclose(turned, rest, atol=1e-3)
