"""The captured pose under its own weight: at rest, and where the law says nothing, unchanged."""

import dataclasses

import jax
import numpy as np
import pytest
import trimesh

from physagent_jax.core.arrays import to_device
from physagent_jax.forces.schema import ForceField
from physagent_jax.mpm import step
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.compile.equilibrium import find_equilibrium, find_or_warn
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.standing import Support, make_stand
from physagent_jax.simulation.simulate import simulate_frames


@pytest.fixture(scope="module")
def pillar(tmp_path_factory):
    """A jelly pillar, three quarters as wide as high."""
    path = tmp_path_factory.mktemp("pillar") / "jelly.obj"
    trimesh.creation.box((0.75, 0.75, 1.0)).export(path)
    return path


def scene_of(path, *, frames=20, cells=48, particles=3000, field=None, **parts):
    overrides = dict(max_particles=particles, cells=cells, frame_count=frames)
    base = {"object": {"path": str(path), "up": "+z"}, "prompt": "x", "world": "ground"}
    spec = {**base, "overrides": overrides, **parts}
    run = resolve(RunSpec.model_validate(spec))
    template = run.template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    template, notes = make_stand(template, body, Support(keep_material=run.spec.material.says_stiffness))
    return compile_scene(fuse(template, body, field or ForceField()), body), notes


def farthest(scene):
    """Largest root mean square way from the captured pose [L]."""
    rest = np.asarray(scene.state.x)
    return max(
        np.sqrt(((np.asarray(frame.state.x) - rest) ** 2).sum(1).mean()) for frame in simulate_frames(scene)
    )


def test_jelly_stands_as_it_was_captured(pillar):
    scene, _ = scene_of(pillar)
    assert scene.config.always_gravity and scene.config.start == "equilibrium"
    assert farthest(scene) < 0.005
    eye = to_device(np.broadcast_to(np.eye(3, dtype=np.float32), scene.state.F.shape))
    unstressed = dataclasses.replace(scene, state=dataclasses.replace(scene.state, F=eye))
    assert farthest(unstressed) > 0.03  # a bar sags by rho g L / 2E = 0.08 at its top


def test_the_stress_is_that_of_a_bar_under_its_weight(pillar):
    scene, _ = scene_of(pillar, frames=2)
    material, x = scene.config.material, np.asarray(scene.state.x)
    firmness = 1.0 if scene.materials.firmness is None else scene.materials.firmness
    mu = firmness * material.youngs_modulus / (2 * (1 + material.poissons_ratio))
    lam = 2 * mu * material.poissons_ratio / (1 - 2 * material.poissons_ratio)
    F = np.asarray(scene.state.F, float)
    J = np.linalg.det(F)
    tau = mu * ((F @ F.transpose(0, 2, 1))[:, 2, 2] - 1) + lam * np.log(J)
    height = x[:, 2] - x[:, 2].min()
    for low in (0.3, 0.5, 0.7):
        slab = np.abs(height - low) < 0.08
        weight = material.density * 9.8 * (1.0 - height[slab].mean())
        assert tau[slab].mean() == pytest.approx(-weight, rel=0.1)


def test_the_residual_is_the_acceleration_that_the_simulation_begins_with(pillar):
    """Whatever bears the weight must be there in the simulation too."""
    scene, _ = scene_of(pillar, frames=2)
    found = find_equilibrium(scene.model, scene.state, np.zeros(len(scene.state.x), bool), scene.config)
    after = jax.jit(step)(scene.model, dataclasses.replace(scene.state, F=to_device(found.F)))
    begun = np.linalg.norm(np.asarray(after.v), axis=1) / float(scene.model.dt)
    left = np.sqrt(np.average(begun**2, weights=np.asarray(scene.model.mass))) / 9.8
    assert left == pytest.approx(found.residual, rel=0.1)
    assert left < 0.005


def test_matter_that_its_weight_crushes_starts_without_stress(pillar):
    """Its stretches would burst in the first substep: it sags from where it was captured, and that is told."""
    scene, _ = scene_of(pillar, frames=2)
    model, held = scene.model, np.zeros(len(scene.state.x), bool)
    assert model.gravity is not None
    heavy = dataclasses.replace(model, gravity=300 * model.gravity)
    found = find_equilibrium(heavy, scene.state, held, scene.config)
    assert np.isfinite(found.F).all() and np.linalg.det(found.F).min() > 0 and found.crushed > 0.1
    assert find_equilibrium(model, scene.state, held, scene.config).crushed == 0
    rest = dataclasses.replace(scene.state, F=np.broadcast_to(np.eye(3, dtype=np.float32), found.F.shape))
    with pytest.warns(UserWarning, match="could not be balanced"):
        start = find_or_warn(heavy, rest, held, scene.config)
    assert (start.F == rest.F).all()


def test_a_held_plant_keeps_its_pose(pillar):
    scene, _ = scene_of(pillar, object={"path": str(pillar), "up": "+z", "kind": "plant"})
    assert scene.config.anchor.kind == "base" and scene.anchored
    assert farthest(scene) < 0.005


def test_what_falls_or_floats_bears_nothing(pillar):
    for field, parts in ((ForceField(default_drop=True), {}), (None, {"world": "free"})):
        scene, _ = scene_of(pillar, frames=2, field=field, world=parts.get("world", "ground"))
        assert scene.config.start == "unstressed"
        np.testing.assert_array_equal(scene.state.F, np.broadcast_to(np.eye(3), scene.state.F.shape))
    sand, _ = scene_of(pillar, frames=2, material={"name": "sand"})
    assert sand.config.start == "unstressed" and sand.config.always_gravity


def test_what_stands_on_its_tip_is_held_and_says_so(robot_path):
    scene, notes = scene_of(robot_path, frames=2, particles=1500, object={"path": str(robot_path)})
    assert "beyond what it stands on: its feet are held" in notes[0]
    assert scene.config.anchor.kind == "base" and scene.config.always_gravity
