"""The executor holds what goes over as a whole where it should change its shape, and nothing else."""

from dataclasses import replace

import pytest

from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.rules.holding import should_hold
from physagent_jax.forces.schema import ForceField, VelocityConstraint
from physagent_jax.motion.schema import AnchorRequest, Verdict
from tests.agents.scenes import asked, brief, judge, read, rewrite, seen_in

WENT_OVER = {
    "displacement": (-0.9, 0, 0),
    "turn": (0, 0, 170.0),
    "stretch": ((2.4, 0, 0), (0, 1, 0), (0, 0, 1)),
}


def fail(prompt, scene, **motion):
    reply = read(prompt, scene)
    failed = judge(prompt, reply, seen_in(reply.expectations, scene.frame_count, **motion), scene)
    assert failed.judgement.verdict is Verdict.FAIL
    return reply, failed


@pytest.fixture
def ground():
    return brief(world="ground").model_copy(update={"may_be_held": True})


def test_what_is_to_bend_and_falls_over_is_held(ground):
    """With the force field as it is, and a reason."""
    prompt = "push the top of the robot to the left"
    reply, failed = fail(
        prompt,
        ground,
        displacement=(-0.9, 0, 0),
        turn=(0, 0, 170.0),
        stretch=((2.4, 0, 0), (0, 1, 0), (0, 0, 1)),
    )
    assert any(check.aspect == "collateral" for check in failed.judgement.checks if check.passed is False)
    answer = rewrite(prompt, reply, failed, ground)
    assert answer.hold == "base" and answer.force_field == failed.force_field
    assert "held at its base" in answer.changes[0]


def test_what_needs_to_be_free_is_never_held(ground):
    """No hold for what is pushed somewhere, is left free by the user or the sentence, or is held already."""
    prompt = "push the robot to the left"
    reply, failed = fail(prompt, ground, **WENT_OVER)
    assert rewrite(prompt, reply, failed, ground).hold is None
    prompt = "push the top of the robot to the left"
    reply, failed = fail(prompt, ground, **WENT_OVER)
    for scene in (brief(world="ground"), ground.model_copy(update={"anchored": "base"}), brief()):
        assert rewrite(prompt, reply, failed, scene).hold is None
    loose = reply.model_copy(update={"anchor": AnchorRequest(kind="none", words="loose")})
    context: AgentContext = asked(prompt, ground, loose, ())
    assert not should_hold(context, failed)


def test_what_is_led_by_its_ends_is_not_held_as_well(ground):
    """Both act on the base, and what lies between is torn."""
    prompt = "push the top of the robot to the left"
    reply, failed = fail(prompt, ground, **WENT_OVER)
    context = asked(prompt, ground, reply, ())
    assert should_hold(context, failed)
    region = failed.force_field.actions[0].region
    led = VelocityConstraint.model_validate(
        dict(constraint_type="enforce_particle_rotation", vector=(1, 0, 0), magnitude=1.0, region=region)
    )
    assert not should_hold(context, replace(failed, force_field=ForceField(constraints=(led,))))


def test_what_is_to_bend_and_slides_is_held(ground):
    """A word of bending asks for it; what is pushed to the same place may slide."""
    for prompt, hold in (
        ("a gust leans the robot to the left", "base"),
        ("a gust pushes the robot to the left", None),
    ):
        reply = read(prompt, ground)
        slides = {"displacement": (-1.5, 0, 0)}
        failed = judge(prompt, reply, seen_in(reply.expectations, ground.frame_count, **slides), ground)
        assert rewrite(prompt, reply, failed, ground).hold == hold
