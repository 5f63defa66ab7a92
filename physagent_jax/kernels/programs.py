"""The programs that XLA has compiled: kept on disk between processes, bounded within one."""

from __future__ import annotations

import contextlib
import logging
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jax
from jax._src import compilation_cache, lru_cache
from jax._src.core import trace_state_clean

from physagent_jax.core.files import write_bytes
from physagent_jax.core.once import make_lock

log = logging.getLogger(__name__)

SHARE = 0.45
"""Share of its allowed memory mappings that a process may use before compiled programs are released.

One simulation adds thousands at most; so many are some 30,000, at which a process holds about 2 GB of programs.
"""
_ALLOWED = 65_530  # Linux's default
_MAPS, _LIMIT = Path("/proc/self/maps"), Path("/proc/sys/vm/max_map_count")
LOOK = 16  # programs compiled between two looks: counting mappings takes some 20 ms
_MISMATCH = re.compile(rb"[^\n]*cpu_aot_loader[^\n]*Target machine feature \+([\w.-]+) is not[^\n]*\n")
_TUNING = (b"prefer-", b"fast-")  # how to generate code, not which instructions a processor has

compiled_count = looked_at = 0
_REPLACED = "replaced"  # attribute: JAX's own function in place of which one of ours is called
_lock = make_lock()  # for counts, and for what replaces JAX's functions
_redirecting = make_lock(
    awaited=True
)  # stderr: a process forked meanwhile would write into a file that is gone


def release_programs(mappings: int | None = None) -> bool:
    """Let all compiled programs go if this process uses many memory mappings; return whether it did.

    Every program takes some, and a process that has used up those that Linux grants dies. JAX keeps what it has
    compiled, in caches of which none can be told to give up what was used least recently: all go at once, and what is
    needed again is compiled again, or read from disk. Nothing is done while something is traced.

    Args:
        mappings: How many are too many; None = `SHARE` of what a process may have.
    """
    global looked_at
    if not trace_state_clean() or (mappings is None and compiled_count - looked_at < LOOK):
        return False
    with _lock:
        looked_at = compiled_count
    if count_mappings() <= (SHARE * count_granted() if mappings is None else mappings):
        return False
    log.info("compiled programs are let go: they take too many memory mappings")
    jax.clear_caches()
    return True


def count_mappings() -> int:
    """Memory mappings of this process; 0 where there is no limit to be known."""
    return _MAPS.read_bytes().count(b"\n") if _MAPS.is_file() else 0


def count_granted() -> int:
    """Memory mappings that the system lets a process have."""
    try:
        return int(_LIMIT.read_text())
    except (OSError, ValueError):
        return _ALLOWED


def _count(event: str, duration_secs: float, **_) -> None:
    del duration_secs
    global compiled_count
    if event == "/jax/core/compile/backend_compile_duration":
        with _lock:
            compiled_count += 1


jax.monitoring.register_event_duration_secs_listener(_count)


def keep_on_disk(folder: Path) -> None:
    """Let JAX keep compiled programs in ``folder``; what cannot be read there is deleted and compiled again.

    JAX itself keeps a damaged file for ever: it warns, compiles, and leaves the file as it is.
    """
    config: Any = jax.config  # its flags are not typed
    config.update("jax_compilation_cache_dir", str(folder))
    config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
    with _lock:
        compilation_cache.get_executable_and_time = _guard(compilation_cache.get_executable_and_time, folder)
        lru_cache.LRUCache.put = _write_at_once(lru_cache.LRUCache.put)


def _guard(read: Any, folder: Path) -> Callable:
    """JAX's ``read``, which answers with what is whole and made for this machine."""
    read = getattr(read, _REPLACED, read)

    def guarded(key: str, *arguments):
        path = folder / f"{key}-cache"
        if not path.is_file():
            return None, None
        try:
            with compare_machine() as foreign:
                program = read(key, *arguments)
        except Exception as error:  # JAX, too, goes on from here whatever it is
            why = f"cannot be read ({type(error).__name__})"
        else:
            if not foreign:
                return program
            why = f"was made for a processor with {foreign[0]}"
        log.warning("%s %s: it is compiled again", path, why)
        with contextlib.suppress(OSError):
            path.unlink()
        return None, None

    setattr(guarded, _REPLACED, read)
    return guarded


def _write_at_once(write: Any) -> Callable:
    """JAX's ``write``, which makes each file elsewhere and renames it: other processes may be reading the folder."""
    write = getattr(write, _REPLACED, write)

    def put(cache: Any, key: str, value: bytes) -> None:
        path = Path(cache.path) / f"{key}-cache"
        if cache.eviction_enabled or "://" in str(cache.path):
            write(cache, key, value)
        elif not path.exists():
            write_bytes(path, value)

    setattr(put, _REPLACED, write)
    return put


@contextlib.contextmanager
def compare_machine() -> Iterator[list[str]]:
    """Yield which features of the processor a program that is read within needs and this one lacks.

    XLA compares the machine that a program was compiled for with this one, and writes a line of 2 KB to stderr for
    each feature that differs. On machines with AVX-512 two always do: XLA adds "prefer-no-gather" and
    "prefer-no-scatter" when it compiles, which tell LLVM how to generate code, and asks the processor for them when it
    reads. Later versions leave such features out (openxla/xla#44565); until then these lines are left out here,
    as no option of XLA makes the two descriptions equal but that which forbids AVX-512. All else that is written
    meanwhile is passed on.
    """
    foreign: list[str] = []
    with _redirecting:
        try:
            stderr = os.dup(2)
        except OSError:  # there is none
            yield foreign
            return
        with tempfile.TemporaryFile() as written:
            sys.stderr.flush() if sys.stderr else None
            os.dup2(written.fileno(), 2)
            try:
                yield foreign
            finally:
                os.dup2(stderr, 2)
                os.close(stderr)
                written.seek(0)
                text = written.read()
                features = _MISMATCH.findall(text)
                foreign.extend(each.decode() for each in features if not each.startswith(_TUNING))
                if rest := _MISMATCH.sub(b"", text):
                    with contextlib.suppress(OSError):
                        os.write(2, rest)
