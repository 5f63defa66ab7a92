"""Semantic agents that ask a chat model: alone, or beside the grammar."""

from __future__ import annotations

from typing import Literal, get_args

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.llm.fields import PaperForm, build_field, expect_motions
from physagent_jax.agents.llm.forms import ClauseForm, SentenceForm, check_words, join_clauses, make_intent
from physagent_jax.agents.llm.prompt import describe_motion, quote, write_messages
from physagent_jax.agents.llm.splitting import split_clauses
from physagent_jax.agents.llm.structured import BadAnswers, add_repairs, ask
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import AgentError, Reply, Trace
from physagent_jax.chat.base import ChatModel
from physagent_jax.core.errors import UserError
from physagent_jax.motion.judging.comparing import name_direction
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import cosine

Form = Literal["clauses", "by-clause", "paper"]
FORMS: tuple[Form, ...] = get_args(Form)
MOST_CHARACTERS = 4000
"""Length of a sentence that is sent to a model, at most."""
_ALIKE = 0.9  # cosine of directions that are called the same
_LINES = (MotionKind.STRETCH, MotionKind.SQUEEZE, MotionKind.SWAY)  # either sense is the same
_SAY_MORE = "Say what should happen to the object, or read with the grammar"


class NoMotion(AgentError):
    """A model finds no motion in a sentence, or none that can be compiled."""


class ModelSemanticAgent(GrammarSemanticAgent):
    """Reads with a chat model; if no answer of it fits the form, the grammar reads instead, and says so.

    Args:
        model: The model.
        form: "clauses" = words, one request for the sentence; "by-clause" = words, one request per clause, for small
            models; "paper" = the paper's force field with its vectors.
    """

    def __init__(self, model: ChatModel, form: Form = "clauses"):
        if form not in FORMS:
            raise UserError(
                "there is no such form of a reading", got=form, do=f"Choose one of {', '.join(FORMS)}"
            )
        self._model: ChatModel = model
        self._form: Form = form

    @property
    def name(self) -> str:
        """The model and the form: another of either is another run."""
        return f"model({self._model.name}, {self._form})"

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence; see `protocols.SemanticAgent`."""
        try:
            return read_with_model(self._model, context, self._form)
        except BadAnswers as error:
            why = f"No answer of {self._model.name} fits the form: the grammar has read the sentence instead."
            trace = add_repairs(error.trace, why)
        try:
            reply = super().compile(context).value
        except UserError as error:
            raise AgentError(f"{why} {error.what}", trace=trace, got=error.got, do=error.do) from error
        return Reply(reply.model_copy(update=dict(notes=(why, *reply.notes))), trace)


class BothReaders(ModelSemanticAgent):
    """Reads with the grammar, whose reading stands, and lets a model's reading doubt it.

    Where they disagree about what moves, which way or which part, no motion is called a success.
    """

    @property
    def name(self) -> str:
        """The grammar, the model and the form."""
        return f"both(grammar, {self._model.name}, {self._form})"

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence twice; see `protocols.SemanticAgent`. What the grammar refuses stays refused."""
        reading, who = GrammarSemanticAgent.compile(self, context).value, self._model.name
        doubts, notes = [], []
        try:
            second = read_with_model(self._model, context, self._form)
            trace = second.trace
            doubts = find_disagreements(reading, second.value, who, context.brief)
            if not doubts:
                notes = [f"{who} reads the same motions, directions and parts."]
        except NoMotion as error:
            trace = error.trace
            doubts = [f"Grammar and model disagree: {who} finds no motion in the sentence."]
        except BadAnswers as error:
            notes = [f"No answer of {who} fits the form: it has no say about this reading."]
            trace = add_repairs(error.trace, *notes)
        told = dict(unsure=(*reading.unsure, *doubts), notes=(*reading.notes, *notes))
        return Reply(reading.model_copy(update=told), trace)


def read_with_model(model: ChatModel, context: AgentContext, form: Form) -> Reply[SemanticReply]:
    """A model's reading alone.

    Raises:
        AgentError: The model gives no answer, none that fits (`BadAnswers`), or finds no motion (`NoMotion`).
        UserError: The sentence is empty or too long to be sent.
    """
    prompt = context.prompt.strip()
    if not prompt:
        raise UserError("The prompt is empty", do="Say what should happen to the object")
    if len(prompt) > MOST_CHARACTERS:
        raise UserError(
            f"The prompt is longer than the {MOST_CHARACTERS:,} characters that are sent to a model",
            got=f"{len(prompt):,}",
            do="Say in a sentence or two what should happen",
        )
    if form == "paper":
        return _read_field(model, context)
    asked = _ask_by_clause(model, context) if form == "by-clause" else _ask_whole(model, context)
    intent, trace = asked.value, asked.trace
    if not intent.clauses and intent.held is None and intent.surroundings.gravity is None:
        raise NoMotion(f"{model.name} finds no motion in the sentence", trace=trace, do=_SAY_MORE)
    try:
        reply = compile_intent(intent, context.brief)
    except UserError as error:
        raise NoMotion(error.what, trace=trace, got=error.got, do=error.do) from error
    note = f"Read by {model.name}, {form}."
    return Reply(reply.model_copy(update=dict(notes=(note, *reply.notes))), trace)


def _ask_whole(model: ChatModel, context: AgentContext) -> Reply[Intent]:
    def check(form: SentenceForm) -> None:
        check_words(form, context.prompt)

    messages = write_messages("semantic", context)
    answer = ask(model, messages, SentenceForm, validate=check, state_schema=False)
    return Reply(make_intent(answer.value), answer.trace)


def _ask_by_clause(model: ChatModel, context: AgentContext) -> Reply[Intent]:
    pieces = split_clauses(context.prompt)
    forms: list[ClauseForm] = []
    trace, before = Trace(), ""
    for piece in pieces:
        clause = quote(piece.text)
        messages = write_messages("semantic_clause", context, clause=clause, before=before)
        try:
            answer = ask(model, messages, ClauseForm, state_schema=False)
        except AgentError as error:
            error.trace = _join(trace, error.trace)
            raise
        forms.append(answer.value)
        trace, before = _join(trace, answer.trace), f"The clause before: {clause}\n"
    intent = join_clauses(forms, [piece.text for piece in pieces], [piece.order for piece in pieces])
    return Reply(intent, trace)


def _join(trace: Trace, later: Trace) -> Trace:
    """Two exchanges for one answer as one trace, with both replies."""
    raw = "\n".join(filter(None, (trace.raw_reply, later.raw_reply)))
    return trace.followed_by(later).model_copy(update=dict(raw_reply=raw))


def _read_field(model: ChatModel, context: AgentContext) -> Reply[SemanticReply]:
    answer = ask(model, write_messages("semantic_paper", context), PaperForm)
    field, repairs = build_field(answer.value, context.brief)
    mended = tuple(f"Hard rule {each.rule}: {each.why}." for each in repairs)
    trace = add_repairs(answer.trace, *mended)
    if not field.actions and not field.default_drop:
        what = f"{model.name} writes a force field in which nothing acts"
        raise NoMotion(what, trace=trace, do=_SAY_MORE)
    notes = (
        f"Read by {model.name}, paper.",
        "What should be seen is taken from its force field, not from the sentence.",
        *mended,
    )
    expectations = expect_motions(field, context.brief)
    return Reply(SemanticReply(force_field=field, expectations=expectations, notes=notes), trace)


def find_disagreements(
    reading: SemanticReply, second: SemanticReply, reader: str, brief: SceneBrief
) -> list[str]:
    """Doubts about ``reading``, a sentence each, where ``second`` says another motion, direction or part.

    Strengths, amounts and times are left to the first: a small difference there is none that a viewer would see.
    """

    def doubt(what: str, mine: str, theirs: str) -> str:
        return f"Grammar and model disagree on the {what}: {mine}; {reader} reads {theirs}."

    mine, theirs = (sorted(each.expectations, key=lambda motion: motion.window) for each in (reading, second))
    if [motion.kind for motion in mine] != [motion.kind for motion in theirs]:
        said = [", then ".join(describe_motion(each, brief) for each in side) for side in (mine, theirs)]
        return [doubt("motion", said[0] or "nothing", said[1] or "nothing")]
    doubts = []
    for one, other in zip(mine, theirs):
        if not _go_the_same_way(one, other):
            doubts.append(doubt("direction", describe_motion(one, brief), describe_motion(other, brief)))
        if not _act_on_the_same_part(one, other):
            doubts.append(doubt("part", _describe_part(one, brief), _describe_part(other, brief)))
    return doubts


def _go_the_same_way(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    if one.direction is None or other.direction is None:
        return one.direction is other.direction
    alike = cosine(one.direction, other.direction)
    return (abs(alike) if one.kind in _LINES else alike) > _ALIKE


def _act_on_the_same_part(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    if one.part is None or other.part is None:
        return one.part is other.part and one.partial == other.partial
    return cosine(one.part, other.part) > _ALIKE and one.excludes_part == other.excludes_part


def _describe_part(motion: ExpectedMotion, brief: SceneBrief) -> str:
    if motion.part is None:
        return "a part of it" if motion.partial else "the whole object"
    but = "all but " if motion.excludes_part else ""
    return f"{but}the {name_direction(motion.part, brief.directions)} end"
