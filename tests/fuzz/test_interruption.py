"""Runs that something happens to: killed, stopped, without room, without rights, two at once.

Whatever it is: what is there is whole, what is said is one line, and the same command finishes the run, with the bytes
of a run that nothing happened to (what it cost apart). The processes share one folder of compiled programs.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time

import pytest

from tests.fuzz import seeds
from tests.fuzz.contract import BYSTANDER, half_written
from tests.fuzz.processes import (
    LIMIT,
    PROMPT,
    RUN,
    children_of_session,
    ended,
    run,
    said,
    same,
    start,
    whole,
)

# --- kill -9 -------------------------------------------------------------------------------------------


def files_written(base) -> int:
    """Rename of the undisturbed run, at least one per file."""
    return sum(p.is_file() for p in (base / "undisturbed").rglob("*"))


def test_killed_twice_on_the_way_the_run_finishes_as_if_nothing_had_been(base, tmp_path):
    """Kill -9 after the 7th file, and before the 3rd of those that are left."""
    out = tmp_path / "run"
    for what, at in (("after", 7), ("before", 3)):
        code, errors = run(base, out, what=what, at=at)
        assert code == -signal.SIGKILL, errors
        whole(out)
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")
    assert (base / BYSTANDER).read_bytes() == b"not yours\n"


@pytest.mark.slow
@pytest.mark.parametrize("what", ["before", "after"])
@pytest.mark.parametrize("at", range(1, 31))
def test_killed_at_any_file_the_run_finishes_as_if_nothing_had_been(at, what, base, tmp_path):
    """Including the report, and rewrites of the manifest."""
    out = tmp_path / "run"
    code, errors = run(base, out, what=what, at=at)
    if code == 0:
        assert at > files_written(base)
        pytest.skip(f"the run writes fewer than {at} files")
    assert code == -signal.SIGKILL, errors
    whole(out)
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")


@pytest.mark.slow
@pytest.mark.parametrize("at", range(1, 6))
def test_simulate_killed_at_any_file_can_be_repeated(at, base, tmp_path):
    out = tmp_path / "played"
    arguments = ["simulate", base / "undisturbed" / "scene.json", "--out", out]
    code, _ = ended(start(base, arguments, what="before", at=at))
    if code == 0:
        pytest.skip("fewer files")
    whole(out) if out.exists() else None
    code, errors = ended(start(base, [*arguments]))
    if code == 2:  # what a killed command left may be refused, if the way out is told
        assert "--overwrite" in said(errors)[0]
        code, errors = ended(start(base, [*arguments, "--overwrite"]))
    assert code == 0, errors
    assert not [p for p in out.rglob("*") if half_written(p)]


# --- signals -------------------------------------------------------------------------------------------


def stopped(base, out, what: str, at: int, limit: float = LIMIT) -> tuple[int, str]:
    process = start(
        base,
        ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN],
        what=what,
        at=at,
    )
    code, errors = ended(process, limit)
    deadline = time.monotonic() + LIMIT
    while children_of_session(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not children_of_session(process.pid), "helper processes stayed behind"
    return code, errors


@pytest.mark.parametrize(
    ("what", "exit_code"), [("term", 143), pytest.param("int", 130, marks=pytest.mark.slow)]
)
def test_one_signal_stops_in_one_line_and_the_run_can_be_taken_up(what, exit_code, base, tmp_path):
    out = tmp_path / "run"
    code, errors = stopped(base, out, what, at=2)
    assert code == exit_code, errors
    assert [line for line in said(errors) if "stopping at" not in line] == [said(errors)[-1]]
    whole(out)
    assert not (out / "report.html").exists()
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")


@pytest.mark.slow
@pytest.mark.parametrize("what", ["int2", "term2"])
def test_two_signals_end_at_once(what, base, tmp_path):
    """However it ends, it leaves nothing half-written and no process."""
    code, errors = stopped(base, tmp_path / "run", what, at=2)
    assert code in (130, 143, -signal.SIGINT, -signal.SIGTERM), errors
    assert "Traceback" not in errors
    whole(tmp_path / "run")
    assert not (tmp_path / "run" / "report.html").exists()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("seconds", [0.3, 1.0, 2.0, 3.0, 4.0])
def test_a_signal_at_any_moment_ends_without_a_traceback(seconds, number, base, tmp_path):
    """While Python imports, too."""
    out = tmp_path / "run"
    process = start(base, ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN])
    time.sleep(seconds)
    process.send_signal(number)
    code, errors = ended(process)
    assert code in (0, 128 + number, -number), errors
    assert "Traceback" not in errors or ", in main" not in errors  # before `main` begins nobody can catch it
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")


# --- two at once ---------------------------------------------------------------------------------------


def test_the_second_of_two_processes_in_one_folder_is_told_so(base, tmp_path):
    """And the first finishes as if it had been alone."""
    out, marker = tmp_path / "run", tmp_path / "marker"
    arguments = ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN]
    first = start(base, arguments, what="hold", at=3, marker=marker)
    try:
        deadline = time.monotonic() + LIMIT
        while not marker.exists():
            assert first.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        code, errors = run(base, out)
        assert code == 2, errors
        assert len(said(errors)) == 1
        code, errors = ended(start(base, [*arguments, "--overwrite"]))
        assert code == 2, errors
    finally:
        marker.unlink(missing_ok=True)
        code, errors = ended(first)
    assert code == 0, errors
    same(out, base / "undisturbed")


# --- no room, no rights --------------------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 48 kB; larger after `mount -o remount`."""
    place = tmp_path / "disk"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=48k", "tmpfs", str(place)]
    try:
        mounted = subprocess.run(command, capture_output=True).returncode == 0
    except FileNotFoundError:
        mounted = False
    if not mounted:
        pytest.skip("no right to mount a file system")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.slow
def test_a_full_disk_is_told_in_one_line_and_the_run_goes_on_when_there_is_room(base, small_disk):
    code, errors = run(base, small_disk / "run")
    assert code == 2, errors
    assert len(said(errors)) == 1
    whole(small_disk / "run")
    assert not [p for p in small_disk.rglob(".*") if p.is_file()], "a temporary file takes room"
    subprocess.run(["mount", "-o", "remount,size=64m", str(small_disk)], check=True)
    code, errors = run(base, small_disk / "run")
    assert code == 0, errors
    same(small_disk / "run", base / "undisturbed")


@pytest.mark.slow
def test_files_that_may_not_grow_are_told_in_one_line(base, tmp_path):
    """A quota, which the system reports in another way than a full disk; the caches may not grow either."""
    code, errors = run(base, tmp_path / "run", prefix=("prlimit", "--fsize=4000"))
    assert code == 2, errors
    assert len(said(errors)) == 1
    whole(tmp_path / "run")


@pytest.fixture
def writable_again(tmp_path):
    """Give back what "readonly" has taken, when it is called with the folder."""
    taken = tmp_path / "taken"
    taken.mkdir()
    if os.geteuid() == 0:
        if subprocess.run(["mount", "--bind", taken, taken], capture_output=True).returncode:
            pytest.skip("no right to mount a file system")
        subprocess.run(["umount", taken], check=True)

    def mend():
        if os.geteuid() == 0:
            subprocess.run(["umount", taken], capture_output=True)
        for folder, _, _ in os.walk(taken):
            os.chmod(folder, 0o700)

    yield taken, mend
    mend()


@pytest.mark.slow
def test_permissions_lost_on_the_way_are_told_in_one_line(base, writable_again):
    out, mend = writable_again
    code, errors = run(base, out, what="readonly", at=3)
    assert code == 2, errors
    assert len(said(errors)) == 1
    mend()
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")
