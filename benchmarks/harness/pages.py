"""Pages with places for tables: people write the text, and what stands between two marks is made of the rows.

A place is ``<!-- table: NAME -->`` and ``<!-- end -->`` on lines of their own; what lies between is replaced.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from physagent_jax.core.errors import UserError

Rows = list[dict[str, Any]]
Result = dict[str, Any]
Tables = Mapping[str, str]
RAW = Path("benchmarks/raw")
_PLACE = re.compile(r"(<!-- table: (?P<name>[^>]+?) -->\n)(?P<held>.*?)(<!-- end -->)", re.DOTALL)


def fill_places(text: str, tables: Tables) -> str:
    """A page's text with each table in its place; the place of a table that there is not is left empty.

    Raises:
        UserError: A table has no place.
    """
    places = {found["name"] for found in _PLACE.finditer(text)}
    if lost := [name for name in tables if name not in places]:
        marks = ", ".join(f"`<!-- table: {name} -->`" for name in lost)
        raise UserError("a page has no place for a table", got=marks, do="Add the mark, and `<!-- end -->`")
    return _PLACE.sub(lambda found: _mark(found["name"], tables.get(found["name"], "")), text)


def fill_pages(pages: Sequence[Path], tables: Tables) -> dict[Path, str]:
    """The texts of pages with each table in its places; where there is no page, the first is of places alone.

    Raises:
        UserError: A table has no place in any of them.
    """
    texts = {page: page.read_text() for page in pages if page.is_file()}
    if not texts:
        return {pages[0]: "\n\n".join(_mark(name, text) for name, text in tables.items()) + "\n"}
    fill_places("".join(texts.values()), tables)
    held = {page: {found["name"] for found in _PLACE.finditer(text)} for page, text in texts.items()}
    return {
        page: fill_places(text, {name: tables[name] for name in tables if name in held[page]})
        for page, text in texts.items()
    }


def empty_place(text: str, name: str) -> str:
    """A page's text with nothing in the place of this name."""
    return _PLACE.sub(lambda found: _mark(name, "") if found["name"] == name else found[0], text)


def _mark(name: str, text: str) -> str:
    held = text.strip("\n")
    return (
        f"<!-- table: {name} -->\n{held}\n<!-- end -->" if held else f"<!-- table: {name} -->\n<!-- end -->"
    )


@dataclasses.dataclass(frozen=True)
class Page:
    """A benchmark's page and files.

    Attributes:
        name: Name of the page, ``docs/NAME.md``, of the summary, ``benchmarks/results/NAME.json``, and of the raw
            rows, ``benchmarks/raw/NAME.json``.
        command: Command that measures the rows again.
        tables: Maker of the tables from a summary, each with the name of its place.
        sources: Files and folders of this repository that the figures depend on.
        condense: Maker of the summary from all rows; without it the rows are the summary.
        rename: Maker of rows with the names of today from those that history has; it goes when they are measured again.
        details: Name of a second page, ``docs/DETAILS.md``, for tables that have no place on the first; "" = none.
    """

    name: str
    command: str
    tables: Callable[[Result], Tables]
    sources: tuple[str, ...] = ()
    condense: Callable[[Result], Result] = dict
    rename: Callable[[Result], Result] = dict
    details: str = ""

    def list_docs(self, folder: Path) -> list[Path]:
        """The files of the page and of its details."""
        return [folder / f"{name}.md" for name in (self.name, self.details) if name]

    @property
    def raw(self) -> Path:
        """The file of the raw rows, as a command writes it that is started in the repository."""
        return RAW / f"{self.name}.json"


def drop_fields(result: Result, left_out: Collection[str]) -> Result:
    """The sections with rows that lack these fields."""
    return {
        part: section
        | {"rows": [{k: v for k, v in row.items() if k not in left_out} for row in section["rows"]]}
        for part, section in result.items()
    }


def read_runs(section: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The runs that rows of a section come from; a summary whose rows name no run keeps those alone."""
    used = {row["run"] for row in section["rows"] if "run" in row}
    return [run for index, run in enumerate(section["runs"]) if not used or index in used]


def count_rows(section: Mapping[str, Any]) -> int:
    """The number of rows that were measured, which a summary may have counted."""
    return section.get("measured", len(section["rows"]))


def condense_section(section: Mapping[str, Any], rows: Rows) -> dict[str, Any]:
    """A section of other rows, which are made of its own."""
    return {
        "runs": read_runs(section),
        "complete": section["complete"],
        "measured": count_rows(section),
        "rows": rows,
    }


def make_lines(tables: Tables) -> Rows:
    """A row for each line of tables, for a summary of rows that are too many to keep."""
    return [
        {"table": name, "line": line}
        for name, text in tables.items()
        for line in text.strip("\n").splitlines()
    ]


def read_lines(summary: Result) -> Tables:
    """The tables that `make_lines` has taken apart."""
    tables: dict[str, list[str]] = {}
    for section in summary.values():
        for row in section["rows"]:
            tables.setdefault(row["table"], []).append(row["line"])
    return {name: "\n".join(lines) for name, lines in tables.items()}
