"""Findings about objects, on disk: they take seconds, and each command asks for them again.

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
from typing import Annotated, Any, ParamSpec, TypeVar, get_type_hints

import numpy as np
import scipy
from pydantic import InstanceOf, PlainSerializer, TypeAdapter, ValidationError, WrapValidator

from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_bytes
from physagent_jax.core.once import once
from physagent_jax.kernels.folders import make_private_folder

MOST_BYTES = 64_000_000  # of entries; the oldest go
_Arguments = ParamSpec("_Arguments")
_Found = TypeVar("_Found")
_NUMBERS = TypeAdapter(list[float])

Numbers = Annotated[
    InstanceOf[np.ndarray],
    PlainSerializer(np.ndarray.tolist),
    WrapValidator(lambda value, _: np.array(_NUMBERS.validate_python(value))),
]
"""A field of what is kept that is an array of shape (n,)."""


def keep(find: Callable[_Arguments, _Found]) -> Callable[_Arguments, _Found]:
    """A function as it is, which reads from the disk what it has found before for equal arguments.

    Args:
        find: It depends on its arguments alone: arrays, strings, numbers, dataclasses and sequences of these. What it
            finds is of the type that it states, which pydantic can write and read.
    """

    @once
    def make_adapter() -> TypeAdapter[_Found]:
        return TypeAdapter(get_type_hints(find)["return"])

    @functools.wraps(find)
    def load_or_find(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Found:
        adapter = make_adapter()
        digest = hashlib.sha256(f"{find.__module__}.{find.__qualname__} {digest_sources()}".encode())
        for each in (args, sorted(kwargs.items())):
            digest.update(b"".join(_list_bytes(each)))
        file = _make_folder(os.environ.get("XDG_CACHE_HOME")) / f"{digest.hexdigest()}.json"
        with contextlib.suppress(OSError, ValidationError):
            found = adapter.validate_json(file.read_bytes())
            os.utime(file)
            return found
        found = find(*args, **kwargs)
        with contextlib.suppress(OSError, UserError):  # a full disk costs a search each time, nothing else
            _write(file, adapter.dump_json(found))
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
    states = [(each.stat(), each) for each in file.parent.glob("*.json")]
    left = MOST_BYTES
    for state, each in sorted(states, key=lambda entry: -entry[0].st_mtime_ns):
        left -= state.st_size
        if left < 0:
            each.unlink(missing_ok=True)


@once
def _make_folder(base: str | None) -> Path:
    """The folder of entries, made once for each place that the environment names."""
    del base  # `make_private_folder` reads it
    return make_private_folder("objects")


@once
def digest_sources() -> str:
    """A digest of the package's code, any of which may be what finds something."""
    digest = hashlib.sha256(f"{np.__version__} {scipy.__version__}".encode())
    for folder, _, names in sorted(os.walk(Path(__file__).parents[1])):
        for name in sorted(names):
            if name.endswith((".py", ".yaml")):
                digest.update(Path(folder, name).read_bytes())
    return digest.hexdigest()
