"""Constructions that the grammar has no reading for, although it knows each of their words.

Taken word by word they would say something else: "left or right", "everything but rotate", "not to the left". A rule
here holds for a construction, whatever the words in it; `comparisons`, `parts`, `particles`, `sides`, `turnings`,
`series` and `suppositions` hold others of one kind each.
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.function_words import FUNCTION_WORDS, PAUSES
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import (
    WHOLE_WORDS,
    Join,
    Place,
    Repeat,
)
from physagent_jax.agents.rules.language.naming import DETERMINERS, OWNERS
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, find_telling, get_phrase, has_motion
from physagent_jax.agents.rules.language.tokens import FORMS, is_participle
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_CHOOSABLE = (*MOTIONS, *WAYS, MentionKind.PLACE)
_POSTURES = frozenset({"stand", "sit", "lay", "lie", "rest"})
_KEEPING = frozenset({"keep", "keeps", "keeping", "kept"})
_ALTERNATING = frozenset({"alternately", "alternating", "alternatingly"})
_PARTICLES = frozenset({"in", "out", "around", "about", "through", "across", "along", "on", "off"})


def find_constructions(mentions: list[Mention]) -> list[str]:
    """Plain sentences about constructions that were not understood."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_end_over_end(mentions: list[Mention], index: int) -> list[str]:
    """Says "spin it end over end": about which axis?"""
    verb = next((m.value for m in reversed(mentions[:index]) if isinstance(m.value, Verb)), None)
    upright = verb is None or verb.direction == "up"  # it tumbles so anyway
    if upright and [m.form for m in mentions[index : index + 3]] == ["end", "over", "end"]:
        return ["How it turns 'end over end' is not understood."]
    return []


def _find_interval(mentions: list[Mention], index: int) -> list[str]:
    """Says "between two pushes it rests"."""
    after = [m.kind for m in mentions[index + 1 : index + 3]]
    between = mentions[index].form == "between" and mentions[index].kind is MentionKind.FUNCTION
    if between and after and (after[0] is MentionKind.REPEAT or after[-1] is MentionKind.VERB):
        return ["What is done 'between' is not understood."]
    return []


def _find_both_ways(mentions: list[Mention], index: int) -> list[str]:
    """Says "pull it left and right at the same time": not to and fro."""
    mention, before = mentions[index], mentions[:index]
    if mention.phrase not in ("at the same time", "simultaneously", "at once") or has_motion(
        mentions[index:]
    ):
        return []
    swings = any(isinstance(m.value, Repeat) and m.value.names for m in before)
    if swings and not any(m.kind is MentionKind.SIDES for m in before):
        return [f"How it goes both ways '{mention.words}' is not understood."]
    return []


def _find_figure(mentions: list[Mention], index: int) -> list[str]:
    """Says "it does the splits": the name of a figure, and not what the verb says."""
    mention = mentions[index]
    named = mention.kind is MentionKind.VERB and get_phrase(mentions, index - 1) == "the"
    if named and get_phrase(mentions, index - 2) in ("do", "does", "did", "doing"):
        return [f"What 'the {mention.words}' is to look like is not understood."]
    return []


def _find_nothing_that_can(mentions: list[Mention], index: int) -> list[str]:
    """Says "nothing can move it"."""
    if mentions[index].form == "nothing" and get_phrase(mentions, index + 1) in (
        "can",
        "could",
        "will",
        "would",
    ):
        return ["What 'nothing' can do is not understood."]
    return []


def _find_explanation(mentions: list[Mention], index: int) -> list[str]:
    """Says "it rises: it gets taller", "twice: first left, then right"."""
    if mentions[index].kind is not MentionKind.JOIN:
        return []
    if mentions[index].words == ":" and any(m.kind is MentionKind.REPEAT for m in mentions[:index]):
        return ["What is counted before ':' is not understood."]
    if mentions[index].words == ":" and has_motion(mentions[:index]) and has_motion(mentions[index:]):
        return ["Whether what stands behind ':' happens besides is not understood."]
    return []


def _find_sagging(mentions: list[Mention], index: int) -> list[str]:
    """Says "it collapses under its own weight": it gives way where it stands, and nobody lets it fall."""
    under = [m.form for m in mentions[max(index - 2, 0) : index]]
    if mentions[index].phrase in ("own weight", "its weight") and "under" in under:
        return [f"How it gives way under '{mentions[index].words}' is not understood."]
    return []


def _find_choice(mentions: list[Mention], index: int) -> list[str]:
    """Says "left or right", "push or pull it"; "neither ... or" is a list."""
    before, after = find_telling(mentions, index, -1), find_telling(mentions, index, 1)
    if mentions[index].form != "or" or before is None or after is None:
        return []
    if before.kind not in _CHOOSABLE or after.kind not in _CHOOSABLE:
        return []
    if any(m.kind is MentionKind.NOT for m in mentions[:index]):
        return []
    return [f"Which of '{before.words}' or '{after.words}' is meant is not understood."]


def _find_means(mentions: list[Mention], index: int) -> list[str]:
    """Says "stretch it by pulling its head": one thing, told twice."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    means = mention.kind is MentionKind.VERB and is_participle(mention.form) and before == "by"
    if means and has_motion(mentions[: index - 1]):
        return [f"How 'by {mention.words}' does it is not understood."]
    return []


def _find_attempt(mentions: list[Mention], index: int) -> list[str]:
    """Says "someone tries to lift it, but ...": it does not come to that."""
    tries = mentions[index].form in ("try", "tries", "tried", "trying")
    if tries and any(m.value is Join.BUT for m in mentions[index:]):
        return ["Whether what is tried succeeds is not understood."]
    return []


def _find_idle_denial(mentions: list[Mention], index: int) -> list[str]:
    """Says "but it can not", "or not": nothing follows that would not happen."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    if mentions[index].kind is MentionKind.NOT and ends and has_motion(mentions[:index]):
        return [f"What '{mentions[index].words}' denies is not understood."]
    return []


def _find_moving_holder(mentions: list[Mention], index: int) -> list[str]:
    """Says "mount it on a turntable that makes one turn in four seconds": what holds it moves, and it with that."""
    verb = next((m.value for m in reversed(mentions[:index]) if isinstance(m.value, Verb)), None)
    if mentions[index].phrase != "that makes" or verb is None or verb.effect is not Effect.HOLD:
        return []
    return ["Whether what holds it moves it along is not understood."]


def _find_counted_pause(mentions: list[Mention], index: int) -> list[str]:
    """Says "three times with pauses of a second": how long the pauses are, and not what comes after all."""
    mention = mentions[index]
    verb = mention.value
    rests = isinstance(verb, Verb) and verb.effect is Effect.STILL and not verb.generic
    if not rests or index == 0 or mentions[index - 1].kind is MentionKind.NOT:
        return []
    joined = any(m.form == "with" for m in mentions[max(index - 4, 0) : index])
    between = mention.form.endswith("ing") or mention.form.endswith("s") and joined
    if between and any(m.kind is MentionKind.REPEAT for m in mentions[:index]):
        return [f"When '{mention.words}' is, is not understood."]
    return []


def _find_idle_pause(mentions: list[Mention], index: int) -> list[str]:
    """Says "pausing in between" of what is not counted."""
    mention = mentions[index]
    if mention.phrase in PAUSES and not any(m.kind is MentionKind.REPEAT for m in mentions):
        return [f"What '{mention.words}' is between is not understood."]
    return []


def _find_posture(mentions: list[Mention], index: int) -> list[str]:
    """Says "lay it on its back", "it stands on its head": something is done, and not stillness."""
    mention = mentions[index]
    turns = isinstance(mention.value, Verb) and mention.value.effect is Effect.TURN
    if mention.kind is not MentionKind.VERB or not (turns or FORMS.get(mention.form) in _POSTURES):
        return []
    place = find_telling(mentions, index, 1)
    if place is not None and isinstance(place.value, Place) and "down" not in place.value.names:
        if any(m.phrase in ("on", "onto", "upon") for m in mentions[index : index + 4]):
            return [f"How it comes to be on its {place.words} is not understood."]
    if turns or mention.form not in _POSTURES:
        return []
    behind = mentions[index + 1] if index + 1 < len(mentions) else None
    imperative = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
    if imperative and behind is not None and behind.phrase in DETERMINERS | {"it", "him", "them"}:
        return [f"What '{mention.words}' does is not understood."]
    return []


def _find_particle(mentions: list[Mention], index: int) -> list[str]:
    """Says "in and out", "it is pushed around", "face it to the right"."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    ends = after is None or after.kind in (MentionKind.JOIN, MentionKind.TIME, MentionKind.REPEAT)
    ends = ends or mention.form == "around" and after is not None and after.form == "by"
    told = find_telling(mentions, index, -1)
    loose = told is not None and told.kind is not MentionKind.JOIN
    alone = mention.phrase == mention.form  # "in the air" is a phrase
    if mention.kind is MentionKind.FUNCTION and mention.form in _PARTICLES and alone and ends and loose:
        turns = any(isinstance(m.value, Verb) and m.value.effect is Effect.TURN for m in mentions[:index])
        if not (turns and mention.form in ("around", "about")):
            return [f"Which way '{mention.words}' is, is not understood."]
    if mention.kind is MentionKind.PLACE and mention.phrase in ("face", "head"):
        begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN or before in ("it", "to")
        faces = after is not None and before == "it" and after.kind in WAYS  # "make it face left"
        if after is not None and begins and (faces or after.phrase in DETERMINERS | {"it", "to", "toward"}):
            return [f"What '{mention.words} {after.words}' does is not understood."]
    return []


def _find_gerund(mentions: list[Mention], index: int) -> list[str]:
    """Says "its falling is stopped": a noun, of what happens anyway."""
    mention = mentions[index]
    noun = mention.kind is MentionKind.VERB and is_participle(mention.form)
    if noun and get_phrase(mentions, index - 1) in OWNERS:
        return [f"What 'its {mention.words}' does is not understood."]
    return []


def _find_alternation(mentions: list[Mention], index: int) -> list[str]:
    """Says "alternately squeeze and stretch it": the one and the other, again and again."""
    mention = mentions[index]
    if mention.form not in _ALTERNATING:
        return []
    verbs = [m.value for m in mentions if m.kind is MentionKind.VERB and isinstance(m.value, Verb)]
    if len({(verb.effect, verb.sign) for verb in verbs}) > 1:
        return [f"What happens '{mention.words}' is not understood."]
    return []


def _find_keeping(mentions: list[Mention], index: int) -> list[str]:
    """Says "keep the feet on the ground", "keep its width"."""
    mention, kept = mentions[index], find_telling(mentions, index, 1)
    keeps = mention.kind is MentionKind.FUNCTION and mention.form in _KEEPING
    if (
        keeps
        and kept is not None
        and kept.kind in (MentionKind.PLACE, MentionKind.AXIS, MentionKind.EXCLUDED)
    ):
        return [f"What is to be kept of '{kept.words}' is not understood."]
    return []


def _find_pair(mentions: list[Mention], index: int) -> list[str]:
    """Says "the dog and the cat"."""
    if mentions[index].form != "and" or not 0 < index < len(mentions) - 1:
        return []
    after = index + 1
    while after < len(mentions) - 1 and mentions[after].phrase in DETERMINERS:
        after += 1
    first, second = mentions[index - 1], mentions[after]
    nouns = all(_is_noun(mentions, at) for at in (index - 1, after)) and first.phrase != second.phrase
    return [f"'{first.words} and {second.words}' are more than one object."] if nouns else []


def _is_noun(mentions: list[Mention], index: int) -> bool:
    """Return whether a word that does nothing by itself stands behind an article."""
    mention = mentions[index]
    return (
        mention.kind in (MentionKind.FUNCTION, MentionKind.UNKNOWN)
        and mention.form not in FUNCTION_WORDS
        and get_phrase(mentions, index - 1) in DETERMINERS
    )


def _find_omission(mentions: list[Mention], index: int) -> list[str]:
    """Says "everything but rotate it", "anything but gently"."""
    mention, after = mentions[index], find_telling(mentions, index, 1)
    leaves_out = mention.value is Join.BUT and get_phrase(mentions, index - 1) in (*WHOLE_WORDS, "anything")
    if leaves_out and after is not None and not isinstance(after.value, Place):
        return [f"What is left when '{after.words}' is left out is not understood."]
    return []


def _find_denial(mentions: list[Mention], index: int) -> list[str]:
    """Says "not to the left" and no other way: the one that is assumed might be the same."""
    mention, denied = mentions[index], find_telling(mentions, index, 1)
    if mention.kind is not MentionKind.NOT or denied is None or denied.kind not in (*WAYS, MentionKind.PLACE):
        return []
    meant = [
        other
        for at, other in enumerate(mentions)
        if other.kind is denied.kind
        and getattr(find_telling(mentions, at, -1), "kind", None) is not MentionKind.NOT
    ]
    if meant:
        return []
    return [f"What is to be in place of what '{mention.words} {denied.words}' rules out is not understood."]


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_end_over_end,
    _find_interval,
    _find_both_ways,
    _find_figure,
    _find_nothing_that_can,
    _find_explanation,
    _find_sagging,
    _find_choice,
    _find_idle_denial,
    _find_means,
    _find_attempt,
    _find_idle_pause,
    _find_moving_holder,
    _find_counted_pause,
    _find_posture,
    _find_particle,
    _find_gerund,
    _find_alternation,
    _find_keeping,
    _find_pair,
    _find_omission,
    _find_denial,
)
