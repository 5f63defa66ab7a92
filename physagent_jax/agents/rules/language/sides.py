"""Words for ways and sides that tell no way where they stand: "the left", "it left the ground"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, find_telling, get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_PRONOUNS = frozenset({"it", "he", "she", "they"})
_LATERAL = frozenset({"left", "right"})
_LINKS = frozenset(
    "to toward towards from on at of by in into for with onto off against and or than is near s".split()
)
_AIMS = frozenset({"against", "at", "into", "onto"})
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


def _find_tool(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "push it with the right hand": whose hand?"""
    mention = mentions[index]
    limb = mention.kind is MentionKind.PLACE and bool(_LIMBS & set(mention.words.lower().split()))
    owner = get_phrase(mentions, index - 1)
    behind_with = any(m.form == "with" for m in mentions[max(index - 2, 0) : index])
    if limb and behind_with and owner not in ("its", "his", "her") and has_motion(mentions[:index]):
        return [f"Whose '{mention.words}' it is, is not understood."]
    return []


def _find_turns(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "from both sides in turn": one after the other, and no rotation."""
    mention = mentions[index]
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    bare = mention.form in ("turn", "turns") and isinstance(mention.value, Verb) and ends
    if bare and get_phrase(mentions, index - 1) in ("in", "by", "take", "takes"):
        return [f"What goes 'in {mention.words}' is not understood."]
    return []


def _find_facing(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it turns to the camera": so that it faces there, and not that its top goes there."""
    mention, verb = mentions[index], find_telling(mentions, index, -1)
    turns = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is Effect.TURN
    spins = turns and mention.value in (("up",), ("down",)) and mentions[index - 1] is verb
    if spins and verb is not None and verb.phrase == "spin":
        return [f"What '{verb.words} {mention.words}' means is not understood."]  # faster, or slower
    if not turns or verb is None or verb.form not in ("turn", "turns", "turning", "turned"):
        return []
    if mention.kind is MentionKind.DIRECTION and mention.value in (("toward",), ("up",)):
        return [f"What it is to turn '{mention.words}' is not understood."]
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


def _find_pivot(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "it swings from its top": what holds it, and no way."""
    mention, owner = mentions[index], get_phrase(mentions, index - 1)
    verb = next((m for m in reversed(mentions[:index]) if m.kind is MentionKind.VERB), None)
    upright = mention.kind is MentionKind.FROM and mention.value in (("up",), ("down",))
    swings = verb is not None and isinstance(verb.value, Verb) and verb.value.effect is not Effect.HOLD
    if upright and owner in ("its", "his", "her") and swings:
        return [f"What 'from {owner} {mention.words}' means is not understood."]
    return []


def _find_shown(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "so that its back faces us": all of it turns, and no part is moved."""
    mention, after = mentions[index], [m.form for m in mentions[index + 1 : index + 3]]
    if mention.kind is MentionKind.PLACE and {"faces", "facing", "points", "pointing"} & set(after):
        return [f"How '{mention.words}' comes to be there is not understood."]
    return []


def _is_shove(verb: Verb) -> bool:
    """Whether somebody pushes: "push", and not "move"."""
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


def _find_over(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "over it goes": it falls, and does not go."""
    begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
    subject = get_phrase(mentions, index + 1) in names | _PRONOUNS
    goes = index + 2 < len(mentions) and mentions[index + 2].form in ("goes", "went", "go")
    if mentions[index].form == "over" and begins and subject and goes:
        return [f"Where '{mentions[index].words}' leads is not understood."]
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
    other = any(m.kind is MentionKind.PLACE for m in mentions)
    moves = after is not None and (
        after.kind is MentionKind.DIRECTION
        or isinstance(after.value, Verb)
        and after.value.effect not in (Effect.STILL, Effect.HOLD)
    )
    if mention.kind is MentionKind.FUNCTION and rest and other and moves:
        return [f"Which part '{mention.words}' is, is not understood."]
    return []


def _find_near(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "bring the object more near": nearer to what?"""
    verb = find_telling(mentions, index, -1)
    brings = verb is not None and verb.kind in (MentionKind.VERB, MentionKind.COMPARATIVE)
    if mentions[index].form == "near" and brings:
        return [f"Where '{mentions[index].words}' is, is not understood."]
    return []


def _find_turned(mentions: list[Mention], index: int, names: frozenset[str]) -> list[str]:
    """Says "the breeze turns it": the object, and not the wind."""
    mention, after = mentions[index], get_phrase(mentions, index + 1)
    wind = any(isinstance(m.value, Verb) and m.value.wind for m in mentions[:index])
    turns = mention.kind is MentionKind.VERB and mention.form in ("turns", "turned", "turning")
    if wind and turns and after in DETERMINERS | names | {"it", "him", "her"}:
        return [f"What the wind '{mention.words}' is not understood."]
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


def _find_seen(mentions: list[Mention], index: int, _names: frozenset[str]) -> list[str]:
    """Says "turn it so that we see the back": what is seen then, and no part that is moved."""
    mention, before = mentions[index], [m.form for m in mentions[max(index - 2, 0) : index]]
    if mention.kind is MentionKind.PLACE and {"see", "sees", "seen"} & set(before):
        return [f"How it is turned to show '{mention.words}' is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int, frozenset[str]], list[str]], ...] = (
    _find_noun,
    _find_just,
    _find_aim,
    _find_tool,
    _find_turns,
    _find_facing,
    _find_return,
    _find_own,
    _find_standpoint,
    _find_there,
    _find_pivot,
    _find_shown,
    _find_blown,
    _find_height,
    _find_over,
    _find_measure,
    _find_part_besides,
    _find_other,
    _find_body,
    _find_near,
    _find_turned,
    _find_off,
    _find_out,
    _find_striker,
    _find_seen,
)
