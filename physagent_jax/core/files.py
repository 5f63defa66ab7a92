"""Writing files so that a reader never meets half of one."""

from __future__ import annotations

import contextlib
import os
import uuid
from collections.abc import Iterator
from pathlib import Path

from physagent_jax.core.errors import UserError


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yields a temporary name beside ``path``; renames it to ``path`` when the block succeeds.

    The name keeps the suffix (encoders choose their format by it) and the folder (a rename across file
    systems is not atomic). If the block fails, the temporary file goes and the old ``path`` stays.

    Raises:
        UserError: The folder cannot be made or written to.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.stem}.{uuid.uuid4().hex[:8]}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise UserError(
            f"cannot write {path}", got=error.strerror or error, do="Choose a folder that you may write to"
        ) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Writes UTF-8 text atomically."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def check_writable(folder: str | Path) -> None:
    """Refuses a folder that cannot be made or written to, before any work is done for it.

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
