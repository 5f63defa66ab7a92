"""Holding a folder, so that two processes never write into it at the same time."""

from __future__ import annotations

import contextlib
import os
import warnings
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import check_writable, explain_write_error, make_folders

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


class FolderLock:
    """A folder held by this process until `release` or its end, however that comes; nothing is written for it.

    The folder is made if it is not there; what was made goes again at the release if it has stayed empty.

    Raises:
        UserError: Another process holds it, or it cannot be made or written to.
    """

    def __init__(self, folder: str | Path):
        self._folder = Path(folder)
        check_writable(self._folder)
        self._made = _make(self._folder)
        try:
            self._handle = _hold(self._folder)
        except BaseException:
            self._remove_empty()
            raise

    def release(self) -> None:
        """Let the folder go; may be called again."""
        if self._handle is not None:
            self._remove_empty()
            os.close(self._handle)
            self._handle = None

    def _remove_empty(self) -> None:
        with contextlib.suppress(OSError):  # not empty, or gone
            for folder in reversed(self._made):
                folder.rmdir()


def _make(folder: Path) -> list[Path]:
    """Make a folder and its parents; return those that were not there, outermost first."""
    try:
        return make_folders(folder)
    except OSError as error:
        raise explain_write_error(folder, error) from error


def _hold(folder: Path) -> int | None:
    """A handle that keeps others out until it is closed."""
    if fcntl is None:
        return None  # Windows has no lock on folders
    while True:
        try:
            handle = os.open(folder, os.O_RDONLY)
        except OSError as error:
            raise explain_write_error(folder, error) from error
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(handle), os.stat(folder)):
                return handle
        except BlockingIOError:
            os.close(handle)
            raise UserError(
                f"another process is writing to {folder} at this moment",
                do="Wait until it is done, or choose another --out",
            ) from None
        except FileNotFoundError:
            pass  # whoever made the folder has taken it away again
        except OSError as error:
            warnings.warn(
                f"{folder} cannot be locked ({error.strerror}): start one run at a time", stacklevel=4
            )
            return handle
        os.close(handle)
        _make(folder)
