"""Command-line input: odd paths, odd characters, options that mean nothing; and any terminal."""

import contextlib
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.cli.console import ConsoleObserver, warn
from physagent_jax.scene.priors import PRIORS, find_kind
from tests.test_cli import PROMPT, SMALL, no_cache, refused  # noqa: F401


@pytest.fixture
def run(tmp_path, robot_path, capsys):
    """Refuse `physagent run` with options, before any folder is made."""

    def refuse(options, *fragments, prompt=PROMPT, item=robot_path):
        out = tmp_path / "run"
        arguments = ["run", "--object", item, "--prompt", prompt, "--out", out, *SMALL, *options]
        refused(capsys, arguments, *fragments)
        assert not out.exists()

    return refuse


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        (["--friction", "-1"], ["friction"]),
        (["--friction", "nan"], ["friction"]),
        (["--friction", "inf"], ["friction"]),
        (["--friction", "1e300"], ["friction"]),
        (["--kind", "plnat"], ["`--kind`", "`plant`"]),
        (["--kind", "nonsense"], ["`--kind`", "jelly"]),
        (["--seed", "-1"], ["seed"]),
        (["--seed", "4294967296"], ["seed"]),
        (["--frames", "100000"], ["frame_count"]),
        (["--particles", "1000000000000"], ["max_particles"]),
        (["--resolution", "100000"], ["width"]),
        (["--azimuth", "nan"], ["azimuth"]),
        (["--azimuth", "1e300"], ["azimuth"]),
        (["--opacity-threshold", "nan"], ["--opacity-threshold"]),
        (["--opacity-threshold", "1"], ["--opacity-threshold"]),
        (["--max-iterations", "1000000"], ["max-iterations"]),
        (["--density", "1e-300"], ["density"]),
        (["--youngs-modulus", "1e300"], ["youngs_modulus"]),
        (["--soften", "1e300"], ["soften"]),
        (["--soften", "nan"], ["soften"]),
        (["--soften", "0.5"], ["soften"]),
        (["--material", "rigid", "--soften", "3"], ["no stiffness"]),
        (["--material", "rigid", "--youngs-modulus", "1e5"], ["--youngs-modulus", "no stiffness"]),
        (["--material", "jely"], ["jelly"]),
        (["--anchor-mask", "/no/such/mask.npy"], ["`--anchor-mask` means nothing", "--anchor mask"]),
        (["--anchor-mask", "/no/such.npy", "--anchor", "base"], ["`--anchor-mask` means nothing"]),
        (["--anchor", "mask", "--anchor-mask", "/no/such/mask.npy"], ["there is no anchor mask"]),
        (["--anchor", "mask"], ["needs a mask"]),
        (["--anchor", "box"], ["needs a box"]),
        (["--anchor-box", "1", "1", "1", "1", "1", "1"], ["`--anchor-box` means nothing"]),
        (["--anchor", "box", "--anchor-box", "1", "1", "1", "-1", "1", "1"], ["half_size"]),
        (["--anchor", "box", "--anchor-box", "1", "1", "1e300", "1", "1", "1"], ["point"]),
        (["--physgm", "/no/such.json"], ["PhysGM"]),
        (["--physgm", "/no/such.json", "--material", "steel"], ["`--physgm` and `--material`"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) and "-" in value[0][:1] else "",
)
def test_options_beyond_sense_or_without_meaning_are_refused(options, fragments, run):
    run(options, *fragments)


@pytest.mark.parametrize(
    ("prompt", "fragment"),
    [
        ("push it to the left " * 60_000, "longer than"),
        ("push \x07 it", "no text"),
        ("push \udcff it", "no text"),
        ("\x00", "a zero byte"),
    ],
)
def test_prompts_that_are_no_sentence_are_refused_at_once(prompt, fragment, run):
    run([], fragment, prompt=prompt)


@pytest.mark.parametrize(
    "path", ["x" * 5000, "/dev/full", "", ".", "a\udcff", "no\0where", "loop"], ids=lambda p: ascii(p)[:9]
)
def test_paths_that_cannot_be_read_are_refused(path, tmp_path, capsys, robot_path):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    path = str(tmp_path / path) if path == "loop" else path
    out = tmp_path / "out"
    refused(capsys, ["run", "--object", path, "--prompt", PROMPT, "--out", out, *SMALL])
    refused(capsys, ["simulate", path, "--out", out])
    refused(capsys, ["import-physgaussian", path, "--object", robot_path, "--out", out / "a.json"])
    refused(capsys, ["report", path if path != "." else tmp_path / "gone"])
    scene = tmp_path / "scene.json"
    scene.write_text('{"source": {"path": "x.ply"}}')
    refused(capsys, ["simulate", scene, "--object", path, "--out", out])
    assert not out.exists()


@pytest.mark.parametrize(
    ("card", "fragment"),
    [
        (b'{"kind": "plnat"}', "`plant`"),
        (b'{"knid": "plant"}', "`kind`"),
        (b'{"azimuth_degrees": 1e300}', "azimuth_degrees"),
        (b'{"up": "+w"}', "up"),
        (b"[" * 100_000, "nested"),
        (b"\xff\xfe{", "UTF-16"),
    ],
)
def test_cards_are_read_with_care(card, fragment, tmp_path, robot_path, run):
    item = tmp_path / "thing.ply"
    item.write_bytes(robot_path.read_bytes())
    (tmp_path / "thing.card.json").write_bytes(card)
    run([], "thing.card.json", fragment, item=item)


def test_every_kind_is_found_by_its_name_its_words_and_their_plurals():
    for kind, prior in PRIORS.items():
        assert find_kind(kind) == find_kind(f" {kind.upper()} ") == kind
        for word in prior.words:
            assert find_kind(word) == find_kind(word + "s") == kind


def test_make_takes_no_seed_that_a_generator_cannot(tmp_path, capsys):
    for seed in ("-1", "4294967296"):
        refused(capsys, ["make", "jelly", "--out", tmp_path / "a.ply", "--seed", seed], "--seed")
    assert not list(tmp_path.iterdir())


# --- terminals -------------------------------------------------------------------------------------------


@contextlib.contextmanager
def ascii_terminal():
    """Standard output and error as a terminal in plain ASCII has them; gives what was written to each."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="ascii", write_through=True) for _ in range(2))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield lambda: [stream.buffer.getvalue().decode("ascii") for stream in (out, err)]


def test_all_commands_speak_ascii_where_the_terminal_does():
    with ascii_terminal() as written:
        assert main(["materials"]) == 0 and main(["materials", "dry_sand"]) == 0
        observer = ConsoleObserver()
        observer.stage("r\u00e9sum\u00e9 \u63a8 [x]")
        observer.close()
        warn("\u2717 \ud800")
    out, err = written()
    assert "kg/m^3" in out and "33 degrees" in out
    assert "- resume \\u63a8 [x]" in err and "x \\ud800" in err


def test_json_is_json_in_ascii_too():
    with ascii_terminal() as written:
        assert main(["materials", "--json"]) == 0
    assert len(json.loads(written()[0])) > 30


def test_a_process_with_an_ascii_locale_works():
    """The whole way, with the environment that does it: LANG=C without Python's own repair of it."""
    environment = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-c", "import sys; from physagent_jax.cli import main; sys.exit(main())"]
    options = dict(env=environment, capture_output=True, cwd=Path(__file__).parents[1])
    result = subprocess.run([*command, "materials", "steel"], **options)
    assert result.returncode == 0, result.stderr
    assert b"kg/m^3" in result.stdout
    odd = b"pousse \xc3\xa0 gauche"
    result = subprocess.run([*command, "run", "--prompt", odd, "--object", "x", "--out", "y"], **options)
    assert result.returncode == 2 and b"no text in this terminal" in result.stderr, result.stderr


def test_a_mask_is_held_against_its_file(tmp_path, run, robot_path):
    """Refused before the sentence is read; what is wrong inside the file is told when the scene is compiled."""
    np.save(tmp_path / "mask.npy", np.zeros(3))
    run(["--anchor", "mask", "--anchor-mask", str(tmp_path)], "a folder")
