"""Little words behind a verb that lead elsewhere than they say: "put it back", "pull it out", "over it goes"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, find_telling, get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_LINKS = frozenset(
    "to toward towards from on at of by in into for with onto off against and or than is near s".split()
)
_AIMS = frozenset({"against", "at", "into", "onto"})
_PRONOUNS = frozenset({"it", "he", "she", "they"})


def find_particles(mentions: list[Mention], names: frozenset[str]) -> list[str]:
    """Plain sentences about where such a word leads; ``names`` are words for the object."""
    return [
        doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index, names)
    ]


def _find_aim(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "throw the ball against it", "it leans into the wind": a thing to meet, wherever it is."""
    mention = mentions[index]
    behind = index + 1
    while get_phrase(mentions, behind) in DETERMINERS:
        behind += 1
    if mention.form not in _AIMS or mention.kind is not MentionKind.FUNCTION or behind >= len(mentions):
        return []
    wind = mentions[behind].value
    facing = mention.form in ("against", "into") and isinstance(wind, Verb) and wind.wind
    last = max((i for i in range(index) if mentions[i].kind in MOTIONS), default=index)
    moved = any(m.phrase in names for m in mentions[last:index])
    thing = mentions[behind].form in ("it", "them", "that") and behind == index + 1
    if facing and has_motion(mentions[:index]) or moved and thing:
        return [f"Where '{mention.words} {mentions[behind].words}' leads is not understood."]
    return []


def _find_return(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "lift it and put it back": where it was, and not away from the viewer."""
    mention = mentions[index]
    puts = any(m.form in ("put", "puts", "set", "sets", "place") for m in mentions[max(index - 3, 0) : index])
    verb = find_telling(mentions, index, -1)
    if mention.words.lower() == "back" and get_phrase(mentions, index + 1) == "where":
        return [f"Where '{mention.words} where' it was is, is not understood."]
    down = get_phrase(mentions, index + 1) in ("down", "up") or verb is not None and "down" in verb.phrase
    told = has_motion(mentions[:index]) or get_phrase(mentions, index + 1) == "on"
    if mention.words.lower() == "back" and puts and not down and told:
        return [f"Where '{mention.words}' is, is not understood."]
    return []


def _find_there(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "push it there": which way is that?"""
    told = any(m.kind in WAYS for m in mentions[max(index - 3, 0) : index + 3])
    verb = find_telling(mentions, index, -1)
    does = verb.value if verb is not None else None
    moves = isinstance(does, Verb) and does.effect in (Effect.PUSH, Effect.STRIKE)
    thing = get_phrase(mentions, index - 1) in names | {"it", "him", "her"}
    if mentions[index].form == "there" and moves and thing and not told:
        return ["Where 'there' is, is not understood."]
    return []


def _find_hung(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it hangs its head": the head sinks, and nothing holds it."""
    mention, after = mentions[index], mentions[index + 1 : index + 3]
    hangs = mention.kind is MentionKind.VERB and mention.phrase == "hang" and len(after) == 2
    if hangs and after[0].phrase in ("its", "his", "her") and after[1].kind is MentionKind.PLACE:
        return [f"What '{mention.words} {after[0].words} {after[1].words}' means is not understood."]
    return []


def _find_pivot(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it swings from its top": what holds it, and no way."""
    mention, owner = mentions[index], get_phrase(mentions, index - 1)
    verb = next((m for m in reversed(mentions[:index]) if m.kind is MentionKind.VERB), None)
    upright = mention.kind is MentionKind.FROM and mention.value in (("up",), ("down",))
    swings = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is not Effect.HOLD
    if upright and owner in ("its", "his", "her") and swings:
        return [f"What 'from {owner} {mention.words}' means is not understood."]
    return []


def _find_blown(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "blow the balloon up": it is inflated, or lifted."""
    mention, after = mentions[index], get_phrase(mentions, index + 1)
    blows = mention.kind is MentionKind.VERB and mention.form in ("blow", "blew", "blown")
    at = index + 1
    while at < len(mentions) and (mentions[at].phrase in DETERMINERS | names | {"it"}):
        at += 1
    up = at > index + 1 and get_phrase(mentions, at) == "up" and get_phrase(mentions, at + 1) not in _LINKS
    if blows and up and after in DETERMINERS | names | {"it"}:
        return [f"Whether '{mention.words} up' inflates or lifts is not understood."]
    return []


def _find_over(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "over it goes": it falls, and does not go."""
    begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
    subject = get_phrase(mentions, index + 1) in names | _PRONOUNS
    goes = index + 2 < len(mentions) and mentions[index + 2].form in ("goes", "went", "go")
    if mentions[index].form == "over" and begins and subject and goes:
        return [f"Where '{mentions[index].words}' leads is not understood."]
    return []


def _find_off(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "push it away from it", "let it go left": word by word another way, or a fall."""
    mention, after = mentions[index], find_telling(mentions, index, 1)
    thing = get_phrase(mentions, index + 2) in ("it", "that", "there")
    from_it = mention.phrase == "away" and get_phrase(mentions, index + 1) == "from" and thing
    goes = isinstance(mention.value, Verb) and mention.value.effect is Effect.RELEASE
    goes = goes and mention.words.lower().endswith(" go")
    if from_it or goes and after is not None and after.kind is MentionKind.DIRECTION:
        return [f"Where '{mention.words}' leads is not understood."]
    return []


def _find_out(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "pull it out by the roots", "push in the chair": out of what, into what?"""
    mention, before = mentions[index], mentions[index - 1] if index > 0 else None
    after = get_phrase(mentions, index + 1)
    if mention.kind is not MentionKind.FUNCTION or mention.form not in ("out", "in") or before is None:
        return []
    verb = find_telling(mentions, index, -1)
    pushes = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is Effect.PUSH
    loose = (
        before.form == "it"
        and after == "by"
        or before is verb
        and mention.form == "out"
        and after in DETERMINERS
    )
    inward = (
        before is verb
        and mention.form == "in"
        and verb is not None
        and verb.form in ("push", "pushes", "pushed")
    )
    if pushes and (loose or inward and after in DETERMINERS):
        return [f"Where '{mention.words}' leads is not understood."]
    return []


def _find_near(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "bring the object more near": nearer to what?"""
    verb = find_telling(mentions, index, -1)
    brings = verb is not None and verb.kind in (MentionKind.VERB, MentionKind.COMPARATIVE)
    if mentions[index].form == "near" and brings:
        return [f"Where '{mentions[index].words}' is, is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], list[str]], ...] = (
    _find_aim,
    _find_return,
    _find_there,
    _find_hung,
    _find_pivot,
    _find_blown,
    _find_over,
    _find_off,
    _find_out,
    _find_near,
)
