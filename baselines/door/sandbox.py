"""`python sandbox.py FD HIDDEN ... -- WRITABLE ...`: the door's program, with files kept from it for good.

Landlock is Linux's sandbox for unprivileged programs (since 5.13; docs.kernel.org/userspace-api/landlock.html). It
allows and does not deny: what is allowed is all that lies beside the hidden paths. A process in it cannot trace or read
one outside, so that the memory of its parent is closed too. It holds for one thread and what that starts: so it is set
by a program that has no others, and imports nothing. Where there is none, a hook stops Python's own ways to open files.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import struct
import sys
from collections.abc import Collection, Iterable
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446  # the same system calls on every architecture
_VERSION, _NO_NEW_PRIVILEGES, _PATH_BENEATH = 1, 38, 1
_WRITE_FILE, _READ_FILE, _REMOVE, _MAKE, _TRUNCATE = 1 << 1, 1 << 2, 0b11 << 4, 0b1111111 << 6, 1 << 14
_OF_FILES = _WRITE_FILE | _READ_FILE | _TRUNCATE


def list_hidden(paths: Iterable[Path]) -> set[Path]:
    """The paths without links, and the histories of the checkouts that they lie in."""
    hidden = {Path(os.path.realpath(path)) for path in paths}
    return hidden | {up / ".git" for path in hidden for up in path.parents if (up / ".git").exists()}


def hide_by_hook(hidden: Collection[Path], folders: Collection[Path]) -> None:
    """Refuse by Python itself to open ``hidden``, to write outside ``folders``, and to start programs."""

    def is_below(path: str, tops: Collection[Path]) -> bool:
        real = Path(os.path.realpath(path))
        return any(real == top or top in real.parents for top in tops)

    def refuse(event: str, arguments: tuple) -> None:
        if event in ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork"):
            raise PermissionError("a method may start no program")
        if event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
            path, flags = os.fsdecode(arguments[0]), arguments[2] or 0
            writes = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
            if is_below(path, hidden) or writes and not is_below(path, folders):
                raise PermissionError(f"a method may not open {path}")

    sys.addaudithook(refuse)


def list_beside(top: Path, hidden: Collection[Path]) -> list[Path]:
    """The largest files and folders below ``top`` that hold nothing hidden; links are left out."""
    if top in hidden:
        return []
    if not any(top in path.parents for path in hidden):
        return [top]
    found = []
    with contextlib.suppress(OSError), os.scandir(top) as entries:
        for entry in entries:
            if not entry.is_symlink():
                found += list_beside(Path(entry.path), hidden)
    return found


def restrict(hidden: Collection[Path], folders: Collection[Path]) -> bool:
    """Restrict this process by Landlock; False where the kernel has none."""
    if sys.platform != "linux":
        return False
    call = ctypes.CDLL(None, use_errno=True).syscall
    version = call(_CREATE, None, ctypes.c_size_t(0), _VERSION)
    if version < 1:
        return False
    handled = _WRITE_FILE | _READ_FILE | _REMOVE | _MAKE | (_TRUNCATE if version >= 3 else 0)
    rules = call(_CREATE, struct.pack("Q", handled), ctypes.c_size_t(8), 0)
    if rules < 0:
        return False
    for path, access in (
        *((path, _READ_FILE) for path in list_beside(Path("/"), hidden)),
        *((path, handled) for path in folders),
    ):
        with contextlib.suppress(OSError):  # gone since, or not ours
            file = os.open(path, os.O_PATH | os.O_CLOEXEC)
            allowed = access if path.is_dir() else access & _OF_FILES
            call(_ADD, rules, _PATH_BENEATH, struct.pack("=Qi", allowed, file), 0)
            os.close(file)
    ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    restricted = call(_RESTRICT, rules, 0) == 0
    os.close(rules)
    return restricted


def main(arguments: list[str]) -> None:
    """Restrict this process, and become the door's program."""
    connection, *paths = arguments
    cut = paths.index("--")
    hidden, folders = (
        list_hidden(map(Path, paths[:cut])),
        [Path(os.path.realpath(p)) for p in paths[cut + 1 :]],
    )
    folders.append(Path("/dev"))
    kept = ["landlock"] if restrict(hidden, folders) else [*map(str, hidden), "--", *map(str, folders)]
    os.execv(sys.executable, [sys.executable, "-m", "baselines.door.inside", connection, *kept])


if __name__ == "__main__":
    main(sys.argv[1:])
