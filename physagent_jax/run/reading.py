"""The reading of a sentence for an object that its kind holds: made anew for the free object where it needs that."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.holds import HoldOrigin, describe_release, find_leaving
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, SceneBrief
from physagent_jax.run.brief import make_brief
from physagent_jax.run.holding import UP
from physagent_jax.run.resolve import LET_GO, ResolvedRun
from physagent_jax.run.sentence_material import tell_material
from physagent_jax.scene.body import Body
from physagent_jax.scene.template import SceneTemplate

Ask = Callable[[AgentContext], Reply[SemanticReply]]


def read_for_scene(run: ResolvedRun, body: Body, ask: Ask) -> Reply[SemanticReply]:
    """The semantic agent's reply to the run's sentence, in which nothing is held that has to be free.

    What its words for a material choose is among its notes.

    Args:
        run: The run.
        body: Its object at rest.
        ask: Calls the semantic agent.
    """

    def describe(said: SemanticReply | None = None) -> SceneBrief:
        brief = make_brief(
            run.place_for_agents(body, said), frames_fixed=run.frames_fixed, parts=run.list_parts(body)
        )
        return brief.model_copy(update=dict(may_be_held=run.spec.anchor.kind == "auto"))

    context = AgentContext(run.spec.prompt, describe(), describe_skills())
    reading = ask(context)
    motion = find_release(run, reading.value)
    if motion is not None:
        reading = read_let_go(reading, motion, dataclasses.replace(context, brief=describe(LET_GO)), ask)
    told = tell_material(run.spec.prompt, context.brief, run.spec.material, reading.value)
    return Reply(told, reading.trace)


def place_for_field(run: ResolvedRun, body: Body, field: ForceField) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The scene for a force field without a sentence, as `ResolvedRun.place` gives it, free if the field needs that.

    A hold that somebody has chosen stays, whatever the field: it may be one of many that are tried.

    Args:
        run: The run.
        body: Its object at rest.
        field: What acts.
    """
    motion = find_release(run, SemanticReply(force_field=field))
    if motion is None:
        return run.place(body)
    template, notes = run.place(body, LET_GO)
    return template, (describe_release(motion, template.source.kind), *notes)


def find_release(run: ResolvedRun, reply: SemanticReply) -> ExpectedMotion | None:
    """The motion that the hold of the object's kind gives way to; None if there is no such hold, or it stays."""
    hold = run.find_hold(reply)
    implied = hold is not None and hold.origin is HoldOrigin.KIND
    return find_leaving(reply.plan, UP) if implied else None


def read_let_go(
    reading: Reply[SemanticReply], motion: ExpectedMotion, context: AgentContext, ask: Ask
) -> Reply[SemanticReply]:
    """The second reading, which knows that nothing holds the object, and says why.

    Args:
        reading: The first one.
        motion: What of it needs the object free.
        context: The sentence and the scene in which nothing is held.
        ask: Calls the semantic agent.
    """
    again = ask(context)
    note = describe_release(motion, context.brief.object_kind)
    free = AnchorRequest(kind="none", words=motion.words)
    evidence = tuple(each for each in again.value.evidence if each.field != "anchor")
    value = again.value.model_copy(
        update=dict(anchor=free, evidence=evidence, notes=(note, *again.value.notes))
    )
    return Reply(value, reading.trace.followed_by(again.trace))
