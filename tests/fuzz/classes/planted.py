"""Faults of every kind, made on purpose: what the fuzzing itself is tested with (`--only planted`)."""

from __future__ import annotations

import os
import signal
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from tests.fuzz.contract import BYSTANDER, Breach, Case, Fault
from tests.fuzz.drawing import Draw


class Multiline(UserError):
    """A refusal that does not fit on a line."""

    def __str__(self) -> str:
        return "one\ntwo"


def _raise(error: BaseException) -> None:
    raise error


def _loop(folder: Path) -> None:
    while True:
        time.sleep(0.01)


def _loop_and_swallow(folder: Path) -> None:
    while True:
        try:
            while True:
                time.sleep(0.01)
        except Exception:  # what a careless product does
            pass


def _ignore_signals(folder: Path) -> None:
    """No signal ends it."""
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    _loop(folder)


def _hoard(folder: Path) -> Any:
    return [np.zeros(2**27) for _ in range(64)]


def _recurse(folder: Path) -> None:
    _recurse(folder)


def _warn(folder: Path) -> None:
    warnings.warn_explicit("overflow", RuntimeWarning, "/x/physagent_jax/somewhere.py", 3)


def _make_writer(name: str, content: bytes) -> Callable[[Path], Any]:
    return lambda folder: (folder / name).write_bytes(content)


# What is planted, how it must be counted, and the case.
PLANTED: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("nothing", "accepted", {"act": lambda folder: {"x": [1.0, np.ones(3)]}}),
    ("a window without end", "accepted", {"act": lambda folder: {"end": 1.0}}),
    ("a refusal", "refused", {"act": lambda folder: _raise(UserError("no", got=1, do="Say yes"))}),
    ("an exception", "traceback", {"act": lambda folder: {}["missing"]}),
    ("an exit", "traceback", {"act": lambda folder: _raise(SystemExit(1))}),
    ("deep recursion", "traceback", {"act": _recurse}),
    ("a hang", "hang", {"act": _loop, "seconds": 0.2}),
    ("a hang that swallows exceptions", "hang", {"act": _loop_and_swallow, "seconds": 0.2}),
    ("too much memory", "memory", {"act": _hoard}),
    ("NaN in an array", "nonfinite", {"act": lambda folder: {"x": [np.array([1.0, np.nan])]}}),
    ("infinity in a number", "nonfinite", {"act": lambda folder: (1.0, {"a": float("inf")})}),
    ("a lost file", "lost", {"act": lambda folder: (folder / BYSTANDER).unlink()}),
    ("a changed file", "lost", {"act": _make_writer(BYSTANDER, b"mine now"), "own": ("out",)}),
    ("a changed input", "lost", {"act": _make_writer("in.json", b"{}"), "files": {"in.json": b"[]"}}),
    ("a stray file", "litter", {"act": _make_writer("stray", b""), "own": ("out",)}),
    ("a temporary file", "litter", {"act": _make_writer("out/.x.1234.json", b"{}"), "files": {"out/a": b""},
    "own": ("out",)}),
    ("half a JSON", "litter", {"act": _make_writer("out.json", b'{"a": '), "own": ("out.json",)}),
    ("half a video", "litter", {"act": _make_writer("out.mp4", b"\0\0\0\x18ftypmp42"), "own": ("out.mp4",)}),
    ("litter of a refusal", "litter", {"act": lambda folder: _raise(_leave_litter(folder)), "own": ()}),
    ("nonsense accepted", "silent", {"act": lambda folder: None, "must_refuse": "nonsense"}),
    ("a wrong result", "silent", {"act": lambda folder: _raise(Breach(Fault.SILENT, "2 + 2 = 5"))}),
    ("a refusal in two lines", "wording", {"act": lambda folder: _raise(Multiline("x"))}),
    ("a warning of NumPy", "noise", {"act": _warn}),
)  # fmt: skip
# Those that end the process, which only processes of their own survive.
DEADLY: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("a crash", "traceback", {"act": lambda folder: os.abort()}),
    ("a process killed", "traceback", {"act": lambda folder: os.kill(os.getpid(), signal.SIGKILL)}),
    ("a hang that no signal ends", "hang", {"act": _ignore_signals, "seconds": 0.2}),
)


def _leave_litter(folder: Path) -> UserError:
    (folder / "begun.txt").write_text("half")
    return UserError("no")


def make(draw: Draw) -> Case:
    """The planted fault of that number."""
    index = int(draw.key.rsplit("/", 1)[-1])
    kinds = (*PLANTED, *DEADLY)
    what, _, case = kinds[index % len(kinds)]
    return Case(what, **case)
