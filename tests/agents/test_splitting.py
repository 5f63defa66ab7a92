"""Splitting in halves: how a sentence says so, that the halves come apart, and when."""

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.forces.pairs import find_pairs
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ConstraintType
from physagent_jax.metrics import report_true_motion
from physagent_jax.motion.schema import Verdict
from tests.agents.scenes import Unseen, brief
from tests.agents.test_limbs import read

PLAIN = dict(world="ground", object_name="melon", object_kind="object", parts=(), frames_fixed=False)


def read_whole(sentence):
    """The reply to a sentence about an object without parts."""
    about = brief(**PLAIN)
    return compile_intent(read_intent(sentence, about), about)


@pytest.mark.parametrize(
    "sentence",
    [
        "the melon splits in half",
        "the melon breaks in two",
        "the melon cracks in two halves",
        "the melon snaps in two",
        "it splits open down the middle and the two halves fall apart to the left and right",
        "the melon comes apart in two halves and they roll away",
        "tear the melon in two",
    ],
)
def test_halves_are_led_apart_as_pieces_of_their_own_and_let_go(sentence):
    """It was of brittle matter instead, and fell to pieces where it stood."""
    reply = read_whole(sentence)
    one, other = reply.force_field.constraints
    assert not reply.force_field.actions and not reply.unsure and not reply.materials
    for made in (one, other):
        assert made.constraint_type is ConstraintType.PARTICLE_TRANSLATION and made.held_until is None
        assert made.region.rigid and made.active_time[0] == 0 and made.active_time[1] <= 12
    assert np.dot(one.vector, other.vector) == pytest.approx(-1)
    assert one.region.inside == other.region.outside
    assert [each.manner for each in reply.expectations] == ["split"]


@pytest.mark.parametrize(
    "before", ["drops to the floor and bounces twice", "spins around once", "slides to the left"]
)
def test_what_splits_after_something_else_is_whole_until_then(before):
    reply = read_whole(f"the melon {before}, and then it splits open down the middle")
    first, second = reply.expectations[0], reply.expectations[-1]
    halves = [each for each in reply.force_field.constraints if each.region is not None]
    assert second.manner == "split" and not reply.materials
    assert len(halves) == 2 and all(each.active_time[0] >= first.window[1] > 10 for each in halves)


def test_a_part_that_breaks_in_two_comes_off_all_the_same():
    (motion,) = read("its head breaks in two", world="ground").expectations
    assert motion.manner == "detach" and motion.limb == 2


@pytest.mark.parametrize(("apart", "verdict"), [(0.3, "SUCCESS"), (0.02, "FAIL")])
def test_what_has_split_lies_in_two_halves_in_the_end(apart, verdict):
    """A thing that is only drawn out comes back."""
    sentence, scene = "the melon splits in half", brief(**PLAIN)
    reply = read_whole(sentence)
    ball = np.random.default_rng(0).uniform(-0.5, 0.5, (800, 3))
    way = np.sign(ball[:, :1]) * (1.0, 0.0, 0.0)
    frames = [
        ball + 0.2 * np.sin(min(t / 10, 1) * np.pi) * way + min(t / 20, 1) * apart * way for t in range(49)
    ]
    context = AgentContext(sentence, scene, (), reply)
    report = report_true_motion(np.stack(frames), frame_dt=0.04, windows=RulePlanner().windows(context))
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert judged.verdict is Verdict(verdict), judged.checks


def test_two_halves_are_no_two_ends_of_what_is_drawn_out():
    """Between two ends all follows in proportion; between two halves, it tears."""
    field = read_whole("the melon splits in half").force_field
    soft = [
        each.model_copy(update=dict(region=each.region.model_copy(update=dict(rigid=False))))
        for each in field.constraints
    ]
    rest = np.random.default_rng(0).uniform(0, 1, (500, 3))
    scaling = make_closed_form_scaling(extent=1.0, youngs_modulus=1e5, density=1e3, duration=2.0)
    drawn = field.model_copy(update=dict(constraints=tuple(soft)))
    assert not find_pairs(field, scaling, rest) and len(find_pairs(drawn, scaling, rest)) == 1
