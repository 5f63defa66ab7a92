"""Numbers in a sentence: quantities, times, counts, and which of several strokes."""

from __future__ import annotations

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.quantities import Quantity, match_number, match_quantity
from physagent_jax.agents.rules.language.reader import Reader
from physagent_jax.agents.rules.language.timing import match_time, parse_number


def read_quantity(reader: Reader, at: int) -> Mention | None:
    """Reads "90 degrees", "half a body length", "twice as strong"."""
    found = match_quantity(reader.tokens, at) or _match_part_of_turn(reader, at) or _match_facing(reader, at)
    if found is None:
        return None
    quantity, behind = found
    used = [index for index in range(at, min(behind, len(reader.tokens))) if index not in reader.used]
    if quantity.dimension == "strength":
        return reader.make_mention(MentionKind.COMPARATIVE, quantity.value, "as strong", used)
    return reader.make_mention(MentionKind.QUANTITY, quantity, "quantity", used)


def _match_part_of_turn(reader: Reader, at: int) -> tuple[Quantity, int] | None:
    """Reads the quarter in "it turns a quarter to the left": of a turn, where that is what was done last."""
    last = next((e.value for e in reversed(reader.mentions) if isinstance(e.value, v.Verb)), None)
    counted = match_number(reader.tokens, at)
    if last is None or last.effect is not v.Effect.TURN or counted is None or not 0.0 < counted[0] < 1.0:
        return None
    behind = reader.get_text(counted[1])
    goes_on = behind in ("", "one", "back", "to", ".", ",", "and", "then", "clockwise", "left", "right")
    return (Quantity(360.0 * counted[0], "degrees"), counted[1]) if goes_on else None


def _match_facing(reader: Reader, at: int) -> tuple[Quantity, int] | None:
    """Reads "it turns to face the other way", "... to face away": half a turn."""
    last = next((e.value for e in reversed(reader.mentions) if isinstance(e.value, v.Verb)), None)
    faces = reader.get_text(at) in ("face", "facing") and last is not None and last.effect is v.Effect.TURN
    for ways in (("the", "other", "way"), ("the", "opposite", "way"), ("away",), ("backwards",)):
        if faces and tuple(reader.get_text(at + 1 + i) for i in range(len(ways))) == ways:
            return Quantity(180.0, "degrees"), at + 1 + len(ways)
    return None


def read_ordinal(reader: Reader, at: int) -> Mention | None:
    """Reads "the second time", "the second harder": one of several strokes."""
    order = {"second": 2, "third": 3, "last": -1}.get(reader.get_text(at))
    if order is None or reader.get_text(at - 1) != "the":
        return None
    after = reader.get_text(at + 1)
    counted = after in ("time", "one") and reader.get_text(at - 2) != "for"
    if counted or after in m.COMPARATIVES or after in m.INTENSITIES or after in ("more", "much"):
        return reader.make_mention(MentionKind.ORDINAL, order, "ordinal", [at, at + 1][: 1 + counted])
    return None


def read_time_or_count(reader: Reader, at: int) -> Mention | None:
    """Reads "for two seconds", "three times", and the number in "three gusts"."""
    found = match_time(reader.tokens, at)
    if found:
        return reader.make_mention(MentionKind.TIME, found[0], "time", list(range(at, found[1])))
    counted = parse_number(reader.tokens, at)
    if (
        counted
        and reader.get_text(counted[1]) in ("times", "time", "x", "cycles", "repetitions", "strokes")
        and reader.tokens[at].text not in ("a", "an")
    ):
        # A count beyond any clip's frames means nothing more than "very often".
        repeat = m.Repeat(int(min(max(counted[0], 1), 1000)))
        return reader.make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1] + 1)))
    if counted and counted[0] > 1 and counted[1] < len(reader.tokens):
        behind = counted[1] + (reader.get_text(counted[1]) in m.INTENSITIES)
        thing = reader.tokens[min(behind, len(reader.tokens) - 1)]  # "three gusts", "two small jumps"
        several = thing.text.endswith("s") and thing.text != thing.lemma  # "3.2 Compress it" is a heading
        verb = v.VERBS.get(thing.lemma)
        if counted[0] != int(counted[0]):  # "one and a half somersaults"
            turns = several and verb is not None and verb.effect is v.Effect.TURN
            found = Quantity(360.0 * counted[0], "degrees")
            used = list(range(at, counted[1]))
            return reader.make_mention(MentionKind.QUANTITY, found, "quantity", used) if turns else None
        if several and thing.lemma in v.VERBS or thing.text.endswith("s") and thing.text in v.CAUSES:
            repeat = m.Repeat(int(min(counted[0], 1000)))
            return reader.make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1])))
    return None
