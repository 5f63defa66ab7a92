"""docs/executor.md, made of the rows alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness import link, number, one_line, provenance, table

_REWRITES = (0, 1, 2, 3)


def document(result: Mapping[str, Any], source: Path, target: Path) -> str:
    """The whole document."""
    starts, kinds = (result.get(part, {}).get("rows", []) for part in ("starts", "kinds"))
    return "\n".join(
        [
            "# The executor, from wrong force fields",
            "",
            f"Made by `python -m benchmarks.executor` of [{source.name}]({link(source, target)}), whose rows may come "
            "from several runs and revisions: those listed at the end. Small scenes (5,000 particles, 64 cells a "
            "side); planner and executor read the particles' own motion, so that perception's errors play no part. "
            "A success is what the offline planner calls one. On the ground, objects stand as in a run: the robot, "
            "which cannot, is held in the air (until 2026-11-23 it fell over here, and 1 of its 5 starts was mended).",
            _write_starts(starts) if starts else "",
            _write_kinds(kinds) if kinds else "",
            "## Measured with",
            provenance(result, ("starts", "kinds")),
        ]
    )


def _format_share(rows: Sequence[Mapping], rewrites: int) -> str:
    done = sum(r["rewrites_to_success"] is not None and r["rewrites_to_success"] <= rewrites for r in rows)
    return f"{done} of {len(rows)} ({100 * done / len(rows):.0f} %)"


def _write_starts(rows: Sequence[Mapping]) -> str:
    wrong = [r for r in rows if r["rewrites_to_success"] != 0]
    harmless = [r for r in rows if r["rewrites_to_success"] == 0]
    lines = [
        "## Share that reaches a true success",
        "",
        f"{len(rows)} force fields for sentences over several objects, each spoilt in one way. {len(harmless)} of them "
        "still gave a motion that passes (too little spoilt); of the others, so many are right after",
        table(
            ["faults", *(f"{k} rewrite{'s' * (k != 1)}" for k in _REWRITES[1:])],
            [["all", *(_format_share(wrong, k) for k in _REWRITES[1:])]]
            + [
                [name, *(_format_share(group, k) for k in _REWRITES[1:])]
                for name, group in _group(wrong, "fault")
            ],
        ),
        table(
            ["sentence", *(f"{k} rewrite{'s' * (k != 1)}" for k in _REWRITES[1:])],
            [
                [name, *(_format_share(group, k) for k in _REWRITES[1:])]
                for name, group in _group(wrong, "sentence")
            ],
        ),
        "## Those that never became right",
        table(
            ["sentence", "fault", "scores", "what was missing in the best round", "what was tried last"],
            [
                [
                    r["sentence"],
                    r["fault"],
                    ", ".join(number(score) for score in r["scores"]),
                    one_line("; ".join(r["failed"][_find_best(r["scores"])])),
                    one_line(" ".join(next((c for c in reversed(r["changes"]) if c), []))),
                ]
                for r in rows
                if r["rewrites_to_success"] is None and r["scores"]
            ],
        ),
    ]
    worse = sum(any(b < a for a, b in zip(r["scores"], r["scores"][1:])) for r in rows)
    lines.append(
        f"In {worse} of {len(rows)} runs a rewrite scored below the round before; the next one then goes out from the "
        "best round, and the best round is the result.\n"
    )
    return "\n".join(lines)


def _find_best(scores: Sequence[float]) -> int:
    return max(range(len(scores)), key=lambda i: scores[i] or 0.0)


def _group(rows: Sequence[Mapping], key: str) -> list[tuple[str, list[Mapping]]]:
    names = list(dict.fromkeys(r[key] for r in rows))
    return [(name, [r for r in rows if r[key] == name]) for name in names]


def _write_kinds(rows: Sequence[Mapping]) -> str:
    return "\n".join(
        [
            "## The two kinds of skill",
            "",
            "The same effect by a body force (M = 1) and by velocity constraints. `drift` and `turn` are what the "
            "whole does besides, in body lengths and degrees; J is the volume of the most squeezed and most stretched "
            "particle over that at rest. The rule that chooses between them is in [skills.md](skills.md).",
            table(
                ["effect", "object", "kind", "asked for", "achieved", "", "drift", "turn", "J"],
                [
                    [
                        r["effect"], r["object"], r["kind"], number(r["asked"]), number(r["achieved"]), r["unit"],
                        number(r["drift"]), number(r["turn"]), f"{r['min_J']:.2f} to {r['max_J']:.2f}",
                    ]
                    for r in rows
                ],
            ),
        ]
    )  # fmt: skip
