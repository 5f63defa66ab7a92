"""Tipping over of a rigid box about its edge, step by step: past its balance, and no further."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces import calibration
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Opposition

G, AXIS, FRAME_DT, FRAMES, DT = calibration.GRAVITY, np.array([0.0, 1.0, 0.0]), 0.04, 51, 4e-3
SHAPES = {
    "tower": (0.25, 1.0),
    "block": (0.5, 1.0),
    "cube": (1.0, 1.0),
    "low": (1.0, 0.7),
    "flat": (1.0, 0.45),
    "long": (0.4, 0.8, 3.0),
}


def tip(width, height, depth=0.5, strength=1.0):
    """Angles [rad] and speeds [rad/s] until it lies, and the time [s], of a box that is tipped to the right."""
    grid = [np.linspace(-0.5, 0.5, 7)] * 3
    rest = np.array(list(itertools.product(*grid))) * [width, depth, height]
    edge = np.array([width / 2, 0.0, -height / 2])
    arm, mass = rest - edge, np.full(len(rest), 1.0)
    flat = (rest[:, [0, 2]] ** 2).sum(1).mean()
    usual = (rest**2).sum(1).mean() - 0.5 * (rest[:, :2] ** 2).sum(1).mean()  # as about any level axis
    opposition = Opposition(weight=G, tipping=G * width / 2 / usual, turning=1.0, travel=1.0, time=2.0)
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=1e5, density=1.0, duration=2.0, opposition=opposition
    )
    magnitude, seconds = calibration.find_tipping(strength, 2.0, 2.0)
    action = dict(
        action_type="torque",
        vector=AXIS,
        magnitude=min(magnitude, calibration.MAGNITUDE_MAX),
        active_time=(0, round(seconds / FRAME_DT)),
    )
    forces, _ = compile_force_field(
        ForceField.model_validate(dict(actions=[action])),
        scaling,
        rest.astype(np.float32),
        np.ones(len(rest), np.float32),
        frame_dt=FRAME_DT,
        frame_count=FRAMES,
    )
    push = jax.jit(lambda *state: sum(each.acceleration(*state) for each in forces))
    inertia, angle, speed, times = (arm[:, [0, 2]] ** 2).sum(), 0.0, 0.0, np.arange(0, 4, DT)
    angles, speeds = [], []
    for time in times:
        c, s = np.cos(angle), np.sin(angle)
        at = arm @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        state = (jnp.asarray(each, jnp.float32) for each in (at, speed * np.cross(AXIS, at), mass, time, DT))
        field = np.asarray(push(*state), float) + [0, 0, -G]
        moment = np.cross(at, field)[:, 1].sum()
        speed = 0.0 if angle <= 0 and moment < 0 else speed + DT * moment / inertia
        angle += DT * speed
        angles.append(angle)
        speeds.append(speed)
        if angle >= np.pi / 2:
            break
    lying = arm @ np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
    for later in (time, 1.6):  # it lies where it has fallen
        state = (jnp.asarray(each, jnp.float32) for each in (lying, 0 * lying, mass, later, DT))
        moment = np.cross(lying, np.asarray(push(*state), float))[:, 1].sum()
        assert moment <= 1.01 * scaling.torque * calibration.MAGNITUDE_MAX * len(rest) * flat
    return np.array(angles), np.array(speeds), time


@pytest.mark.parametrize("strength", [0.6, 1.0, 1.6])
@pytest.mark.parametrize("shape", SHAPES)
def test_weight_does_the_rest_once_it_is_past_its_balance(shape, strength):
    width, height, *_ = SHAPES[shape]
    angles, speeds, time = tip(*SHAPES[shape], strength=strength)
    assert angles[-1] >= np.pi / 2 and time < 3.0, "it lies in good time"
    balance, reach = np.arctan2(width, height), 0.5 * np.hypot(width, height)
    inertia = (width**2 + height**2) / 12 + reach**2
    slow = speeds[np.searchsorted(angles, balance)]
    asked = 2 * calibration.TIPPED / calibration.TIPPING_TIME  # the speed at the end of the drive
    assert slow < 1.5 * np.sqrt(strength) * asked, "it is not flung over"
    fallen = np.sqrt(slow**2 + 2 * G * (reach - 0.5 * width) / inertia)
    assert speeds[-1] < 1.15 * fallen, "nothing drives it on as it falls"
