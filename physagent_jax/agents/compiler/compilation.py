"""The compiler: an intent and the brief -> force field, expectations and evidence, by rules alone.

The paper's two rules hold: base vectors come from the brief's direction table and are never changed, and what the
lexicon maps a word to takes precedence over whatever else an agent thinks of it.
"""

from __future__ import annotations

from collections.abc import Iterable

from physagent_jax.agents.compiler.builder import ForceFieldBuilder
from physagent_jax.agents.compiler.events import Event
from physagent_jax.agents.compiler.interpretation import resolve_obstacles
from physagent_jax.agents.compiler.limbs import bears_all, drive_limbs, find_support
from physagent_jax.agents.compiler.schedule import schedule
from physagent_jax.agents.compiler.sequence import apply_holding, choose_anchor, make_events
from physagent_jax.agents.compiler.skills import compile_slots
from physagent_jax.agents.compiler.words import look_up, suggest_motions
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.lexicon import Effect
from physagent_jax.agents.materials import (
    BROKEN,
    CRUSHED,
    FLOWS,
    GIVING,
    LIMP,
    SOFT,
    YIELDING,
    YIELDS,
    find_meaning,
)
from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_entry
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.breaking import find_burst
from physagent_jax.motion.kinds import choose_kinds
from physagent_jax.motion.matching import find_new_places
from physagent_jax.motion.parts import explain_missing, list_names
from physagent_jax.motion.schema import AnchorRequest, MotionKind, SceneBrief, WorldRequest

EXAMPLES = (
    '"push the robot to the left", "a gentle wind sways the plant", "drop the guitar", "twist the loaf"'
)
_SHAPING = (Effect.LEAN, Effect.SWAY, Effect.SCALE, Effect.SWELL, Effect.BURST)
_RESTITUTION = 0.7
"""Coefficient of restitution of what is hard and is to come off a wall [1]: high enough to be seen."""


def compile_intent(intent: Intent, brief: SceneBrief) -> SemanticReply:
    """The reply to an intent, with the kind of each skill chosen: body forces or velocity constraints.

    Raises:
        UserError: No motion is known, and nothing is said about holding or gravity.
    """
    return _choose_kinds(drive_limbs(compile_forces(intent, brief), brief), brief)


def compile_forces(intent: Intent, brief: SceneBrief) -> SemanticReply:
    """The reply to an intent in the paper's four skills, all of them body forces.

    Raises:
        UserError: No motion is known, and nothing is said about holding or gravity.
    """
    flows = _is_of(FLOWS, intent)  # it collapses where it stands
    clauses = [
        each.model_copy(update=dict(motion="melt")) if flows and each.motion == "collapse" else each
        for each in intent.clauses
    ]
    told = [look_up(clause, list_names(brief)) for clause in clauses]
    for event in told:
        if bears_all(event, brief):  # "the trunk bends": so does all of the tree
            event.parts.clear()
    known = [event for event in told if event.is_known]
    unknown = [event for event in told if not event.is_known]
    if not known and intent.held is None and intent.surroundings.gravity is None:
        raise _refuse(unknown, brief)
    clauses = apply_holding(known, intent.held)
    anchor = choose_anchor(intent.held, clauses, brief)
    anchor = find_support(clauses, brief, _is_soft(SOFT, intent, brief)) if anchor.kind is None else anchor
    held = anchor.kind in ("base", "top", "rest")
    anchored = held or (brief.anchored is not None and anchor.kind != "none")
    rooted = anchored and "top" not in (anchor.kind or brief.anchored or "")
    builder = ForceFieldBuilder(brief, anchored, intent.surroundings.gravity, rooted=rooted)
    builder.soft, builder.breaks = _is_soft(GIVING, intent, brief), _is_of(("brittle",), intent)
    builder.bursts = 0.0 if anchored or builder.gravity else _find_burst(clauses, intent, brief)
    builder.notes += intent.notes
    builder.obstacles += resolve_obstacles(intent.surroundings.solids, None, brief)
    slots, frame_count, remarks = schedule(make_events(clauses, builder), brief, anchored)
    builder.brief = brief.model_copy(update={"frame_count": frame_count})
    builder.notes += remarks
    compile_slots(slots, builder)
    _state_gravity(intent, builder)
    _expect_stillness(clauses, builder)
    solids = [*intent.surroundings.solids, *(each for clause in intent.clauses for each in clause.solids)]
    unknown_parts = [*(word for event in told for word in event.unknown_parts), *intent.unknown_parts]
    words = [intent.surroundings.text, *(each.text or each.kind for each in solids)]
    if len(set(solids)) > len(builder.obstacles):
        builder.unsure.append(f"Where '{words[-1]}' is, is not understood.")
    _collect_doubts(intent, unknown, builder)
    if builder.attitude is not None and anchor.kind is None:  # it would not stand so, and does not have to
        anchor, builder.gravity = AnchorRequest(kind="none", words="it falls"), "down"
    if anchor.kind is not None:
        builder.add_evidence(anchor.words, "anchor", anchor.kind, "words about holding or freedom")
    return SemanticReply(
        force_field=ForceField(
            default_drop=builder.default_drop,
            actions=tuple(builder.actions),
            constraints=tuple(builder.constraints),
        ),
        expectations=tuple(builder.expectations),
        anchor=anchor,
        world=WorldRequest(
            gravity=builder.gravity,
            ground=intent.surroundings.ground,
            obstacles=tuple(builder.obstacles),
            drop_height=builder.drop_height,
            attitude=builder.attitude,
            restitution=_RESTITUTION if any(each.rebounds for each in solids) else None,
            words=", ".join(dict.fromkeys(filter(None, words))),
        ),
        frame_count=None if frame_count == brief.frame_count else frame_count,
        materials=_choose_materials(intent, (*clauses, *(e for slot in slots for e in slot.events)), brief),
        ignored=intent.ignored,
        unsure=tuple(dict.fromkeys(builder.unsure)),
        unknown_parts=tuple(dict.fromkeys(unknown_parts)),
        evidence=tuple(builder.evidence),
        not_understood=intent.unknown,
        notes=tuple(dict.fromkeys(builder.notes)),
    )


def _choose_materials(intent: Intent, events: Iterable[Event], brief: SceneBrief) -> tuple[str, ...]:
    """The sentence's words for materials, and one for what gives way where they name nothing that does."""
    events = list(events)
    happens = [event.motion for event in events]
    # "Sags, then springs back".
    springs = any(each.effect is Effect.RELEASE and not each.lets_go for each in happens)
    firm = not springs and brief.object_kind not in LIMP and not _is_of(YIELDS, intent)
    firm &= any(each.gives for each in happens)
    severed = [event.words.lower() for event in events if event.motion.manner == "detach"]
    told = tuple(word for word in intent.materials if not any(word in each for each in severed))
    if any(each.manner == "split" for each in happens) and not any(each.gives for each in happens):
        told = tuple(word for word in told if not _is_brittle(word))  # whole but for where it is split
    if any(event.bursts for event in events):
        told, firm = tuple(word for word in told if not _is_brittle(word)), False  # whole until it bursts
    crushed = any(each.effect is Effect.STRIKE and each.gives for each in happens)
    broken = any(event.phrase == "break" for event in events)  # "it snaps"
    return (*told, CRUSHED if crushed else BROKEN if broken else YIELDING) if firm else told


def _find_burst(clauses: list[Event], intent: Intent, brief: SceneBrief) -> float:
    """Strength with which it goes to pieces, after motions of the whole alone or by itself; 0 = it does not."""
    shaped = any(each.effect in _SHAPING and not each.motion.gives for each in clauses)
    parted = shaped or any(each.parts or each.motion.manner in ("detach", "split") for each in clauses)
    solids = intent.surroundings.solids or any(each.clause.solids for each in clauses)
    said = all(_is_brittle(word) for word in intent.materials)
    return 0.0 if parted or solids else find_burst(intent.materials, brief, by_kind=said)


def _is_brittle(word: str) -> bool:
    meaning = find_meaning(word)
    return meaning is not None and meaning.becomes and meaning.preset in ("brittle", "sand")


def _is_soft(presets: tuple[str, ...], intent: Intent, brief: SceneBrief) -> bool:
    """Return whether the object is of one of some presets, by its kind unless the sentence says what it is made of."""
    return _is_of(presets, intent) if intent.materials else brief.object_kind in presets


def _is_of(presets: tuple[str, ...], intent: Intent) -> bool:
    """Return whether the sentence says that the object is of one of some presets."""
    return any(each and each.preset in presets for each in map(find_meaning, intent.materials))


def _refuse(unknown: list[Event], brief: SceneBrief) -> UserError:
    """The error for an intent of which nothing is known, with the nearest known motions."""
    words = [each for event in unknown if (each := event.clause.motion or event.clause.cause)]
    do = f"Say in other words what should happen to the {brief.object_name}, for example {EXAMPLES}"
    if not words:
        return UserError("The prompt names no motion that is understood", do=do)
    near = [each for word in words for each in suggest_motions(word)]
    nearest = f"; the nearest known motions are {', '.join(map(repr, near))}" if near else ""
    return UserError("The motion is not known", got=", ".join(map(repr, words)), do=do + nearest)


def _state_gravity(intent: Intent, builder: ForceFieldBuilder) -> None:
    """Gravity named without a falling motion; explicit weightlessness is recorded too."""
    told = intent.surroundings
    words = told.text or "gravity"
    if builder.gravity is None or told.gravity is None:
        return
    if builder.gravity == "none":
        builder.add_evidence(words, "default_drop", "false", "no gravity is asked for")
    elif not (builder.grounded and builder.expectations):
        builder.enable_gravity(words, "gravity is named")
    if not builder.expectations and builder.gravity != "none":
        way = builder.brief.directions.up if builder.gravity == "up" else None
        builder.expect(MotionKind.FALL, way, (0.0, builder.brief.last), words)


def _expect_stillness(clauses: list[Event], builder: ForceFieldBuilder) -> None:
    """A sentence that forbids all motion, or only holds something, asks for stillness."""
    if builder.expectations:
        return
    for event in clauses:
        if event.clause.negated and event.verb is not None and event.verb.effect is Effect.STILL:
            builder.unsure.append("What it is to do, if not to be still, is not understood.")
    words = " ".join(event.words for event in clauses)
    builder.expect(MotionKind.STILL, None, (0.0, builder.brief.last), words)


def _collect_doubts(intent: Intent, unknown: list[Event], builder: ForceFieldBuilder) -> None:
    """Adds what the intent doubts, and what the lexicon, the scene or the clip have no place for."""
    for event in unknown:
        builder.unsure += event.doubts or ["A clause without a motion is not understood."]
    if builder.gravity == "none" and any(each.kind is MotionKind.FALL for each in builder.expectations):
        builder.unsure.append("How it falls without gravity is not understood.")
    builder.unsure += intent.doubts
    for word in intent.unknown:
        missing = explain_missing(word, builder.brief.parts) if word in intent.unknown_parts else ""
        builder.unsure.append(missing or f"'{word}' is not understood.")


def _choose_kinds(reply: SemanticReply, brief: SceneBrief) -> SemanticReply:
    """The reply with velocity constraints where they do what the sentence says and a force does not."""
    told = {
        "base": "the base",
        "top": "the top",
        "rest": "all but the part",
        "none": None,
        None: brief.anchored,
    }
    weightless = reply.world.gravity in ("none", "up") or reply.world.ground is False
    world = "free" if weightless else "ground" if reply.world.ground else brief.world
    frame_count, fixture = reply.frame_count or brief.frame_count, told[reply.anchor.kind]
    scene = brief.model_copy(update=dict(anchored=fixture, frame_count=frame_count, world=world))
    if scene.frame_count < 2:
        return reply  # nothing moves in one frame
    choice = choose_kinds(reply.force_field, reply.expectations, scene)
    if not choice.reasons:
        return reply
    places = find_new_places(reply.force_field, choice.force_field)
    evidence = tuple(_follow(item, places, choice.force_field) for item in reply.evidence)
    notes = (*reply.notes, *choice.reasons)
    return reply.model_copy(update=dict(force_field=choice.force_field, evidence=evidence, notes=notes))


def _follow(item: Evidence, places: dict[str, str], force_field: ForceField) -> Evidence:
    """Evidence of an action as that of what stands for it: its new place, and what is there now."""
    place, dot, name = item.field.partition(".")
    new = places.get(place, place)
    group, _, index = new.rstrip("]").partition("[")
    if group != "constraints":
        return item.model_copy(update={"field": new + dot + name})
    name = "constraint_type" if name == "action_type" else name
    values = describe_entry(force_field.constraints[int(index)])
    return item.model_copy(update={"field": f"{new}.{name}", "value": values.get(name, item.value)})
