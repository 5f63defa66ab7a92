"""Statements beyond the grammar: words, things and comparisons that would change the motion.

What is found here keeps a run from being called a success. Words that only decorate (an adjective of the object, who
acts) are no doubt.
"""

from __future__ import annotations

from physagent_jax.agents.rules.language.clauses import Clause, get_verb
from physagent_jax.agents.rules.language.comparisons import find_comparisons
from physagent_jax.agents.rules.language.constructions import find_constructions
from physagent_jax.agents.rules.language.contradictions import find_contradictions
from physagent_jax.agents.rules.language.elsewhere import find_elsewhere
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import LOCATIONS, PARTS, Place
from physagent_jax.agents.rules.language.movers import find_other_movers
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import get_phrase
from physagent_jax.agents.rules.language.particles import find_particles
from physagent_jax.agents.rules.language.parts import find_parts
from physagent_jax.agents.rules.language.questions import find_questions
from physagent_jax.agents.rules.language.retractions import find_retractions
from physagent_jax.agents.rules.language.series import find_series
from physagent_jax.agents.rules.language.sides import find_sides
from physagent_jax.agents.rules.language.suppositions import find_suppositions
from physagent_jax.agents.rules.language.surroundings import find_surroundings
from physagent_jax.agents.rules.language.turnings import find_turnings
from physagent_jax.agents.rules.language.unplaced import UNPLACED_PARTS
from physagent_jax.agents.rules.language.verbs import CAUSES, Effect, Verb
from physagent_jax.agents.schema import SceneBrief

# Other things, when something is done to them; elsewhere they are who or what acts.
THINGS = frozenset({"ball", "hammer", "rope", "string", "stick"})
_TELLING = (
    MentionKind.DIRECTION,
    MentionKind.FROM,
    MentionKind.AXIS,
    MentionKind.PLANE,
    MentionKind.SIDES,
    MentionKind.SENSE,
    MentionKind.PLACE,
    MentionKind.EXCLUDED,
    MentionKind.REPEAT,
    MentionKind.TIME,
    MentionKind.REVERSAL,
)
_PAIRS = frozenset({"two", "three", "four", "both", "several"})


def find_doubts(
    mentions: list[Mention],
    names: frozenset[str],
    unknown: list[str],
    clauses: list[Clause],
    brief: SceneBrief,
    prompt: str,
) -> list[str]:
    """Plain sentences about what was not understood and would change the motion."""
    doubts = [f"'{word}' is not understood." for word in unknown]
    named = any(mention.phrase in names for mention in mentions)
    own = brief.object_name.lower().split()
    for index, mention in enumerate(mentions):
        before = get_phrase(mentions, index - 1)
        following = mentions[index + 1] if index + 1 < len(mentions) else None
        if (
            mention.form == "like"
            and mention.kind is MentionKind.FUNCTION
            and before not in ("would", "d", "i")
            and not _is_naming_cause(mentions, index)
        ):
            doubts.append("What comes after 'like' is a comparison, and comparisons are not understood.")
        elif (
            mention.form == "way"
            and before == "the"
            and get_phrase(mentions, index - 2) not in ("all", "half")
        ):
            doubts.append("'the way' of doing it is not understood.")
        elif mention.kind is MentionKind.EXCEPT:
            doubts.append(f"What '{mention.words}' leaves out is not understood.")
        elif mention.form in ("apart", "together") and get_phrase(mentions, index - 1) in names | THINGS:
            doubts.append(f"What goes '{mention.form}' is more than one object.")
        elif mention.phrase in names and before in _PAIRS:
            doubts.append(f"There is only one object here, not '{before} {mention.words}'.")
        elif (
            mention.phrase in UNPLACED_PARTS and mention.phrase not in names and _is_acted_on(mentions, index)
        ):
            doubts.append(f"Where the '{mention.words}' of the object is, is not known.")
        elif (
            mention.phrase in THINGS
            and named
            and mention.phrase not in names
            and _is_acted_on(mentions, index)
        ):
            doubts.append(f"'{mention.words}' is another thing, and there is only one object here.")
        elif mention.phrase in LOCATIONS and _find_next_telling(mentions, index) is MentionKind.PLACE:
            doubts.append(f"Where '{mention.words}' that part is, is not known.")
        elif mention.phrase in ("table", "shelf", "cliff") and "off" in (
            before,
            get_phrase(mentions, index - 2),
        ):
            doubts.append(f"There is no {mention.words} here.")
        elif mention.phrase == "gravity" and mention.value == "down" and _is_turning_aside(mentions, index):
            doubts.append("Gravity acts downwards, upwards or not at all here.")
        elif mention.form in ("second", "third", "fourth", "fifth", "last") and following is not None:
            if following.kind is MentionKind.PLACE or following.phrase in UNPLACED_PARTS | frozenset(PARTS):
                doubts.append(f"Which part '{mention.form} {following.words}' is, is not known.")
    for clause in clauses:
        holds = clause.verb is not None and get_verb(clause.verb).effect is Effect.HOLD and not clause.negated
        ways = [m for m in clause.select(MentionKind.DIRECTION) if holds and m.value != ("down",)]
        ways += [m for m in clause.select(MentionKind.FROM) if holds and m.value != ("up",)]
        if ways:
            doubts.append(f"How it is held '{ways[0].words}' is not understood.")
    doubts += [
        f"What '{m.words}' counts is not understood." for m in _find_loose_quantities(mentions, clauses)
    ]
    doubts += [
        f"What '{m.words}' belongs to is not understood."
        for clause in clauses
        if clause.head is None
        and not clause.select(MentionKind.ANCHOR)
        and not _is_told_again(clause, clauses)
        for m in clause.select(*_TELLING)
    ]
    if not any(mention.phrase in own for mention in mentions):
        doubts += [
            f"Whether '{m.words}' is the whole object or a part of it is not known."
            for m in mentions
            if isinstance(m.value, Place) and m.value.start < 0.5 and m.phrase in brief.object_nouns
            if m.phrase not in PARTS
        ]
    doubts += find_other_movers(mentions, names)
    doubts += find_constructions(mentions) + find_comparisons(mentions) + find_parts(mentions)
    doubts += find_questions(mentions, prompt, names)
    doubts += find_suppositions(mentions, names)
    doubts += find_series(mentions)
    doubts += find_retractions(mentions)
    doubts += find_sides(mentions, names) + find_particles(mentions, names) + find_turnings(mentions, names)
    doubts += find_surroundings(mentions) + find_elsewhere(mentions)
    doubts += find_contradictions(clauses)
    return list(dict.fromkeys(doubts))


def _is_told_again(clause: Clause, clauses: list[Clause]) -> bool:
    """Return whether all that a clause without a verb says is said with one: "not left, right! push it right"."""
    said = [(m.kind, m.value) for c in clauses if c.head is not None for m in c.select(*_TELLING)]
    said += [
        (MentionKind.DIRECTION, (get_verb(c.verb).direction,))
        for c in clauses
        if c.verb is not None and get_verb(c.verb).direction is not None
    ]
    return all((m.kind, m.value) in said for m in clause.select(*_TELLING))


def _find_next_telling(mentions: list[Mention], index: int) -> MentionKind | None:
    """The kind of the next mention that is no article."""
    return next((m.kind for m in mentions[index + 1 :] if m.kind is not MentionKind.FUNCTION), None)


def _is_turning_aside(mentions: list[Mention], index: int) -> bool:
    """Return whether what follows gravity, before any verb, is a direction to a side."""
    for mention in mentions[index + 1 :]:
        pulls = (
            isinstance(mention.value, Verb) and mention.value.effect is Effect.PUSH
        )  # "gravity pulls it aside"
        if mention.kind is MentionKind.JOIN or mention.kind is MentionKind.VERB and not pulls:
            return False
        if mention.kind in (MentionKind.DIRECTION, MentionKind.PLANE):
            return mention.value not in (("down",), ("up",))
    return False


def _find_loose_quantities(mentions: list[Mention], clauses: list[Clause]) -> list[Mention]:
    """Quantities that no clause with a verb has taken up."""
    used = [m for clause in clauses if clause.head is not None for m in clause.modifiers]
    used += [m for clause in clauses if clause.verb is not None for m in clause.mentions]
    return [
        m for m in mentions if m.kind is MentionKind.QUANTITY and not any(m.first == u.first for u in used)
    ]


def _is_acted_on(mentions: list[Mention], index: int) -> bool:
    """Return whether a thing is what is moved rather than what moves: "pull the handle", not "hit by a hammer"."""
    before = index - 1
    while before >= 0 and (
        mentions[before].phrase in DETERMINERS
        or mentions[before].kind in (MentionKind.UNKNOWN, MentionKind.ORDINAL)
        or mentions[before].phrase in ("second", "third", "first", "last")
    ):
        before -= 1
    if before < 0:
        return any(m.kind is MentionKind.VERB for m in mentions[index : index + 2])
    mention = mentions[before]
    if mention.phrase in ("by", "with") and mentions[index].phrase in UNPLACED_PARTS:
        return mentions[index].phrase not in THINGS | {"finger", "fingers", "hook"}
    joined = mention.kind is MentionKind.JOIN and mention.words.lower() == "and" and before > 0
    return mention.kind is MentionKind.VERB or joined or mention.phrase in ("of", "s")


def _is_naming_cause(mentions: list[Mention], index: int) -> bool:
    """Return whether what follows is a cause that is understood: "like in a storm"."""
    return any(m.kind is MentionKind.CAUSE or m.phrase in CAUSES for m in mentions[index + 1 : index + 5])
