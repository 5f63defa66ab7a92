"""Votes of a user study, as participants send them."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.study.analysis import analyse_study, write_summary
from physagent_jax.study.schema import Ballot, Item, Sheet, Study, StudyClip, read_ballot
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, any_json, damaged, encoded, of_schema

CODE = "000-0123456789abcdef"
CLIPS = tuple(StudyClip(id=f"{index:012x}", method=name, source=name) for index, name in enumerate("abc"))
STUDY = Study(
    id="study",
    open=False,
    alternatives=3,
    methods=("a", "b", "c"),
    items=(Item(name="x", family="", sentence="push it", clips=CLIPS),),
    sheets=(Sheet(code=CODE, sets=(tuple(clip.id for clip in CLIPS),)),),
)
CHOICES = {name: CLIPS[1].id for name in ("alignment", "fidelity", "overall")}
GOOD = {"study": "study", "code": CODE, "answers": [{"choices": CHOICES, "seconds": 4.5}]}


def make(draw: Draw) -> Case:
    """One file of votes, read and counted."""
    match draw.one(["altered", "altered", "damaged", "schema", "any"]):
        case "altered":
            what, content = altered(draw, GOOD)
        case "damaged":
            what, content = damaged(draw, encoded(GOOD))
        case "schema":
            what, content = "of the schema", encoded(of_schema(draw, Ballot.model_json_schema()))
        case _:
            what, content = "any JSON", encoded(any_json(draw))
    return Case(what, _count, {"votes.json": content})


def _count(folder: Path):
    ballot = read_ballot((folder / "votes.json").read_bytes(), STUDY, "votes.json")
    result = analyse_study(STUDY, [ballot])
    write_summary(result)
    return result["median_seconds"]
