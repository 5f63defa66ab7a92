"""Obstacles and constraints of a scene: what the JSON says is what the simulator gets, or a message that helps."""

import json

import numpy as np
import pytest

from physagent_jax import mpm
from physagent_jax.core.errors import UserError
from physagent_jax.mpm import simulate
from physagent_jax.report.facts import describe_boundary, describe_constraint
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.compile.boundaries import compile_boundaries
from physagent_jax.scene.compile.constraints import compile_constraints

NOWHERE = {"path": "object.ply"}


def scene(**parts):
    """A scene by way of its JSON."""
    return c.parse_scene(json.loads(json.dumps({"source": NOWHERE, **parts})))


def obstacles(*boundaries, base_dir="."):
    return compile_boundaries(scene(boundaries=boundaries), base_dir)


def held(constraint, rest):
    forces, motions = compile_constraints(
        scene(constraints=[constraint]), np.asarray(rest, np.float32), np.ones(len(rest))
    )
    assert forces == ()
    return motions[0]


# --- obstacles ---------------------------------------------------------------------------------------

ALIKE = {"friction": 0.25, "start": 0.5, "end": 2.0, "surface": "slip", "velocity": [0.1, 0.0, 0.0]}


@pytest.mark.parametrize(
    ("kind", "shape"),
    [
        (mpm.HalfSpace, {"kind": "half_space", "point": [1, 2, 3], "normal": [0, 0, 2]}),
        (mpm.Sphere, {"kind": "sphere", "point": [1, 2, 3], "radius": 0.5}),
        (mpm.Box, {"kind": "box", "point": [1, 2, 3], "half_size": [0.5, 0.5, 0.5], "container": True}),
    ],
)
def test_an_obstacle_has_the_numbers_of_its_json(kind, shape):
    (made,) = obstacles(shape | ALIKE)
    assert isinstance(made, kind) and made.contact is mpm.Contact.SLIP
    np.testing.assert_array_equal(made.point, [1, 2, 3])
    np.testing.assert_allclose((made.friction, made.start, made.end), (0.25, 0.5, 2.0))
    np.testing.assert_allclose(made.velocity, [0.1, 0, 0])
    assert getattr(made, "container", None) == shape.get(
        "container", False if kind is not mpm.HalfSpace else None
    )
    if kind is mpm.HalfSpace:
        np.testing.assert_allclose(made.normal, [0, 0, 1])
    if kind is mpm.Box:
        np.testing.assert_allclose(made.half_size, 0.5)


def test_what_stands_still_has_no_velocity_to_compute_with():
    (made,) = obstacles({"kind": "sphere", "point": [1, 1, 1], "radius": 1})
    assert made.velocity is None and made.contact is mpm.Contact.SEPARATE and not made.container


@pytest.mark.parametrize(
    ("boundary", "field"),
    [
        ({"kind": "sphere", "point": [1, 1, 1], "radius": -1}, "boundaries.0.sphere.radius"),
        ({"kind": "sphere", "point": [1, 1, 1]}, "boundaries.0.sphere.radius"),
        ({"kind": "sphere", "point": [1, 1, 1], "radius": 1, "mass": 2}, "boundaries.0.sphere.mass"),
        ({"kind": "box", "point": [1, 1, 1], "half_size": [1, 0, 1]}, r"boundaries.0.box.half_size.1"),
        ({"kind": "box", "point": [1, 1], "half_size": [1, 1, 1]}, "boundaries.0.box.point"),
        ({"kind": "half_space", "point": [1, 1, 1], "normal": [0, 0, 0]}, "boundaries.0.half_space.normal"),
        ({"kind": "mesh"}, "boundaries.0.mesh.path"),
        ({"kind": "mesh", "path": "a.obj", "rotation_degrees": [90]}, "rotation_axes"),
        (
            {"kind": "mesh", "path": "a.obj", "rotation_degrees": [90], "rotation_axes": [3]},
            "boundaries.0.mesh.rotation_axes.0",
        ),
        (
            {"kind": "sphere", "point": [1, 1, 1], "radius": 1, "start": 2, "end": 1},
            "`end` must exceed `start`",
        ),
        ({"kind": "pyramid"}, "boundaries.0"),
    ],
)
def test_a_bad_obstacle_is_refused_by_the_name_of_its_field(boundary, field):
    with pytest.raises(UserError, match=field):
        scene(boundaries=[boundary])


# --- constraints -------------------------------------------------------------------------------------

RELEASE = {"kind": "particle_release", "normal": [0, 0, 2], "start_position": 1.5, "end_position": 0.5}


@pytest.mark.parametrize("layers", [1, 4, 7])
def test_a_release_is_that_of_nested_boxes_let_go_in_turn(layers):
    """PhysGaussian's way: box i is held until end (i + 1) / layers; a particle is free after its last box."""
    rest = np.random.default_rng(0).uniform(0, 2, (200, 3))
    made = held(RELEASE | {"layers": layers, "start": 0.1, "end": 2.0}, rest)
    until = np.full(len(rest), -1.0)
    for i in range(layers):
        box = np.abs(rest[:, 2] - 0.5) <= 1.0 * (layers - i) / layers
        until = np.where(box, 2.0 * (i + 1) / layers, until)
    assert isinstance(made, mpm.PrescribedMotion)
    count = (until > 0).sum()
    np.testing.assert_array_equal(made.particles[:count], np.flatnonzero(until > 0))
    np.testing.assert_allclose(made.end[:count], until[until > 0], rtol=1e-6)
    assert (np.asarray(made.particles[count:]) == len(rest)).all()  # fills up: no particle
    assert 0 < count < len(rest) and float(made.start) == np.float32(0.1)
    assert not np.asarray(made.velocity).any() and not np.asarray(made.angular_velocity).any()


def test_layers_may_lie_along_any_direction():
    n = np.array([3.0, 0.0, 4.0]) / 5
    rest = np.linspace(0.05, 0.95, 10)[:, None] * n + np.array([0.0, 1.0, 0.0])
    made = held(
        {**RELEASE, "normal": [3, 0, 4], "start_position": 1.0, "end_position": 0.0, "layers": 2, "end": 1.0},
        rest,
    )
    np.testing.assert_allclose(made.end, [1.0] * 5 + [0.5] * 5)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"layers": 0}, "constraints.0.particle_release.layers"),
        ({}, "constraints.0.particle_release.layers"),
        ({"layers": 3, "end_position": 1.5}, "`start_position` and `end_position` must differ"),
        ({"layers": 3, "normal": [0, 0, 0]}, "constraints.0.particle_release.normal"),
        ({"layers": 3, "velocity": [0, 0, 0]}, "constraints.0.particle_release.velocity"),
    ],
)
def test_a_bad_release_is_refused_by_the_name_of_its_field(change, field):
    with pytest.raises(UserError, match=field):
        scene(constraints=[RELEASE | change])


def test_a_release_of_nothing_is_refused():
    with pytest.raises(UserError, match=r"constraints\[0\]. selects no particle.*spans"):
        held(RELEASE | {"layers": 2}, np.full((3, 3), 9.0))


def test_a_rotation_turns_about_its_point():
    made = held(
        {
            "kind": "particle_rotation",
            "point": [1, 2, 3],
            "normal": [0, 0, 5],
            "half_height": 1,
            "radius": 1,
            "angular_velocity": 2.0,
            "axial_velocity": -0.5,
        },
        [[1.5, 2, 3], [9, 9, 9]],
    )
    np.testing.assert_array_equal(made.particles, [0])
    np.testing.assert_array_equal(made.center, [1, 2, 3])
    np.testing.assert_allclose(made.angular_velocity, [0, 0, 2])
    np.testing.assert_allclose(made.velocity, [0, 0, -0.5])


# --- all of them -------------------------------------------------------------------------------------


def test_a_scene_with_every_kind_round_trips_compiles_and_plays(robot_path, tmp_path):
    import trimesh

    trimesh.creation.icosphere(subdivisions=2, radius=0.3).export(tmp_path / "ball.stl")
    config = c.SceneConfig(
        source=c.Source(path=str(robot_path), up="-y"),
        domain=c.Domain(size=4.0, cells=32),
        filling=c.Filling(max_particles=800),
        boundaries=(
            c.DomainBox(),
            c.HalfSpace(point=(0, 0, 0.5), normal=(0, 0, 1), friction=0.3, velocity=(0.2, 0, 0)),
            c.Sphere(point=(2, 2, 0.8), radius=0.5),
            c.Box(point=(2, 2, 2), half_size=(1.8, 1.8, 1.8), container=True),
            c.Mesh(path="ball.stl", position=(3, 2, 2), velocity=(-0.5, 0, 0), end=1.0),
            c.Cuboid(point=(2, 2, 3.5), half_size=(0.1, 0.1, 0.1)),
        ),
        constraints=(
            c.ParticleRelease(normal=(0, 0, 1), start_position=2.6, end_position=1.4, layers=3, end=0.05),
        ),
        always_gravity=True,
    )
    assert c.parse_scene(json.loads(c.dump_scene(config))) == config
    made = compile_scene(config, make_body(config.source, config.filling, config.domain, "."), tmp_path)
    kinds = [type(b).__name__ for b in made.model.boundaries]
    assert kinds == ["DomainBox", "HalfSpace", "Sphere", "Box", "SignedDistance", "Cuboid"]
    last = list(simulate(made.model, made.state, frame_count=3, frame_dt=0.04))[-1]
    fallen = np.asarray(made.state.x - last.state.x)[:, 2]
    assert np.isfinite(fallen).all() and 0 < fallen.mean() < 0.5 * 9.8 * 0.08**2
    walls = [describe_boundary(b) for b in config.boundaries]
    assert "moving at (0.20, 0.00, 0.00) m/s" in walls[1] and "friction 0.3" in walls[1]
    assert "solid sphere" in walls[2] and "container box" in walls[3] and "ball.stl" in walls[4]
    assert "held" in walls[5] and "3 layers" in describe_constraint(config.constraints[0])
