"""Sampled distances and signs of closed meshes against closed forms and other implementations."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from physagent_jax.scene.kernels import triangles as kernel
from physagent_jax.scene.signed_distance import BAND, sample

CELLS = 16
TURN = Rotation.from_euler("xyz", (25.0, 40.0, 10.0), degrees=True).as_matrix()


def shell(outer, inner):
    """A solid with a hollow."""
    return np.concatenate([outer.triangles, inner.triangles[:, ::-1]])


def scattered_balls():
    rng = np.random.default_rng(3)
    balls = [trimesh.creation.icosphere(subdivisions=1, radius=r) for r in rng.uniform(0.02, 0.06, 8)]
    places = (np.stack(np.indices((2, 2, 2)), -1).reshape(-1, 1, 1, 3) - 0.5) * 0.3
    return np.concatenate([ball.triangles + place for ball, place in zip(balls, places)])


def needles():
    """A cylinder of 300 slivers, whose ends are fans about one vertex, on a line of nodes unless it is turned."""
    return np.asarray(trimesh.creation.cylinder(radius=0.25, height=0.5, sections=300).triangles)


def on_nodes():
    """A box whose vertices, edges and faces all lie on nodes and lines of nodes."""
    return np.asarray(trimesh.creation.box((0.5, 0.75, 0.5)).subdivide_to_size(1.01 / CELLS * 2).triangles)


SOLIDS = {
    "torus": lambda: np.asarray(trimesh.creation.torus(0.3, 0.1, 24, 16).triangles),
    "many balls": scattered_balls,
    "wall of a hundredth of a cell": lambda: np.asarray(
        trimesh.creation.box((0.7, 0.5, 0.01 / CELLS)).triangles
    ),
    "thin shell": lambda: shell(trimesh.creation.box((0.755,) * 3), trimesh.creation.box((0.745,) * 3)),
    "needles": needles,
    "on nodes": on_nodes,
    "fine": lambda: np.asarray(trimesh.creation.icosphere(subdivisions=3, radius=0.07).triangles),
}


def find_nodes(phi, first):
    return first + np.indices(phi.shape).reshape(3, -1).T / CELLS


def measure_with_trimesh(triangles, points):
    """Distances to the nearest of all triangles, by another implementation, for each point."""
    best = np.full(len(points), np.inf)
    for triangle in triangles:
        closest = trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        best = np.minimum(best, np.linalg.norm(closest - points, axis=1))
    return best


def wind(triangles, points):
    """Winding numbers as sums of solid angles (Van Oosterom and Strackee 1983), for each point."""
    total = np.zeros(len(points))
    for triangle in triangles:
        a, b, c = (corner - points for corner in triangle)
        la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        total += 2 * np.arctan2((a * np.cross(b, c)).sum(1), below)
    return total / (4 * np.pi)


@pytest.mark.filterwarnings("ignore:.*stops nothing")
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("name", SOLIDS)
def test_distances_are_exact_in_the_band_and_signs_everywhere(name, turned):
    triangles = SOLIDS[name]() @ (TURN if turned else np.eye(3)) + 0.5
    phi, first = sample(triangles, 1 / CELLS, 0.0, 1.0, "mesh")
    points, phi = find_nodes(phi, first), phi.ravel()
    rng = np.random.default_rng(0)
    some = np.flatnonzero(np.abs(phi) < BAND / CELLS)
    some = rng.choice(some, min(len(some), 400), replace=False)
    exact = measure_with_trimesh(triangles, points[some])
    within = exact < (BAND - 1e-6) / CELLS
    assert within.sum() > 50
    np.testing.assert_allclose(np.abs(phi[some])[within], exact[within], atol=1e-11)  # trimesh, on slivers
    some = rng.choice(len(phi), 500, replace=False)
    some = some[np.abs(phi[some]) > 1e-9]
    np.testing.assert_array_equal(phi[some] < 0, wind(triangles, points[some]) > 0.5)


@pytest.mark.parametrize("turned", [False, True])
def test_a_torus_has_the_distance_of_its_closed_form(turned):
    """The facets of a torus lie inside it by the sagitta of their angle."""
    sections = 96
    triangles = np.asarray(trimesh.creation.torus(0.3, 0.12, sections, sections).triangles)
    rotation = TURN if turned else np.eye(3)
    phi, first = sample(triangles @ rotation + 0.5, 1 / CELLS, 0.0, 1.0, "mesh")
    x, y, z = ((find_nodes(phi, first) - 0.5) @ rotation.T).T
    exact = np.hypot(np.hypot(x, y) - 0.3, z) - 0.12
    near = np.abs(exact) < (BAND - 0.1) / CELLS
    sagitta = (0.42 + 0.12) * (1 - np.cos(np.pi / sections))
    np.testing.assert_allclose(phi.ravel()[near], exact[near], atol=1.5 * sagitta)


@pytest.mark.parametrize("shift", [0.0, 1e-9, -1e-9])
def test_a_box_of_many_faces_on_the_grids_planes_keeps_its_corners(shift):
    """Lines of nodes pass through vertices and along edges, and nodes lie on faces, or a little beside them."""
    triangles = on_nodes() + 0.5 + shift
    phi, first = sample(triangles, 1 / CELLS, 0.0, 1.0, "mesh")
    beyond = np.abs(find_nodes(phi, first) - 0.5 - shift) - [0.25, 0.375, 0.25]
    exact = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(1), 0)
    near = np.abs(exact) < (BAND - 1e-6) / CELLS
    np.testing.assert_allclose(phi.ravel()[near], exact[near], atol=1e-14)


def test_random_polyhedra_with_vertices_on_nodes_have_no_leaking_lines():
    """Cones from one vertex over a random polygon, all corners on nodes: one wrong sign of an edge fills a line."""
    rng = np.random.default_rng(1)
    for _ in range(40):
        corners = rng.integers(2, 11, (12, 3)).astype(float)
        hull = trimesh.convex.convex_hull(corners)
        planes = np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])
        _, winding, _ = kernel.measure(np.asarray(hull.triangles), (13, 13, 13), BAND)
        nodes = np.indices((13, 13, 13)).reshape(3, -1).T
        depth = (nodes @ hull.face_normals.T - planes).max(1)
        clear = np.abs(depth) > 1e-9
        np.testing.assert_array_equal(winding.ravel()[clear], (depth < 0)[clear])


def test_far_distances_are_right_to_a_tenth_of_a_cell():
    ball = 20 * np.asarray(trimesh.creation.icosphere(subdivisions=5).triangles) + 24
    distance, winding, _ = kernel.measure(ball, (49, 49, 49), BAND)
    exact = np.linalg.norm(np.indices(distance.shape) - 24, axis=0) - 20
    assert np.abs(np.where(winding != 0, -distance, distance) - exact).max() < 0.1


@pytest.mark.parametrize("name", ["torus", "thin shell"])
def test_libigl_measures_the_same(name):
    igl = pytest.importorskip("igl", reason="libigl is not a dependency: `pip install libigl` to compare")
    triangles = SOLIDS[name]() @ TURN + 0.5
    phi, first = sample(triangles, 1 / CELLS, 0.0, 1.0, "mesh")
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    kind = igl.SIGNED_DISTANCE_TYPE_WINDING_NUMBER  # the fast one is approximate
    theirs, *_ = igl.signed_distance(find_nodes(phi, first), mesh.vertices, mesh.faces.astype(np.int64), kind)
    near = np.abs(theirs) < (BAND - 1e-6) / CELLS
    np.testing.assert_allclose(phi.ravel()[near], theirs[near], atol=1e-9)
