"""A server that answers badly in every way there is: a look at each kind, and proof that the checks can fail."""

import dataclasses
import socket
import threading
from pathlib import Path

import pytest

pytest.importorskip("openai", reason="the extra `llm` is not installed")

from benchmarks.agents.adversarial import measure_kind
from benchmarks.agents.markdown import condense, write_tables
from benchmarks.agents.replies import KEY, list_kinds
from benchmarks.agents.roles import ROLES
from benchmarks.agents.server import complete
from physagent_jax.agents.trace import AgentError, Reply

KINDS = list_kinds()
FAST = [kind for kind in KINDS if not kind.slow]
BY_NAME = {kind.name: kind for kind in KINDS}


def test_there_are_many_kinds():
    assert len(BY_NAME) == len(KINDS) >= 100


@pytest.mark.parametrize("start", range(4))
def test_replies_end_as_they_have_to(start):
    """Every fourth kind, each for another agent."""
    rows = [measure_kind(kind, ROLES[place % len(ROLES)], 0) for place, kind in enumerate(FAST[start::4])]
    assert len(rows) > 25
    assert [(row["kind"], row["breaches"]) for row in rows if not row["good"]] == []
    assert {row["ending"] for row in rows} == {"answered", "refused", "failed"}


def test_rows_become_tables():
    rows = [measure_kind(BY_NAME[name], ROLES[1], 0) for name in ("right", "empty")]
    section = {"runs": [], "complete": True, "rows": rows}
    text = write_tables(condense({"adversarial": section}))["adversarial"]
    assert "2 replies of 2 kinds; 2 of them end as they have to" in text
    assert "| answered | 1 | right |" in text and "| refused | 1 | empty |" in text


def spoil(kind, **changes):
    return measure_kind(dataclasses.replace(BY_NAME[kind], **changes), ROLES[1], 0)


def test_another_ending_is_a_breach():
    assert spoil("empty", ending="answered")["breaches"] == ["refused instead of answered"]


def test_a_key_that_gets_out_is_a_breach():
    def tell(model):
        reply = ROLES[1].ask(model)
        return Reply(reply.value, reply.trace.model_copy(update={"raw_reply": KEY}))

    row = measure_kind(BY_NAME["right"], dataclasses.replace(ROLES[1], ask=tell), 0)
    assert row["breaches"] == ["trace.json holds the key"]

    def fail(model):
        try:
            return ROLES[1].ask(model)
        except AgentError as error:
            raise AgentError(f"wrong: {KEY}", trace=error.trace) from None

    row = measure_kind(BY_NAME["403"], dataclasses.replace(ROLES[1], ask=fail), 0)
    assert set(row["breaches"]) == {"error.txt holds the key", "the error tells the key"}


def test_a_lost_exchange_and_a_followed_order_are_breaches():
    def lose(model):
        reply = ROLES[1].ask(model)
        return Reply(reply.value, reply.trace.model_copy(update={"validation_errors": ()}))

    row = measure_kind(BY_NAME["500 once"], dataclasses.replace(ROLES[1], ask=lose), 0)
    assert row["breaches"] == ["the trace does not account for 2 requests"]

    def follow(draw):
        open(draw.trap, "w").close()
        return [complete(draw.text)]

    assert spoil("right", script=follow)["breaches"] == ["an order of the reply was followed"]


def test_what_stays_open_is_a_breach():
    kept = []

    def leave(model):
        kept.append(socket.socket())
        return ROLES[1].ask(model)

    row = measure_kind(BY_NAME["right"], dataclasses.replace(ROLES[1], ask=leave), 0)
    kept.pop().close()
    assert row["breaches"] == (["sockets left"] if Path("/proc/self/fd").is_dir() else [])

    done = threading.Event()

    def start(model):
        threading.Thread(target=done.wait).start()
        return ROLES[1].ask(model)

    row = measure_kind(BY_NAME["right"], dataclasses.replace(ROLES[1], ask=start), 0)
    done.set()
    assert row["breaches"] == ["threads left"]
