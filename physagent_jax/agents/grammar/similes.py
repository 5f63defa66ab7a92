"""Similes: "sways like seaweed", "bends as if pushed from the left", "moves like a metronome".

A simile tells how something is done that is told already; its own words are about another thing. Where the verb says
nothing by itself ("moves"), a well-known model does ("like a pendulum"). How fast or how hard something goes that is
done "like a feather" is not understood.
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.modifiers import DIRECTIONS
from physagent_jax.agents.rules.language.verbs import VERBS, Effect, Verb

# Things that are known for one motion: the verb that says the same.
MODELS: dict[str, str] = {
    model: verb
    for models, verb in {
        "pendulum, metronome, seaweed, cradle, reed, hammock": "swing",
        "jelly, jello, pudding": "wobble",
        "propeller, carousel, ballerina, dreidel, turbine": "spin",
        "rocket": "soar",
        "frog, kangaroo, rabbit": "hop",
        "stone, rock, brick, anvil": "fall",
    }.items()
    for model in models.split(", ")
}
_SHAPED = (
    Effect.SWAY,
    Effect.TURN,
    Effect.LEAN,
    Effect.TOPPLE,
    Effect.SCALE,
    Effect.SWELL,
    Effect.BURST,
    Effect.JUMP,
)
_ASIDE = frozenset({"would", "d", "i", "look", "looks", "looking", "they", "we", "you"})
_SUPPOSING = frozenset({"as if", "as though"})
_SETTING = frozenset({"in", "during"})
_GOES_ON = (
    MentionKind.JOIN,
    MentionKind.TIME,
    MentionKind.REPEAT,
    MentionKind.QUANTITY,
    MentionKind.SENSE,
    MentionKind.FROM,
    MentionKind.SOLID,
)


def read_similes(mentions: list[Mention]) -> list[Mention]:
    """The mentions with those of similes emptied, as far as the motion is known without them."""
    result = list(mentions)
    for index, mention in enumerate(mentions):
        if mention.kind is not MentionKind.FUNCTION or result[index].phrase == "simile":
            continue
        if mention.form == "like" and not (index and mentions[index - 1].form in _ASIDE):
            _read_likeness(result, index)
        elif mention.phrase in _SUPPOSING:
            _read_supposition(result, index)
    return result


def _read_likeness(mentions: list[Mention], index: int) -> None:
    """Empties "like a leaf"; of "like in a storm" the storm is left."""
    behind = next((m for m in mentions[index + 1 :] if m.form not in ("a", "an", "the", "real")), None)
    if behind is None or behind.form in _SETTING and _find_cause(mentions, index) is not None:
        return
    end = _find_end(mentions, index)
    verb, at = _find_verb(mentions, index)
    words = {m.words.lower() for m in mentions[index:end]} | {m.form for m in mentions[index:end]}
    model = next((MODELS[word] for word in words if word in MODELS), None)
    if verb is None or not _is_telling(verb):
        same = verb is not None and model is not None and VERBS[model].effect is verb.effect
        if model is None or verb is not None and not verb.generic and not same:
            return
        if at is not None and not same:
            mentions[at] = replace(mentions[at], value=VERBS[model], phrase=model)
        elif at is None:
            return
    for place in range(index, end):
        mentions[place] = empty(mentions[place], "simile")


def _read_supposition(mentions: list[Mention], index: int) -> None:
    """Reads "as if pushed from the left": which way and how hard; "as though it had seen a ghost": nothing."""
    verb, _ = _find_verb(mentions, index)
    end = _find_end(mentions, index)
    done = next((at for at in range(index, end) if mentions[at].kind is MentionKind.VERB), None)
    if verb is None or not (_is_telling(verb) or not verb.generic):
        return
    if (
        done is None
        and not any(m.kind is MentionKind.CAUSE for m in mentions[index:end])
        and (_is_telling(verb) or verb.effect is Effect.RELEASE)
    ):
        for place in range(index, end):
            mentions[place] = empty(mentions[place], "simile")
    elif done is not None:
        supposed = mentions[done].value
        pulls = isinstance(supposed, Verb) and supposed.pulls
        mentions[done] = empty(mentions[done], "simile")
        for place in range(done, len(mentions)):
            if mentions[place].kind is MentionKind.JOIN:
                break
            if pulls and not verb.pulls and mentions[place].kind is MentionKind.FROM:
                mentions[place] = replace(mentions[place], kind=MentionKind.DIRECTION)


def _is_telling(verb: Verb) -> bool:
    """Return whether a verb says what form its motion has, so that a likeness adds nothing to it."""
    stretches = verb.effect is Effect.SCALE and verb.sign > 0  # which way, the likeness may tell
    return not verb.generic and verb.effect in _SHAPED and not stretches


def _find_verb(mentions: list[Mention], index: int) -> tuple[Verb | None, int | None]:
    """Find the verb of the simile's own segment, and its place."""
    for at in range(index - 1, -1, -1):
        if mentions[at].kind is MentionKind.JOIN and mentions[at].words == ".":
            break
        value = mentions[at].value
        if mentions[at].kind is MentionKind.VERB and isinstance(value, Verb):
            return value, at
    return None, None


def _find_cause(mentions: list[Mention], index: int) -> int | None:
    return next((at for at in range(index, len(mentions)) if mentions[at].kind is MentionKind.CAUSE), None)


def _find_end(mentions: list[Mention], index: int) -> int:
    """Find the end of the simile: a connective, a way, a time, a count."""
    for at in range(index + 1, len(mentions)):
        mention = mentions[at]
        goes_on = mention.kind in _GOES_ON
        way = mention.kind is MentionKind.DIRECTION and (
            mentions[at - 1].form in ("to", "the") or " " in mention.phrase and mention.phrase in DIRECTIONS
        )
        setting = mention.form in _SETTING and mention.kind is MentionKind.FUNCTION and at > index + 1
        if goes_on or way or setting and _find_cause(mentions, at) is not None:
            while at > index + 1 and mentions[at - 1].form in ("to", "the") and way:
                at -= 1
            return at
    return len(mentions)
