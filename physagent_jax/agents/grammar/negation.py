"""Negation: the effect of "not" on the mention behind it."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.clauses import WHERE
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import OPPOSITE_GRAVITY, SCENE_NOUNS

_NEGATABLE = (
    *WHERE,
    MentionKind.VERB,
    MentionKind.CAUSE,
    MentionKind.INTENSITY,
    MentionKind.DEGREE,
    MentionKind.COMPARATIVE,
    MentionKind.GRAVITY,
    MentionKind.ANCHOR,
)


def apply_negations(mentions: list[Mention]) -> list[Mention]:
    """Resolves NOT on everything but verbs: what is negated vanishes or turns into its opposite."""
    result: list[Mention] = []
    pending: Mention | None = None
    manner = False
    for mention in mentions:
        denies_manner = pending is not None and mention.kind is MentionKind.VERB
        manner = pending is not None and (
            manner or denies_manner and _is_manner_denied(mentions, mention)
        )  # "do not push it too hard" pushes it
        if mention.kind is MentionKind.NOT:
            pending = mention
        elif pending is not None and mention.kind is MentionKind.SOLID:
            pending = None  # "no wall, just push it"
        elif pending is not None and pending.phrase in ("no", "without") and mention.form in SCENE_NOUNS:
            pending = None  # "without a floor it falls"
            result.append(mention)
        elif pending is None or mention.kind not in _NEGATABLE:
            result.append(mention)
        elif mention.kind is MentionKind.INTENSITY and _is_noun_denied(mentions, pending, mention):
            continue  # "not a strong push, just a soft one"
        elif mention.kind is MentionKind.DEGREE:  # "not too hard": the intensity that follows is negated
            continue
        elif manner and mention.kind is not MentionKind.INTENSITY:
            result.append(mention)
        else:
            result += _negate(pending, mention)
            pending = None
    return result


def _is_noun_denied(mentions: list[Mention], negation: Mention, adjective: Mention) -> bool:
    """Return whether an article stands between "not" and an adjective, so that the noun is denied."""
    between = [m.form for m in mentions if negation.first < m.first < adjective.first]
    behind = next(
        (m for m in mentions if m.first > adjective.first and m.kind is not MentionKind.DEGREE), None
    )
    acts = behind is not None and behind.kind in (MentionKind.VERB, MentionKind.CAUSE)
    return acts and any(form in ("a", "an") for form in between)


def _is_manner_denied(mentions: list[Mention], verb: Mention) -> bool:
    """Return whether only how strongly it is done is denied: "do not push it too hard"."""
    behind = [m.kind for m in mentions if m.first > verb.first and m.kind is not MentionKind.FUNCTION]
    hard = [m for m in mentions if m.first > verb.first and m.kind is MentionKind.INTENSITY]
    hard = [
        m for m in hard if isinstance(m.value, float) and m.value > 1
    ]  # "don't move it a bit" is another thing
    degrees = any(pair == (MentionKind.DEGREE, MentionKind.INTENSITY) for pair in zip(behind, behind[1:]))
    return (degrees or bool(hard)) and MentionKind.VERB not in behind


def _negate(negation: Mention, mention: Mention) -> list[Mention]:
    """The meaning of "not X"."""
    if mention.kind in (MentionKind.VERB, MentionKind.CAUSE):
        return [negation, mention]
    if mention.kind in (MentionKind.INTENSITY, MentionKind.COMPARATIVE):
        assert isinstance(mention.value, float)
        value = 0.8 if mention.value > 1 else 1.2
        return [
            replace(
                mention, kind=MentionKind.INTENSITY, value=value, words=f"{negation.words} {mention.words}"
            )
        ]
    if mention.kind is MentionKind.GRAVITY:
        value = OPPOSITE_GRAVITY[str(mention.value)]
        return [replace(mention, value=value, words=f"{negation.words} {mention.words}")]
    if mention.kind is MentionKind.ANCHOR:
        return [
            replace(
                mention,
                value="none" if mention.value != "none" else "base",
                words=f"{negation.words} {mention.words}",
            )
        ]
    return []
