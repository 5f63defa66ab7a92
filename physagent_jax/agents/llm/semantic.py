"""Semantic agents that ask a chat model: alone, or beside the grammar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.llm.base import ChatModel, ModelError
from physagent_jax.agents.llm.disagreement import find_disagreements
from physagent_jax.agents.llm.fields import PaperForm, build_field, expect_motions
from physagent_jax.agents.llm.forms import (
    SETTINGS,
    ClauseForm,
    SentenceForm,
    check_words,
    join_clauses,
    list_motions,
    make_intent,
)
from physagent_jax.agents.llm.scene_words import describe_scene
from physagent_jax.agents.llm.splitting import split_clauses
from physagent_jax.agents.llm.structured import ask
from physagent_jax.agents.llm.templates import list_rows, quote, write_messages
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import AgentError, Reply, Trace
from physagent_jax.core.errors import UserError

Form = Literal["clauses", "by-clause", "paper"]
FORMS: tuple[Form, ...] = get_args(Form)
MOST_CHARACTERS = 4000
"""Length of a sentence that is sent to a model, at most."""


class NoMotion(UserError):
    """A model finds no motion in a sentence, or none that can be compiled."""


class ModelSemanticAgent(SemanticAgent):
    """Reads with a chat model; if no answer of it fits the form, the grammar reads instead, and says so.

    Args:
        model: The model.
        form: "clauses" = words, one request for the sentence; "by-clause" = words, one request per clause, for small
            models; "paper" = the paper's force field with its vectors.
    """

    def __init__(self, model: ChatModel, form: Form = "clauses"):
        self._model = model
        self._form: Form = check_form(form)

    @property
    def name(self) -> str:
        """The model and the form: another of either is another run."""
        return f"model({self._model.name}, {self._form})"

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence; see `protocols.SemanticAgent`."""
        try:
            return read_with_model(self._model, context, self._form)
        except AgentError as error:
            if not has_bad_answers(error):
                raise
            why = f"No answer of {self._model.name} fits the form: the grammar has read the sentence instead."
            trace = error.trace.model_copy(update=dict(repairs=(*error.trace.repairs, why)))
        try:
            reply = GrammarSemanticAgent().compile(context).value
        except UserError as error:
            what = f"{why} {error.what}"
            raise AgentError(what, trace=trace, got=error.got, do=error.do) from error
        return Reply(reply.model_copy(update=dict(notes=(why, *reply.notes))), trace)


class BothReaders(SemanticAgent):
    """Reads with the grammar, whose reading stands, and lets a model's reading doubt it.

    Where they disagree about what moves, which way or which part, no motion is called a success.

    Args:
        model: The model.
        form: As for `ModelSemanticAgent`.
    """

    def __init__(self, model: ChatModel, form: Form = "clauses"):
        self._model = model
        self._form: Form = check_form(form)

    @property
    def name(self) -> str:
        """The grammar, the model and the form."""
        return f"both(grammar, {self._model.name}, {self._form})"

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence twice; see `protocols.SemanticAgent`. What the grammar refuses stays refused."""
        reading = GrammarSemanticAgent().compile(context).value
        try:
            second = read_with_model(self._model, context, self._form)
        except AgentError as error:
            if isinstance(error.__cause__, NoMotion):
                doubt = f"Grammar and model disagree: {self._model.name} finds no motion in the sentence."
                return Reply(_doubt(reading, [doubt]), error.trace)
            if not has_bad_answers(error):
                raise
            why = f"No answer of {self._model.name} fits the form: it has no say about this reading."
            trace = error.trace.model_copy(update=dict(repairs=(*error.trace.repairs, why)))
            return Reply(reading.model_copy(update=dict(notes=(*reading.notes, why))), trace)
        doubts = find_disagreements(reading, second.value, self._model.name, context.brief)
        if not doubts:
            agreed = f"{self._model.name} reads the same motions, directions and parts."
            return Reply(reading.model_copy(update=dict(notes=(*reading.notes, agreed))), second.trace)
        return Reply(_doubt(reading, doubts), second.trace)


def check_form(form: str) -> Form:
    """``form``, if there is such a form.

    Raises:
        UserError: There is none.
    """
    for each in FORMS:
        if each == form:
            return each
    raise UserError("there is no such form of a reading", got=form, do=f"Choose one of {', '.join(FORMS)}")


def has_bad_answers(error: AgentError) -> bool:
    """Return whether a model answered and no answer could be used: a server that is away is another matter."""
    return not isinstance(error.__cause__, ModelError | NoMotion)


def read_with_model(model: ChatModel, context: AgentContext, form: Form) -> Reply[SemanticReply]:
    """A model's reading alone.

    Raises:
        AgentError: The model gives no answer (its cause is a `ModelError`), none that fits, or finds no motion (its
            cause is a `NoMotion`).
        UserError: The sentence is empty or too long to be sent.
    """
    _check_length(context)
    if form == "paper":
        return _read_field(model, context)
    asked = _ask_by_clause(model, context) if form == "by-clause" else _ask_whole(model, context)
    try:
        if not asked.value.clauses and asked.value.held is None and asked.value.surroundings.gravity is None:
            raise NoMotion(
                f"{model.name} finds no motion in the sentence",
                do="Say what should happen to the object, or read with the grammar",
            )
        reply = _compile(asked.value, context)
    except NoMotion as error:
        raise AgentError(error.what, trace=asked.trace, got=error.got, do=error.do) from error
    note = f"Read by {model.name}, {form}."
    return Reply(reply.model_copy(update=dict(notes=(note, *reply.notes))), asked.trace)


def _compile(intent: Intent, context: AgentContext) -> SemanticReply:
    try:
        return compile_intent(intent, context.brief)
    except UserError as error:
        raise NoMotion(error.what, got=error.got, do=error.do) from error


def _check_length(context: AgentContext) -> None:
    prompt = context.prompt.strip()
    if not prompt:
        raise UserError("The prompt is empty", do="Say what should happen to the object")
    if len(prompt) > MOST_CHARACTERS:
        raise UserError(
            f"The prompt is longer than the {MOST_CHARACTERS:,} characters that are sent to a model",
            got=f"{len(prompt):,}",
            do="Say in a sentence or two what should happen",
        )


def _ask_whole(model: ChatModel, context: AgentContext) -> Reply[Intent]:
    values = {**_list_choices(), **describe_scene(context.brief), "sentence": quote(context.prompt)}
    messages = write_messages("semantic", values)
    answer = ask(
        model,
        messages,
        SentenceForm,
        validate=lambda form: check_words(form, context.prompt),
        state_schema=False,
    )
    return Reply(make_intent(answer.value), answer.trace)


def _ask_by_clause(model: ChatModel, context: AgentContext) -> Reply[Intent]:
    pieces = split_clauses(context.prompt)
    forms: list[ClauseForm] = []
    trace, before = Trace(), ""
    for piece in pieces:
        values = {**_list_choices(), "clause": quote(piece.text), "before": before}
        try:
            answer = ask(model, write_messages("semantic_clause", values), ClauseForm, state_schema=False)
        except AgentError as error:
            whole = join_traces([trace, error.trace])
            raise AgentError(error.what, trace=whole, got=error.got, do=error.do) from error.__cause__
        forms.append(answer.value)
        trace = join_traces([trace, answer.trace])
        before = f"The clause before: {quote(piece.text)}\n"
    intent = join_clauses(forms, [piece.text for piece in pieces], [piece.order for piece in pieces])
    return Reply(intent, trace)


def _read_field(model: ChatModel, context: AgentContext) -> Reply[SemanticReply]:
    values = {
        **describe_scene(context.brief),
        "skills": context.skills.text,
        "sentence": quote(context.prompt),
    }
    answer = ask(model, write_messages("semantic_paper", values), PaperForm)
    field, repairs = build_field(answer.value, context.brief)
    mended = tuple(f"Hard rule {each.rule}: {each.why}." for each in repairs)
    trace = answer.trace.model_copy(update=dict(repairs=(*answer.trace.repairs, *mended)))
    if not field.actions and not field.default_drop:
        what = f"{model.name} writes a force field in which nothing acts"
        error = NoMotion(what, do="Say what should happen to the object, or read with the grammar")
        raise AgentError(what, trace=trace, do=error.do) from error
    notes = (
        f"Read by {model.name}, paper.",
        "What should be seen is taken from its force field, not from the sentence.",
    )
    reply = SemanticReply(
        force_field=field, expectations=expect_motions(field, context.brief), notes=(*notes, *mended)
    )
    return Reply(reply, trace)


def _list_choices() -> dict[str, str]:
    return {"motions": list_rows(list_motions()), "settings": ", ".join(SETTINGS)}


def _doubt(reading: SemanticReply, doubts: Sequence[str]) -> SemanticReply:
    return reading.model_copy(update=dict(unsure=(*reading.unsure, *doubts)))


def join_traces(traces: Sequence[Trace]) -> Trace:
    """Several exchanges for one answer as one trace, in their order."""
    whole = Trace()
    for each in traces:
        raw = "\n".join(filter(None, (whole.raw_reply, each.raw_reply)))
        whole = whole.followed_by(each).model_copy(update=dict(raw_reply=raw))
    return whole
