"""Clouds that show one side of an object, as lifters of a single photo give them."""

import re

import numpy as np
import pytest

from physagent_jax.scene.config import Domain, Filling, Source
from physagent_jax.scene.filling import fill
from physagent_jax.scene.mesh import gaussians_from_mesh
from physagent_jax.scene.placement import place
from physagent_jax.scene.surfels import make_surfels

COUNT, DX = 8000, 1 / 24
HALF_BALL = 2 / 3 * np.pi * 0.5**3


def make_ball(keep, stretch=(1.0, 1.0, 1.0)):
    """The Gaussians of a ball's surface, of radius 0.5, whose normals ``keep`` chooses."""
    normals = np.random.default_rng(0).normal(size=(COUNT, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals[keep(normals)]
    radius = 0.5 * 0.7 * np.sqrt(4 * np.pi / COUNT)
    return make_surfels(0.5 * normals * stretch, normals, radius, np.full(normals.shape, 0.5))


def fill_all(cloud):
    return fill(cloud, Filling(max_particles=100_000), dx=DX)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1, 1])
def test_half_a_ball_is_filled_behind(axis, sign):
    side = re.escape("+-"[sign < 0] + "xy"[axis])
    with pytest.warns(UserWarning, match=f"one side of the object, towards {side}"):
        particles = fill_all(make_ball(lambda n: sign * n[:, axis] > 0))
    assert particles.volume.sum() == pytest.approx(HALF_BALL, rel=0.15)
    assert (sign * particles.x[:, axis]).min() > -DX, "nothing is made up beyond the rim"


def test_what_is_seen_of_a_ball_from_near_is_filled_behind():
    with pytest.warns(UserWarning, match="one side"):
        particles = fill_all(make_ball(lambda n: n[:, 1] < -0.3))  # a lens sees less than half
    cap = np.pi * 0.35**2 * (3 * 0.5 - 0.35) / 3  # of a ball, 0.35 high
    assert particles.volume.sum() == pytest.approx(cap, rel=0.2)


@pytest.mark.parametrize(
    "keep",
    [lambda n: n[:, 2] < 0, lambda n: n[:, 2] > 0, lambda n: n[:, 2] > -2],
    ids=["bowl", "dome", "ball"],
)
def test_bowls_domes_and_whole_objects_are_left_as_they_are(keep, recwarn):
    fill_all(make_ball(keep))
    assert not recwarn.list


def test_a_flag_and_a_bent_leaf_stay_thin(recwarn):
    across, up = np.random.default_rng(0).uniform(-0.5, 0.5, (2, COUNT))
    for away in (0.05 * np.sin(12 * across), across**2):
        points = np.column_stack([across, away, up])
        normals = np.tile([0.0, -1.0, 0.0], (COUNT, 1))
        particles = fill_all(make_surfels(points, normals, 0.01, np.full((COUNT, 3), 0.5)))
        assert particles.volume.sum() < 3 * DX * np.ptp(across) * np.ptp(up)
    assert not recwarn.list


def test_what_is_thin_on_the_grid_is_not_judged(recwarn):
    fill(make_ball(lambda n: n[:, 1] < 0), Filling(cells=10), dx=DX)
    assert not recwarn.list


def test_whole_meshes_are_not_taken_for_one_sided_ones(recwarn, shared_data):
    domain = Domain(size=2.0, cells=64)
    for name, up in (("spot.obj", "+y"), ("bunny.obj", "+y")):
        source = Source(path=name, up=up)
        cloud, _ = place(gaussians_from_mesh(shared_data / name, count=5000), source, domain)
        fill(cloud, Filling(), dx=domain.dx)
    assert not recwarn.list
