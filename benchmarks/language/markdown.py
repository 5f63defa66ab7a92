"""Tables of docs/language.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from benchmarks.harness import Page, Result, Row, Rows, Tables, condense_section, provenance, table
from benchmarks.language.notation import SPLITS
from benchmarks.language.totals import OUTCOMES, REQUIRED, find_outcome

PARTS = ("sentences",)
_WORST = 12  # groups that the page lists


def condense(result: Result) -> Result:
    """Counts of sentences by author, split and group: outcomes, ignored words and wrong fields."""
    return {
        part: condense_section(section, _count_groups(section["rows"])) for part, section in result.items()
    }


def write_tables(summary: Result) -> Tables:
    """The tables of docs/language.md, of a summary."""
    tables = {"runs": provenance(summary, PARTS)}
    if "sentences" in summary:
        rows = summary["sentences"]["rows"]
        tables["totals"] = _list_totals(rows)
        tables["authors"] = _compare_authors(rows)
        tables["groups"] = _compare_groups(rows)
        tables["fields"] = _list_fields(rows)
    if "first_readings" in summary:
        tables["first readings"] = _list_first_readings(summary["first_readings"]["rows"])
    return tables


def _count_groups(rows: Rows) -> Rows:
    """A row for each author, split and group of sentences."""
    groups: dict[tuple[str, str, str], Rows] = {}
    for row in rows:
        groups.setdefault((row["split"], row["author"], row["group"]), []).append(row)
    return [
        {
            "split": split,
            "author": author,
            "group": group,
            "sentences": len(mine),
            "fields": sum(row["fields"] for row in mine),
            **{name: n for name, n in Counter(map(find_outcome, mine)).items()},
            "ignored": sum(bool(row["named"]) and row["answer"] == "motion" for row in mine),
            "wrong": dict(Counter(name for row in mine for name in row["wrong"])),
        }
        for (split, author, group), mine in groups.items()
    ]


_COLUMNS = ("sentences", "fields right", *OUTCOMES, "words ignored")


def _list_totals(rows: Rows) -> str:
    """A line for each split, and whether it is as required."""
    lines = []
    for split in SPLITS:
        mine = [row for row in rows if row["split"] == split]
        lines.append([split, *_list_figures(mine), _describe_requirement(split, mine)])
    return table(("split", *_COLUMNS, "required"), lines)


def _describe_requirement(split: str, rows: Sequence[Row]) -> str:
    if split not in REQUIRED:
        return ""
    (least, most), count = REQUIRED[split], _sum(rows, "sentences")
    met = _sum(rows, "right") >= least * count and _sum(rows, "silently wrong") <= most * count
    return f"right {least:.0%}, silently wrong {most:.0%}: {'met' if met else 'not met'}"


def _compare_authors(rows: Rows) -> str:
    """A line for each author of each split."""
    keys = dict.fromkeys((row["split"], row["author"]) for row in rows)
    lines = [
        [f"{author}, {split}", *_list_figures(row for row in rows if (row["split"], row["author"]) == key)]
        for key in keys
        for split, author in [key]
        if split in REQUIRED
    ]
    return table(("author", *_COLUMNS), lines)


def _list_figures(rows: Iterable[Row]) -> list[str]:
    """Cells of `_COLUMNS`."""
    rows = list(rows)
    count, fields = _sum(rows, "sentences"), _sum(rows, "fields")
    wrong = sum(sum(row["wrong"].values()) for row in rows)
    shares = (_sum(rows, name) / max(count, 1) for name in (*OUTCOMES, "ignored"))
    return [str(count), f"{1 - wrong / max(fields, 1):.1%}", *(f"{share:.1%}" for share in shares)]


def _compare_groups(rows: Rows) -> str:
    """Numbers of sentences of the groups with the most development sentences that are silently wrong."""
    silent = Counter()
    for row in rows:
        silent[row["group"]] += row.get("silently wrong", 0) * (row["split"] == "development")
    lines = []
    for name, _ in silent.most_common(_WORST):
        cells: list[Any] = []
        for split in REQUIRED:
            mine = [row for row in rows if (row["group"], row["split"]) == (name, split)]
            cells += [_sum(mine, key) for key in _GROUP_COLUMNS] if mine else [""] * len(_GROUP_COLUMNS)
        lines.append([name, *cells])
    return table(("group", *(f"{split}: {head}" for split in REQUIRED for head in _GROUP_COLUMNS)), lines)


_GROUP_COLUMNS = ("sentences", "right", "silently wrong")


def _list_fields(rows: Rows) -> str:
    """Counts of wrong fields, of all sentences of a split that were not refused."""
    wrong = {
        split: sum((Counter(row["wrong"]) for row in rows if row["split"] == split), Counter())
        for split in REQUIRED
    }
    names = sorted(set().union(*wrong.values()))
    return table(("field", *wrong), [[name, *(count[name] for count in wrong.values())] for name in names])


def _list_first_readings(rows: Rows) -> str:
    """A line for each author: all sentences, as they were read at first sight."""
    lines = []
    for author in dict.fromkeys(row["author"] for row in rows):
        mine = [row for row in rows if row["author"] == author]
        count = _sum(mine, "sentences")
        shares = (_sum(mine, name) / count for name in ("right", "silent"))
        lines.append([author, count, *(f"{share:.1%}" for share in shares)])
    return table(("author", "sentences", "right", "silently wrong"), lines)


def _sum(rows: Iterable[Row], name: str) -> int:
    return sum(row.get(name, 0) for row in rows)


PAGE = Page(
    "language",
    "python -m benchmarks.language",
    write_tables,
    (
        "physagent_jax/agents",
        *(f"benchmarks/language/{name}" for name in ("corpus", "notation.py", "score.py")),
    ),
    condense,
)
