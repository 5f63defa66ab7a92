"""Compiled kernels on disk: found again, and compiled again when they are damaged or not ours."""

import logging
import os
import shutil

import pytest

pytest.importorskip("numba")

from physagent_jax.kernels import ffi, folders, store  # noqa: E402  (after the check for Numba)
from tests.kernels.processes import begun, ended  # noqa: E402

NAME = "target"


def handler(frame):
    """A kernel that compiles in no time."""
    return frame + 41


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The folder of `handler`, once compiled."""
    monkeypatch.setattr(store, "find_folder", lambda: tmp_path)
    assert not store.is_stored(NAME)
    assert store.load_or_compile(NAME, ffi.HANDLER, handler).ctypes(1) == 42
    assert store.is_stored(NAME)
    return tmp_path / NAME


def files(place):
    return sorted(place.rglob("*.nb?"))


def truncated(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def bit_flipped(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 8
    path.write_bytes(content)


DAMAGES = {
    "truncated": truncated,
    "a bit flipped": bit_flipped,
    "random": lambda path: path.write_bytes(os.urandom(4000)),
    "empty": lambda path: path.write_bytes(b""),
    "another pickle": lambda path: path.write_bytes(b"\x80\x04]\x94."),
    "gone": lambda path: path.unlink(),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
}


def test_a_kernel_is_found_again(place):
    assert store.load_or_compile(NAME, ffi.HANDLER, handler)._cache_hits == 1


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("which", [0, 1, "seal"])
def test_a_damaged_file_costs_a_compilation_and_one_line(place, which, damage, caplog):
    DAMAGES[damage](place / "seal.json" if which == "seal" else files(place)[which])
    with caplog.at_level(logging.WARNING):
        again = store.load_or_compile(NAME, ffi.HANDLER, handler)
    assert again.ctypes(1) == 42 and again._cache_hits == 0
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert store.load_or_compile(NAME, ffi.HANDLER, handler)._cache_hits == 1
    assert [path.name for path in place.parent.iterdir()] == [NAME]  # nothing is left lying about


def test_what_is_sealed_but_not_numbas_costs_a_compilation(place, caplog):
    """Such as files of another version that somebody copied, seal and all."""
    files(place)[0].write_bytes(b"nonsense")
    store.seal(place)
    assert store.load_or_compile(NAME, ffi.HANDLER, handler).ctypes(1) == 42
    assert "cannot be read" in caplog.text and store.is_stored(NAME)


def test_a_full_disk_costs_nothing_but_time(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "find_folder", lambda: tmp_path / "not there")
    assert store.load_or_compile(NAME, ffi.HANDLER, handler).ctypes(1) == 42


def test_processes_that_compile_the_same_at_once_do_not_meet(tmp_path):
    """Each fills a folder of its own, and the first one's stays; all have a kernel that works."""
    script = (
        "from physagent_jax.kernels import ffi, store\n"
        "from tests.kernels.test_store import handler\n"
        f"print(store.load_or_compile('{NAME}', ffi.HANDLER, handler).ctypes(1), store.is_stored('{NAME}'))"
    )
    processes = [begun(script, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2)]
    assert [ended(process)[:2] for process in processes] == [(0, "42 True\n")] * 2


def test_a_folder_that_others_may_write_to_is_not_used(tmp_path, caplog):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "link").symlink_to(tmp_path)
    assert not folders.is_usable(tmp_path / "open") and "others" in caplog.text
    assert not folders.is_usable(tmp_path / "link")
    assert folders.is_usable(tmp_path / "new") and (tmp_path / "new").stat().st_mode & 0o777 == 0o700


def test_another_users_folder_is_not_used(tmp_path, monkeypatch):
    """Least of all in the folder for temporary files, where anybody may have made it before us."""
    (tmp_path / "cache").mkdir(mode=0o700)
    assert folders.is_usable(tmp_path / "cache")
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    monkeypatch.setattr(folders.tempfile, "gettempdir", lambda: str(tmp_path))
    (tmp_path / "physagent_jax-12345").mkdir(mode=0o700)
    found = folders.make_private_folder("kernels", base=tmp_path)
    try:
        assert found.name.startswith("physagent-") and not list(found.iterdir())
    finally:
        shutil.rmtree(found)


def test_another_processor_has_another_folder(monkeypatch):
    """A cache that came with a home folder from another machine is not even looked at."""
    here = folders.describe_processor()
    folders.describe_processor.cache_clear()
    read_text = folders.Path.read_text
    monkeypatch.setattr(
        folders.Path, "read_text", lambda self, **how: read_text(self, **how).replace("sse2", "sse9")
    )
    try:
        assert folders.describe_processor() != here
    finally:
        folders.describe_processor.cache_clear()
