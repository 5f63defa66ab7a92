"""`.npy` and `.npz`: what NumPy wrote comes back, and a header that lies costs neither memory nor a traceback."""

import io
import struct
import zipfile

import numpy as np
import pytest

from physagent_jax.core.npy import read_npy, read_npz
from tests.core.test_reading import refused


def npy(header: str, data: bytes = b"", version=(1, 0)) -> bytes:
    return b"\x93NUMPY" + bytes(version) + struct.pack("<H", len(header)) + header.encode() + data


def header(descr="'|b1'", shape="(3,)", order="False"):
    return f"{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n"


@pytest.mark.parametrize(
    "array",
    [
        np.array([True, False]),
        np.asfortranarray(np.arange(12.0).reshape(3, 4)),
        np.arange(6, dtype=">i4").reshape(1, 2, 3),
        np.float16(2.5),
        np.zeros((0, 3)),
    ],
)
def test_what_numpy_wrote_comes_back(array, tmp_path):
    np.save(tmp_path / "a.npy", array)
    np.savez_compressed(tmp_path / "a.npz", one=array, other=np.ones(3))
    for back in (
        read_npy(tmp_path / "a.npy", most=10_000, what="the mask"),
        read_npz(tmp_path / "a.npz", ["one", "absent"], most=10_000, what="the motion")["one"],
    ):
        np.testing.assert_array_equal(back, array)
        assert back.dtype == np.asarray(array).dtype


def pickled() -> bytes:
    content = io.BytesIO()
    np.save(content, np.array([{}, []], dtype=object), allow_pickle=True)
    return content.getvalue()


BROKEN = {
    "empty": (b"", "no array"),
    "zip": (b"PK\x03\x04" + b"\0" * 100, "no array"),
    "text": (b"hello, I am no array of any kind", "no array"),
    "no data": (npy(header()), "announces more"),
    "far too many": (npy(header(shape="(10000000000000, 1000000000000)"), b"\0" * 99), "announces more"),
    "negative": (npy(header(shape="(-1,)"), b"\0" * 99), "announces more"),
    "pickle": (pickled(), "Python objects"),
    "no literal": (npy("{'descr': __import__('os')}\n"), "no array"),
    "no dictionary": (npy("[1, 2]\n"), "no array"),
    "deep": (npy("(" * 5000 + "\n"), "no array"),
    "half a header": (npy(header())[:30], "no array"),
    "version": (npy(header(), version=(9, 9)), "format (9, 9)"),
    "strange shape": (npy(header(shape="(2.5,)"), b"\0" * 9), "no array"),
    "empty items": (npy(header(descr="'|S0'"), b"\0" * 9), "no array"),
    "none by many": (npy(header(shape=f"(0, {10**30})"), b"\0" * 9), "no array"),
    "many axes": (npy(header(shape=str((1,) * 99)), b"\0" * 9), "no array"),
    "strange type": (npy(header(descr="'nonsense'"), b"\0" * 9), "no array"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_array_is_refused(case, tmp_path):
    content, fragment = BROKEN[case]
    path = tmp_path / "a.npy"
    path.write_bytes(content)
    refused(lambda: read_npy(path, most=10_000, what="the mask"), "the mask", fragment)
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("one.npy", content)
    refused(
        lambda: read_npz(tmp_path / "a.npz", ["one"], most=10_000, what="the motion"), "one.npy", fragment
    )


def test_archives_are_bounded_when_unpacked(tmp_path):
    """A megabyte of zeros packs into a thousand bytes."""
    np.savez_compressed(tmp_path / "a.npz", one=np.zeros(2**20, np.uint8))
    refused(lambda: read_npz(tmp_path / "a.npz", ["one"], most=2**19, what="the motion"), "unpacked")


@pytest.mark.parametrize("damage", ["cut", "flipped", "text", "encrypted"])
def test_a_damaged_archive_is_refused(damage, tmp_path):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, one=np.random.default_rng(0).integers(0, 9, 500))
    data = bytearray(path.read_bytes())
    if damage == "cut":
        data = data[: len(data) // 2]
    elif damage == "flipped":
        data[len(data) // 2] ^= 0xFF
    elif damage == "text":
        data = bytearray(b"not an archive")
    else:
        data[6] |= 1
        data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(data)
    refused(lambda: read_npz(path, ["one"], most=10_000, what="the motion"), "a.npz")


def test_messages_about_damaged_archives_are_short(tmp_path):
    """zipfile quotes names of entries in full."""
    path = tmp_path / "a.npz"
    np.savez(path, one=np.zeros(3))
    data = bytearray(path.read_bytes())
    at = data.index(b"one.npy")
    data[at + 4 :] = data[at + 4 :].replace(b"one.npy", b"two.npy")  # in the directory, not before the data
    data[26:28] = (60_000).to_bytes(2, "little")  # length of the first name
    path.write_bytes(data + b"x" * 70_000)
    refused(lambda: read_npz(path, ["two", "one"], most=10_000, what="the motion"), "a.npz")
