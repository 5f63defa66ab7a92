"""The page's recurring shapes: sections, tables, facts, badges."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence

from pydantic import BaseModel

from physagent_jax.motion.schema import Verdict
from physagent_jax.report.markup import Child, Markup, div, span, tag


def make_section(id_: str, title: str, *children: Child, lead: str = "") -> Markup:
    """A titled part of the page."""
    intro = tag("p", lead, class_="lead") if lead else None
    return tag("section", tag("h2", title), intro, *children, id=id_)


def make_table(
    head: Sequence[str],
    rows: Iterable[Sequence[Child]],
    *,
    ids: Sequence[str] | None = None,
    class_: str = "",
    numeric: Sequence[int] = (),
) -> Markup:
    """A table that turns into a list of cards on narrow screens (the cells carry their headings).

    Args:
        head: Column headings.
        rows: Cells.
        ids: An id per row.
        class_: Extra classes.
        numeric: Columns that are set to the right.
    """

    def cell(name: str, column: int, heading: str, content: Child) -> Markup:
        class_name = "numeric" if column in numeric else None
        return tag(name, content, class_=class_name, data_label=heading or None)

    header = tag("tr", [cell("th", i, "", h) for i, h in enumerate(head)])
    body = [
        tag(
            "tr", [cell("td", i, h, c) for i, (h, c) in enumerate(zip(head, row))], id=ids[n] if ids else None
        )
        for n, row in enumerate(rows)
    ]
    return div("table", tag("table", tag("thead", header), tag("tbody", body), class_=class_ or None))


def make_facts(rows: Iterable[tuple[str, Child] | None]) -> Markup:
    """Names and values; None rows are skipped."""
    return tag(
        "dl", [(tag("dt", row[0]), tag("dd", row[1])) for row in rows if row is not None], class_="facts"
    )


def make_list(title: str, items: Sequence[Child]) -> Markup | None:
    """A titled list; None if it would be empty."""
    if not items:
        return None
    return div("listing", tag("h3", title), tag("ul", [tag("li", item) for item in items]))


def make_badge(verdict: str | None) -> Markup:
    """A verdict as a coloured label."""
    kinds = {Verdict.SUCCESS.value: "success", Verdict.FAIL.value: "fail"}
    return span(f"badge {kinds.get(verdict or '', 'open')}", verdict or "not judged")


def note_missing(text: str) -> Markup:
    """Says that something which belongs here is not there."""
    return tag("p", text, class_="missing")


def make_fold(title: Child, *children: Child, open_: bool = False) -> Markup:
    """Content behind a fold."""
    return tag("details", tag("summary", title), *children, open=open_)


def make_json_fold(title: str, model: BaseModel) -> Markup:
    """A schema object as JSON behind a fold, short lists on one line."""
    text = json.dumps(model.model_dump(mode="json", exclude_none=True), indent=2, ensure_ascii=False)
    text = re.sub(r"\[\n([^\[\]{}]*?)\n\s*\]", _put_on_one_line, text)
    return tag("details", tag("summary", title), tag("pre", tag("code", text)), class_="json")


def _put_on_one_line(match: re.Match[str]) -> str:
    return "[" + re.sub(r"\n\s*", " ", match[1].strip()) + "]"


def make_paragraphs(text: str, class_: str = "") -> list[Markup]:
    """Text as paragraphs, one per non-empty line."""
    return [tag("p", line.strip(), class_=class_ or None) for line in text.splitlines() if line.strip()]
