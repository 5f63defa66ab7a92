"""Tables of docs/parts.md."""

from __future__ import annotations

from benchmarks.harness import Page, Result, Rows, Tables, provenance, table


def write_tables(result: Result) -> Tables:
    """The tables of docs/parts.md; a part of the rows is a half of the objects."""
    sections = {half: section["rows"] for half, section in result.items()}
    return {
        "runs": provenance(result, tuple(result)),
        "totals": _summarise(sections),
        "each": _list_each(sections),
    }


def _summarise(sections: dict[str, Rows]) -> str:
    columns = ("half", "form", "parts", "right", "wrong", "asked for", "right of those marked unsure")
    lines = []
    for half, rows in sections.items():
        for form in dict.fromkeys(row["form"] for row in rows):
            own = [row for row in rows if row["form"] == form]
            counts = {key: sum(r["outcome"] == key for r in own) for key in ("right", "wrong", "asked for")}
            unsure = [row["outcome"] == "right" for row in own if row["unsure"]]
            shares = [f"{100 * count / len(own):.0f} % ({count})" for count in counts.values()]
            lines.append([half, form, len(own), *shares, f"{sum(unsure)} of {len(unsure)}"])
    return table(columns, lines)


def _list_each(sections: dict[str, Rows]) -> str:
    columns = ("object", "half", "part", "as a mesh", "as a capture")
    lines = []
    for half, rows in sections.items():
        for name, word in dict.fromkeys((row["job"], row["word"]) for row in rows):
            own = {row["form"]: row for row in rows if (row["job"], row["word"]) == (name, word)}
            lines.append([name, half, word, *(f"{r['outcome']} ({r['overlap']:.2f})" for r in own.values())])
    return table(columns, lines)


PAGE = Page(
    "parts",
    "python -m benchmarks.parts --data DIR",
    write_tables,
    ("physagent_jax/scene/parts", "physagent_jax/run/resolve.py", "physagent_jax/scene/body.py"),
)
