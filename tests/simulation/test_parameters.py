"""The motion as a function of all of a scene's numbers: derivatives agree with central differences."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.parameters import SceneParameters
from physagent_jax.simulation.simulate import simulate_scene
from physagent_jax.simulation.trajectory import trajectory
from tests.scene.small_scenes import make_config, make_rich_scene, make_small_body

pytestmark = pytest.mark.filterwarnings("ignore:only .* particles per grid cell")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("jelly")


@pytest.fixture(scope="module")
def body(folder):
    return make_small_body(folder)


def in_double_precision(scene):
    def widen(tree):
        single = [getattr(leaf, "dtype", None) == jnp.float32 for leaf in jax.tree.leaves(tree)]
        leaves = [
            leaf.astype(jnp.float64) if each else leaf for leaf, each in zip(jax.tree.leaves(tree), single)
        ]
        return jax.tree.unflatten(jax.tree.structure(tree), leaves)

    return dataclasses.replace(scene, model=widen(scene.model), state=widen(scene.state))


def list_names(tree):
    """A name for every number of a pytree."""
    found = jax.tree_util.tree_leaves_with_path(tree)
    return [jax.tree_util.keystr(path) for path, leaf in found for _ in np.ravel(leaf)]


# Where a number is one of a step function: which particles are blown at, what is held when.
STEPS = (".center", ".radius", ".constraints[0].window", ".constraints[1].start", ".constraints[1].end")


@pytest.mark.parametrize(
    "regions",
    [pytest.param((), id="fields"), pytest.param(None, id="fields and solids", marks=pytest.mark.slow)],
)
def test_every_number_has_the_derivative_of_differences(regions, folder, body, x64):
    """Of the force field, five terms with their envelopes, an impulse and a grip, materials, walls, start and drag."""
    parts = {} if regions is None else {"material_regions": regions}
    scene = in_double_precision(make_rich_scene(folder, body, **parts))
    at = dataclasses.replace(SceneParameters.of(scene), velocity=np.array([0.2, -0.1, -1.5]))
    weight = np.random.default_rng(0).normal(size=(2, len(scene.state.x), 3, 3))

    @jax.jit
    def respond(numbers):
        path = trajectory(scene, numbers, substeps=12)
        return (path.x[1:] * weight[0, :, 0]).sum() + 0.1 * (path.F[-1] * weight[1]).sum()

    slopes, _ = ravel_pytree(jax.jit(jax.grad(respond))(at))
    values, rebuild = ravel_pytree(at)
    names, begun = list_names(at), respond(at)
    assert len(names) == len(values) > 70
    for index, (name, slope) in enumerate(zip(names, slopes)):
        h = 1e-6 * max(abs(float(values[index])), 1.0)
        after = respond(rebuild(values.at[index].add(h)))
        if (
            name.endswith(".start") and values[index] == 0
        ):  # nothing is before the clip: it can only begin later
            difference = (after - begun) / h
            assert slope == pytest.approx(float(difference), rel=1e-3) and slope != 0, name
            continue
        difference = (after - respond(rebuild(values.at[index].add(-h)))) / (2 * h)
        assert slope == pytest.approx(float(difference), rel=1e-5, abs=1e-9), name
        assert (slope == 0) == name.endswith(STEPS), name


def test_a_simulation_of_other_numbers_is_their_own(folder, body):
    """It takes over no frame of the scene's, and along its schedule its motion comes out again."""
    scene = compile_scene(make_config(folder, always_gravity=True), body, folder)
    recording = simulate_scene(scene)
    thrown = SceneParameters(velocity=np.array([0.4, 0.0, 1.0]))
    other = simulate_scene(scene.with_parameters(thrown), restart_cache=recording.restart_cache)
    again = simulate_scene(scene, restart_cache=other.restart_cache)
    assert other.reused_frames == again.reused_frames == 0 and np.abs(other.x - recording.x).max() > 0.05
    np.testing.assert_array_equal(again.x, recording.x)
    own = trajectory(scene, SceneParameters.of(scene), recording.schedule)
    np.testing.assert_array_equal(own.x, trajectory(scene, schedule=recording.schedule).x)
    np.testing.assert_allclose(own.x, recording.x, atol=1e-6)
    np.testing.assert_allclose(trajectory(scene, thrown, other.schedule).x, other.x, atol=1e-6)
