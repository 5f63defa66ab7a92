"""`python -m benchmarks.evidence [NAME ...]`: which pages rest on code that has changed since it was measured.

``--summarise`` makes summaries of raw rows first, ``--fill`` the tables of the pages, ``--check`` fails where a page is
not what its summary gives. ``--restore`` writes raw rows that history still has.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from typing import Annotated

import tyro

from benchmarks import harness
from benchmarks.evidence.catalogue import DOCS, PAGES, RESULTS, ROOT
from benchmarks.evidence.summaries import (
    Summary,
    format_summary,
    read_summary,
    restore,
    summarise,
)
from benchmarks.harness import Page, Tables, table
from benchmarks.harness.command import format_result
from benchmarks.harness.pages import empty_place, fill_pages
from benchmarks.harness.sources import hash_sources
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text

STATE = "state"
"""Name of the place that says what a page was measured on: it changes with the code."""


@dataclasses.dataclass(frozen=True)
class Command:
    """List the pages whose code has changed, with the commands that measure them again."""

    names: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    """Pages; none = all."""
    summarise: bool = False
    """Make the named summaries of raw rows."""
    allow_unkept: bool = False
    """With `--summarise`: take rows of revisions that are not in the repository; the page says so."""
    restore: bool = False
    """Write the raw rows that the repository's history has, so that `--resume` and `--only` can go on with them."""
    fill: bool = False
    """Fill the tables of the pages."""
    check: bool = False
    """Fail where a page is not what its summary gives."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line."""
    command = tyro.cli(Command, args=arguments)
    try:
        pages = choose_pages(command.names)
        if (command.summarise or command.restore) and not command.names:
            raise UserError("`--summarise` and `--restore` need names", do=f"There are: {', '.join(PAGES)}")
        for page in pages if command.restore else ():
            _restore(page)
        for page in pages if command.summarise else ():
            _summarise(page, command.allow_unkept)
        for page in pages if command.fill else ():
            for path, text in fill_pages(page.list_docs(DOCS), write_tables(page)).items():
                write_text(path, text)
        print(list_stale(pages))
        differing = find_differing(pages) if command.check else []
    except UserError as error:
        print(f"evidence: {error}", file=sys.stderr)
        return 2
    for name in differing:
        harness.say(
            f"docs/{name}.md is not what its summary gives: `python -m benchmarks.evidence {name} --fill`"
        )
    return 1 if differing else 0


def choose_pages(names: Sequence[str]) -> list[Page]:
    """The pages of these names; all without any.

    Raises:
        UserError: There is no such page.
    """
    if unknown := [name for name in names if name not in PAGES]:
        raise UserError("no such page", got=", ".join(unknown), do=f"There are: {', '.join(PAGES)}")
    return [PAGES[name] for name in names or PAGES]


def write_tables(page: Page) -> Tables:
    """The tables of a page, and its state, of its summary alone."""
    summary = read_summary(RESULTS / f"{page.name}.json")
    return {**page.tables(summary["parts"]), STATE: describe_state(page, summary)}


def describe_state(page: Page, summary: Summary) -> str:
    """A line for the head of a page: where its figures are, and what has changed since."""
    name = f"{page.name}.json"
    text = f"*Figures: [{name}](../benchmarks/results/{name}), by `{page.command.split(' --')[0]}`. "
    code = summary["code"]
    if code is None:
        return text + "The revision that they were measured on is not recorded.*"
    text += f"Oldest part of {code['date']}, revision {code['revision']}; "
    if changed := find_changed(page, summary):
        return text + f"code has changed since: {', '.join(f'`{source}`' for source in changed)}.*"
    return text + "the code that they depend on has not changed since.*"


def find_changed(page: Page, summary: Summary) -> list[str]:
    """The sources that are not as they were at the newest revision of the figures."""
    now, then = hash_sources(page.sources), summary["code"]["hashes"]
    return [source for source in page.sources if now[source] != then.get(source)]


def find_differing(pages: Sequence[Page]) -> list[str]:
    """The names of pages whose tables, the state apart, are not what their summaries give."""
    differing = []
    for page in pages:
        tables = page.tables(read_summary(RESULTS / f"{page.name}.json")["parts"])
        for path, text in fill_pages(page.list_docs(DOCS), {**tables, STATE: ""}).items():
            if empty_place(path.read_text(), STATE) != empty_place(text, STATE):
                differing.append(path.stem)
    return differing


def list_stale(pages: Sequence[Page]) -> str:
    """A table of the pages whose code has changed or is not known: what changed, the command, and its minutes."""
    lines = []
    for page in pages:
        summary = read_summary(RESULTS / f"{page.name}.json")
        known = summary["code"] is not None
        changed = ", ".join(find_changed(page, summary)) if known else "revision not recorded"
        if changed:
            lines.append([page.name, changed, f"`{page.command}`", describe_minutes(summary)])
    head = f"{len(lines)} of {len(pages)} pages rest on code that has changed since, or is not recorded.\n"
    after = "\nThen `python -m benchmarks.evidence PAGE --summarise --fill` makes the summary and the page.\n"
    return head + (table(("page", "changed", "again by", "minutes"), lines) + after if lines else "")


def describe_minutes(summary: Summary) -> str:
    """The minutes that measuring took, at least where some runs have not told."""
    runs = [run for section in summary["parts"].values() for run in section["runs"]]
    minutes = sum(run["seconds"] for run in runs) / 60
    return f"{minutes:.1f}" if all(run["seconds"] for run in runs) else f"more than {minutes:.1f}"


def _restore(page: Page) -> None:
    if (path := ROOT / page.raw).exists():
        raise UserError("there are raw rows already", got=page.raw, do="Move them away first")
    write_text(path, format_result(restore(page, read_summary(RESULTS / f"{page.name}.json"))) + "\n")


def _summarise(page: Page, allow_unkept: bool) -> None:
    path = RESULTS / f"{page.name}.json"
    recorded = read_summary(path) if path.is_file() else None
    write_text(path, format_summary(summarise(page, ROOT / page.raw, recorded, allow_unkept=allow_unkept)))


if __name__ == "__main__":
    sys.exit(main())
