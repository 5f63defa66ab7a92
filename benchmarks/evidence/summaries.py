"""Summaries: what is kept of raw rows, with where these come from.

A summary is ``{"raw": {part: file}, "code": {...}, "parts": {part: section}}``. A file of raw rows is known by its size
and its sha256. The code is the newest revision of the oldest part, with its date and the hashes of the page's sources;
None where no revision is recorded. Sections are like those of raw rows, with rows that the tables are made of.
"""

from __future__ import annotations

import copy
import hashlib
import json
from pathlib import Path
from typing import Any

from benchmarks.harness import Page, Result
from benchmarks.harness.command import format_result
from benchmarks.harness.sources import (
    find_newest,
    find_oldest,
    hash_sources,
    is_checkout,
    is_known,
    read_date,
    read_object,
)
from physagent_jax.core.errors import UserError

Summary = dict[str, Any]


def summarise(
    page: Page, raw: Path, recorded: Summary | None = None, *, allow_unkept: bool = False
) -> Summary:
    """The summary of raw rows; parts that these have not are taken from the one that is recorded.

    Args:
        page: The page that the rows are for.
        raw: File of the raw rows.
        recorded: Summary of earlier rows.
        allow_unkept: Take rows of revisions that the repository does not have, without their names.

    Raises:
        UserError: There are no rows, or some that are not to be quoted: quick ones, of a part that is not whole where
            the recorded one is, or of code that was not committed.
    """
    if not raw.is_file():
        raise UserError("there are no raw rows", got=raw, do=f"Measure them: `{page.command}`")
    content = raw.read_bytes()
    result: Result = json.loads(content)
    raw_rows = {part: section["rows"] for part, section in json.loads(content).items()}
    earlier: Result = dict(recorded["parts"]) if recorded else {}
    for part, section in result.items():
        known = earlier.get(part)
        if not section["complete"] and known is not None and known["complete"]:
            raise UserError(f"part {part} of {raw} is not whole", do="Measure the rest with --resume")
        if any(run["quick"] for run in section["runs"]):
            raise UserError(f"part {part} of {raw} has quick rows", do="Measure it without --quick")
    for section in result.values():
        _drop_idle_runs(section)
    _settle_revisions(result, allow_unkept)
    parts = earlier | page.condense(copy.deepcopy(result))
    revision = find_oldest(
        newest for part in parts if (newest := find_newest(list_revisions({part: parts[part]})))
    )  # a part that is measured anew makes the others no newer
    file = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    known = recorded["raw"] if recorded else {}
    return {
        "raw": known | dict.fromkeys(result, file) | _find_unchanged(page, known, raw_rows),
        "code": describe_code(page, revision) if revision else None,
        "parts": parts,
    }


def describe_code(page: Page, revision: str) -> dict[str, Any]:
    """A revision with its date and the hashes of the sources that a page depends on."""
    return {
        "revision": revision,
        "date": read_date(revision),
        "hashes": hash_sources(page.sources, revision),
    }


def restore(page: Page, summary: Summary) -> Result:
    """The raw rows that the repository's history has, checked against their hashes, by the names of today.

    Raises:
        UserError: It has none.
    """
    found: Result = {}
    for part, file in summary["raw"].items():
        if "history" in file and "sha256" in file:
            content = read_object(file["history"])
            if hashlib.sha256(content).hexdigest() != file["sha256"]:
                raise UserError(f"raw rows of {part} are not those that were summarised", got=file["history"])
            found[part] = json.loads(content)[part]
    if not found:
        raise UserError("history has no raw rows of these figures", do="Measure them again")
    return page.rename(found)


def list_revisions(parts: Result) -> set[str]:
    """The revisions that a summary's runs name."""
    return {
        run["git_revision"] for section in parts.values() for run in section["runs"] if run["git_revision"]
    }


def read_summary(path: Path) -> Summary:
    """A summary."""
    return json.loads(path.read_text())


def format_summary(summary: Summary) -> str:
    """JSON with a line for each run and each row."""
    facts = [f"{json.dumps(name)}: {json.dumps(summary[name])}" for name in ("raw", "code")]
    return "{\n" + ",\n".join(facts) + ',\n"parts": ' + format_result(summary["parts"]) + "\n}\n"


def _find_unchanged(page: Page, known: dict[str, Any], rows: Result) -> dict[str, Any]:
    """The recorded files of the parts whose rows are still those that history has."""
    kept = {part: file for part, file in known.items() if "history" in file and part in rows}
    if not kept or not is_checkout():
        return {}
    there = restore(page, {"raw": kept})
    return {part: file for part, file in kept.items() if there[part]["rows"] == rows[part]}


def _drop_idle_runs(section: dict[str, Any]) -> None:
    """Take out runs whose rows have all been measured again."""
    used = sorted({row["run"] for row in section["rows"]})
    section["runs"] = [section["runs"][index] for index in used]
    section["rows"] = [row | {"run": used.index(row["run"])} for row in section["rows"]]


def _settle_revisions(result: Result, allow_unkept: bool) -> None:
    """Take the names of revisions off that nobody can look up, or refuse them."""
    for part, section in result.items():
        for run in section["runs"]:
            revision = run["git_revision"]
            if revision is None or is_known(revision):
                continue
            if not allow_unkept:
                raise UserError(
                    f"part {part} was measured on a revision that cannot be looked up",
                    got=revision,
                    do="Commit and measure again, or give --allow-unkept: the page then says that it is not recorded",
                )
            run["git_revision"] = None
