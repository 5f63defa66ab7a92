"""The command line: every bad input gives one clear line and exit code 2, and leaves nothing behind."""

import json
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

from physagent_jax.cli import main
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.store import RunStore
from physagent_jax.scene.config import Filling, SceneConfig, Source, Timing, dump_scene

PROMPT = "push the robot to the left"
SMALL = ["--frames", "4", "--particles", "300", "--resolution", "64", "--max-iterations", "1"]
TOO_STIFF = ["--preset", "paper", "--youngs-modulus", "1e13", "--max-minutes", "1e9"]


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")


def refused(capsys, arguments, *fragments):
    """Run a command that must be refused; return its one line."""
    assert main([str(argument) for argument in arguments]) == 2
    error = capsys.readouterr().err
    lines = [line for line in error.splitlines() if line.startswith("physagent: ")]
    assert len(lines) == 1, error
    assert "Traceback" not in error
    for fragment in fragments:
        assert fragment in lines[0], lines[0]
    return lines[0]


@pytest.fixture
def robot_bytes(robot_path):
    return robot_path.read_bytes()


def make_file(path, content):
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("case", ["missing", "empty", "text", "truncated", "no vertices"])
def test_unreadable_objects(case, tmp_path, robot_bytes, capsys):
    header_end = robot_bytes.index(b"end_header\n") + len(b"end_header\n")
    contents = {
        "empty": b"",
        "text": b"hello, I am not a PLY\n",
        "truncated": robot_bytes[: len(robot_bytes) // 2],
        "no vertices": robot_bytes[:header_end].replace(b"element vertex 3835", b"element vertex 0"),
    }
    path = tmp_path / "object.ply"
    if case in contents:
        make_file(path, contents[case])
    out = tmp_path / "run"
    refused(capsys, ["run", "--object", path, "--prompt", PROMPT, "--out", out, *SMALL], "object.ply")
    assert not out.exists()


def test_nothing_left_after_the_opacity_filter(tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    arguments = [
        "run",
        "--object",
        robot_path,
        "--prompt",
        PROMPT,
        "--out",
        out,
        "--opacity-threshold",
        "0.99999",
        *SMALL,
    ]
    refused(capsys, arguments, "opacity")
    assert not out.exists()


@pytest.mark.parametrize("prompt", ["", "   ", "asdf qwer zxcv", "12345"])
def test_prompts_without_meaning(prompt, tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    refused(capsys, ["run", "--object", robot_path, "--prompt", prompt, "--out", out, *SMALL])
    assert not out.exists()


def test_unwritable_output(tmp_path, robot_path, capsys):
    blocker = make_file(tmp_path / "file", b"x")
    for out in (blocker, blocker / "run"):
        refused(capsys, ["run", "--object", robot_path, "--prompt", PROMPT, "--out", out, *SMALL], str(out))
    assert blocker.read_bytes() == b"x"


def test_a_folder_with_other_things_in_it_is_not_touched(tmp_path, robot_path, capsys):
    make_file(tmp_path / "thesis.tex", b"precious")
    arguments = ["run", "--object", robot_path, "--prompt", PROMPT, "--out", tmp_path, *SMALL]
    refused(capsys, arguments, "not a run folder")
    refused(capsys, [*arguments, "--overwrite"], "not a run folder")
    assert (tmp_path / "thesis.tex").read_bytes() == b"precious"


@pytest.mark.parametrize(
    ("option", "fragment"),
    [
        (["--frames", "1"], "frame_count"),
        (["--particles", "2"], "max_particles"),
        (["--resolution", "3"], "width"),
        (["--youngs-modulus", "-5"], "youngs_modulus"),
        (["--poissons-ratio", "0.5"], "poissons_ratio"),
        (["--density", "nan"], "density"),
        (["--max-iterations", "0"], "max-iterations"),
        (["--elevation", "90"], "elevation"),
    ],
)
def test_options_out_of_range_name_the_field(option, fragment, tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    arguments = ["run", "--object", robot_path, "--prompt", PROMPT, "--out", out, *SMALL, *option]
    refused(capsys, arguments, fragment)
    assert not out.exists()


# --- scene files -------------------------------------------------------------------------------------


@pytest.fixture
def scene_file(tmp_path, robot_path):
    config = SceneConfig(
        source=Source(path=str(robot_path), up="-y"),
        filling=Filling(max_particles=300),
        timing=Timing(frame_count=3),
    )
    path = tmp_path / "scene.json"
    path.write_text(dump_scene(config))
    return path


def edited(path, **changes):
    """The scene with dotted keys changed, e.g. ``timing__substep_dt``."""
    data = json.loads(path.read_text())
    for key, value in changes.items():
        *parents, last = key.split("__")
        place = data
        for parent in parents:
            place = place[parent]
        place[last] = value
    path.write_text(json.dumps(data))
    return path


@pytest.mark.parametrize(
    ("changes", "fragments"),
    [
        ({"timing__substep_dt": 0.04}, ["above the stable bound", "Use `substep_dt` <="]),
        ({"material__youngs_modulus": float("nan")}, ["NaN"]),
        ({"material__young_modulus": 1e5}, ["material.young_modulus", "Extra inputs"]),
        ({"colour": "blue"}, ["colour"]),
        (
            {"force_field__actions": [{"action_type": "push", "vector": [1, 0, 0]}]},
            ["force_field.actions.0.action_type"],
        ),
        ({"force_field__actions": [{"action_type": "torque", "vector": [0, 0, 0]}]}, ["vector", "zero"]),
        ({"source__path": "nowhere.ply"}, ["nowhere.ply"]),
        ({"source__sha256": "0" * 64}, ["sha256"]),
        ({"anchor__kind": "mask"}, ["mask_path"]),
        ({"version": 2}, ["version"]),
    ],
)
def test_broken_scenes(changes, fragments, scene_file, tmp_path, capsys):
    out = tmp_path / "out"
    refused(capsys, ["simulate", edited(scene_file, **changes), "--out", out], *fragments)
    assert not out.exists()


def test_scene_files_that_are_not_json(tmp_path, capsys):
    refused(
        capsys,
        ["simulate", make_file(tmp_path / "x.json", b"{"), "--out", tmp_path / "out"],
        "not valid JSON",
    )
    refused(
        capsys,
        ["simulate", make_file(tmp_path / "y.json", b"\xff\xfe"), "--out", tmp_path / "out"],
        "not valid JSON",
    )
    refused(capsys, ["simulate", tmp_path / "z.json", "--out", tmp_path / "out"], "cannot read")
    refused(capsys, ["simulate", make_file(tmp_path / "l.json", b"[1]"), "--out", tmp_path / "out"])


def test_simulate_plays_a_scene_and_prints_one_line_of_json(scene_file, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["simulate", str(scene_file), "--out", str(out), "--json", "--save-splats"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["frames"] == 3 and summary["substeps"] > 0
    assert {"scene.json", "simulation.json", "video.mp4", "motion.npz", "splats"} <= {
        p.name for p in out.iterdir()
    }
    assert len(list((out / "splats").glob("*.ply"))) == 3


def test_physgaussian_configs_need_their_object(tmp_path, robot_path, capsys):
    config = {"material": "jelly", "E": 2e4, "nu": 0.3, "density": 200, "g": [0, 0, -9.8], "n_grid": 50,
              "substep_dt": 1e-4, "frame_dt": 0.01, "frame_num": 2, "pic_damping": 0.1,
              "boundary_conditions": [{"type": "bounding_box"}]}  # fmt: skip
    path = tmp_path / "config.json"
    path.write_text(json.dumps(config))
    refused(capsys, ["simulate", path, "--out", tmp_path / "out"], "--object")
    scene = tmp_path / "imported.json"
    assert main(["import-physgaussian", str(path), "--object", str(robot_path), "--out", str(scene)]) == 0
    assert "pic_damping" in capsys.readouterr().err
    assert json.loads(scene.read_text())["timing"]["substep_dt"] == 1e-4


# --- the small commands ------------------------------------------------------------------------------


@pytest.mark.parametrize("what", ["plant", "loaf", "jelly"])
def test_make_writes_an_object_and_its_card(what, tmp_path, capsys):
    path = tmp_path / f"{what}.ply"
    assert main(["make", what, "--out", str(path), "--seed", "3"]) == 0
    first = path.read_bytes()
    assert json.loads((tmp_path / f"{what}.card.json").read_text())["name"] == what
    assert main(["make", what, "--out", str(path), "--seed", "3"]) == 0
    assert path.read_bytes() == first


@pytest.mark.parametrize("what", ["scene", "force-field", "motion-report", "judgement"])
def test_schema_prints_json_schema(what, capsys):
    assert main(["schema", what]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["type"] == "object" and schema["additionalProperties"] is False


def test_debug_shows_the_traceback(tmp_path):
    from physagent_jax.core.errors import UserError

    with pytest.raises(UserError):
        main(["simulate", str(tmp_path / "none.json"), "--out", str(tmp_path / "out"), "--debug"])


def test_up_axes_and_presets_are_written_as_in_the_help(tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    options = ["--up", "-y", "--preset", "fast", "--opacity-threshold", "0.99999", *SMALL]
    refused(capsys, ["run", "--object", robot_path, "--prompt", PROMPT, "--out", out, *options], "opacity")


def test_a_scene_that_cannot_be_simulated_leaves_nothing(tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    arguments = ["run", "--object", robot_path, "--prompt", PROMPT, "--out", out, *TOO_STIFF, *SMALL]
    refused(capsys, arguments, "would take more than 100,000 substeps: the material is so stiff")
    assert not out.exists()


def test_matter_that_never_moves_has_no_bound_and_plays(scene_file, tmp_path, capsys):
    """The stable step of what has no stress is infinite, which no JSON can say."""
    out = tmp_path / "out"
    assert (
        main(["simulate", str(edited(scene_file, material={"model": "stationary"})), "--out", str(out)]) == 0
    )
    record = json.loads((out / "simulation.json").read_text())
    assert record["stable_dt"] is None and record["kinetic_energy"] == [0, 0, 0]


# --- files of others ---------------------------------------------------------------------------------


@pytest.fixture
def earlier_run(tmp_path):
    """A finished run, and an object that a user keeps in its folder."""
    path = tmp_path / "run"
    earlier = Manifest(command="", prompt="earlier", versions={}, platform="", seed=0, inputs={})
    with RunStore.open(path, earlier) as store:
        store.begin()
        store.claimed("video.mp4").write_bytes(b"the earlier video")
        store.finish()
    return path


def snapshot(folder):
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_refused_run_leaves_the_earlier_one_whole(earlier_run, robot_path, tmp_path, capsys):
    """Sentence, object and scene are checked before anything is replaced, and a failed simulation gives it back."""
    mine = make_file(earlier_run / "object.ply", robot_path.read_bytes())
    before = snapshot(earlier_run)
    for prompt, object_path, extra in (
        ("asdf qwer zxcv", robot_path, []),
        (PROMPT, tmp_path / "nowhere.ply", []),
        (PROMPT, robot_path, TOO_STIFF),
        (PROMPT, mine, TOO_STIFF),
    ):
        arguments = ["run", "--object", object_path, "--prompt", prompt, "--out", earlier_run, "--overwrite"]
        refused(capsys, [*arguments, *SMALL, *extra])
        assert snapshot(earlier_run) == before


def test_an_object_that_the_earlier_run_wrote_is_not_replaced(earlier_run, robot_path, capsys):
    with RunStore.open(earlier_run, read_manifest(earlier_run)) as store:
        make_file(store.claimed("0000.ply"), robot_path.read_bytes())
    before = snapshot(earlier_run)
    arguments = [
        "--object",
        earlier_run / "0000.ply",
        "--prompt",
        PROMPT,
        "--out",
        earlier_run,
        "--overwrite",
    ]
    refused(capsys, ["run", *arguments, *SMALL], "0000.ply", "needed for the new one")
    assert snapshot(earlier_run) == before


def read_manifest(folder):
    return Manifest.model_validate_json((folder / "manifest.json").read_bytes())


def test_simulate_does_not_write_over_what_it_did_not_make(scene_file, earlier_run, tmp_path, capsys):
    before = snapshot(earlier_run)
    refused(capsys, ["simulate", scene_file, "--out", earlier_run], "another run", "--overwrite")
    (tmp_path / "other").mkdir()
    make_file(tmp_path / "other" / "video.mp4", b"precious")
    for extra in ([], ["--overwrite"]):
        refused(capsys, ["simulate", scene_file, "--out", tmp_path / "other", *extra], "not a run folder")
    assert snapshot(earlier_run) == before
    assert (tmp_path / "other" / "video.mp4").read_bytes() == b"precious"
    assert main(["simulate", str(scene_file), "--out", str(earlier_run), "--overwrite"]) == 0
    assert main(["simulate", str(scene_file), "--out", str(earlier_run)]) == 0  # the same is there already
    after = snapshot(earlier_run)
    refused(
        capsys,
        ["simulate", earlier_run / "scene.json", "--out", earlier_run, "--overwrite", "--ledger"],
        "scene.json",
        "needed for the new one",
    )
    assert snapshot(earlier_run) == after


def test_make_and_import_do_not_write_over_other_files(tmp_path, robot_path, capsys):
    card = make_file(tmp_path / "a.card.json", b"precious")
    refused(capsys, ["make", "jelly", "--out", tmp_path / "a.ply"], "a.card.json", "--overwrite")
    assert not (tmp_path / "a.ply").exists() and card.read_bytes() == b"precious"
    assert main(["make", "jelly", "--out", str(tmp_path / "a.ply"), "--overwrite"]) == 0
    assert json.loads(card.read_text())["name"] == "jelly"
    config = make_file(
        tmp_path / "config.json", b'{"n_grid": 50, "substep_dt": 1e-4, "frame_num": 2, "g": [0, 0, -9.8]}'
    )
    scene = make_file(tmp_path / "scene.json", b"precious")
    arguments = ["import-physgaussian", str(config), "--object", str(robot_path), "--out", str(scene)]
    refused(capsys, arguments, "scene.json exists")
    assert scene.read_bytes() == b"precious"
    assert main([*arguments, "--overwrite"]) == 0


def test_report_does_not_replace_a_page_of_another_hand(earlier_run, capsys):
    make_file(earlier_run / "report.html", b"<html>my own</html>")
    refused(capsys, ["report", earlier_run], "report.html", "--overwrite")
    assert (earlier_run / "report.html").read_bytes() == b"<html>my own</html>"
    assert main(["report", str(earlier_run), "--overwrite"]) == 0
    assert main(["report", str(earlier_run)]) == 0  # its own page


def test_the_command_that_is_installed_is_the_process_of_python_m(tmp_path):
    root = Path(__file__).resolve().parents[1]
    module, name = tomllib.loads((root / "pyproject.toml").read_text())["project"]["scripts"][
        "physagent"
    ].split(":")
    assert callable(getattr(import_module(module), name))
    for arguments, code in ((["materials"], 0), (["run", "--out", str(tmp_path / "run")], 2)):
        done = subprocess.run([sys.executable, "-m", "physagent_jax", *arguments], capture_output=True)
        assert done.returncode == code
