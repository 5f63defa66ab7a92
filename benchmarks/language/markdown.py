"""Tables of docs/language.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from benchmarks.harness import Page, Result, Row, Rows, Tables, condense_section, provenance, table
from benchmarks.language.notation import SPLITS
from benchmarks.language.totals import OUTCOMES, REQUIRED, count_outcomes, is_met

PARTS = ("sentences",)
_COLUMNS = ("sentences", "fields right", *OUTCOMES, "words ignored")
_WORST = 8  # groups that the page lists


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
            **count_outcomes(mine),
            "ignored": sum(bool(row["named"]) and row["answer"] == "motion" for row in mine),
            "wrong": dict(Counter(name for row in mine for name in row["wrong"])),
        }
        for (split, author, group), mine in groups.items()
    ]


def _list_totals(rows: Rows) -> str:
    """A line for each split, and whether it is as required."""
    lines = []
    for split in SPLITS:
        mine = [row for row in rows if row["split"] == split]
        lines.append([split, *_list_figures(mine), _describe_requirement(split, mine)])
    return table(("split", *_COLUMNS, "required"), lines)


def _describe_requirement(split: str, rows: Rows) -> str:
    if split not in REQUIRED:
        return ""
    least, most = REQUIRED[split]
    met = is_met(split, Counter({name: _sum(rows, name) for name in OUTCOMES}))
    return f"right {least:.0%}, silently wrong {most:.0%}: {'met' if met else 'not met'}"


def _compare_authors(rows: Rows) -> str:
    """A line for each author of the splits that have a requirement."""
    lines: dict[str, Rows] = {}
    for row in rows:
        if row["split"] in REQUIRED:
            lines.setdefault(f"{row['author']}, {row['split']}", []).append(row)
    return table(("author", *_COLUMNS), ([name, *_list_figures(mine)] for name, mine in lines.items()))


def _list_figures(rows: Rows) -> list[str]:
    """Cells of `_COLUMNS`."""
    count, fields = _sum(rows, "sentences"), _sum(rows, "fields")
    wrong = sum(sum(row["wrong"].values()) for row in rows)
    shares = (_sum(rows, name) / max(count, 1) for name in (*OUTCOMES, "ignored"))
    return [str(count), f"{1 - wrong / max(fields, 1):.1%}", *(f"{share:.1%}" for share in shares)]


def _compare_groups(rows: Rows) -> str:
    """Counts of the groups with the most development sentences that are silently wrong."""
    groups: dict[str, Rows] = {}
    for row in rows:
        if row["split"] == "development":
            groups.setdefault(row["group"], []).append(row)
    worst = sorted(groups, key=lambda name: -_sum(groups[name], "silently wrong"))[:_WORST]
    columns = ("sentences", *OUTCOMES)
    return table(
        ("group", *columns), ([name, *(_sum(groups[name], key) for key in columns)] for name in worst)
    )


def _list_fields(rows: Rows) -> str:
    """Counts of wrong fields, of all sentences of a split."""
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
        "physagent_jax/motion",
        *(f"benchmarks/language/{name}" for name in ("corpus", "notation.py", "score.py", "totals.py")),
    ),
    condense,
)
