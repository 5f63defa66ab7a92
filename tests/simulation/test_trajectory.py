"""A clip as a function of its force field's numbers: the derivatives are right, and the motion is the scene's."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.render import render
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.procedural import make_jelly
from physagent_jax.simulation.simulate import simulate_frames, simulate_scene
from physagent_jax.simulation.trajectory import find_static_substeps, trajectory

pytestmark = [
    pytest.mark.filterwarnings("ignore:the object is thinly filled"),
    pytest.mark.usefixtures("least_optimised"),  # derivatives of small scenes: to compile takes longest
]
WINDOW = [0.63, 1.87]  # ends within substeps, where positions are smooth functions of it
UPPER = {"kind": "half_space", "point": [0.5, 0.5, 0.6], "normal": [0.1, 0.2, 1.0]}
ITEMS = {
    "translation": {"action_type": "translation", "vector": [0.3, -0.8, 0.4], "magnitude": 1.2},
    "impulse": {"action_type": "impulse", "vector": [0.5, 0.2, -0.6], "magnitude": -0.9, "region": UPPER},
    "torque": {"action_type": "torque", "vector": [0.2, 0.3, 0.9], "magnitude": 1.3, "region": UPPER},
    "scale": {"action_type": "scale", "vector": [0.8, 0.3, 0.1], "magnitude": 0.7},
    "enforce_particle_translation": {
        "constraint_type": "enforce_particle_translation",
        "vector": [0.3, -0.2, 0.9],
        "magnitude": 1.1,
        "region": UPPER,
    },
    "particle_impulse": {"constraint_type": "particle_impulse", "vector": [0.5, 0.2, 0.3], "magnitude": 0.6},
}


def force_field(name, drop=False):
    item = ITEMS[name] | {"active_time": WINDOW}
    group = "actions" if "action_type" in item else "constraints"
    return ForceField.model_validate({"default_drop": drop, group: [item]})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("jelly")
    write_ply(path / "object.ply", make_jelly(0, count=800))
    return path


def make_scene(folder, field, frame_count=3, **timing):
    config = c.SceneConfig(
        source=c.Source(path=str(folder / "object.ply"), kind="jelly", extent=0.8),
        filling=c.Filling(max_particles=100),
        material=c.Material(youngs_modulus=3e4, density=400.0),
        domain=c.Domain(size=3.0, cells=24),
        timing=c.Timing(frame_count=frame_count, frame_dt=0.05, **timing),
        force_field=field,
    )
    body = make_body(config.source, config.filling, config.domain, folder)
    return compile_scene(config, body, folder)


def in_double_precision(scene):
    def widen(tree):
        return jax.tree.map(lambda a: a.astype(jnp.float64) if a.dtype == jnp.float32 else a, tree)

    return dataclasses.replace(scene, model=widen(scene.model), state=widen(scene.state))


@pytest.mark.parametrize("name", list(ITEMS))
def test_derivatives_agree_with_central_differences(name, folder, x64):
    scene = in_double_precision(make_scene(folder, force_field(name, drop=True)))
    substeps = find_static_substeps(scene)
    at = jax.tree.map(jnp.asarray, ForceFieldParameters.of(scene.config.force_field, 3))
    weight = np.random.default_rng(0).normal(size=(2, len(scene.state.x), 3, 3))

    @jax.jit
    def response(parameters):
        path = trajectory(scene, parameters, substeps=substeps)
        return (path.x * weight[0, :, 0]).sum() + 0.1 * (path.F[-1] * weight[1]).sum()

    slopes, _ = ravel_pytree(jax.jit(jax.grad(response))(at))
    values, rebuilt = ravel_pytree(at)
    h = 1e-6
    differences = np.array(
        [
            (response(rebuilt(values.at[i].add(h))) - response(rebuilt(values.at[i].add(-h)))) / (2 * h)
            for i in range(len(values))
        ]
    )
    np.testing.assert_allclose(slopes, differences, rtol=1e-6, atol=1e-6 * np.abs(differences).max())
    vector, magnitude, window = slopes[:3], slopes[3], slopes[4:]
    assert np.abs(vector).min() > 0 and magnitude != 0
    if name in (
        "enforce_particle_translation",
        "particle_impulse",
    ):  # these begin and end between two substeps
        assert not window.any()
    else:
        assert np.abs(window).min() > 0


def test_what_is_at_rest_at_first_has_derivatives_too(folder):
    scene = make_scene(folder, force_field("translation"))
    numbers = ForceFieldParameters.of(scene.config.force_field, 3)
    slope = jax.grad(lambda parameters: trajectory(scene, parameters).x[-1].sum())(numbers)
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(slope))


@pytest.mark.parametrize("name", list(ITEMS))
def test_it_is_the_motion_that_is_simulated(name, folder):
    """With the same fixed step to round-off, with the adaptive one as far as time steps differ."""
    field = force_field(name)
    fixed = make_scene(folder, field, substep_dt=0.05 / 32)
    frames = list(simulate_frames(fixed))
    path = trajectory(fixed)
    assert [frame.substeps for frame in frames] == [0, 32, 32] and find_static_substeps(fixed) == 32
    np.testing.assert_allclose(path.x, [frame.state.x for frame in frames], atol=2e-6)
    np.testing.assert_allclose(path.F, [frame.state.F for frame in frames], atol=2e-5)
    np.testing.assert_allclose(path.time, [frame.state.time for frame in frames], rtol=1e-5)

    adaptive = make_scene(folder, field, safety=0.5)
    x = np.asarray([frame.state.x for frame in simulate_frames(adaptive)])
    moved = np.abs(x - x[0]).max()
    np.testing.assert_allclose(trajectory(adaptive).x, x, atol=0.04 * moved)


def test_along_the_schedule_of_a_recording_it_is_the_recorded_motion(folder):
    """With the adaptive step and the window of `simulate_scene`; derivatives go through it, to pictures too."""
    scene = make_scene(folder, force_field("translation"))
    recording = simulate_scene(scene)
    path = trajectory(scene, schedule=recording.schedule)
    np.testing.assert_allclose(path.x, recording.x, atol=1e-6)
    np.testing.assert_allclose(path.F, recording.F, atol=1e-5)

    known = ForceFieldParameters.of(scene.config.force_field, 3)

    def balance(magnitude):
        action = dataclasses.replace(known.actions[0], magnitude=magnitude)
        path = trajectory(scene, dataclasses.replace(known, actions=(action,)), recording.schedule)
        splats = deform(*scene.gaussians, path.x[-1], path.F[-1], scene.body.placement.rotation)
        dark = 1 - render(splats, scene.camera).rgb.mean(-1)
        across, down = jnp.meshgrid(jnp.linspace(0, 1, dark.shape[1]), jnp.linspace(0, 1, dark.shape[0]))
        return (dark * (across - 2 * down)).mean()

    slope, difference = jax.grad(balance)(1.2), (balance(1.3) - balance(1.1)) / 0.2
    assert slope == pytest.approx(float(difference), rel=0.03) and slope != 0
    with pytest.raises(UserError, match="frames after the first, 1"):
        trajectory(make_scene(folder, force_field("translation"), frame_count=2), schedule=recording.schedule)
    with pytest.raises(UserError, match="Leave out `substeps`"):
        trajectory(scene, schedule=recording.schedule, substeps=3)


@pytest.mark.parametrize("model", [c.MaterialModel.NEO_HOOKEAN, c.MaterialModel.RIGID])
def test_given_numbers_are_those_of_a_scene_that_says_them(model, folder):
    """Every entry's numbers reach its own term, and the scene's other terms and constraints stay."""
    everything = {
        "actions": [item for item in ITEMS.values() if "action_type" in item],
        "constraints": [item for item in ITEMS.values() if "constraint_type" in item],
    }
    other = ForceField.model_validate(
        {
            group: [item | {"magnitude": 0.5, "vector": [0, 1, 0.5], "active_time": [1, 2]} for item in items]
            for group, items in everything.items()
        }
    )
    extra = {
        "material": c.Material(model=model),
        "forces": (c.Uniform(acceleration=(0, 0, 1.0)),),
        "anchor": c.Anchor(kind="base"),
    }

    def scene(field):
        plain = make_scene(folder, field)
        return compile_scene(plain.config.model_copy(update=extra), plain.body, folder)

    wanted = scene(ForceField.model_validate(everything)).model
    numbers = ForceFieldParameters.of(ForceField.model_validate(everything), 3)
    given = scene(other).with_parameters(numbers).model
    assert jax.tree.structure(given) == jax.tree.structure(wanted)
    for one, two in zip(jax.tree.leaves(given), jax.tree.leaves(wanted)):
        np.testing.assert_array_equal(one, two)


def test_many_force_fields_at_once(folder):
    """`jax.vmap` over vectors is the clip of each, compiled as one program."""
    scene = make_scene(folder, force_field("translation"), frame_count=2)
    known = ForceFieldParameters.of(scene.config.force_field, 2)

    def end(vector):
        action = dataclasses.replace(known.actions[0], vector=vector)
        return trajectory(scene, dataclasses.replace(known, actions=(action,))).centroid(scene.model.mass)[-1]

    vectors = jnp.eye(3)
    np.testing.assert_allclose(
        jax.jit(jax.vmap(end))(vectors), jnp.stack([end(v) for v in vectors]), atol=1e-5
    )


def test_what_does_not_fit_is_refused(folder):
    scene = make_scene(folder, force_field("translation"))
    with pytest.raises(UserError, match="one entry per entry of the force field, 1"):
        trajectory(scene, ForceFieldParameters())
    with pytest.raises(UserError, match="`substeps` must be at least 1"):
        trajectory(scene, substeps=0)
