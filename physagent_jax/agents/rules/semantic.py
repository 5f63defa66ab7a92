"""The offline semantic agent: a deterministic reading of everyday English."""

from __future__ import annotations

import unicodedata
from dataclasses import replace
from typing import Literal

from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.materials import find_materials
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.rules.kinds import choose_kinds, find_new_places
from physagent_jax.agents.rules.language.builder import ForceFieldBuilder, describe_skill
from physagent_jax.agents.rules.language.clauses import Clause, find_places, get_verb
from physagent_jax.agents.rules.language.compilation import compile_slots
from physagent_jax.agents.rules.language.events import TOLD, Event, ValueSource
from physagent_jax.agents.rules.language.explanations import merge_explanations
from physagent_jax.agents.rules.language.grammar import read_clauses
from physagent_jax.agents.rules.language.interpretation import interpret, lands_aside, resolve_obstacles
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import GROUND_WORDS, OPPOSITE_GRAVITY, Join
from physagent_jax.agents.rules.language.naming import collect_object_words
from physagent_jax.agents.rules.language.reading import find_mentions
from physagent_jax.agents.rules.language.schedule import follows, schedule
from physagent_jax.agents.rules.language.spelling import describe_corrections
from physagent_jax.agents.rules.language.timing import TimeSpan
from physagent_jax.agents.rules.language.unknowns import is_mostly_unknown, list_unknown
from physagent_jax.agents.rules.language.verbs import VERBS, Effect, Verb
from physagent_jax.agents.schema import (
    AnchorRequest,
    Evidence,
    ExpectedMotion,
    MotionKind,
    SceneBrief,
    SemanticReply,
    WorldRequest,
)
from physagent_jax.agents.trace import Reply
from physagent_jax.agents.vectors import dot
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

EXAMPLES = (
    '"push the robot to the left", "a gentle wind sways the plant", "drop the guitar", "twist the loaf"'
)
MOST_CHARACTERS = 100_000  # read within seconds
End = Literal["base", "top", "none"] | None
_AWAY = 0.01  # [lengths, metres or degrees] from where nothing has to come back
_LETS_FALL = frozenset({"release", "let go", "let ~ go", "let loose", "set free"})
Gravity = Literal["down", "up", "none"] | None


class RuleSemanticAgent(SemanticAgent):
    """Reads by rules: no model, no network, the same words give the same field."""

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence, and choose the kind of each skill; see `protocols.SemanticAgent`."""
        return Reply(_choose_kinds(read_sentence(context.prompt, context.brief), context.brief))


def _choose_kinds(reply: SemanticReply, brief: SceneBrief) -> SemanticReply:
    """The reply with velocity constraints where they do what the sentence says and a force does not."""
    fixture = {"base": "the base", "top": "the top", "none": None, None: brief.anchored}[reply.anchor.kind]
    weightless = reply.world.gravity in ("none", "up") or reply.world.ground is False
    scene = brief.model_copy(
        update={
            "anchored": fixture,
            "frame_count": reply.frame_count or brief.frame_count,
            "world": "free" if weightless else "ground" if reply.world.ground else brief.world,
        }
    )
    choice = choose_kinds(reply.force_field, reply.expectations, scene)
    if not choice.reasons:
        return reply
    places = find_new_places(reply.force_field, choice.force_field)
    evidence = [_follow(item, places, choice.force_field) for item in reply.evidence]
    return reply.model_copy(
        update={
            "force_field": choice.force_field,
            "evidence": tuple(evidence),
            "notes": (*reply.notes, *choice.reasons),
        }
    )


def _follow(item: Evidence, places: dict[str, str], force_field: ForceField) -> Evidence:
    """Evidence of an action as that of what stands for it: its new place, and what is there now."""
    place, dot_, name = item.field.partition(".")
    new = places.get(place, place)
    group, _, index = new.rstrip("]").partition("[")
    if group != "constraints":
        return item.model_copy(update={"field": new + dot_ + name})
    name = "constraint_type" if name == "action_type" else name
    values = describe_skill(force_field.constraints[int(index)])
    return item.model_copy(update={"field": f"{new}.{name}", "value": values.get(name, item.value)})


def read_sentence(prompt: str, brief: SceneBrief) -> SemanticReply:
    """Read a sentence into the paper's four skills, all of them body forces.

    Raises:
        UserError: Nothing in it, or too little of it, can be understood.
    """
    _check_text(prompt)
    names = collect_object_words(prompt, brief)
    mentions = find_mentions(prompt, names)
    clauses, mentions = merge_explanations(read_clauses(mentions), mentions)
    gravity = _read_gravity(mentions)
    unknown, notes = list_unknown(mentions, names, brief)
    materials = find_materials(prompt, brief)
    phrases = [material.phrase.lower().replace("-", " ") for material in materials if not material.turns]
    said = {word for phrase in phrases for word in phrase.split()}
    unknown = [word for word in unknown if word.lower() not in said]
    notes += describe_corrections(prompt, names)
    clauses = _assume_push(clauses, unknown)
    if is_mostly_unknown(mentions, unknown):
        raise UserError(
            "Most words of the prompt are not understood",
            got=repr(_shorten(prompt)),
            do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
        )
    if gravity is None and not any(c.head for c in clauses) and not _choose_anchor(clauses).kind:
        raise UserError(
            "The prompt names no motion that is understood",
            got=repr(_shorten(prompt)),
            do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
        )
    anchor = _choose_anchor(clauses)
    anchored = anchor.kind in ("base", "top") or (brief.anchored is not None and anchor.kind != "none")
    builder = ForceFieldBuilder(brief, anchored, gravity, notes=notes)
    events = _read_events(clauses, builder)
    slots, frame_count, remarks = schedule(events, brief, anchored)
    builder.brief = brief.model_copy(update={"frame_count": frame_count})
    builder.notes += remarks
    compile_slots(slots, builder)
    _state_gravity(mentions, builder)
    _expect_stillness(clauses, builder)
    if builder.gravity == "none" and any(e.kind is MotionKind.FALL for e in builder.expectations):
        builder.unsure.append("How it falls without gravity is not understood.")
    solids = [m for clause in clauses for m in clause.select(MentionKind.SOLID)]
    if len({m.first for m in solids}) > len(builder.obstacles):
        builder.unsure.append(f"Where '{solids[-1].words}' is, is not understood.")
    builder.unsure += [f"'{word}' is not understood." for word in unknown]
    return SemanticReply(
        force_field=builder.build(),
        expectations=tuple(builder.expectations),
        anchor=anchor,
        world=_describe_world(mentions, builder),
        frame_count=None if frame_count == brief.frame_count else frame_count,
        unsure=tuple(builder.unsure),
        evidence=tuple([*builder.evidence, *_collect_anchor_evidence(anchor)]),
        not_understood=tuple(unknown),
        materials=tuple(material.word for material in materials),
        notes=tuple(builder.notes),
    )


def _check_text(prompt: str) -> None:
    """Refuse what is no sentence at all, before any of it is read."""
    if not prompt.strip():
        raise UserError("The prompt is empty", do=f"Say what should happen, for example {EXAMPLES}")
    if len(prompt) > MOST_CHARACTERS:
        raise UserError(
            f"The prompt is longer than {MOST_CHARACTERS:,} characters",
            got=f"{len(prompt):,}",
            do=f"Say in a sentence or two what should happen, for example {EXAMPLES}",
        )
    # Line breaks and tabs are spaces to a reader; other control characters and halves of characters are no text.
    strange = next((c for c in prompt if unicodedata.category(c) in ("Cc", "Cs") and not c.isspace()), None)
    if strange is not None:
        raise UserError(
            "The prompt holds a character that is no text",
            got=ascii(strange),
            do=f"Type the sentence anew, for example {EXAMPLES}",
        )


def _shorten(prompt: str) -> str:
    text = " ".join(prompt.split())
    return text if len(text) <= 80 else text[:77] + "..."


def _read_gravity(mentions: list[Mention]) -> Gravity:
    """Read explicit statements about gravity ("no gravity" is a NOT before the mention)."""
    found: Gravity = None
    for before, mention in zip([None, *mentions], mentions):
        if mention.kind is MentionKind.GRAVITY:
            negated = before is not None and before.kind is MentionKind.NOT
            said = OPPOSITE_GRAVITY[str(mention.value)] if negated else str(mention.value)
            said = "up" if said == "up" else "none" if said == "none" else "down"
            found = said if found in (None, "down") else found
    return found


def _describe_world(mentions: list[Mention], builder: ForceFieldBuilder) -> WorldRequest:
    """Describe the sentence's gravity, ground and obstacles."""
    words = [m.words for m in mentions if m.kind in (MentionKind.GRAVITY, MentionKind.SOLID)]
    groundless = any(
        before.kind is MentionKind.NOT and mention.phrase in GROUND_WORDS
        for before, mention in zip(mentions, mentions[1:])
    )
    return WorldRequest(
        gravity=builder.gravity,
        ground=False if groundless else None,
        obstacles=tuple(builder.obstacles),
        words=", ".join(words),
    )


def _assume_push(clauses: list[Clause], unknown: list[str]) -> list[Clause]:
    """A bare "to the left" is a push; among words that are not understood it is nothing."""
    if unknown or any(c.head for c in clauses):
        return clauses
    directed = [c for c in clauses if c.select(MentionKind.DIRECTION, MentionKind.FROM)]
    for clause in directed:
        first = clause.select(MentionKind.DIRECTION, MentionKind.FROM)[0]
        clause.verb = replace(first, kind=MentionKind.VERB, value=Verb(Effect.PUSH), phrase="push")
    return clauses


def _read_events(clauses: list[Clause], builder: ForceFieldBuilder) -> list[Event]:
    """The events that happen, in order, with what the words around them change."""
    events: list[Event] = []
    for clause in clauses:
        if clause.head is None or get_verb(clause.head).effect is Effect.HOLD:
            builder.obstacles += resolve_obstacles(
                clause, None, builder.brief
            )  # "there is a wall on its right"
            continue
        if _names_held_end(clause, clauses):
            continue  # "while the bottom stays put": what is held
        if clause.negated:
            builder.add_note(f"'{clause.words}' is negated: it does not happen.")
            continue
        directed = _find_measure(events, clause)
        event = _measure_return(interpret(clause, directed, builder.brief), events, clause)
        ways = [mention.value for mention in clause.select(MentionKind.DIRECTION)]
        lands = bool(events) and events[-1].effect is Effect.FALL and event.effect is Effect.FALL
        if lands and all(mention.kind is MentionKind.INTENSITY for mention in clause.modifiers):
            continue  # "it drops and bounces"
        if lands and lands_aside(clause) and events[-1].direction is None:
            told = dict(
                direction=event.direction, amount=event.amount, doubts=events[-1].doubts + event.doubts
            )
            words = f"{events[-1].words} {event.words}"
            events[-1] = replace(events[-1], **told, words=words, sources=events[-1].sources | event.sources)
            continue  # "drop it; as it reaches the ground it is farther to the right"
        if event.effect is Effect.FALL and builder.gravity is None and ("up",) in ways:
            builder.gravity = "up"  # "it falls upwards"
        events.append(_put_under_gravity(event, clause, builder.gravity))
    events = _share_time(_find_releases(events, builder))
    moving = [e for e in events if e.effect not in (Effect.STILL, Effect.RELEASE)]
    if moving:  # "the robot standing on the ground is pushed": standing is not a wish for stillness
        tail = events[-1]
        events = [
            e
            for e in events
            if not (e.effect is Effect.STILL and e.verb.generic)
            or (e is tail and e.join is Join.THEN)
            or _is_timed(e)  # "push it, rest for a second, push it"
        ]
    return events


def _measure_return(event: Event, events: list[Event], clause: Clause) -> Event:
    """The distance of a return, where the distance away was told."""
    back = any(m.phrase == "back" for m in clause.select(MentionKind.DIRECTION))
    if not back or event.amount is not None or event.direction is None or clause.select(MentionKind.QUANTITY):
        return event
    away = 0.0
    alike = [e for e in events if e.effect is event.effect and e.direction is not None]
    for each in alike:
        along = dot(each.direction or event.direction, event.direction)
        if each.amount is None or alike[0].amount is None or each.amount.unit != alike[0].amount.unit:
            return event
        away -= along * each.amount.value
    if away < _AWAY or alike[0].amount is None:
        return event
    return replace(event, amount=alike[0].amount.model_copy(update={"value": round(away, 6)}))


def _share_time(events: list[Event]) -> list[Event]:
    """A time that is told of all steps together ("left, then up, in a second") as a time of each, by its way."""
    if not events or not events[-1].when.total or events[-1].when.length is None:
        return events
    span = events[-1].when.length
    timed = any(_is_timed(e) for e in events[:-1])
    if timed or not all(follows(one, other) for one, other in zip(events, events[1:])):
        return events
    units = {e.amount.unit if e.amount else None for e in events}
    ways = [e.amount.value if e.amount and len(units) == 1 else 1.0 for e in events]
    lengths = [replace(span, value=span.value * way / sum(ways)) for way in ways]
    return [replace(e, when=TimeSpan(None, length, True)) for e, length in zip(events, lengths)]


def _is_timed(event: Event) -> bool:
    """Return whether the sentence says when or how long it is."""
    source = event.sources.get("active_time")
    return source is not None and source.why == TOLD


def _find_measure(events: list[Event], clause: Clause) -> Event | None:
    """The last event with a direction; for what comes "back" or goes on the same way, the last like it."""
    directed = [e for e in events if e.direction is not None]
    if any(m.phrase == "back" for m in clause.select(MentionKind.DIRECTION)):
        turns = get_verb(clause.head).effect is Effect.TURN
        directed = [e for e in directed if (e.effect is Effect.TURN) == turns] or directed
    if any(m.value == "same" for m in clause.select(MentionKind.REVERSAL)):
        directed = [e for e in directed if e.effect is not Effect.TURN] or directed
    return directed[-1] if directed else None


def _put_under_gravity(event: Event, clause: Clause, gravity: Gravity) -> Event:
    """Let gravity make things fall; what floats in zero gravity is still, unless something else moves it."""
    told = bool(clause.select(MentionKind.DIRECTION, MentionKind.FROM))
    if (
        clause.select(MentionKind.GRAVITY)
        and gravity == "down"
        and event.effect is Effect.PUSH
        and (not told or event.verb.pulls)
    ):
        return replace(event, verb=VERBS["fall"], phrase="fall", direction=None)
    if gravity == "none" and event.phrase in ("float", "hover", "levitate") and not told:
        resting = replace(VERBS["motionless"], generic=True)
        return replace(event, verb=resting, phrase="motionless", direction=None)
    return event


def _find_releases(events: list[Event], builder: ForceFieldBuilder) -> list[Event]:
    """Letting go of something at rest lets it fall; letting go before a fall is part of the fall."""
    result: list[Event] = []
    for index, event in enumerate(events):
        if event.effect is Effect.RELEASE and result and result[-1].effect is Effect.RELEASE:
            continue  # "release it and let it swing back" is one release
        acted = any(e.effect not in (Effect.STILL, Effect.RELEASE) for e in result)
        falls_next = index + 1 < len(events) and events[index + 1].effect in (Effect.FALL, Effect.TOPPLE)
        up = builder.brief.directions.up
        last = next((e for e in reversed(result) if e.effect is not Effect.STILL), None)
        if event.effect is Effect.RELEASE and last is not None and last.direction is not None:
            raised = last.effect is Effect.PUSH and dot(last.direction, up) > 0.5
            if raised and builder.grounded and not builder.anchored and event.phrase in _LETS_FALL:
                event = replace(event, verb=VERBS["fall"], phrase="fall", direction=None)
        if event.effect is not Effect.RELEASE or (acted and not falls_next):
            result.append(event)
        elif not falls_next and event.phrase in _LETS_FALL:
            result.append(replace(event, verb=VERBS["fall"]))
            builder.add_note(f"'{event.words}': nothing acts before it, so the object is let fall.")
        elif not falls_next:
            builder.unsure.append(f"What '{event.words}' comes back from is not understood.")
    return result


def _state_gravity(mentions: list[Mention], builder: ForceFieldBuilder) -> None:
    """Gravity named without a falling verb; explicit weightlessness is recorded too."""
    mention = next((mention for mention in mentions if mention.kind is MentionKind.GRAVITY), None)
    if builder.gravity is None or mention is None:
        return
    if builder.gravity != "none" and not builder.default_drop:
        if not (builder.grounded and builder.expectations):
            builder.enable_gravity(mention.words, "gravity is named")
        if not builder.expectations:
            event = Event(
                VERBS["fall"],
                "fall",
                mention.words,
                Join.THEN,
                None,
                1.0,
                sources={"action_type": ValueSource("", "")},
            )
            way = builder.brief.directions.up if builder.gravity == "up" else None
            builder.add_expectation(event, MotionKind.FALL, way, (0.0, builder.last))
    elif builder.gravity == "none":
        builder.evidence.append(
            Evidence(words=mention.words, field="default_drop", value="false", why="no gravity is asked for")
        )


def _expect_stillness(clauses: list[Clause], builder: ForceFieldBuilder) -> None:
    """A sentence that forbids all motion, or only holds something, asks for stillness."""
    if builder.expectations:
        return
    if any(c.negated and c.verb is not None and get_verb(c.verb).effect is Effect.STILL for c in clauses):
        builder.unsure.append("What it is to do, if not to be still, is not understood.")
    words = " ".join(c.words for c in clauses if c.head)
    window = builder.fit_window((0.0, builder.last)) or (0.0, builder.last)
    builder.expectations.append(ExpectedMotion(kind=MotionKind.STILL, window=window, words=words[:200]))


def _choose_anchor(clauses: list[Clause]) -> AnchorRequest:
    """Choose the hold: an adjective ("rooted"), a verb ("hold the pot"), or an end that "does not move"."""
    for clause in clauses:
        for mention in clause.select(MentionKind.ANCHOR):
            return AnchorRequest.model_validate(
                {"kind": mention.value, "words": mention.words, "described": True}
            )
        if clause.head is None:
            continue
        verb = get_verb(clause.head)
        words = " ".join(mention.words for mention in clause.mentions)
        if verb.effect is Effect.HOLD:
            return AnchorRequest(
                kind="none" if clause.negated else _find_held_end(clause, verb.holds), words=words
            )
        if _names_held_end(clause, clauses):
            return AnchorRequest(kind=_find_held_end(clause, None), words=words)
    return AnchorRequest()


def _names_held_end(clause: Clause, clauses: list[Clause]) -> bool:
    """Return whether a clause says of a part that it does not move while the rest does."""
    verb = get_verb(clause.head)
    still = verb.effect is Effect.STILL or (clause.negated and _is_said_of_part(clause))
    held = still and _find_held_end(clause, None) is not None
    return held and (clause is clauses[0] or clause.join is not Join.THEN)


def _is_said_of_part(clause: Clause) -> bool:
    """Return whether a part moves rather than is acted on: "its base does not tilt", not "don't hit its head"."""
    head = clause.head
    if head is None or get_verb(head).effect is Effect.STILL:
        return False
    places = [mention.first for mention in clause.select(MentionKind.PLACE)]
    return get_verb(head).generic or min(places, default=0) < head.first


def _find_held_end(clause: Clause, otherwise: End) -> End:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    for place in find_places(clause):
        if "down" in place.names:
            return "base"
        return "top" if "up" in place.names else None
    return otherwise


def _collect_anchor_evidence(anchor: AnchorRequest) -> list[Evidence]:
    if anchor.kind is None:
        return []
    return [
        Evidence(words=anchor.words, field="anchor", value=anchor.kind, why="words about holding or freedom")
    ]
