"""The reading of a sentence for an object that its kind holds: made anew for the free object where it needs that."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import NamedTuple

from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.holds import Hold, HoldOrigin, describe_release, find_leaving, needs_weight
from physagent_jax.motion.parts import explain_missing
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, SceneBrief, WorldRequest
from physagent_jax.run.bearing import carry_along
from physagent_jax.run.brief import make_brief
from physagent_jax.run.holding import UP
from physagent_jax.run.postures import list_acted
from physagent_jax.run.resolve import LET_GO, ResolvedRun
from physagent_jax.run.sentence_material import tell_material
from physagent_jax.run.sides import put_sides_first
from physagent_jax.scene.body import Body
from physagent_jax.scene.template import SceneTemplate

_ANY_END = re.compile(r"\b(?:one|an?) (?:end|edge|side|corner|half)\b", re.IGNORECASE)
Ask = Callable[[AgentContext], Reply[SemanticReply]]


class Release(NamedTuple):
    """The motion that an implied hold gives way to, the hold, and whether the object's weight would be missed then."""

    motion: ExpectedMotion
    hold: Hold
    weighs: bool


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
        asked = dict(frame_count=run.template.preset.timing.frame_count)  # a reply tells its own anew
        return brief.model_copy(update=asked | dict(may_be_held=run.spec.anchor.kind == "auto"))

    ask = _carry(ask, run, body)
    held, free = describe(), describe(LET_GO)
    supported = held.anchored is not None and run.template.anchor.kind == "none"
    prompt = put_sides_first(run.spec.prompt or "")
    context = AgentContext(prompt, free if supported else held, describe_skills())
    reading = ask(context)
    release = find_release(run, body, reading.value)
    if supported and release and not _let_go(release).world.gravity:  # read as it then is
        reading, release = Reply(_mark_free(reading.value, release, free), reading.trace), None
    elif not release and reading.value.anchor.kind is None:
        held = describe(reading.value)  # of the sentence's material it may bear less of its weight
        if held.anchored != context.brief.anchored:
            again = ask(dataclasses.replace(context, brief=held))
            reading = Reply(again.value, reading.trace.followed_by(again.trace))
            release = find_release(run, body, reading.value)
    if release:
        context = dataclasses.replace(context, brief=describe(_let_go(release)))
        reading = read_let_go(reading, release, context, ask)
    told = tell_material(run.spec.prompt, context.brief, run.spec.material, reading.value)
    return Reply(tell_parts(told, prompt, context.brief), reading.trace)


def tell_parts(reply: SemanticReply, prompt: str, brief: SceneBrief) -> SemanticReply:
    """The reply that asks for no part which tells a posture alone, and says which part a word is taken to mean."""
    acted = [brief.parts[each.limb] for each in reply.expectations if each.limb is not None]
    taken = [f"'{part.name}' is taken to be '{part.stands_for}'." for part in acted if part.stands_for]
    ends = {
        each.words for each in reply.evidence if each.field.endswith("region") and _ANY_END.search(each.words)
    }
    taken += [f"'{words}' is taken to be the one on the right, which is seen well." for words in sorted(ends)]
    unknown = list_acted(reply.unknown_parts, prompt)
    idle = [explain_missing(word, brief.parts) for word in reply.unknown_parts if word not in unknown]
    told = dict(
        unknown_parts=unknown,
        notes=tuple(dict.fromkeys((*reply.notes, *taken))),
        unsure=tuple(each for each in reply.unsure if each not in idle),
        not_understood=tuple(
            each for each in reply.not_understood if each in unknown or each not in reply.unknown_parts
        ),
    )
    return reply.model_copy(update=told)


def _carry(ask: Ask, run: ResolvedRun, body: Body) -> Ask:
    """``ask`` with replies in which what bears the object takes it along (`run.bearing`); as it is where it is held."""
    world, parts = run.template.world, run.list_parts(body)
    if run.spec.anchor.kind != "auto" or not world.ground or world.gravity != "down":
        return ask

    def ask_and_carry(context: AgentContext) -> Reply[SemanticReply]:
        reply = ask(context)
        carried = carry_along(reply.value, body, parts, run.template.preset.timing.frame_dt)
        return Reply(carried, reply.trace)

    return ask_and_carry


def place_for_field(run: ResolvedRun, body: Body, field: ForceField) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The scene for a force field without a sentence, as `ResolvedRun.place` gives it, free if the field needs that.

    A hold that somebody has chosen stays, whatever the field: it may be one of many that are tried. Feet that are held
    only so that the object stands are let go: no sentence says that it stays.

    Args:
        run: The run.
        body: Its object at rest.
        field: What acts.
    """
    reply = SemanticReply(force_field=field)
    hold = run.find_hold(reply, body)
    if hold is not None and hold.origin is HoldOrigin.SUPPORT:
        return run.place(body, LET_GO)
    if (release := find_release(run, body, reply)) is None:
        return run.place(body)
    template, notes = run.place(body, _let_go(release))
    return template, (describe_release(release.motion, release.hold, template.source.kind), *notes)


def find_release(run: ResolvedRun, body: Body, reply: SemanticReply) -> Release | None:
    """The release of the object; None if there is no implied hold of it, or it stays."""
    hold = run.find_hold(reply, body)
    if hold is None or hold.origin not in (HoldOrigin.KIND, HoldOrigin.SUPPORT):
        return None
    support = hold.origin is HoldOrigin.SUPPORT
    motion = find_leaving(reply.plan, UP, stands=support)
    return motion and Release(motion, hold, support and needs_weight(motion, reply.plan, UP))


def _let_go(release: Release) -> SemanticReply:
    """A reply that lets the object go, with its weight where it would be missed of what cannot stand."""
    weight = dict(world=WorldRequest(gravity="down"))
    return LET_GO.model_copy(update=weight) if release.weighs else LET_GO


def read_let_go(
    reading: Reply[SemanticReply],
    release: Release,
    context: AgentContext,
    ask: Ask,
) -> Reply[SemanticReply]:
    """The second reading, which knows that nothing holds the object, and says why.

    Args:
        reading: The first one.
        release: What of it needs the object free, and the hold that gives way.
        context: The sentence and the scene in which nothing is held.
        ask: Calls the semantic agent.
    """
    again = ask(context)
    value = _mark_free(again.value, release, context.brief)
    return Reply(value, reading.trace.followed_by(again.trace))


def _mark_free(reply: SemanticReply, release: Release, brief: SceneBrief) -> SemanticReply:
    """The reply that lets the object go, and says why."""
    note, world = describe_release(release.motion, release.hold, brief.object_kind), reply.world
    free = AnchorRequest(kind="none", words=release.motion.words)
    evidence = tuple(each for each in reply.evidence if each.field != "anchor")
    if world.gravity is None:
        world = world.model_copy(update=dict(gravity=_let_go(release).world.gravity))
    return reply.model_copy(
        update=dict(anchor=free, world=world, evidence=evidence, notes=(note, *reply.notes))
    )
