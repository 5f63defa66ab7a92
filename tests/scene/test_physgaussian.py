import json
import math

import numpy as np
import pytest

from physagent_jax.errors import UserError
from physagent_jax.scene.config import (
    Cuboid,
    DomainBox,
    HalfSpace,
    MaterialModel,
    ParticleImpulse,
    ParticleRotation,
    ParticleTranslation,
    Surface,
    dump_scene,
    parse_scene,
)
from physagent_jax.scene.physgaussian import import_physgaussian, is_physgaussian


def ficus():
    """A plant held at its foot and struck once, with the numbers of the published scene."""
    return {
        "opacity_threshold": 0.02,
        "rotation_degree": [0.0],
        "rotation_axis": [0],
        "material": "jelly",
        "E": 2e6,
        "nu": 0.4,
        "density": 200,
        "g": [0, 0, 0],
        "grid_v_damping_scale": 0.9999,
        "n_grid": 50,
        "substep_dt": 1e-4,
        "frame_dt": 4e-2,
        "frame_num": 125,
        "additional_material_params": [
            {"point": [1, 1, 1.5], "size": [1, 1, 0.5], "E": 2e6, "nu": 0.4, "density": 70}
        ],
        "boundary_conditions": [
            {
                "type": "cuboid",
                "point": [1, 1, 0.5],
                "size": [0.5, 0.5, 0.28],
                "velocity": [0, 0, 0],
                "reset": 1,
            },
            {"type": "particle_impulse", "force": [-0.18, 0, 0], "num_dt": 1, "start_time": 0},
        ],
        "default_camera_index": -1,
        "init_azimuthm": 45.0,
        "init_elevation": 5.0,
        "init_radius": 4.0,
    }


def bread():
    """Soft bread, pulled apart along y."""
    return {
        "material": "jelly",
        "E": 2e3,
        "nu": 0.3,
        "g": [0, 0, 0],
        "rpic_damping": 0.5,
        "grid_v_damping_scale": 0.9995,
        "n_grid": 150,
        "frame_dt": 1e-2,
        "frame_num": 300,
        "particle_filling": {
            "n_grid": 200,
            "density_threshold": 2.0,
            "max_partciels_per_cell": 3,
            "boundary": [0, 2, 0, 2, 0, 2],
            "visualize": True,
        },
        "boundary_conditions": [
            {"type": "bounding_box"},
            {
                "type": "enforce_particle_translation",
                "point": [1, 1.25, 1],
                "size": [1, 0.05, 1],
                "velocity": [0, 0.2, 0],
                "start_time": 0,
                "end_time": 1000,
            },
            {
                "type": "enforce_particle_translation",
                "point": [1, 0.75, 1],
                "size": [1, 0.05, 1],
                "velocity": [0, -0.2, 0],
                "start_time": 0,
                "end_time": 2.2,
            },
        ],
    }


def vase():
    """A vase twisted there and back."""
    cylinder = {
        "type": "enforce_particle_velocity_rotation",
        "point": [1, 1, 1.4],
        "normal": [0, 0, 2],
        "half_height_and_radius": [0.1, 0.3],
        "translation_scale": 0.0,
    }
    return {
        "E": 1e4,
        "nu": 0.3,
        "density": 40,
        "g": [0, 0, 0],
        "n_grid": 120,
        "frame_dt": 0.04,
        "frame_num": 75,
        "boundary_conditions": [
            cylinder | {"rotation_scale": 1.9, "start_time": 0, "end_time": 0.3},
            cylinder | {"rotation_scale": 0, "start_time": 0.3, "end_time": 1.0},
            cylinder | {"rotation_scale": -1.9, "start_time": 1.0, "end_time": 1.3},
        ],
    }


def imported(data, **options):
    return import_physgaussian(data, object_path="object.ply", **options)


@pytest.mark.parametrize("make", [ficus, bread, vase])
def test_scenes_are_recognised_and_survive_a_round_trip_through_json(make):
    assert is_physgaussian(make())
    config, _ = imported(make())
    text = dump_scene(config)
    assert parse_scene(json.loads(text)) == config
    assert not is_physgaussian(json.loads(text))


def test_nothing_else_is_recognised():
    assert not any(
        is_physgaussian(data)
        for data in ([], None, {}, {"E": 1.0}, {"source": {}, "n_grid": 1, "grid_lim": 2})
    )


def test_defaults_are_physgaussians():
    config, warnings = imported({"g": [0, 0, -9.8]})
    assert config.material.model is MaterialModel.FIXED_COROTATED
    assert (config.material.youngs_modulus, config.material.poissons_ratio, config.material.density) == (
        1e5,
        0.4,
        200.0,
    )
    assert (config.domain.size, config.domain.cells) == (2.0, 50)
    assert (config.timing.substep_dt, config.timing.frame_dt) == (1e-4, 1e-2)
    assert config.timing.frame_count == 101  # 100 intervals
    assert (config.source.opacity_threshold, config.source.extent, config.source.center) == (
        0.02,
        1.0,
        (1.0, 1.0, 1.0),
    )
    assert not config.filling.enabled and config.filling.volumes == "cells"
    assert config.gravity == (0.0, 0.0, -9.8) and config.always_gravity
    assert (
        config.transfer.scheme == "apic"
        and config.transfer.damping_rate == 0
        and config.transfer.rpic_damping == 0
    )
    assert config.boundaries == (DomainBox(padding=3),)
    assert len(warnings) == 1 and "camera" in warnings[0]


def test_the_plant():
    config, warnings = imported(ficus())
    (region,) = config.material_regions
    assert region.half_size == (1.0, 1.0, 0.5) and region.material.density == 70
    assert region.material.model is MaterialModel.FIXED_COROTATED
    cuboid, walls = config.boundaries
    assert (
        isinstance(cuboid, Cuboid)
        and cuboid.half_size == (0.5, 0.5, 0.28)
        and (cuboid.start, cuboid.end) == (0, 1e3)
    )
    assert isinstance(walls, DomainBox)
    (impulse,) = config.constraints
    assert isinstance(impulse, ParticleImpulse)
    assert impulse.force == (-0.18, 0, 0) and impulse.duration == pytest.approx(1e-4)
    assert impulse.point == impulse.half_size == (1.0, 1.0, 1.0)
    # 400 substeps of a factor 0.9999 make up one frame of 0.04 s.
    assert math.exp(-config.transfer.damping_rate * 0.04) == pytest.approx(0.9999**400)
    assert sum("reset" in w for w in warnings) == 1


def test_the_bread():
    config, warnings = imported(bread())
    first, second = config.constraints
    assert isinstance(first, ParticleTranslation) and first.velocity == (0.0, 0.2, 0.0) and first.end == 1000
    assert second.velocity == (0.0, -0.2, 0.0) and second.end == 2.2
    assert config.transfer.rpic_damping == 0.5
    filling = config.filling
    assert filling.enabled and filling.particles_per_cell == 3  # despite the misspelt key
    assert filling.cells == 100  # 200 over 2 m, an object of 1 m
    assert (filling.density_unit, filling.density_threshold, filling.search_threshold) == (
        "overlap",
        2.0,
        3.0,
    )
    assert (filling.exclude_direction, filling.ray_cast_direction, filling.max_particles) == (5, 4, 2_000_000)
    assert {w.split("`")[1] for w in warnings} >= {"particle_filling.visualize", "particle_filling.boundary"}


def test_the_vase_turns_left_handed_as_physgaussian_does():
    config, _ = imported(vase())
    first, pause, back = config.constraints
    assert all(isinstance(c, ParticleRotation) for c in config.constraints)
    assert (first.half_height, first.radius, first.normal) == (0.1, 0.3, (0.0, 0.0, 1.0))
    assert (first.angular_velocity, pause.angular_velocity, back.angular_velocity) == (-1.9, 0.0, 1.9)
    # PhysGaussian: v = s r (-sin(t) h1 + cos(t) h2), h1 = (1,1,1) made horizontal, h2 = h1 x normal, at angle t
    # from h1 towards h2. At t = 0 the velocity is s r h2.
    n = np.array(first.normal)
    h1 = np.array([1, 1, 0]) / math.sqrt(2)
    velocity = 1.9 * 0.2 * np.cross(h1, n)
    np.testing.assert_allclose(np.cross(first.angular_velocity * n, 0.2 * h1), velocity, atol=1e-12)


def collider(**changes):
    return {
        "type": "surface_collider",
        "point": [1, 1, 0.5],
        "normal": [0, 0, 2],
        "surface": "sticky",
        "friction": 0,
        "start_time": 0,
        "end_time": 9,
    } | changes


@pytest.mark.parametrize(
    ("name", "surface"),
    [
        ("sticky", Surface.STICKY),
        ("slip", Surface.SLIP),
        ("separate", Surface.SEPARATE),
        ("whatever", Surface.SEPARATE),
    ],
)
def test_surfaces(name, surface):
    config, warnings = imported({"g": [0, 0, 0], "boundary_conditions": [collider(surface=name)]})
    plane = config.boundaries[0]
    assert isinstance(plane, HalfSpace) and plane.surface is surface and plane.normal == (0, 0, 1)
    assert any("acts as sticky" in w for w in warnings) == (name != "sticky")


def test_friction_is_kept_where_it_means_something():
    data = {"g": [0, 0, 0], "boundary_conditions": [collider(surface="separate", friction=0.4)]}
    assert imported(data)[0].boundaries[0].friction == 0.4


def test_sequential_release_lets_the_outermost_layer_go_first():
    release = {
        "type": "release_particles_sequentially",
        "normal": [0, 0, 1],
        "start_position": 1.5,
        "end_position": 0.5,
        "num_layers": 4,
        "start_time": 0,
        "end_time": 2.0,
    }
    config, _ = imported({"g": [0, 0, -9.8], "boundary_conditions": [release]})
    assert [c.end for c in config.constraints] == [0.5, 1.0, 1.5, 2.0]
    assert [c.half_size for c in config.constraints] == [(1.0, 1.0, s) for s in (1.0, 0.75, 0.5, 0.25)]
    assert all(c.point == (1.0, 1.0, 0.5) and c.velocity == (0.0, 0.0, 0.0) for c in config.constraints)


def test_what_is_left_out_is_said():
    data = {
        "g": [0, 0, 0],
        "pic_damping": 0.1,
        "show_hint": True,
        "yield_stress": 5,
        "my_key": 1,
        "boundary_conditions": [collider(surface="cut"), {"type": "teleport"}, collider(end_time=0)],
    }
    config, warnings = imported(data)
    assert len(config.boundaries) == 1
    for word in ("pic_damping", "show_hint", "yield_stress", "my_key", "'cut'", "'teleport'", "end_time"):
        assert sum(word in w for w in warnings) == 1, word


@pytest.mark.parametrize("material", ["metal", "sand", "foam", "snow", "plasticine"])
def test_materials_that_are_not_available_are_refused_by_name(material):
    with pytest.raises(UserError, match=rf"not available yet \(got '{material}'\).*jelly"):
        imported({"material": material, "g": [0, 0, 0]})


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"E": "stiff"}, "`E`"),
        ({"E": -1}, "youngs_modulus"),
        ({"nu": 0.5}, "poissons_ratio"),
        ({"nu": float("nan")}, "`nu`"),
        ({"n_grid": 50.5}, "`n_grid`"),
        ({"g": [0, 0]}, "`g`"),
        ({"sim_area": [0, 1]}, "`sim_area`"),
        ({"substep_dt": True}, "`substep_dt`"),
        ({"grid_v_damping_scale": 0}, "`grid_v_damping_scale`"),
        ({"boundary_conditions": {}}, "`boundary_conditions`"),
        ({"boundary_conditions": [3]}, r"`boundary_conditions\[0\]`"),
        (
            {"boundary_conditions": [{"type": "cuboid", "size": [1, 1, 1]}]},
            r"`boundary_conditions\[0\].point` is missing",
        ),
        (
            {"boundary_conditions": [{"type": "particle_impulse"}]},
            r"`boundary_conditions\[0\].force` is missing",
        ),
        (
            {"additional_material_params": [{"point": [1, 1, 1], "size": [1, 1, 1], "nu": 0.3}]},
            r"\[0\].E` is missing",
        ),
        ({"particle_filling": 3}, "`particle_filling`"),
        ({"rotation_degree": [1], "rotation_axis": []}, "rotation_degrees"),
    ],
)
def test_errors_name_the_key(change, name):
    with pytest.raises(UserError, match=name):
        imported({"g": [0, 0, 0]} | change)


def test_missing_gravity_is_the_scalar_quirk():
    config, warnings = imported({})
    assert config.gravity == (0.0, 0.0, -9.8)
    assert any("`g` is missing" in w for w in warnings)


def test_pic_is_what_a_negative_rpic_damping_means():
    transfer = imported({"g": [0, 0, 0], "rpic_damping": -1})[0].transfer
    assert transfer.scheme == "pic" and transfer.rpic_damping == 0


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 200.0])
def test_the_orbit_camera_stands_where_physgaussians_does(azimuth):
    data = ficus() | {"init_azimuthm": azimuth, "init_elevation": 20.0, "init_radius": 6.0}
    camera = imported(data, file_units_per_metre=3.0)[0].camera
    assert camera.distance == pytest.approx(2.0) and camera.elevation_degrees == 20.0
    # With z up, PhysGaussian counts from (1, 1, 0) towards (1, -1, 0).
    t = math.radians(azimuth)
    theirs = (math.cos(t) * np.array([1, 1]) + math.sin(t) * np.array([1, -1])) / math.sqrt(2)
    a = math.radians(camera.azimuth_degrees)
    np.testing.assert_allclose((math.sin(a), -math.cos(a)), theirs, atol=1e-12)


def test_the_radius_is_said_to_be_in_file_units():
    assert any("init_radius" in w for w in imported(ficus())[1])
    assert not any("init_radius" in w for w in imported(ficus(), file_units_per_metre=1.0)[1])
