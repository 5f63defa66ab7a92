"""The side of an object that is shown by default."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.run.brief import make_brief
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.broad_side import find_broad_azimuth, find_named_front, measure_extents
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.procedural import PROCEDURAL
from tests.run.specs import small

THIN = np.array([1.0, 0.08, 0.7])


def slab(turn_degrees, count=4000, seed=0):
    """A board of sides `THIN`, its broad face turned away from the front by an angle about +z."""
    points = np.random.default_rng(seed).uniform(-0.5, 0.5, (count, 3)) * THIN
    c, s = np.cos(np.radians(turn_degrees)), np.sin(np.radians(turn_degrees))
    return points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def plain(count):
    return np.full((count, 3), 0.4)


@pytest.mark.parametrize("turn", [0, 30, 45, 75, 90, -30, -60])
def test_a_board_shows_its_face(turn):
    """A camera at azimuth a looks along (-sin a, cos a): at a board turned by a it looks square on."""
    found = find_broad_azimuth(slab(turn), plain(4000))
    assert -90 < found <= 90
    off = (found - turn + 90) % 180 - 90
    assert abs(off) <= 15


@pytest.mark.parametrize("turn", [0, 60, -75])
def test_of_two_broad_sides_the_painted_one_is_the_face(turn):
    """The board's side towards its own -y, which a camera at azimuth ``turn`` sees, or its back."""
    rng = np.random.default_rng(3)
    for painted in (-1, 1):
        board, colours = slab(0), plain(4000).copy()
        face = painted * board[:, 1] > 0
        colours[face] += rng.normal(size=(face.sum(), 1))
        found = find_broad_azimuth(slab(turn), colours)
        expected = turn if painted < 0 else turn + 180
        assert abs((found - expected + 180) % 360 - 180) <= 15 and -180 < found <= 180


@pytest.mark.parametrize("turn", [0, 90, -90, 180])
def test_the_back_is_not_shown_where_the_front_is_known(turn):
    """A backpack has more colours than a face: a figure is seen from its front still, if its file tells that."""
    board, colours = slab(turn), plain(4000).copy()
    angle = np.radians(turn)
    colours[board @ [np.sin(angle), -np.cos(angle), 0] < 0] += np.random.default_rng(3).normal(size=(1, 3))
    colours[::2] += 0.3 * (board[::2] @ [np.sin(angle), -np.cos(angle), 0] < 0)[:, None]
    found = find_broad_azimuth(board, colours, float(turn))
    assert abs((found - turn + 180) % 360 - 180) <= 15 and -180 < found <= 180


@pytest.mark.parametrize("looks", [(0, 1), (1, 0), (-0.6, -0.8)])
def test_parts_called_left_and_right_tell_the_front(looks):
    """The left of what looks along y is at -x."""
    x, y = looks
    faces = np.array([[0, 1, 2]])
    triangle = 0.1 * np.eye(3)
    sides = [
        MeshPart(triangle + sign * np.array([-y, x, 0.3 * sign]), faces, names=(f"arm {side}",))
        for side, sign in (("left", 1), ("right", -1))
    ]
    other = MeshPart(triangle, faces, names=("left",))
    assert np.allclose(find_named_front([*sides, other], np.eye(3)), [x, y, 0])
    assert find_named_front([sides[0], other], np.eye(3)) is None


def test_what_is_about_as_broad_all_around_is_seen_from_the_front():
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(5000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    assert find_broad_azimuth(ball, plain(5000)) == 0
    for make in PROCEDURAL.values():
        cloud = make(0)
        assert find_broad_azimuth(np.asarray(cloud.means), np.asarray(cloud.sh[:, 0])) == 0


def test_floaters_do_not_decide():
    floaters = np.array([[0.0, 5.0, 0.0], [0.0, -6.0, 0.2]])
    assert abs(find_broad_azimuth(np.concatenate([slab(0), floaters]), plain(4002))) <= 15


def test_single_points_have_a_side():
    assert find_broad_azimuth(np.zeros((1, 3)), plain(1)) == 0
    assert find_broad_azimuth(np.array([[0, 0, 0], [0, 1.0, 0]]), plain(2)) in range(-90, 91)


@pytest.fixture
def board(tmp_path):
    cloud = PROCEDURAL["jelly"](0)
    flat = np.asarray(cloud.means) * [0.1, 1.0, 1.0]  # its broad face towards +x
    path = tmp_path / "board.ply"
    write_ply(path, type(cloud)(flat, cloud.quats, cloud.scales, cloud.opacities, cloud.sh))
    return path


def test_a_run_looks_at_the_broad_side_unless_it_is_told(board):
    assert abs(resolve(small(board)).template.camera.azimuth_degrees) >= 75
    told = small(board, camera=dict(azimuth_degrees=10.0))
    assert resolve(told).template.camera.azimuth_degrees == 10
    board.with_name("board.card.json").write_text('{"azimuth_degrees": -20}')
    assert resolve(small(board)).template.camera.azimuth_degrees == -20
    assert resolve(told).template.camera.azimuth_degrees == 10


def test_agents_are_told_along_what_an_object_is_clearly_longest(tmp_path):
    axes = {}
    for name, made in PROCEDURAL.items():
        write_ply(tmp_path / f"{name}.ply", made(0))
        axes[name] = make_brief(resolve(small(tmp_path / f"{name}.ply")).template).long_axis
    assert axes["loaf"] == (1, 0, 0) and axes["jelly"] is None


@pytest.mark.parametrize("turn", [0, 40])
def test_width_height_and_depth_are_as_the_viewer_sees_them(turn):
    """Whichever way the board is turned from the file's axes."""
    a = np.radians(turn)
    ways = [(np.cos(a), np.sin(a), 0.0), (0.0, 0.0, 1.0), (np.sin(a), -np.cos(a), 0.0)]
    longest = np.ptp(slab(turn), axis=0).max()
    sizes = measure_extents(slab(turn), ways)
    assert np.array(sizes) * longest == pytest.approx(THIN[[0, 2, 1]], rel=0.05)


def test_a_file_that_cannot_be_read_is_refused_as_ever(tmp_path):
    path = tmp_path / "broken.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\n")
    with pytest.raises(UserError):
        resolve(small(path))
