"""The compiler: an intent and the brief -> force field, expectations and evidence, by rules alone.

The paper's two rules hold: base vectors come from the brief's direction table and are never changed, and what the
lexicon maps a word to takes precedence over whatever else an agent thinks of it.
"""

from __future__ import annotations

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.holding import apply_holding, choose_anchor
from physagent_jax.agents.compiler.interpretation import resolve_obstacles
from physagent_jax.agents.compiler.kinds import choose_reply_kinds
from physagent_jax.agents.compiler.schedule import schedule
from physagent_jax.agents.compiler.sequence import make_events
from physagent_jax.agents.compiler.skills import compile_slots
from physagent_jax.agents.compiler.words import Meaning, look_up, suggest_motions
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.schema import (
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
    told = [look_up(clause) for clause in intent.clauses]
    known = [meaning for meaning in told if meaning.motion is not None]
    unknown = [meaning for meaning in told if meaning.motion is None]
    if not known and intent.held is None and intent.surroundings.gravity is None:
        raise _refuse(unknown, brief)
    meanings = apply_holding(known, intent.held)
    anchor = choose_anchor(intent.held, meanings)
    anchored = anchor.kind in ("base", "top") or (brief.anchored is not None and anchor.kind != "none")
    builder = ForceFieldBuilder(brief, anchored, intent.surroundings.gravity, notes=list(intent.notes))
    builder.obstacles += resolve_obstacles(intent.surroundings.solids, None, brief)
    slots, frame_count, remarks = schedule(make_events(meanings, builder), brief, anchored)
    builder.brief = brief.model_copy(update={"frame_count": frame_count})
    builder.notes += remarks
    compile_slots(slots, builder)
    _state_gravity(intent, builder)
    _expect_stillness(meanings, builder)
    _collect_doubts(intent, unknown, builder)
    if anchor.kind is not None:
        why = "words about holding or freedom"
        builder.evidence.append(Evidence(words=anchor.words, field="anchor", value=anchor.kind, why=why))
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
        evidence=tuple(builder.evidence),
        not_understood=intent.unknown,
        notes=tuple(builder.notes),
    )


def _refuse(unknown: list[Meaning], brief: SceneBrief) -> UserError:
    """The error for an intent of which nothing is known, with the nearest known motions."""
    words = [meaning.clause.motion or meaning.clause.cause or "" for meaning in unknown]
    do = f"Say in other words what should happen to the {brief.object_name}, for example {EXAMPLES}"
    if not any(words):
        return UserError("The prompt names no motion that is understood", do=do)
    near = [each for word in words for each in suggest_motions(word)]
    nearest = f"; the nearest known motions are {', '.join(map(repr, near))}" if near else ""
    return UserError(
        "The motion is not known", got=", ".join(map(repr, filter(None, words))), do=do + nearest
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
    elif not (builder.grounded and builder.expectations):
        builder.enable_gravity(words, "gravity is named")
    if not builder.expectations and builder.gravity != "none":
        way = builder.brief.directions.up if builder.gravity == "up" else None
        _expect(MotionKind.FALL, words, builder, way)


def _expect_stillness(meanings: list[Meaning], builder: ForceFieldBuilder) -> None:
    """A sentence that forbids all motion, or only holds something, asks for stillness."""
    if builder.expectations:
        return
    for meaning in meanings:
        if meaning.clause.negated and meaning.verb is not None and meaning.verb.effect is Effect.STILL:
            builder.add_doubt("What it is to do, if not to be still, is not understood.")
    _expect(MotionKind.STILL, " ".join(meaning.words for meaning in meanings), builder)


def _expect(kind: MotionKind, words: str, builder: ForceFieldBuilder, way=None) -> None:
    """Expects a motion during the whole clip."""
    window = (0.0, builder.last)
    builder.expectations.append(
        ExpectedMotion(
            kind=kind, direction=way, window=builder.fit_window(window) or window, words=words[:200]
        )
    )


def _collect_doubts(intent: Intent, unknown: list[Meaning], builder: ForceFieldBuilder) -> None:
    """Adds what the intent doubts, and what the lexicon, the scene or the clip have no place for."""
    for meaning in unknown:
        for doubt in meaning.doubts or ["A clause without a motion is not understood."]:
            builder.add_doubt(doubt)
    if builder.gravity == "none" and any(each.kind is MotionKind.FALL for each in builder.expectations):
        builder.add_doubt("How it falls without gravity is not understood.")
    solids = _list_solids(intent)
    if len(set(solids)) > len(builder.obstacles):
        builder.add_doubt(f"Where '{solids[-1].text or solids[-1].kind}' is, is not understood.")
    for doubt in (*intent.doubts, *(f"'{word}' is not understood." for word in intent.unknown)):
        builder.add_doubt(doubt)


def _list_solids(intent: Intent) -> list:
    """The walls and blocks of surroundings and clauses."""
    return [*intent.surroundings.solids, *(each for clause in intent.clauses for each in clause.solids)]


def _quote_world(intent: Intent) -> str:
    """The words about gravity, ground, walls and blocks."""
    words = [intent.surroundings.text, *(each.text or each.kind for each in _list_solids(intent))]
    return ", ".join(dict.fromkeys(word for word in words if word))
