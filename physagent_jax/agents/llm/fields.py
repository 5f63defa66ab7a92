"""Types of what a model writes: words, and force fields, whose shape is checked and which the hard rules mend."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetPydanticSchema, JsonValue
from pydantic_core import PydanticCustomError, core_schema

from physagent_jax.agents.hard_rules import Repair, apply_hard_rules
from physagent_jax.core.strict import Number, Numbers
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import scale


def one_of(list_words: Callable[[], Iterable[str]]) -> GetPydanticSchema:
    """Annotation of a string that is one of some words; they are listed when they are needed, not before."""

    def check(word: str) -> str:
        words = list(list_words())
        if word not in words:
            raise PydanticCustomError("enum", "Input should be one of {words}", {"words": ", ".join(words)})
        return word

    return GetPydanticSchema(
        lambda source, handler: core_schema.no_info_after_validator_function(check, handler(source)),
        lambda _schema, _handler: {"type": "string", "enum": list(list_words())},
    )


def _make_plain(text: str) -> str:
    """The text on one line; what is not printable, a terminal's escapes among it, becomes a space."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


Phrase = Annotated[str, Field(max_length=200), AfterValidator(_make_plain)]
Sentences = Annotated[str, Field(max_length=2000), AfterValidator(_make_plain)]


class _Lenient(BaseModel):
    """Keeps what it does not know, for the hard rules to remove and to record."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)


class ActionForm(_Lenient):
    """An action in the paper's schema, with the library's region."""

    action_type: ActionType
    vector: Numbers
    magnitude: Number = 1.0
    active_time: tuple[Number, Number] | None = None
    region: dict[str, JsonValue] | None = None


class ConstraintForm(_Lenient):
    """A prescribed velocity."""

    constraint_type: ConstraintType
    vector: Numbers
    magnitude: Number = 1.0
    active_time: tuple[Number, Number] | None = None
    region: dict[str, JsonValue] | None = None
    held_until: Number | None = None


class PaperForm(_Lenient):
    """The paper's force field (appendix A.1)."""

    default_drop: bool = False
    actions: Annotated[tuple[ActionForm, ...], Field(max_length=50)]


class RewriteForm(PaperForm):
    """A whole force field that takes another's place.

    Attributes:
        reason: What changed and why.
        constraints: Prescribed velocities.
    """

    reason: Sentences = ""
    constraints: Annotated[tuple[ConstraintForm, ...], Field(max_length=50)] = ()


def build_field(
    form: PaperForm, brief: SceneBrief, expectations: tuple[ExpectedMotion, ...] = ()
) -> tuple[ForceField, tuple[Repair, ...]]:
    """The force field of a form, inside the hard rules, and what they mended."""
    raw: dict[str, Any] = form.model_dump(mode="json", exclude_none=True, exclude={"reason"})
    return apply_hard_rules(raw, brief, expectations)


def expect_motions(field: ForceField, brief: SceneBrief) -> tuple[ExpectedMotion, ...]:
    """Motions that a force field without a sentence's words leads a viewer to expect."""
    last = brief.last
    motions = [_expect(action, last) for action in field.actions]
    if field.default_drop:
        motions.append(ExpectedMotion(kind=MotionKind.FALL, window=(0.0, last)))
    return tuple(motions) or (ExpectedMotion(kind=MotionKind.STILL, window=(0.0, last)),)


def _expect(action: Action, last: float) -> ExpectedMotion:
    skill, reversed_ = get_skill(action), action.magnitude < 0
    kind = MotionKind(skill.causes[0])
    if kind is MotionKind.STRETCH and reversed_:
        kind = MotionKind.SQUEEZE
    return ExpectedMotion(
        kind=kind,
        direction=scale(action.vector, -1.0 if reversed_ and not skill.is_two_sided else 1.0),
        strength=abs(action.magnitude),
        window=action.active_time or (0.0, last),
        sudden=skill.is_sudden,
        partial=action.region is not None,
    )
