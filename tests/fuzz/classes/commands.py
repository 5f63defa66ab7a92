"""The command line, within the process: options at their edges, pairs that exclude each other, odd paths, files as
scenes.

Simulating is stopped where it would begin: a case that gets so far is accepted, and what it would have simulated
is checked.
"""

from __future__ import annotations

import contextlib
import io
import os
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tests.conftest import share_programs
from tests.fuzz import seeds
from tests.fuzz.classes import scenes
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import TEXTS, Draw, altered, damaged, encoded

SECONDS = 30.0
NONSENSE = "-5 0 -0 1e-300 1e300 nan inf -inf 1e400 abc 99999999999999999999 0.5 2".split() + [
    "",
    " ",
    "0x10",
    "1,5",
    "1_0",
]
# Values that must not be accepted, by option.
WRONG = {
    "--friction": ("-1", "nan", "inf", "1e300"), "--kind": ("xyzzy", "plnat", ""),
    "--material": ("stele", "", "nan"), "--seed": ("-1", "1e3", "1.5"),
    "--frames": ("0", "1", "-3", "1000000"), "--particles": ("0", "-1", "1.5"),
    "--resolution": ("0", "1", "1000000"), "--azimuth": ("nan", "inf", "1e400"),
    "--elevation": ("90", "-90", "nan", "1e300"), "--soften": ("0", "-1", "nan", "inf", "1e300", "x"),
    "--youngs-modulus": ("0", "-1", "nan", "1e-300", "1e300", "inf"),
    "--poissons-ratio": ("0.5", "-0.1", "nan"), "--density": ("0", "-1", "1e-300", "1e300", "nan"),
    "--up": ("z", "+w", ""), "--opacity-threshold": ("-0.1", "1.5", "nan"),
    "--max-iterations": ("0", "-1", "x"), "--preset": ("slow", ""), "--anchor": ("foot", ""),
    "--physgm": ("missing.json", "/dev/zero", ""), "--anchor-mask": ("missing.npy",),
    "--max-minutes": ("0", "-1", "nan", "inf"), "--max-memory": ("0", "-1", "nan", "inf"),
}  # fmt: skip
# Two options that say the same thing, or of which one has no meaning without the other.
PAIRS = (
    ("--physgm", "good-physgm.json", "--material", "steel"),
    ("--anchor", "base", "--anchor-mask", scenes.MASK), ("--anchor-mask", scenes.MASK),
    ("--anchor-box", "1", "1", "1", "1", "1", "1"), ("--anchor", "mask"), ("--anchor", "box"),
    ("--anchor", "none", "--anchor-box", "1", "1", "1", "1", "1", "1"),
)  # fmt: skip
FINE = (
    "--seed 3", "--kind plant", "--azimuth 30", "--up -y", "--anchor base", "--friction 0.3",
    "--material steel --soften auto", "--frames 2", "--ledger", "--physgm good-physgm.json",
    "--max-iterations 1", "--particles 50",
)  # fmt: skip
PICTURE = "picture.png"
LINK, FIFO, DEVICE, FOLDER, EARLIER, NOTES = (
    "link.ply",
    "pipe.json",
    "device.ply",
    "folder",
    "earlier",
    "earlier/notes.txt",
)
PATHS = (
    "", ".", "/", "..", "~", "x" * 5000, "a/" * 2000, "b\udcff\udcfe.ply", "missing", "/dev/zero",
    "/dev/null", "/dev/full", "/proc/self/mem", LINK, FIFO, FOLDER, seeds.OBJECT, "nul\0byte", scenes.SCENE,
    "ü.ply", EARLIER, "-", "--out",
)  # fmt: skip
# Where nothing is yet: to write there is right.
NEW = ("missing", "ü.ply", "b\udcff\udcfe.ply", "-", "~", "--out")
# What can be an argument: bytes that are no text come as halves of pairs, and only so.
WORDS = tuple(text.replace("\ud800", "\udcff") for text in TEXTS)


class Begun(BaseException):
    """Simulating would have begun."""


def make(draw: Draw) -> Case:
    """One command."""
    kind = draw.one(
        [_draw_option] * 3
        + [_draw_wrong] * 4
        + [_draw_pair, *[_draw_path] * 3, *[_draw_scene] * 2, _draw_small, _draw_make, _draw_variables]
        + [_draw_inspect]
    )
    return kind(draw)


warm_up = scenes.warm_up

# --- kinds of commands ---------------------------------------------------------------------------------


def _compose(*options: str, object_=seeds.OBJECT, prompt="push it to the left", out="out") -> list[str]:
    return ["run", "--object", object_, "--prompt", prompt, "--out", out, *options]


def _draw_option(draw: Draw) -> Case:
    option, value = draw.one(sorted(WRONG)), draw.one(NONSENSE)
    return _make_case(_compose(f"{option}={value}", *draw.one(FINE).split()))


def _draw_wrong(draw: Draw) -> Case:
    option = draw.one(sorted(WRONG))
    value = draw.one(WRONG[option])
    return _make_case(_compose(f"{option}={value}"), must_refuse=f"{option} {value!r} means nothing")


def _draw_pair(draw: Draw) -> Case:
    pair = draw.one(PAIRS)
    return _make_case(_compose(*pair), must_refuse="options that exclude or need each other")


def _draw_path(draw: Draw) -> Case:
    """A path that is none, where a file or folder is to be read or written; what is there already must stay."""
    path = draw.one(PATHS)
    extra = draw.one([[], [], ["--overwrite"]])
    out = DEVICE if path.startswith(("/dev", "/proc")) else path  # the machine's own are not put at risk
    commands = (
        _compose(object_=path), _compose(*extra, out=out), _compose("--physgm", path), _compose("--anchor", "mask",
        "--anchor-mask", path),
        ["simulate", path, "--out", "out"], ["simulate", scenes.SCENE, *extra, "--out", out],
        ["simulate", scenes.SCENE, "--object", path, "--out", "out"], ["make", "jelly", *extra, "--out", out],
        ["report", path], ["inspect", path, "--out", PICTURE], ["inspect", seeds.OBJECT, *extra, "--out", out],
        ["import-physgaussian", path, "--object", seeds.OBJECT, "--out", "out.json"],
        ["import-physgaussian", "physgaussian.json", "--object", path, "--out", "out.json"],
        ["import-physgaussian", "physgaussian.json", *extra, "--object", seeds.OBJECT, "--out", out],
        _compose(prompt=path),
    )  # fmt: skip
    arguments = draw.one(commands)
    mine = [PICTURE, *([path, str(Path(path).with_suffix(".card.json"))] if path in NEW else [])]
    if arguments == ["report", path] and path in ("", "."):
        mine.append("report.html")  # a folder that holds a scene is a run
    return _make_case(arguments, own=tuple(mine))


def _draw_scene(draw: Draw) -> Case:
    if draw.chance(0.3):
        what, content = damaged(draw, encoded(scenes.scene(draw)))
    else:
        what, content = altered(draw, scenes.scene(draw))
    options = draw.one([[], ["--ledger"], ["--force-substep"], ["--object", seeds.OBJECT]])
    return _make_case(["simulate", scenes.SCENE, "--out", "out", *options], {scenes.SCENE: content}, what)


def _draw_inspect(draw: Draw) -> Case:
    """An object that is damaged, or options at their edges; doctor takes none."""
    if draw.chance(0.1):
        return _make_case(["doctor", *draw.one([[], ["--json"], ["--jsno"], ["x"]])])
    option = draw.one(["--up", "--kind", "--opacity-threshold", "--splat-encoding"])
    values = (*NONSENSE, *WRONG.get(option, ()), "-y", "plant", "0.1", "log-logit", "plain-plain")
    what, content = "", seeds.gaussians()
    if draw.chance(0.6):
        what, content = damaged(draw, content)
    line = ["inspect", seeds.OBJECT, f"{option}={draw.one(values)}", "--out", draw.one([PICTURE, "x.jpg"])]
    return _make_case([*line, *draw.one([[], ["--json"]])], {seeds.OBJECT: content}, what, own=(PICTURE,))


def _draw_small(draw: Draw) -> Case:
    words = ("materials", "schema", "report", "simulate", "run", "make", "import-physgaussian", "--help", "-h",
    "inspect", "doctor", "--json", "--debugg",
             "steel", "scene", "force-field", "--out", "x", "", "--", "-", "--seed", "1", *WORDS[:12])  # fmt: skip
    if draw.chance(0.5):
        arguments = [draw.one(words) for _ in range(draw.randint(0, 4))]
    else:
        arguments = draw.one([["materials"], ["schema"]]) + [
            draw.one([*WORDS, "steel", "stele", "sceen", "manifest"])
        ]
    return _make_case(arguments, own=("x", "x.card.json"))


def _draw_make(draw: Draw) -> Case:
    out = draw.one(["made.ply", "made", "sub/made.ply", seeds.OBJECT, "taken.ply"])
    seed = draw.one(["0", "-1", "1", "4294967296", "99999999999999999999", "x", "1.5"])
    refuse = f"--seed {seed}" if seed in ("-1", "x", "1.5") else ""
    return _make_case(["make", draw.one(["plant", "loaf", "jelly"]), "--out", out, f"--seed={seed}"],
                      must_refuse=refuse, own=("made.ply", "made", "sub", "made.card.json"))  # fmt: skip


def _draw_variables(draw: Draw) -> Case:
    """Variables that the command reads itself; those that only a new process reads are in `test_interruption`."""
    value = draw.one(["/dev/null", "/proc/x", "x" * 5000, "object.ply", "cache", "off", "0", "", "\udcff"])
    own = ("cache", *([value] if "/" not in value and "." not in value and value else []))
    return _make_case(_compose(), environment={"PHYSAGENT_COMPILE_CACHE": value}, own=own)


# --- running one ---------------------------------------------------------------------------------------


def _make_case(
    arguments: list[str],
    files: dict[str, bytes] | None = None,
    what: str = "",
    *,
    own: tuple[str, ...] = (),
    must_refuse: str = "",
    environment: dict[str, str] | None = None,
) -> Case:
    shown = " ".join(a if len(a) < 60 else f"{a[:20]}...({len(a)})" for a in arguments)
    laid = {
        **scenes.files(), scenes.SCENE: encoded(scenes.usual_scene()),
        "good-physgm.json": b'{"E": 1e6, "nu": 0.3, "material": "Wood"}',
        "physgaussian.json": b'{"n_grid": 20, "grid_lim": 2.0, "frame_num": 3, "g": [0, 0, -9.8], "material": "jelly"}',
        "taken.card.json": b'{"name": "somebody else\'s"}', NOTES: b"precious",
        f"{EARLIER}/manifest.json": b'{"name": "of something else"}',
        f"{FOLDER}/inside": b"x", **(files or {}),
    }  # fmt: skip
    shown = (
        f"physagent {shown}{'; ' + what if what else ''}{' with ' + repr(environment) if environment else ''}"
    )
    return Case(
        shown, lambda folder: _call_main(arguments, folder, environment or {}), laid, prepare=_make_specials,
        own=("out", "out.json", *own),
        refusals=(Refused,), must_refuse=must_refuse,
        seconds=4 * SECONDS if arguments[:1] == ["inspect"] else SECONDS,  # programs that draw are compiled
    )  # fmt: skip


def _make_specials(folder: Path) -> None:
    os.symlink("nowhere", folder / LINK)
    os.mkfifo(folder / FIFO)
    try:
        os.mknod(folder / DEVICE, stat.S_IFCHR | 0o666, os.makedev(1, 3))  # another /dev/null
    except PermissionError:  # for root only
        os.mkfifo(folder / DEVICE)


class Refused(Exception):
    """Exit code 2 and one line."""


def _call_main(arguments: list[str], folder: Path, environment: dict[str, str]) -> Any:
    from physagent_jax.cli import main

    out = io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True)
    err = io.TextIOWrapper(
        io.BytesIO(), "utf-8", "backslashreplace", write_through=True
    )  # as Python's own is
    reached: list[Any] = []
    variables = {"PHYSAGENT_COMPILE_CACHE": "off", **environment}
    try:
        with _change_folder(folder), _set_variables(variables), _stop_short(reached), redirected(out, err):
            try:
                code = main(arguments)
            except SystemExit as leaving:  # the parser's own way out
                code = leaving.code
    except Begun:
        return reached[0].model, reached[0].state, reached[0].camera
    text = err.buffer.getvalue().decode("utf-8", "replace")
    return judged(code, text)


def judged(code: object, stderr: str) -> None:
    """Hold an exit code and what was said to the contract.

    Raises:
        Refused: As it should be.
        Breach: Not so.
    """
    if "Traceback (most recent call last)" in stderr:
        raise Breach(Fault.TRACEBACK, stderr.strip().splitlines()[-1][:300])
    if code in (0, None):
        return
    if code != 2:
        raise Breach(Fault.WORDING, f"exit code {code}: {stderr[-200:]}")
    lines = [line for line in stderr.splitlines() if line.startswith("physagent: ")]
    # The parser of options draws a box about what it does not understand.
    if len(lines) != 1 and "\u256d" not in stderr:
        raise Breach(Fault.WORDING, f"{len(lines)} lines that begin with `physagent:` in {stderr[-300:]!r}")
    raise Refused(lines[0] if lines else stderr)


@contextlib.contextmanager
def redirected(out, err) -> Iterator[None]:
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield


@contextlib.contextmanager
def _change_folder(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@contextlib.contextmanager
def _set_variables(changes: dict[str, str]) -> Iterator[None]:
    import jax

    before = {name: os.environ.get(name) for name in changes}
    cache = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", None)  # as in a process that is the command's own
    os.environ.update(changes)
    try:
        yield
    finally:
        jax.config.update("jax_compilation_cache_dir", cache)
        share_programs()  # the command may have put another folder in the place of the tests' own
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextlib.contextmanager
def _stop_short(reached: list) -> Iterator[None]:
    """`simulate_scene` ends the command, wherever it has been imported; nothing is compiled ahead."""
    import physagent_jax.run.loop
    import physagent_jax.run.replay  # noqa: F401
    from physagent_jax.kernels import ahead
    from physagent_jax.simulation import simulate as simulation

    def simulate_scene(scene, *_, **__):
        reached.append(scene)
        raise Begun

    def begin(*_, **__):
        return None

    changed: list[tuple[Any, str, Callable]] = []
    for original, new in ((simulation.simulate_scene, simulate_scene), (ahead.start_compiling, begin)):
        for module in [m for name, m in sys.modules.items() if name.startswith("physagent_jax")]:
            for attribute, value in list(vars(module).items()):
                if value is original:
                    changed.append((module, attribute, original))
                    setattr(module, attribute, new)
    try:
        yield
    finally:
        for module, attribute, original in changed:
            setattr(module, attribute, original)
