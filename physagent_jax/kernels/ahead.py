"""Kernels compiled ahead: the first time on a machine, in processes of their own.

Numba compiles for ten seconds or two, on one core, and only once; while an object is loaded and XLA compiles the rest,
the other cores can do it. One process imports what all kernels need and forks into one per kernel. They are a session
of their own, which a Ctrl-C in the terminal does not reach, and end with the process that began them, however it ends.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from threading import Condition

from physagent_jax.core.once import call_in_forked, make_lock
from physagent_jax.kernels import import_kernels, use_cpu
from physagent_jax.kernels.threads import core_count

Targets = dict[str, tuple[str, ...]]
"""Kernels to compile: target -> (module, arguments of its `register_handler`); the longest first."""

_LOOK = 0.1  # seconds between two looks at whether a kernel is done
running: dict[str, subprocess.Popen[str]] = {}
_heard: set[subprocess.Popen[str]] = set()  # those to which some thread listens
_lock = make_lock(awaited=True)  # of `running` and `_heard`
_changed = Condition(_lock)


def start_compiling(targets: Targets) -> None:
    """Start compiling those of ``targets`` that the disk does not have; do nothing where kernels are not used."""
    if not use_cpu():
        return
    from physagent_jax.kernels import store  # needs Numba, without which there is nothing to do

    absent = {name: made for name, made in targets.items() if not store.is_stored(name)}
    with _changed:
        missing = {name: made for name, made in absent.items() if name not in running}
        if not missing:
            return
        script = f"from physagent_jax.kernels import ahead; ahead.compile_all({missing!r}, parent=0)"
        process = subprocess.Popen(
            [sys.executable, "-c", script],
            stdin=subprocess.PIPE,  # closed when this process ends
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,
        )
        running.update(dict.fromkeys(missing, process))


def compile_all(targets: Targets, parent: int | None = None) -> None:
    """Compile kernels into the store and print the names of those done, in a process that was started for it.

    Args:
        targets: As `start_compiling` has them.
        parent: A pipe that closes when whoever waits for the kernels is no more: then all processes of this one's
            session end. None = nobody's end matters.
    """
    at_work = 0
    for name, (module, *arguments) in targets.items():
        import_kernels(module)
        if not hasattr(os, "fork"):
            _compile(name, module, *arguments)
            continue
        if at_work == core_count():
            _wait_for_one(parent)
            at_work -= 1
        at_work += 1
        if os.fork() == 0:
            _compile(name, module, *arguments)
            os._exit(0)
    for _ in range(at_work):
        _wait_for_one(parent)


def _wait_for_one(parent: int | None) -> None:
    """Return when a forked process has ended."""
    while parent is not None and os.waitpid(-1, os.WNOHANG)[0] == 0:
        if select.select([parent], [], [], _LOOK)[0] and not os.read(parent, 1):
            os.killpg(0, signal.SIGKILL)
    if parent is None:
        os.wait()


def _compile(name: str, module: str, *arguments: str) -> None:
    import_kernels(module).register_handler(*arguments)
    print(name, flush=True)


def wait_for(name: str) -> None:
    """Return when nobody is compiling ``name``; whoever failed has left it to the caller."""
    with _changed:
        while (process := running.get(name)) is not None:
            if process in _heard:
                _changed.wait()
            else:
                _listen(process)


def _listen(process: subprocess.Popen[str]) -> None:
    """Notes the next kernel that a process has compiled, or that it has ended; others are free to ask meanwhile."""
    _heard.add(process)
    _changed.release()
    try:
        done = process.stdout.readline().strip() if process.stdout else ""
    finally:
        _changed.acquire()
        _heard.discard(process)
        _changed.notify_all()
    ended = [each for each in running if running[each] is process]
    for each in [done] if done else ended:
        running.pop(each, None)
    if process not in running.values():
        process.communicate()


def _forget() -> None:
    """Let a forked process know of no others: they are its parent's, and end when nobody holds their pipes open."""
    global _changed
    nowhere = os.open(os.devnull, os.O_RDWR)
    for process in set(running.values()):
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                os.dup2(nowhere, pipe.fileno())
    os.close(nowhere)
    running.clear()
    _heard.clear()
    _changed = Condition(_lock)  # without the parent's threads that wait


call_in_forked(_forget)
