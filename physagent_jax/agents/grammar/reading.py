"""A sentence as a list of mentions in the order of the words.

At each word the first of `_READERS` that finds something there wins: those that look farthest stand first. Then passes
over the whole list give words their scope.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from physagent_jax.agents.grammar.asides import PASSES
from physagent_jax.agents.grammar.chunks import read_phrase, read_word
from physagent_jax.agents.grammar.measures import match_count, match_number, match_quantity, match_time
from physagent_jax.agents.grammar.mentions import Mention, MentionKind, Reader, get_last_motion, has_motion
from physagent_jax.agents.grammar.nouns import read_named_part, read_part, read_solid
from physagent_jax.agents.grammar.tables import LEXICON, NUMBERS, get_set, read_sections
from physagent_jax.agents.lexicon import Effect, Join, Repeat

_MOST_STROKES = 1000  # a count beyond any clip's frames means nothing more than "very often"


def read_mentions(
    sentence: str, names: frozenset[str], parts: frozenset[tuple[str, ...]] = frozenset()
) -> list[Mention]:
    """The mentions of ``sentence``; ``names`` are for the object, ``parts`` for its parts: no verbs after "the"."""
    reader = Reader(sentence, names, parts)
    for at in range(len(reader.tokens)):
        if at not in reader.used:
            reader.mentions.append(_read_at(reader, at))
    mentions = reader.mentions
    for change in PASSES:
        mentions = change(mentions, names)
    return mentions


def _read_at(reader: Reader, at: int) -> Mention:
    token = reader.tokens[at]
    if not token.is_word:
        join = {",": Join.COMMA, ":": Join.RESULT}.get(token.text, Join.THEN)
        return reader.make_mention(MentionKind.JOIN, join, token.text, [at])
    if (part := read_named_part(reader, at)) is not None:
        return part
    before, one = reader.get_text(at - 1), token.text.removesuffix("s")
    if one != token.text and one in reader.names and NUMBERS.get(before, 0.0) > 1:  # there is one object
        return reader.make_mention(MentionKind.UNKNOWN, None, f"{before} {token.text}", [at])
    noun = reader.is_after_determiner(at) or reader.get_text(at + 1) in reader.names  # "race car"
    noun |= at > 0 and reader.tokens[at - 1].possessive  # "the monster's head"
    blows = token.text in ("wind", "winds") and reader.get_text(at + 1) not in reader.names  # no turbine
    if token.text in reader.names and (noun or token.lemma not in LEXICON.motions) and not blows:
        return reader.make_mention(MentionKind.FUNCTION, None, token.text, [at])
    found = (read(reader, at) for read in _READERS)
    return next((mention for mention in found if mention is not None), None) or read_word(reader, at)


def _read_least(reader: Reader, at: int) -> Mention | None:
    """Reads "four or" of "four or five times": the larger number counts; "2-3 times" has a dash between."""
    link = reader.get_text(at + 1)
    dash = link.isdigit() and reader.sentence[reader.tokens[at].end : reader.tokens[at + 1].start] in (
        "-",
        "–",
    )
    if dash and reader.get_text(at).isdigit() and float(link) > float(reader.get_text(at)):
        return reader.make_mention(MentionKind.FUNCTION, None, "least", [at])
    least, most = match_number(reader.words, at), match_number(reader.words, at + 2)
    ends = most is not None and reader.get_text(most[1]) in read_sections()["times"]
    if least is None or most is None or link != "or" and not (link in ("to", "and") and ends):
        return None
    if least[1] != at + 1 or not 1 <= least[0] < most[0] or reader.get_text(at) in ("a", "an"):
        return None
    return reader.make_mention(MentionKind.FUNCTION, None, "least", [at, at + 1])


def _read_once(reader: Reader, at: int) -> Mention | None:
    """Reads "once it has landed", a time and no count, and "..., so it goes right", what comes of it."""
    join = {"once": Join.AFTER, "so": Join.RESULT}.get(reader.get_text(at))
    if reader.get_text(at) == "that" and "so" in (reader.get_text(at - 2), reader.get_text(at - 3)):
        join = Join.RESULT  # "so fast that its leaves fly out"
    if reader.get_text(at) == "where" and reader.get_text(at - 1) in (",", "ground", "floor", "table"):
        join = Join.RESULT  # "it falls on the floor, where it squashes flat"
    told = has_motion(reader.mentions) and reader.mentions[-1].kind is MentionKind.INTENSITY
    if told and reader.get_text(at - 2) == "so" and reader.get_text(at) in get_set("pronouns_of_owners"):
        return reader.make_mention(
            MentionKind.JOIN, Join.RESULT, "so much", [at]
        )  # "so hard its lid rattles"
    subject = get_set("pronouns") | get_set("pronouns_of_owners") | reader.names | {"the"}
    if join is None or reader.get_text(at + 1) not in subject:
        return None
    return reader.make_mention(MentionKind.JOIN, join, reader.get_text(at), [at])


def _read_inversion(reader: Reader, at: int) -> Mention | None:
    """Reads "inside out", which nothing can be turned here: a doubt, in place of the turn."""
    if (reader.get_text(at), reader.get_text(at + 1)) != ("inside", "out"):
        return None
    for index, mention in enumerate(reader.mentions):
        if mention.motion is not None and mention.motion.effect is Effect.TURN:
            reader.mentions[index] = replace(mention, kind=MentionKind.FUNCTION, value=None)
    return reader.make_mention(MentionKind.UNKNOWN, None, "inside out", [at, at + 1])


def _read_nothing(reader: Reader, at: int) -> Mention | None:
    """Reads "first nothing, then it falls": a time in which it is still."""
    behind = (",", ";", ".", "then", "for", "at")
    if reader.get_text(at) != "nothing" or reader.get_text(at + 1) not in behind:
        return None
    return reader.make_mention(MentionKind.VERB, LEXICON.motions["wait"], "wait", [at])


def _read_load(reader: Reader, at: int) -> Mention | None:
    """Reads "someone sits down on the sofa", "someone sits on it": it is pressed."""
    behind = at + 1 + (reader.get_text(at + 1) == "down")
    noun = behind + 1 + (reader.get_text(behind + 1) in get_set("determiners"))
    loaded = reader.tokens[at].lemma in get_set("loads") and reader.get_text(behind) in ("on", "onto", "upon")
    told = reader.names | (get_set("objects") if reader.get_text(at - 1) in get_set("persons") else set())
    if not loaded or reader.get_text(noun) not in told or has_motion(reader.mentions):
        return None
    press = LEXICON.motions["press"]
    return reader.make_mention(MentionKind.VERB, press, "press", list(range(at, behind + 1)))


def _read_swing(reader: Reader, at: int) -> Mention | None:
    """Reads "someone swings the axe to the left", which a tool does not do by itself; "swings it down" is a chop."""
    noun, tools = at + 1 + (reader.get_text(at + 1) in get_set("determiners")), get_set("swung")
    done = reader.get_text(at) == "swung" or reader.get_text(noun) == "it"
    done = reader.get_text(noun) in tools or done and not tools.isdisjoint(reader.names)
    sways = any(reader.get_text(k) in get_set("unswung") for k in range(noun, noun + 6))
    if reader.tokens[at].lemma != "swing" or not done or sways:
        return None
    return reader.make_mention(MentionKind.VERB, LEXICON.motions["slash"], "slash", [at])


def _read_prevention(reader: Reader, at: int) -> Mention | None:
    """Reads "keep it from falling", which does not fall, and "nobody pushes it"."""
    after, text = reader.tokens[at + 1] if at + 1 < len(reader.tokens) else None, reader.get_text(at)
    prevented = text == "from" and any(m.form in get_set("prevents") for m in reader.mentions)
    prevented &= after is not None and after.text.endswith("ing")
    if after is None or after.lemma not in LEXICON.motions or not (prevented or text == "nobody"):
        return None
    return reader.make_mention(MentionKind.NOT, None, text, [at])


def _read_state(reader: Reader, at: int) -> Mention | None:
    """An adjective that says what was before: "the fallen robot"; "the floating robot" is weightless."""
    token = reader.tokens[at]
    verb, behind = LEXICON.motions.get(token.lemma), reader.get_text(at + 1)
    hangs = verb is not None and verb.effect is Effect.HOLD and token.text.endswith("ing")
    if hangs and (behind in LEXICON.parts or behind.removesuffix("s") in LEXICON.part_nouns):
        return reader.make_mention(MentionKind.FUNCTION, None, "state", [at])  # "the lowest hanging branch"
    if not reader.is_after_determiner(at) or reader.get_text(at + 1) not in reader.names:
        return None
    if verb is not None and verb.floats and token.text.endswith("ing"):
        return reader.make_mention(MentionKind.GRAVITY, "none", token.text, [at])
    done = token.text != token.lemma and not token.text.endswith(("ing", "s"))
    if verb is None or verb.effect is Effect.HOLD or not done:
        return None  # what holds it ("the tied robot") holds it yet
    return reader.make_mention(MentionKind.FUNCTION, None, "state", [at])


def _read_manner(reader: Reader, at: int) -> Mention | None:
    """The noun in "with great force", "at high speed": its adjective says how it is done."""
    if reader.get_text(at) not in LEXICON.manners or get_last_motion(reader.mentions) is None:
        return None
    before = at - 1
    while reader.get_text(before) in LEXICON.intensities or reader.get_text(before) in LEXICON.degrees:
        before -= 1
    if reader.get_text(before) not in ("with", "at", ","):
        return None
    return reader.make_mention(MentionKind.FUNCTION, None, "manner", [at])


def _read_quantity(reader: Reader, at: int) -> Mention | None:
    """Reads "90 degrees", "half a body length", "twice as strong"."""
    found = match_quantity(reader.words, at)
    if found is None or reader.get_text(at).startswith("doubl") and reader.get_text(at + 1) == "over":
        return None  # "it doubles over"
    quantity, behind = found
    if quantity.dimension == "strength":
        return reader.make_span(MentionKind.COMPARATIVE, quantity.value, "as strong", at, behind)
    return reader.make_span(MentionKind.QUANTITY, quantity, "quantity", at, behind)


def _read_ordinal(reader: Reader, at: int) -> Mention | None:
    """Reads "the second time", "the second harder": one of several strokes; and "two kicks ... and one from above"."""
    if reader.get_text(at) in ("one", "another") and reader.get_text(at - 1) in ("and", "then", ","):
        if reader.get_text(at + 1) in ("from", "to"):
            return reader.make_mention(MentionKind.ORDINAL, 1, "one", [at])
    order = read_sections()["ordinals"].get(reader.get_text(at))
    if order is None or reader.get_text(at - 1) != "the":
        return None
    after = reader.get_text(at + 1)
    counted = after in ("time", "one") and reader.get_text(at - 2) != "for"
    named = reader.tokens[at + 1] if at + 1 < len(reader.tokens) else None
    last = get_last_motion(reader.mentions)
    again = None if named is None else LEXICON.motions.get(named.lemma)
    counted |= again is not None and last is not None and again.effect is last.effect is Effect.JUMP
    if counted or after in LEXICON.comparatives or after in LEXICON.intensities or after == "more":
        return reader.make_mention(MentionKind.ORDINAL, int(order), "ordinal", [at, at + 1][: 1 + counted])
    return None


def _read_time(reader: Reader, at: int) -> Mention | None:
    """Reads "for two seconds", "in the first half"."""
    found = match_time(reader.words, at, lambda: _is_measured(reader, at))
    if found is None:
        return None
    return reader.make_span(MentionKind.TIME, found[0], "time", at, found[1])


def _is_measured(reader: Reader, at: int) -> bool:
    """Return whether it was said how much: "by half its length in a second"; "in a second push it" tells a start.

    Behind a colon the measure may follow: "hit it: in a second it goes by half its length".
    """
    for mention in reversed(reader.mentions):
        if mention.kind is MentionKind.QUANTITY:
            return True
        if mention.kind is MentionKind.JOIN and not mention.words.isalpha() and mention.words != ",":
            break
    if reader.get_text(at - 1) != ":" or reader.get_text(at) not in ("in", "over"):
        return False
    return any(match_quantity(reader.words, i) for i in range(at, min(at + 20, len(reader.tokens))))


def _read_count(reader: Reader, at: int) -> Mention | None:
    """Reads "three times", and the number in "three gusts", "two small jumps"."""
    if counted := match_count(reader.words, at):
        vague = reader.get_text(at) in get_set("vague")
        repeat = Repeat(int(min(max(counted[0], 1), _MOST_STROKES)), vague=vague)
        return reader.make_span(MentionKind.REPEAT, repeat, "times", at, counted[1])
    counted = match_number(reader.words, at)
    whole = counted is not None and counted[0] > 1 and counted[0] == int(counted[0])
    if counted is None or not whole or counted[1] >= len(reader.tokens):
        return None
    behind = counted[1] + (reader.get_text(counted[1]) in LEXICON.intensities)
    thing = reader.tokens[min(behind, len(reader.tokens) - 1)]
    several = thing.text != thing.lemma and (thing.lemma in LEXICON.motions or thing.text == "steps")
    # "3.2 Compress it" is a heading.
    if thing.text.endswith("s") and (several or thing.text in LEXICON.causes):
        repeat = Repeat(int(min(counted[0], _MOST_STROKES)))
        return reader.make_span(MentionKind.REPEAT, repeat, "times", at, counted[1])
    return None


_READERS: tuple[Callable[[Reader, int], Mention | None], ...] = (
    _read_least, read_solid, _read_once, _read_inversion, _read_nothing, _read_load, _read_swing,
    _read_prevention,
    _read_state, _read_manner, _read_quantity, _read_ordinal, read_part, _read_time, _read_count,
    read_phrase
)  # fmt: skip
