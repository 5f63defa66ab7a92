"""docs/language.md, made of the rows alone."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.harness import Row, link, one_line, provenance, table
from benchmarks.language.notation import FILES, LIMIT

_HEAD = """# Sentences as people understand them

What the offline parser makes of {count} sentences, beside what a person understands by them: kinds of motion,
directions, strength, quantities, how often, which part, when, what stays or is let go, their order, gravity, walls, and
what is held. The expectations were written by hand; some sentences have several good readings, and for some the only
right answer is a refusal or a plain word that something was not understood. They have nine authors. The
[first author's]({first}) were written before the parser was tuned on them, by the parser's own author; a third of
them, by their hash, is the test split. The [second]({second}), the [third]({third}), the [fourth]({fourth}) and the
[fifth author's]({fifth}) were written by somebody who had read neither the parser nor, but for a few lines that show
the notation, anybody else's sentences, and so were the [seventh's]({seventh}), the [eighth's]({eighth}) and the
[ninth's]({ninth}); half of the second's, the fourth's, the fifth's and the seventh's, by the same hash, are test
splits. No rule is made for a test split, and nobody looks at its sentences one by one while rules are written. The
third's had one too, until it was opened and rules were made for it: it counts as development now. A second reader, who
saw neither the parser nor what it makes of any sentence, went through all sentences of the third, the fourth and the
fifth author, test splits too, and added readings that are as good where one was missing (286 of 720 sentences; none
was taken away). By the expectations as their authors left them 25 of 656 sentences of the test splits were silently
wrong before the third's was opened, by the completed ones 22. Three more such readers later did the same for the first
(188 of 473), the second (140 of 233) and the seventh author (132 of 240). By these three authors' own words, without
these readings (`--own-words`), 20 of 638 sentences were silently wrong (3.13 %) before a second reading was held
against the grammar's (below); what is silently wrong since, by both, the tables say.

How clean the test splits are: the second author mended the parser afterwards, with the development splits alone, but
remembers sentences of their own, and saw how many of each group of a test split were silently wrong. The fourth and the
fifth author mended nothing: somebody else did, who saw how many of each split were right and silently wrong, also with
a construction or a class of words left out, and by a slip the text of seven sentences of the test splits (six of the
fourth author's, one of the fifth's). After that somebody's last rule most sentences of both were shown by another slip;
rules made since are somebody else's, who saw totals alone. The first author's test split was not read by whoever
mended, and its silently wrong share is what to expect of sentences in a style that the grammar was made for; the other
authors' first figures (below) are what to expect of a newcomer's. The [sixth author's]({sixth}) are all development:
whoever wrote them mended the parser by them afterwards, and saw totals alone of the other authors' test splits, but
those several times while rules were written. Three of their expectations were completed after the first run. The
seventh author's test split is the cleanest: whoever mended by the other half, and by all of the eighth's and the
ninth's, saw its totals alone. It did not gain by it: six of its 110 sentences were silently wrong before, and six were
then. About 5 % is what to expect of a newcomer: rules for single sentences do not help there.

So a general check was looked for. Parsers as they were when the third to the ninth author's development sentences were
first read to them gave 75 silent errors and 441 sentences that they read right; of each candidate it was counted how
many of both it marks. What was dropped: words that a sentence reads the same without (31 errors, 98 right sentences),
n-grams of word classes that no other author's right sentence has (17 of 37 against 31 of 89), readings that change
without commas or with a sentence's idle words left out (7 against 22, 11 against 34), words that no evidence quotes,
and a logistic score of forty features, fitted without the author whom it is tried on (14 errors at 3.5 % of the right
sentences). What was kept ([cross_check]({cross_check}), [coherence]({coherence}), [accounting]({accounting})): ways,
parts, sizes, verbs, holds, walls and counts are collected word by word and held against the motions, motions are held
against each other (together though nothing joins them, the same twice, hung up and yet falling), and every verb, way
and strength must be in some clause. On the 75 it was made, so that its 33 say little; of 30 other misreadings by these
parsers, of partly the same sentences, it marks 11, and of 472 sentences that were read right, 1. Of today's development
sentences it marks 2 of 1,244 that were right (0.1 points; 2 points were allowed), and none of the verdicts' 105.
It did less on the test splits than on the old parsers' errors, of which many kinds are read by now: see the tables.

Sentences that are composed of two clear ones ("before B-ing, A", "B, but first A") have an answer that nobody need
write: both, in their order. Of 2,015 such, 167 were silently wrong before and 8 are now; of 2,032 others, by another
seed, 13. Of 281 sentences written afterwards to look for what was left, 14 were silently wrong: rules were made. These
counts, like those on the old parsers, were taken once, by scripts that are not kept; tests compose some such
sentences. The totals of the test splits were looked at seven times while this was made, and decided nothing but whether
to keep it.

*Right* are sentences of which every field is right. *Silently wrong* are those of which something is wrong, and that
were neither refused nor marked as unsure (which keeps a run from being called a success); words that are merely listed
as not understood do not count as a mark. *Marked in vain* were understood and refused or marked all the same. Required:
at most {limit:.0%} silently wrong on the test splits together.
"""
_RULES = Path(__file__).parents[2] / "physagent_jax/agents/rules/language"
_BEFORE = (
    "\n## Before tuning, and by the authors' own words\n\nThe parser as it was when the sentences of each author after "
    "the first were first read to it, and, last, today's by expectations that nobody has completed.\n"
)
_EARLIER = (
    ("before", "The second author's, expectations as they were first written"),
    (
        "before-completed",
        "The same parser, after fifteen of the second author's expectations were completed: a fall over may be a turn "
        "and a fall, a hop comes down, wringing turns two ends, what is held still is held, and a turn to the left is "
        "read either way about the vertical, where the first author's sentences have the other way. The turns, two "
        "sentences, came last, when their groups were seen to be misread",
    ),
    (
        "third-before",
        "The third author's, which were written and committed before they were read to the parser, as it was after the "
        "second author's; one expectation of the development split was corrected afterwards",
    ),
    (
        "fifth-before",
        "The fourth and the fifth author's, which were written and committed before they were read to the parser, as "
        "it was after the third author's",
    ),
    (
        "fifth-before-completed",
        "The same parser, with one expectation of the fifth author's development split completed (a plant that is "
        "pushed three times goes to and fro), and with falls that may begin with the lean that they follow, in every "
        "author's expectations",
    ),
    (
        "sixth-before",
        "The sixth author's, which were written and committed before they were read to the parser",
    ),
    (
        "seventh-before",
        "The seventh, the eighth and the ninth author's, which were written and committed before they were read to the "
        "parser; two lines that did not keep to the notation were corrected first",
    ),
    (
        "own-words",
        "Today's parser, by the first, the second and the seventh author's expectations as they left them",
    ),
)
_COLUMNS = (
    "sentences",
    "fields right",
    "sentences right",
    "silently wrong",
    "refused",
    "marked unsure",
    "marked in vain",
)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The page's text."""
    rows = result["sentences"]["rows"] if "sentences" in result else []
    files = {author: link(Path(__file__).with_name(name), target) for author, (name, _) in FILES.items()}
    checks = {
        name: link(_RULES / f"{name}.py", target) for name in ("cross_check", "coherence", "accounting")
    }
    text = _HEAD.format(count=len(rows), limit=LIMIT, **files, **checks)
    text += f"\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, ("sentences",))
    if not rows:
        return text
    text += _compare_splits(rows) + _state_requirement(rows)
    text += _describe_earlier(json_path, target)
    text += "\n## By group\n" + _compare_by(rows, "group")
    text += "\n## By field\n\nOf the fields that sentences have which were not refused.\n"
    text += _list_fields(rows)
    text += "\n## Not right on the development splits\n\n"
    return text + _list_wrong([row for row in rows if row["split"] == "development"])


def _state_requirement(rows: Sequence[Row]) -> str:
    """Whether few enough of the sentences held back are silently wrong, all together and by each author."""
    held = [row for row in rows if row["split"] == "test"]
    authors = list(dict.fromkeys(row["author"] for row in held))
    told = []
    for who, chosen in [
        ("all", held),
        *((f"the {a}", [r for r in held if r["author"] == a]) for a in authors),
    ]:
        silent = sum(row["silent"] for row in chosen)
        met = "met" if silent <= LIMIT * len(chosen) else "not met"
        told.append(f"{who}: {silent} of {len(chosen)}, {100 * silent / max(len(chosen), 1):.2f} % ({met})")
    return f"\nSilently wrong of those held back, at most {LIMIT:.0%} required: {'; '.join(told)}.\n"


def _describe_earlier(json_path: Path, target: Path) -> str:
    """The tables of the runs before tuning that lie beside ``json_path``."""
    text = ""
    for name, what in _EARLIER:
        path = json_path.with_stem(f"{json_path.stem}-{name}")
        if path.exists():
            earlier = json.loads(path.read_text())
            text += f"\n{what} (every row is in [{path.name}]({link(path, target)})):\n\n"
            text += provenance(earlier, ("sentences",)) + _compare_splits(earlier["sentences"]["rows"])
    return text and _BEFORE + text


def _compare_splits(rows: Sequence[Row]) -> str:
    """A line for each split, and one for all test splits together."""
    splits = [[split, *_list_figures(_select(rows, split))] for split in _list_splits(rows)]
    splits.append(["all, test", *_list_figures([row for row in rows if row["split"] == "test"])])
    return table(("split", *_COLUMNS), splits)


def _list_splits(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["job"] for row in rows))


def _select(rows: Sequence[Row], split: str) -> list[Row]:
    return [row for row in rows if row["job"] == split]


def _list_figures(rows: Sequence[Row]) -> list[str]:
    fields = sum(row["fields"] for row in rows)
    right = fields - sum(len(row["wrong"]) for row in rows)

    def share(of: Callable[[Row], bool]) -> str:
        return f"{100 * sum(map(of, rows)) / len(rows):.1f} %"

    return [
        str(len(rows)),
        f"{100 * right / fields:.1f} %",
        share(lambda row: not row["wrong"]),
        share(lambda row: row["silent"]),
        share(lambda row: row["answer"] == "refused"),
        share(lambda row: row["answer"] == "unsure"),
        share(lambda row: bool(row["wrong"]) and row["answer"] != "motion"),
    ]


def _compare_by(rows: Sequence[Row], key: str) -> str:
    names = list(dict.fromkeys(row[key] for row in rows))
    lines = []
    for name in names:
        for split in _list_splits(rows):
            group = [row for row in _select(rows, split) if row[key] == name]
            if group:
                lines.append([name, split, *_list_figures(group)[:4]])
    return table((key, "split", *_COLUMNS[:4]), lines)


def _list_fields(rows: Sequence[Row]) -> str:
    names = sorted({name for row in rows for name in row["wrong"]})
    lines = [
        [
            name,
            *(
                str(sum(row["wrong"].count(name) for row in _select(rows, split)))
                for split in _list_splits(rows)
            ),
        ]
        for name in names
    ]
    return table(("field", *(f"wrong in {split}" for split in _list_splits(rows))), lines)


def _list_wrong(rows: Sequence[Row]) -> str:
    lines = [
        f'- {row["object"]}: "{one_line(row["sentence"])}" ({row["answer"]}): '
        f"{', '.join(dict.fromkeys(row['wrong']))}; expected `{row['expected']}`\n"
        for row in rows
        if row["wrong"]
    ]
    return "".join(lines) or "Nothing.\n"
