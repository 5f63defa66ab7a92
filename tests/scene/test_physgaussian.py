import json
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.scene.compile.materials import ParticleMaterials
from physagent_jax.scene.config import (
    Cuboid,
    DomainBox,
    HalfSpace,
    MaterialModel,
    ParticleImpulse,
    ParticleRelease,
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


def release(**changes):
    return {
        "type": "release_particles_sequentially",
        "normal": [0, 0, -1],
        "start_position": 1.5,
        "end_position": 0.5,
        "num_layers": 4,
        "start_time": 0,
        "end_time": 2.0,
    } | changes


def test_sequential_release_honours_its_number_of_layers():
    config, _ = imported({"g": [0, 0, -9.8], "boundary_conditions": [release()]})
    (condition,) = config.constraints
    assert isinstance(condition, ParticleRelease)
    assert condition.normal == (0.0, 0.0, 1.0)  # positions are coordinates, whatever the normal's sign
    assert (condition.start_position, condition.end_position, condition.layers) == (1.5, 0.5, 4)
    assert (condition.start, condition.end) == (0.0, 2.0)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"normal": [0, 1, 1]}, r"\[0\].normal` must lie along one axis"),
        ({"num_layers": 0}, r"\[0\].num_layers` must be positive"),
        ({"num_layers": 2.5}, r"\[0\].num_layers` must be a whole number"),
        ({"end_position": 1.5}, r"\[0\].end_position` must differ"),
    ],
)
def test_a_bad_release_is_refused_by_its_key(change, name):
    with pytest.raises(UserError, match=name):
        imported({"g": [0, 0, 0], "boundary_conditions": [release(**change)]})


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


# --- materials ----------------------------------------------------------------------------------------

PLANE = {"material": "metal", "E": 1e5, "nu": 0.25, "density": 1000, "yield_stress": 100.0, "g": [0, 0, 0]}


def material_of(**changes):
    config, warnings = imported({key: value for key, value in (PLANE | changes).items() if value is not None})
    return config.material, [w for w in warnings if "camera" not in w]


@jax.jit
def sheared(law, steps):
    """Shears a particle of ``law`` by one step after the other; |dev tau| after each."""

    def shear(carry, step):
        F, history = carry
        F, history = law.project(jnp.eye(3).at[0, 1].set(step) @ F, history, jnp.array(1e-4))
        tau = law.stress(F, history)[0]
        return (F, history), jnp.linalg.norm(tau - jnp.trace(tau) / 3 * jnp.eye(3))

    return jax.lax.scan(shear, (jnp.eye(3)[None], jnp.zeros(1)), steps)[1]


def reference_flows(data, strain_steps):
    """PhysGaussian's return mappings of metal and plasticine, with its explicit update of the bound."""
    mu, bound = data["E"] / (2 * (1 + data["nu"])), data["yield_stress"]
    F, norms = np.eye(3), []
    for step in strain_steps:
        shear = np.eye(3)
        shear[0, 1] = step
        U, sigma, Vt = np.linalg.svd(shear @ F)
        eps = np.log(sigma)
        deviator = eps - eps.mean()
        norm = np.linalg.norm(deviator)
        if 2 * mu * norm > bound:
            gamma = norm - bound / (2 * mu)
            eps = eps - gamma / norm * deviator
            if data["material"] == "plasticine":
                bound -= data.get("softening", 0.1) * gamma
            if data.get("hardening") == 1:
                bound += 2 * mu * data["xi"] * gamma
        F = U @ np.diag(np.exp(eps)) @ Vt
        norms.append(2 * mu * np.linalg.norm(eps - eps.mean()))
    return np.array(norms)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"hardening": 1, "xi": 0.2},
        {"xi": 0.2},  # `hardening` is off
        {"material": "plasticine", "softening": 2e3},
        {"material": "plasticine", "softening": 2e3, "hardening": 1, "xi": 0.01},
        {"material": "plasticine", "softening": 2e3, "hardening": 1, "xi": 0.1},  # hardens on balance
    ],
)
def test_yield_hardening_and_softening_mean_what_they_do_in_physgaussian(changes, x64):
    data, steps = PLANE | changes, np.full(500, 2e-5)
    expected = reference_flows(data, steps)
    assert abs(expected[-1] - expected[200]) > 5 or not (changes.get("hardening") or changes.get("softening"))
    # Its bound lags behind by one step, which is 0.2 % here.
    (law,) = ParticleMaterials((imported(data)[0].material,), np.zeros(1, np.int32)).build_materials()
    np.testing.assert_allclose(sheared(law, jnp.asarray(steps)), expected, rtol=3e-3)


def test_metal_converts_as_worked_out_by_hand():
    material, (note,) = material_of(hardening=1, xi=0.5)
    assert material.model is MaterialModel.VON_MISES
    assert material.yield_stress == pytest.approx(122.474487)
    assert material.hardening_modulus == pytest.approx(3 * 4e4 * 0.5)
    assert "factor of the stretch" in note


def test_foam_keeps_its_uniaxial_yield_stress():
    material, _ = material_of(material="foam", plastic_viscosity=10.0)
    assert material.model is MaterialModel.VISCOPLASTIC
    assert (material.yield_stress, material.plastic_viscosity) == (100.0, 10.0)


def test_sand_and_snow():
    sand, (note,) = material_of(material="sand", friction_angle=30, yield_stress=None)
    assert sand.model is MaterialModel.DRUCKER_PRAGER and (sand.friction_angle, sand.cohesion) == (30.0, 0.0)
    assert "volume" in note
    snow, (note,) = material_of(material="snow", yield_stress=None)
    assert snow.model is MaterialModel.SNOW and snow.critical_compression == 2.5e-2
    assert (snow.youngs_modulus, snow.poissons_ratio, snow.density) == (1e5, 0.25, 1000.0)
    assert "no stress" in note


def test_missing_keys_take_physgaussians_defaults():
    data = {"material": "sand", "g": [0, 0, 0]}
    assert imported(data)[0].material.friction_angle == 25.0
    plasticine = imported(data | {"material": "plasticine", "yield_stress": 1e3})[0].material
    assert plasticine.softening_modulus == pytest.approx(0.15)
    foam = imported(data | {"material": "foam", "yield_stress": 1e3})[0].material
    assert foam.plastic_viscosity == 0.0


@pytest.mark.parametrize(
    ("name", "model"),
    [
        ("metal", MaterialModel.FLUID),
        ("foam", MaterialModel.FLUID),
        ("plasticine", MaterialModel.FIXED_COROTATED),
    ],
)
def test_without_a_yield_stress_matter_is_what_it_is_in_physgaussian(name, model):
    material, notes = material_of(material=name, yield_stress=0.0, plastic_viscosity=6.0)
    assert material.model is model and any("`yield_stress` is missing or 0" in note for note in notes)
    if model is MaterialModel.FLUID:
        assert material.tension and material.bulk_modulus == pytest.approx(1e5 / 1.5)
    assert material.viscosity == (3.0 if name == "foam" else None)


def test_fluid_is_warp_mpms():
    """There p = K (J^-1.1 - 1), so that -dp/dJ = 1.1 K at rest."""
    material, notes = material_of(material="fluid", bulk_modulus=2e5)
    assert material.model is MaterialModel.FLUID and material.bulk_modulus == pytest.approx(2.2e5)
    assert any("warp-mpm" in note for note in notes)
    assert material_of(material="fluid")[0].bulk_modulus == pytest.approx(1.1 * 1e5 / 1.5)


def test_regions_have_the_scenes_law_with_their_own_stiffness():
    part = {"point": [1, 1, 1], "size": [1, 1, 1], "E": 3e5, "nu": 0.25}
    config, _ = imported(PLANE | {"hardening": 1, "xi": 0.5, "additional_material_params": [part]})
    (region,) = config.material_regions
    assert region.material.yield_stress == config.material.yield_stress
    assert region.material.hardening_modulus == pytest.approx(3 * 1.2e5 * 0.5)
    assert region.material.density == 1000.0


@pytest.mark.parametrize("material", ["jelly", "metal", "sand", "foam", "snow", "plasticine", "fluid"])
def test_keys_of_other_materials_are_said_to_be_ignored(material):
    own = {
        "metal": {"yield_stress", "hardening", "xi"},
        "sand": {"friction_angle"},
        "foam": {"yield_stress", "plastic_viscosity"},
        "plasticine": {"yield_stress", "hardening", "xi", "softening"},
        "fluid": {"bulk_modulus"},
    }.get(material, set())
    values = {"yield_stress": 9, "hardening": 1, "xi": 0.1, "friction_angle": 30, "plastic_viscosity": 1}
    values |= {"softening": 1, "bulk_modulus": 1e5}
    _, warnings = imported({"material": material, "g": [0, 0, 0]} | values)
    ignored = {w.split("`")[1] for w in warnings if "is ignored" in w}
    assert ignored == values.keys() - own


def test_an_unknown_material_is_refused_with_the_known_ones():
    with pytest.raises(UserError, match=r"`material` is unknown \(got 'rubber'\).*jelly.*snow"):
        imported({"material": "rubber", "g": [0, 0, 0]})


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"E": "stiff"}, "`E`"),
        ({"E": -1}, "youngs_modulus"),
        ({"nu": 0.5}, "poissons_ratio"),
        ({"material": "fluid", "nu": 0.5}, "poissons_ratio"),
        ({"material": "metal", "yield_stress": "high"}, "`yield_stress`"),
        ({"material": "sand", "friction_angle": 95}, "friction_angle"),
        ({"material": "foam", "yield_stress": 1, "plastic_viscosity": -1}, "plastic_viscosity"),
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


HUGE = [10**400, 1e300, -1e300, 1e16, float("inf")]


@pytest.mark.parametrize("value", [*HUGE, [], {}, "x" * 5000, None, True], ids=str)
@pytest.mark.parametrize(
    "key", ["E", "g", "grid_lim", "n_grid", "frame_num", "substep_dt", "material", "scale", "rotation_axis"]
)
def test_any_value_of_any_key_is_read_or_refused_in_one_line(key, value):
    refused_or_read({"g": [0, 0, 0]} | {key: value})


@pytest.mark.parametrize("value", [*HUGE, [], {}, None, 0], ids=str)
@pytest.mark.parametrize("key", ["type", "surface", "start_time", "end_time", "friction", "point", "num_dt"])
def test_any_value_in_a_condition_is_read_or_refused_in_one_line(key, value):
    refused_or_read({"g": [0, 0, 0], "boundary_conditions": [collider() | {key: value}]})
    impulse = {"type": "particle_impulse", "force": [1, 0, 0]}
    refused_or_read({"g": [0, 0, 0], "boundary_conditions": [impulse | {key: value}]})


def refused_or_read(data):
    try:
        imported(data)
    except UserError as error:
        assert "\n" not in str(error) and len(str(error)) < 400


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grid_lim": 0}, "size"),
        ({"substep_dt": 0}, "substep_dt"),
        ({"material": ["jelly"]}, "`material`"),
        ({"material": "metl"}, "Did you mean `metal`"),
        ({"boundary_conditions": [{"type": ["cuboid"]}]}, r"`boundary_conditions\[0\].type` must be a name"),
        ({"boundary_conditions": [{"type": "cubiod"}]}, "Did you mean `cuboid`"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_what_may_be(change, message):
    with pytest.raises(UserError, match=message):
        imported({"g": [0, 0, 0]} | change)


def test_a_filling_grid_beyond_ours_is_said_to_be_cut():
    config, warnings = imported({"g": [0, 0, 0], "particle_filling": {"n_grid": 10**12}})
    assert config.filling.cells == 512
    assert any("particle_filling.n_grid" in w and "512 are taken" in w for w in warnings)
