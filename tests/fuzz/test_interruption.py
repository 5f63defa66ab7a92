"""Runs that something happens to: killed, stopped, without room, without rights, two at once.

Whatever it is: what is there is whole, what is said is one line, and the same command finishes the run, with the bytes
of a run that nothing happened to (wall times apart). The processes share one folder of compiled programs.
"""

from __future__ import annotations

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.fuzz import seeds
from tests.fuzz.contract import BYSTANDER, half_written

REPOSITORY = Path(__file__).resolve().parents[2]
LIMIT = 240.0  # [s] for a process, compilation included
PROMPT = "push the robot hard to the left"
RUN = ("--frames", "3", "--particles", "60", "--resolution", "32", "--max-iterations", "2", "--seed", "1")
TIMES = {"stages", "command"}  # of a manifest; what depends on the clock or on how often a run was started


def environment(base: Path, **changes: str) -> dict[str, str]:
    """Of a process: its caches lie in ``base``."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PHYSAGENT", "NUMBA", "JAX", "XLA"))}
    ours = {"PYTHONPATH": str(REPOSITORY), "XDG_CACHE_HOME": str(base / "caches"), "JAX_PLATFORMS": "cpu"}
    return {**kept, **ours, **changes}


def start(base: Path, arguments: list, *, what="none", at=0, marker="", prefix=(), env=None, **options) -> subprocess.Popen:
    """A process of the command line (`tests.fuzz.interrupted`), in a session of its own."""
    line = [*prefix, sys.executable, "-m", "tests.fuzz.interrupted", what, at, marker, "--", *arguments]
    return subprocess.Popen(
        list(map(str, line)), cwd=base, env=env or environment(base), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True, **options,
    )  # fmt: skip


def ended(process: subprocess.Popen, limit: float = LIMIT) -> tuple[int, str]:
    """Exit code and standard error; a process that does not end is killed with its children, and the test fails."""
    try:
        _, errors = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        pytest.fail(f"no end after {limit:g} s: {process.args}")
    return process.returncode, errors


def run(base: Path, out: Path, **options) -> tuple[int, str]:
    """The run of these tests into ``out``; what happens to it is in ``options``."""
    arguments = ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN]
    return ended(start(base, arguments, **options))


def said(errors: str) -> list[str]:
    """The lines that begin with `physagent:`; there must be no traceback."""
    assert "Traceback" not in errors, errors[-2000:]
    return [line for line in errors.splitlines() if line.startswith("physagent: ")]


def whole(out: Path) -> None:
    """Every file in a folder can be read; temporary ones are allowed while a run is not finished."""
    for path in out.rglob("*"):
        if not path.name.startswith("."):
            assert half_written(path) == "", path


def contents(out: Path) -> dict[str, object]:
    """What a finished run left, by name: bytes, or JSON where the clock is part of it."""
    found: dict[str, object] = {}
    for path in sorted(p for p in out.rglob("*") if p.is_file()):
        name = str(path.relative_to(out))
        if name == "manifest.json":
            manifest = json.loads(path.read_text())
            agents = [{k: v for k, v in agent.items() if k not in ("seconds", "calls")} for agent in manifest["agents"]]
            found[name] = {k: v for k, v in manifest.items() if k not in TIMES} | {"agents": agents}
        elif name == "report.html":  # shows wall times
            found[name] = path.read_text(encoding="utf-8").rstrip().endswith("</html>")
        else:
            found[name] = path.read_bytes()
    return found


def same(out: Path, undisturbed: Path) -> None:
    """Both runs left the same; nothing temporary is among it."""
    got, expected = contents(out), contents(undisturbed)
    assert got.keys() == expected.keys()
    differing = [name for name, value in expected.items() if got[name] != value]
    assert not differing


@pytest.fixture(scope="session")
def base(tmp_path_factory, worker_id="") -> Path:
    """A folder with an object, warm caches and a run that nothing happened to; made once for all processes of pytest."""
    root = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        root = root.parent
    root = root / "interruption"
    root.mkdir(exist_ok=True)
    with open(root.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (root / "ready").is_file():
            (root / seeds.OBJECT).write_bytes(seeds.gaussians())
            (root / BYSTANDER).write_bytes(b"not yours\n")
            code, errors = run(root, root / "undisturbed")
            assert code == 0, errors
            (root / "ready").touch()
    return root


# --- kill -9 -------------------------------------------------------------------------------------------


def files_written(base: Path) -> int:
    """Renames of the undisturbed run, at least one per file."""
    return sum(p.is_file() for p in (base / "undisturbed").rglob("*"))


def test_killed_three_times_on_the_way_the_run_finishes_as_if_nothing_had_been(base, tmp_path):
    """Kill -9 before the 2nd file, after the 7th of those that are left, before the 3rd of the rest."""
    out = tmp_path / "run"
    for what, at in (("before", 2), ("after", 7), ("before", 3)):
        code, errors = run(base, out, what=what, at=at)
        assert code == -signal.SIGKILL, errors
        whole(out)
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")
    assert (base / BYSTANDER).read_bytes() == b"not yours\n"


@pytest.mark.slow
@pytest.mark.parametrize("what", ["before", "after"])
@pytest.mark.parametrize("at", range(1, 24))
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


def children_of_session(session: int) -> list[str]:
    """Processes of a session that are still there."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(stat.parent.name)
    return found


def stopped(base: Path, out: Path, what: str, at: int, limit: float = LIMIT) -> tuple[int, str]:
    process = start(
        base, ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN], what=what, at=at
    )
    code, errors = ended(process, limit)
    deadline = time.monotonic() + 5
    while children_of_session(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not children_of_session(process.pid), "helper processes stayed behind"
    return code, errors


@pytest.mark.parametrize(("what", "exit_code"), [("term", 143), pytest.param("int", 130, marks=pytest.mark.slow)])
def test_one_signal_stops_in_one_line_and_the_run_can_be_taken_up(what, exit_code, base, tmp_path):
    out = tmp_path / "run"
    code, errors = stopped(base, out, what, at=2)
    assert code == exit_code, errors
    assert len(said(errors)) == 1
    whole(out)
    assert not (out / "report.html").exists()
    code, errors = run(base, out)
    assert code == 0, errors
    same(out, base / "undisturbed")


@pytest.mark.slow
@pytest.mark.parametrize("what", ["int2", "term2"])
def test_two_signals_end_at_once(what, base, tmp_path):
    """However it ends, it leaves nothing half-written and no process."""
    begun = time.monotonic()
    code, errors = stopped(base, tmp_path / "run", what, at=2, limit=60)
    assert code in (130, 143, -signal.SIGINT, -signal.SIGTERM), errors
    assert "Traceback" not in errors
    assert time.monotonic() - begun < 60
    whole(tmp_path / "run")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("seconds", [0.3, 1.0, 2.0, 3.0, 4.0])
def test_a_signal_at_any_moment_ends_without_a_traceback(seconds, number, base, tmp_path):
    """While Python imports, too."""
    out = tmp_path / "run"
    process = start(base, ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN])
    time.sleep(seconds)
    process.send_signal(number)
    code, errors = ended(process, 60)
    assert code in (0, 128 + number, -number), errors
    assert seconds < 2 or "Traceback" not in errors  # before `main` begins nobody can catch it
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


@pytest.mark.slow
def test_permissions_lost_on_the_way_are_told_in_one_line(base, tmp_path):
    out = tmp_path / "shared" / "run"
    out.parent.mkdir()
    options = {}
    if os.geteuid() == 0:  # whom no permission holds
        for folder in (out.parent, *out.parents[:4]):
            os.chmod(folder, 0o777)
        subprocess.run(["chmod", "-R", "a+rwX", str(base)], check=True)
        options = {"user": 65534, "group": 65534, "extra_groups": []}
        reachable = subprocess.run([sys.executable, "-c", "import physagent_jax"], cwd=base, env=environment(base), **options)
        if reachable.returncode:
            pytest.skip("another user cannot read this checkout")
    code, errors = run(base, out, what="readonly", at=2, **options)
    assert code == 2, errors
    assert len(said(errors)) == 1
    for folder, _, _ in os.walk(out):
        os.chmod(folder, 0o777)
    code, errors = run(base, out, **options)
    assert code == 0, errors
    same(out, base / "undisturbed")
