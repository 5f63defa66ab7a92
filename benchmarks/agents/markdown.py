"""Tables of docs/agents.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from benchmarks.harness import Page, Result, Tables, provenance, table

PARTS = ("adversarial",)
_ENDINGS = ("answered", "refused", "failed")


def write_tables(result: Result) -> Tables:
    """The tables of docs/agents.md."""
    rows = result["adversarial"]["rows"] if "adversarial" in result else []
    tables = {"adversarial": write_adversarial(rows)} if rows else {}
    return {**tables, "runs": provenance(result, PARTS)}


def write_adversarial(rows: Sequence[Mapping]) -> str:
    """Endings of adversarial replies: in sum, and by kind."""
    kinds: dict[str, list[Mapping]] = {}
    for row in rows:
        kinds.setdefault(row["kind"], []).append(row)
    good = sum(row["good"] for row in rows)
    head = f"{len(rows)} replies of {len(kinds)} kinds; {good} of them end as they have to, and leave nothing behind.\n"
    sums = Counter(row["ending"] for row in rows)
    lines = [[name, *_describe(group)] for name, group in kinds.items()]
    return (
        head
        + table(("", *_ENDINGS), [["replies", *(sums[ending] for ending in _ENDINGS)]])
        + table(("kind", *_ENDINGS, "requests", "seconds at most"), lines)
    )


def _describe(rows: Sequence[Mapping]) -> list:
    endings = Counter(row["ending"] for row in rows)
    attempts = sorted({row["attempts"] for row in rows})
    requests = f"{attempts[0]}" if len(attempts) == 1 else f"{attempts[0]} to {attempts[-1]}"
    return [
        *(endings[each] or "" for each in _ENDINGS),
        requests,
        f"{max(row['seconds'] for row in rows):.2f}",
    ]


PAGE = Page(
    "agents",
    "python -m benchmarks.agents",
    write_tables,
    ("physagent_jax/agents/llm", "benchmarks/agents"),
)
