"""The store of compiled kernels between processes.

Each kernel has a folder of its own: the files that Numba writes, and a seal with their digests. It is filled elsewhere
and renamed, so that nobody finds half of one, and is read only if the seal holds: Numba itself would run whatever code
a damaged file has, or fail. Then the folder goes, and the kernel is compiled again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
from numba.core import sigutils
from numba.core.ccallback import CFunc
from numba.core.compiler_lock import global_compiler_lock

from physagent_jax.core.once import once
from physagent_jax.kernels.folders import describe_processor, make_private_folder

log = logging.getLogger(__name__)
_SEAL = "seal.json"


def is_stored(target: str) -> bool:
    """Return whether a target has been compiled from these sources on this machine."""
    return _is_sealed(find_folder() / target)


def load_or_compile(target: str, signature, function):
    """The C function that Numba makes of ``function``: from the disk, or compiled and kept."""
    place = find_folder() / target
    if place.exists() and not _is_sealed(place):
        log.warning("%s is damaged: %s is compiled again", place, target)
        _remove(place)
    if place.exists():
        try:
            return _compile_in(place, signature, function)
        except Exception as error:  # whatever Numba and LLVM make of code that is not theirs
            log.warning("%s cannot be read (%s): %s is compiled again", place, type(error).__name__, target)
            _remove(place)
    try:
        filled = Path(tempfile.mkdtemp(prefix=f".{target}.", dir=find_folder()))
    except OSError:  # a full disk costs a compilation each time, nothing else
        return _compile_in(None, signature, function)
    try:
        made = _compile_in(filled, signature, function)
        with contextlib.suppress(OSError):  # whoever was first has the same
            seal(filled)
            filled.rename(place)
        return made
    except OSError:
        return _compile_in(None, signature, function)
    finally:
        shutil.rmtree(filled, ignore_errors=True)


def _compile_in(folder: Path | None, signature, function):
    """`numba.cfunc`, with its files in ``folder``; None = it is compiled for this process alone."""
    made = CFunc(function, sigutils.normalize_signature(signature), locals={}, options={})
    if folder is not None:
        with _keep_numba_in(folder):
            made.enable_caching()
    made.compile()
    return made


@contextlib.contextmanager
def _keep_numba_in(folder: Path) -> Iterator[None]:
    """Let Numba look for the files of what is decorated within in ``folder``: a setting of the whole process."""
    config: Any = numba.config  # type: ignore[attr-defined]
    with global_compiler_lock:
        before = config.CACHE_DIR
        config.CACHE_DIR = str(folder)
        try:
            yield
        finally:
            config.CACHE_DIR = before


def seal(folder: Path) -> None:
    """Notes the digests of a folder's files, as the last thing that is written into it."""
    (folder / _SEAL).write_text(json.dumps(_compute_digests(folder)))


def _is_sealed(folder: Path) -> bool:
    """Return whether all files of a folder are as they were written."""
    try:
        return json.loads((folder / _SEAL).read_bytes()) == _compute_digests(folder)
    except (OSError, ValueError, RecursionError):
        return False


def _compute_digests(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*.nb?") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _remove(folder: Path) -> None:
    """Take a folder away at once, whoever else is about to read it."""
    with contextlib.suppress(OSError):
        away = Path(tempfile.mkdtemp(prefix=".old.", dir=folder.parent))
        folder.rename(away / folder.name)
        shutil.rmtree(away, ignore_errors=True)


@once
def find_folder() -> Path:
    """A folder that belongs to exactly these sources, where they lie, and this processor.

    Numba's own cache notices a changed file by its time, but not that a function calls one from another file that
    has changed: it would go on running old code.
    """
    digest = hashlib.sha256(f"{numba.__version__} {describe_processor()}".encode())
    for source in sorted(Path(__file__).parents[1].glob("**/kernels/*.py")):
        digest.update(f"{source} {source.stat().st_mtime_ns}".encode() + source.read_bytes())
    asked = os.environ.get("NUMBA_CACHE_DIR")
    return make_private_folder("kernels", digest.hexdigest()[:16], base=Path(asked) if asked else None)
