"""The compiler: an intent and the brief -> force field, expectations and evidence, by rules alone.

The paper's two rules hold: base vectors come from the brief's direction table and are never changed, and what the
lexicon maps a word to takes precedence over whatever else an agent thinks of it.
"""

from __future__ import annotations

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.events import Event, ValueSource
from physagent_jax.agents.compiler.holding import apply_holding, choose_anchor
from physagent_jax.agents.compiler.interpretation import resolve_obstacles
from physagent_jax.agents.compiler.kinds import choose_reply_kinds
from physagent_jax.agents.compiler.schedule import schedule
from physagent_jax.agents.compiler.sequence import make_events
from physagent_jax.agents.compiler.skills import compile_slots
from physagent_jax.agents.compiler.words import Meaning, look_up, suggest_motions
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.schema import (
    AnchorRequest,
    Evidence,
    ExpectedMotion,
    MotionKind,
    SceneBrief,
    SemanticReply,
    WorldRequest,
)
from physagent_jax.core.errors import UserError

EXAMPLES = (
    '"push the robot to the left", "a gentle wind sways the plant", "drop the guitar", "twist the loaf"'
)


def compile_intent(intent: Intent, brief: SceneBrief) -> SemanticReply:
    """The reply to an intent, with the kind of each skill chosen: body forces or velocity constraints.

    Raises:
        UserError: No motion is known, and nothing is said about holding or gravity.
    """
    return choose_reply_kinds(compile_forces(intent, brief), brief)


def compile_forces(intent: Intent, brief: SceneBrief) -> SemanticReply:
    """The reply to an intent in the paper's four skills, all of them body forces.

    Raises:
        UserError: No motion is known, and nothing is said about holding or gravity.
    """
    meanings = [look_up(clause) for clause in intent.clauses]
    _check_known(intent, meanings, brief)
    unknown = [meaning for meaning in meanings if meaning.motion is None]
    meanings = apply_holding([meaning for meaning in meanings if meaning.motion is not None], intent.held)
    anchor = choose_anchor(intent.held, meanings)
    anchored = anchor.kind in ("base", "top") or (brief.anchored is not None and anchor.kind != "none")
    gravity = intent.surroundings.gravity
    builder = ForceFieldBuilder(brief, anchored, gravity, notes=list(intent.notes))
    builder.obstacles += resolve_obstacles(intent.surroundings.solids, None, brief)
    events = make_events(meanings, builder)
    slots, frame_count, remarks = schedule(events, brief, anchored)
    builder.brief = brief.model_copy(update={"frame_count": frame_count})
    builder.notes += remarks
    compile_slots(slots, builder)
    _state_gravity(intent, builder)
    _expect_stillness(meanings, builder)
    _collect_doubts(intent, unknown, builder)
    return SemanticReply(
        force_field=builder.build(),
        expectations=tuple(builder.expectations),
        anchor=anchor,
        world=WorldRequest(
            gravity=builder.gravity,
            ground=intent.surroundings.ground,
            obstacles=tuple(builder.obstacles),
            words=_quote_world(intent),
        ),
        frame_count=None if frame_count == brief.frame_count else frame_count,
        materials=intent.materials,
        ignored=intent.ignored,
        unsure=tuple(builder.unsure),
        evidence=tuple([*builder.evidence, *_collect_anchor_evidence(anchor)]),
        not_understood=intent.unknown,
        notes=tuple(builder.notes),
    )


def _check_known(intent: Intent, meanings: list[Meaning], brief: SceneBrief) -> None:
    """Refuse an intent of which nothing is known."""
    known = any(meaning.motion is not None for meaning in meanings)
    if known or intent.held is not None or intent.surroundings.gravity is not None:
        return
    words = [clause.motion or clause.cause or "" for clause in intent.clauses]
    if not any(words):
        raise UserError(
            "The prompt names no motion that is understood",
            do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
        )
    near = [each for word in words for each in suggest_motions(word)]
    nearest = f"; the nearest known motions are {', '.join(map(repr, near))}" if near else ""
    raise UserError(
        "The motion is not known",
        got=", ".join(repr(word) for word in words if word),
        do=f"Say with another word what should happen to the {brief.object_name}, for example {EXAMPLES}{nearest}",
    )


def _state_gravity(intent: Intent, builder: ForceFieldBuilder) -> None:
    """Gravity named without a falling motion; explicit weightlessness is recorded too."""
    told = intent.surroundings
    words = told.text or "gravity"
    if builder.gravity is None or told.gravity is None:
        return
    if builder.gravity == "none":
        why = "no gravity is asked for"
        builder.evidence.append(Evidence(words=words, field="default_drop", value="false", why=why))
    elif not builder.default_drop:
        if not (builder.grounded and builder.expectations):
            builder.enable_gravity(words, "gravity is named")
        if not builder.expectations:
            fall = read_lexicon().motions["fall"]
            event = Event(
                fall, "fall", words, "then", None, 1.0, sources={"action_type": ValueSource("", "")}
            )
            way = builder.brief.directions.up if builder.gravity == "up" else None
            builder.add_expectation(event, MotionKind.FALL, way, (0.0, builder.last))


def _expect_stillness(meanings: list[Meaning], builder: ForceFieldBuilder) -> None:
    """A sentence that forbids all motion, or only holds something, asks for stillness."""
    if builder.expectations:
        return
    for meaning in meanings:
        if meaning.clause.negated and meaning.verb is not None and meaning.verb.effect is Effect.STILL:
            builder.add_doubt("What it is to do, if not to be still, is not understood.")
    words = " ".join(meaning.words for meaning in meanings)
    window = builder.fit_window((0.0, builder.last)) or (0.0, builder.last)
    builder.expectations.append(ExpectedMotion(kind=MotionKind.STILL, window=window, words=words[:200]))


def _collect_doubts(intent: Intent, unknown: list[Meaning], builder: ForceFieldBuilder) -> None:
    """Adds what the intent doubts, and what the lexicon, the scene or the clip have no place for."""
    for meaning in unknown:
        for doubt in meaning.doubts or ["A clause without a motion is not understood."]:
            builder.add_doubt(doubt)
    if builder.gravity == "none" and any(each.kind is MotionKind.FALL for each in builder.expectations):
        builder.add_doubt("How it falls without gravity is not understood.")
    solids = [*intent.surroundings.solids, *(each for clause in intent.clauses for each in clause.solids)]
    if len(set(solids)) > len(builder.obstacles):
        words = solids[-1].text or solids[-1].kind
        builder.add_doubt(f"Where '{words}' is, is not understood.")
    for doubt in (*intent.doubts, *(f"'{word}' is not understood." for word in intent.unknown)):
        builder.add_doubt(doubt)


def _quote_world(intent: Intent) -> str:
    """The words about gravity, ground, walls and blocks."""
    solids = [*intent.surroundings.solids, *(each for clause in intent.clauses for each in clause.solids)]
    words = [intent.surroundings.text, *(each.text or each.kind for each in solids)]
    return ", ".join(dict.fromkeys(word for word in words if word))


def _collect_anchor_evidence(anchor: AnchorRequest) -> list[Evidence]:
    if anchor.kind is None:
        return []
    return [
        Evidence(words=anchor.words, field="anchor", value=anchor.kind, why="words about holding or freedom")
    ]
