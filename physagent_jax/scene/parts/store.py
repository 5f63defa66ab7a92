"""The parts that were found before, on disk: finding them takes seconds, and each command asks for them again.

Entries are told by what they were found in, bit by bit, and by the code that found them. They hold data alone; one
that cannot be read is found again.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, ParamSpec

import numpy as np
import scipy
from pydantic import TypeAdapter, ValidationError

from physagent_jax import forces
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_bytes
from physagent_jax.core.once import once
from physagent_jax.forces.part import Part
from physagent_jax.kernels.folders import make_private_folder

MOST_ENTRIES = 400  # entries; the oldest go
_PARTS = TypeAdapter(tuple[Part, ...])
_Arguments = ParamSpec("_Arguments")


def keep(find: Callable[_Arguments, tuple[Part, ...]]) -> Callable[_Arguments, tuple[Part, ...]]:
    """A function as it is, which reads from the disk what it has found before for equal arguments.

    Args:
        find: It depends on its arguments alone: arrays, strings, numbers, dataclasses and sequences of these.
    """

    @functools.wraps(find)
    def load_or_find(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> tuple[Part, ...]:
        digest = hashlib.sha256(f"{find.__module__}.{find.__qualname__} {digest_sources()}".encode())
        for each in (args, sorted(kwargs.items())):
            digest.update(b"".join(_list_bytes(each)))
        file = _make_folder(os.environ.get("XDG_CACHE_HOME")) / f"{digest.hexdigest()}.json"
        with contextlib.suppress(OSError, ValidationError):
            found = _PARTS.validate_json(file.read_bytes())
            os.utime(file)
            return found
        found = find(*args, **kwargs)
        with contextlib.suppress(OSError, UserError):  # a full disk costs a search each time, nothing else
            _write(file, _PARTS.dump_json(found))
        return found

    return load_or_find


def _list_bytes(value: Any) -> Iterable[bytes]:
    """The bytes that tell a value from others."""
    if dataclasses.is_dataclass(value):
        value = [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, (list, tuple)):
        yield f"{len(value)} of".encode()
        for each in value:
            yield from _list_bytes(each)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    else:
        yield f"{value!r}\n".encode()


def _write(file: Path, data: bytes) -> None:
    """Write an entry as a whole, and remove the oldest of too many."""
    write_bytes(file, data)
    entries = sorted(file.parent.glob("*.json"), key=lambda each: each.stat().st_mtime)
    for old in entries[:-MOST_ENTRIES]:
        old.unlink(missing_ok=True)


@once
def _make_folder(base: str | None) -> Path:
    """The folder of entries, made once for each place that the environment names."""
    del base  # `make_private_folder` reads it
    return make_private_folder("parts")


@once
def digest_sources() -> str:
    """A digest of all code that finds parts."""
    digest = hashlib.sha256(f"{np.__version__} {scipy.__version__}".encode())
    for folder in (Path(__file__).parent, Path(forces.__file__).parent):
        for source in sorted(path for path in folder.iterdir() if path.suffix in (".py", ".yaml")):
            digest.update(source.read_bytes())
    return digest.hexdigest()
