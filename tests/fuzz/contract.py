"""The contract of every case: accepted and finite, or refused in one line; bounded; nothing lost.

A `Case` lays files into a folder of its own, does one thing with the product there and says which names the product
may write. `check` runs it and gives a `Result`; whatever breaks the contract is a `Fault`, with the place in the code.
"""

from __future__ import annotations

import contextlib
import dataclasses
import enum
import faulthandler
import hashlib
import json
import os
import resource
import signal
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError

MEMORY = 4 * 2**30  # [bytes] of address space that one case may take, in arrays, stacks and mappings
RESIDENT = 1.5 * 2**30  # [bytes] by which one case may raise the process's peak
STARVED = 8  # times a case's limit that it may take while other programs have the processor
PATIENCE = 20.0  # [s] beyond a case's limit until code that no signal stops ends the process
BYSTANDER = "somebody-elses.txt"


class Fault(enum.StrEnum):
    """Ways of breaking the contract."""

    TRACEBACK = "traceback"  # an exception that is no refusal
    HANG = "hang"  # no end within the limit
    MEMORY = "memory"  # more than `MEMORY` or `RESIDENT`
    NONFINITE = "nonfinite"  # accepted, with a number that is none
    LOST = "lost"  # a file changed or gone that was not the command's own
    LITTER = "litter"  # half-written, temporary or unannounced files
    SILENT = "silent"  # nonsense accepted, or a result that says other than what it did
    WORDING = "wording"  # refused, but not in one line
    NOISE = "noise"  # a RuntimeWarning of NumPy from the product's own code


class Outcome(enum.StrEnum):
    """The end of a case."""

    ACCEPTED = "accepted"
    REFUSED = "refused"
    FAILED = "failed"


class Breach(Exception):
    """Raised by a case that sees the contract broken."""

    def __init__(self, fault: Fault, detail: str):
        super().__init__(f"{fault}: {detail}")
        self.fault, self.detail = fault, detail


class Overtime(BaseException):
    """The limit has passed; not an `Exception`, so that no handler of the product takes it for its own."""


@dataclasses.dataclass(frozen=True)
class Case:
    """One input.

    Attributes:
        what: What is special about it, in a line.
        act: Does it, in the case's folder; returns whatever must be finite. Raises one of ``refusals`` to refuse.
        files: What lies in the folder before, by name.
        prepare: Lays what is no plain file, before anything is looked at.
        own: Names that the product may make or change; folders with all that is in them.
        refusals: Exceptions that count as a refusal.
        must_refuse: Why accepting it would be an error in silence; "" = it may be accepted.
        seconds: The limit [s], of processor time.
    """

    what: str
    act: Callable[[Path], Any]
    files: Mapping[str, bytes] = dataclasses.field(default_factory=dict)
    prepare: Callable[[Path], None] | None = None
    own: tuple[str, ...] = ()
    refusals: tuple[type[BaseException], ...] = (UserError,)
    must_refuse: str = ""
    seconds: float = 20.0  # many times what is usual: machines are busy


@dataclasses.dataclass(frozen=True)
class Result:
    """The outcome of a case.

    Attributes:
        outcome: How it ended.
        fault: What is wrong; None unless failed.
        detail: The refusal, or the fault in words.
        place: Innermost line of the product, "file:line function"; "" where there is none.
        seconds: Wall time [s].
    """

    outcome: Outcome
    fault: Fault | None = None
    detail: str = ""
    place: str = ""
    seconds: float = 0.0

    @property
    def column(self) -> str:
        """The column that counts it: "accepted", "refused" or the name of the fault."""
        return str(self.fault or self.outcome)


def check(case: Case, folder: Path) -> Result:
    """Run ``case`` in ``folder``, which must be empty, and hold it to the contract."""
    for name, content in {**case.files, BYSTANDER: b"not yours\n"}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    if case.prepare:
        case.prepare(folder)
    begun, resident = time.perf_counter(), _read_peak()
    result = _act(case, folder)
    if result.fault is None and _read_peak() - resident > RESIDENT:
        result = _fail(Fault.MEMORY, f"the process grew by {(_read_peak() - resident) / 2**30:.1f} GiB")
    return dataclasses.replace(result, seconds=time.perf_counter() - begun)


def _act(case: Case, folder: Path) -> Result:
    before: dict[str, str] = {}
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            before = snapshot(folder)
            with limited(case.seconds):
                value = case.act(folder)
        result = Result(Outcome.ACCEPTED)
        fault = not_finite(value)
        if fault:
            result = _fail(Fault.NONFINITE, fault)
        elif case.must_refuse:
            result = _fail(Fault.SILENT, f"accepted: {case.must_refuse}")
    except case.refusals as error:
        result = _judge_refusal(error)
    except Breach as error:
        result = _fail(error.fault, error.detail, _find_place(error))
    except Overtime as error:
        result = _fail(Fault.HANG, f"no end after {case.seconds:g} s", _find_place(error))
    except MemoryError as error:
        result = _fail(Fault.MEMORY, f"MemoryError: {_shorten(error)}", _find_place(error))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever it is, it is what a user would see as a traceback
        result = _fail(Fault.TRACEBACK, f"{type(error).__name__}: {_shorten(error)}", _find_place(error))
    if result.fault is None:
        result = _find_file_fault(before, folder, case.own) or result
    if result.fault is None:
        result = _find_noise(caught) or result
    return result


def _judge_refusal(error: BaseException) -> Result:
    text = str(error)
    if isinstance(error, UserError) and len(text.splitlines()) != 1:
        return _fail(Fault.WORDING, f"a refusal of {len(text.splitlines())} lines: {text[:200]!r}")
    return Result(Outcome.REFUSED, detail=text)


def _fail(fault: Fault, detail: str, place: str = "") -> Result:
    return Result(Outcome.FAILED, fault, detail, place)


def _find_noise(caught: list[warnings.WarningMessage]) -> Result | None:
    for warning in caught:
        if issubclass(warning.category, RuntimeWarning) and "physagent_jax" in warning.filename:
            place = f"{_shorten_path(warning.filename)}:{warning.lineno}"
            return _fail(Fault.NOISE, f"{warning.category.__name__}: {warning.message}", place)
    return None


# --- limits --------------------------------------------------------------------------------------------


@contextlib.contextmanager
def limited(seconds: float, memory: int = MEMORY) -> Iterator[None]:
    """End the block with `Overtime` after ``seconds`` and with MemoryError beyond ``memory`` more bytes.

    Where other programs leave this process less of a processor, it has up to `STARVED` times as long. Python
    code is stopped by a signal. Native code that does not come back ends the process, with a traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        raise RuntimeError("cases run in the main thread: signals end those that hang")

    began, used = time.perf_counter(), time.process_time()

    def stop(signum, frame):
        if time.process_time() - used > seconds or time.perf_counter() - began > STARVED * seconds:
            raise Overtime

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() + memory
    earlier = signal.signal(signal.SIGALRM, stop)
    faulthandler.dump_traceback_later(STARVED * seconds + PATIENCE, exit=True)
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))
    signal.setitimer(signal.ITIMER_REAL, seconds, 0.5)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        faulthandler.cancel_dump_traceback_later()
        signal.signal(signal.SIGALRM, earlier)


def _read_peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


# --- values --------------------------------------------------------------------------------------------


def not_finite(value: Any, place: str = "") -> str:
    """The place in ``value`` of a number that is not finite; "" if nowhere. Any schemas, containers, arrays.

    What is called ``end`` may be infinite: a window that never closes.
    """
    where = place or "the result"
    if isinstance(value, float):
        return "" if np.isfinite(value) else f"{where} is {value}"
    if value is None or isinstance(value, (str, bytes, bool, int, enum.Enum, Path)):
        return ""
    if isinstance(value, Mapping):
        parts = [(f"{place}[{key!r}]", part) for key, part in value.items()]
    elif isinstance(value, (tuple, list)):
        parts = [(f"{place}[{index}]", part) for index, part in enumerate(value)]
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = [(f"{place}.{f.name}", getattr(value, f.name)) for f in dataclasses.fields(value)]
    elif hasattr(value, "model_dump"):
        return not_finite(value.model_dump(), place or type(value).__name__)
    elif hasattr(value, "dtype") and hasattr(value, "shape"):
        array = np.asarray(value)
        if not np.issubdtype(array.dtype, np.inexact) or np.isfinite(array).all():
            return ""
        if place.endswith(".end") and not np.isnan(array).any():
            return ""
        return f"{where} has {np.sum(~np.isfinite(array))} of {array.size} numbers that are not finite"
    else:
        return ""
    for at, part in parts:
        if found := not_finite(part, at):
            return found
    return ""


# --- files ---------------------------------------------------------------------------------------------


def snapshot(folder: Path) -> dict[str, str]:
    """The contents of ``folder``: a hash, a link's target or a kind, by relative name."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(root, name)
            found[os.path.relpath(path, folder)] = _take_fingerprint(path)
    return found


def _take_fingerprint(path: Path) -> str:
    if path.is_symlink():
        return f"link to {os.readlink(path)}"
    if path.is_dir():
        return "folder"
    if not path.is_file():
        return "device or pipe"
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _find_file_fault(before: Mapping[str, str], folder: Path, own: tuple[str, ...]) -> Result | None:
    after = snapshot(folder)

    def is_own(name: str) -> bool:
        return any(name == mine or name.startswith(f"{mine}/") for mine in own)

    for name, print_ in before.items():
        if not is_own(name) and after.get(name) != print_:
            return _fail(Fault.LOST, f"{name} is {'changed' if name in after else 'gone'}")
    for name in sorted(after.keys() - before.keys()):
        if not is_own(name):
            return _fail(Fault.LITTER, f"{name} was left behind")
        if detail := half_written(folder / name):
            return _fail(Fault.LITTER, f"{name}: {detail}")
    return None


def half_written(path: Path) -> str:
    """The fault of a file that the product has left; "" if there is none."""
    if path.name.startswith(".") or path.suffix in (".tmp", ".part"):
        return "a temporary file"
    if path.is_symlink() or not path.is_file():
        return ""
    if path.suffix == ".json":
        try:
            json.loads(path.read_bytes())
        except ValueError as error:
            return f"no JSON ({error})"
    if path.suffix == ".mp4":
        import imageio.v3 as iio

        try:
            if len(iio.imread(path, plugin="pyav")) == 0:
                return "a video without pictures"
        except Exception as error:  # whatever the decoder meets
            return f"cannot be decoded ({_shorten(error)})"
    return ""


# --- words ---------------------------------------------------------------------------------------------


def _shorten_path(filename: str) -> str:
    return (
        filename[filename.rindex("physagent_jax") :] if "physagent_jax" in filename else Path(filename).name
    )


def _find_place(error: BaseException) -> str:
    """The innermost line of the product, and the innermost of all where that is another."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/physagent_jax/" in f.filename]
    shown = [*ours[-1:], *(frames[-1:] if frames and frames[-1] not in ours[-1:] else [])]
    return " <- ".join(f"{_shorten_path(f.filename)}:{f.lineno} {f.name}" for f in shown)


def _shorten(error: BaseException, length: int = 300) -> str:
    try:
        text = " ".join(str(error).split())
    except Exception:  # an exception whose text cannot be made
        text = "?"
    return text if len(text) <= length else f"{text[: length - 3]}..."
