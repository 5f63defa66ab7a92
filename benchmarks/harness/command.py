"""Options of a benchmark, and the work that they ask for."""

from __future__ import annotations

import dataclasses
import difflib
import json
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks.harness.machine import circumstances
from benchmarks.harness.pages import Page, Result, fill_pages
from benchmarks.harness.workers import call_all
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.run.lock import FolderLock

Row = dict[str, Any]
console = Console(stderr=True)
_NAMES_TOLD = 5  # of jobs, to who names none of them


@dataclasses.dataclass(frozen=True)
class Command:
    """Options that every benchmark has; each adds its ``parts``, which it measures."""

    json: Path
    """File of the raw rows; those of other parts are kept."""
    markdown: Path | None = None
    """Also fill the places for tables of this page."""
    parts: tuple[str, ...] = ()
    """Parts to measure; none = only write the tables."""
    only: tuple[str, ...] = ()
    """Only jobs with one of these in their names; the other rows are kept."""
    quick: bool = False
    """A few minutes' look at small sizes: no figure to quote."""
    resume: bool = False
    """Go on where a run was stopped: jobs whose rows the file has are not done again."""


@dataclasses.dataclass(frozen=True)
class Job:
    """Measurement that is done whole or not at all.

    Attributes:
        name: Unique in its part.
        measure: Does it, and returns its rows.
        group: Name of the jobs that compile the same programs; "" = none.
    """

    name: str
    measure: Callable[[], Iterable[Row]]
    group: str = ""


def main(
    command: Command,
    parts: Mapping[str, Callable[[], Iterable[Job]]],
    page: Page,
    about: Mapping[str, Any] | None = None,
    workers: int = 1,
    prepare: Callable[[], object] | None = None,
) -> int:
    """Measures what ``command`` asks for, writes the rows after every job, and then the tables.

    `benchmarks.evidence` makes of the rows the summary that is kept, and the page.

    Args:
        command: The options.
        parts: The jobs of each part; a part that is not asked for is not called.
        page: Maker of the tables, for ``command.markdown``.
        about: More to note of this run, beside `circumstances`.
        workers: As for `call_all`.
        prepare: As for `call_all`.

    Returns:
        The exit code: 1 if a row that was measured says ``"good": False``, 2 if there is no such part or job, or
        another command writes the same file.
    """
    try:  # the file itself is replaced after every job
        lock = FolderLock(command.json.with_name(f"{command.json.name}.lock"))
    except UserError as error:
        say(f"rows cannot be kept in {command.json}: {error.what}. Wait, or choose another --json")
        return 2
    try:
        noted = {**(about or {}), **({"workers": workers} if workers > 1 else {})}
        call = partial(call_all, workers=workers, prepare=prepare)
        return _measure(command, parts, page, noted, call)
    finally:
        lock.release()


def say(text: str) -> None:
    """Tell a person what goes on; what goes to standard output is for programs."""
    console.print(text, highlight=False, markup=False, soft_wrap=True)


def _measure(
    command: Command,
    parts: Mapping[str, Callable[[], Iterable[Job]]],
    page: Page,
    about: Mapping[str, Any],
    call: Callable,
) -> int:
    """`main`, of a file that no other command writes."""
    content = json.loads(command.json.read_text()) if command.json.is_file() else {}
    result = {part: section for part, section in content.items() if part in parts}
    missing = [part for part in command.parts if part not in parts]
    if missing:
        say(f"there is no part {', '.join(missing)}; there are: {', '.join(parts)}")
        return 2
    plan = {part: list(parts[part]()) for part in command.parts}
    names = [job.name for jobs in plan.values() for job in jobs]
    unknown = [word for word in command.only if not any(word in name for name in names)]
    for word in unknown:
        nearest = difflib.get_close_matches(word, names, n=_NAMES_TOLD, cutoff=0.0)
        say(f"none of {len(names)} jobs has {word!r} in its name; the nearest are: {'; '.join(nearest)}")
    if unknown:
        return 2
    wanted = {part: jobs for part, jobs in plan.items() if any(_is_wanted(job, command) for job in jobs)}
    bad = sum(_do_jobs(command, part, jobs, result, about, call) for part, jobs in wanted.items())
    if command.markdown is not None:
        docs = [command.markdown, *page.list_docs(command.markdown.parent)[1:]]
        for path, text in fill_pages(docs, page.tables(page.condense(result))).items():
            write_text(path, text)
    if plan:
        say(f"{bad} row(s) fail" if bad else "no row fails")
    print(command.json)
    return 1 if bad else 0


def _do_jobs(
    command: Command, part: str, jobs: list[Job], result: Result, about: Mapping, measure: Callable
) -> int:
    """Do a part's jobs; return how many rows fail."""
    run = {**circumstances(), "quick": command.quick, "seconds": 0.0, **about}
    section = result[part] = _open_section(result.get(part), command)
    order = {job.name: place for place, job in enumerate(jobs)}
    done = {row["job"] for row in section["rows"]} if command.resume else set()
    wanted = [job for job in jobs if _is_wanted(job, command) and job.name not in done]
    bad, begun = 0, time.perf_counter()
    console.rule(part)
    groups = [job.group or job.name for job in wanted]
    for place, rows in measure([job.measure for job in wanted], groups=groups):
        if not any(known is run for known in section["runs"]):
            section["runs"].append(run)
        name = wanted[place].name
        rows = [{"run": len(section["runs"]) - 1, "job": name} | row for row in rows]
        bad += sum(not row.get("good", True) for row in rows)
        run["seconds"] = round(time.perf_counter() - begun, 1)
        kept = [row for row in section["rows"] if row["job"] != name]
        section["rows"] = sorted(kept + rows, key=lambda row: order.get(row["job"], -1))
        section["complete"] = order.keys() <= {row["job"] for row in section["rows"]}
        write_text(command.json, format_result(result) + "\n")
    return bad


def format_result(result: Mapping[str, Mapping[str, Any]]) -> str:
    """JSON with a line for each run and each row, so that a change of one is a change of one line."""
    return _join(
        (f"{json.dumps(part)}: {_format_section(section)}" for part, section in result.items()), "{}"
    )


def _format_section(section: Mapping[str, Any]) -> str:
    fields = (
        (key, _join(map(json.dumps, value), "[]") if isinstance(value, list) else json.dumps(value))
        for key, value in section.items()
    )
    return _join((f"{json.dumps(key)}: {value}" for key, value in fields), "{}")


def _join(items: Iterable[str], brackets: str) -> str:
    return f"{brackets[0]}\n" + ",\n".join(items) + f"\n{brackets[1]}"


def _is_wanted(job: Job, command: Command) -> bool:
    return not command.only or any(word in job.name for word in command.only)


def _open_section(section: dict | None, command: Command) -> dict:
    """A new section, or the one that rows are added to: quick rows and others do not mix."""
    keeps = command.resume or command.only
    if section is None or not keeps or any(run["quick"] != command.quick for run in section["runs"]):
        return {"runs": [], "complete": False, "rows": []}
    return section
