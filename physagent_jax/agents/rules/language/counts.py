"""Numbers in a sentence: quantities, times, counts, and which of several strokes."""

from __future__ import annotations

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.quantities import match_quantity
from physagent_jax.agents.rules.language.reader import Reader
from physagent_jax.agents.rules.language.timing import match_time, parse_number


def read_quantity(reader: Reader, at: int) -> Mention | None:
    """Reads "90 degrees", "half a body length", "twice as strong"."""
    found = match_quantity(reader.tokens, at)
    if found is None:
        return None
    quantity, behind = found
    used = [index for index in range(at, min(behind, len(reader.tokens))) if index not in reader.used]
    if quantity.dimension == "strength":
        return reader.make_mention(MentionKind.COMPARATIVE, quantity.value, "as strong", used)
    return reader.make_mention(MentionKind.QUANTITY, quantity, "quantity", used)


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
        and reader.get_text(counted[1]) in ("times", "time")
        and reader.tokens[at].text not in ("a", "an")
    ):
        # A count beyond any clip's frames means nothing more than "very often".
        repeat = m.Repeat(int(min(max(counted[0], 1), 1000)))
        return reader.make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1] + 1)))
    if counted and counted[0] > 1 and counted[1] < len(reader.tokens):
        behind = counted[1] + (reader.get_text(counted[1]) in m.INTENSITIES)
        thing = reader.tokens[min(behind, len(reader.tokens) - 1)]  # "three gusts", "two small jumps"
        if thing.text.endswith("s") and (thing.lemma in v.VERBS or thing.text in v.CAUSES):
            repeat = m.Repeat(int(min(counted[0], 1000)))
            return reader.make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1])))
    return None
