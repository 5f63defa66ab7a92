"""Sequels: what comes by itself of a motion or of its cause, none of which is another motion.

"It bounces four times, each bounce lower than the last", "it bursts and the pieces fly everywhere", "when the wind
stops, it springs back".
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import (
    LOOSE,
    Mention,
    MentionKind,
    empty,
    get_last_motion,
    get_phrase,
    has_motion,
    ignore,
    list_segments,
    read_as,
)
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import Effect, Join

_BESIDE = (MentionKind.FUNCTION, *LOOSE)
_ADVERBS = (MentionKind.INTENSITY, MentionKind.DEGREE)
_NEAR = 4  # words from "each" to what it is less by
_RUNNING_OUT = (Effect.PUSH, Effect.ROLL, Effect.TURN)
_WHENS = ("when", "once", "as soon as", "after")
_ENDING = frozenset(("stop", "cease", "halt", "subside", "die down", "calm down"))
_ENDING |= {f"come to {end}" for end in ("rest", "a stop", "a halt", "a standstill")}
_WEATHER = get_set("winds_begin") | get_set("winds_end")


def read_trends(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Ignores that it does so less and less: "each bounce lower than the last", "slower and slower until it stops".

    What bounces or swings does so by itself, and what comes to rest gets slower before. Of other motions it is a doubt.
    """
    result = list(mentions)
    for at in range(1, len(mentions)):
        end = _find_trend(mentions, at)
        motion = get_last_motion(result[:at]) if end > at else None
        if motion is None or result[at].phrase == "aside":
            continue
        begin = at
        while begin and (
            mentions[begin - 1].form in get_set("growing") or mentions[begin - 1].kind in _ADVERBS
        ):
            begin -= 1
        known = motion.bounces or motion.effect is Effect.SWAY
        later = next((each.motion for each in mentions[end:] if each.motion is not None), motion)
        known |= motion.effect in _RUNNING_OUT and later.effect is Effect.STILL
        less = next(k for k in range(at, end) if mentions[k].form in get_set("fading"))
        if not known and mentions[less].motion is None:
            continue  # "each time less" of a push is doubted as it stands
        told = mentions[less]
        result[begin:end] = map(empty, mentions[begin:end])
        kind = MentionKind.IGNORED if known else MentionKind.UNKNOWN
        if not motion.bounces:
            result[less] = replace(told, kind=kind, value=None, phrase=told.form)
    return result


def _find_trend(mentions: list[Mention], at: int) -> int:
    """The end of the words that begin at ``at`` and tell that something gets less each time; ``at`` if none do."""
    forms = [mention.form for mention in mentions[at : at + _NEAR + 1]]
    each, fading = {"each", "every"}, get_set("fading")
    places = [k for k, form in enumerate(forms) if form in fading]
    doubled = len(forms) > 2 and mentions[at + 1].value is Join.AND and forms[0] == forms[2]
    if forms[0] in fading and doubled:
        end = at + 3
    elif forms[0] in each and places:
        end = at + places[0] + 1
    elif forms[0] in fading and not each.isdisjoint(forms[1:3]):
        end = at + 1
    else:
        return at
    if mentions[end : end + 1] and mentions[end].form in each:
        end += 2  # "lower and lower each time"
    if mentions[end : end + 1] and mentions[end].form == "than":
        while end < len(mentions) and (mentions[end].kind in _BESIDE or mentions[end].phrase == "before"):
            end += 1  # "than the one before"
    return min(end, len(mentions))


def read_debris(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties what the pieces do of what bursts or falls apart: "it explodes into pieces that scatter everywhere".

    What a fall or a smash "splits into chunks" breaks by that: nothing pulls at it.
    """
    result, parted, falls = list(mentions), False, False
    for begin, end in list_segments(mentions):
        piece = None
        if (split := _find_split(mentions, begin, end, parted)) is not None and (parted or falls):
            result[begin:end] = map(ignore, mentions[begin:end])
            result[split] = result[split] if parted else read_as(mentions[split], "break")
            parted = True
            continue
        for at in range(begin, end):
            mention, motion = mentions[at], mentions[at].motion
            if mention.form in get_set("debris") and motion is None:
                piece = at
            elif motion is not None and piece is not None and parted:
                behind = [each.form for each in mentions[end : end + 2]]
                last = end + 2 * (behind == ["after", "another"])  # "one after another"
                result[piece:last] = map(empty, mentions[piece:last])
                break
            elif mention.kind not in _BESIDE:
                piece = None
            noun = mentions[at - 1] if at else mention
            if motion is not None and motion.gives and noun.kind is MentionKind.UNKNOWN:
                strewn = mention.phrase.endswith("directions")  # "its three balls roll off in all directions"
                result[at - 1] = replace(noun, kind=MentionKind.IGNORED) if strewn else noun
            if motion is not None:
                parted |= motion.gives or motion.effect is Effect.BURST or motion.manner == "split"
                parted |= mention.phrase.split()[0] in get_set("smashing")
                falls |= motion.effect is Effect.FALL
                relative = get_phrase(mentions, at + 1) in get_set("relatives")
                piece = at + 1 if relative and mention.phrase.split()[-1] in get_set("debris") else piece
    return result


def _find_split(mentions: list[Mention], begin: int, end: int, plain: bool) -> int | None:
    """Index of a verb, maybe ``plain``, whose segment tells what tearing leaves: "splitting into four chunks"."""
    words = " ".join(each.words for each in mentions[begin:end]).lower().split()
    left = not {"in", "into", "to"}.isdisjoint(words) and not get_set("debris").isdisjoint(words)
    told = ((at, mentions[at].motion, mentions[at]) for at in range(begin, end if left else begin))
    tears = (each for each in told if each[1] and each[1].effect is Effect.SCALE and each[1].sign > 0)
    return next((at for at, _, verb in tears if plain or verb.form != verb.phrase.split()[0]), None)


def read_captions(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Empties a title that what follows tells again: "a bottle flip: it goes up, turns once and lands".

    What goes up in a flip leaps, and turns head over heels.
    """
    colon = next((at for at, each in enumerate(mentions) if each.words == ":"), 0)
    title, behind = mentions[:colon], mentions[colon:]
    told = title[-1].motion if title and title[0].form in ("a", "an") else None
    plain = all(each.kind in _BESIDE or each.phrase in names for each in title[:-1])
    again = told is not None and any(each.motion and each.motion.effect is told.effect for each in behind)
    if told is None or title[-1].kind is not MentionKind.VERB or not (plain and again):
        return mentions

    def follow(at: int, each: Mention) -> Mention:
        up = any(way.value == ("up",) for way in behind[at : at + 3])
        if each.motion is None or not told.tumbles:
            return each
        if each.motion.effect is Effect.PUSH and (up or each.motion.direction == "up"):
            return replace(each, value=LEXICON.motions["jump"], phrase="jump")
        turns = each.motion.effect is Effect.TURN and not each.motion.tumbles
        return replace(each, value=told, phrase=title[-1].phrase) if turns else each

    return [*map(empty, title), *(follow(at, each) for at, each in enumerate(behind))]


def read_lulls(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Makes a "then" of the end of what acts: "a gust bends it, and when the wind stops it springs back".

    Nor is a part moved that stops it: "it rolls until the handle stops it". A wind that "picks up" lifts nothing.
    """
    result = list(mentions)
    for at, mention in enumerate(mentions):
        behind = mentions[at + 1 : at + 1 + _NEAR]
        end = next((k for k, each in enumerate(behind) if each.phrase in _ENDING), 0)
        ends = mention.kind is MentionKind.JOIN and mention.phrase in _WHENS and has_motion(mentions[:at])
        acts = end > 0 and (behind[end - 1].form == "it" or behind[end - 1].motion is not None)
        if mention.motion is not None and mention.motion.wind and mention.kind is MentionKind.CAUSE:
            _read_weather(mentions, result, at, names)
        if ends and acts:
            later = has_motion(behind[end + 1 :] + mentions[at + 1 + _NEAR :])
            links = [
                k for k in range(at) if mentions[k].kind is MentionKind.JOIN and has_motion(mentions[:k])
            ]
            for link in [at] if later else links[-1:]:  # "it slides and wobbles when it stops"
                result[link] = replace(mentions[link], value=Join.THEN, phrase="then")
                result[at + later : at + end + 2] = map(empty, mentions[at + later : at + end + 2])
        if mention.phrase == "stop" and behind and behind[0].form in get_set("objects"):
            for k in range(max(at - _NEAR, 0), at):
                result[k] = empty(mentions[k]) if mentions[k].kind is MentionKind.PLACE else result[k]
                if mentions[k].kind is MentionKind.SOLID:
                    result[at] = empty(mention)  # "until a wall stops it": it goes there
    return result


def read_exits(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Makes a release of what pressed on it and leaves: "a hand presses it flat, then it is lifted away"."""
    result, pressed, acts, things = list(mentions), False, False, set[str]()
    acting, own = LEXICON.agents | {"something"}, names | get_set("pronouns")
    for begin, end in list_segments(mentions):
        segment = mentions[begin:end]
        verb = next((k for k, each in enumerate(segment) if each.motion), end - begin)
        said = [{m.phrase, f"{m.phrase} {get_phrase(segment, k + 1)}"} for k, m in enumerate(segment)]
        leaves = next((k for k, words in enumerate(said) if words & get_set("departures")), end)
        doer = next((k for k, each in enumerate(segment) if each.form == "by"), 0)
        told = segment[doer : doer + _NEAR] if doer else segment[: min(verb, leaves)]
        nouns = {m.phrase for m in told if m.kind is MentionKind.UNKNOWN or m.phrase in acting} - names
        acts |= get_phrase(mentions, begin - 1) == "which"
        parts = {m.phrase for m in segment if m.kind is MentionKind.PLACE}
        if leaves <= verb and parts <= things:
            it, up = {m.phrase for m in told} & own, any(m.value == ("up",) for m in segment)
            by_it = bool(things) and not (it & names or up) if it else acts
            if pressed and (nouns <= things if nouns else by_it):
                result[begin:end] = map(empty, segment)
                result[begin + leaves] = read_as(segment[leaves], "let go")
                result[begin - 1] = replace(mentions[begin - 1], value=Join.THEN, phrase="then")
        elif verb < end - begin and (motion := segment[verb].motion) is not None:
            down = motion.effect is Effect.PUSH and any(m.value == ("down",) for m in segment[verb:])
            pressed |= motion.effect is Effect.SCALE and motion.sign < 0 or down
            if told:
                things, acts = things | nouns, not doer and all(m.phrase not in own for m in told)
    return result


def _read_weather(mentions: list[Mention], result: list[Mention], at: int, names: frozenset[str]) -> None:
    """Empties in ``result`` what says that the wind at ``at`` begins, and the wind that ends with a verb of its own."""
    told, own = {}, names | get_set("objects") | get_set("determiners")
    for verb in (k for k in range(at + 1, min(at + _NEAR, len(mentions))) if not told):
        for more in (verb + 1, verb + 2):
            said = " ".join(each.phrase for each in mentions[verb:more])
            if said in _WEATHER and get_phrase(mentions, more) not in own:  # "picks up the boat" lifts it
                told = {said: (verb, more)}
        if mentions[verb].kind not in _BESIDE:
            break
    for said, (verb, more) in told.items():
        first = verb if said in get_set("winds_begin") else at
        for link in [k for k in range(at) if mentions[k].kind is MentionKind.JOIN and first == at][-1:]:
            result[link] = replace(mentions[link], value=Join.THEN, phrase="then")
        result[first:more] = map(empty, mentions[first:more])
