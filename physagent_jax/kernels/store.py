"""Where compiled kernels are kept from one process to the next."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba


@contextmanager
def kept() -> Iterator[None]:
    """Lets Numba keep what is decorated within in a folder that belongs to exactly these sources.

    Numba's own cache notices a changed file, but not that a function calls one from another file that has changed:
    it would go on running old code.
    """
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(_folder())  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


def has(target: str) -> bool:
    """Whether a target has been compiled from these sources on this machine."""
    return (_folder() / f"{target}.compiled").is_file()


def note(target: str) -> None:
    """Remembers that a target has been compiled."""
    (_folder() / f"{target}.compiled").touch()


@cache
def _folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parents[1].glob("**/kernels/*.py")):
        digest.update(source.read_bytes())
    asked = os.environ.get("NUMBA_CACHE_DIR")
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "physagent_jax"
    for base in (Path(asked) if asked else user, Path(tempfile.gettempdir()) / "physagent_jax"):
        folder = base / "kernels" / digest.hexdigest()[:16]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return Path(tempfile.mkdtemp(prefix="physagent-kernels-"))
