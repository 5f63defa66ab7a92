"""The product's agents with a chat model that reads and rewrites; the planner's rules judge, as a local model is blind.

Answers of the model are all there is: where the product would let its rules read or rewrite in the model's place, a
sentence is refused here, and the rounds end.
"""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

from baselines.agents import play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.protocol import Method
from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.agents.llm.executor import ModelExecutor
from physagent_jax.agents.llm.fields import PaperForm, RewriteForm, expect_motions
from physagent_jax.agents.llm.prompt import quote, write_field, write_messages
from physagent_jax.agents.llm.semantic import FORMS, Form, read_with_model
from physagent_jax.agents.llm.structured import BadAnswers, ask
from physagent_jax.agents.protocols import Agents, ExecutorAgent, SemanticAgent
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.chat.base import ChatModel
from physagent_jax.chat.registry import locate_model, make_model
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField


class Reader(SemanticAgent):
    """Reads with a chat model alone."""

    def __init__(self, model: ChatModel, form: Form):
        self._model: ChatModel = model
        self._form: Form = form

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence; see `protocols.SemanticAgent`."""
        return read_with_model(self._model, context, self._form)


class Rewriter(ModelExecutor):
    """Rewrites with a chat model alone: without a usable answer the force field stays, which ends the rounds."""

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Return the next force field; see `protocols.ExecutorAgent`."""
        reply = super().rewrite(context, failed)
        return _give_up(failed, reply.trace) if reply.trace.repairs else reply


class PlainAuthor(SemanticAgent, ExecutorAgent):
    """Writes force fields from their JSON schema alone: no word about what a skill does, and no hard rules.

    A field that the schema refuses is sent back; nothing is mended.
    """

    def __init__(self, model: ChatModel):
        self._model = model

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Write a first force field; see `protocols.SemanticAgent`."""
        messages = write_messages("semantic_paper", _withhold(context))
        answer = ask(self._model, messages, PaperForm, validate=_build)
        field = _build(answer.value)
        reply = SemanticReply(force_field=field, expectations=expect_motions(field, context.brief))
        return Reply(reply, answer.trace)

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Write another one; see `protocols.ExecutorAgent`."""
        messages = write_messages(
            "executor",
            _withhold(context),
            ledger="(none)",
            report=failed.report.text,
            force_field=write_field(failed.force_field),
            suggestion=quote(failed.judgement.suggestion),
        )
        try:
            answer = ask(self._model, messages, RewriteForm, validate=_build)
        except BadAnswers as error:
            return _give_up(failed, error.trace)
        return Reply(Rewrite(force_field=_build(answer.value), changes=(answer.value.reason,)), answer.trace)


@dataclasses.dataclass(frozen=True)
class ChatAgents(Method):
    """Semantic agent and executor ask a model, in rounds of playing, judging and rewriting.

    Attributes:
        model: The model, or its place: a GGUF file, a cassette (.jsonl), or a server's address and name as URL#MODEL.
        record: Cassette in which its answers are kept; "" = none.
        form: Form of a reading (`agents.llm.semantic`).
        skills: Whether the model is told what skills do, and the hard rules mend what it writes.
        rounds: At most.
    """

    model: str | ChatModel = ""
    record: str = ""
    form: Form = "by-clause"
    skills: bool = True
    rounds: int = 6

    def __post_init__(self):
        if self.rounds < 1:
            raise UserError("`rounds` must be at least 1", got=self.rounds)
        if self.form not in FORMS:
            raise UserError("there is no such `form`", got=self.form, do=f"Choose one of {', '.join(FORMS)}")

    @property
    def name(self) -> str:
        """As in the registry."""
        return "chat_agents"

    def open(self) -> Agents:
        """The agents; a model that has a place is opened once and stays open."""
        model = open_model(self.model, self.record) if isinstance(self.model, str) else self.model
        if self.skills:
            return dataclasses.replace(
                make_agents(), semantic=Reader(model, self.form), executor=Rewriter(model)
            )
        author = PlainAuthor(model)
        return dataclasses.replace(make_agents(), semantic=author, executor=author)

    def search(self, evaluator: Evaluator) -> None:
        """Until the planner is satisfied, the model has no other answer, or the budget is spent."""
        agents = self.open()
        play_rounds(evaluator, read_sentence(evaluator, agents), rounds=self.rounds, agents=agents)


@cache
def open_model(place: str, record: str) -> ChatModel:
    """The model at a place; the same object whenever it is asked for.

    Raises:
        UserError: There is none, or it cannot be opened.
    """
    return make_model(locate_model(place), record=record or None)


def _withhold(context: AgentContext) -> AgentContext:
    """The context without the library's words."""
    return dataclasses.replace(context, skills=dataclasses.replace(context.skills, text="(see the schema)"))


def _build(form: PaperForm) -> ForceField:
    """The force field of a form as it was written; a ValueError says what the schema refuses."""
    raw: dict[str, Any] = form.model_dump(mode="json", exclude_none=True, exclude={"reason"})
    field = ForceField.model_validate(raw)
    if not (field.actions or field.constraints or field.default_drop):
        raise ValueError("nothing acts in this force field")
    return field


def _give_up(failed: Round, trace: Any) -> Reply[Rewrite]:
    told = "No answer of the model can be used."
    return Reply(Rewrite(force_field=failed.force_field, changes=(told,)), trace)
