"""The up axis that a shape tells, against captures and models whose up axis is known."""

import itertools

import numpy as np
import pytest
import trimesh
from trimesh import creation
from trimesh.transformations import rotation_matrix

from physagent_jax.scene.config import Source
from physagent_jax.scene.load import load_object
from physagent_jax.scene.procedural import PROCEDURAL
from physagent_jax.scene.up_axis import AXES, find_mirrored, find_opposite, guess_up, measure_sides

CAPTURES = {
    "playbot_31k_sh2.ply": "-y", "playbot_8k_sh3_inria_layout.ply": "-y", "guitar_sh0.ply": "-y",
    "spot.obj": "+y", "bunny.obj": "+y",
    "playbot_robot_sh2.ply": None, "pc_short_100_sh3_inria.ply": None,
}  # fmt: skip
"""Up axes as the files' sources state them; None = the object floats, or is a part of a scene."""


def read_points(path):
    return np.asarray(load_object(Source(path=str(path)), ".").cloud.means)


def sample(*meshes):
    return np.asarray(trimesh.sample.sample_surface(trimesh.util.concatenate(list(meshes)), 6000, seed=0)[0])


def moved(mesh, *offset):
    return mesh.apply_translation(offset)


def make_legs(x, y, height, width=0.05):
    return [
        moved(creation.box([width, width, height]), i * x, j * y, height / 2)
        for i in (-1, 1)
        for j in (-1, 1)
    ]


def make_mug():
    handle = creation.torus(0.2, 0.04).apply_transform(rotation_matrix(np.pi / 2, [1, 0, 0]))
    return sample(creation.annulus(0.3, 0.33, 0.8), moved(creation.cylinder(0.33, 0.03), 0, 0, -0.4),
                  moved(handle, 0.45, 0, 0))  # fmt: skip


@pytest.mark.parametrize(("name", "up"), CAPTURES.items())
def test_real_files(name, up, shared_data):
    assert guess_up(read_points(shared_data / name)).axis == up


@pytest.mark.parametrize("name", PROCEDURAL)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_objects_made_by_code(name, seed):
    assert guess_up(np.asarray(PROCEDURAL[name](seed).means)).axis == "+z"


@pytest.mark.parametrize(
    ("shape", "up"),
    [
        (sample(creation.cone(0.3, 1.0)), "+z"),
        (sample(creation.cylinder(0.2, 0.04), moved(creation.cylinder(0.02, 1), 0, 0, 0.5),
                moved(creation.cone(0.25, 0.3), 0, 0, 1)), "+z"),
    ],
    ids=["cone", "lamp"],
)  # fmt: skip
def test_models_with_a_foot(shape, up):
    assert guess_up(shape).axis == up


@pytest.mark.parametrize(
    "shape",
    [
        sample(creation.icosphere()),
        sample(creation.box([1, 1, 1])),
        sample(creation.box([1, 0.7, 0.15])),
        sample(creation.cylinder(0.3, 1.0)),
        sample(moved(creation.box([1, 0.6, 0.05]), 0, 0, 0.7), *make_legs(0.45, 0.25, 0.7)),
        sample(moved(creation.box([0.45, 0.45, 0.05]), 0, 0, 0.45), *make_legs(0.2, 0.2, 0.45),
               moved(creation.box([0.45, 0.05, 0.5]), 0, -0.2, 0.7)),
        make_mug(),
    ],
    ids=["ball", "cube", "book", "can", "table", "chair", "mug"],
)  # fmt: skip
def test_shapes_that_do_not_tell(shape):
    """They stand as well on other sides, or on none: no guess is better than a wrong one."""
    guess = guess_up(shape)
    assert guess.axis is None and "does not tell" in guess.reason


def test_the_guess_turns_with_the_object(robot_path):
    """All 24 right-angled turns and all mirror images: nothing is known of axes but from the shape."""
    loaf = np.asarray(PROCEDURAL["loaf"](0).means, np.float64)
    turns = itertools.product(itertools.permutations(range(3)), itertools.product((-1, 1), repeat=3))
    for order, signs in turns:
        turned = loaf[:, order] * signs
        column = order.index(2)
        assert guess_up(turned).axis == "-+"[signs[column] > 0] + "xyz"[column]


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e6])
def test_units_and_place_do_not_matter(scale):
    plant = np.asarray(PROCEDURAL["plant"](0).means, np.float64)
    assert guess_up(scale * (plant + [3, -2, 7])).axis == "+z"


def test_a_few_floaters_do_not_matter():
    jelly = np.asarray(PROCEDURAL["jelly"](0).means, np.float64)
    assert guess_up(np.concatenate([jelly, [[0, 0, -9.0], [5, 0, 0], [0, 8, 3]]])).axis == "+z"


def test_the_side_of_a_cube():
    """A cube tips over at 45 degrees and is raised by (sqrt(2) - 1) / 2 of its side."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 41)] * 3, indexing="ij"), -1).reshape(-1, 3)
    shell = grid[((grid == 0) | (grid == 1)).any(axis=1)]
    for side in measure_sides(shell):
        assert side.angle == pytest.approx(45, abs=1)
        assert side.work == pytest.approx((np.sqrt(2) - 1) / 2, rel=0.05)  # points are counted in cells
        assert (side.flatness, side.share) == pytest.approx((1, 1))


@pytest.mark.parametrize(
    "points", [np.zeros((500, 3)), np.zeros((5, 3)), np.linspace(0, 1, 500)[:, None] * [1, 0, 0],
               np.random.default_rng(0).random((500, 3)) * [1, 1, 0]],
    ids=["one place", "few", "a line", "a plane"],
)  # fmt: skip
def test_points_without_a_volume(points):
    assert guess_up(points).axis in (None, "+z", "-z")


def test_opposites():
    for axis in AXES:
        assert find_opposite(axis)[1] == axis[1] and find_opposite(find_opposite(axis)) == axis
        assert find_opposite(axis) != axis


def test_left_and_right_are_told_by_the_mirror():
    """Wings on either side of a body: it is its own image across the axis that they lie along, and that alone."""
    boxes = [((1.0, 0.1, 0.1), 0.0), ((0.2, 1.0, 0.04), 0.2), ((0.12, 0.3, 0.04), -0.45)]
    parts = [trimesh.creation.box(size) for size, _ in boxes]
    for part, (_, place) in zip(parts, boxes):
        part.apply_translation((place, 0, 0))
    fin = trimesh.creation.box((0.12, 0.02, 0.3))
    fin.apply_translation((-0.45, 0, 0.15))
    plane = trimesh.util.concatenate([*parts, fin])
    points = np.asarray(trimesh.sample.sample_surface(plane, 20_000, seed=0)[0])
    assert find_mirrored(points) == 1
    assert find_mirrored(points[:, [1, 2, 0]]) == 0
    assert find_mirrored(points[:, [0, 2, 1]] * 7 + 3) == 2
    box = np.asarray(trimesh.sample.sample_surface(trimesh.creation.box((1, 0.5, 0.3)), 20_000, seed=0)[0])
    assert find_mirrored(box) is None
