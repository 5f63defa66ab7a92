"""docs/verdicts.md, made of the rows alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness import Row, link, one_line, provenance, table
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.figures import ALLOWED, HALVES, SIGHTS, count_false, get_rows

_HEAD = """# Verdicts as people give them

Clips of a right or a wrong motion, each with a sentence and a label: would a person who reads the sentence and watches
the video call it a success? The motions are scene data written by hand (accelerations, torques, gripped ends, blows,
in metres and seconds); the labels follow from how they were made, by the rules at the head of
[`catalogue.py`](CATALOGUE), and were checked on contact sheets; no parser took part. A motion also says in numbers what
comes of it, and its particles are held against them first ([`claims.py`](CLAIMS)): a clip that does not move as it is
labelled is listed, and not judged. The offline agents then read each sentence and judge the clip twice: with the
particles' true trajectories in place of perception (*truth*), and from its pictures and depth (*pictures*), before no
background at all (*plain*), a painted wall and floor, or a photo, each with its depth. What either reports of a clip is
kept beside it until the sources that made it change: a run that finds it spends its seconds on judging alone.

A *false SUCCESS* is a wrong motion that passes, a *false FAIL* a right one that does not. A sentence that the parser
refuses counts as FAIL. The clips are halved by the hash of their names; thresholds may be tuned on the development half
alone. Several sentences may share a simulation.

"""
_RATES = ("sight", "half", "clips", "false SUCCESS", "allowed", "false FAIL", "allowed")


def document(result: dict, json_path: Path, target: Path) -> str:
    """The page's text."""
    text = _HEAD
    for name in ("catalogue", "claims"):
        text = text.replace(name.upper(), link(Path(__file__).with_name(f"{name}.py"), target))
    text += f"Every row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, ("clips", *SIGHTS))
    missing = sorted({name for part in result.values() for run in part["runs"] for name in run["left_out"]})
    if missing:
        text += f"\nLeft out in some run, because there was no file: {', '.join(missing)}.\n"
    text += _coverage(result)
    text += table(_RATES, [line for sight in SIGHTS for line in _rates(result, sight)])
    for sight in SIGHTS:
        if rows := get_rows(result, sight):
            text += _section(sight, rows)
    return text + _list_untrue(result)


def _list_untrue(result: dict) -> str:
    """Clips that are not judged, with what is not as it is said."""
    rows = [row for row in get_rows(result, "clips") if row["untrue"]]
    lines = [f"- `{row['clip']}`: {row['motion']}: {'; '.join(row['untrue'])}\n" for row in rows]
    count = len(get_rows(result, "clips"))
    head = f"\n## Not as labelled\n\nOf {count} clips, {len(rows)} do not move as they are said to.\n\n"
    return head + "".join(lines) if count else ""


def _coverage(result: dict) -> str:
    """How much of the catalogue has been judged: a run may be stopped, or be told to judge what has been made."""
    whole = {clip.name for clip in list_clips(None)}
    counts = {sight: len(whole & {row["clip"] for row in get_rows(result, sight)}) for sight in SIGHTS}
    texts = [
        f"{count} with {'the truth' if sight == 'truth' else 'pictures'}" for sight, count in counts.items()
    ]
    return (
        f"\nOf the {len(whole)} clips that need no folder of data, {' and '.join(texts)} have been judged.\n"
    )


def _rates(result: dict, sight: str) -> list[list[Any]]:
    lines = []
    for name, wanted in (("all", {}), *((half, {"half": half}) for half in HALVES)):
        rows = get_rows(result, sight, **wanted)
        if rows:
            success, fail = ALLOWED[sight]
            cells = [sight, name, len(rows), _share(rows, "FAIL"), f"{100 * success:.0f} %"]
            lines.append([*cells, _share(rows, "SUCCESS"), f"{100 * fail:.0f} %"])
    return lines


def _share(rows: Sequence[Row], label: str) -> str:
    false, of = count_false(rows, label)
    return f"{100 * false / of:.1f} % ({false} of {of})" if of else ""


def _section(sight: str, rows: list[Row]) -> str:
    title = "With the truth" if sight == "truth" else "From pictures"
    text = f"\n## {title}\n" + _confusion("motion", rows, lambda row: row["wrong"] or "right")
    if sight == "pictures":
        text += _confusion("background", rows, lambda row: row["background"])
    text += _confusion("object", rows, lambda row: row["object"])
    text += _confusion("world", rows, lambda row: row["world"])
    text += _confusion("sentence", rows, lambda row: row["clip"].split("/")[1])
    return text + "\n### Misjudged\n\n" + "".join(_misjudged(row) for row in rows if not row["right"]) + "\n"


def _confusion(what: str, rows: list[Row], key) -> str:
    """Labels against verdicts, per value of ``key``."""
    columns = (what, "right: SUCCESS", "right: FAIL", "wrong: SUCCESS", "wrong: FAIL")
    lines = []
    for name in sorted({key(row) for row in rows}):
        mine = [row for row in rows if key(row) == name]
        cells = [
            sum((row["label"], row["verdict"]) == (label, verdict) for row in mine)
            for label in ("SUCCESS", "FAIL")
            for verdict in ("SUCCESS", "FAIL")
        ]
        lines.append([name, *cells])
    return table(columns, lines)


def _misjudged(row: Row) -> str:
    why = "; ".join(row.get("failed", [])) or row.get("refused", "no check failed")
    label = f"wrong: {row['wrong']}" if row["wrong"] else "right"
    return one_line(f'- `{row["clip"]}` "{row["sentence"]}": {row["motion"]} ({label}): {why}') + "\n"
