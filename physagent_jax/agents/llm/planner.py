"""Planners that ask a chat model: alone, or in agreement with the rules."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.llm.base import ChatModel
from physagent_jax.agents.llm.choices import Sentences
from physagent_jax.agents.llm.scene_words import describe_rounds, describe_scene, write_field
from physagent_jax.agents.llm.semantic import has_bad_answers
from physagent_jax.agents.llm.structured import ask
from physagent_jax.agents.llm.templates import quote, write_messages
from physagent_jax.agents.protocols import PlannerAgent
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.schema import Judgement, Verdict
from physagent_jax.agents.trace import AgentError, Reply
from physagent_jax.core.strict import Strict

MOST_PICTURES = 6
_HIGHEST_FAILURE = 0.99


class JudgementForm(Strict):
    """A model's judgement.

    Attributes:
        comparison: What was asked and what was seen.
        verdict: Whether they are the same.
        suggestion: What to change in the force field.
    """

    comparison: Sentences = ""
    verdict: Verdict
    suggestion: Sentences = ""


class ModelPlanner(PlannerAgent):
    """Judges with a chat model, by the motion report and, if the model has eyes, by pictures of the clip.

    If no answer of it fits the form, the rules judge instead, and say so.

    Args:
        model: The model.
    """

    def __init__(self, model: ChatModel):
        self._model = model

    @property
    def name(self) -> str:
        """The model: another one is another run."""
        return f"chat({self._model.name})"

    def windows(self, context: AgentContext) -> Sequence[tuple[int, int]]:
        """Those of the rules."""
        return RulePlanner().windows(context)

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare the report with the sentence; see `protocols.PlannerAgent`."""
        try:
            answer = judge_with_model(self._model, context, seen)
        except AgentError as error:
            return _judge_by_rules(error, self._model, context, seen)
        form = answer.value
        notes = (form.comparison,) if form.comparison else ()
        judgement = Judgement(verdict=form.verdict, suggestion=_get_suggestion(form), notes=notes)
        return Reply(_heed_doubts(judgement, context), answer.trace)


class BothPlanners(PlannerAgent):
    """Judges with the rules and a chat model: a SUCCESS needs both.

    Checks and score are those of the rules, so that an executor by rules has something to mend.

    Args:
        model: The model.
    """

    def __init__(self, model: ChatModel):
        self._model = model

    @property
    def name(self) -> str:
        """The rules and the model."""
        return f"both(rules, {self._model.name})"

    def windows(self, context: AgentContext) -> Sequence[tuple[int, int]]:
        """Those of the rules."""
        return RulePlanner().windows(context)

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare the report with the sentence twice; see `protocols.PlannerAgent`."""
        rules = RulePlanner().judge(context, seen).value
        try:
            answer = judge_with_model(self._model, context, seen)
        except AgentError as error:
            return _judge_by_rules(error, self._model, context, seen)
        form, who = answer.value, self._model.name
        if form.verdict is rules.verdict:
            notes, suggestion = (f"Rules and {who} agree.",), rules.suggestion or ""
        elif rules.verdict is Verdict.SUCCESS:
            notes = (f"Rules and model disagree: the rules say SUCCESS, {who} says FAIL.",)
            suggestion = _get_suggestion(form)
        else:
            notes = (f"Rules and model disagree: the rules say FAIL, {who} says SUCCESS.",)
            suggestion = rules.suggestion
        notes += (form.comparison,) if form.comparison else ()
        agreed = form.verdict is rules.verdict is Verdict.SUCCESS
        score = rules.score if agreed or rules.score is None else min(rules.score, _HIGHEST_FAILURE)
        judgement = rules.model_copy(
            update=dict(
                verdict=Verdict.SUCCESS if agreed else Verdict.FAIL,
                score=score,
                suggestion=suggestion,
                notes=notes,
            )
        )
        return Reply(judgement, answer.trace)


def judge_with_model(model: ChatModel, context: AgentContext, seen: Observation) -> Reply[JudgementForm]:
    """A model's judgement alone.

    Raises:
        AgentError: The model gives no answer, or none that fits.
    """
    frames = seen.key_frames.pick(MOST_PICTURES) if model.has_eyes else ()
    shown = ", ".join(str(frame.frame) for frame in frames)
    values = {
        **describe_scene(context.brief),
        "sentence": quote(context.prompt),
        "report": seen.report.text,
        "force_field": write_field(seen.force_field),
        "rounds": describe_rounds(context.rounds),
        "pictures": f"\nThe pictures are the frames {shown} of the video.\n" if frames else "",
    }
    return ask(model, write_messages("planner", values, tuple(frame.png for frame in frames)), JudgementForm)


def _get_suggestion(form: JudgementForm) -> str:
    if form.verdict is Verdict.SUCCESS:
        return ""
    return form.suggestion or form.comparison or "The motion is not what the sentence asks for."


def _heed_doubts(judgement: Judgement, context: AgentContext) -> Judgement:
    """Bar a success where the sentence is in doubt, whoever judges (`SemanticReply.unsure`)."""
    unsure = context.reading.unsure if context.reading else ()
    if not unsure or judgement.verdict is Verdict.FAIL:
        return judgement
    doubts = "; ".join(doubt.removesuffix(".") for doubt in unsure)
    why = f"Not understood for certain, so no motion can be called a success: {doubts}."
    return judgement.model_copy(update=dict(verdict=Verdict.FAIL, suggestion=why))


def _judge_by_rules(
    error: AgentError, model: ChatModel, context: AgentContext, seen: Observation
) -> Reply[Judgement]:
    """The rules' judgement in place of a model's whose answers do not fit; it says so."""
    if not has_bad_answers(error):
        raise error
    why = f"No answer of {model.name} fits the form: the rules have judged instead."
    judgement = RulePlanner().judge(context, seen).value
    trace = error.trace.model_copy(update=dict(repairs=(*error.trace.repairs, why)))
    return Reply(judgement.model_copy(update=dict(notes=(why,))), trace)
