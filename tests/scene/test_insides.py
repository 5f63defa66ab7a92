"""A skin around nothing shows its own colour where it is torn open, and nothing changes where it is whole."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians.binding import bind, deform
from physagent_jax.render import look_at, render
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Filling
from physagent_jax.scene.filling import fill
from physagent_jax.scene.insides import add_inside, comes_apart
from physagent_jax.scene.pieces import join_pieces
from physagent_jax.scene.surfels import SH_DC
from tests.scene.clouds import box_shell, sphere_shell

DX = 1 / 16
COLOUR = np.array([0.9, 0.3, 0.2])


def body_of(cloud) -> Body:
    cloud = dataclasses.replace(
        cloud, sh=jnp.broadcast_to(jnp.float32((COLOUR - 0.5) / SH_DC), cloud.sh.shape)
    )
    particles = fill(cloud, Filling(max_particles=6000), dx=DX)
    return Body(cloud, None, particles, bind(cloud.means, particles.x))  # type: ignore[arg-type]


@pytest.fixture(scope="module", params=["ball", "box"])
def body(request):
    shell = {"ball": lambda: sphere_shell(0.5, 6000), "box": lambda: box_shell((1, 0.8, 0.7), 8000)}
    return body_of(shell[request.param]())


def seen(cloud, binding, x):
    """The picture from +x, from where the half at +x has been taken away or not."""
    eye = np.array([3.0, 0.3, 0.2])
    camera = look_at(eye, np.zeros(3), (0, 0, 1), fov_degrees=50, width=96, height=96)
    F = np.broadcast_to(np.eye(3, dtype=np.float32), (len(x), 3, 3))
    image = render(
        deform(cloud, binding, jnp.asarray(x), jnp.asarray(F), np.eye(3)), camera, background=(0, 0, 0)
    )
    return np.asarray(image.rgb), np.asarray(image.depth)


def test_a_whole_skin_looks_as_before(body):
    x = body.particles.x
    plain, _ = seen(body.cloud, body.binding, x)
    filled, _ = seen(*add_inside(body.cloud, body), x)
    assert np.abs(filled - plain).mean() < 0.5 / 255
    assert np.abs(filled - plain).max() < 0.05


def test_a_torn_skin_is_solid_and_of_its_own_colour(body):
    x = body.particles.x.copy()
    x[x[:, 0] > 0] += np.float32([0, 0, 50])
    _, hollow = seen(body.cloud, body.binding, x)
    rgb, solid = seen(*add_inside(body.cloud, body), x)
    middle = np.s_[38:58, 38:58]
    assert np.median(hollow[middle]) > 3.3, "one sees the far wall"
    assert np.abs(solid[middle] - 3.0).max() < 0.2, "one sees the cut"
    np.testing.assert_allclose(rgb[middle], np.broadcast_to(COLOUR, (20, 20, 3)), atol=0.06)


def test_only_what_comes_apart_does():
    rng = np.random.default_rng(0)
    rest = rng.uniform(-0.5, 0.5, (6000, 3))
    turned = rest @ Rotation.from_rotvec([0.3, 1.2, -2]).as_matrix().T + [4, 0, 0]
    stretched = rest * [1.4, 0.9, 0.9]
    torn = np.where(rest[:, :1] > 0, rest + [0.5, 0, 0], rest)
    drawn_out = rest * [2, 0.7, 0.7]
    crumb = rest.copy()
    crumb[0] += 3
    for name, frame, apart in (
        ("turned", turned, False),
        ("stretched", stretched, False),
        ("a crumb", crumb, False),
        ("torn", torn, True),
        ("drawn out", drawn_out, True),
    ):
        assert comes_apart(np.stack([rest, rest, frame])) is apart, name
    assert not comes_apart(rest[None]) and not comes_apart(np.stack([rest[:3], 9 * rest[:3]]))


def test_joints_between_pieces_are_never_shown():
    one = box_shell((0.5, 0.5, 0.5), 3000)
    two = dataclasses.replace(
        one,
        means=jnp.concatenate([one.means, one.means + jnp.float32([0.62, 0, 0])]),
        **{
            name: jnp.concatenate([getattr(one, name)] * 2) for name in ("quats", "scales", "opacities", "sh")
        },
    )
    particles = fill(two, Filling(max_particles=6000), dx=DX)
    joined, _ = join_pieces(particles, DX)
    assert joined.count > particles.count
    assert not joined.enclosed[particles.count :].any()
    assert np.abs(np.abs(joined.x[joined.enclosed] - [0.31, 0, 0]) - [0.31, 0, 0])[:, 0].max() < 0.25
