"""The offline executor: remedies for what failed, and the closed loop in a toy world."""

import pytest

from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.agents.rules.remedies import list_remedies
from physagent_jax.forces.schema import ActionType, ConstraintType, ForceField
from physagent_jax.motion.edits import Case
from physagent_jax.motion.matching import list_causes
from physagent_jax.motion.schema import Verdict
from tests.agents.scenes import asked, brief, judge, make_report, read, rewrite, seen_in
from tests.agents.sentences import SENTENCES
from tests.agents.toy_world import ToyWorld, loop

LEFT, RIGHT = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
SWALLOWED = {  # this world's gravity overcomes any blow upwards, and no rule may switch it off
    "a sudden jolt from below makes the robot jump",
    "the robot jumps to the right",
    "throw the ball into the air",
    "jump",
    "The object rises slowly, spins twice and falls to the ground.",
    # The same of rebounds: the blows that throw it up again do not lift it off this ground.
    "it bounces",
    "the ball falls and bounces",
    "the ball is thrown to the left and bounces",
}
UNSEEN = {  # parts against each other: the report measures the whole object
    "twist the loaf",
    "wring the towel",
    "twist the top to the left and the bottom to the right",
    "push the upper half to the left and the lower half to the right",
    "push the left side to the right and the right side to the left",
}


TOO_SHORT = {  # so many actions in two seconds that three rounds are not enough for all of them
    "twist it half a turn",
    "The vase is twisted by an invisible force, first to the left, then to the right.",
    "the object is severely compressed, violently twisted, and then rebounds",
    "first push it left, then lift it, then twist it, finally let it go",
    "the robot is thrown up, spins, and lands",
    "slide it to the right for half a second, then wait, then slide it back",
    "raise the robot for half a second and then lower it",
    "The object rises slowly, spins twice and falls to the ground.",
}


def rewritten(prompt, field: ForceField | None = None, scene=None, history=(), **motion):
    """The rewrite after a report that shows ``motion``, and the round that it mends."""
    scene = scene or brief()
    reply = read(prompt, scene)
    seen = seen_in(reply.expectations, scene.frame_count, **motion)
    failed = judge(prompt, reply, seen, scene, field)
    assert failed.judgement.verdict is Verdict.FAIL
    return rewrite(prompt, reply, failed, scene, history), failed


def with_magnitude(prompt: str, magnitude: float, **changes) -> ForceField:
    field = read(prompt).force_field
    action = field.actions[0].model_copy(update={"magnitude": magnitude} | changes)
    return field.model_copy(update={"actions": (action,)})


def test_too_weak_becomes_stronger():
    """The magnitude grows by the planner's gain, the vector stays."""
    answer, _ = rewritten("push it left", displacement=(-0.2, 0, 0))
    (action,) = answer.force_field.actions
    assert (action.vector, action.magnitude) == (LEFT, 1.6)
    answer, failed = rewritten("push it gently left", displacement=(-0.07, 0, 0))
    gain = next(check.gain for check in failed.judgement.checks if check.gain)
    assert answer.force_field.actions[0].magnitude == pytest.approx(0.5 * gain, abs=1e-4) and gain > 2
    assert "becomes 1.3" in answer.changes[0] and answer.rules_applied == ("magnitude_range",)


def test_too_strong_becomes_weaker():
    """And shrinks by it."""
    answer, _ = rewritten("push it left", displacement=(-2.5, 0, 0))
    assert answer.force_field.actions[0].magnitude == pytest.approx(0.4)


def test_wrong_way_is_reversed_by_the_sign():
    """The vector is immutable: a contrary action gets the opposite sign."""
    answer, _ = rewritten("push it left", read("push it right").force_field, displacement=(1.0, 0, 0))
    (action,) = answer.force_field.actions
    assert (action.vector, action.magnitude) == (RIGHT, -1.0)
    assert "sentence_direction" in answer.rules_applied


def test_other_direction_is_replaced_by_the_mapping():
    """An action across the sentence's direction gets the mapped vector."""
    answer, _ = rewritten("push it left", read("push it up").force_field, displacement=(0, 0, 1.0))
    assert answer.force_field.actions[0].vector == LEFT


def test_the_fixed_mapping_wins_over_what_is_seen():
    """An action that points as the sentence says is never turned round, whatever is seen."""
    answer, _ = rewritten("push it left", displacement=(0.5, 0, 0))
    (action,) = answer.force_field.actions
    assert action.vector == LEFT and action.magnitude == 1.6


@pytest.mark.parametrize(
    ("prompt", "wrong", "right"),
    [("spin it", "push it left", "enforce_particle_rotation"), ("push it left", "spin it", "translation"),
     ("stretch it", "push it left", "enforce_particle_translation"), ("kick it left", "squeeze it", "impulse")],
)  # fmt: skip
def test_wrong_kind_is_a_discrete_leap(prompt, wrong, right):
    """An action that cannot have the effect becomes the skill that has it."""
    answer, _ = rewritten(prompt, read(wrong).force_field)
    causes = list_causes(answer.force_field)
    assert {cause.skill.name for cause in causes} == {right}
    assert causes[0].item.vector == read(prompt).force_field.actions[0].vector


def test_missing_action_is_added():
    """A motion that nothing causes gets its action; gravity is switched on for a fall."""
    answer, _ = rewritten("push it left", ForceField())
    assert answer.force_field.actions[0].vector == LEFT
    answer, _ = rewritten("drop it", ForceField())
    assert answer.force_field.default_drop


def test_unwanted_motion_is_removed():
    """Stillness: gravity off, actions gone."""
    answer, _ = rewritten("the robot stands still", read("push it left").force_field, displacement=(-1, 0, 0))
    assert answer.force_field.actions == ()
    answer, _ = rewritten("the robot stands still", ForceField(default_drop=True), displacement=(0, 0, -1))
    assert not answer.force_field.default_drop


def test_saturated_stretch_becomes_exactly_two_opposed_constraints():
    """The pair is symmetric: opposite vectors, mirrored end slabs, one magnitude, one window."""
    prompt = "stretch it along its height"
    answer, _ = rewritten(prompt, with_magnitude(prompt, 1.6))
    assert answer.force_field.actions == ()
    one, two = answer.force_field.constraints
    assert {one.constraint_type, two.constraint_type} == {ConstraintType.PARTICLE_TRANSLATION}
    assert one.vector == pytest.approx([-c for c in two.vector])
    assert one.region.normal == pytest.approx([-c for c in two.region.normal])
    assert one.region.point == pytest.approx([1 - c for c in two.region.point])
    assert (one.magnitude, one.active_time, one.held_until) == (
        two.magnitude,
        two.active_time,
        two.held_until,
    )
    assert one.vector[2] * one.region.normal[2] == pytest.approx(1.0)
    assert "paired_translation" in answer.rules_applied


def test_saturated_squeeze_is_pressed_between_plates():
    """Two opposed ones; one where the ground is the other."""
    prompt = "squeeze it vertically"
    answer, _ = rewritten(prompt, with_magnitude(prompt, -1.6))
    assert answer.force_field.actions == ()
    one, two = answer.force_field.constraints
    assert {one.constraint_type, two.constraint_type} == {ConstraintType.MOVING_PLATE}
    assert one.vector == pytest.approx([-c for c in two.vector])
    assert (one.magnitude, one.active_time, one.held_until) == (
        two.magnitude,
        two.active_time,
        two.held_until,
    )
    answer, _ = rewritten(prompt, with_magnitude(prompt, -1.6), scene=brief(world="ground"))
    (plate,) = answer.force_field.constraints
    assert plate.vector == (0.0, 0.0, -1.0)


def test_saturated_impulse_becomes_a_brief_particle_impulse():
    """Of at most two frames, in the same direction."""
    answer, _ = rewritten("kick it left", with_magnitude("kick it left", 1.6), displacement=(-0.2, 0, 0))
    assert answer.force_field.actions == ()
    for blow in answer.force_field.constraints:
        assert blow.constraint_type is ConstraintType.PARTICLE_IMPULSE
        assert blow.vector == LEFT and blow.active_time[1] - blow.active_time[0] <= 2


def test_saturated_push_acts_longer_and_is_never_stacked():
    """First the window grows, then its velocity is prescribed."""
    prompt = "push it left for one second"
    answer, _ = rewritten(prompt, with_magnitude(prompt, 1.6), displacement=(-0.05, 0, 0))
    (action,) = answer.force_field.actions
    assert action.active_time[1] > 25
    answer, _ = rewritten("push it left", with_magnitude("push it left", 1.6), displacement=(-0.2, 0, 0))
    assert answer.force_field.actions == ()
    (drive,) = answer.force_field.constraints
    assert drive.constraint_type is ConstraintType.PARTICLE_TRANSLATION and drive.vector == LEFT


def test_a_prescribed_velocity_goes_where_the_sentence_says():
    """A force that was turned to make up for a drift is no reason to prescribe a motion beside the one asked for."""
    prompt, slow = "push it left", dict(displacement=(-0.2, 0, 0))
    reply = read(prompt)
    straight, turned = (
        with_magnitude(prompt, 1.6, vector=way, active_time=(0.0, 48.0))
        for way in (LEFT, (-0.7071, 0.7071, 0.0))
    )
    tried = judge(prompt, reply, seen_in(reply.expectations, **slow), brief(), straight)
    answer, _ = rewritten(prompt, turned, history=(tried,), **slow)
    (drive,) = answer.force_field.constraints
    assert drive.vector == pytest.approx(LEFT) and drive.magnitude > 0


def test_a_saturated_push_that_began_late_begins_earlier():
    """A saturated push that cannot last longer begins earlier: where its motion should begin, not before."""
    prompt = "spin it"
    late = with_magnitude(prompt, 1.6, active_time=(30.0, 48.0))
    answer, _ = rewritten(prompt, late, turn=(0, 0, 3.0))
    (action,) = answer.force_field.actions
    assert action.active_time[1] == 48.0 and action.active_time[0] < 20.0


def test_no_attempt_is_repeated_until_nothing_is_left():
    """Rewrite differ from all earlier attempts; when they run out, the change says so."""
    scene, prompt = brief(), "push it left"
    reply = read(prompt)
    field, history, tried = reply.force_field, [], [reply.force_field]
    for _ in range(40):
        seen = seen_in(reply.expectations)
        failed = judge(prompt, reply, seen, scene, field)
        answer = rewrite(prompt, reply, failed, scene, history)
        history.append(failed)
        if answer.force_field == field:
            assert answer.changes[0].startswith("Nothing left to try")
            break
        field = answer.force_field
        assert field not in tried
        tried.append(field)
    else:
        pytest.fail("the remedies never ran out")
    assert len(tried) > 3


def test_unobservable_motion_changes_nothing():
    """Without a failed check there is nothing to mend, and the change says so."""
    answer, _ = rewritten("push it left", displacement=None)
    assert answer.force_field == read("push it left").force_field
    assert "Nothing left to try" in answer.changes[0]


@pytest.mark.parametrize("gain", [0.4, 0.55, 0.8, 1.0, 1.5, 2.0, 2.5])
@pytest.mark.parametrize(
    "prompt",
    ["push it left", "push it slightly to the right", "a strong wind pushes it away", "spin it clockwise",
     "stretch it", "squeeze it", "kick it to the upper left", "push it left for one second"],
)  # fmt: skip
def test_loop_converges_for_unknown_gains(prompt, gain):
    """Whatever the response of the world, three rounds are enough, and the score never falls."""
    reply = read(prompt)
    attempts = loop(reply.force_field, reply.expectations, ToyWorld(brief(), gain), iterations=3)
    assert attempts[-1][1].verdict is Verdict.SUCCESS
    scores = [judgement.score for _, judgement in attempts]
    assert scores == sorted(scores)


@pytest.mark.parametrize("prompt", ["push it left", "spin it", "stretch it", "kick it up"])
def test_loop_recovers_from_a_wrong_first_field(prompt):
    """A field for another sentence is turned into the right one."""
    reply = read(prompt)
    for wrong in ("push it right", "spin it clockwise", "squeeze it", "kick it down"):
        attempts = loop(read(wrong).force_field, reply.expectations, ToyWorld(brief()), iterations=3)
        assert attempts[-1][1].verdict is Verdict.SUCCESS, wrong


def toy_scene(row):
    is_anchored = row[1] or "anchor base" in row[2] or "anchor top" in row[2]
    return brief(anchored="base" if is_anchored else None)


def test_first_guesses_agree_with_the_skill_library():
    """With the library's own scaling most sentences succeed at once, though viewers' ranges do not follow from it."""
    at_once, failed = 0, set()
    for row in SENTENCES:
        scene = toy_scene(row)
        reply = read(row[0], scene)
        attempts = loop(reply.force_field, reply.expectations, ToyWorld(scene), iterations=3)
        at_once += len(attempts) == 1
        if attempts[-1][1].verdict is not Verdict.SUCCESS:
            failed.add(row[0])
    assert failed == UNSEEN | SWALLOWED | TOO_SHORT
    assert at_once > 0.8 * len(SENTENCES)


@pytest.mark.parametrize("gain", [0.4, 2.5])
def test_every_rewrite_obeys_the_hard_rules(gain):
    """All attempts of all sentences are valid and need no repair; no attempt is made twice."""
    for row in SENTENCES[::2]:
        scene = toy_scene(row)
        reply = read(row[0], scene)
        attempts = loop(reply.force_field, reply.expectations, ToyWorld(scene, gain), iterations=4)
        fields = [field for field, _ in attempts]
        for field in fields:
            assert apply_hard_rules(field, scene, reply.expectations)[1] == ()
        assert all(field not in fields[:i] for i, field in enumerate(fields))


def test_torque_type_is_kept_for_rotation():
    """Rotation is never mended by a translation."""
    reply = read("spin it")
    attempts = loop(reply.force_field, reply.expectations, ToyWorld(brief(), 0.1), iterations=5)
    assert all({a.action_type for a in field.actions} == {ActionType.TORQUE} for field, _ in attempts)


def test_what_is_to_stay_and_comes_back_is_kept_longer():
    """Until the clip's end, or until the next motion: a shorter cause is for what should come back."""
    end = {"kind": "half_space", "point": [0.75, 0.5, 0.5], "normal": [1, 0, 0]}
    other = {"kind": "half_space", "point": [0.25, 0.5, 0.5], "normal": [-1, 0, 0]}
    ends = [
        {
            "constraint_type": "enforce_particle_translation",
            "vector": region["normal"],
            "magnitude": 0.8,
            "active_time": [0, 8],
            "held_until": 12,
            "region": region,
        }
        for region in (end, other)
    ]
    prompt = "stretch it sideways by a fifth within half a second and keep it so"
    scene, reply = brief(), read(prompt)
    strains = [0.2 * min(t / 8, 1) if t <= 12 else 0.0 for t in range(49)]
    tensors = [((1 + e, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) for e in strains]
    seen = make_report([(0.0, 0.0, 0.0)] * 49, [(0.0, 0.0, 0.0)] * 49, tensors, windows=[(0, 12)])
    failed = judge(prompt, reply, seen, scene, ForceField.model_validate({"constraints": ends}))
    assert [c.aspect for c in failed.judgement.checks if c.passed is False][:1] == ["return"]
    answer = rewrite(prompt, reply, failed, scene)
    assert [c.held_until for c in answer.force_field.constraints] == [48, 48]
    assert [c.active_time for c in answer.force_field.constraints] == [(0, 8), (0, 8)]


def test_a_round_with_nothing_but_doubts_is_not_changed_for_the_worse():
    """Its every check is met: what a worse round failed by is mended already."""
    prompt, scene = "push it left by half of its length", brief()
    reply = read(prompt, scene).model_copy(update={"unsure": ("'so' is not understood.",)})
    weak, near = (
        judge(
            prompt,
            reply,
            seen_in(reply.expectations, scene.frame_count, displacement=(-way, 0, 0)),
            scene,
            reply.force_field.model_copy(update={"actions": reply.force_field.actions[:count]}),
        )
        for way, count in ((0.2, 1), (0.5, 2))
    )
    assert all(check.passed for check in near.judgement.checks)
    assert near.judgement.verdict is Verdict.FAIL
    answer = rewrite(prompt, reply, near, scene, (weak,))
    assert answer.force_field == near.force_field and "no check failed" in answer.changes[0]


def test_what_left_the_picture_was_too_much():
    """Unobservable because the object is gone: the same again, but weaker."""
    prompt, scene = "push it left", brief()
    reply = read(prompt, scene)
    seen = seen_in(reply.expectations, scene.frame_count, displacement=None)
    seen = seen.model_copy(update={"quality": seen.quality.model_copy(update={"leaves_frame": 7})})
    answer = rewrite(prompt, reply, judge(prompt, reply, seen, scene), scene)
    (action,) = answer.force_field.actions
    assert (action.vector, action.magnitude) == (LEFT, pytest.approx(0.6))


def test_what_breaks_is_not_asked_for_more():
    """A mug that was wrung too little and came apart was wrung harder."""
    prompt, scene = "push it left", brief()
    field, reply = with_magnitude(prompt, 0.8), read(prompt)
    failed = judge(prompt, reply, seen_in(reply.expectations, 49, displacement=(-0.2, 0, 0)), scene, field)
    checks = [check for check in failed.judgement.checks if check.passed is False]
    broken = checks[0].model_copy(update=dict(aspect="integrity", gain=0.6))
    for told, harder in ((checks, True), ([*checks, broken], False)):
        case = Case(field, reply.expectations[0], reply.expectations, scene, told, failed.report, ())
        efforts = [a.magnitude * a.gain for each in list_remedies(case) for a in each.force_field.actions]
        assert (max(efforts) > 0.8) is harder and efforts


def test_what_stands_is_not_led_into_the_ground():
    """It sank out of sight, and what was asked for seemed to be met."""
    field = ForceField.model_validate(
        {"actions": [dict(action_type="translation", vector=(0, 0, -1), magnitude=1.6)]}
    )
    for world, led in (("free", True), ("ground", False)):
        scene = brief(world=world)
        reply = read("move the robot down", scene)
        seen = seen_in(reply.expectations, 49, displacement=(0, 0, -0.01))
        checks = judge("move the robot down", reply, seen, scene, field).judgement.checks
        failed = [check for check in checks if check.passed is False]
        case = Case(field, reply.expectations[0], reply.expectations, scene, failed, seen, ())
        kinds = {c.constraint_type for each in list_remedies(case) for c in each.force_field.constraints}
        assert (ConstraintType.PARTICLE_TRANSLATION in kinds) is led


def test_between_too_weak_and_too_much_lies_the_next_attempt():
    """After 1.0 was too much and 0.6 too weak, the next attempt is not 1.6."""
    prompt = "push it left"
    too_much, too_weak = with_magnitude(prompt, 1.0), with_magnitude(prompt, 0.6)
    _, judged = rewritten(prompt, too_much, displacement=(-2.5, 0, 0))
    answer, _ = rewritten(prompt, too_weak, history=[judged], displacement=(-0.2, 0, 0))
    (action,) = answer.force_field.actions
    assert 0.6 < action.magnitude < 1.0


def test_it_goes_out_from_the_best_round():
    """A second attempt that is worse than the first is dropped, whatever it changed."""
    prompt, scene = "push it left and turn it clockwise", brief()
    reply = read(prompt, scene)
    near = judge(
        prompt, reply, seen_in(reply.expectations, scene.frame_count, displacement=(-0.4, 0, 0)), scene
    )
    away = read("push it away").force_field
    far = judge(prompt, reply, seen_in(reply.expectations, scene.frame_count), scene, away)
    assert near.judgement.score > far.judgement.score
    answer = rewrite(prompt, reply, far, scene, [near])
    assert {a.action_type for a in answer.force_field.actions} == {ActionType.TRANSLATION, ActionType.TORQUE}
    assert LEFT in [a.vector for a in answer.force_field.actions]
    assert "best round" in answer.changes[0]


def test_what_nobody_asked_for_is_removed():
    """An extra action goes before anything else is tried; brakes and the halves of a swing stay."""
    field = read("push it left").force_field
    extra = read("spin it").force_field.actions
    field = field.model_copy(update={"actions": (*field.actions, *extra)})
    answer, _ = rewritten("push it left", field, displacement=(-0.05, 0, 0))
    assert [a.action_type for a in answer.force_field.actions] == [ActionType.TRANSLATION]


def test_what_acts_at_the_wrong_time_is_moved_to_its_window():
    late = with_magnitude("push it left", 1.0, active_time=(40.0, 48.0))
    answer, _ = rewritten("push it left", late, displacement=(-0.02, 0, 0))
    (action,) = answer.force_field.actions
    assert action.active_time == (0.0, 48.0)


def test_several_failed_clauses_are_mended_at_once():
    prompt = "push it left, then stretch it sideways"
    reply = read(prompt)
    push = read("push it right").force_field.actions[0].model_copy(update={"active_time": (0.0, 24.0)})
    pull = reply.force_field.actions[-1].model_copy(update={"magnitude": -1.0})
    answer, _ = rewritten(prompt, ForceField(actions=(push, pull)), displacement=(0.9, 0, 0))
    one, two = answer.force_field.actions
    assert one.magnitude * one.vector[0] < 0 and two.magnitude > 0


def test_what_leaves_the_range_of_M_is_calibrated_again():
    """The planner's whole factor is carried out: M stays in its range, k makes up for the rest."""
    answer, failed = rewritten("push it left", displacement=(-0.2, 0, 0))
    asked = next(check.gain for check in failed.judgement.checks if check.gain)
    (action,) = answer.force_field.actions
    assert action.magnitude == 1.6 and action.magnitude * action.gain == pytest.approx(asked, rel=1e-3)
    assert "k is calibrated again" in answer.changes[0]
    answer, failed = rewritten("push it left", displacement=(-9.0, 0, 0))
    asked = next(check.gain for check in failed.judgement.checks if check.gain)
    (action,) = answer.force_field.actions
    assert action.magnitude == 0.4 and action.magnitude * action.gain == pytest.approx(asked, rel=2e-3)


def test_a_gain_goes_on_from_round_to_round():
    """A k that was calibrated again is a part of the effort that the next factor is of."""
    field = with_magnitude("push it left", 1.6, gain=2.0)
    answer, _ = rewritten("push it left", field, displacement=(-0.24, 0, 0))
    (action,) = answer.force_field.actions
    assert (action.magnitude, action.gain) == (1.6, pytest.approx(5.0, rel=1e-3))
    answer, _ = rewritten("push it left", field, displacement=(-1.8, 0, 0))
    (action,) = answer.force_field.actions
    assert (action.magnitude, action.gain) == (pytest.approx(1.6 / 3, rel=1e-3), 2.0)


def test_what_is_at_its_limit_is_said():
    """K has its limit too, and nothing in any rewrite exceeds the range, alone or with others."""
    limit = with_magnitude("a gust blows it left", 1.3, gain=45.0)
    answer, _ = rewritten("a gust blows it left", limit, displacement=(-0.35, 0, 0))
    said = [change for change in answer.changes if "cannot be made stronger" in change]
    assert all(abs(action.magnitude) <= 1.6 and action.gain <= 50 for action in answer.force_field.actions)
    assert said or answer.force_field.actions[0].gain == 45.0


def test_an_opposed_pair_stays_one():
    """A twist that is too weak, and whose axis is hardly seen, is made stronger at both ends alike."""
    prompt = "twist the loaf"
    reply, scene = read(prompt), brief()
    answer, _ = rewritten(prompt, scene=scene)
    one, two = (cause.item for cause in list_causes(answer.force_field))
    assert one.vector == pytest.approx([-c for c in two.vector])
    assert (one.magnitude, one.gain, one.active_time) == (two.magnitude, two.gain, two.active_time)
    assert reply.force_field != answer.force_field


def test_leaps_that_run_together_are_not_replaced_by_pushes_to_and_fro():
    """No change of the blows tells them apart: there is nothing left to try."""
    scene = brief(world="ground", frame_count=100)
    reply = read("the robot hops three times", scene)
    leaps = next(each for each in reply.expectations if each.repeats == 3)
    assert leaps.window[1] == pytest.approx(scene.last)  # all three are its own
    heights = [max(0.0, 0.5 * (1 - abs(t / 16 - 1))) for t in range(100)]
    failed = judge("", reply, make_report([(0.0, 0.0, h) for h in heights]), scene)
    assert any(check.aspect == "repeats" and check.passed is False for check in failed.judgement.checks)
    answer = rewrite("the robot hops three times", reply, failed, scene)
    assert all(action.vector == (0.0, 0.0, 1.0) for action in answer.force_field.actions), answer


def test_what_is_kept_after_its_turn_is_still_kept_when_it_turns_for_longer():
    scene, prompt = brief(world="ground"), "spin it around twice"
    reply = GrammarSemanticAgent().compile(asked(prompt, scene)).value
    (before,) = reply.force_field.constraints
    seen = seen_in(reply.expectations, scene.frame_count, turn=(0, 0, 400))
    failed = judge(prompt, reply, seen, scene)
    (after,) = rewrite(prompt, reply, failed, scene).force_field.constraints
    assert before.held_until == after.held_until == scene.last
    assert before.active_time[1] <= after.active_time[1] < scene.last
    assert after.magnitude * after.gain > before.magnitude * before.gain
