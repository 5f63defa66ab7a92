"""The methods of score distillation, led by priors whose wish is known; and what is compared with the truth."""

import dataclasses
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from baselines.evaluation import GRADIENT_COST, Evaluator
from baselines.methods import make_method
from baselines.methods.sds_choice import Choice
from baselines.methods.sds_steps import PUBLISHED_STEP
from baselines.protocol import Budget
from baselines.scores import Cost
from baselines.scores.compare import compare_with_truth, summarise
from baselines.starts import KINDS
from baselines.truncation import Truncation
from benchmarks import distillation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from tests.baselines.tiny import act

WISHES = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "up": (0.0, -1.0)}


@dataclasses.dataclass
class Wish:
    """Wants what is dark (the object, on white) on one side of the picture: a loss that is linear in the pixels."""

    side: str = "left"
    noise: float = 0.0
    name: str = "wish"
    toy: bool = True
    licence: str = "none"
    cost: Cost = dataclasses.field(default_factory=Cost)
    seen: list = dataclasses.field(default_factory=list)
    keys: list = dataclasses.field(default_factory=list)

    def gradient(self, video, prompt, key, *, still=None):
        self.cost.calls += 2
        self.seen.append((video.shape, prompt, None if still is None else still.shape))
        self.keys.append(key)
        across, down = WISHES[self.side]
        rows, columns = np.indices(video.shape[1:3])
        wish = across * (columns / video.shape[2] - 0.5) + down * (rows / video.shape[1] - 0.5)
        wanted = np.broadcast_to(wish[None, ..., None], video.shape).astype(np.float32)
        return wanted + self.noise * np.random.default_rng(key).normal(size=video.shape).astype(np.float32)


def fit(name, task, budget=60.0, seed=0, **options):
    return make_method(name, options).fit(task, Budget(budget), seed)


def find_push(result):
    (action,) = result.incumbent_at().actions
    return action.magnitude * np.asarray(action.vector)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("sds_last_substep", dict(shown=4)),
        pytest.param("sds_whole_clip", dict(learning_rate=0.5), marks=pytest.mark.slow),
    ],
)
def test_steps_push_where_the_prior_wishes(tiny, name, options):
    """The camera looks along +y: left is -x. The start pushes to the right."""
    prior = Wish("left")
    result = fit(name, tiny, prior=prior, iterations=6, **options)
    push = find_push(result)
    assert tiny.start.actions[0].vector[0] > 0 and push[0] < -0.5
    assert not result.oracle and result.model_calls == prior.cost.calls == 12
    assert [each.objective for each in result.evaluations] == sorted(
        (each.objective for each in result.evaluations), reverse=True
    )
    assert result.incumbent_at() == result.evaluations[-1].force_field
    cost = 1 + (1 if name == "sds_last_substep" else GRADIENT_COST)
    assert result.spent == pytest.approx(6 * cost + 1)


def test_the_published_schedule_shows_every_other_frame_in_turn_and_steps_by_a_fixed_length(tiny):
    prior = Wish("up")
    result = fit("sds_last_substep", tiny, prior=prior, iterations=3, shown=4)
    assert [shape[0] for shape, _, _ in prior.seen] == [4, 4, 4]  # of 8 frames
    assert all(prompt == tiny.spec.sentence for _, prompt, _ in prior.seen)
    assert all(still == shape for shape, _, still in prior.seen)
    first, second = (
        np.asarray(each.force_field.actions[0].vector) * each.force_field.actions[0].magnitude
        for each in result.evaluations[:2]
    )
    assert np.abs(second - first).max() == pytest.approx(PUBLISHED_STEP * 3.2, rel=1e-5)
    assert second[2] > first[2] + 0.5


@pytest.mark.slow
def test_sds_choice_moves_the_vector_by_stages(tiny):
    prior = Wish("left")
    result = fit(
        "sds_choice", tiny, prior=prior, stages=2, inner=2, epochs=1, learning_rate=0.5, logit_rate=0.0
    )
    push = find_push(result)
    assert push[0] < -0.3 and result.incumbent_at().actions[0].action_type == "translation"
    assert [shape[0] for shape, _, _ in prior.seen] == [5, 5, 4, 4]  # frames 0 to 4, then 4 to 7
    stage = Truncation(first=4).count_cost(8, GRADIENT_COST)
    assert result.spent == pytest.approx(2 * (1 + GRADIENT_COST) + 2 * (1 + stage) + 1)


@pytest.mark.slow
def test_sds_choice_leaves_a_skill_that_goes_against_the_wish(tiny):
    """A push to the right cannot please who wants it left while its vector stays: another skill must act."""
    options = dict(stages=1, inner=8, epochs=1, learning_rate=1e-6, logit_rate=0.3, preference=0.5)
    result = fit("sds_choice", tiny, budget=100, prior=Wish("left"), **options)
    assert result.evaluations[0].force_field.actions[0].action_type == "translation"
    assert result.incumbent_at().actions[0].action_type not in ("translation", "impulse")
    # With the wish reversed the push is right and stays.
    result = fit("sds_choice", tiny, budget=100, prior=Wish("right"), **options)
    assert result.incumbent_at().actions[0].action_type in ("translation", "impulse")


def test_the_straight_through_gradient_is_that_of_a_softmax():
    rng = np.random.default_rng(0)
    choice = Choice(ForceField(), rng.normal(size=(2, 3)), rng.normal(size=(2, len(KINDS))))
    by_weights = rng.normal(size=choice.logits.shape)
    wanted = jax.grad(lambda logits: (jax.nn.softmax(logits, axis=1) * by_weights).sum())(
        jnp.asarray(choice.logits)
    )
    assert np.allclose(choice.pull_weights(by_weights), wanted, atol=1e-6)


def test_each_other_skill_takes_one_place_and_has_its_own_weight():
    """Of two actions, at one of which another skill acts, all else being the same."""
    start = act("impulse", (0, 0, 2), 1.2)
    start = start.model_copy(update=dict(actions=(*start.actions, *act("scale", (1, 0, 0), -0.9).actions)))
    choice = Choice.of(start, 0.5)
    field, others = choice.decode(8), choice.list_others(8)
    assert [each.action_type for each in field.actions] == ["impulse", "scale"]
    by_weights = choice.place_weights(1.0 + np.arange(len(others)))
    assert len(others) == 2 * (len(KINDS) - 1)
    for weight, other in enumerate(others, 1):
        ((index, kind),) = np.argwhere(by_weights == weight)
        skill, sign = KINDS[kind]
        changed = other.actions[index]
        assert changed.action_type is skill and np.sign(changed.magnitude) == sign
        assert (
            changed.action_type != field.actions[index].action_type
            or sign > 0 > field.actions[index].magnitude
        )
        assert abs(changed.magnitude) == pytest.approx(abs(field.actions[index].magnitude))
        assert other.actions[1 - index] == field.actions[1 - index]
    assert (by_weights[np.arange(2), choice.chosen] == 0).all()


def test_a_pull_begins_as_the_push_that_it_is():
    field = Choice.of(act("translation", (1, 0, 0), -1.1), 0.5).decode(8)
    assert field.actions[0].magnitude * field.actions[0].vector[0] == pytest.approx(-1.1)
    field = Choice.of(act("scale", (1, 0, 0), -1.1), 0.5).decode(8)
    assert field.actions[0].magnitude == pytest.approx(-1.1) and field.actions[0].vector[0] == 1


@pytest.mark.parametrize("name", ["sds_last_substep", pytest.param("sds_choice", marks=pytest.mark.slow)])
def test_a_seed_and_a_budget_are_kept_to(tiny, name):
    options = dict(iterations=2) if name == "sds_last_substep" else dict(stages=1, inner=2, epochs=1)
    runs = [fit(name, tiny, seed=seed, prior=Wish(noise=1.0), **options) for seed in (1, 1, 2)]
    tried = [[each.force_field for each in run.evaluations] for run in runs]
    assert tried[0] == tried[1] != tried[2]
    prior = Wish()
    short = fit(name, tiny, budget=4.0, prior=prior)
    assert short.spent < 4.0 + GRADIENT_COST and len(set(prior.keys)) == len(prior.keys)


@pytest.mark.parametrize("name", ["sds_last_substep", "sds_choice"])
def test_the_target_is_never_read(tiny, name):
    """With a target that cannot be measured, everything is as before."""
    blind = dataclasses.replace(
        tiny, target=None, spec=SimpleNamespace(name="blind", sentence="push it to the left")
    )
    options = dict(iterations=2) if name == "sds_last_substep" else dict(stages=1, inner=2, epochs=1)
    runs = [fit(name, task, prior=Wish(), **options) for task in (tiny, blind)]
    assert [each.force_field for each in runs[0].evaluations] == [
        each.force_field for each in runs[1].evaluations
    ]


@pytest.mark.parametrize("name", ["sds_last_substep", "sds_choice"])
def test_what_cannot_be_done_is_refused(tiny, name):
    with pytest.raises(UserError, match="needs the weights"):
        fit(name, tiny)
    with pytest.raises(UserError, match="prior cannot tell"):
        make_method(name, dict(types="enumerated"))
    still = dataclasses.replace(tiny, start=ForceField())
    with pytest.raises(UserError, match="no action"):
        fit(name, still, prior=Wish())


@pytest.mark.slow
def test_a_step_that_fails_is_halved(tiny):
    built = tiny.build

    def build(force_field):
        if force_field.actions[0].vector[0] < -0.2:
            raise UserError("it tears")
        return built(force_field)

    fragile = dataclasses.replace(tiny, build=build)
    result = fit("sds_whole_clip", fragile, prior=Wish("left"), iterations=8, learning_rate=0.6)
    assert any(each.objective == float("inf") for each in result.evaluations)
    assert built(result.incumbent_at()) and result.incumbent_at().actions[0].vector[0] >= -0.2


def test_comparison_with_the_truth(tiny):
    """A prior that wishes what the hidden push does agrees with the truth; the opposite wish does not."""
    left, right = (
        compare_with_truth(tiny, tiny.start, Wish(side, 0.05), draws=4) for side in ("left", "right")
    )
    assert left.cosine > 0.5 and right.cosine < -0.5
    assert left.draws == 4 and left.cosines.shape == (4,) and left.variance.shape == (3,)
    assert left.share_downhill == 1 and left.signal_to_noise > 1


def test_the_benchmark_of_distillation_tells_a_prior_that_agrees_from_one_that_does_not(tiny):
    named = dataclasses.replace(
        tiny, spec=SimpleNamespace(name="tiny", family="push", sentence="push it left")
    )
    rows = []
    for side in ("left", "right"):
        made = distillation.compare(named, lambda _, side=side: Wish(side, name=side), places=1, draws=2)
        rows += made
    assert [row["setting"] for row in rows] == 2 * list(distillation.SETTINGS)
    whole = [row["cosine"] for row in rows if row["setting"] == "whole clip"]
    assert whole[0] > 0.5 and whole[1] < -0.5
    tables = distillation.write_tables({"cosines": {"runs": [], "complete": True, "rows": rows}})
    page = tables["cosines"]
    agreeing, opposed = page.split("## Right: whole clip\n")
    assert "| push | 1 |" in agreeing and "| 100% | 100% |" in agreeing.split("## Left: whole clip\n")[1]
    assert "| 0% | 0% |" in opposed.split("##")[0]


def test_comparison_s_figures():
    rng = np.random.default_rng(0)
    true, spread = np.array([3.0, 0.0, 4.0]), np.array([0.5, 1.0, 2.0])
    gradients = true / 5 + spread * rng.normal(size=(4000, 3))
    found = summarise(Wish(), gradients, true)
    assert found.cosine == pytest.approx(1, abs=0.02)
    assert np.allclose(found.variance, spread**2, rtol=0.1)
    assert found.signal_to_noise == pytest.approx(1 / 5.25, rel=0.2)
    assert 0.5 < found.share_downhill < 0.9
    with pytest.raises(UserError, match="no direction"):
        summarise(Wish(), np.zeros((3, 3)), true)


def test_a_method_without_the_truth_cannot_ask_for_it(tiny):
    evaluator = Evaluator(tiny, Budget(10), oracle=make_method("sds_last_substep").oracle)
    with pytest.raises(UserError, match="not marked as an oracle"):
        evaluator.score(tiny.start)
