"""Tensors of a file that `torch.save` wrote, read without torch and without running anything that the file says.

Such a file is a zip archive: a pickle that names tensors, and one stored entry of numbers for each. A pickle is a
program. This reader has a few of its instructions, which make tensors and containers of them, and refuses every other.
"""

from __future__ import annotations

import math
import pickletools
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ml_dtypes
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import MIB, open_regular

PICKLE_BYTES = 8 * MIB  # a thousand tensors have a fifth of one
_DTYPES = {
    "FloatStorage": np.float32,
    "DoubleStorage": np.float64,
    "HalfStorage": np.float16,
    "BFloat16Storage": ml_dtypes.bfloat16,
    "LongStorage": np.int64,
    "IntStorage": np.int32,
    "ByteStorage": np.uint8,
    "BoolStorage": np.bool_,
}
_DICT, _TENSOR, _PARAMETER = (
    "collections OrderedDict",
    "torch._utils _rebuild_tensor_v2",
    "torch._utils _rebuild_parameter",
)
_CONVERT = "Convert it where torch is installed: `safetensors.torch.save_file(model.state_dict(), 'model.safetensors')`"


def read_torch_file(path: str | Path, *, most: int) -> dict[str, np.ndarray]:
    """The tensors of a checkpoint, by name.

    A dictionary inside the dictionary, as of a model beside its optimiser, is entered where it alone holds tensors.

    Args:
        path: A file of torch 1.6 or newer.
        most: Largest size [bytes].

    Raises:
        UserError: It cannot be read, is of another kind, or says more than tensors.
    """
    with open_regular(path, most=most, what="the checkpoint") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                tensors = _take_tensors(_Reader(archive).read())
        except UserError:
            raise
        except _Refusal as error:
            raise UserError(f"the checkpoint {path} is refused: {error}", do=_CONVERT) from None
        except Exception as error:  # of a mutilated zip or pickle, whose readers raise a dozen kinds
            reason = str(error)[:120] or type(error).__name__
            raise UserError(
                f"the checkpoint {path} is no file of `torch.save` ({reason})", do=_CONVERT
            ) from None
    return tensors


class _Refusal(Exception):
    """Something in the file that is not a tensor or a container of tensors."""


class _Name(str):
    """The name of something to call: text that the program cannot write as text."""


class _Reader:
    """A machine for the instructions of pickles that hold tensors.

    Args:
        archive: The file.
    """

    def __init__(self, archive: zipfile.ZipFile):
        names = [name for name in archive.namelist() if name.endswith("/data.pkl")]
        if len(names) != 1:
            raise _Refusal("it has no `data.pkl`")
        self._archive, self._root = archive, names[0].removesuffix("data.pkl")
        self._storages: dict[str, np.ndarray] = {}
        if f"{self._root}byteorder" in archive.namelist() and self._take("byteorder", 16) != b"little":
            raise _Refusal("its numbers have their highest byte first")

    def read(self) -> Any:
        """Run the pickle and return the result."""
        stack: list[Any] = []
        marks: list[int] = []
        memo: dict[Any, Any] = {}

        def pop_marked() -> list[Any]:
            start = marks.pop()
            taken = stack[start:]
            del stack[start:]
            return taken

        for opcode, argument, _ in pickletools.genops(self._take("data.pkl", PICKLE_BYTES)):
            match opcode.name:
                case "PROTO":
                    pass
                case "GLOBAL":
                    stack.append(_Name(argument))
                case "BINUNICODE" | "BININT" | "BININT1" | "BININT2" | "LONG1" | "BINFLOAT":
                    stack.append(argument)
                case "NONE" | "NEWTRUE" | "NEWFALSE":
                    stack.append({"NEWTRUE": True, "NEWFALSE": False}.get(opcode.name))
                case "EMPTY_TUPLE" | "EMPTY_LIST" | "EMPTY_DICT":
                    stack.append(
                        {"EMPTY_TUPLE": tuple, "EMPTY_LIST": list, "EMPTY_DICT": dict}[opcode.name]()
                    )
                case "MARK":
                    marks.append(len(stack))
                case "TUPLE":
                    stack.append(tuple(pop_marked()))
                case "TUPLE1" | "TUPLE2" | "TUPLE3":
                    count = int(opcode.name[-1])
                    stack[-count:] = [tuple(stack[-count:])]
                case "APPEND" | "APPENDS":
                    more = [stack.pop()] if opcode.name == "APPEND" else pop_marked()
                    stack[-1].extend(more)
                case "SETITEM" | "SETITEMS":
                    more = [stack.pop(-2), stack.pop()] if opcode.name == "SETITEM" else pop_marked()
                    stack[-1].update(zip(more[::2], more[1::2], strict=True))
                case "BINPUT" | "LONG_BINPUT":
                    memo[argument] = stack[-1]
                case "BINGET" | "LONG_BINGET":
                    stack.append(memo[argument])
                case "BINPERSID":
                    stack.append(self._take_storage(stack.pop()))
                case "REDUCE":
                    arguments, called = stack.pop(), stack.pop()
                    stack.append(_call(called, arguments))
                case "BUILD":  # versions of the layers
                    stack.pop()
                case "STOP":
                    return stack.pop()
                case other:
                    raise _Refusal(f"its pickle has the instruction {other}")
        raise _Refusal("its pickle has no end")

    def _take_storage(self, said: Any) -> np.ndarray:
        kind, dtype, key, _, count = said
        name = dtype.removeprefix("torch ") if isinstance(dtype, _Name) else ""
        if kind != "storage" or name not in _DTYPES:
            raise _Refusal(f"it asks for `{dtype}`, which is no storage of numbers that this reader knows")
        numbers = np.dtype(_DTYPES[name])
        if key not in self._storages:
            data = self._take(f"data/{key}", count * numbers.itemsize, exactly=True)
            self._storages[key] = np.frombuffer(data, numbers)
        return self._storages[key]

    def _take(self, name: str, most: int, exactly: bool = False) -> bytes:
        """An entry as it lies in the file: what is compressed could unpack to any size."""
        entry = self._archive.getinfo(self._root + name)
        if entry.compress_type != zipfile.ZIP_STORED:
            raise _Refusal(f"its entry `{name}` is compressed")
        if entry.file_size > most or (exactly and entry.file_size != most):
            raise _Refusal(f"its entry `{name}` has {entry.file_size} bytes instead of {most}")
        return self._archive.read(entry)


def _call(called: Any, arguments: tuple) -> Any:
    """The result of one of the three things that may be called."""
    made: Callable[..., Any] | None = {_DICT: dict, _TENSOR: _make_tensor, _PARAMETER: _take_first}.get(
        called if isinstance(called, _Name) else ""
    )
    if made is None:
        raise _Refusal(f"it asks for `{str(called)[:80].replace(' ', '.')}`")
    return made(*arguments)


def _take_first(tensor: Any, *_: Any) -> Any:
    return tensor


def _make_tensor(storage: Any, offset: Any, shape: Any, strides: Any, *_: Any) -> np.ndarray:
    """A tensor as a view of its storage, in which it must lie."""
    whole = all(type(each) is int and each >= 0 for each in (offset, *shape, *strides))
    if not isinstance(storage, np.ndarray) or storage.ndim != 1 or not whole or len(shape) != len(strides):
        raise _Refusal("it has a tensor without numbers, or of no possible shape")
    if not math.prod(shape):
        return np.zeros(shape, storage.dtype)
    last = offset + sum((n - 1) * step for n, step in zip(shape, strides))
    if math.prod(shape) > storage.size or last >= storage.size:
        raise _Refusal("it has a tensor that is larger than its storage")
    steps = [step * storage.itemsize for step in strides]
    return np.lib.stride_tricks.as_strided(storage[offset:], shape, steps, writeable=False)


def _take_tensors(said: Any) -> dict[str, np.ndarray]:
    """The dictionary of tensors in what a file says: itself, or the only one that it holds."""
    inner = [each for each in said.values() if _holds_tensors(each)] if isinstance(said, dict) else []
    for found in (said, *(inner if len(inner) == 1 else ())):
        if _holds_tensors(found):
            return dict(found)
    raise _Refusal("it is no dictionary of tensors")


def _holds_tensors(found: Any) -> bool:
    named = isinstance(found, dict) and all(isinstance(name, str) for name in found)
    return named and bool(found) and all(isinstance(each, np.ndarray) for each in found.values())
