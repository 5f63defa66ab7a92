"""Scenes bind to particles as their JSON says: materials, boundaries, constraints, anchors, gravity."""

import warnings

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.mpm import FixedCorotated, Lumped, NeoHookean, Sharpened, rollout, simulate, stable_dt
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.camera import find_viewer_directions, frame_camera, make_reference_camera
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.presets import PRESETS, PresetName
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.simulation.simulate import simulate_frames


@pytest.fixture(scope="module")
def source(robot_path):
    return c.Source(path=str(robot_path), name="robot", kind="robot", up="-y")


@pytest.fixture(scope="module")
def body(source):
    return make_body(source, c.Filling(max_particles=1500), c.Domain(size=4.0, cells=48), ".")


def scene(source, body, **parts):
    defaults = dict(source=source, domain=c.Domain(size=4.0, cells=48), filling=c.Filling(max_particles=1500))
    return compile_scene(c.SceneConfig(**{**defaults, **parts}), body)


def test_lame_parameters_and_mass(source, body):
    made = scene(source, body, material=c.Material(youngs_modulus=1e5, poissons_ratio=0.25, density=300.0))
    solid = made.model.materials[0]
    np.testing.assert_allclose(solid.mu, 4e4, rtol=1e-6)
    np.testing.assert_allclose(solid.lam, 4e4, rtol=1e-6)
    np.testing.assert_allclose(made.model.mass, 300 * made.model.volume, rtol=1e-6)


def test_two_materials_share_a_scene(source, body):
    """The upper half is another solid; particles are grouped by model, and the grouping is undone."""
    stiff = c.Material(model=c.MaterialModel.FIXED_COROTATED, youngs_modulus=3e5, density=50.0)
    upper = c.MaterialRegion(point=(2, 2, 2.5), half_size=(1, 1, 0.5), material=stiff)
    made = scene(source, body, material_regions=(upper,))
    soft, hard = made.model.materials
    assert isinstance(soft, NeoHookean) and isinstance(hard, FixedCorotated)
    x = np.asarray(made.state.x)
    assert (x[: soft.count, 2] < 2).all() and (x[soft.count :, 2] >= 2).all()
    np.testing.assert_allclose(x, body.particles.x[made.order], atol=1e-6)
    density = np.asarray(made.model.mass / made.model.volume)
    np.testing.assert_allclose(density, np.where(x[:, 2] >= 2, 50.0, 200.0), rtol=1e-5)
    frames = list(simulate(made.model, made.state, frame_count=2, frame_dt=0.02))
    np.testing.assert_allclose(frames[-1].state.x, x, atol=1e-5)


def places(made, constraint):
    """The particles of a constraint, without what fills up its list."""
    listed = np.asarray(constraint.particles)
    return listed[listed < len(made.order)]


def test_gravity_only_acts_when_asked(source, body):
    assert scene(source, body).model.gravity is None
    assert scene(source, body, force_field=ForceField(default_drop=True)).model.gravity is not None
    assert scene(source, body, always_gravity=True).model.gravity is not None


def test_an_anchored_base_stays_and_the_rest_is_pushed(source, body):
    push = ForceField.model_validate(
        {"actions": [{"action_type": "translation", "vector": [1, 0, 0], "magnitude": 1.6}]}
    )
    made = scene(source, body, anchor=c.Anchor(kind="base", fraction=0.3), force_field=push)
    anchor_places = places(made, made.model.constraints[0])
    assert made.anchored == len(set(made.order[anchor_places])) > 0
    start = np.asarray(made.state.x)
    assert start[anchor_places, 2].max() <= start[:, 2].min() + 0.3 * np.ptp(start[:, 2]) + 1e-5
    end = np.asarray(list(simulate(made.model, made.state, frame_count=4, frame_dt=0.04))[-1].state.x)
    np.testing.assert_array_equal(end[anchor_places], start[anchor_places])
    assert (end - start)[:, 0].max() > 1e-3


def test_impulses_by_velocity_and_by_force(source, body):
    """A force per particle gives dv = F t / m, a velocity change is what it says."""
    everywhere = dict(point=(2, 2, 2), half_size=(2, 2, 2), duration=0.01)
    by_velocity = c.ParticleImpulse(delta_velocity=(0.5, 0, 0), **everywhere)
    by_force = c.ParticleImpulse(force=(0, 2e-4, 0), **everywhere)
    made = scene(source, body, constraints=(by_velocity, by_force), boundaries=())
    end = list(simulate(made.model, made.state, frame_count=2, frame_dt=0.02))[-1].state
    momentum = np.asarray((made.model.mass[:, None] * end.v).sum(0))
    mass = float(made.model.mass.sum())
    np.testing.assert_allclose(momentum[0] / mass, 0.5, rtol=1e-4)
    np.testing.assert_allclose(momentum[1], 2e-4 * 0.01 * body.particles.count, rtol=1e-4)


def test_prescribed_motions_and_boundaries_of_a_scene(source, body):
    parts = dict(
        constraints=(
            c.ParticleTranslation(point=(2, 2, 2.4), half_size=(1, 1, 0.1), velocity=(0.1, 0, 0), end=0.04),
            c.ParticleRotation(
                point=(2, 2, 1.6), normal=(0, 0, 1), half_height=0.1, radius=0.3, angular_velocity=2.0
            ),
        ),
        boundaries=(
            c.DomainBox(),
            c.HalfSpace(point=(0, 0, 1.0), normal=(0, 0, 2), surface=c.Surface.STICKY),
            c.Cuboid(point=(2, 2, 3), half_size=(0.1, 0.1, 0.1), velocity=(0, 0, 0)),
        ),
    )
    made = scene(source, body, **parts)
    top = places(made, made.model.constraints[0])
    end = list(simulate(made.model, made.state, frame_count=2, frame_dt=0.04))[-1].state
    np.testing.assert_allclose(
        end.x[top] - made.state.x[top], np.broadcast_to([0.004, 0, 0], (len(top), 3)), atol=1e-6
    )


def test_what_the_method_does_badly_is_said_when_a_scene_is_compiled_and_only_then(source, body):
    thin = c.Box(point=(2, 2, 1), half_size=(1, 1, 0.05))  # 1.2 of 48 cells over 4 m
    with pytest.warns(UserWarning, match=r"`boundaries\[1\]` \(Box\) is 1.2 cells thick.*take 120 cells"):
        made = scene(source, body, boundaries=(c.DomainBox(), thin))
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        next(simulate_frames(made))


@pytest.mark.parametrize(
    "parts",
    [
        dict(
            constraints=(
                c.ParticleTranslation(point=(0.5, 0.5, 0.5), half_size=(0.1, 0.1, 0.1), velocity=(1, 0, 0)),
            )
        ),
        dict(
            material_regions=(
                c.MaterialRegion(point=(0.5, 0.5, 0.5), half_size=(0.1, 0.1, 0.1), material=c.Material()),
            )
        ),
    ],
)
def test_boxes_that_miss_the_object_are_refused_with_its_place(source, body, parts):
    with pytest.raises(UserError, match=r"selects no particle; the object spans \[1\.[0-9]+"):
        scene(source, body, **parts)


# --- the reference camera ----------------------------------------------------------------------------


@pytest.mark.parametrize("azimuth", [0.0, 35.0, -120.0])
@pytest.mark.parametrize("elevation", [-20.0, 10.0])
def test_the_viewers_words_point_where_the_picture_says(azimuth, elevation):
    """Moving along "right", "up" and "toward" moves a point's picture right, up, and makes it nearer."""
    view = c.CameraConfig(azimuth_degrees=azimuth, elevation_degrees=elevation)
    camera = make_reference_camera(view, c.Rendering(), c.Domain())
    words = {word: np.asarray(v) for word, v in find_viewer_directions(view).items()}

    def picture(point):
        p = np.asarray(camera.viewmat)[:3, :3] @ point + np.asarray(camera.viewmat)[:3, 3]
        return p[0] / p[2], p[1] / p[2], p[2]

    here = picture(np.full(3, 2.0))
    assert picture(np.full(3, 2.0) + 0.1 * words["right"])[0] > here[0] + 0.01
    assert picture(np.full(3, 2.0) + 0.1 * words["up"])[1] < here[1] - 0.01
    assert picture(np.full(3, 2.0) + 0.1 * words["toward"])[2] < here[2] - 0.05
    for a, b in (("right", "left"), ("up", "down"), ("toward", "away")):
        np.testing.assert_allclose(words[a], -words[b], atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(words[a]), 1, atol=1e-9)


def test_framing_shows_every_point_and_not_much_more():
    rng = np.random.default_rng(0)
    points = rng.uniform(-1, 1, (50, 3)) * [1.5, 0.4, 0.6] + [2, 2.5, 1.8]
    view = c.CameraConfig(azimuth_degrees=25, elevation_degrees=15)
    camera = make_reference_camera(frame_camera(points, view, c.Rendering()), c.Rendering(), c.Domain())
    local = points @ np.asarray(camera.viewmat)[:3, :3].T + np.asarray(camera.viewmat)[:3, 3]
    pixels = local[:, :2] / local[:, 2:] * np.asarray(camera.K)[0, 0] + [camera.width / 2, camera.height / 2]
    size = np.array([camera.width, camera.height])
    assert (pixels > 0).all() and (pixels < size).all()
    assert (np.abs(pixels - size / 2).max(0) / (size / 2)).max() > 0.8


# --- fusion ------------------------------------------------------------------------------------------


def template(source, **changes):
    return SceneTemplate(
        **{
            "prompt": "x",
            "preset_name": "fast",
            "preset": PRESETS[PresetName.FAST],
            "source": source,
            "material": c.Material(),
            "anchor": c.Anchor(),
            "camera": c.CameraConfig(),
            **changes,
        }
    )


def test_fusion_is_deterministic_and_its_json_reads_back(source, body):
    field = ForceField.model_validate(
        {"actions": [{"action_type": "torque", "vector": [0, 0, 1], "magnitude": 1}]}
    )
    texts = {c.dump_scene(fuse(template(source), body, field)) for _ in range(2)}
    assert len(texts) == 1
    config = fuse(template(source), body, field)
    assert c.SceneConfig.model_validate_json(texts.pop()) == config


def test_falling_objects_get_a_floor_below_them(source, body):
    field = ForceField(default_drop=True)
    floor = fuse(template(source), body, field).boundaries[-1]
    np.testing.assert_allclose(floor.point[2], body.low[2] - 0.5 * body.extent, atol=1e-3)
    rooted = fuse(template(source, anchor=c.Anchor(kind="base")), body, field).boundaries[-1]
    np.testing.assert_allclose(rooted.point[2], body.low[2], atol=1e-3)
    assert not any(isinstance(b, c.HalfSpace) for b in fuse(template(source), body, ForceField()).boundaries)


def test_a_placed_camera_is_left_alone(source, body):
    camera = c.CameraConfig(target=(1, 2, 3), distance=7.0)
    assert fuse(template(source, camera=camera), body, ForceField()).camera == camera


def test_the_paper_preset_has_the_papers_figures():
    paper = PRESETS[PresetName.PAPER]
    assert (paper.domain.dx, paper.filling.max_particles) == (0.02, 200_000)  # 100 cells on 2 m: here on 4 m
    assert (paper.timing.frame_count, paper.timing.frame_dt, paper.timing.substep_dt) == (50, 0.04, 2e-4)
    assert paper.transfer.rpic_damping == 0.5
    np.testing.assert_allclose(np.exp(-paper.transfer.damping_rate * 2e-4), 0.9995, rtol=1e-12)


def test_a_scene_may_sharpen_its_increments(source, body):
    made = [scene(source, body, transfer=c.Transfer(sharpening=beta)).model for beta in (0.0, 0.18)]
    assert [model.inertia for model in made] == [Lumped(), Sharpened(0.18)]


@pytest.mark.parametrize("sharpening", [0.0, 0.18])
def test_a_scene_may_aggregate_its_light_nodes(sharpening, source, body):
    transfer = c.Transfer(sharpening=sharpening, aggregation=0.5)
    expected = Sharpened(0.18, 0.5) if sharpening else Lumped(0.5)
    assert scene(source, body, transfer=transfer).model.inertia == expected


def test_sparse_matter_is_warned_about(source):
    with pytest.warns(UserWarning, match="thinly filled"):
        make_body(source, c.Filling(max_particles=300), c.Domain(size=4.0, cells=96), ".")


def test_a_compiled_model_works_in_rollout_as_it_stands(source, body):
    """Dropped, it falls by g t^2 / 2; the window in `simulate` is a small part of the domain all the same."""
    made = scene(source, body, force_field=ForceField(default_drop=True, actions=[]))
    end, path = rollout(made.model, made.state, frame_count=2, substeps=made.substeps)
    time = 2 * made.config.timing.frame_dt
    assert float(end.time) == pytest.approx(time, rel=1e-5)
    fall = np.asarray(end.x - made.state.x).mean(0)
    np.testing.assert_allclose(fall, [0, 0, -9.8 * time**2 / 2], rtol=0.1, atol=1e-5)
    assert np.isfinite(path.x).all()
    assert float(made.model.dt) <= float(stable_dt(made.model, made.state))
    assert made.windowed.grid.shape == (4, 4, 4) and made.model.grid.shape == (49, 49, 49)
