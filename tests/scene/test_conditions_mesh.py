"""Meshes as obstacles: their sampled distance against exact ones, and what cannot be sampled."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from physagent_jax import mpm
from physagent_jax.core.errors import UserError
from physagent_jax.mpm.boundaries import SignedDistance
from physagent_jax.mpm.limits import find_limits
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.boundaries import compile_boundaries
from physagent_jax.scene.kernels import triangles as kernel
from physagent_jax.scene.signed_distance import BAND, MARGIN, load_solid, sample
from tests.mpm.blocks import block


def compiled(path, *, cells=32, size=1.0, base_dir=".", **options):
    domain = {"size": size, "cells": cells}
    mesh = {"kind": "mesh", "path": str(path), **options}
    config = c.parse_scene(
        json.loads(json.dumps({"source": {"path": "x"}, "domain": domain, "boundaries": [mesh]}))
    )
    (obstacle,) = compile_boundaries(config, base_dir)
    assert isinstance(obstacle, SignedDistance) and obstacle.spacing == size / cells
    return obstacle


def samples(obstacle):
    """Positions of the samples and phi there."""
    index = np.indices(obstacle.values.shape).reshape(3, -1).T
    return np.asarray(obstacle.origin) + index * obstacle.spacing, np.asarray(obstacle.values).ravel()


def box_distance(points, half):
    beyond = np.abs(points) - half
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(1), 0)


@pytest.fixture
def ball_path(tmp_path):
    trimesh.creation.icosphere(subdivisions=4, radius=1.0).export(tmp_path / "ball.obj")
    return tmp_path / "ball.obj"


def test_a_ball_has_the_distance_of_a_sphere_to_the_order_of_its_facets(ball_path):
    """The facets of a sphere cut in 2^k parts lie inside by O(4^-k), and no grid makes it worse near the surface.

    Far from it a distance is that to one near facet of many: right to a twentieth of a cell.
    """
    errors = []
    for subdivisions in (2, 3, 4):
        triangles = np.asarray(trimesh.creation.icosphere(subdivisions=subdivisions, radius=0.3).triangles)
        phi, first = sample(triangles + 0.5, 0.05, 0.0, 1.0, "mesh")
        points = first + 0.05 * np.indices(phi.shape).reshape(3, -1).T
        exact = np.linalg.norm(points - 0.5, axis=1) - 0.3
        error, near = np.abs(phi.ravel() - exact), np.abs(exact) < BAND * 0.05 - 0.006
        errors.append(error[near].max())
        assert error.max() < max(errors[-1], 0.05 * 0.05) + 0.002
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2, atol=0.35)
    assert errors[-1] < 0.0004


@pytest.mark.parametrize("sections", [5, 16, 400])
def test_facets_of_any_size_and_shape_have_exact_distances_near_them(sections):
    """A prism, turned: long slivers on its side and fans on its ends, from much larger to much finer than the cells."""
    turn = Rotation.from_euler("xyz", (25.0, 40.0, 10.0), degrees=True)
    prism = trimesh.creation.cylinder(radius=0.3, height=0.5, sections=sections)
    turned = turn.apply(np.array(prism.triangles).reshape(-1, 3)).reshape(-1, 3, 3)
    spacing = 1 / 24
    phi, first = sample(turned + 0.5, spacing, 0.0, 1.0, "mesh")
    points = turn.inv().apply(first + spacing * np.indices(phi.shape).reshape(3, -1).T - 0.5)
    # The prism over a regular polygon: distance to the polygon in the plane, joined with that along the axis.
    corner = np.linspace(0, 2 * np.pi, sections, endpoint=False)  # the mesh has one on the x axis
    polygon = 0.3 * np.stack([np.cos(corner), np.sin(corner)], axis=1)
    across, along = measure_polygon(points[:, :2], polygon), np.abs(points[:, 2]) - 0.25
    outside = np.hypot(np.maximum(across, 0), np.maximum(along, 0))
    exact = outside + np.minimum(np.maximum(across, along), 0)
    near = np.abs(exact) < (BAND - 1e-6) * spacing
    np.testing.assert_allclose(phi.ravel()[near], exact[near], atol=1e-9)


def measure_polygon(points, corners):
    """Signed distance to a convex polygon, its corners in order."""
    edges = np.roll(corners, -1, axis=0) - corners
    offset = points[:, None] - corners
    share = np.clip((offset * edges).sum(2) / (edges**2).sum(1), 0, 1)
    distance = np.linalg.norm(offset - share[..., None] * edges, axis=2).min(1)
    inside = ((edges[:, 0] * offset[..., 1] - edges[:, 1] * offset[..., 0]) > 0).all(1)
    return np.where(inside, -distance, distance)


def test_few_large_faces_cost_as_much_as_their_area():
    """A box as large as the domain: some six nodes on either side of each cell of its surface, and each node beyond."""
    cells = 64
    box = cells * (np.asarray(trimesh.creation.box((1, 1, 1)).triangles) + 0.5) + MARGIN
    distance, _, pairs = kernel.measure(box, (cells + 2 * MARGIN + 1,) * 3, BAND)
    assert pairs < 8 * (6 * cells**2) + 2 * distance.size


def test_fine_faces_cost_little_more_than_their_nodes():
    """Thirty triangles a cell of the surface: nodes that know a near one look at few others."""
    ball = 8 * np.asarray(trimesh.creation.icosphere(subdivisions=5).triangles) + 11
    distance, _, pairs = kernel.measure(ball, (23, 23, 23), BAND)
    assert pairs < 20 * distance.size


def test_scale_rotation_and_position_are_applied_in_that_order(tmp_path):
    half, degrees, centre = np.array([1.0, 2.0, 0.5]), (30.0, 45.0), np.array([0.55, 0.5, 0.45])
    trimesh.creation.box(2 * half).export(tmp_path / "brick.stl")
    obstacle = compiled(
        "brick.stl",
        base_dir=tmp_path,
        scale=0.1,
        position=centre.tolist(),
        rotation_degrees=degrees,
        rotation_axes=[2, 0],
    )
    turn = Rotation.from_euler("zx", degrees, degrees=True)  # about fixed axes, z first
    points, phi = samples(obstacle)
    exact = box_distance(turn.inv().apply(points - centre), 0.1 * half)
    near = np.abs(exact) < BAND / 32
    np.testing.assert_allclose(phi[near], exact[near], atol=2e-6)
    np.testing.assert_array_equal(phi[np.abs(exact) > 1e-6] < 0, exact[np.abs(exact) > 1e-6] < 0)
    np.testing.assert_allclose(phi, exact, atol=0.5 / 32)  # far away it is roughly right


def test_the_samples_lie_on_the_grids_nodes_with_a_margin(ball_path):
    obstacle = compiled(ball_path, scale=0.2, position=[0.5, 0.5, 0.5])
    on_nodes = np.asarray(obstacle.origin) * 32
    np.testing.assert_allclose(on_nodes, np.round(on_nodes), atol=1e-5)
    phi = np.asarray(obstacle.values)
    rim = np.concatenate([np.take(phi, [0, -1], axis=axis).ravel() for axis in range(3)])
    assert rim.min() > (MARGIN - 1) / 32


def test_a_block_rebounds_from_a_mesh_as_from_a_sphere(ball_path, x64):
    """The whole way: file, samples, contact."""
    mesh = compiled(ball_path, cells=20, scale=0.22, position=[0.52, 0.48, 0.3])
    sphere = mpm.Sphere(
        jnp.array([0.52, 0.48, 0.3]), jnp.asarray(0.22), mesh.friction, mesh.start, mesh.end, mesh.contact
    )
    ends = []
    for obstacle in (mesh, sphere):
        model, state = block(
            (2, 2, 2), low=(0.47, 0.47, 0.55), youngs_modulus=5e4, dtype=np.float64, boundaries=(obstacle,)
        )
        state = mpm.State.at_rest(state.x, jnp.full_like(state.v, 0.0).at[:, 2].set(-1.0))
        ends.append(
            jax.jit(lambda m, s: jax.lax.fori_loop(0, 200, lambda _, s: mpm.step(m, s), s))(model, state)
        )
    assert float(ends[1].v[:, 2].mean()) > 0.1
    np.testing.assert_allclose(ends[0].x.mean(0), ends[1].x.mean(0), atol=2e-3)
    np.testing.assert_allclose(ends[0].v.mean(0), ends[1].v.mean(0), atol=2e-2)


def test_overlapping_parts_make_one_solid_whichever_way_their_faces_turn():
    first = np.asarray(trimesh.creation.box((0.4, 0.4, 0.4)).triangles) + 0.4
    second = np.asarray(trimesh.creation.box((0.4, 0.4, 0.4)).triangles) + 0.55
    for triangles in (np.concatenate([first, second]), np.concatenate([first, second])[:, ::-1]):
        phi, low = sample(triangles, 0.05, 0.0, 1.0, "mesh")
        points = low + 0.05 * np.indices(phi.shape).reshape(3, -1).T
        exact = np.minimum(box_distance(points - 0.4, 0.2), box_distance(points - 0.55, 0.2))
        clear = np.abs(exact) > 1e-6
        np.testing.assert_array_equal((phi.ravel() <= 0)[clear], (exact < 0)[clear])


def test_a_hollow_is_not_solid():
    """A box with a box-shaped cavity, whose faces turn the other way."""
    outer = np.asarray(trimesh.creation.box((0.8, 0.8, 0.8)).triangles)
    inner = np.asarray(trimesh.creation.box((0.4, 0.4, 0.4)).triangles)[:, ::-1]
    axis = np.linspace(-0.5, 0.5, 21)
    _, winding, _ = kernel.measure(20 * (np.concatenate([outer, inner]) + 0.5), (21, 21, 21), BAND)
    depth = np.abs(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"))).max(0)
    solid = (depth < 0.39) & (depth > 0.21)
    assert (winding[solid] == 1).all() and (winding[(depth < 0.19) | (depth > 0.41)] == 0).all()


def test_of_a_large_mesh_only_what_the_domain_holds_is_sampled(tmp_path):
    trimesh.creation.box((50.0, 50.0, 2.0)).export(tmp_path / "ground.stl")
    obstacle = compiled(tmp_path / "ground.stl", position=[0, 0, -0.7], cells=16)  # its top is at 0.3
    assert max(obstacle.values.shape) <= 16 + 2 * MARGIN + 1
    points, phi = samples(obstacle)
    within = ((points >= 0) & (points <= 1)).all(1)
    near = within & (np.abs(points[:, 2] - 0.3) < BAND / 16)
    np.testing.assert_allclose(phi[near], points[near, 2] - 0.3, atol=1e-6)
    assert (phi[within & (points[:, 2] > 0.31)] > 0).all() and (phi[within & (points[:, 2] < 0.29)] < 0).all()


def test_a_moving_mesh_is_sampled_whole_though_it_starts_outside(ball_path):
    moving = compiled(ball_path, scale=0.2, position=[-0.5, 0.5, 0.5], velocity=[1.0, 0.0, 0.0])
    assert float(moving.values.min()) < -0.15
    np.testing.assert_allclose(moving.velocity, [1, 0, 0])


def test_a_real_mesh_with_texture_seams_keeps_its_volume(shared_data):
    triangles = load_solid(shared_data / "spot.obj", "mesh")
    spacing = 1 / 12
    phi, _ = sample(triangles, spacing, -9.0, 9.0, "mesh")
    share = np.clip(0.5 - phi / spacing, 0, 1)  # of a cell that is inside
    np.testing.assert_allclose(share.sum() * spacing**3, 0.718259, rtol=0.02)  # the known volume


def test_an_open_mesh_is_refused(tmp_path):
    box = trimesh.creation.box((1, 1, 1))
    box.update_faces(np.arange(len(box.faces)) > 0)
    box.export(tmp_path / "open.obj")
    with pytest.raises(UserError, match=r"boundaries\[0\].path.*not watertight.*3 edges.*[Cc]lose its holes"):
        compiled(tmp_path / "open.obj")


def test_faces_that_wind_both_ways_are_refused(tmp_path):
    box = trimesh.creation.box((1, 1, 1))
    faces = box.faces.copy()
    faces[0] = faces[0][::-1]
    trimesh.Trimesh(box.vertices, faces, process=False).export(tmp_path / "mixed.obj")
    with pytest.raises(UserError, match=r"boundaries\[0\].path.*wind the same way"):
        compiled(tmp_path / "mixed.obj")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": "missing.obj"}, r"boundaries\[0\].path.*there is no mesh file.*missing.obj"),
        ({"position": [5, 5, 5]}, r"boundaries\[0\]`: no part of the mesh.s surface is in the domain.*spans"),
        ({"scale": 100.0}, r"boundaries\[0\]`: no part of the mesh.s surface is in the domain"),
        ({"scale": 100.0, "velocity": [1, 0, 0]}, r"boundaries\[0\]`: the mesh spans too many grid cells"),
    ],
)
def test_a_mesh_out_of_reach_is_refused(options, message, ball_path):
    with pytest.raises(UserError, match=message):
        compiled(**{"path": ball_path, "base_dir": ball_path.parent, **options})


def test_what_is_no_mesh_is_refused_by_its_field(tmp_path):
    (tmp_path / "text.obj").write_text("hello")
    with pytest.raises(UserError, match=r"`boundaries\[0\].path`"):
        compiled(tmp_path / "text.obj")


def test_a_mesh_is_sampled_once_until_its_file_changes(ball_path, monkeypatch):
    first = compiled(ball_path, scale=0.2, position=[0.5, 0.5, 0.5])
    monkeypatch.setattr("physagent_jax.scene.signed_distance.sample", None)  # would fail if called
    again = compiled(ball_path, scale=0.2, position=[0.5, 0.5, 0.5])
    np.testing.assert_array_equal(first.values, again.values)
    monkeypatch.undo()
    trimesh.creation.box((1, 1, 1)).export(ball_path)
    assert compiled(ball_path, scale=0.2, position=[0.5, 0.5, 0.5]).values.shape != first.values.shape


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scale": 1e9}, "no part|too many"),
        ({"scale": 1e9, "velocity": [1, 0, 0]}, "cells, at most"),
        ({"scale": 1e9, "position": [1e6, 1e6, 1e6]}, "cells from the origin"),
        ({"scale": 1e7, "position": [0.5, 0.5, 1e6]}, "no part|too many"),
        ({"scale": 1e30}, "scale"),
        ({"scale": 1e-300}, "scale"),
    ],
)
def test_absurd_scales_are_refused_before_any_work(options, message, tmp_path):
    """One large triangle through the domain; the pieces that it would be cut into are counted, not made."""
    trimesh.creation.box((2, 2, 2)).export(tmp_path / "box.obj")
    with pytest.raises(UserError, match=message):
        compiled(tmp_path / "box.obj", **options)


def test_a_ground_as_large_as_a_country_costs_what_the_domain_holds(tmp_path):
    trimesh.creation.box((2, 2, 2)).export(tmp_path / "box.obj")
    obstacle = compiled(tmp_path / "box.obj", scale=5e5, position=[0, 0, 0.3 - 5e5], cells=16)
    points, phi = samples(obstacle)
    near = ((points >= 0) & (points <= 1)).all(1) & (np.abs(points[:, 2] - 0.3) < BAND / 16)
    np.testing.assert_allclose(phi[near], points[near, 2] - 0.3, atol=1e-6)


def test_a_mesh_between_the_nodes_is_said_to_do_nothing(ball_path):
    with pytest.warns(UserWarning, match=r"boundaries\[0\].*stops nothing"):
        compiled(ball_path, scale=0.01, position=[0.515, 0.515, 0.515])


def test_many_large_faces_are_counted_before_distances_are_measured(monkeypatch):
    shells = [np.asarray(trimesh.creation.box([9.0 + k] * 3).triangles) for k in range(3)]
    monkeypatch.setattr(kernel, "measure", None)  # would fail if called
    flat = np.concatenate(shells) * [1, 1, 1e-3] + 0.5
    with pytest.raises(UserError, match="`mesh`: the mesh spans too many.*distances, at most"):
        sample(np.repeat(flat, 320, axis=0), 1 / 256, 0.0, 1.0, "mesh")


def test_without_numba_a_mesh_is_refused_in_words(monkeypatch):
    monkeypatch.setattr(
        "physagent_jax.scene.signed_distance.numba_missing", lambda: "No module named 'numba'"
    )
    box = np.asarray(trimesh.creation.box((0.5, 0.5, 0.5)).triangles) + 0.5
    with pytest.raises(UserError, match="`mesh`: a mesh cannot be sampled without Numba"):
        sample(box, 0.1, 0.0, 1.0, "mesh")


def test_a_mesh_of_coordinates_beyond_any_integer_is_refused():
    triangles = np.asarray(trimesh.creation.box((1, 1, 1)).triangles)
    for scale in (1e21, 1e100, 1e300):
        with pytest.raises(UserError, match="too many|no part"):
            sample(triangles * scale, 0.05, 0.0, 1.0, "mesh")
        with pytest.raises(UserError, match="too many|no part"):
            sample(triangles * scale, 0.05, -np.inf, np.inf, "mesh")


@pytest.mark.parametrize("cells", [0.5, 1.0, 2.0, 2.8])
@pytest.mark.parametrize("degrees", [(0.0,), (30.0,)])
def test_thin_walls_of_a_mesh_are_said_with_the_cells_that_hold(cells, degrees, tmp_path):
    """A tube with walls of so many cells; its length and the hole in it are much larger."""
    wall = cells / 32
    trimesh.creation.annulus(r_min=0.3 - wall, r_max=0.3, height=0.5, sections=64).export(
        tmp_path / "tube.obj"
    )
    made = compiled(
        tmp_path / "tube.obj", position=[0.5, 0.5, 0.5], rotation_degrees=degrees, rotation_axes=[0]
    )
    assert made.thickness == pytest.approx(wall, rel=0.02)  # facets of a circle
    model, state = block((3, 3, 3), grid_cells=32, boundaries=(made,))
    (sentence,) = find_limits(model, state, 1.0)
    assert "`boundaries[0]` (SignedDistance) is" in sentence and "cells along the domain's side" in sentence


@pytest.mark.parametrize("degrees", [(0.0, 0.0), (20.0, 50.0)])
@pytest.mark.parametrize("shape", ["box", "ball", "wall"])
def test_thick_meshes_and_their_edges_are_not_thin(shape, degrees, tmp_path):
    meshes = {
        "box": trimesh.creation.box((0.4, 0.4, 0.4)),
        "ball": trimesh.creation.icosphere(subdivisions=3, radius=0.2),
        "wall": trimesh.creation.box((0.6, 0.6, 3.05 / 32)),
    }
    meshes[shape].export(tmp_path / "a.obj")
    made = compiled(tmp_path / "a.obj", position=[0.5] * 3, rotation_degrees=degrees, rotation_axes=[0, 1])
    assert made.thickness is None


def test_a_tray_that_people_reported_as_leaking_is_said(shared_data):
    """Walls of a hundredth: half a cell of 48."""
    made = compiled(shared_data / "reports/in/thin_tray.obj", position=[0.5, 0.5, 0.3], cells=48)
    assert made.thickness == pytest.approx(0.01, rel=1e-3)
    model, state = block((3, 3, 3), grid_cells=48, boundaries=(made,))
    (sentence,) = find_limits(model, state, 1.0)
    assert "0.48 cells thick" in sentence and "take 300 cells" in sentence
