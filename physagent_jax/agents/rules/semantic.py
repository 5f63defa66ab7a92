"""The offline semantic agent: a deterministic reading of everyday English."""

from __future__ import annotations

import unicodedata
from dataclasses import replace
from typing import Literal

from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.rules.language.clauses import Clause, places, read_clauses, verb_of
from physagent_jax.agents.rules.language.compilation import compile_slots
from physagent_jax.agents.rules.language.draft import Draft
from physagent_jax.agents.rules.language.events import Event, Source, interpret
from physagent_jax.agents.rules.language.marks import Kind, Mark, read_marks
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.schedule import schedule
from physagent_jax.agents.rules.language.verbs import VERBS, Doing, Verb
from physagent_jax.agents.schema import (
    AnchorRequest,
    Evidence,
    ExpectedMotion,
    MotionKind,
    SceneBrief,
    SemanticReply,
)
from physagent_jax.agents.trace import Reply
from physagent_jax.core.errors import UserError

EXAMPLES = (
    '"push the robot to the left", "a gentle wind sways the plant", "drop the guitar", "twist the loaf"'
)
MOST_CHARACTERS = 100_000  # read within seconds
End = Literal["base", "top", "none"] | None
_LETS_FALL = frozenset({"release", "let go", "let ~ go", "let loose", "set free"})
_DETERMINERS = frozenset({"the", "a", "an", "this", "that", "my", "your"})


class RuleSemanticAgent(SemanticAgent):
    """Reads by rules: no model, no network, the same words give the same field."""

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Reads the sentence; see `protocols.SemanticAgent`."""
        return Reply(_read(context.prompt, context.brief))


def _read(prompt: str, brief: SceneBrief) -> SemanticReply:
    _check_text(prompt)
    marks = read_marks(prompt, _object_words(brief))
    clauses = read_clauses(marks)
    gravity = _gravity(marks)
    unknown, notes = _not_understood(marks, brief)
    clauses = _assume_push(clauses, unknown)
    if gravity is None and not any(c.acts for c in clauses) and not _anchor(clauses).kind:
        raise UserError(
            "The prompt names no motion that is understood",
            got=repr(_short(prompt)),
            do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
        )
    anchor = _anchor(clauses)
    anchored = anchor.kind in ("base", "top") or (brief.anchored is not None and anchor.kind != "none")
    draft = Draft(brief, anchored, gravity, notes=notes)
    events = _events(clauses, draft)
    compile_slots(schedule(events, brief.frame_count, brief.frame_dt), draft)
    _state_gravity(marks, draft)
    _expect_stillness(clauses, draft)
    return SemanticReply(
        force_field=draft.force_field(),
        expectations=tuple(draft.expectations),
        anchor=anchor,
        evidence=tuple([*draft.evidence, *_anchor_evidence(anchor)]),
        not_understood=tuple(unknown),
        notes=tuple(draft.notes),
    )


def _check_text(prompt: str) -> None:
    """Refuses what is no sentence at all, before any of it is read."""
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


def _object_words(brief: SceneBrief) -> frozenset[str]:
    """The object's name and kind, singular and plural."""
    words = (
        "".join(c if c.isalnum() else " " for c in f"{brief.object_name} {brief.object_kind}").lower().split()
    )
    return frozenset(words) | {word + "s" for word in words}


def _short(prompt: str) -> str:
    text = " ".join(prompt.split())
    return text if len(text) <= 80 else text[:77] + "..."


def _gravity(marks: list[Mark]) -> bool | None:
    """What the sentence says about gravity in so many words ("no gravity" is a NOT before the mark)."""
    for before, mark in zip([None, *marks], marks):
        if mark.kind is Kind.GRAVITY:
            negated = before is not None and before.kind is Kind.NOT
            return bool(mark.value) != negated
    return None


def _not_understood(marks: list[Mark], brief: SceneBrief) -> tuple[list[str], list[str]]:
    """Unknown content words; a noun is taken for the object if the sentence does not name it otherwise."""
    names = _object_words(brief)
    named = any(mark.phrase in names for mark in marks)
    unknown: list[str] = []
    taken: list[str] = []
    for before, mark in zip([None, *marks], marks):
        word = mark.phrase
        if mark.kind is not Kind.UNKNOWN or word in unknown or word in names:
            continue
        follows = "" if before is None else before.phrase
        if word.isalpha() and (follows in taken or not (named or taken) and follows in _DETERMINERS):
            taken.append(word)  # "the castle", "the sand castle"
        elif word not in taken:
            unknown.append(word)
    notes = [f"'{' '.join(taken)}' is taken to be the object ({brief.object_name})."] if taken else []
    return unknown, notes


def _assume_push(clauses: list[Clause], unknown: list[str]) -> list[Clause]:
    """A bare "to the left" is a push; among words that are not understood it is nothing."""
    if unknown or any(c.acts for c in clauses):
        return clauses
    directed = [c for c in clauses if c.of(Kind.DIRECTION, Kind.FROM)]
    for clause in directed:
        first = clause.of(Kind.DIRECTION, Kind.FROM)[0]
        clause.verb = replace(first, kind=Kind.VERB, value=Verb(Doing.PUSH), phrase="push")
    return clauses


def _events(clauses: list[Clause], draft: Draft) -> list[Event]:
    """The events that happen, in order, with what the words around them change."""
    events: list[Event] = []
    for clause in clauses:
        if clause.acts is None or verb_of(clause.acts).doing is Doing.HOLD:
            continue
        if clause.negated:
            draft.note(f"'{clause.words}' is negated: it does not happen.")
            continue
        directed = next((e for e in reversed(events) if e.direction is not None), None)
        event = interpret(clause, directed, draft.brief)
        events.append(_under_gravity(event, clause, draft.gravity))
    events = _releases(events, draft)
    moving = [e for e in events if e.doing not in (Doing.STILL, Doing.RELEASE)]
    if moving:  # "the robot standing on the ground is pushed": standing is not a wish for stillness
        tail = events[-1]
        events = [
            e
            for e in events
            if not (e.doing is Doing.STILL and e.verb.generic) or (e is tail and e.join is Join.THEN)
        ]
    return events


def _under_gravity(event: Event, clause: Clause, gravity: bool | None) -> Event:
    """What gravity pulls down falls; what floats in zero gravity is still."""
    told = bool(clause.of(Kind.DIRECTION, Kind.FROM))
    if clause.of(Kind.GRAVITY) and gravity and event.doing is Doing.PUSH and (not told or event.verb.pulls):
        return replace(event, verb=VERBS["fall"], phrase="fall", direction=None)
    if gravity is False and event.phrase in ("float", "hover", "levitate") and not told:
        return replace(event, verb=VERBS["motionless"], phrase="motionless", direction=None)
    return event


def _releases(events: list[Event], draft: Draft) -> list[Event]:
    """Letting go of something at rest lets it fall; letting go before a fall is part of the fall."""
    result: list[Event] = []
    for index, event in enumerate(events):
        if event.doing is Doing.RELEASE and result and result[-1].doing is Doing.RELEASE:
            continue  # "release it and let it swing back" is one release
        acted = any(e.doing not in (Doing.STILL, Doing.RELEASE) for e in result)
        falls_next = index + 1 < len(events) and events[index + 1].doing is Doing.FALL
        if event.doing is not Doing.RELEASE or (acted and not falls_next):
            result.append(event)
        elif not falls_next and event.phrase in _LETS_FALL:
            result.append(replace(event, verb=VERBS["fall"]))
            draft.note(f"'{event.words}': nothing acts before it, so the object is let fall.")
        elif not falls_next:
            draft.note(f"'{event.words}': nothing acts before it to come back from.")
    return result


def _state_gravity(marks: list[Mark], draft: Draft) -> None:
    """Gravity named without a falling verb; explicit weightlessness is recorded too."""
    if draft.gravity is None:
        return
    mark = next(mark for mark in marks if mark.kind is Kind.GRAVITY)
    if draft.gravity and not draft.default_drop:
        draft.drop(mark.words, "gravity is named")
        if not draft.expectations:
            event = Event(
                VERBS["fall"],
                "fall",
                mark.words,
                Join.THEN,
                None,
                1.0,
                sources={"action_type": Source("", "")},
            )
            draft.expect(event, MotionKind.FALL, None, (0.0, draft.last))
    elif not draft.gravity:
        draft.evidence.append(
            Evidence(words=mark.words, field="default_drop", value="false", why="no gravity is asked for")
        )


def _expect_stillness(clauses: list[Clause], draft: Draft) -> None:
    """A sentence that forbids all motion, or only holds something, asks for stillness."""
    if draft.expectations:
        return
    words = " ".join(c.words for c in clauses if c.acts)
    window = draft.window((0.0, draft.last)) or (0.0, draft.last)
    draft.expectations.append(ExpectedMotion(kind=MotionKind.STILL, window=window, words=words[:200]))


def _anchor(clauses: list[Clause]) -> AnchorRequest:
    """What is held: an adjective ("rooted"), a verb ("hold the pot"), or an end that "does not move"."""
    for clause in clauses:
        for mark in clause.of(Kind.ANCHOR):
            return AnchorRequest.model_validate({"kind": mark.value, "words": mark.words})
        if clause.acts is None:
            continue
        verb = verb_of(clause.acts)
        words = " ".join(mark.words for mark in clause.marks)
        if verb.doing is Doing.HOLD:
            return AnchorRequest(
                kind="none" if clause.negated else _held_end(clause, verb.holds), words=words
            )
        still = verb.doing is Doing.STILL or (clause.negated and verb.doing is not Doing.STILL)
        if still and places(clause) and (clause is clauses[0] or clause.join is not Join.THEN):
            return AnchorRequest(kind=_held_end(clause, None), words=words)
    return AnchorRequest()


def _held_end(clause: Clause, otherwise: End) -> End:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    for place in places(clause):
        if "down" in place.names:
            return "base"
        return "top" if "up" in place.names else None
    return otherwise


def _anchor_evidence(anchor: AnchorRequest) -> list[Evidence]:
    if anchor.kind is None:
        return []
    return [
        Evidence(words=anchor.words, field="anchor", value=anchor.kind, why="words about holding or freedom")
    ]
