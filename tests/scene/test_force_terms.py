"""Force terms of a scene: JSON in, motion out; what is refused; what the report says."""

import json

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces import terms
from physagent_jax.mpm import simulate
from physagent_jax.report.facts import make_scene_facts
from physagent_jax.report.force_cards import make_force_cards, read_setting
from physagent_jax.report.markup import join
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene

WIND = {
    "kind": "wind",
    "direction": [2, 0, 0],
    "speed": 1.5,
    "linear_drag": 2.0,
    "envelope": {"kind": "constant", "start": 0.04, "end": 0.16},
}
ATTRACTOR = {"kind": "attractor", "point": [1.0, 1.0, 1.0], "strength": 0.6, "softening": 0.1}
VORTEX = {"kind": "vortex", "point": [2, 2, 0], "axis": [0, 0, 2], "swirl": 3.0, "inward": 1.0, "core": 0.5}
TURBULENCE = {"kind": "turbulence", "strength": 4.0, "length_scale": 0.3, "time_scale": 0.5, "seed": 3}
UNIFORM = {
    "kind": "uniform",
    "acceleration": [0, 0, 3],
    "envelope": {"kind": "ramp", "rise": 0.1, "fall": 0.06, "end": 0.2},
    "region": {"kind": "half_space", "point": [0.5, 0.5, 0.5], "normal": [0, 0, 1]},
}


def scene_json(robot_path, *forces, center=None, frames=6):
    """A small scene as a file would hold it."""
    return {
        "source": {"path": str(robot_path), "up": "-y", "extent": 0.3, "center": center},
        "domain": {"size": 2.0, "cells": 40},
        "filling": {"max_particles": 600},
        "timing": {"frame_count": frames, "frame_dt": 0.04},
        "material": {"youngs_modulus": 2e4},
        "forces": forces,
    }


def parsed(robot_path, *forces, **rest):
    return c.SceneConfig.model_validate_json(json.dumps(scene_json(robot_path, *forces, **rest)))


@pytest.fixture(scope="module")
def built(robot_path):
    """Compile scenes of the one small body, or of one elsewhere."""
    bodies = {}

    def build(*forces, **rest):
        config = parsed(robot_path, *forces, **rest)
        place = config.source.center
        if place not in bodies:
            bodies[place] = make_body(config.source, config.filling, config.domain, ".")
        return compile_scene(config, bodies[place])

    return build


def centre(made, state):
    mass = np.asarray(made.model.mass, np.float64)
    return mass @ np.asarray(state.x) / mass.sum()


def mean_velocity(made, state):
    mass = np.asarray(made.model.mass, np.float64)
    return mass @ np.asarray(state.v) / mass.sum()


def simulate_states(made, state=None):
    timing = made.config.timing
    frames = simulate(
        made.model, state or made.state, frame_count=timing.frame_count, frame_dt=timing.frame_dt
    )
    return [frame.state for frame in frames]


def test_every_kind_compiles_to_its_term(built):
    made = built(WIND, ATTRACTOR, VORTEX, TURBULENCE, UNIFORM)
    kinds = [terms.Wind, terms.Attractor, terms.Vortex, terms.Turbulence, terms.UniformField]
    assert [type(force) for force in made.model.forces] == kinds
    wind, _, vortex, _, uniform = made.model.forces
    np.testing.assert_allclose(wind.direction, [1, 0, 0])
    np.testing.assert_allclose(vortex.axis, [0, 0, 1])
    z = np.asarray(made.state.x)[:, 2]
    np.testing.assert_array_equal(uniform.weight, z >= 0.5 * (z.min() + z.max()))
    assert (
        simulate_states(built(WIND, ATTRACTOR, VORTEX, TURBULENCE, UNIFORM, frames=3))[-1].x.dtype
        == np.float32
    )


def test_wind_carries_the_object_downwind_as_its_drag_says(built):
    """For 0.12 s in a wind of 1.5 m/s with drag 2 / s: v = 1.5 (1 - exp(-0.24)), then coasting."""
    made = built(WIND)
    states = simulate_states(made)
    speed = 1.5 * (1 - np.exp(-2.0 * 0.12))
    np.testing.assert_allclose(mean_velocity(made, states[1]), 0, atol=1e-7)
    np.testing.assert_allclose(mean_velocity(made, states[-1]), [speed, 0, 0], atol=2e-3 * speed)
    way = 1.5 * (0.12 - (1 - np.exp(-2.0 * 0.12)) / 2.0) + speed * 0.04
    np.testing.assert_allclose(
        centre(made, states[-1]) - centre(made, states[0]), [way, 0, 0], atol=0.02 * way
    )


def test_an_attractor_holds_the_object_in_orbit(built):
    """Started at circular speed, it keeps its distance and turns by the angle of Kepler's third law."""
    attractor = {**ATTRACTOR, "strength": 0.5, "softening": 0.05}
    made = built(attractor, center=[1.6, 1.0, 1.0], frames=11)
    start = centre(made, made.state) - 1.0
    radius = np.linalg.norm(start)
    across = np.cross([0, 0, 1.0], start / radius)
    across /= np.linalg.norm(across)
    rate = np.sqrt(0.5 / radius**3)
    moving = np.asarray(made.state.x) * 0 + np.float32(rate * radius * across)
    state = type(made.state).at_rest(made.state.x, v=moving, materials=made.model.materials)
    arm = centre(made, simulate_states(made, state)[-1]) - 1.0
    np.testing.assert_allclose(np.linalg.norm(arm), radius, rtol=0.01)
    angle = np.arctan2(arm @ across, arm @ start / radius)
    assert angle > 0.5
    np.testing.assert_allclose(angle, rate * 0.4, rtol=0.03)


def test_a_ramped_push_on_a_region_gives_its_share_of_momentum(built):
    made = built(UNIFORM)
    share = float((made.model.forces[0].weight * made.model.mass).sum() / made.model.mass.sum())
    change = mean_velocity(made, simulate_states(made)[-1])
    np.testing.assert_allclose(change, [0, 0, share * 3.0 * (0.2 - 0.08)], rtol=2e-3, atol=1e-5)


def test_a_vortex_carries_an_object_beside_its_axis_around_it(built):
    """It is swirled with 3 m/s^2 at the core's radius, growing with 1 / r within it, and pulled inwards."""
    made = built({**VORTEX, "point": [0.4, 1, 0]})
    v = mean_velocity(made, simulate_states(made)[-1])
    r = np.hypot(0.6, 0.5)
    around, inward = (strength * 0.5 / r * 0.6 / r * 0.2 for strength in (3.0, 1.0))
    np.testing.assert_allclose(v[:2], [-inward, around], rtol=0.15)
    np.testing.assert_allclose(v[2], 0, atol=0.02 * around)


def test_turbulence_is_that_of_its_seed(built):
    def field(seed):
        made = built({**TURBULENCE, "seed": seed})
        return np.asarray(made.model.forces[0].acceleration(made.state.x, None, None, 0.1, 0.01))

    np.testing.assert_array_equal(field(3), field(3))
    assert np.abs(field(3) - field(4)).max() > 1
    assert 0.3 * 4.0 < np.sqrt((field(3) ** 2).sum(1).mean()) < 3 * 4.0


def test_a_scene_with_terms_reads_back(robot_path):
    config = parsed(robot_path, WIND, ATTRACTOR, VORTEX, TURBULENCE, UNIFORM)
    assert c.SceneConfig.model_validate_json(c.dump_scene(config)) == config


PULSE = {"kind": "pulse", "start": 0.1}


@pytest.mark.parametrize(
    ("term", "place", "message"),
    [
        ({"kind": "storm"}, "forces.0", "kind"),
        ({**WIND, "speed": -1}, "forces.0.wind.speed", "greater than or equal to 0"),
        ({**WIND, "direction": [0, 0, 0]}, "forces.0.wind.direction", "zero vector"),
        ({**WIND, "direction": None}, "forces.0.wind", "`direction` is missing"),
        ({**WIND, "linear_drag": 0}, "forces.0.wind", "`linear_drag` and `quadratic_drag` are both 0"),
        ({**WIND, "radius": 0.3}, "forces.0.wind", "`center` and `radius` belong together"),
        ({**ATTRACTOR, "softening": 0}, "forces.0.attractor.softening", "greater than or equal to 0.000001"),
        ({**VORTEX, "swirl": 0, "inward": 0}, "forces.0.vortex", "are all 0"),
        (
            {**TURBULENCE, "length_scale": 0},
            "forces.0.turbulence.length_scale",
            "greater than or equal to 0.000001",
        ),
        ({**TURBULENCE, "seed": -1}, "forces.0.turbulence.seed", "greater than or equal to 0"),
        ({**UNIFORM, "acceleration": [0, 1]}, "forces.0.uniform.acceleration", "required"),
        ({**UNIFORM, "gust": 1}, "forces.0.uniform.gust", "not permitted"),
        ({**WIND, "envelope": {"kind": "constant", "rise": 1}}, "envelope.constant.rise", "not permitted"),
        ({**WIND, "envelope": {"kind": "ramp", "fall": 1}}, "envelope.ramp", "`fall` needs an `end`"),
        ({**WIND, "envelope": {"kind": "ramp", "rise": 2, "end": 1}}, "envelope.ramp", "must fit"),
        ({**WIND, "envelope": PULSE}, "envelope.pulse", "`end` is missing"),
        ({**WIND, "envelope": {**PULSE, "end": 0.05}}, "envelope.pulse", "`end` must exceed `start`"),
        ({**WIND, "envelope": {"kind": "sine"}}, "envelope.sine.frequency", "required"),
        ({**UNIFORM, "region": {"kind": "blob"}}, "forces.0.uniform.region", "blob"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(robot_path, term, place, message):
    with pytest.raises(UserError) as error:
        c.parse_scene(scene_json(robot_path, term), origin="scene.json")
    assert place in str(error.value) and message in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"envelope": {"kind": "constant", "start": 0.2}},
            r"forces\[0\].envelope.start.*clip's end at 0.2 s",
        ),
        (
            {"region": {"kind": "sphere", "center": [9, 9, 9], "radius": 0.1}},
            r"forces\[0\].region.*no particle",
        ),
    ],
)
def test_terms_that_would_do_nothing_are_refused(built, change, message):
    with pytest.raises(UserError, match=message):
        built({**UNIFORM, **change})


def test_the_report_tells_the_terms_in_words(robot_path):
    gust = {**WIND, "center": [1, 1, 1], "radius": 0.4, "envelope": {"kind": "sine", "frequency": 2.0}}
    drag = {"kind": "wind", "quadratic_drag": 0.3, "envelope": {"kind": "pulse", "end": 0.1}}
    scene = parsed(robot_path, gust, drag, {**ATTRACTOR, "strength": -2}, VORTEX, TURBULENCE, UNIFORM)
    expected = [
        "wind blowing right at 1.5 m/s, drag 2 1/s, within 400 mm of the line through (1.00, 1.00, 1.00) m, "
        "swinging at 2 Hz",
        "still air, drag 0.3 1/m, one smooth pulse, 0 s to 0.1 s",
        "(1.00, 1.00, 1.00) m repels with 2 m/s\u00b2 at 1 m, falling off with power 2",
        "vortex about an axis pointing up through (2.00, 2.00, 0.00) m, core 500 mm: "
        "3 m/s\u00b2 around it, 1 m/s\u00b2 towards it",
        "turbulence of 4 m/s\u00b2 on scales of 300 mm and 0.5 s, seed 3",
        "uniform acceleration (0.00, 0.00, 3.00) m/s\u00b2, rising over 0.1 s, falling over 60 ms, 0 s to 0.2 s; "
        "region: beyond (0.50, 0.50, 0.50) of the bounding box, towards (0.00, 0.00, 1.00)",
    ]
    facts = str(join(*make_scene_facts(scene, None)))
    cards = str(make_force_cards(scene.force_field, read_setting(scene)))
    for words in expected:
        assert words in facts and words in cards
    assert "No force acts" not in cards
    bare = parsed(robot_path)
    assert "No force acts" in str(make_force_cards(bare.force_field, read_setting(bare)))
