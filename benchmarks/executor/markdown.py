"""Tables of docs/executor.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.harness import Page, Result, Tables, number, one_line, provenance, table

_REWRITES = (0, 1, 2, 3)


def write_tables(result: Result) -> Tables:
    """The tables of docs/executor.md."""
    parts = ("starts", "kinds", "rescues")
    starts, kinds, rescues = (result.get(part, {}).get("rows", []) for part in parts)
    tables = {"runs": provenance(result, parts)}
    if starts:
        tables |= _write_starts(starts)
    if kinds:
        tables["kinds"] = _write_kinds(kinds)
    if rescues:
        tables["rescues"] = _write_rescues(rescues)
    return tables


def _format_share(rows: Sequence[Mapping], rewrites: int) -> str:
    done = sum(r["rewrites_to_success"] is not None and r["rewrites_to_success"] <= rewrites for r in rows)
    return f"{done} of {len(rows)} ({100 * done / len(rows):.0f}%)"


def _write_starts(rows: Sequence[Mapping]) -> Tables:
    wrong = [r for r in rows if r["rewrites_to_success"] != 0]
    harmless = len(rows) - len(wrong)
    head = [f"{k} rewrite{'s' * (k != 1)}" for k in _REWRITES[1:]]
    every = ["all", *(_format_share(wrong, k) for k in _REWRITES[1:])]
    by = {
        key: [[name, *(_format_share(group, k) for k in _REWRITES[1:])] for name, group in _group(wrong, key)]
        for key in ("fault", "sentence")
    }
    never = [
        [
            r["sentence"],
            r["fault"],
            ", ".join(number(score) for score in r["scores"]),
            one_line("; ".join(r["failed"][_find_best(r["scores"])])),
            one_line(" ".join(next((c for c in reversed(r["changes"]) if c), []))),
        ]
        for r in rows
        if r["rewrites_to_success"] is None and r["scores"]
    ]
    worse = sum(any(b < a for a, b in zip(r["scores"], r["scores"][1:])) for r in rows)
    return {
        "starts": f"{len(rows)} force fields for sentences over several objects, each spoilt in one way. "
        f"{harmless} of them\nstill gave a motion that passes. Of the others, so many are right after\n"
        + table(["faults", *head], [every, *by["fault"]])
        + table(["sentence", *head], by["sentence"]),
        "never": table(
            ["sentence", "fault", "scores", "what was missing in the best round", "what was tried last"],
            never,
        )
        + f"\nIn {worse} of {len(rows)} runs a rewrite scored below the round before. The next one then goes out "
        "from the\nbest round, and the best round is the result.\n",
    }


def _find_best(scores: Sequence[float]) -> int:
    return max(range(len(scores)), key=lambda i: scores[i] or 0.0)


def _group(rows: Sequence[Mapping], key: str) -> list[tuple[str, list[Mapping]]]:
    names = list(dict.fromkeys(r[key] for r in rows))
    return [(name, [r for r in rows if r[key] == name]) for name in names]


def _write_kinds(rows: Sequence[Mapping]) -> str:
    return table(
        ["effect", "object", "kind", "asked for", "achieved", "", "drift", "turn", "J"],
        [
            [
                r["effect"], r["object"], r["kind"], number(r["asked"]), number(r["achieved"]), r["unit"],
                number(r["drift"]), number(r["turn"]), f"{r['min_J']:.2f} to {r['max_J']:.2f}",
            ]
            for r in rows
        ],
    )  # fmt: skip


def _write_rescues(rows: Sequence[Mapping]) -> str:
    failed = [r for r in rows if r["rewrites_to_success"] != 0]
    rescued = [r for r in failed if r["rewrites_to_success"] is not None]
    head = f"Of {len(rows)} sentences {len(failed)} fail in round 1; of these {len(rescued)} are right by round 3.\n"
    at = [r["rewrites_to_success"] for r in rows]
    return head + table(
        ["object", "sentence", "right in round", "scores", "why round 1 fails", "what was tried last"],
        [
            [
                r["object"], r["sentence"], "never" if k is None else str(k + 1),
                ", ".join(number(score) for score in r["scores"]), one_line(r["why"][0]),
                one_line(" ".join(r["changes"][-1] if r["changes"] else [])),
            ]
            for r, k in zip(rows, at)
        ],
    )  # fmt: skip


PAGE = Page(
    "executor",
    "python -m benchmarks.executor",
    write_tables,
    ("physagent_jax/agents", "physagent_jax/motion", "physagent_jax/mpm"),
)
