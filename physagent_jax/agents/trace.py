"""The path to an agent's answer, and its cost. Empty for rules, which exchange no messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from physagent_jax.core.errors import UserError
from physagent_jax.core.strict import Count, NonNegative, Strict

Value = TypeVar("Value")


class Message(Strict):
    """One message of the exchange with a chat model.

    Attributes:
        role: Who speaks.
        text: What is said.
        pictures: How many pictures went with it; the pictures themselves are those of the round.
    """

    role: Literal["system", "user", "assistant"]
    text: str
    pictures: Count = 0


class Trace(Strict):
    """One call of an agent.

    Attributes:
        model: Identifier of the model that answered, as its provider reports it; empty for rules.
        messages: The exchange in order, replies that were refused and the model's second thoughts included.
        raw_reply: The text that the answer was read from, as it came.
        validation_errors: Why earlier replies of this call were refused, one each.
        repairs: What was changed in the reply so that it could be used, a sentence each.
        input_tokens, output_tokens: Tokens of all messages of this call, as the provider counts them.
        latency_seconds: Waited for the model [s].
    """

    model: str = ""
    messages: tuple[Message, ...] = ()
    raw_reply: str = ""
    validation_errors: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    input_tokens: Count = 0
    output_tokens: Count = 0
    latency_seconds: NonNegative = 0.0

    @property
    def is_empty(self) -> bool:
        """Return whether no model took part."""
        return self == Trace()

    def followed_by(self, later: Trace) -> Trace:
        """This call and a later one of the same agent as one: the later answer, and the cost of both."""
        cost = ("input_tokens", "output_tokens", "latency_seconds")
        both = ("messages", "validation_errors", "repairs", *cost)
        summed = {name: getattr(self, name) + getattr(later, name) for name in both}
        return later.model_copy(update={"model": later.model or self.model, **summed})


@dataclass(frozen=True)
class Reply(Generic[Value]):
    """An agent's answer.

    Attributes:
        value: The answer.
        trace: How it came about.
    """

    value: Value
    trace: Trace = Trace()


class FailedCall(Strict):
    """A call of an agent that gave no answer.

    Attributes:
        error: Why.
        trace: What was tried, and what that cost.
    """

    error: str
    trace: Trace


class AgentError(UserError):
    """An agent has no answer, after whatever it tried to repair; the run keeps what was tried and ends.

    Args:
        what: What is wrong.
        trace: The exchange until then, refused replies and tokens included.
        got: The offending value, if showing it helps.
        do: What to do about it; the loop adds that the same command asks again.
    """

    def __init__(self, what: str, *, trace: Trace, got: object = None, do: str = ""):
        super().__init__(what, got=got, do=do)
        self.trace = trace
