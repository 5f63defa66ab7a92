"""The guarded reader: whatever a path or a JSON file holds, it is read or refused in one line, and never waited for."""

import json
import os
import stat
import sys
import tracemalloc
from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field

from physagent_jax.core import reading
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import suggest
from physagent_jax.core.strict import Strict

DEVICES = ("/dev/zero", "/dev/urandom", "/dev/full", "/dev/null")


def refused(action, *fragments):
    with pytest.raises(UserError) as caught:
        action()
    message = str(caught.value)
    assert "\n" not in message and message.isprintable() and len(message) < 700
    for fragment in fragments:
        assert fragment in message, message
    return message


@pytest.fixture(
    params=["device", "pipe", "folder", "missing", "dangling", "loop", "long", "bytes", "nul", "sur"]
)
def odd_path(request, tmp_path):
    """A name that is no regular file, and a word that the refusal must hold."""
    path = tmp_path / "file"
    match request.param:
        case "device":
            return next(filter(Path.is_char_device, map(Path, DEVICES))), "device"
        case "pipe":
            os.mkfifo(path)
            return path, "pipe"
        case "folder":
            return tmp_path, "folder"
        case "missing":
            return path, "there is no file"
        case "dangling":
            path.symlink_to(tmp_path / "gone")
            return path, "there is no file"
        case "loop":
            path.symlink_to(path)
            return path, "symbolic link"
        case "long":
            return tmp_path / ("x" * 5000), "too long"
        case "bytes":
            return Path(os.fsdecode(b"no\xff\xfesuch")), "there is no file"
        case "nul":
            return "a\0b", "null"
    return "\ud800", "not text"


@pytest.mark.parametrize("read", [reading.read_json, lambda path: reading.read_bytes(path, most=100)])
def test_what_is_no_regular_file_is_refused_at_once(odd_path, read):
    path, word = odd_path
    refused(lambda: read(path), word)


def test_a_file_without_permission_is_refused(tmp_path):
    path = tmp_path / "secret"
    path.write_text("{}")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    refused(lambda: reading.read_json(path), "Permission")


def test_sizes_are_limited_before_and_while_reading(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"x" * 101)
    refused(lambda: reading.read_bytes(path, most=100, what="the mask"), "the mask", "101 bytes")
    assert reading.read_bytes(path, most=101) == b"x" * 101
    assert reading.check_regular(path, most=101) == 101
    with open(path, "wb") as file:  # a hole: nothing is on the disk
        file.truncate(reading.JSON_BYTES + 1)
    refused(lambda: reading.read_json(path), "too large")
    endless = Path("/proc/self/maps")  # a regular file whose size is told as 0
    if endless.is_file() and stat.S_ISREG(endless.stat().st_mode):
        refused(lambda: reading.read_bytes(endless, most=100), "too large")


def test_a_small_file_takes_no_more_memory_than_it_has(tmp_path):
    """Whatever the limit: Python's `read` takes as much at once as it is told it may read."""
    (tmp_path / "file").write_bytes(b"x" * 100)
    tracemalloc.start()
    try:
        reading.read_bytes(tmp_path / "file", most=2**33)
        assert tracemalloc.get_traced_memory()[1] < 2**22
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (b"", "not valid JSON"),
        (b"{", "not valid JSON"),
        (b"\xff\xfe{\0}\0", "UTF-16"),
        (b"\xef\xbb\xbf{}", "byte order mark"),
        ('{"a": "é"}'.encode("latin-1"), "not UTF-8"),
        (b"[NaN]", "NaN"),
        (b"[-Infinity]", "Infinity"),
        (b"[1e999]", "too large"),
        (b"[%s]" % (b"9" * 5000), "5000 digits"),
        (b"[0.%s]" % (b"9" * 5000), "digits"),
        (b"[%d]" % 2**64, "too large"),
        (b"[%d]" % (-(2**63) - 1), "too large"),
        (b"[" * 65 + b"]" * 65, "nested too deeply"),
        (b'{"a":' * 100_000 + b"1" + b"}" * 100_000, "nested too deeply"),
        (b"\0\0\0", "not valid JSON"),
        (b'["\\ud800"]', "half a character"),
        (b'{"\\uD800": 1}', "half a character"),
    ],
)
def test_json_beyond_its_limits_is_refused(tmp_path, content, fragment):
    path = tmp_path / "scene.json"
    path.write_bytes(content)
    refused(lambda: reading.read_json(path), "scene.json", fragment)


def test_json_within_its_limits_is_what_json_says(tmp_path):
    data = {"a": [1, -2.5, 1e300, 2**64 - 1, -(2**63)], "é": None, "deep": json.loads("[" * 60 + "]" * 60)}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(data))
    assert reading.read_json(path) == data


class Round(Strict):
    kind: Literal["round"] = "round"
    radius: float


class Flat(Strict):
    kind: Literal["flat"] = "flat"
    half_size: tuple[float, float] = (1.0, 1.0)


class Thing(Strict):
    name: str
    shapes: tuple[Annotated[Round | Flat, Field(discriminator="kind")], ...] = ()
    table: dict[str, Round] = {}


@pytest.mark.parametrize(
    ("data", "fragments"),
    [
        ({"nane": "x"}, ["`nane`", "`name`"]),
        ({"name": "x", "shapes": [{"kind": "flat", "halfsize": [1, 1]}]}, ["halfsize", "`half_size`"]),
        ({"name": "x", "shapes": [{"kind": "rond"}]}, ["rond", "`round`"]),
        ({"name": "x", "table": {"a": {"radus": 1}}}, ["radus", "`radius`"]),
        ({"name": "x", "table": {"a": {"radius": 1, "kind": "rnd"}}}, ["rnd", "`round`"]),
        ({"name": "x" * 5000, "shapes": 3}, ["shapes"]),
        ({"\x1b[31m\n": 1, "name": "x"}, ["\\x1b"]),
        ([1], ["top level"]),
    ],
)
def test_misspelt_keys_and_values_are_answered_with_the_nearest(data, fragments, tmp_path):
    path = tmp_path / "thing.json"
    path.write_text(json.dumps(data))
    refused(lambda: reading.read_model(path, Thing), "thing.json", *fragments)


def test_a_valid_file_is_a_model(tmp_path):
    path = tmp_path / "thing.json"
    path.write_text('{"name": "x", "shapes": [{"kind": "round", "radius": 2}]}')
    assert reading.read_model(path, Thing).shapes == (Round(radius=2.0),)


def test_counts_are_compared_with_what_there_is():
    reading.check_counts("a.ply", "vertices", 10, 12, 120)
    refused(lambda: reading.check_counts("a.ply", "vertices", 11, 12, 120), "11 vertices", "120 bytes")
    refused(lambda: reading.check_counts("a.ply", "vertices", -1, 12, 120), "-1 vertices")
    refused(lambda: reading.check_counts("a.ply", "vertices", 10**5000, 12, 120), "2^64")
    assert sys.get_int_max_str_digits() == 4300  # which the message has not run into


def test_names_are_near_whatever_their_case_and_hyphens():
    assert "`wet_sand`" in suggest("Wet-Snad", ["wet_sand", "steel", "jelly"])
    assert suggest("qqqq", ["a", "b"]) == "Known: a, b."
    assert suggest("qqqq", map(str, range(50))) == ""


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="needs a file that opens and cannot be read")
def test_a_file_that_opens_and_cannot_be_read_is_refused_whoever_reads_it():
    """As on a broken disk: the memory of a process is a regular file whose first page nobody has."""
    with (
        reading.open_regular("/proc/self/mem", most=100) as file,
        pytest.raises(UserError, match="cannot read the file"),
    ):
        file.read(10)
    with pytest.raises(UserError, match="cannot read the mask /proc/self/mem .*Check the disk"):
        reading.read_bytes("/proc/self/mem", most=100, what="the mask")
