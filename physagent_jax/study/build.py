"""Write a study's folder: one page for participants, and the plan that tells whose each clip is."""

from __future__ import annotations

import base64
import hashlib
import json
import random
import secrets
from collections.abc import Sequence
from importlib import resources
from pathlib import Path, PurePosixPath

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.study.design import Balance, make_sheets
from physagent_jax.study.schema import CODES, PAGE, PLAN, QUESTIONS, VOTES, Item, Sheet, Study, StudyClip
from physagent_jax.study.sources import copy_clip, match_items, read_method

MOST_BYTES = 200 * 2**20
"""Largest size of all clips of a page [bytes]: participants load it whole."""


def build_study(
    results: Sequence[str],
    out: Path,
    *,
    participants: int,
    sets: int | None,
    alternatives: int,
    open_: bool,
    seed: int,
) -> tuple[Study, Balance, list[str]]:
    """Make a study of the results of methods.

    Args:
        results: Folders of the methods, as `read_method` takes them.
        out: Folder of the study.
        participants: Number of sheets, and of codes.
        sets: Number of sets that a participant sees; None = every item once.
        alternatives: Number of clips in a set.
        open_: Whether anybody with the page may vote, rather than those with a code.
        seed: Seed of the design; codes and ids of clips are secret and never repeat.

    Returns:
        The plan, its balance, and notes on what is missing or may give methods away.

    Raises:
        UserError: The results do not make a study, or the folder holds one.
    """
    if (out / PLAN).exists():
        raise UserError(f"{out} holds a study", do="Choose another --out: its votes would lose their meaning")
    named = [read_method(given) for given in results]
    methods = dict(named)
    if len(methods) < len(named):
        raise UserError(
            "two methods have the same name", got=", ".join(name for name, _ in named), do="Pass NAME=FOLDER"
        )
    matched, notes = match_items(methods, alternatives)
    if sets is not None and sets > len(matched):
        raise UserError("`--sets` is more than there are items", got=f"{sets} of {len(matched)}")
    contents: dict[str, bytes] = {}
    items = []
    for name, sources in matched.items():
        clips, looks = [], {}
        for source in sources:
            (video,) = source.videos.values()
            content, looks[source.method] = copy_clip(video)
            clip = StudyClip(
                id=secrets.token_hex(6), method=source.method, source=str(video), judged=source.judged
            )
            contents[clip.id] = content
            clips.append(clip)
        if len(set(looks.values())) > 1:
            told = "; ".join(f"{method} {w} x {h}, {s:g} s" for method, (w, h, s) in looks.items())
            notes.append(f"{name}: sizes or durations differ, which may give a method away ({told}).")
        family = PurePosixPath(name).parent.as_posix()
        sentence = " ".join(sources[0].sentence.split())
        items.append(
            Item(name=name, family="" if family == "." else family, sentence=sentence, clips=tuple(clips))
        )
    size = sum(map(len, contents.values()))
    if size > MOST_BYTES:
        raise UserError(
            "the clips are too large for one page",
            got=f"{size >> 20} of {MOST_BYTES >> 20} MiB",
            do="Make them smaller",
        )
    available = [[clip.method for clip in item.clips] for item in items]
    dealt, balance = make_sheets(
        available, alternatives, sheets=participants, sets=sets or len(items), seed=seed
    )
    ids = [{clip.method: clip.id for clip in item.clips} for item in items]
    sheets = tuple(
        Sheet(
            code="" if open_ else f"{index:03d}-{secrets.token_hex(8)}",
            sets=tuple(tuple(ids[item][method] for method in shown) for item, shown in page),
        )
        for index, page in enumerate(dealt)
    )
    study = Study(
        id=secrets.token_hex(6),
        open=open_,
        alternatives=alternatives,
        methods=tuple(methods),
        items=tuple(items),
        sheets=sheets,
    )
    write_text(out / PAGE, render_page(study, contents))
    if not open_:
        write_text(out / CODES, "".join(f"{sheet.code}\n" for sheet in sheets))
    (out / VOTES).mkdir(exist_ok=True)
    write_text(out / PLAN, study.model_dump_json(indent=1) + "\n")  # last: with it the study exists
    return study, balance, notes


def render_page(study: Study, contents: dict[str, bytes]) -> str:
    """The page of a study, which names no method: clips come in random order under random ids."""
    sentences = {clip.id: item.sentence for item in study.items for clip in item.clips}
    ids = sorted(contents)
    random.SystemRandom().shuffle(ids)
    data = {
        "study": study.id,
        "open": study.open,
        "questions": QUESTIONS,
        "sheets": [
            [{"sentence": sentences[shown[0]], "clips": shown} for shown in sheet.sets]
            for sheet in study.sheets
        ],
        "clips": {id_: base64.b64encode(contents[id_]).decode("ascii") for id_ in ids},
    }
    page = resources.files("physagent_jax.study").joinpath("page.html").read_text("utf-8")
    script = page.split("<script>", 1)[1].split("</script>", 1)[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; media-src blob:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'"
    )
    text = json.dumps(data, ensure_ascii=False).replace("<", "\\u003c")
    return page.replace("{{policy}}", policy).replace("{{data}}", text)
