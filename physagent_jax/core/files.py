"""Writing files so that a reader never meets half of one, and nothing is lost that somebody else made."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import stat
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path

from physagent_jax.core.errors import UserError

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_MOST_FOLDERS = 64
_MARK = "[0-9a-f]{8}"  # tells temporary names from those of users


@contextlib.contextmanager
def replace_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary name beside ``path``, and rename it to ``path`` when the block succeeds.

    The name keeps the suffix (encoders choose their format by it) and the folder (a rename across file
    systems is not atomic). If the block fails, the temporary file goes and the old ``path`` stays; if the
    process is killed, the temporary file stays until `remove_leftovers`.

    Raises:
        UserError: The folder cannot be made or written to, or ``path`` is a link, a folder, a device or a pipe.
    """
    path = Path(path)
    _check_replaceable(path)
    temporary = path.with_name(f".{path.stem}.{uuid.uuid4().hex[:8]}{path.suffix}")
    try:
        make_folders(path.parent)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise explain_write_error(path, error) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _check_replaceable(path: Path) -> None:
    """Refuse what a rename would take the place of and no file can stand for; root may even rename over /dev/null."""
    try:
        mode = path.lstat().st_mode
    except OSError:
        return  # nothing is there, or whoever writes is told why not
    if not stat.S_ISREG(mode):
        kind = "a link" if stat.S_ISLNK(mode) else "a folder, a device or a pipe"
        raise UserError(f"cannot write {path}", got=kind, do="Name a regular file")


def make_folders(folder: Path) -> list[Path]:
    """Make a folder and its parents; return those that were not there, outermost first.

    Raises:
        UserError: They are more than `_MOST_FOLDERS`: a mistake, which would be hard to clear away.
        OSError: The system refuses.
    """
    missing, place = [], folder
    while not place.exists():
        missing.insert(0, place)
        place = place.parent
        if len(missing) > _MOST_FOLDERS:
            raise UserError(
                f"cannot write to {folder.as_posix()[:80]}...: more than {_MOST_FOLDERS} folders would have to be made",
                do="Choose a shorter path",
            )
    for place in missing:
        place.mkdir(exist_ok=True)
    return missing


def explain_write_error(path: str | Path, error: OSError) -> UserError:
    """Explain an operating system's refusal to write ``path``."""
    if error.errno in _FULL:
        remedy = "Make room and give the same command again"
    else:
        remedy = "Choose a place that you may write to"
    return UserError(f"cannot write {path}", got=error.strerror or error, do=remedy)


def find_leftovers(path: str | Path) -> list[Path]:
    """Files that `replace_file` left beside ``path`` when a process was killed, if nobody is writing it now."""
    path = Path(path)
    pattern = re.compile(re.escape(f".{path.stem}.") + _MARK + re.escape(path.suffix))
    try:
        return [path.parent / name for name in os.listdir(path.parent) if pattern.fullmatch(name)]
    except (FileNotFoundError, NotADirectoryError):
        return []


def remove_leftovers(path: str | Path) -> None:
    """Remove `find_leftovers`."""
    for leftover in find_leftovers(path):
        leftover.unlink(missing_ok=True)


def link_or_copy(source: Path, target: Path) -> None:
    """Give a file a second name, so that its bytes are kept once; a copy where the file system has no hard links.

    What `replace_file` writes to one of the names later leaves the other as it is.
    """
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text atomically."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write a file atomically."""
    with replace_file(path) as temporary:
        temporary.write_bytes(content)


def write_new(contents: Mapping[Path, bytes], *, overwrite: bool) -> None:
    """Write files, but none of them if one would replace a file that holds something else, unless told to.

    Raises:
        UserError: There is such a file, or one cannot be written.
    """
    for path, content in contents.items():
        _check_replaceable(path)
        if not overwrite and os.path.lexists(path) and not _has_content(path, content):
            raise UserError(
                f"{path} exists and holds something else",
                do="Choose another --out, or pass --overwrite to replace it",
            )
    for path, content in contents.items():
        write_bytes(path, content)


def _has_content(path: Path, content: bytes) -> bool:
    try:
        return path.is_file() and path.stat().st_size == len(content) and path.read_bytes() == content
    except OSError:
        return False  # it cannot be told


def check_writable(folder: str | Path) -> None:
    """Refuse a folder that cannot be made or written to, before any work is done for it.

    Raises:
        UserError: ``folder`` is a file, or it or its nearest existing parent is read-only.
    """
    folder = Path(folder)
    existing = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not existing.is_dir():
        raise UserError(f"cannot write to {folder}", got=f"{existing} is a file", do="Choose another --out")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise UserError(
            f"cannot write to {folder}", got=f"{existing} is read-only", do="Choose another --out"
        )
