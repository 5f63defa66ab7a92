"""The executor that asks a chat model: suggestion and constraint ledger in, force field out."""

from __future__ import annotations

from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.agents.hard_rules import RULES
from physagent_jax.agents.llm.fields import RewriteForm, build_field
from physagent_jax.agents.llm.prompt import list_rows, quote, write_field, write_messages
from physagent_jax.agents.llm.structured import BadAnswers, add_repairs, ask
from physagent_jax.agents.rules.executor import RuleExecutor
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.chat.base import ChatModel


class ModelExecutor(RuleExecutor):
    """Rewrites with a chat model, inside the hard rules: they win always, and what they change is recorded.

    A force field that was tried before is sent back to the model. If no answer of it can be used, the rules rewrite
    instead, and say so.
    """

    def __init__(self, model: ChatModel):
        self._model = model

    @property
    def name(self) -> str:
        """The model: another one is another run."""
        return f"chat({self._model.name})"

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Return the next force field; see `protocols.ExecutorAgent`."""
        messages = write_messages(
            "executor",
            context,
            ledger=list_ledger(),
            report=failed.report.text,
            force_field=write_field(failed.force_field),
            suggestion=quote(failed.judgement.suggestion),
        )
        tried = [each.force_field for each in (*context.rounds, failed)]

        def check(form: RewriteForm) -> None:
            field, _ = build_field(form, context.brief, context.expectations)
            if not (field.actions or field.constraints or field.default_drop):
                raise ValueError(
                    "nothing acts in this force field; write all of it, with what stays as it was"
                )
            if field in tried:
                raise ValueError("inside the ledger this is a force field that was tried before; change it")

        try:
            answer = ask(self._model, messages, RewriteForm, validate=check)
        except BadAnswers as error:
            instead = "the rules have rewritten the force field instead"
            why = f"No answer of {self._model.name} can be used: {instead}."
            rewrite = super().rewrite(context, failed).value
            told = rewrite.model_copy(update=dict(changes=(why, *rewrite.changes)))
            return Reply(told, add_repairs(error.trace, why))
        field, repairs = build_field(answer.value, context.brief, context.expectations)
        reason = answer.value.reason or "The model gives no reason."
        rewrite = Rewrite(
            force_field=field,
            changes=(reason, *(f"Hard rule: {repair.why}." for repair in repairs)),
            rules_applied=tuple(dict.fromkeys(repair.rule for repair in repairs)),
        )
        return Reply(rewrite, answer.trace)


def list_ledger() -> str:
    """The hard rules in words, a line each, as they describe themselves."""
    return list_rows({name: (rule.__doc__ or "").strip().splitlines()[0] for name, rule in RULES.items()})
