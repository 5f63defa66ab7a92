"""Words for ways and sides that tell no way where they stand: "the left", "it left the ground"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import WAYS, find_telling, get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_PRONOUNS = frozenset({"it", "he", "she", "they"})
_LATERAL = frozenset({"left", "right"})
_STRIKING = frozenset("kicks punches hits strikes slaps pokes".split())
_LIMBS = frozenset({"hand", "arm", "foot", "fist", "hands", "feet", "leg", "shoulder"})


def find_sides(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Plain sentences about ways that are none; ``names`` are words for the object."""
    return [
        doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index, names)
    ]


def _find_noun(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "shake the left", "it left the ground", "what is left of it", "the left robot"."""
    mention, before, after = mentions[index], get_phrase(mentions, index - 1), get_phrase(mentions, index + 1)
    if mention.kind is not MentionKind.DIRECTION or mention.phrase not in _LATERAL:
        return []
    verb = find_telling(mentions, index, -1)
    done = verb is not None and verb.kind is MentionKind.VERB and before == "the" and index > 1
    noun = done and mentions[index - 2] is verb
    leaves = mention.phrase == "left" and before in names | _PRONOUNS and after in DETERMINERS | {"behind"}
    leaves = leaves and not has_motion(mentions[:index])
    owners = [m.phrase for m in mentions[max(index - 2, 0) : index]]
    remains = (
        mention.phrase == "left" and before in ("is", "was", "are", "were", "what", "s") and after == "of"
    )
    remains = remains or mention.phrase == "left" and before in ("nothing", "something", "anything", "all")
    remains = remains or owners in (["has", "the"], ["have", "the"], ["had", "the"]) and after == "to"
    one = before in DETERMINERS and after in names
    if noun or leaves or remains or one:
        return [f"What '{mention.words}' means here is not understood."]
    return []


def _find_just(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "push it right before it lands": to the right, or just then?"""
    mention = mentions[index]
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    told = mention.kind is MentionKind.DIRECTION and mention.words.lower() == "right"
    if told and after is not None and after.value in (Join.BEFORE, Join.AFTER, Join.WHILE):
        if not any(m.phrase in ("to", "the") for m in mentions[max(index - 2, 0) : index]):
            return [f"Whether '{mention.words} {after.words}' tells a way or a time is not understood."]
    return []


def _find_tool(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "push it with the right hand": whose hand?"""
    mention = mentions[index]
    limb = mention.kind is MentionKind.PLACE and bool(_LIMBS & set(mention.words.lower().split()))
    owner = get_phrase(mentions, index - 1)
    behind_with = any(m.form == "with" for m in mentions[max(index - 2, 0) : index])
    if limb and behind_with and owner not in ("its", "his", "her") and has_motion(mentions[:index]):
        return [f"Whose '{mention.words}' it is, is not understood."]
    return []


def _find_standpoint(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "blow on it from where you are": whoever looks, and no verb of the object."""
    begins = index == 0 or mentions[index - 1].form != "from" or not has_motion(mentions[:index])
    if (
        mentions[index].form == "where"
        and not begins
        and get_phrase(mentions, index + 1) in ("you", "i", "we")
    ):
        return ["Where 'from where' is, is not understood."]
    return []


def _find_own(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "to its own left": the object's left may be the viewer's right."""
    mention, before = mentions[index], mentions[index - 1] if index > 0 else None
    sided = mention.kind is MentionKind.DIRECTION and mention.phrase in _LATERAL and before is not None
    if (
        sided
        and before is not None
        and (before.form == "own" or before.phrase in names and "'s" in before.words)
    ):
        return [f"Whose {mention.words} it is, is not understood."]
    return []


def _is_shove(verb: Verb) -> bool:
    """Return whether somebody pushes: "push", and not "move"."""
    return verb.effect is Effect.PUSH and not verb.generic and verb.direction is None and not verb.wind


def _find_height(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "hit it low", "push it high up": where, and neither how strongly nor where to."""
    mention = mentions[index]
    verb = find_telling(mentions, index, -1)
    does = verb.value if verb is not None and verb.kind is MentionKind.VERB else None
    strikes = isinstance(does, Verb) and (
        does.effect is Effect.STRIKE and not does.gravity or _is_shove(does)
    )
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    rises = (
        after is not None and after.value == ("up",) and after.phrase != "up"
    )  # "kick it high into the air"
    if (
        mention.kind is MentionKind.INTENSITY
        and mention.words.lower() in ("low", "high")
        and strikes
        and not rises
    ):
        return [f"Whether '{mention.words}' is where it is hit is not understood."]
    return []


def _find_measure(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "lift it halfway": how far, and not when."""
    mention = mentions[index]
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    verb = find_telling(mentions, index, -1)
    moves = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is not Effect.STILL
    if mention.form in ("halfway", "midway") and ends and (moves or verb is not None and verb.kind in WAYS):
        return [f"How far '{mention.words}' is, is not understood."]
    return []


def _find_part_besides(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "push it left and its head right": all of it one way, and a part another."""
    if mentions[index].value is not Join.AND:
        return []
    at = index + 1
    while at < len(mentions) and mentions[at].phrase in DETERMINERS:
        at += 1
    if at + 1 >= len(mentions) or mentions[at].kind is not MentionKind.PLACE:
        return []
    way = find_telling(mentions, at, 1)
    begin = max((i for i in range(index) if mentions[i].kind is MentionKind.JOIN), default=-1) + 1
    first = mentions[begin:index]
    whole = any(m.kind is MentionKind.DIRECTION for m in first) and not any(
        m.kind in (MentionKind.PLACE, MentionKind.EXCLUDED) for m in first
    )
    if whole and has_motion(first) and way is not None and way.kind is MentionKind.DIRECTION:
        return [f"How '{mentions[at].words}' goes another way than the whole is not understood."]
    return []


def _find_other(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "to one side and then the other": what stands behind "the other" is left out."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    if mentions[index].form == "other" and ends and get_phrase(mentions, index - 1) == "the":
        return ["What 'the other' is, is not understood."]
    return []


def _find_body(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "the head goes left, the body right": the whole, or what is left of it?"""
    mention, after = mentions[index], find_telling(mentions, index, 1)
    rest = mention.form == "body" or mention.form == "rest" and get_phrase(mentions, index + 1) == "of"
    if not rest:
        return []
    other = any(m.kind is MentionKind.PLACE for m in mentions)
    moves = after is not None and (
        after.kind is MentionKind.DIRECTION
        or isinstance(after.value, Verb)
        and after.value.effect not in (Effect.STILL, Effect.HOLD)
    )
    if mention.kind is MentionKind.FUNCTION and other and moves:
        return [f"Which part '{mention.words}' is, is not understood."]
    return []


def _find_striker(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "the horse kicks back": it strikes, and is not struck."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    strikes = isinstance(mention.value, Verb) and mention.value.effect is Effect.STRIKE
    strikes = strikes and mention.kind is MentionKind.VERB and mention.form in _STRIKING
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    free = after is None or after.kind in (MentionKind.DIRECTION, MentionKind.JOIN, MentionKind.REPEAT)
    if (
        strikes
        and before in names
        and free
        and not any(m.kind is MentionKind.CAUSE for m in mentions[:index])
    ):
        return [f"What '{mention.words}' strikes is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], list[str]], ...] = (
    _find_noun,
    _find_just,
    _find_tool,
    _find_own,
    _find_standpoint,
    _find_height,
    _find_measure,
    _find_part_besides,
    _find_other,
    _find_body,
    _find_striker,
)
