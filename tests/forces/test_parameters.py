"""A force field's numbers as a pytree: nothing changes them on the way, and what is traced obeys the same law."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces import calibration
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.free_path import compute_free_path
from physagent_jax.forces.parameters import ActionParameters, ForceFieldParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField
from physagent_jax.forces.skills import find_skill, list_skills
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.motion.tolerances import expect_move, expect_rotation, expect_strain

pytestmark = pytest.mark.usefixtures(
    "least_optimised"
)  # derivatives of small scenes: to compile takes longest

FRAMES, FRAME_DT = 26, 0.04
SCALING = make_closed_form_scaling(extent=0.83, youngs_modulus=5e4, density=390.0, duration=1.0)
REGION = {"kind": "sphere", "center": [0.4, 0.6, 0.5], "radius": 0.4}
FIELD = ForceField.model_validate(
    {
        "actions": [
            {"action_type": "translation", "vector": [1, 2, 3], "magnitude": -0.7},
            {"action_type": "scale", "vector": [3, -1, 0.2], "magnitude": 1.3, "active_time": [2, 9.7]},
            {"action_type": "scale", "vector": [0, 1, 2], "magnitude": -0.5, "region": REGION},
            {"action_type": "impulse", "vector": [0, 0.1, 1], "magnitude": 1.6, "active_time": [3, 4]},
            {"action_type": "torque", "vector": [1, 1, 0], "magnitude": 0.4, "region": REGION},
        ],
        "constraints": [
            {"constraint_type": "enforce_particle_translation", "vector": [1, 0, 1], "region": REGION},
            {"constraint_type": "particle_impulse", "vector": [0, 1, 1], "active_time": [5.5, 7.25]},
        ],
    }
)


def cloud(dtype=np.float32):
    """A lopsided dumb-bell: its necks and heads make a stretch's stress concentration matter."""
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 1, (1500, 3))
    thin = (np.abs(x[:, 1:] - 0.5) < 0.08).all(1)
    x = x[thin | (x[:, 0] < 0.3) | (x[:, 0] > 0.8)]
    return x.astype(dtype), rng.uniform(1, 2, len(x))


def compiled(parameters=None, field=FIELD, dtype=np.float32):
    return compile_force_field(
        field, SCALING, *cloud(dtype), frame_dt=FRAME_DT, frame_count=FRAMES, parameters=parameters
    )


def test_numbers_survive_the_way_there_and_back():
    numbers = ForceFieldParameters.of(FIELD, FRAMES)
    assert numbers.to_force_field(FIELD, FRAMES) == FIELD
    assert [leaf.dtype for leaf in jax.tree.leaves(numbers)] == [np.float64] * 3 * 7
    assert numbers.actions[0].window.tolist() == [0, FRAMES - 1]  # None = the whole clip


def test_terms_of_given_numbers_are_those_of_the_field_bit_by_bit():
    wanted, given = compiled(), compiled(ForceFieldParameters.of(FIELD, FRAMES))
    assert jax.tree.structure(wanted) == jax.tree.structure(given)
    for one, two in zip(jax.tree.leaves(wanted), jax.tree.leaves(given)):
        np.testing.assert_array_equal(np.asarray(one), np.asarray(two))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_traced_numbers_obey_the_same_law(dtype, x64):
    """Also where a direction says how a body is cut (the stress concentration of a stretch)."""
    numbers = jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), ForceFieldParameters.of(FIELD, FRAMES))
    traced = jax.jit(lambda numbers: compiled(numbers, dtype=dtype))(numbers)
    wanted = compiled(dtype=dtype)
    assert wanted[0][1].magnitude < 0.8 * SCALING.scale * 1.3  # the neck counts
    for one, two in zip(jax.tree.leaves(traced), jax.tree.leaves(wanted)):
        assert one.dtype == two.dtype
        np.testing.assert_allclose(one, two, rtol=1e-12 if dtype is np.float64 else 2e-5)


def test_a_longer_vector_is_a_greater_magnitude(x64):
    """Traced and not, for all skills and constraints: terms that are linear in M v feel no difference."""

    def effect(numbers):
        forces, (held,) = compiled(numbers, dtype=np.float64)
        x, volume = map(jnp.asarray, cloud(np.float64))
        push = [force.acceleration(x, 0 * x, volume, 0.22, 0.04) for force in forces]
        return [*push, held.velocity]

    numbers = ForceFieldParameters.of(FIELD, FRAMES)

    def longer(item: ActionParameters) -> ActionParameters:
        return dataclasses.replace(item, vector=2 * item.vector, magnitude=item.magnitude / 2)

    changed = ForceFieldParameters(
        tuple(map(longer, numbers.actions)), tuple(map(longer, numbers.constraints))
    )
    for one, two, three in zip(effect(numbers), effect(changed), jax.jit(effect)(changed)):
        np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(three, one, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("group", "index"),
    [*(("actions", i) for i in range(len(FIELD.actions))), ("constraints", 0), ("constraints", 1)],
)
def test_every_number_has_a_derivative(group, index, x64):
    """Of the term, against central differences; those of whole clips are in tests/simulation."""
    alone = ForceField(**{group: (getattr(FIELD, group)[index],)})
    weight = jnp.asarray(np.random.default_rng(1).normal(size=(len(cloud()[0]), 3)))

    def effect(flat):
        numbers = ForceFieldParameters(**{group: (ActionParameters(flat[:3], flat[3], flat[4:]),)})
        (forces, held) = compiled(numbers, alone, np.float64)
        if held:
            return (held[0].velocity * weight[0]).sum()
        x, volume = map(jnp.asarray, cloud(np.float64))
        (force,) = forces
        spans = ((0.1, 0.03), (0.13, 0.7))  # the windows begin and end within them
        return sum((force.acceleration(x, 0 * x, volume, t, dt) * dt * weight).sum() for t, dt in spans)

    effect = jax.jit(effect)
    at = jnp.array([0.3, -0.5, 0.7, 1.2, 3.1, 19.3])
    h = 1e-6
    differences = [(effect(at.at[i].add(h)) - effect(at.at[i].add(-h))) / (2 * h) for i in range(6)]
    np.testing.assert_allclose(jax.grad(effect)(at), differences, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "entry"),
    [
        ({"magnitude": 9.0}, {"magnitude": calibration.MAGNITUDE_MAX}),
        ({"magnitude": -0.1}, {"magnitude": -calibration.MAGNITUDE_MIN}),
        ({"vector": [0.0, 0.0, -3.0]}, {"vector": (0.0, 0.0, -1.0)}),
        ({"window": [-3.0, 5.0]}, {"active_time": (0.0, 5.0)}),
        ({"window": [1.0, 80.0]}, {"active_time": (1.0, 80.0)}),  # one may outlast the clip
        ({"window": [8.0, 4.0]}, {"active_time": (8.0, 8.01)}),
        ({"window": [70.0, 80.0]}, {"active_time": (24.99, 80.0)}),
    ],
)
def test_numbers_are_brought_into_the_library_s_range(change, entry):
    numbers = ForceFieldParameters.of(FIELD, FRAMES)
    change = {name: np.asarray(value) for name, value in change.items()}
    actions = (dataclasses.replace(numbers.actions[0], **change), *numbers.actions[1:])
    written = dataclasses.replace(numbers, actions=actions).to_force_field(FIELD, FRAMES)
    assert written.actions[1:] == FIELD.actions[1:] and written.constraints == FIELD.constraints
    ForceField.model_validate_json(written.model_dump_json())
    for name, value in entry.items():
        assert getattr(written.actions[0], name) == pytest.approx(value)
    compiled(field=written)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vector": [0.0, 0.0, 0.0]}, "zero vector"),
        ({"vector": [math.nan, 0.0, 1.0]}, "must be finite"),
        ({"magnitude": math.inf}, "must be finite"),
    ],
)
def test_numbers_that_mean_nothing_are_refused(change, message):
    numbers = ForceFieldParameters.of(FIELD, FRAMES)
    change = {name: np.asarray(value) for name, value in change.items()}
    actions = (dataclasses.replace(numbers.actions[0], **change), *numbers.actions[1:])
    with pytest.raises(UserError, match=message):
        dataclasses.replace(numbers, actions=actions).to_force_field(FIELD, FRAMES)


def test_numbers_of_another_field_are_refused():
    numbers = ForceFieldParameters.of(FIELD, FRAMES)
    with pytest.raises(UserError, match="one entry per entry of the force field, 2"):
        compiled(dataclasses.replace(numbers, constraints=()))


def test_the_free_path_is_what_pushes_and_blows_add_up_to():
    """A push over the whole clip and a blow at its start each travel what they are calibrated to."""

    def end(kind, **window):
        field = ForceField.model_validate(
            {"actions": [{"action_type": kind, "vector": [0, 0, 1], "magnitude": 1.2, **window}]}
        )
        return compute_free_path(field, SCALING, frame_dt=1 / 200, frame_count=201)[-1, 2]

    travel = 1.2 * calibration.TRAVEL * 0.83
    np.testing.assert_allclose(end("translation"), travel, rtol=0.01)  # half a frame ahead
    np.testing.assert_allclose(end("impulse", active_time=[0, 1]), travel, rtol=1e-9)
    assert end("torque") == 0


def test_what_one_gives_is_within_what_a_viewer_expects():
    """A magnitude of 1 gives a motion that viewers call plain."""
    plain = ExpectedMotion(kind=MotionKind.STRETCH, window=(0, 25))
    band = expect_strain(plain, squeeze=False)
    turn = expect_rotation(plain, anchored=False)
    move = expect_move(plain, anchored=False)
    assert band.low < calibration.STRAIN < band.high
    assert turn.low < math.degrees(calibration.TURN) < turn.high
    assert move.low < calibration.TRAVEL < move.high


def test_what_one_means_is_said_in_words():
    assert all(skill.one_means and skill.unit for skill in list_skills())
    assert "90 degrees" in find_skill("torque").one_means and "0.15" in find_skill("scale").one_means


def test_a_gain_acts_as_a_factor_on_k():
    """Every skill with M = 0.5 and a gain of 3 does what one with M = 1.5 does, and its gain is a part of its JSON."""
    timed = {"vector": [0.6, 0, 0.8], "active_time": [2, 9]}
    for group, key in (("actions", "action_type"), ("constraints", "constraint_type")):
        for skill in list_skills(group):
            entry = {key: skill.name, **timed} | ({"active_time": [2, 3]} if skill.is_sudden else {})
            strong, again = (
                ForceField.model_validate({group: [entry | numbers]})
                for numbers in ({"magnitude": 1.5}, {"magnitude": 0.5, "gain": 3.0})
            )
            rest, volume = np.random.default_rng(0).uniform(0, 1, (40, 3)), np.full(40, 1e-3)
            compiled = [
                compile_force_field(field, SCALING, rest, volume, frame_dt=FRAME_DT, frame_count=FRAMES)
                for field in (strong, again)
            ]
            for one, other in zip(*map(jax.tree.leaves, compiled), strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-6, err_msg=skill.name)
            assert "gain" not in strong.model_dump_json() and '"gain":3.0' in again.model_dump_json()
            assert ForceField.model_validate_json(again.model_dump_json()) == again
