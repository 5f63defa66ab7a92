"""Files of a study: the plan, which tells whose each clip is, and ballots, which hold votes and no names."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import decode_json, parse_model, read_bytes, read_json, shorten
from physagent_jax.core.strict import Strict

PLAN, VOTES, PAGE, CODES = "study.json", "votes", "page/index.html", "codes.txt"
BALLOT_BYTES = 2**20
QUESTIONS = {
    "alignment": "Which video does most exactly what the sentence says?",
    "fidelity": "In which video do things move and deform most as they would in reality?",
    "overall": "Taking picture and physics together, which video do you prefer?",
}
"""Criteria of PhysAgent's appendix, in words of our own."""

Question = Literal["alignment", "fidelity", "overall"]
Code = Annotated[str, Field(pattern=r"^\d{3}-[0-9a-f]{16}$")]


class Judged(Strict):
    """A judge's opinion of a clip: ``by`` names the judge, a higher score is better."""

    by: str
    success: bool
    score: float


class StudyClip(Strict):
    """A clip; ``id`` is all that participants can see of it."""

    id: str
    method: str
    source: str
    judged: Judged | None = None


class Item(Strict):
    """A sentence, and the clips that methods made for it."""

    name: str
    family: str
    sentence: str
    clips: tuple[StudyClip, ...]


class Sheet(Strict):
    """A participant's part: sets of clips in the order shown, from left to right; ``code`` is empty in open studies."""

    code: str
    sets: tuple[tuple[str, ...], ...]


class Study(Strict):
    """The plan of a study. Its file names the method of each clip: it is not for participants."""

    format: Literal["physagent-study-1"] = "physagent-study-1"
    id: str
    open: bool
    alternatives: int
    methods: tuple[str, ...]
    items: tuple[Item, ...]
    sheets: tuple[Sheet, ...]


class Answer(Strict):
    """Answers to the questions about a set: the ids of the chosen clips; ``seconds`` is the time they took [s]."""

    choices: dict[Question, str]
    seconds: float = Field(ge=0)


class Ballot(Strict):
    """Votes of a participant: the first sets of the sheet that the code names."""

    study: str
    code: Code
    answers: tuple[Answer, ...]

    @property
    def sheet(self) -> int:
        """Index of the participant's sheet."""
        return int(self.code[:3])

    def extends(self, other: Ballot) -> bool:
        """Return whether this holds all votes of ``other``, and perhaps more."""
        return self.code == other.code and self.answers[: len(other.answers)] == other.answers


def read_study(folder: Path) -> Study:
    """Read the plan in a study's folder.

    Raises:
        UserError: There is none, or it is damaged.
    """
    if not (folder / PLAN).is_file():
        raise UserError(
            f"{shorten(folder)} holds no {PLAN}",
            do="Make a study first: physagent study build RESULTS --out DIR",
        )
    return parse_model(read_json(folder / PLAN), Study, f"{PLAN} cannot be used")


def read_ballot(data: bytes, study: Study, origin: str) -> Ballot:
    """Check what a participant sent.

    Args:
        data: JSON.
        study: The study that it should belong to.
        origin: Its name in messages.

    Raises:
        UserError: It is no ballot, is one of another study or of nobody invited, or names a clip that was not shown.
    """
    ballot = parse_model(decode_json(data, origin), Ballot, f"{origin} is not a ballot")
    if ballot.study != study.id:
        raise UserError(
            f"{origin} belongs to another study", got=shorten(ballot.study, 40), do=f"This one is {study.id}"
        )
    if ballot.sheet >= len(study.sheets) or not (
        study.open or study.sheets[ballot.sheet].code == ballot.code
    ):
        raise UserError(
            f"{origin} has a code that nobody was given", got=ballot.code, do=f"See {CODES} for those given"
        )
    if not 0 < len(ballot.answers) <= len(study.sheets[ballot.sheet].sets):
        raise UserError(
            f"{origin} answers {len(ballot.answers)} sets", do="Expected between 1 and the sheet's number"
        )
    for number, (answer, shown) in enumerate(zip(ballot.answers, study.sheets[ballot.sheet].sets), 1):
        if set(answer.choices) != set(QUESTIONS):
            raise UserError(
                f"{origin} leaves questions of set {number} open", got=", ".join(answer.choices) or "none"
            )
        for chosen in answer.choices.values():
            if chosen not in shown:
                raise UserError(
                    f"{origin} names a clip that set {number} did not show", got=shorten(chosen, 40)
                )
    return ballot


def collect_ballots(files: Iterable[Path], study: Study) -> tuple[list[Ballot], list[str]]:
    """Ballots of files, one per participant, and a line for each file that does not count.

    A ballot that goes on from another of the same code takes its place; one that contradicts an earlier one is refused.
    """
    kept: dict[str, Ballot] = {}
    faults = []
    for path in files:
        try:
            ballot = read_ballot(read_bytes(path, most=BALLOT_BYTES, what="the ballot"), study, path.name)
        except UserError as error:
            faults.append(str(error))
            continue
        earlier = kept.get(ballot.code)
        if earlier is None or ballot.extends(earlier):
            kept[ballot.code] = ballot
        elif not earlier.extends(ballot):
            faults.append(
                f"{path.name} votes a second time, and otherwise, with {ballot.code}: the first counts."
            )
    return list(kept.values()), faults
