"""Sentences of several steps: a verdict on each, rounds ranked by them, and rewrites that leave what was met alone."""

import pytest

from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import Action, ForceField, HalfSpaceRegion
from physagent_jax.motion.judging.progress import PATIENCE, find_best_round, has_stalled
from physagent_jax.motion.schema import ExpectedMotion, Judgement, MotionKind, Stage, StageVerdict, Verdict
from tests.agents.scenes import brief, judge, make_report, ramp, rewrite
from tests.agents.toy_world import ToyWorld, loop

LEFT, RIGHT, UP, DOWN = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
LAST = 120
SCENE = brief(frame_count=LAST + 1)
PROMPT = "push it left, then spin it, then push it down"
STEPS = (
    ExpectedMotion(kind=MotionKind.MOVE, direction=LEFT, window=(0, 40), words="push it left"),
    ExpectedMotion(kind=MotionKind.ROTATE, direction=UP, window=(40, 80), words="spin it"),
    ExpectedMotion(kind=MotionKind.MOVE, direction=DOWN, window=(80, LAST), words="push it down"),
)
FIELD = ForceField(
    actions=(
        Action(action_type="translation", vector=LEFT, magnitude=1.0, active_time=(0, 40)),
        Action(action_type="torque", vector=UP, magnitude=1.0, active_time=(40, 80)),
        Action(action_type="translation", vector=DOWN, magnitude=1.0, active_time=(80, LAST)),
    )
)
READING = SemanticReply(force_field=FIELD, expectations=STEPS)


def show(left=0.5, spin=90.0, down=0.5, **options):
    """A report of the three steps: distances [body lengths] and the angle [deg]."""
    frames = range(LAST + 1)
    places = [(-left * ramp(t, 0, 40), 0.0, -down * ramp(t, 80, LAST)) for t in frames]
    turns = [(0.0, 0.0, spin * ramp(t, 40, 80)) for t in frames]
    return make_report(places, turns, windows=[(0, 40), (40, 80), (80, LAST)], **options)


def judged(seen, field=FIELD):
    return judge(PROMPT, READING, seen, SCENE, field)


def verdicts(round_) -> list[str]:
    return [stage.verdict.value for stage in round_.judgement.stages]


def test_every_stage_has_a_verdict_of_its_own_in_order():
    assert verdicts(judged(show())) == ["met", "met", "met"]
    judgement = judged(show(spin=4.0)).judgement
    assert [stage.verdict.value for stage in judgement.stages] == ["met", "not met", "met"]
    assert [stage.words for stage in judgement.stages] == ["push it left", "spin it", "push it down"]
    assert [stage.window for stage in judgement.stages] == [(0, 40), (40, 80), (80, LAST)]
    failed = judgement.stages[1]
    assert failed.asked == "how far does it turn? 20 to 260 degrees" and "4 degrees" in failed.measured
    assert failed.misfit > 0.5 and judgement.stages[0].misfit == judgement.stages[2].misfit == 0.0
    assert judgement.verdict is Verdict.FAIL and "Stage 2 of 3" in judgement.suggestion


def test_the_values_of_a_met_stage_are_told_too():
    stage = judged(show(left=0.5)).judgement.stages[0]
    assert stage.asked == "how far does it move? 0.25 to 1.3 body lengths"
    assert stage.measured == "0.5 body lengths that way"


def test_what_cannot_be_seen_is_not_seen_and_no_success():
    places = [(-0.5 * ramp(t, 0, 40), 0.0, 0.0) if t < 79 else None for t in range(LAST + 1)]
    turns = [(0.0, 0.0, 90.0 * ramp(t, 40, 80)) for t in range(LAST + 1)]
    round_ = judged(make_report(places, turns, windows=[(0, 40), (40, 80), (80, LAST)]))
    assert verdicts(round_)[::2] == ["met", "not seen"]
    assert round_.judgement.verdict is Verdict.FAIL


def test_motions_that_begin_together_are_one_stage():
    together = (STEPS[0], STEPS[1].model_copy(update={"window": (0.0, 40.0)}), STEPS[2])
    reading = SemanticReply(force_field=FIELD, expectations=together)
    stages = judge(PROMPT, reading, show(), SCENE).judgement.stages
    assert [stage.expectations for stage in stages] == [(0, 1), (2,)]
    assert stages[0].words == "push it left and spin it"


def test_stages_are_in_the_order_of_time_not_of_the_words():
    """'Before it falls, push it left': what is named first happens last."""
    reading = SemanticReply(force_field=FIELD, expectations=STEPS[::-1])
    stages = judge(PROMPT, reading, show(), SCENE).judgement.stages
    assert [stage.expectations for stage in stages] == [(2,), (1,), (0,)]


def test_what_nobody_asked_for_belongs_to_the_stage_in_which_it_begins():
    """It slips aside while it is spun: the push before it is met."""
    places = [
        (-0.5 * ramp(t, 0, 40), 1.0 * ramp(t, 40, 80), -0.5 * ramp(t, 80, LAST)) for t in range(LAST + 1)
    ]
    turns = [(0.0, 0.0, 90.0 * ramp(t, 40, 80)) for t in range(LAST + 1)]
    round_ = judged(make_report(places, turns, windows=[(0, 40), (40, 80), (80, LAST)]))
    aside = next(check for check in round_.judgement.checks if "nobody asked" in check.question)
    assert aside.passed is False and aside.expectation == 1
    assert verdicts(round_)[0] == "met" and verdicts(round_)[1] == "not met"


def test_leaving_the_picture_belongs_to_a_motion_that_travels():
    round_ = judged(show(leaves_frame=60))
    (check,) = [c for c in round_.judgement.checks if c.question == "does it stay in the picture?"]
    assert check.passed is False and check.expectation == 0


def test_a_rewrite_leaves_the_stages_that_were_met_as_they_are():
    answer = rewrite(PROMPT, READING, judged(show(spin=10.0)), SCENE)
    before, after = FIELD.actions, answer.force_field.actions
    assert (after[0], after[2]) == (before[0], before[2])
    assert after[1].magnitude > before[1].magnitude and after[1].vector == before[1].vector


@pytest.mark.parametrize(
    "shown", [{"left": 0.05}, {"spin": 5.0}, {"down": 0.05}, {"left": 3.0}, {"down": 3.0}]
)
def test_only_the_failed_stage_is_rewritten_however_often(shown):
    """Round after round with the same failure: the entries of the other stages stay, bit for bit."""
    rounds, field = [], FIELD
    failed = ("left", "spin", "down").index(next(iter(shown)))
    met = [action for i, action in enumerate(FIELD.actions) if i != failed]
    for _ in range(5):
        rounds.append(judged(show(**shown), field))
        assert verdicts(rounds[-1])[failed] == "not met"
        assert verdicts(rounds[-1]).count("met") == 2
        answer = rewrite(PROMPT, READING, rounds[-1], SCENE, rounds[:-1])
        field = answer.force_field
        assert all(action in field.actions for action in met), answer.changes


def test_a_cause_that_reaches_into_the_next_stage_belongs_to_its_own():
    """Two pushes the same way, of which the first ends late: it is not made stronger for the second's sake."""
    steps = (STEPS[0], STEPS[0].model_copy(update={"window": (60.0, 120.0), "words": "then far to the left"}))
    early = Action(action_type="translation", vector=LEFT, magnitude=0.7, active_time=(0, 65))
    late = Action(action_type="translation", vector=LEFT, magnitude=0.7, active_time=(60, 120))
    reading = SemanticReply(force_field=ForceField(actions=(early, late)), expectations=steps)
    places = [(-0.5 * ramp(t, 0, 40) - 0.08 * ramp(t, 60, LAST), 0.0, 0.0) for t in range(LAST + 1)]
    failed = judge("", reading, make_report(places, windows=[(0, 40), (60, LAST)]), SCENE)
    assert verdicts(failed) == ["met", "not met"]
    answer = rewrite("", reading, failed, SCENE)
    one, two = answer.force_field.actions
    assert one == early and two.magnitude > late.magnitude
    assert "stays as it was" in answer.changes[0]


def test_one_cause_of_two_stages_is_changed_for_the_one_that_failed():
    """There is nothing else to change."""
    steps = (STEPS[0], STEPS[0].model_copy(update={"window": (60.0, 120.0), "words": "then far to the left"}))
    whole = Action(action_type="translation", vector=LEFT, magnitude=0.7, active_time=(0, 120))
    reading = SemanticReply(force_field=ForceField(actions=(whole,)), expectations=steps)
    places = [(-0.5 * ramp(t, 0, 40) - 0.08 * ramp(t, 60, LAST), 0.0, 0.0) for t in range(LAST + 1)]
    failed = judge("", reading, make_report(places, windows=[(0, 40), (60, LAST)]), SCENE)
    assert rewrite("", reading, failed, SCENE).force_field.actions != (whole,)


def test_the_loop_mends_one_stage_and_keeps_the_others():
    """End to end in the toy world: the spin is far too weak, the pushes are right from the first round."""
    world = ToyWorld(SCENE, gain=3.0)
    weak = FIELD.actions[1].model_copy(update={"magnitude": 0.4})
    field = FIELD.model_copy(update={"actions": (FIELD.actions[0], weak, FIELD.actions[2])})
    rounds = loop(field, STEPS, world, 3, PROMPT)
    assert [stage.verdict.value for stage in rounds[0][1].stages] == ["met", "not met", "met"]
    assert rounds[-1][1].verdict is Verdict.SUCCESS and len(rounds) > 1
    for tried, _ in rounds:
        assert (tried.actions[0], tried.actions[2]) == (FIELD.actions[0], FIELD.actions[2])


def scored(score, *met, misfits=None, verdict="FAIL"):
    told = misfits or [0.0 if each else 0.5 for each in met]
    return Judgement(
        verdict=verdict,
        score=score,
        stages=tuple(
            Stage(
                expectations=(i,), window=(i, i + 1), misfit=misfit,
                verdict=StageVerdict.MET if each else StageVerdict.NOT_MET,
            )
            for i, (each, misfit) in enumerate(zip(met, told))
        ),
    )  # fmt: skip


def test_the_best_round_has_most_stages_met():
    assert find_best_round([scored(0.9, True, False, False), scored(0.8, True, True, False)]) == 1
    assert find_best_round([scored(0.8, True, False), scored(0.9, True, False)]) == 1
    assert find_best_round([scored(0.9, True, False), scored(0.9, False, True)]) == 0


def test_the_executor_goes_out_from_the_round_with_most_stages_met():
    """The last round broke a stage that was met before, though its score is higher."""
    first = judged(show(spin=10.0))
    louder = FIELD.actions[0].model_copy(update={"magnitude": 1.6})
    field = FIELD.model_copy(update={"actions": (louder, *FIELD.actions[1:])})
    last = judged(show(left=1.35, spin=19.9), field)
    assert first.judgement.stages_met == 2 and last.judgement.stages_met == 1
    assert (last.judgement.score or 0) > (first.judgement.score or 0)
    answer = rewrite(PROMPT, READING, last, SCENE, [first])
    assert answer.force_field.actions[0] == FIELD.actions[0]
    assert "the best round" in answer.changes[0]


def test_a_run_stalls_after_rounds_without_improvement():
    worst, worse, bad = scored(0.5, False), scored(0.6, False), scored(0.7, False)
    assert not has_stalled([worst, worst])
    assert has_stalled([worst, worst, worst]) and has_stalled([bad, worst, worse])
    assert not has_stalled([worst, worst, worse]) and not has_stalled([worst, worse, worse])
    assert has_stalled([worst, worse, worse, worse])


def test_one_stage_more_is_an_improvement_and_one_less_is_none():
    one, two = scored(0.9, True, False), scored(0.8, True, True)
    assert not has_stalled([one, one, two])
    assert has_stalled([two, one, one])


def test_a_smaller_misfit_of_the_stages_is_an_improvement_though_the_score_is_lower():
    far, near = scored(0.8, False, misfits=[0.6]), scored(0.79, False, misfits=[0.3])
    assert not has_stalled([far, far, near])
    assert has_stalled([far] * (PATIENCE + 1))


def test_a_planner_without_scores_never_stalls():
    assert not has_stalled([Judgement(verdict="FAIL")] * 10)


# --- parts -------------------------------------------------------------------------------------------------

HEAD = ExpectedMotion(
    kind=MotionKind.MOVE, direction=LEFT, part=UP, partial=True, window=(0, 60), words="push the head left"
)
BASE = ExpectedMotion(
    kind=MotionKind.MOVE, direction=RIGHT, part=DOWN, partial=True, window=(60, LAST), words="the base right"
)


def show_ends(top, bottom):
    """A report whose ends move apart, each as far to the right as its function of the frame says."""
    middle = [(0.5 * (top(t) + bottom(t)), 0.0, 0.0) for t in range(LAST + 1)]
    seen = make_report(middle, windows=[(0, 60), (60, LAST)])
    ends = []
    for end in seen.parts:
        way = {1: top, -1: bottom}.get(round(end.direction[2]), lambda t: 0.5 * (top(t) + bottom(t)))
        ends.append(
            end.model_copy(
                update={"centroid": tuple((way(t), 0.0, 0.0) for t in range(LAST + 1)), "rotation": ()}
            )
        )
    return seen.model_copy(update={"parts": tuple(ends)})


def judge_parts(seen, expectations=(HEAD, BASE)):
    reading = SemanticReply(force_field=ForceField(), expectations=expectations)
    return judge("push the head left, then the base right", reading, seen, SCENE)


def test_every_stage_is_judged_by_the_part_that_it_is_about():
    head, base = lambda t: -0.4 * ramp(t, 0, 60), lambda t: 0.4 * ramp(t, 60, LAST)
    assert verdicts(judge_parts(show_ends(head, base))) == ["met", "met"]
    assert verdicts(judge_parts(show_ends(base, head))) == ["not met", "not met"]  # the other end each time
    still = judge_parts(show_ends(head, lambda t: 0.0))
    assert verdicts(still) == ["met", "not met"] and "0 body lengths" in still.judgement.stages[1].measured


def test_a_whole_that_moves_is_no_part_that_moves():
    both = lambda t: -0.4 * ramp(t, 0, 60) + 0.4 * ramp(t, 60, LAST)  # noqa: E731
    round_ = judge_parts(show_ends(both, both))
    assert verdicts(round_) == ["not met", "not met"]
    assert {check.aspect for check in round_.judgement.checks if check.passed is False} == {"part"}


def test_ends_that_are_not_told_apart_are_not_seen():
    seen = show_ends(lambda t: 0.0, lambda t: 0.0).model_copy(update={"parts": ()})
    assert verdicts(judge_parts(seen))[0] == "not seen"


def test_what_is_added_for_a_part_acts_on_that_part():
    """Nothing caused the second stage: the action that is added pushes the base, not the whole."""
    top = HalfSpaceRegion(point=(0.5, 0.5, 0.7), normal=UP)
    push = Action(action_type="translation", vector=LEFT, magnitude=0.8, active_time=(0, 60), region=top)
    field = ForceField(actions=(push,))
    reading = SemanticReply(force_field=field, expectations=(HEAD, BASE))
    seen = show_ends(lambda t: -0.4 * ramp(t, 0, 60), lambda t: 0.0)
    answer = rewrite("", reading, judge("", reading, seen, SCENE, field), SCENE)
    first, second = answer.force_field.actions
    assert first == push
    assert second.region is not None and second.region.normal == DOWN and second.vector == RIGHT


def test_a_push_of_the_whole_is_bounded_to_the_part_that_was_meant():
    whole = Action(action_type="translation", vector=LEFT, magnitude=0.8, active_time=(0, 60))
    field = ForceField(actions=(whole,))
    reading = SemanticReply(force_field=field, expectations=(HEAD,))
    way = lambda t: -0.4 * ramp(t, 0, 60)  # noqa: E731
    answer = rewrite("", reading, judge("", reading, show_ends(way, way), SCENE, field), SCENE)
    (action,) = answer.force_field.actions
    assert action == whole.model_copy(update={"region": action.region})
    assert action.region is not None and action.region.normal == UP


def test_rewrites_of_stages_stay_inside_the_hard_rules():
    answer = rewrite(PROMPT, READING, judged(show(spin=4.0, down=0.05)), SCENE)
    assert apply_hard_rules(answer.force_field, SCENE, STEPS)[0] == answer.force_field
