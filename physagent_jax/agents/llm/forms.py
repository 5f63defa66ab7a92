"""Forms that a model fills in about a sentence: flat objects of words, and their conversion into an `Intent`.

A model is asked for words that stand in the sentence, never for signs, vectors or frames: models of every size are
better at that (docs/decisions.md, "Forms of a reading"). The compiler does the rest, as it does for the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from physagent_jax.agents.intent import (
    Clause,
    Duration,
    Held,
    Intent,
    Part,
    Quantity,
    Relation,
    Repetition,
    Solid,
    Surroundings,
    Timing,
    Way,
)
from physagent_jax.agents.llm.choices import OneOf, Phrase
from physagent_jax.core.strict import Strict
from physagent_jax.forces.skills import list_skills

NOTHING, RELEASE = "nothing", "let go"  # a release follows what it ends, whatever joins them
MOTIONS: dict[str, str] = {
    "push": "it is pushed, or moves, slides, drifts or flies somewhere",
    "pull": "it is pulled or dragged",
    "blow": "wind or air acts on it",
    "lift": "it is raised, rises or floats up",
    "lower": "it is set down or sinks",
    "bend": "its upper end goes aside: bends, leans, tilts",
    "sway": "to and fro: sways, swings, rocks, waves",
    "shake": "to and fro, fast: shakes, vibrates, trembles",
    "stretch": "it gets longer",
    "squeeze": "it is squeezed together from two sides",
    "flatten": "it is pressed down flat",
    "swell": "it gets bigger on all sides",
    "shrink": "it gets smaller on all sides",
    "hit": "a sudden blow: hit, kicked, knocked, punched",
    "throw": "it is thrown through the air",
    "explode": "it bursts apart",
    "spin": "it turns about an axis: spins, rotates, turns",
    "twist": "one end is turned against the other",
    "flip": "it is turned over",
    "roll": "it rolls along",
    "fall": "gravity lets it fall: dropped, falls, bounces",
    "topple": "it falls over",
    "jump": "it leaps",
    RELEASE: "what acted before stops, and it comes back",
    "stand still": "it is asked not to move",
}
"""Motions that a model may choose, in the lexicon's words, and what each covers; skills add theirs (`list_motions`)."""


def list_motions() -> dict[str, str]:
    """All motions that a model may choose, those that skills bring by their own words included."""
    named: dict[str, str] = {}
    for skill in list_skills("actions"):
        words = [word for word in (*skill.nouns, *skill.verbs) if "~" not in word]
        if words:
            named[words[0]] = ", ".join(words)
    return MOTIONS | {word: meaning for word, meaning in named.items() if word not in MOTIONS}


STRENGTHS: dict[str, tuple[str, ...]] = {
    "gentle": ("gently",),
    "plain": (),
    "strong": ("strongly",),
    "violent": ("violently",),
}
PARTS: dict[str, str] = {
    "top": "upper half",
    "bottom": "lower half",
    "left": "left side",
    "right": "right side",
    "front": "front side",
    "back": "rear side",
    "middle": "middle",
}
_UNITS = {"degrees": "degrees", "body lengths": "lengths", "metres": "metres", "times": "share"}
SETTINGS = ("no gravity", "gravity upwards", "held at its base", "held at its top", "not held")

Direction = Literal["left", "right", "up", "down", "toward", "away"]
Direct = Literal[
    "left", "right", "up", "down", "toward", "away",
    "horizontal", "vertical", "depth", "long axis",
    "both sides", "all sides", "outward", "inward", "back",
]  # fmt: skip
Motion = Annotated[str, OneOf(lambda: (NOTHING, *list_motions()))]
Strength = Annotated[str, OneOf(lambda: STRENGTHS)]
PartName = Annotated[str, OneOf(lambda: PARTS)]
Unit = Annotated[str, OneOf(lambda: _UNITS)]
Setting = Annotated[str, OneOf(lambda: SETTINGS)]
Order = Literal["then", "together"]


class ClauseForm(Strict):
    """One thing that a sentence asks for; what it does not say is left out.

    Attributes:
        motion: The nearest motion; "nothing" if the words ask for none.
        relation: Relation of ``word`` to the motion.
        word: The direction, line or side that is named.
        and_word: A second direction: "up" and "left".
        turning: Sense of a rotation, as the viewer sees it.
        part: The part that is acted on; left out for the whole object.
        strength: How strong it is.
        number, unit: A distance, an angle, or "times" as large.
        starts: When it begins [s].
        lasts: How long it lasts [s].
        times: How often it happens.
        to_and_fro: Whether it goes there and back.
        negated: Whether the words say that it does not happen.
        stays: Whether the result is held.
        wall: Where a wall or block stands that is named.
        setting: What is said about gravity or about holding the object.
    """

    motion: Motion
    relation: Literal["to", "from", "along", "about"] = "to"
    word: Direct | None = None
    and_word: Direction | None = None
    turning: Literal["clockwise", "counterclockwise"] | None = None
    part: PartName | None = None
    strength: Strength = "plain"
    number: float | None = Field(default=None, ge=0, le=1e9)
    unit: Unit | None = None
    starts: float | None = Field(default=None, ge=0, le=1e6)
    lasts: float | None = Field(default=None, ge=0, le=1e6)
    times: int | None = Field(default=None, ge=1, le=1000)
    to_and_fro: bool = False
    negated: bool = False
    stays: bool = False
    wall: Direction | None = None
    setting: Setting | None = None

    @model_validator(mode="before")
    @classmethod
    def _drop_unsaid(cls, value: Any) -> Any:
        """Leave out what a model writes for "not said"."""
        if not isinstance(value, dict):
            return value
        return {key: each for key, each in value.items() if each is not None and each not in ("", "none")}


class _Words(Strict):
    """The words come first, so that a model copies them before it says what they mean."""

    words: Phrase


class OrderedClauseForm(ClauseForm, _Words):
    """A clause among those of a whole sentence.

    Attributes:
        words: The words of the sentence that say it.
        order: "then" follows the clause before; "together" happens at the same time.
    """

    order: Order = "then"


class SentenceForm(Strict):
    """A whole sentence.

    Attributes:
        clauses: What it asks for, in the order of time.
        material: A word for what the object is made of, if the sentence says so.
        unclear: Words that bear on the motion and fit nothing here.
    """

    clauses: Annotated[tuple[OrderedClauseForm, ...], Field(max_length=12)]
    material: Phrase | None = None
    unclear: Annotated[tuple[Phrase, ...], Field(max_length=20)] = ()


def check_words(form: SentenceForm, sentence: str) -> None:
    """Refuse a clause whose words do not stand in the sentence: it is invented.

    Raises:
        ValueError: There is one.
    """
    said = set(_list_words(sentence))
    for index, clause in enumerate(form.clauses):
        strange = [word for word in _list_words(clause.words) if word not in said]
        if strange or not _list_words(clause.words):
            what = f"{strange[0]!r} does not stand in the sentence" if strange else "they are empty"
            raise ValueError(
                f"clauses.{index}.words: {what}; copy them from the sentence, or leave the clause out"
            )


def _list_words(text: str) -> list[str]:
    return re.findall(r"\w+", text.casefold())


Piece = tuple[ClauseForm, str, Order]  # a filled form, the words that it is about, and how it follows


def make_intent(form: SentenceForm) -> Intent:
    """The intent that a filled form stands for."""
    pieces: list[Piece] = [(clause, clause.words, clause.order) for clause in form.clauses]
    return _build(pieces, materials=(form.material,) if form.material else (), unknown=form.unclear)


def join_clauses(forms: Sequence[ClauseForm], texts: Sequence[str], orders: Sequence[Order]) -> Intent:
    """The intent of a sentence whose clauses were asked for one by one.

    Args:
        forms: The filled forms.
        texts: The words of each clause.
        orders: How each follows the clause before.
    """
    return _build(list(zip(forms, texts, orders)))


def _build(
    pieces: Sequence[Piece],
    materials: tuple[str, ...] = (),
    unknown: tuple[str, ...] = (),
) -> Intent:
    clauses, ignored, walls = [], [], []
    held, gravity = None, None
    for form, text, order in pieces:
        if form.setting == "no gravity":
            gravity = ("none", text)
        elif form.setting == "gravity upwards":
            gravity = ("up", text)
        elif form.setting is not None:
            end = {"held at its base": "base", "held at its top": "top", "not held": "none"}[form.setting]
            held = Held.model_validate({"end": end, "text": text})
        if form.motion != NOTHING:
            clauses.append(_make_clause(form, text, "then" if form.motion == RELEASE else order))
        elif form.wall is not None:
            walls.append(Solid(sides=(form.wall,), text=text))
        elif form.setting is None:
            ignored.append(text)
    surroundings = Surroundings.model_validate(
        {"gravity": gravity[0] if gravity else None, "solids": walls, "text": gravity[1] if gravity else ""}
    )
    return Intent(
        clauses=tuple(clauses),
        held=held,
        surroundings=surroundings,
        materials=materials,
        ignored=tuple(ignored),
        unknown=unknown,
    )


def _make_clause(form: ClauseForm, text: str, order: Order) -> Clause:
    words = [word for word in (form.word, form.and_word) if word is not None]
    ways = tuple(Way(relation=Relation(form.relation), word=word, text=text) for word in dict.fromkeys(words))
    repeats = form.times is not None or form.to_and_fro
    repetition = Repetition(times=form.times, alternating=form.to_and_fro, text=text)
    starts, lasts = (
        None if value is None else Duration(value=value, text=text) for value in (form.starts, form.lasts)
    )
    return Clause(
        motion=form.motion,
        order=order,
        ways=ways,
        turning=form.turning,
        parts=() if form.part is None else (Part(word=PARTS[form.part], text=text),),
        strength=STRENGTHS[form.strength],
        quantities=_make_quantities(form, text),
        timing=Timing(starts=starts, lasts=lasts),
        repetitions=(repetition,) if repeats else (),
        solids=() if form.wall is None else (Solid(sides=(form.wall,), text=text),),
        negated=form.negated,
        stays=form.stays,
        text=text,
    )


def _make_quantities(form: ClauseForm, text: str) -> tuple[Quantity, ...]:
    if form.number is None or form.unit is None:
        return ()
    relation = "to" if form.unit == "times" else "by"
    said = {"value": form.number, "unit": _UNITS[form.unit], "relation": relation, "text": text}
    return (Quantity.model_validate(said),)
