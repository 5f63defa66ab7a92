"""Frames of a sentence that move nothing: labels, requests, remarks, "right?".

"Run 3: push it", "I was wondering whether it could bow", "shake it, she is fragile": such parts hold no motion,
whatever words are in them.
"""

from __future__ import annotations

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.modifiers import MOODS
from physagent_jax.agents.rules.language.reader import OWNING

_HEADS = (MentionKind.VERB, MentionKind.CAUSE)
_SPEAKERS = frozenset({"i", "we", "my", "our", "me", "us", "you"})
_PRONOUNS = frozenset({"it", "he", "she", "they"})
_THINGS = frozenset({"it", "him", "her", "them"})
_COPULAS = frozenset({"is", "are", "was", "were", "looks", "seems"})
_CONTRACTED = frozenset({"it's", "he's", "she's", "it\u2019s", "he\u2019s", "she\u2019s"})
_SAYING = frozenset(
    "said cried shouted asked laughed whispered yelled called exclaimed thought says shouts cries".split()
)
_SHOWING = frozenset("show showing reveal revealing display displaying expose exposing".split())
_LINKING = frozenset("to into onto from of in on at like as than until toward towards around only".split())
# What goes on with what was said before: no noun.
_AGAIN = frozenset("repeat undo redo reverse opposite likewise ditto that this them".split())
_TURNED = ("ing", "ed", "wise", "ways", "wards", "zag")
_EMPTY = (MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.DEGREE, MentionKind.JOIN)
_LONGEST_LABEL = 6


def drop_frames(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """The mentions with those of frames emptied; ``names`` are words for the object."""
    result = _drop_exclamation(_drop_label(mentions, names))
    result = _drop_asking(result, names)
    result = _drop_remarks(result, names)
    return _drop_fragments(_drop_purposes(_drop_tag(_drop_reporting(result))), names)


def _drop_label(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties "Run 3:", "Lights up.": a beginning without verb or object in which something is not understood."""
    if len(mentions) > 1 and mentions[0].kind is MentionKind.UNKNOWN and mentions[0].words[0].isdigit():
        return [empty(mentions[0]), *mentions[1:]]  # "3.2 Push it"
    end = next((i for i, m in enumerate(mentions) if m.words in (":", ".", "!")), len(mentions))
    head = mentions[:end]
    told = any(m.kind in _HEADS or m.phrase in names | _PRONOUNS for m in head)
    labels = any(m.kind is MentionKind.UNKNOWN for m in head) and not any(m.form == "only" for m in head)
    if end == len(mentions) or end > _LONGEST_LABEL or told or not labels:
        return mentions
    if not any(m.kind in _HEADS for m in mentions[end:]):
        return mentions
    return [empty(m) for m in head] + mentions[end:]


def _drop_exclamation(mentions: list[Mention]) -> list[Mention]:
    """Empties "what a kick," before what is told of it."""
    end = next((i for i, m in enumerate(mentions) if m.kind is MentionKind.JOIN), len(mentions))
    exclaims = [m.form for m in mentions[:2]] in (["what", "a"], ["what", "an"])
    if not exclaims or not any(m.kind in _HEADS for m in mentions[end:]):
        return mentions
    return [empty(m) for m in mentions[:end]] + mentions[end:]


def _drop_asking(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties what stands before the object and any verb where somebody speaks: "my friend insists that ..."."""
    end = next((i for i, m in enumerate(mentions) if m.kind in _HEADS or m.phrase in names), len(mentions))
    behind = end
    while end > 0 and mentions[end - 1].phrase in OWNING:
        end -= 1
    if behind == len(mentions) or not any(m.form in _SPEAKERS for m in mentions[:end]):
        return mentions
    if mentions[end - 1].kind is MentionKind.UNKNOWN and mentions[behind].phrase in names:
        return mentions  # "we melt the vase"
    acts = any(
        m.kind is MentionKind.UNKNOWN and after.phrase in _THINGS
        for m, after in zip(mentions, mentions[1:end])
    )
    if acts or not any(m.kind in _HEADS for m in mentions[behind:]):
        return mentions  # "can you paint it and then push it", "can you melt down the vase"
    kept = [empty(m) if m.kind is MentionKind.UNKNOWN else m for m in mentions[:end]]
    return kept + mentions[end:]


def _drop_remarks(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties "she is fragile", "until he was dizzy": how it is, in a segment of its own beside a motion."""
    if not any(m.kind in _HEADS for m in mentions):
        return mentions
    result = list(mentions)
    begin = 0
    for end in [i for i, m in enumerate(mentions) if m.kind is MentionKind.JOIN] + [len(mentions)]:
        segment = mentions[begin:end]
        unknown = [m for m in segment if m.kind is MentionKind.UNKNOWN]
        copula = next((i for i, m in enumerate(segment) if m.form in _COPULAS), None)
        subject = segment[copula - 1].phrase if copula else ""
        if segment and segment[0].words.lower() in _CONTRACTED:  # "it's a spooky place"
            subject = segment[0].phrase
        remarks = (
            len(unknown) == 1
            and not unknown[0].form.endswith(("ing", "ed"))
            and all(m.kind in _EMPTY for m in segment)
            and (subject in names or subject in _PRONOUNS)
        )
        if remarks:
            result[begin:end] = [empty(m) for m in segment]
        begin = end + 1
    return result


def _drop_reporting(mentions: list[Mention]) -> list[Mention]:
    """Empties "cried the witch": who says it."""
    result = list(mentions)
    for at, mention in enumerate(mentions):
        if mention.form not in _SAYING or mention.kind is not MentionKind.UNKNOWN:
            continue
        end = at + 1
        while end < len(mentions) and mentions[end].kind in (MentionKind.FUNCTION, MentionKind.UNKNOWN):
            end += 1
        told = any(m.kind in _HEADS for m in mentions[end:])
        speaker = mentions[at + 1].phrase if at + 1 < len(mentions) else ""
        first = 0 if told and speaker in OWNING and _is_speech(mentions[:at]) else at
        result[first:end] = [empty(m) for m in mentions[first:end]]
    return result


def _is_speech(mentions: list[Mention]) -> bool:
    """Return whether one thing alone stands before its speaker: "move over," said the king, and it rolled."""
    ends = [m.words in (",", "!", ".", "?") for m in mentions if m.kind is MentionKind.JOIN]
    return len(ends) == 1 and ends[0] and mentions[-1].kind is MentionKind.JOIN


def _drop_tag(mentions: list[Mention]) -> list[Mention]:
    """Empties the "right" of "I have it here, right, and ...": no way stands beside it, and another one follows."""
    result = list(mentions)
    for at in range(len(mentions) - 1):
        tag = mentions[at]
        begins = at == 0 and any(m.kind in _HEADS for m in mentions[:5])  # "right, now push it left"
        alone = (begins or at > 0 and mentions[at - 1].words == ",") and mentions[at + 1].words in (",", "?")
        if tag.kind is not MentionKind.DIRECTION or tag.words.lower() != "right" or not alone:
            continue
        ways = [i for i, m in enumerate(mentions) if m.kind is MentionKind.DIRECTION and i != at]
        moved = any(m.kind in _HEADS for m in mentions[:at])
        if not moved and ways and all(i > at + (1 if begins else 2) for i in ways):
            result[at] = empty(tag)
    return result


def _drop_purposes(mentions: list[Mention]) -> list[Mention]:
    """Empties "to show its back": what somebody sees then, and no part that is moved."""
    result = list(mentions)
    for at in range(1, len(mentions)):
        if mentions[at].form not in _SHOWING or mentions[at - 1].form not in ("to", ","):
            continue
        if not any(m.kind in (*_HEADS, MentionKind.QUANTITY) for m in mentions[:at]):
            continue
        end = at + 1
        while (
            end < len(mentions)
            and mentions[end].kind is not MentionKind.JOIN
            and mentions[end].kind not in _HEADS
        ):
            end += 1
        result[at:end] = [empty(m) for m in mentions[at:end]]
    return result


def _drop_fragments(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties ", soft lighting, close-up": a segment of nouns beside a motion."""
    result = list(mentions)
    begin = 0
    for end in [i for i, m in enumerate(mentions) if m.kind is MentionKind.JOIN] + [len(mentions)]:
        segment = mentions[begin:end]
        around = [m.words for m in (*mentions[begin - 1 : begin], *mentions[end : end + 1])]
        apart = all(words in (",", ".", "!", ";", ":") for words in around)
        unknown = [m for m in segment if m.kind is MentionKind.UNKNOWN]
        how = any(
            m.form.endswith("ly") and not is_mood(m.form) for m in unknown
        )  # "push it left, lethargically"
        content = {m.kind for m in segment} <= {*_EMPTY, MentionKind.INTENSITY}
        tells = any(
            m.form in names | _PRONOUNS | _LINKING | _AGAIN or m.form.endswith(_TURNED) for m in segment
        )
        moved = any(m.kind in _HEADS for m in (*mentions[:begin], *mentions[end:]))
        lens = [m.kind for m in segment] == [MentionKind.QUANTITY] and segment[0].words.endswith("mm")
        if lens and apart and moved:
            result[begin:end] = [empty(m) for m in segment]  # ", 85mm,"
        if (
            unknown
            and not how
            and apart
            and content
            and moved
            and not tells
            and len(segment) <= _LONGEST_LABEL
        ):
            result[begin:end] = [empty(m) for m in segment]
        begin = end + 1
    return result


def is_mood(word: str) -> bool:
    """Return whether a word tells a mood or a style, which no motion shows: "merrily", "naughty", "cinematic"."""
    if word in MOODS:
        return True
    stem = word.removesuffix("ly")
    return stem != word and (stem in MOODS or stem.removesuffix("i") + "y" in MOODS or stem + "le" in MOODS)
