"""Tables of docs/language.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from benchmarks.harness import Page, Result, Row, Rows, Tables, condense_section, provenance, table
from benchmarks.language.notation import FILES, LIMIT

PARTS = ("sentences", "own_words")
COMPLETED = ("first", "second", "seventh")
"""Authors whose expectations second readers have completed, where `own_words` can leave these readings out."""
FIRST_READINGS = {
    "before": ("second",),
    "third-before": ("third",),
    "fifth-before": ("fourth", "fifth"),
    "sixth-before": ("sixth",),
    "seventh-before": ("seventh", "eighth", "ninth"),
}
"""Readings by the parser as it was when sentences were first read to it, and whose these were."""
_COUNTS = ("sentences", "fields", "right", "silent", "refused", "unsure", "vain")

_COLUMNS = (
    "sentences",
    "fields right",
    "sentences right",
    "silently wrong",
    "refused",
    "marked unsure",
    "marked in vain",
)


def condense(result: Result) -> Result:
    """Counts of sentences by split and group: right, silently wrong, refused and marked, with the wrong fields."""
    return {
        part: condense_section(section, _count_groups(section["rows"])) for part, section in result.items()
    }


def write_tables(summary: Result) -> Tables:
    """The tables of docs/language.md, of a summary."""
    rows = {part: section["rows"] for part, section in summary.items()}
    tables = {"runs": provenance(summary, PARTS)}
    if "sentences" in rows:
        tables["splits"] = _compare_splits(rows["sentences"]) + _state_requirement(rows["sentences"])
        tables["groups"] = _compare_groups(rows["sentences"])
        tables["fields"] = _list_fields(rows["sentences"])
    if "own_words" in rows:
        tables["own words"] = _shorten([row for row in rows["own_words"] if row["author"] in COMPLETED])
    if "first_readings" in rows:
        tables["first readings"] = _shorten(
            [row for row in rows["first_readings"] if row["author"] in FIRST_READINGS.get(row["reading"], ())]
        )
    return tables


def _count_groups(rows: Rows) -> Rows:
    """A row for each split and group of sentences."""
    groups: dict[tuple[str, str], Rows] = {}
    for row in rows:
        groups.setdefault((row["job"], row["group"]), []).append(row)
    return [
        {
            "job": job,
            "author": mine[0]["author"],
            "split": mine[0]["split"],
            "group": group,
            "sentences": len(mine),
            "fields": sum(row["fields"] for row in mine),
            "right": sum(not row["wrong"] for row in mine),
            "silent": sum(row["silent"] for row in mine),
            "refused": sum(row["answer"] == "refused" for row in mine),
            "unsure": sum(row["answer"] == "unsure" for row in mine),
            "vain": sum(bool(row["wrong"]) and row["answer"] != "motion" for row in mine),
            "wrong": dict(Counter(name for row in mine for name in row["wrong"])),
        }
        for (job, group), mine in groups.items()
    ]


def _state_requirement(rows: Sequence[Row]) -> str:
    """Return whether few enough of the sentences held back are silently wrong, all together and by each author."""
    held = [row for row in rows if row["split"] == "test"]
    told = []
    for author in (None, *dict.fromkeys(row["author"] for row in held)):
        chosen = [row for row in held if author in (None, row["author"])]
        silent, count = (sum(row[name] for row in chosen) for name in ("silent", "sentences"))
        met = "met" if silent <= LIMIT * count else "not met"
        who = f"the {author}" if author else "all"
        told.append(f"{who}: {silent} of {count}, {100 * silent / max(count, 1):.2f}% ({met})")
    return f"\nSilently wrong of those held back, at most {LIMIT:.0%} required: {'; '.join(told)}.\n"


def _compare_splits(rows: Sequence[Row]) -> str:
    """A line for each split, and one for all test splits together."""
    splits = [[split, *_list_figures(_select(rows, split))] for split in _list_splits(rows)]
    splits.append(["all, test", *_list_figures([row for row in rows if row["split"] == "test"])])
    return table(("split", *_COLUMNS), splits)


def _shorten(rows: Sequence[Row]) -> str:
    """A line for each split, with the most important figures."""
    figures = {split: _list_figures(_select(rows, split)) for split in _list_splits(rows)}
    lines = [[split, found[0], *found[2:4]] for split, found in figures.items()]
    return table(("split", "sentences", "sentences right", "silently wrong"), lines)


def _list_splits(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["job"] for row in rows))


def _select(rows: Sequence[Row], split: str) -> list[Row]:
    return [row for row in rows if row["job"] == split]


def _list_figures(rows: Sequence[Row]) -> list[str]:
    total = Counter({name: sum(row[name] for row in rows) for name in _COUNTS})
    wrong = sum(sum(row["wrong"].values()) for row in rows)

    def share(name: str) -> str:
        return f"{100 * total[name] / total['sentences']:.1f}%"

    return [
        str(total["sentences"]),
        f"{100 * (total['fields'] - wrong) / total['fields']:.1f}%",
        *(share(name) for name in ("right", "silent", "refused", "unsure", "vain")),
    ]


def _compare_groups(rows: Sequence[Row]) -> str:
    """Counts of right and silently wrong sentences, of the groups that have a silently wrong one."""
    lines = []
    for name in dict.fromkeys(row["group"] for row in rows if row["silent"]):
        cells = []
        for split in ("development", "test"):
            mine = [row for row in rows if (row["group"], row["split"]) == (name, split)]
            cells += [
                sum(row[key] for row in mine) if mine else "" for key in ("sentences", "right", "silent")
            ]
        lines.append([name, *cells])
    heads = ("sentences", "right", "silently wrong")
    return table(
        ("group", *(f"{split}: {head}" for split in ("development", "test") for head in heads)), lines
    )


def _list_fields(rows: Sequence[Row]) -> str:
    """Counts of wrong fields, of all development and of all test splits."""
    wrong = {
        split: sum((Counter(row["wrong"]) for row in rows if row["split"] == split), Counter())
        for split in ("development", "test")
    }
    names = sorted(wrong["development"] | wrong["test"])
    return table(("field", *wrong), [[name, *(count[name] for count in wrong.values())] for name in names])


PAGE = Page(
    "language",
    "python -m benchmarks.language",
    write_tables,
    (
        "physagent_jax/agents/rules",
        *(
            f"benchmarks/language/{name}"
            for name in ("notation.py", "score.py", *(file for file, _ in FILES.values()))
        ),
    ),
    condense,
)
