"""Force fields as a model writes them: checked for their shape alone, then mended by the hard rules."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue

from physagent_jax.agents.hard_rules import Repair, apply_hard_rules
from physagent_jax.agents.llm.choices import Sentences
from physagent_jax.agents.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.agents.vectors import scale
from physagent_jax.core.strict import Number, Numbers
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField
from physagent_jax.forces.skills import get_skill


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
    last = float(brief.frame_count - 1)
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
