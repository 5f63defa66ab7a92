"""Forms that a model fills in about a sentence: flat objects of words, and their conversion into an `Intent`.

A model is asked for words that stand in the sentence, never for signs, vectors or frames: models of every size are
better at that (docs/decisions.md, "Forms of a reading"). The compiler does the rest, as it does for the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from physagent_jax.agents.intent import Direction, Intent
from physagent_jax.agents.llm.fields import Phrase, one_of
from physagent_jax.agents.llm.splitting import Order
from physagent_jax.core.reading import read_packaged_yaml, shorten
from physagent_jax.core.strict import Strict
from physagent_jax.forces.skills import list_skills
from physagent_jax.motion.schema import Manner

NOTHING, RELEASE = "nothing", "let go"  # a release follows what it ends, whatever joins them
_WORDS = read_packaged_yaml("physagent_jax.agents.llm", "forms.yaml")
MOTIONS: dict[str, str] = _WORDS["motions"]
STRENGTHS: dict[str, list[str]] = _WORDS["strengths"]
PARTS: dict[str, str] = _WORDS["parts"]
UNITS: dict[str, dict[str, str]] = _WORDS["units"]
SETTINGS: dict[str, dict[str, dict[str, str]]] = _WORDS["settings"]


def list_motions() -> dict[str, str]:
    """All motions that a model may choose, those that skills bring by their own words included."""
    named: dict[str, str] = {}
    for skill in list_skills("actions"):
        words = [word for word in (*skill.nouns, *skill.verbs) if "~" not in word]
        if words:
            named[words[0]] = ", ".join(words)
    return MOTIONS | {word: meaning for word, meaning in named.items() if word not in MOTIONS}


Direct = Literal[
    "left", "right", "up", "down", "toward", "away",
    "horizontal", "vertical", "depth", "long axis",
    "both sides", "all sides", "outward", "inward", "back",
]  # fmt: skip
Motion = Annotated[str, one_of(lambda: (NOTHING, *list_motions()))]
Strength = Annotated[str, one_of(lambda: STRENGTHS)]
PartName = Annotated[str, one_of(lambda: PARTS)]
Unit = Annotated[str, one_of(lambda: UNITS)]
Setting = Annotated[str, one_of(lambda: SETTINGS)]


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
        manner: How it goes on, if the words tell it.
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
    manner: Manner = ""
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
    """Raise a `ValueError` for a clause whose words do not stand in the sentence: it is invented."""
    said = set(_list_words(sentence))
    for index, clause in enumerate(form.clauses):
        strange = [word for word in _list_words(clause.words) if word not in said]
        if strange or not _list_words(clause.words):
            what = f"{strange[0]!r} does not stand in the sentence" if strange else "they are empty"
            advice = "copy them from the sentence, or leave the clause out"
            raise ValueError(f"clauses.{index}.words: {what}; {advice}")


def _list_words(text: str) -> list[str]:
    return re.findall(r"\w+", text.casefold())


def make_intent(form: SentenceForm) -> Intent:
    """The intent that a filled form stands for."""
    return _build(form.clauses, materials=(form.material,) if form.material else (), unknown=form.unclear)


def join_clauses(forms: Sequence[ClauseForm], texts: Sequence[str], orders: Sequence[Order]) -> Intent:
    """The intent of a sentence whose clauses, with these texts, were asked for one by one."""
    clauses = [
        OrderedClauseForm(**form.model_dump(), words=shorten(text), order=order)
        for form, text, order in zip(forms, texts, orders)
    ]
    return _build(clauses)


def _build(forms: Sequence[OrderedClauseForm], **more: Any) -> Intent:
    clauses, ignored, walls = [], [], []
    said: dict[str, dict[str, Any]] = {"surroundings": {}}
    for form in forms:
        clause = _describe_clause(form)
        for part, setting in SETTINGS[form.setting].items() if form.setting else ():
            said[part] = {**setting, "text": form.words}
        if form.motion != NOTHING:
            clauses.append(clause)
        elif form.wall is not None:
            walls += clause["solids"]
        elif form.setting is None:
            ignored.append(form.words)
    said["surroundings"]["solids"] = walls
    return Intent.model_validate({"clauses": clauses, "ignored": ignored, **said, **more})


def _describe_clause(form: OrderedClauseForm) -> dict[str, Any]:
    """The fields of an intent's clause; each holds the words that led to it."""
    text = {"text": form.words}
    ways = dict.fromkeys(word for word in (form.word, form.and_word) if word is not None)
    quantities, repetitions = [], []
    if form.number is not None and form.unit is not None:
        quantities.append({"value": form.number, **UNITS[form.unit], **text})
    if form.times is not None or form.to_and_fro:
        repetitions.append({"times": form.times, "alternating": form.to_and_fro, **text})
    times = {"starts": form.starts, "lasts": form.lasts}
    return {
        "motion": form.motion,
        "order": "then" if form.motion == RELEASE else form.order,
        "ways": [{"relation": form.relation, "word": word, **text} for word in ways],
        "turning": form.turning,
        "parts": [] if form.part is None else [{"word": PARTS[form.part], **text}],
        "strength": STRENGTHS[form.strength],
        "quantities": quantities,
        "timing": {name: {"value": value, **text} for name, value in times.items() if value is not None},
        "repetitions": repetitions,
        "solids": [] if form.wall is None else [{"sides": (form.wall,), **text}],
        "negated": form.negated,
        "stays": form.stays,
        "manner": form.manner,
        **text,
    }
