"""One adversarial reply after another, sent to an agent over HTTP: what becomes of it, and what is left behind."""

from __future__ import annotations

import os
import random
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.agents.replies import KEY, Draw, Kind
from benchmarks.agents.roles import Role
from benchmarks.agents.server import ScriptedServer
from benchmarks.harness import Row
from physagent_jax.agents.llm.semantic import NoMotion
from physagent_jax.agents.trace import AgentError, Trace
from physagent_jax.chat.openai_client import OWN_KEY, OpenAIModel
from physagent_jax.chat.replay import Recorder

SEED = 40
TIMEOUT, SHORT_TIMEOUT = 20.0, 0.5  # of an attempt, and of one that is to run into it [s]
RETRIES = 2
LARGEST_TRACE = 1_000_000  # bytes of one call's trace
LONGEST_ERROR = 2_000  # characters
_INSTEAD = "No answer of "  # begins what agents say when the rules have answered instead


def measure_kind(kind: Kind, role: Role, variant: int) -> Row:
    """Send one reply to one agent; the row says what became of it and names every breach."""
    before = _count_left()
    with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, {OWN_KEY: KEY}):
        draw = Draw(role.right, random.Random(f"{SEED} {kind.name} {role.name} {variant}"), f"{folder}/trap")
        script = kind.script(draw)
        begun = time.perf_counter()
        with ScriptedServer(lambda _, number: script[min(number, len(script) - 1)]) as server:
            ending, text, trace, waited = _ask(kind, role, server, Path(folder))
        seconds = time.perf_counter() - begun
        breaches = [
            *_check_ending(kind, ending, text),
            *_check_trace(trace, ending, len(server.requests)),
            *_check_files(Path(folder), draw.trap),
        ]
        if KEY in text:
            breaches.append("the error tells the key")
    breaches += [f"{what} left" for what, count in _count_left().items() if count > before[what]]
    return {
        "kind": kind.name,
        "agent": role.name,
        "variant": variant,
        "ending": ending,
        "attempts": len(server.requests),
        "seconds": round(seconds, 3),
        "waited": round(waited, 1),
        "told": text[:300],
        "breaches": breaches,
        "good": not breaches,
    }


def _ask(kind: Kind, role: Role, server: ScriptedServer, folder: Path) -> tuple[str, str, Trace, float]:
    """The ending, the error's text, the trace, and the pauses that the client would have made [s]."""
    timeout = SHORT_TIMEOUT if kind.slow else TIMEOUT
    client = OpenAIModel(model="scripted", url=server.url, timeout=timeout, retries=RETRIES)
    pauses: list[float] = []
    client.sleep = pauses.append
    model = Recorder(client, folder / "cassette.jsonl")
    try:
        reply = role.ask(model)
        text = next((each for each in reply.trace.repairs if each.startswith(_INSTEAD)), "")
        ending, trace = "refused" if text else "answered", reply.trace
        _write(folder / "reply.json", reply.value)
    except AgentError as error:
        ending = "answered" if isinstance(error, NoMotion) else "failed"
        text, trace = str(error), error.trace
        (folder / "error.txt").write_text(text)
    finally:
        model.close()
    _write(folder / "trace.json", trace)
    return ending, text, trace, sum(pauses)


def _write(path: Path, value: Any) -> None:
    """Write an answer or a trace, which its schema must be able to read again."""
    path.write_text(value.model_dump_json())
    type(value).model_validate_json(path.read_text())


def _check_ending(kind: Kind, ending: str, text: str) -> Iterator[str]:
    if kind.ending is not None and ending != kind.ending:
        yield f"{ending} instead of {kind.ending}"
    if "\n" in text or len(text) > LONGEST_ERROR:
        yield "the error is more than a line"


def _check_trace(trace: Trace, ending: str, requests: int) -> Iterator[str]:
    """Every request has its answer or its failure in the trace."""
    answers = sum(message.role == "assistant" for message in trace.messages)
    used = ending == "answered"
    if answers + len(trace.validation_errors) - (answers - used) != requests:
        yield f"the trace does not account for {requests} requests"
    if len(trace.model_dump_json()) > LARGEST_TRACE:
        yield "the trace is too large"


def _check_files(folder: Path, trap: str) -> Iterator[str]:
    if Path(trap).exists():
        yield "an order of the reply was followed"
    for path in folder.rglob("*"):
        if path.is_file() and KEY.encode() in path.read_bytes():
            yield f"{path.name} holds the key"


def _count_left() -> dict[str, int]:
    """Threads and sockets of this process."""
    links = Path("/proc/self/fd")
    names = [_read_link(link) for link in links.iterdir()] if links.is_dir() else []
    return {"threads": threading.active_count(), "sockets": sum(name.startswith("socket:") for name in names)}


def _read_link(link: Path) -> str:
    try:
        return os.readlink(link)
    except OSError:  # the handle of the listing itself
        return ""
