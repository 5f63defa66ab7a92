"""Many cases, in processes that may die without harm."""

from __future__ import annotations

import collections
import dataclasses
import json
import multiprocessing
import os
import resource
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from tests.conftest import compile_as_tests_do
from tests.fuzz.classes import named, shares
from tests.fuzz.contract import STARVED, Fault, Outcome, Result, check

COLUMNS = ("accepted", "refused", *(str(fault) for fault in Fault))
CHUNK = 40  # cases that a worker is handed at a time
RENEWED = 1500  # cases after which a worker is replaced: compiled programs add up
MERCY = 60.0  # [s] beyond a case's own limit until its process is killed


@dataclasses.dataclass
class Tally:
    """The outcomes of the cases.

    Attributes:
        seed: Seed of the campaign.
        counts: Cases by class and column.
        failures: One entry per failed case.
        slowest: Seconds and name of the slowest case by class [s].
        seconds: Wall time by class [s].
    """

    seed: int
    counts: dict[str, collections.Counter] = dataclasses.field(
        default_factory=lambda: collections.defaultdict(collections.Counter)
    )
    failures: list[dict] = dataclasses.field(default_factory=list)
    slowest: dict[str, tuple[float, str]] = dataclasses.field(default_factory=dict)
    seconds: collections.Counter = dataclasses.field(default_factory=collections.Counter)

    def add(self, name: str, index: int, what: str, result: Result) -> None:
        """Counts one case."""
        self.counts[name][result.column] += 1
        self.seconds[name] += result.seconds
        if result.seconds > self.slowest.get(name, (0.0, ""))[0]:
            self.slowest[name] = (round(result.seconds, 2), what)
        if result.outcome is Outcome.FAILED:
            self.failures.append(
                {"class": name, "index": index, "fault": str(result.fault), "what": what, "detail": result.detail,
                 "place": result.place, "seconds": round(result.seconds, 2), "again": again(name, self.seed, index)}
            )  # fmt: skip

    def table(self) -> str:
        """Counts as text, and the distinct failures."""
        used = [c for c in COLUMNS if any(counter[c] for counter in self.counts.values())]
        rows = [["class", "cases", *used, "seconds"]]
        for name, counter in self.counts.items():
            cells = (str(counter[c] or "") for c in used)
            rows.append([name, str(counter.total()), *cells, f"{self.seconds[name]:.1f}"])
        whole = sum(self.counts.values(), collections.Counter())
        rows.append(
            ["all", str(whole.total()), *(str(whole[c]) for c in used), f"{sum(self.seconds.values()):.1f}"]
        )
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = [
            "  ".join(cell.rjust(w) if i else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths)))
            for row in rows
        ]
        for (name, fault, place, kind), found in self.distinct().items():
            first = min(found, key=lambda failure: len(failure["what"]))
            lines += [f"\n{name}: {fault} x{len(found)} {kind} at {place or '-'}", f"  {first['detail'][:300]}",
            f"  input: {first['what'][:300]}",
                      f"  {first['again']}"]  # fmt: skip
        return "\n".join(lines)

    def distinct(self) -> dict[tuple[str, str, str, str], list[dict]]:
        """Failures of the same fault at the same place."""
        groups: dict[tuple[str, str, str, str], list[dict]] = collections.defaultdict(list)
        for failure in self.failures:
            kind = failure["detail"].split(":")[0][:60] if failure["place"] else failure["detail"][:60]
            groups[failure["class"], failure["fault"], failure["place"], kind].append(failure)
        return dict(sorted(groups.items()))

    def json(self) -> str:
        """All of it as JSON."""
        value = {"seed": self.seed, "counts": {n: dict(c) for n, c in self.counts.items()}, "slowest": self.slowest,
                 "seconds": {n: round(s, 2) for n, s in self.seconds.items()}, "failures": self.failures}  # fmt: skip
        return json.dumps(value, indent=1, ensure_ascii=True)


def again(name: str, seed: int, index: int) -> str:
    """The command that repeats a case."""
    return f"python -m tests.fuzz --only {name} --seed {seed} --index {index}"


def examine(name: str, seed: int, index: int) -> tuple[str, Result]:
    """Make a case and run it in a folder of its own; what it is, and what became of it."""
    each = named(name)
    each.warm_up()
    case = each.case(seed, index)
    with tempfile.TemporaryDirectory(prefix="fuzz-", ignore_cleanup_errors=True) as folder:
        return case.what, check(case, Path(folder))


def show(name: str, seed: int, index: int) -> int:
    """Print one case: its input, what became of it, the traceback if there is one. Returns the exit code."""
    case = named(name).case(seed, index)
    print(f"{name} {index}: {case.what}")
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    for file, content in case.files.items():
        begin = content[:200].hex() if 0 in content[:200] else repr(content[:400])
        print(f"  {folder / file} ({len(content)} bytes): {begin}")

    def act(place: Path) -> Any:
        try:
            return case.act(place)
        except BaseException:
            traceback.print_exc()
            raise

    result = check(dataclasses.replace(case, act=act), folder)
    print(f"{result.column}: {result.detail} {result.place} ({result.seconds:.2f} s)")
    return int(result.outcome is Outcome.FAILED)


# --- in processes --------------------------------------------------------------------------------------


def run(names: list[str], cases: int, seed: int, jobs: int) -> Tally:
    """All cases of the classes, ``jobs`` processes at the same time."""
    tally, lock = Tally(seed), threading.Lock()
    chunks = collections.deque(_split_chunks(shares(cases, names)))
    for name in names:  # in this order in the table
        tally.counts[name] = collections.Counter()
    total, begun = sum(len(indices) for _, indices in chunks), time.monotonic()
    done = 0

    def serve() -> None:
        nonlocal done
        with Examiner() as examiner:
            while True:
                with lock:
                    if not chunks:
                        return
                    name, indices = chunks.popleft()
                for index in indices:
                    what, result = examiner.examine(name, seed, index)
                    with lock:
                        tally.add(name, index, what, result)
                        done += 1
                        if done % 200 == 0:
                            so_far = f"{done} of {total} cases, {len(tally.failures)} failed"
                            print(f"{so_far}, {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        for served in [pool.submit(serve) for _ in range(jobs)]:
            served.result()
    tally.failures.sort(key=lambda failure: (failure["class"], failure["index"]))
    return tally


def _split_chunks(wanted: dict[str, int]) -> Iterator[tuple[str, range]]:
    for name, count in wanted.items():
        for start in range(0, count, CHUNK):
            yield name, range(start, min(start + CHUNK, count))


class Examiner:
    """Examines cases in a process of its own, and in another one where that has been its end."""

    def __init__(self):
        self._worker: _Worker | None = None

    def __enter__(self) -> Examiner:
        return self

    def __exit__(self, *_) -> None:
        if self._worker is not None:
            self._worker.end()

    def examine(self, name: str, seed: int, index: int) -> tuple[str, Result]:
        """A case and its outcome, whatever became of the process."""
        if self._worker is not None and self._worker.served >= RENEWED:
            self._worker.end()
            self._worker = None
        self._worker = self._worker or _Worker()
        what, result = self._worker.examine(name, seed, index)
        if self._worker.dead:
            self._worker = None
        return what, result


class _Worker:
    """A process that examines cases one by one, until one of them is its end."""

    def __init__(self):
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self.served, self.dead = 0, False

    def examine(self, name: str, seed: int, index: int) -> tuple[str, Result]:
        """The outcome of a case, whatever became of the process."""
        self.served += 1
        begun = time.monotonic()
        case = named(name).case(seed, index)
        try:
            self._pipe.send((name, seed, index))
            if self._pipe.poll(STARVED * case.seconds + MERCY):
                return self._pipe.recv()
            result = Result(Outcome.FAILED, Fault.HANG, "native code that no signal stops")
        except (EOFError, OSError):
            self._process.join(10)
            code = self._process.exitcode
            fault = Fault.HANG if code == 1 else Fault.TRACEBACK  # 1: faulthandler's end of patience
            result = Result(Outcome.FAILED, fault, f"the process died (exit code {code})")
        self.end()
        self.dead = True
        return case.what, dataclasses.replace(result, seconds=time.monotonic() - begun)

    def end(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join(0.2)
        if self._process.is_alive():
            self._process.kill()
        self._process.join()


def _serve(pipe: Connection) -> None:
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    compile_as_tests_do()
    while True:
        try:
            name, seed, index = pipe.recv()
        except EOFError:
            return
        pipe.send(examine(name, seed, index))
