"""Planners that ask a chat model: alone, or in agreement with the rules."""

from __future__ import annotations

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.llm.fields import Sentences
from physagent_jax.agents.llm.prompt import write_field, write_messages
from physagent_jax.agents.llm.structured import BadAnswers, add_repairs, ask
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.trace import Reply
from physagent_jax.chat.base import ChatModel
from physagent_jax.core.strict import Strict
from physagent_jax.motion.judging.verdict import HIGHEST_FAILURE, describe_doubts
from physagent_jax.motion.schema import Judgement, Verdict

MOST_PICTURES = 6


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


class ModelPlanner(RulePlanner):
    """Judges with a chat model, by the motion report and, if the model has eyes, by pictures of the clip.

    If no answer of it fits the form, the rules judge instead, and say so.
    """

    def __init__(self, model: ChatModel):
        self._model = model

    @property
    def name(self) -> str:
        """The model: another one is another run."""
        return f"chat({self._model.name})"

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare the report with the sentence; see `protocols.PlannerAgent`."""
        rules = super().judge(context, seen).value
        try:
            answer = judge_with_model(self._model, context, seen)
        except BadAnswers as error:
            why = f"No answer of {self._model.name} fits the form: the rules have judged instead."
            return Reply(rules.model_copy(update=dict(notes=(why,))), add_repairs(error.trace, why))
        return Reply(self._conclude(answer.value, rules, context), answer.trace)

    def _conclude(self, form: JudgementForm, rules: Judgement, context: AgentContext) -> Judgement:
        """The model's judgement; where the sentence is in doubt, no motion is a success, whoever judges."""
        verdict, suggestion = form.verdict, _get_suggestion(form)
        unsure = context.reading.unsure if context.reading else ()
        if unsure and verdict is Verdict.SUCCESS:
            verdict, suggestion = Verdict.FAIL, describe_doubts(unsure)
        return Judgement(verdict=verdict, suggestion=suggestion, notes=_list_notes(form))


class BothPlanners(ModelPlanner):
    """Judges with the rules and a chat model: a SUCCESS needs both.

    Checks and score are those of the rules, so that an executor by rules has something to mend.
    """

    @property
    def name(self) -> str:
        """The rules and the model."""
        return f"both(rules, {self._model.name})"

    def _conclude(self, form: JudgementForm, rules: Judgement, context: AgentContext) -> Judgement:
        said, who = form.verdict, self._model.name
        told = f"Rules and {who} agree."
        if said is not rules.verdict:
            told = f"Rules and model disagree: the rules say {rules.verdict.value}, {who} says {said.value}."
        changes: dict[str, object] = {"notes": (told, *_list_notes(form))}
        if said is Verdict.FAIL and rules.verdict is Verdict.SUCCESS:
            score = rules.score if rules.score is None else min(rules.score, HIGHEST_FAILURE)
            changes |= {"verdict": said, "score": score, "suggestion": _get_suggestion(form)}
        return rules.model_copy(update=changes)


def judge_with_model(model: ChatModel, context: AgentContext, seen: Observation) -> Reply[JudgementForm]:
    """A model's judgement alone.

    Raises:
        AgentError: The model gives no answer, or none that fits (`BadAnswers`).
    """
    frames = seen.key_frames.pick(MOST_PICTURES) if model.has_eyes else ()
    numbers = ", ".join(str(frame.frame) for frame in frames)
    messages = write_messages(
        "planner",
        context,
        tuple(frame.png for frame in frames),
        report=seen.report.text,
        force_field=write_field(seen.force_field),
        shown=f"\nThe pictures are the frames {numbers} of the video.\n" if frames else "",
    )
    return ask(model, messages, JudgementForm)


def _get_suggestion(form: JudgementForm) -> str:
    if form.verdict is Verdict.SUCCESS:
        return ""
    return form.suggestion or form.comparison or "The motion is not what the sentence asks for."


def _list_notes(form: JudgementForm) -> tuple[str, ...]:
    return (form.comparison,) if form.comparison else ()
