"""Sentences in which something other than the object moves: "a bird lands on the robot", "jump over it".

The verbs are the grammar's own, so that word by word the object would land or jump.
"""

from __future__ import annotations

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.tokens import is_participle
from physagent_jax.agents.rules.language.verbs import Effect, Verb

# Who does these moves by itself: nothing is "landed" or "sat".
_BY_ITSELF = (Effect.STILL, Effect.FALL, Effect.JUMP, Effect.ROLL, Effect.TURN)
_ONTO = frozenset({"from", "on", "onto", "upon", "into", "against", "off", "beside"})
_BY = frozenset({"over", "under", "past", "around", "above", "below", "beneath", "behind", "between"})
_BETWEEN = (
    MentionKind.FUNCTION,
    MentionKind.UNKNOWN,
    MentionKind.DIRECTION,
    MentionKind.INTENSITY,
    MentionKind.DEGREE,
)
_DOERS = frozenset("hand finger fist foot ball hammer stick rope person".split())
_SCENERY = frozenset("viewer background scene video hand hands light air ball rope clip screen".split())
_OTHERS = frozenset({"all", "everybody", "everyone", "both"})
_ITSELF = frozenset({"it", "him", "her", "itself"})


def find_other_movers(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Plain sentences about what moves past or onto the object, and is not the object."""
    doubts = []
    for index, mention in enumerate(mentions):
        verb = mention.value
        if mention.kind is not MentionKind.VERB or not isinstance(verb, Verb):
            continue
        place = _find_preposition(mentions, index, names)
        if place is None or any(m.kind is MentionKind.CAUSE for m in mentions[:index]):
            continue  # "the wind blows over the plant"
        alone = verb.effect in _BY_ITSELF or verb.effect is Effect.PUSH and verb.generic
        alone = (
            alone or verb.effect is Effect.PUSH and verb.direction is not None and not verb.bound
        )  # "climbs on it"
        passes = verb.effect in (Effect.PUSH, Effect.SWAY) and not verb.wind and place in _BY
        if alone or passes:
            doubts.append(f"What it is that goes '{place}' the object is not understood.")
    doubts += _find_all(mentions) + _find_wind(mentions)
    return (
        doubts + _find_doers(mentions, names) + _find_agents(mentions, names) + _find_others(mentions, names)
    )


def _find_all(mentions: list[Mention]) -> list[str]:
    """Says "all freeze", "everybody jumps": who is there besides."""
    doubts = []
    for index, mention in enumerate(mentions[:-1]):
        begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
        if begins and mention.form in _OTHERS and mentions[index + 1].kind is MentionKind.VERB:
            doubts.append(f"Who '{mention.words}' are, is not understood.")
    return doubts


def _find_wind(mentions: list[Mention]) -> list[str]:
    """Says "the wind drops", "the breeze falls": it blows no longer, and the object does not fall."""
    doubts = []
    for cause, mention in zip(mentions, mentions[1:]):
        wind = cause.kind is MentionKind.CAUSE and isinstance(cause.value, Verb) and cause.value.wind
        if wind and isinstance(mention.value, Verb) and mention.value.effect is Effect.FALL:
            doubts.append(f"What it means that '{cause.words} {mention.words}' is not understood.")
    return doubts


def _find_doers(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Says "a hand comes in from the right and takes it": the hand moves, and not the object."""
    doubts = []
    for index, mention in enumerate(mentions[:-1]):
        subject = mention.kind is MentionKind.FUNCTION and mention.form in _DOERS and index > 0
        begins = (
            subject
            and mentions[index - 1].phrase in ("a", "an")
            and (index == 1 or mentions[index - 2].kind is MentionKind.JOIN)
        )
        verb = mentions[index + 1].value
        alone = isinstance(verb, Verb) and verb.effect is Effect.PUSH and verb.generic
        if not begins or not alone:
            continue
        end = next(
            (i for i in range(index, len(mentions)) if mentions[i].kind is MentionKind.JOIN), len(mentions)
        )
        if not any(m.phrase in names | _ITSELF for m in mentions[index:end]):
            doubts.append(
                f"'{mention.words}' is another thing that moves, and there is only one object here."
            )
    return doubts


def _find_agents(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Says "it is hit by a ball rolling to the left": the ball rolls, and not the object."""
    doubts = []
    for index in range(3, len(mentions)):
        verb = mentions[index]
        noun, article, by = (mentions[index - back] for back in (1, 2, 3))
        agent = noun.kind in (MentionKind.FUNCTION, MentionKind.UNKNOWN) and noun.phrase not in names
        done = verb.kind is MentionKind.VERB and is_participle(verb.form)
        if done and agent and article.phrase in ("a", "an", "the") and by.form in ("by", "with"):
            doubts.append(f"Whether '{verb.words}' is said of the object is not understood.")
    return doubts


def _find_others(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Says "push the other one", "the viewer moves left", "move the scene": not the object."""
    doubts = []
    for index, mention in enumerate(mentions):
        before = mentions[index - 1] if index > 0 else None
        noun = mention.kind is MentionKind.FUNCTION and mention.phrase not in names
        if not noun or before is None:
            continue
        after = mentions[index + 1] if index + 1 < len(mentions) else None
        done = isinstance(before.value, Verb) and before.value.effect in (Effect.PUSH, Effect.STRIKE)
        verb = after.value if after is not None else None
        alone = isinstance(verb, Verb) and (
            verb.effect in _BY_ITSELF or verb.effect is Effect.PUSH and verb.generic
        )
        begins = index == 1 or mentions[index - 2].kind is MentionKind.JOIN
        acted = (
            index > 1
            and isinstance(mentions[index - 2].value, Verb)
            and mentions[index - 2].kind is MentionKind.VERB
        )
        thing = mention.form in _SCENERY and before.phrase in DETERMINERS and (begins and alone or acted)
        another = mention.form == "other" and after is not None and after.phrase in names | {"one", "ones"}
        some = (
            done
            and mention.form in ("something", "me", "us")
            or mention.form == "them"
            and before.form == "of"
        )
        if thing or another or some:
            doubts.append(f"'{mention.words}' is not the object, and nothing else can move here.")
    return doubts


def _find_preposition(mentions: list[Mention], index: int, names: frozenset[str]) -> str | None:
    """The preposition that sets the object, named or "it", beside what the verb at ``index`` moves."""
    for at in range(index + 1, len(mentions)):
        mention = mentions[at]
        if mention.kind not in _BETWEEN or mention.phrase in names | _ITSELF:
            return None
        if mention.phrase in _ONTO | _BY:
            behind = at + 1
            while behind < len(mentions) and mentions[behind].phrase in DETERMINERS:
                behind += 1
            if behind == len(mentions) or mentions[behind].phrase not in names | _ITSELF:
                return None
            owns = behind + 1 < len(mentions) and mentions[behind + 1].kind is MentionKind.PLACE
            return None if owns else mention.phrase
    return None
