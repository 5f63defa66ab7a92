"""From words to forces: what the semantic agent made of the sentence."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.forces.naming import name_places
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import ExpectedMotion
from physagent_jax.report.expectations import describe_motion, list_details
from physagent_jax.report.force_cards import Setting, make_force_cards
from physagent_jax.report.formats import spell_out
from physagent_jax.report.layout import make_list, make_table
from physagent_jax.report.markup import Markup, div, join, span, tag

# What a value is about, told from its place: decides the highlight's colour.
TOPICS = (
    ("direction", ("vector", "direction", "axis", "normal")),
    ("strength", ("magnitude", "strength")),
    ("time", ("active_time", "window", "repeats", "released")),
    ("place", ("region", "anchor", "object")),
)
UNKNOWN_TOPIC, DEFAULT_TOPIC = "unknown", "action"
TOPIC_NAMES = {
    "action": "what happens",
    "direction": "direction",
    "strength": "strength",
    "time": "when",
    "place": "where, and what is held",
    "unknown": "not understood",
}


@dataclasses.dataclass(frozen=True)
class Highlight:
    """A stretch of the prompt and what it led to.

    Attributes:
        start, end: Character range.
        topic: Key of `TOPIC_NAMES`.
        rows: Indices of the evidence, empty for words that were not understood.
    """

    start: int
    end: int
    topic: str
    rows: tuple[int, ...]


def make_words_section(prompt: str, reply: SemanticReply, setting: Setting) -> list[Markup | None]:
    """The marked prompt, the table of evidence, assumptions, expectations and the force field."""
    highlights = find_highlights(prompt, reply.evidence, reply.not_understood)
    marked = {row for highlight in highlights for row in highlight.rows}
    return [
        tag("p", _mark_prompt(prompt, highlights), class_="prompt"),
        _make_topic_legend({highlight.topic for highlight in highlights}),
        _make_evidence_table(reply.evidence, marked, reply.force_field),
        div(
            "listings",
            make_list(
                "What a viewer should see", [describe_expectation(e, setting) for e in reply.expectations]
            ),
            make_list("Assumptions", reply.notes),
            make_list("Ignored: looks, scenery, camera", reply.ignored),
            make_list("Not understood", reply.not_understood),
            make_list("Unsure, so that no motion is called a success", reply.unsure),
        ),
        tag("h3", "The force field, as first compiled"),
        make_force_cards(reply.force_field, setting, name="compiled"),
    ]


def find_highlights(
    prompt: str, evidence: Sequence[Evidence], not_understood: Sequence[str]
) -> list[Highlight]:
    """Places each piece of evidence in the prompt.

    Longer phrases are placed first; a shorter one goes where it does not overlap them, and joins the
    phrase that contains it if there is no such place.
    """
    topics = [(item.words, find_topic(item.field), row) for row, item in enumerate(evidence)]
    topics += [(words, UNKNOWN_TOPIC, None) for words in not_understood]
    placed: list[Highlight] = []
    for words, topic, row in sorted(topics, key=lambda entry: -len(entry[0])):
        rows = () if row is None else (row,)
        spans = _find_occurrences(prompt, words)
        free = [s for s in spans if not any(_do_overlap(s, (h.start, h.end)) for h in placed)]
        if free:
            placed.append(Highlight(*free[0], topic, rows))
            continue
        for index, old in enumerate(placed):
            if any(_do_overlap(s, (old.start, old.end)) for s in spans):
                placed[index] = dataclasses.replace(old, rows=old.rows + rows)
                break
    return sorted(placed, key=lambda highlight: highlight.start)


def find_topic(field: str) -> str:
    """The topic of a value's place, like "actions[0].vector"."""
    for topic, names in TOPICS:
        if any(name in field for name in names):
            return topic
    return DEFAULT_TOPIC


def describe_expectation(expected: ExpectedMotion, setting: Setting) -> Markup:
    """One expected motion as a sentence."""
    head = describe_motion(expected, setting.directions)
    details = ", ".join(list_details(expected, setting.directions, setting.frame_dt))
    quote = span("quiet", f" \u2014 from \u201c{expected.words}\u201d") if expected.words else None
    return join(tag("strong", head[0].upper() + head[1:]), f": {details}", quote)


def _find_occurrences(prompt: str, words: str) -> list[tuple[int, int]]:
    """Character ranges of ``words`` in ``prompt``, whole words first, whatever the case and spacing."""
    pieces = [re.escape(piece) for piece in words.split()]
    if not pieces:
        return []
    pattern = r"\s+".join(pieces)
    for candidate in (rf"(?<!\w){pattern}(?!\w)", pattern):
        spans = [match.span() for match in re.finditer(candidate, prompt, re.IGNORECASE)]
        if spans:
            return spans
    return []


def _do_overlap(a: tuple[int, int], b: tuple[int, int]) -> bool:
    return a[0] < b[1] and b[0] < a[1]


def _mark_prompt(prompt: str, highlights: Sequence[Highlight]) -> Markup:
    parts, position = [], 0
    for highlight in highlights:
        parts.append(prompt[position : highlight.start])
        parts.append(_mark_words(prompt[highlight.start : highlight.end], highlight))
        position = highlight.end
    return join(*parts, prompt[position:])


def _mark_words(text: str, highlight: Highlight) -> Markup:
    if not highlight.rows:
        return tag("mark", text, class_=f"topic {highlight.topic}", title="not understood: led to nothing")
    numbers = ",".join(str(row + 1) for row in highlight.rows)
    inner = [text, tag("sup", numbers)]
    return tag("a", *inner, class_=f"topic {highlight.topic}", href=f"#evidence-{highlight.rows[0]}")


def _make_topic_legend(topics: set[str]) -> Markup | None:
    if not topics:
        return None
    keys = [span(f"topic {name}", title) for name, title in TOPIC_NAMES.items() if name in topics]
    return div("topics", join(*keys))


def _make_evidence_table(evidence: Sequence[Evidence], marked: set[int], force_field: ForceField) -> Markup:
    if not evidence:
        return tag("p", "The agent gave no evidence for its choices.", class_="quiet")
    rows, ids = [], []
    for index, item in enumerate(evidence):
        words = span(f"topic {find_topic(item.field)}", item.words or "\u2014")
        if index not in marked:
            words = join(words, span("quiet", " (not literally in the sentence)"))
        rows.append([str(index + 1), words, _link_field(item.field, force_field), item.value, item.why])
        ids.append(f"evidence-{index}")
    return make_table(["", "words", "led to", "value", "because"], rows, ids=ids, class_="evidence")


def _link_field(field: str, force_field: ForceField) -> Markup:
    """The value's name, linked to its card if it has one."""
    match = re.match(r"(actions|constraints)\[(\d+)\]", field)
    name = span("", name_places(field, force_field) if match else spell_out(field).replace(".", ", "))
    return tag("a", name, href=f"#compiled-{match[1]}-{match[2]}") if match else name
