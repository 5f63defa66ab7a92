"""Parts that only tell where or which way something happens: nothing is done to them.

"Its arm comes off at the shoulder", "it leans toward its tail", "it melts from the ears down", "its knees give way".
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import LOOSE, Mention, MentionKind, empty, get_last_motion
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import Effect

_NOUNS = (MentionKind.PLACE, MentionKind.UNKNOWN)
_YIELDING = ("buckle", "give")  # begins of phrases for what does not bear any more
_BESIDE = ("between", "above", "below", "beneath", "under", "underneath", "inside")
_ADJECTIVES = 4  # before a noun, at most


def read_landmarks(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Makes a way of the part that something goes towards, and empties those that tell a joint or a beginning."""
    result = list(mentions)
    for at, mention in enumerate(mentions):
        if mention.kind is MentionKind.VERB and mention.phrase.startswith(_YIELDING):
            result[at] = _let_fall(mentions, at, names)
        if mention.kind not in _NOUNS:
            continue
        before = _find_preposition(mentions, at)
        words = [each.form for each in mentions[max(before - 1, 0) : before + 1]]
        goal = words[-1:] in (["toward"], ["towards"]) or words == ["direction", "of"]
        if mention.kind is MentionKind.PLACE and goal and not _is_of_another(mentions, at, names):
            result[at] = replace(mention, kind=MentionKind.DIRECTION, value=(mention.phrase,))
        elif any(
            tells(mentions, at, before) for tells in (_is_joint, _is_beginning, _is_giving_way, _is_beside)
        ):
            result[at] = empty(mention)
    return result


def _find_preposition(mentions: list[Mention], at: int) -> int:
    """Index of what stands before a noun's phrase."""
    before = at - 1
    while before >= max(at - _ADJECTIVES, 0) and mentions[before].kind in LOOSE:
        before -= 1
    return before - (before >= 0 and mentions[before].form in get_set("determiners"))


def _is_of_another(mentions: list[Mention], at: int, names: frozenset[str]) -> bool:
    """Return whether a part is one of another thing: "toward the base of the wall"."""
    behind = [each.form for each in mentions[at + 1 : at + 4]]
    return behind[:1] == ["of"] and names.isdisjoint(behind) and get_set("objects").isdisjoint(behind)


def _is_joint(mentions: list[Mention], at: int, before: int) -> bool:
    """Return whether a noun tells where a part bends or comes off: "its arm bends at the elbow"."""
    placed = mentions[at].kind is MentionKind.PLACE
    motion = get_last_motion(mentions[:at]) if placed or mentions[at].phrase in get_set("joints") else None
    if motion is None or before < 0:
        return False
    preposition, severed = mentions[before], motion.manner == "detach"
    begin = max((k for k in range(before) if mentions[k].kind is MentionKind.JOIN), default=0)
    parts = [k for k in range(at) if mentions[k].kind is MentionKind.PLACE]
    if severed and placed and parts[-1:] > [begin]:
        return parts[-1] < at - 1 and preposition.form not in ("of", "and", "with")  # "slips off the rim"
    whole = mentions[at].phrase in ("base", "root", "roots", "stem")  # "saw the tree off at its base"
    if mentions[at].phrase not in get_set("joints") or not (parts or whole and severed):
        return False
    struck = motion.effect is Effect.STRIKE
    placed = preposition.form == "from" or preposition.form in ("at", "in") and not struck
    return placed or preposition.motion is motion and severed  # "breaks off its base"


def _is_beside(mentions: list[Mention], at: int, before: int) -> bool:
    """Return whether a noun tells the place where something moves about: "the wheel turns between its legs"."""
    placed = mentions[at].kind is MentionKind.PLACE and before >= 0 and mentions[before].form in _BESIDE
    motion = get_last_motion(mentions[:at]) if placed and before < at - 1 else None
    return motion is not None and motion.effect in (Effect.TURN, Effect.SWAY)


def _is_beginning(mentions: list[Mention], at: int, before: int) -> bool:
    """Return whether a noun tells where what gives way begins to: "it melts from the ears down"."""
    starts = before > 0 and mentions[before - 1].form in ("starting", "beginning")
    placed = before >= 0 and mentions[before].form in (("from", "with", "at") if starts else ("from",))
    motion = get_last_motion(mentions[:at]) if placed else None
    return motion is not None and motion.gives


def _is_giving_way(mentions: list[Mention], at: int, _before: int) -> bool:
    """Return whether it is what all of it stands on that gives way: "its knees buckle"."""
    behind = next((each for each in mentions[at + 1 :] if each.kind is not MentionKind.FUNCTION), None)
    yields = behind is not None and behind.kind is MentionKind.VERB and behind.phrase.startswith(_YIELDING)
    return yields and mentions[at].words.lower().split()[-1] in get_set("supports")


def _let_fall(mentions: list[Mention], at: int, names: frozenset[str]) -> Mention:
    """The verb of what gives way under the object: of the floor it is a fall, of a leg it is what tips it over."""
    begin = next((i + 1 for i in range(at - 1, -1, -1) if mentions[i].kind is MentionKind.JOIN), 0)
    own, before = names | get_set("pronouns"), mentions[begin:at]
    noun = next((each for each in before if each.form in own | LEXICON.scene_nouns), None)
    if noun is not None and noun.form not in own:
        return replace(mentions[at], value=LEXICON.motions["drop"], phrase="drop")
    borne = any(each.words.lower().split()[-1] in get_set("supports") for each in before)
    topples = any(m.motion is not None and m.motion.effect is Effect.TOPPLE for m in mentions[at + 1 :])
    return empty(mentions[at]) if borne and topples else mentions[at]
