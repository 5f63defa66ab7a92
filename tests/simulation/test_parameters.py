"""The motion as a function of all of a scene's numbers: derivatives agree with central differences."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.parameters import SceneParameters
from physagent_jax.simulation.simulate import simulate_scene
from physagent_jax.simulation.trajectory import trajectory
from tests.scene.small_scenes import TERMS, make_config, make_rich_scene, make_small_body

pytestmark = [
    pytest.mark.filterwarnings("ignore:the object is thinly filled"),
    pytest.mark.usefixtures("least_optimised"),  # derivatives of small scenes: to compile takes longest
]


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


# Run a few times each: compiling is what costs.
quick_jit = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})


def list_names(tree):
    """A name for every number of a pytree."""
    found = jax.tree_util.tree_leaves_with_path(tree)
    return [jax.tree_util.keystr(path) for path, leaf in found for _ in np.ravel(leaf)]


# Where a number is one of a step function: which particles are blown at, what is held when.
STEPS = (".center", ".radius", ".constraints[0].window", ".constraints[1].start", ".constraints[1].end")
# Of differences: round-off spoils short ones of what hardly matters, corners long ones.
LENGTHS = (1e-6, 1e-4)


@pytest.mark.usefixtures("least_optimised")
@pytest.mark.parametrize(
    "parts",
    [
        pytest.param({"material_regions": (), "forces": (TERMS[0], TERMS[-1])}, id="some"),
        pytest.param({}, id="all", marks=pytest.mark.slow),
    ],
)
def test_every_number_has_the_derivative_of_differences(parts, folder, body, x64):
    """Of the force field, terms with their envelopes, an impulse and a grip, materials, walls, start and drag."""
    scene = in_double_precision(make_rich_scene(folder, body, **parts))
    at = dataclasses.replace(SceneParameters.of(scene), velocity=np.array([0.2, -0.1, -1.5]))
    weight = np.random.default_rng(0).normal(size=(2, len(scene.state.x), 3, 3))

    def evaluate(numbers):
        path = trajectory(scene, numbers, substeps=12)
        return (path.x[1:] * weight[0, :, 0]).sum() + 0.1 * (path.F[-1] * weight[1]).sum()

    respond = quick_jit(evaluate)
    slopes, _ = ravel_pytree(quick_jit(jax.grad(evaluate))(at))
    values, rebuild = ravel_pytree(at)
    names, begun = list_names(at), float(respond(at))
    assert len(names) == len(values) > 50
    for index, (name, slope) in enumerate(zip(names, slopes)):

        def move(change, index=index):
            return float(respond(rebuild(values.at[index].add(change))))

        if (
            name.endswith(".start") and values[index] == 0
        ):  # nothing is before the clip: it can only begin later
            assert slope == pytest.approx((move(1e-6) - begun) / 1e-6, rel=1e-3) and slope != 0, name
            continue
        changes = (length * max(abs(float(values[index])), 1.0) for length in LENGTHS)
        differences = ((move(h) - move(-h)) / (2 * h) for h in changes)
        agrees = (slope == pytest.approx(each, rel=1e-5, abs=1e-9) for each in differences)
        assert any(agrees), (name, float(slope))
        assert (slope == 0) == name.endswith(STEPS), name


@pytest.mark.usefixtures("least_optimised")
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


@pytest.mark.slow
def test_single_precision_and_its_kernels_point_the_same_way(folder, body, x64):
    """As double precision by the reference path: all numbers, along a schedule, with contact."""
    scene = make_rich_scene(folder, body, material_regions=(), forces=TERMS[:1])
    schedule = simulate_scene(scene).schedule
    weight = np.random.default_rng(0).normal(size=scene.state.x.shape)
    exact = in_double_precision(scene)
    exact = dataclasses.replace(exact, model=exact.model.replace(kernels="reference"))
    at = SceneParameters.of(scene)

    def find_slopes(scene, numbers):
        def respond(numbers):
            return (trajectory(scene, numbers, schedule).x[1:] * weight).sum()

        slopes, values = ravel_pytree(jax.grad(respond)(numbers))[0], ravel_pytree(numbers)[0]
        return np.asarray(slopes, float) * np.maximum(np.abs(values), 1e-3)  # each by its own size

    one = find_slopes(scene, jax.tree.map(lambda value: jnp.asarray(value, jnp.float32), at))
    other = find_slopes(exact, at)
    assert one @ other > 0.999 * np.linalg.norm(one) * np.linalg.norm(other)


HELD = {"constraint_type": "enforce_particle_translation", "vector": [0.3, -0.2, 0.9], "held_until": 1.9}
HELD |= {"region": {"kind": "half_space", "point": [0.5, 0.5, 0.6], "normal": [0, 0, 1]}}
BLOW = {"constraint_type": "particle_impulse", "vector": [0.5, 0.2, 0.3], "magnitude": 0.6}
PLATE = {"constraint_type": "moving_plate", "vector": [0, 0.1, -1]}
WINDOW = [0.63, 1.37]


@pytest.mark.parametrize(
    ("items", "moving"),
    [
        pytest.param((HELD, BLOW), 3, id="held and blown at"),  # a blow has no end
        pytest.param((PLATE,), 2, id="pressed", marks=pytest.mark.slow),
    ],
)
def test_with_edges_what_is_held_or_blown_at_has_a_derivative_by_its_window(items, moving, folder, body, x64):
    """That of differences; and as the edges narrow, the motion becomes that of the hard window."""
    field = ForceField.model_validate(
        {"default_drop": True, "constraints": [item | {"active_time": WINDOW} for item in items]}
    )
    scene = in_double_precision(compile_scene(make_config(folder, force_field=field), body, folder))
    weight = np.random.default_rng(0).normal(size=scene.state.x.shape)

    def evaluate(windows, edge):
        numbers = ForceFieldParameters.of(field, 3)
        entries = tuple(
            dataclasses.replace(each, window=window) for each, window in zip(numbers.constraints, windows)
        )
        path = trajectory(scene, dataclasses.replace(numbers, constraints=entries), substeps=30, edge=edge)
        return (path.x[1:] * weight).sum(), path.x

    respond = quick_jit(evaluate)
    at, edge = jnp.tile(jnp.array(WINDOW), (len(items), 1)), 0.03
    slopes, _ = quick_jit(jax.grad(evaluate, has_aux=True))(at, edge)
    differences = [
        (respond(at + e, edge)[0] - respond(at - e, edge)[0]) / 2e-7
        for e in 1e-7 * np.eye(at.size).reshape(-1, *at.shape)
    ]
    np.testing.assert_allclose(np.ravel(slopes), differences, rtol=1e-5, atol=1e-9)
    assert np.count_nonzero(slopes) == moving
    hard = trajectory(scene, substeps=30).x
    away = [np.abs(respond(at, edge)[1] - hard).max() for edge in (0.03, 0.01, 1e-7)]
    assert np.abs(hard - hard[0]).max() / 3 > away[0] > 1.3 * away[1] > 0 and away[2] < 1e-7


def test_along_a_schedule_edges_act_beyond_the_frames_of_their_window(folder, body):
    """As in a simulation where everything acts in every step."""
    push = {"action_type": "translation", "vector": [0, 1, 0], "active_time": [1.1, 1.9]}
    field = ForceField.model_validate({"actions": [push]})
    config = make_config(folder, frame_count=4, substep_dt=0.05 / 20, force_field=field)
    scene = compile_scene(config, body, folder)
    schedule = simulate_scene(scene).schedule
    assert [frame.acting.forces for frame in schedule.frames] == [(), (0,), ()]
    hard, soft, everything = (
        trajectory(scene, schedule=schedule).x,
        trajectory(scene, schedule=schedule, edge=0.04).x,
        trajectory(scene, edge=0.04).x,
    )
    np.testing.assert_allclose(soft, everything, atol=2e-6)
    assert np.abs(soft[1] - hard[1]).max() > 1e-4
    for edge, message in ((-0.1, "must not be negative"), (np.nan, "must not be negative")):
        with pytest.raises(UserError, match=message):
            trajectory(scene, edge=edge)
    with pytest.raises(UserError, match="must be known along a schedule"):
        jax.grad(lambda edge: trajectory(scene, schedule=schedule, edge=edge).x.sum())(0.04)


def test_a_horizon_and_a_cut_gradient_without_a_schedule(folder, body, x64):
    """The beginning of the whole; and a frame's own gradient where the state that it begins with counts as given."""
    config = make_config(folder, always_gravity=True, frame_count=4)
    scene = in_double_precision(compile_scene(config, body, folder))
    whole, short = trajectory(scene, substeps=8), trajectory(scene, substeps=8, horizon=2)
    np.testing.assert_array_equal(short.x, whole.x[:3])

    def respond(pull, **options):
        numbers = SceneParameters(gravity=jnp.array([0, 0, -1.0]) * pull)
        return trajectory(scene, numbers, substeps=8, **options).x[-1, :, 2].mean()

    t = 3 * 0.05  # free fall: x = -g t^2 / 2; with the velocity given, the last stretch falls as from rest
    assert jax.grad(respond)(9.8) == pytest.approx(-0.5 * t**2, rel=0.05)
    assert jax.grad(lambda pull: respond(pull, truncate=3))(9.8) == pytest.approx(
        float(jax.grad(respond)(9.8))
    )
    for cut, stretch in ((1, 1), (2, 1)):
        slope = jax.grad(lambda pull, cut=cut: respond(pull, truncate=cut))(9.8)
        assert slope == pytest.approx(-0.5 * (stretch * 0.05) ** 2, rel=0.15)
    with pytest.raises(UserError, match="`horizon` must be within 1..3"):
        trajectory(scene, horizon=4)
    with pytest.raises(UserError, match="`truncate` must be at least 1"):
        trajectory(scene, truncate=0)
