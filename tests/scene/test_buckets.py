"""Arrays filled up to common sizes: nothing moves or looks different, and nothing is compiled twice."""

import dataclasses

import jax
import numpy as np
import pytest

from physagent_jax.forces.schema import ForceField
from physagent_jax.mpm.frame import advance
from physagent_jax.render.renderer import draw
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import buckets, compile_scene
from physagent_jax.simulation.simulate import deform_splats, simulate_frames, simulate_scene

pytestmark = pytest.mark.usefixtures(
    "least_optimised"
)  # derivatives of small scenes: to compile takes longest

DOMAIN = c.Domain(size=4.0, cells=48)


def config(robot_path, particles=1500, **parts):
    source = c.Source(path=str(robot_path), name="robot", kind="robot", up="-y")
    timing = c.Timing(frame_count=4, frame_dt=0.02)
    small = c.Rendering(width=64, height=64)
    filling = c.Filling(max_particles=particles)
    return c.SceneConfig(
        source=source, domain=DOMAIN, filling=filling, timing=timing, rendering=small, **parts
    )


def body_of(scene):
    return make_body(scene.source, scene.filling, scene.domain, ".")


def test_a_bucket_is_hardly_larger_and_there_are_few():
    counts = np.arange(1, 100_000)
    sizes = np.array([buckets.round_up(count) for count in counts])
    assert (sizes >= counts).all() and (sizes <= 1.125 * counts).all() and (np.diff(sizes) >= 0).all()
    assert all(buckets.round_up(size) == size for size in np.unique(sizes))
    octave = np.unique(sizes[(sizes > 32_768) & (sizes <= 65_536)])
    assert len(octave) == 8


def test_copies_fill_each_block_and_share_their_mass():
    order, block = np.random.default_rng(0).permutation(150), np.repeat([3, 7], [101, 49])
    filled = buckets.add_copies(order, block)
    assert len(filled) == buckets.round_up(101) + buckets.round_up(49) == 104 + 52
    assert set(filled[:104]) == set(order[:101]) and set(filled[104:]) == set(order[101:])
    np.testing.assert_allclose(np.bincount(filled, buckets.split_mass(filled)), 1)
    kept = filled[np.append(True, np.diff(filled) != 0)]
    np.testing.assert_array_equal(kept, order)  # the order itself is kept


@pytest.fixture(scope="module")
def busy(robot_path):
    """Two materials, a held base, forces that act per particle, per mass and as skills."""
    stiff = c.Material(model=c.MaterialModel.FIXED_COROTATED, youngs_modulus=3e5, density=50.0)
    action = {"action_type": "torque", "vector": [0, 0, 1], "magnitude": 1.0}
    return config(
        robot_path,
        material_regions=(c.MaterialRegion(point=(2, 2, 2.5), half_size=(1, 1, 0.5), material=stiff),),
        anchor=c.Anchor(kind="base", fraction=0.2),
        force_field=ForceField.model_validate({"default_drop": True, "actions": [action]}),
        constraints=(
            c.ParticleImpulse(force=(0, 2e-3, 0), point=(2, 2, 2), half_size=(2, 2, 2), duration=0.03),
        ),
        ledger=True,
    )


def test_a_scene_moves_and_looks_as_without_copies(busy, monkeypatch):
    body, found = body_of(busy), []
    for bucket in (buckets.round_up, lambda count: count):
        monkeypatch.setattr(buckets, "round_up", bucket)
        scene = compile_scene(busy, body)
        recording = simulate_scene(scene)
        found.append((scene, recording, recording.x[:, scene.back], recording.F[:, scene.back]))
    (filled, with_copies, x, F), (plain, without, expected_x, expected_F) = found
    count = body.particles.count
    assert len(plain.order) == count < len(filled.order) and plain.anchored == filled.anchored > 0
    moved = np.abs(expected_x[-1] - expected_x[0]).max()
    assert moved > 0.01
    np.testing.assert_allclose(x, expected_x, atol=1e-4 * moved)
    np.testing.assert_allclose(F, expected_F, atol=1e-4 * np.abs(expected_F - np.eye(3)).max())
    assert with_copies.gaussians.shape == without.gaussians.shape == (4, body.cloud.count, 3)
    assert np.abs(with_copies.rgb.astype(int) - without.rgb).max() <= 1
    ours, theirs = with_copies.record, without.record
    assert ours.particle_count == theirs.particle_count == count
    for name in ("kinetic_energy", "elastic_energy", "gravitational_energy"):
        values = getattr(theirs, name)
        np.testing.assert_allclose(getattr(ours, name), values, atol=1e-3 * np.abs(values).max())
    np.testing.assert_allclose(filled.model.mass.sum(), plain.model.mass.sum(), rtol=1e-5)


def test_copies_stay_with_their_originals(busy):
    scene = compile_scene(busy, body_of(busy))
    end = list(simulate_frames(scene))[-1].state
    twice = np.flatnonzero(np.diff(scene.order) == 0)
    assert len(twice) > 0
    for leaf in jax.tree.leaves(dataclasses.replace(end, history=())):
        if leaf.ndim:
            np.testing.assert_array_equal(leaf[twice], leaf[twice + 1])


def test_gaussians_that_fill_up_are_invisible_and_come_last(robot_path):
    body = body_of(config(robot_path))
    count, given = body.cloud.count, (body.cloud, body.binding)
    cloud, binding = filled = buckets.pad_gaussians(*given)
    assert cloud.count == len(binding.indices) == buckets.round_up(count) > count
    assert not np.asarray(cloud.opacities[count:]).any()
    for leaf, before in zip(jax.tree.leaves(filled), jax.tree.leaves(given)):
        np.testing.assert_array_equal(leaf[:count], before)


def test_held_particles_come_in_buckets_too():
    mask = np.random.default_rng(0).random(5000) < 0.2
    places, count = np.asarray(buckets.find_places(mask)), mask.sum()
    assert len(places) == buckets.round_up(count) > count
    np.testing.assert_array_equal(places[:count], np.flatnonzero(mask))
    assert (places[count:] == len(mask)).all()


GRIP = {
    "constraint_type": "enforce_particle_translation",
    "vector": [1, 0, 0],
    "magnitude": 1,
    "active_time": [0, 2],
    "region": {"kind": "half_space", "point": [0.5, 0.5, 0.6], "normal": [0, 0, 1]},
}


@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"anchor": c.Anchor(kind="base", fraction=0.2)},
        {"force_field": ForceField.model_validate({"constraints": [GRIP]})},
    ],
    ids=["free", "anchored", "gripped"],
)
def test_an_object_of_nearly_the_same_size_compiles_nothing_anew(robot_path, parts):
    programs = []
    for particles in (1450, 1500):
        scene = config(robot_path, particles, **parts)
        scene = compile_scene(scene, body_of(scene))
        assert scene.body.particles.count != len(scene.order)
        simulate_scene(scene)
        programs.append((advance._cache_size(), draw._cache_size(), len(scene.order)))  # type: ignore[attr-defined]
    assert programs[0] == programs[1]


def test_bands_that_are_zero_are_not_drawn(robot_path):
    scene = config(robot_path)
    body = body_of(scene)
    degree = body.cloud.sh_degree
    assert degree > 0
    for kept in range(degree + 1):
        sh = body.cloud.sh.at[:, (kept + 1) ** 2 :].set(0)
        cut = dataclasses.replace(body.cloud, sh=sh).of_least_degree()
        assert cut.sh_degree == kept
        np.testing.assert_array_equal(cut.sh, sh[:, : (kept + 1) ** 2])
    drawn = deform_splats(compiled := compile_scene(scene, body), next(iter(simulate_frames(compiled))))
    assert drawn.sh.shape[1] == (degree + 1) ** 2
