"""NumPy's `.npy` and `.npz` files, with what a header announces held against what the file holds."""

from __future__ import annotations

import io
import math
import os
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import IO

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_counts, open_regular, shorten

_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
# What NumPy's reader of headers, which evaluates a literal, raises over headers that are none.
_BROKEN = (ValueError, TypeError, SyntaxError, EOFError, tokenize.TokenError, RecursionError, MemoryError)


def read_npy(path: str | Path, *, most: int, what: str) -> np.ndarray:
    """The array of a `.npy` file; pickled objects are refused.

    Args:
        path: The file.
        most: Largest size [bytes].
        what: What it is to the user, for messages.

    Raises:
        UserError: As `open_regular`, or it is no `.npy` file, or announces another size than it has.
    """
    with open_regular(path, most=most, what=what) as file:
        size = os.fstat(file.fileno()).st_size
        return _read_array(file, size, f"{what} {shorten(path)}")


def read_npz(path: str | Path, keys: Iterable[str], *, most: int, what: str) -> dict[str, np.ndarray]:
    """Those of the arrays ``keys`` that a `.npz` file has; arguments as of `read_npy`, ``most`` unpacked.

    Raises:
        UserError: As `read_npy`, or it is no `.npz` file, or takes more than ``most`` bytes when unpacked.
    """
    place = f"{what} {shorten(path)}"
    with open_regular(path, most=most, what=what) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                entries = {f"{key}.npy": key for key in keys}
                found = [entry for entry in archive.infolist() if entry.filename in entries]
                if sum(entry.file_size for entry in found) > most:
                    raise UserError(f"{place} is too large to be unpacked", got=f"more than {most:,} bytes")
                return {
                    entries[e.filename]: _read_member(archive, e, f"{place}: {e.filename}") for e in found
                }
        except UserError:
            raise
        # RuntimeError and NotImplementedError: encrypted, or packed in another way than NumPy does.
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, ValueError) as error:
            raise UserError(f"cannot read {place}", got=shorten(error), do="Write it again") from None


def _read_member(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, place: str) -> np.ndarray:
    with archive.open(entry) as file:
        return _read_array(file, entry.file_size, place)


def _read_array(file: IO[bytes], size: int, place: str) -> np.ndarray:
    """The array in ``size`` bytes."""
    try:
        start = file.read(min(size, 64 * 2**10))  # a header is far shorter
        head = io.BytesIO(start)
        shape, fortran, dtype = _HEADERS[np.lib.format.read_magic(head)](head)
    except KeyError as error:
        raise UserError(
            f"cannot read {place}", got=f"format {error}", do="Save it with `numpy.save`"
        ) from None
    except _BROKEN as error:
        raise _make_error(place, error) from None
    if dtype.hasobject:
        raise UserError(f"{place} holds Python objects", got=dtype, do="Save an array of numbers")
    count = math.prod(shape) if all(side >= 0 for side in shape) else -1
    check_counts(place, "values", count, dtype.itemsize, size - head.tell())
    data = bytearray(start[head.tell() : head.tell() + count * dtype.itemsize])
    data += file.read(count * dtype.itemsize - len(data))
    check_counts(place, "values", count, dtype.itemsize, len(data))  # what is packed may end early
    try:
        return np.frombuffer(data, dtype, count).reshape(shape, order="F" if fortran else "C")
    except (ValueError, OverflowError) as error:  # items of no bytes, or axes that NumPy cannot have
        raise _make_error(place, error) from None


def _make_error(place: str, error: Exception) -> UserError:
    reason = f"no array of NumPy: {shorten(error, 80)}"
    return UserError(f"cannot read {place}", got=reason, do="Save it with `numpy.save`")
