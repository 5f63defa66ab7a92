import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial import cKDTree

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.covariance import quat_to_matrix
from physagent_jax.scene import surfels
from physagent_jax.scene.mesh import GRAIN, TONE, gaussians_from_mesh, sample_mesh
from physagent_jax.scene.surfels import SH_DC, bake_light, place_evenly, value_noise


def colours(cloud):
    return np.asarray(cloud.sh)[:, 0] * SH_DC + 0.5


def normals(cloud):
    return np.asarray(quat_to_matrix(cloud.quats))[:, :, 2]


@pytest.fixture
def box_path(tmp_path):
    path = tmp_path / "box.obj"
    trimesh.creation.box(extents=(2, 1, 0.5)).export(path)
    return path


def test_discs_lie_on_the_surface_and_face_outwards(box_path):
    cloud = gaussians_from_mesh(box_path, count=3000)
    x = np.asarray(cloud.means)
    half = np.array([1, 0.5, 0.25])
    face = np.argmin(np.abs(half - np.abs(x)), axis=1)
    row = np.arange(len(x))
    np.testing.assert_allclose(np.abs(x)[row, face], half[face], atol=1e-6)
    expected = np.zeros_like(x)
    expected[row, face] = np.sign(x[row, face])
    on_an_edge = (np.sort(half - np.abs(x), axis=1)[:, 1]) < 1e-4
    np.testing.assert_allclose(normals(cloud)[~on_an_edge], expected[~on_an_edge], atol=1e-5)
    assert (np.argmin(np.asarray(cloud.scales), axis=1) == 2).all()  # thin along the normal


def test_the_count_is_met_and_faces_share_by_area(box_path):
    cloud = gaussians_from_mesh(box_path, count=3500)
    assert cloud.count == 3500
    top = (np.abs(np.asarray(cloud.means)[:, 2]) > 0.25 - 1e-6).mean()
    assert top == pytest.approx(2 * (2 * 1) / (2 * (2 + 1 + 0.5)), abs=0.03)


def test_samples_are_more_even_than_random_ones(box_path):
    cloud = gaussians_from_mesh(box_path, count=3000)
    nearest = cKDTree(cloud.means).query(cloud.means, k=2)[0][:, 1]
    # Uniformly random points in the plane: the nearest distance varies by sqrt(4 / pi - 1) = 0.52 of its mean.
    assert nearest.std() / nearest.mean() < 0.26


def test_discs_cover_the_surface(box_path):
    cloud = gaussians_from_mesh(box_path, count=3000)
    surface = trimesh.sample.sample_surface(trimesh.load(box_path, force="mesh"), 3000, seed=5)[0]
    distance = cKDTree(cloud.means).query(surface)[0]
    assert (distance < 2 * np.asarray(cloud.scales)[0, 0]).all()


def test_same_seed_same_cloud_other_seed_another(box_path):
    first, again, other = (gaussians_from_mesh(box_path, count=200, seed=s) for s in (3, 3, 4))
    np.testing.assert_array_equal(first.means, again.means)
    np.testing.assert_array_equal(first.sh, again.sh)
    assert (np.asarray(first.means) != other.means).any()


def test_vertex_colours_are_kept(tmp_path):
    mesh = trimesh.creation.box()
    mesh.visual.vertex_colors = np.where(mesh.vertices[:, :1] > 0, [[255, 0, 0, 255]], [[0, 0, 255, 255]])
    mesh.export(tmp_path / "box.ply")
    cloud = gaussians_from_mesh(tmp_path / "box.ply", count=500)
    rgb, x = colours(cloud), np.asarray(cloud.means)[:, 0]
    assert rgb[:, 1].max() < 1e-5
    right, left = rgb[x > 0.49], rgb[x < -0.49]
    assert (right[:, 0] > 3 * right[:, 2]).all() and (left[:, 2] > 3 * left[:, 0]).all()


def test_a_texture_is_read_where_its_coordinates_say(tmp_path):
    (tmp_path / "quad.obj").write_text(
        "mtllib quad.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    (tmp_path / "quad.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:4, :, 0], pixels[4:, :, 1] = 255, 255  # red above, green below
    Image.fromarray(pixels).save(tmp_path / "skin.png")
    cloud = gaussians_from_mesh(tmp_path / "quad.obj", count=400)
    rgb, y = colours(cloud), np.asarray(cloud.means)[:, 1]
    np.testing.assert_array_equal(rgb[:, 0] > 0.3, y > 0.5)
    np.testing.assert_array_equal(rgb[:, 1] > 0.3, y < 0.5)


def test_a_bare_mesh_has_one_quiet_tone_and_no_pattern(box_path):
    """One colour under the light of each face, but for a grain that is fainter than any pattern."""
    cloud = gaussians_from_mesh(box_path, count=3000, smooth=False)
    unlit = colours(cloud) / bake_light(normals(cloud))[:, None]
    assert np.abs(unlit / np.asarray(TONE) - 1).max() < GRAIN + 1e-3
    assert 0 < (unlit / np.asarray(TONE)).std() < 0.03


def test_light_comes_from_the_files_up(tmp_path):
    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.stl")
    for up, axis in (("+z", (0, 0, 1)), ("+y", (0, 1, 0)), ("-y", (0, -1, 0))):
        cloud = gaussians_from_mesh(tmp_path / "ball.stl", count=1000, up=up)
        height = np.asarray(cloud.means) @ axis
        brightness = colours(cloud).mean(axis=1)
        assert brightness[height > 0.5].mean() > 1.3 * brightness[height < -0.5].mean()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gone.obj", None, "cannot read"),
        ("empty.obj", "", "faces|cannot read"),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "faces|cannot read"),
        ("junk.stl", "this is no mesh", "cannot read|faces"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "area|faces"),
    ],
)
def test_what_is_no_mesh_is_refused(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(UserError, match=message):
        gaussians_from_mesh(tmp_path / name, count=100)


def test_even_points_terminates_on_duplicates():
    assert len(place_evenly(np.zeros((50, 3)), 7)) == 7


def test_points_are_thinned_once_and_nobody_changes_what_is_remembered(monkeypatch):
    points = np.random.default_rng(7).uniform(size=(300, 3))
    first = place_evenly(points, 100)
    others = [place_evenly(points, 99), place_evenly(points[::-1], 100)]
    assert [len(each) for each in others] == [99, 100] and (first != others[1]).any()
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1
    monkeypatch.setattr(surfels, "KDTree", None)
    np.testing.assert_array_equal(place_evenly(points.copy(), 100), first)


def test_noise_is_seeded_bounded_and_smooth():
    points = np.random.default_rng(0).uniform(0, 1, (2000, 3))
    noise = value_noise(points, 4.0, seed=1)
    assert noise.min() >= 0 and noise.max() <= 1 and 0.1 < noise.std() < 0.4
    np.testing.assert_array_equal(noise, value_noise(points, 4.0, seed=1))
    assert np.abs(noise - value_noise(points, 4.0, seed=2)).mean() > 0.1
    assert np.abs(noise - value_noise(points + 1e-4, 4.0, seed=1)).max() < 0.01


def test_baked_light_is_brightest_towards_the_key_light():
    directions = np.random.default_rng(0).normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    brightest = directions[np.argmax(bake_light(directions))]
    assert brightest[2] > 0.5 and brightest[1] < 0 and brightest[0] < 0  # above, in front, left


def test_a_mesh_without_colours_is_plain_for_people_and_grained_for_perception(box_path):
    grained, plain = sample_mesh(box_path, count=2000, smooth=False)
    np.testing.assert_array_equal(grained.means, plain.means)
    shades = np.unique(np.round(np.asarray(plain.sh[:, 0, 0], np.float64), 4))
    assert len(shades) <= 6, "one shade per side of the box"
    assert len(np.unique(np.round(np.asarray(grained.sh[:, 0, 0], np.float64), 4))) > 100


def test_a_mesh_in_plain_paint_is_grained_for_perception_too(tmp_path):
    """Paint of few colours gives optical flow no more to follow than none."""
    box = trimesh.creation.box((1, 1, 1))
    box.visual.face_colors = [200, 40, 40, 255]
    box.export(tmp_path / "red.ply")
    grained, plain = sample_mesh(tmp_path / "red.ply", count=2000, smooth=False)
    shades = [
        len(np.unique(np.round(np.asarray(each.sh[:, 0, 0], np.float64), 4))) for each in (plain, grained)
    ]
    assert shades[0] <= 6 and shades[1] > 100
