"""The traces of the agents: messages, refusals, repairs, cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from physagent_jax.agents.trace import FailedCall, Message, Trace
from physagent_jax.report.formats import format_count, format_plural, format_seconds
from physagent_jax.report.layout import make_facts, make_fold, make_list
from physagent_jax.report.markup import Child, Markup, div, tag
from physagent_jax.run.refused import RefusedReading


def show_agent_traces(
    traces: Mapping[str, Trace | None], failed: Mapping[str, Sequence[FailedCall]]
) -> list[Markup]:
    """A fold for each agent that asked a model, and for each call without an answer; rules leave no trace and no fold.

    Args:
        traces: How the answers came about, by the agent's role.
        failed: Calls that gave no answer, by the agent's role.
    """
    folds = [
        make_fold(
            f"A call of the {role} that gave no answer",
            tag("p", call.error, class_="missing"),
            *_show_trace(call.trace),
        )
        for role, calls in failed.items()
        for call in calls
    ]
    for role, trace in traces.items():
        if trace is not None and not trace.is_empty:
            folds.append(make_fold(f"How the {role} came to it", *_show_trace(trace)))
    return folds


def show_refused_readings(readings: Sequence[RefusedReading]) -> list[Markup]:
    """A fold for each sentence that a model read for a run which was refused then."""
    return [
        make_fold(
            "A sentence that was read, and its run refused",
            tag("p", each.prompt),
            tag("p", each.error, class_="missing"),
            *_show_trace(each.trace),
        )
        for each in readings
    ]


def _show_trace(trace: Trace) -> list[Child]:
    rows = [
        ("model", trace.model) if trace.model else None,
        ("tokens", f"{format_count(trace.input_tokens)} in, {format_count(trace.output_tokens)} out"),
        ("waited", format_seconds(trace.latency_seconds)),
    ]
    return [
        make_facts(rows),
        make_list("Replies that were refused", trace.validation_errors),
        make_list("What was repaired", trace.repairs),
        _show_text("The reply as it came", trace.raw_reply) if trace.raw_reply else None,
        make_fold(format_plural(len(trace.messages), "message"), *map(_show_message, trace.messages))
        if trace.messages
        else None,
    ]


def _show_message(message: Message) -> Markup:
    pictures = f", with {format_plural(message.pictures, 'picture')}" if message.pictures else ""
    return _show_text(f"{message.role}{pictures}", message.text)


def _show_text(title: str, text: str) -> Markup:
    return div("json", tag("h3", title), tag("pre", text))
