"""CLIP as the objective: its gradient by the forces, and a descent that raises it."""

import dataclasses
import math
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from baselines.evaluation import GRADIENT_COST, Evaluator
from baselines.methods import make_method
from baselines.parametrisation import Parametrisation
from baselines.protocol import Budget
from baselines.simulation import Simulation
from baselines.truncation import WHOLE
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.metrics.clip_similarity import load_clip
from tests.metrics.make_tiny_clip import FOLDER, LENGTH, SIZE

for package in ("flax", "safetensors", "tokenizers"):
    pytest.importorskip(package, reason="needs the extra `clip`")

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # to compile takes longest


@pytest.fixture(scope="module")
def encoder():
    return load_clip(FOLDER)


def make_coarse_sighted():
    """The tiny CLIP with patches that count by their mean colour."""
    from physagent_jax.metrics.clip_checkpoint import make_model, read_config, read_tensors
    from physagent_jax.metrics.clip_encoder import ClipEncoder
    from physagent_jax.metrics.clip_pictures import Preparation
    from physagent_jax.metrics.clip_words import Words

    tensors, name = read_tensors(FOLDER), "vision_model.embeddings.patch_embedding.weight"
    filters = tensors[name].astype(np.float32)
    tensors[name] = np.broadcast_to(filters.mean((2, 3), keepdims=True), filters.shape)
    model = make_model(read_config(FOLDER / "config.json"), tensors)
    return ClipEncoder(model, Preparation.read(FOLDER, SIZE), Words(FOLDER, LENGTH), "coarse")


def make_loss(encoder, sentence="push it left"):
    embedded = encoder.embed(sentence)
    return lambda rgb: -encoder.cosines(rgb, embedded).mean()


def find_push(field):
    (action,) = field.actions
    return action.magnitude * np.asarray(action.vector)


@pytest.mark.slow  # the pixels' part is in tests/metrics, and a descent below needs the rest
def test_the_gradient_by_the_forces_is_that_of_differences(tiny):
    """Through both towers, the renderer and all substeps, along the steps of one simulation.

    Of a CLIP that sees the mean colours of patches, so that what it says is smooth over a step. What crosses the least
    alpha that is drawn has no derivative, so it is right to a seventh.
    """
    simulation, loss, frames = Simulation(tiny), make_loss(make_coarse_sighted()), [3, 7]
    rollout = simulation.simulate(tiny.start)
    here = ForceFieldParameters.of(tiny.start, tiny.frame_count)
    _, gradient = simulation.differentiate_pictures(rollout, here, loss, frames)
    unknowns = Parametrisation(tiny.start, tiny.frame_count)
    slope, u = unknowns.pull_back(tiny.start, gradient), unknowns.encode(tiny.start)

    def value(u):
        return float(loss(simulation.draw(rollout, unknowns.to_parameters(u), frames)))

    h = 0.01
    differences = [(value(u + h * axis) - value(u - h * axis)) / (2 * h) for axis in np.eye(3)]
    assert np.abs(differences).max() > 1e-4
    np.testing.assert_allclose(slope, differences, atol=0.15 * np.abs(differences).max())


def test_one_gradient_is_that_of_the_parts(tiny, encoder):
    """The pixels' own, carried back by `pull_back`; frames that are not shown have none."""
    simulation, loss, frames = Simulation(tiny), make_loss(encoder), [2, 6]
    pictures, rollout = simulation.play(tiny.start)
    here = ForceFieldParameters.of(tiny.start, tiny.frame_count)
    value, whole = simulation.differentiate_pictures(rollout, here, loss, frames)
    shown = jnp.asarray(pictures.rgb[frames], jnp.float32) / 255
    pixels = np.zeros(pictures.rgb.shape, np.float32)
    pixels[frames] = jax.grad(loss)(shown)
    parts, _ = simulation.pull_back(rollout, here, pixels, WHOLE)
    assert value == pytest.approx(float(loss(shown)), abs=1e-3)  # pictures are rounded to 8 bits
    for one, other in zip(whole.actions, parts.actions):
        assert np.abs(one.vector).max() > 0
        np.testing.assert_allclose(one.vector, other.vector, atol=0.02 * np.abs(one.vector).max())


@pytest.mark.slow  # its gradient is compared above
def test_a_few_steps_raise_the_similarity(tiny, encoder):
    """The target is never read: with one that cannot be measured everything is as before."""
    blind = dataclasses.replace(
        tiny, target=None, spec=SimpleNamespace(name="blind", sentence="push it left")
    )
    method = make_method("clip_guided", dict(clip=encoder, iterations=4, shown=4, learning_rate=0.2))
    result = method.fit(blind, Budget(60.0))
    scores = [-each.objective for each in result.evaluations]
    assert len(scores) == 4 and max(scores[1:]) > scores[0] + 1e-3
    assert result.incumbent_at() == result.evaluations[int(np.argmax(scores))].force_field
    assert not result.oracle and result.model_calls == 4
    assert 4 * GRADIENT_COST + 1 <= result.spent <= 4 * GRADIENT_COST + 4
    again = method.fit(blind, Budget(60.0))
    assert [each.force_field for each in again.evaluations] == [
        each.force_field for each in result.evaluations
    ]


def test_a_step_that_fails_is_halved(tiny):
    """An encoder that wants the object on the left, of a simulator that fails there."""

    class Dark:
        def embed(self, sentence):
            return jnp.linspace(1.0, -1.0, 64)

        def cosines(self, rgb, embedded):
            return 0.2 * ((1 - rgb.mean(-1)) * embedded).mean((1, 2))

    def build(force_field):
        if find_push(force_field)[0] < -0.5:
            raise UserError("it tears")
        return tiny.build(force_field)

    fragile = dataclasses.replace(tiny, build=build)
    options = dict(clip=Dark(), iterations=8, shown=3, learning_rate=0.6)
    result = make_method("clip_guided", options).fit(fragile, Budget(100.0))
    failed = [each.objective == float("inf") for each in result.evaluations]
    at = failed.index(True)
    before, there, after = (find_push(each.force_field) for each in result.evaluations[at - 1 : at + 2])
    np.testing.assert_allclose(after, 0.5 * (before + there), atol=1e-6)
    assert not all(failed[at:])


def test_a_failed_simulation_has_no_slope(tiny, encoder):
    def build(force_field):
        raise UserError("it tears")

    evaluator = Evaluator(dataclasses.replace(tiny, build=build), Budget(10), oracle=False)
    value, gradient = evaluator.differentiate_pictures(tiny.start, make_loss(encoder), [0])
    assert math.isinf(value) and not np.any(gradient.actions[0].vector)
    assert evaluator.spent == 1 and evaluator.evaluations[-1].objective == float("inf")


def test_what_cannot_be_done_is_refused(tiny, tmp_path):
    with pytest.raises(UserError, match="needs a CLIP model"):
        make_method("clip_guided").fit(tiny, Budget(10))
    with pytest.raises(UserError, match="`learning_rate`"):
        make_method("clip_guided", dict(learning_rate=0))
    with pytest.raises(UserError, match="at least 1"):
        make_method("clip_guided", dict(shown=1))
    with pytest.raises(UserError, match="holds no CLIP model"):
        make_method("clip_guided", dict(clip=str(tmp_path))).fit(tiny, Budget(10))
