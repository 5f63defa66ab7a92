"""Tables of docs/agents.md."""

from __future__ import annotations

from benchmarks.agents.judging import condense_judging, write_judging
from benchmarks.agents.reading import condense_reading, write_reading
from benchmarks.harness import Page, Result, Rows, Tables, condense_section, provenance, table

PARTS = ("adversarial", "reading", "judging")
_ENDINGS = ("answered", "refused", "failed")


def condense(result: Result) -> Result:
    """Counts of replies, of what was read, and of what was judged."""
    counts = {
        "adversarial": condense_adversarial,
        "reading": condense_reading,
        "judging": condense_judging,
    }
    return {
        part: condense_section(section, counts[part](section["rows"])) for part, section in result.items()
    }


def write_tables(result: Result) -> Tables:
    """The tables of docs/agents.md."""
    writers = {"adversarial": write_adversarial, "reading": write_reading, "judging": write_judging}
    tables = {part: write(result[part]["rows"]) for part, write in writers.items() if part in result}
    return {**tables, "runs": provenance(result, [part for part in PARTS if part in result])}


def condense_adversarial(rows: Rows) -> Rows:
    """Endings of adversarial replies by kind."""
    kinds: dict[str, Rows] = {}
    for row in rows:
        kinds.setdefault(row["kind"], []).append(row)
    return [
        {
            "kind": kind,
            "replies": len(mine),
            "good": sum(row["good"] for row in mine),
            **{ending: sum(row["ending"] == ending for row in mine) for ending in _ENDINGS},
            "attempts": [min(row["attempts"] for row in mine), max(row["attempts"] for row in mine)],
            "seconds": round(max(row["seconds"] for row in mine), 2),
        }
        for kind, mine in kinds.items()
    ]


def write_adversarial(kinds: Rows) -> str:
    """Endings of adversarial replies, with the kinds that end so."""
    replies, good = (sum(row[name] for row in kinds) for name in ("replies", "good"))
    head = f"{replies} replies of {len(kinds)} kinds; {good} of them end as they have to, and leave nothing behind.\n\n"
    rows = [
        [ending, sum(row[ending] for row in kinds), ", ".join(row["kind"] for row in kinds if row[ending])]
        for ending in _ENDINGS
    ]
    return head + table(("ending", "replies", "kinds of replies"), rows)


PAGE = Page(
    "agents",
    "python -m benchmarks.agents",
    write_tables,
    ("physagent_jax/agents/llm", "physagent_jax/chat", "benchmarks/agents"),
    condense=condense,
)
