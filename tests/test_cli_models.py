"""`physagent models`, and the options that choose perception's models."""

import json

import pytest

from physagent_jax.chat.registry import MODELS as CHAT_MODELS
from physagent_jax.cli import main
from physagent_jax.cli.options import to_spec
from physagent_jax.cli.run import Run
from physagent_jax.core.errors import UserError
from physagent_jax.core.model_files import find_snapshot, locate_folder
from physagent_jax.perception.backends import DEPTH_ESTIMATORS, SEGMENTERS, TRACKERS
from physagent_jax.run.models import MODELS, examine_model, find_card, warn_of_licences
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import PerceptionChoice, RunSpec
from physagent_jax.run.video_judges import JUDGES
from tests.run.specs import small

REGISTRIES = {
    "segmenter": SEGMENTERS,
    "depth": DEPTH_ESTIMATORS,
    "tracker": TRACKERS,
    "chat": CHAT_MODELS,
    "judge": JUDGES,
}


@pytest.fixture(autouse=True)
def empty_places(monkeypatch, tmp_path):
    monkeypatch.setenv("PHYSAGENT_MODELS", str(tmp_path / "models"))
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path / "hub"))
    return tmp_path


def make_snapshot(folder, identifier):
    snapshot = folder / "hub" / f"models--{identifier.replace('/', '--')}" / "snapshots" / "abc"
    snapshot.mkdir(parents=True)
    (snapshot / "config.json").write_text("{}")
    return snapshot


def test_every_registered_model_has_one_entry_and_none_is_made_up():
    for role, registry in REGISTRIES.items():
        assert sorted(each.name for each in MODELS if each.role == role) == sorted(registry.entries)
    assert {each.role for each in MODELS} == {*REGISTRIES, "clip"}


def test_entries_are_whole():
    for card in MODELS:
        assert bool(card.packages) == bool(card.extra), card.name
        assert sum(map(bool, (card.hub, card.file, card.given))) <= 1, card.name
        assert bool(card.hub or card.file) <= bool(card.fetch and card.option), card.name
        with_files = card.hub or card.file
        assert (card.weights != "none needed") >= bool(with_files), card.name


def test_the_command_lists_them_all(capsys, empty_places):
    assert main(["models"]) == 0
    out = capsys.readouterr().out
    assert all(f"  {card.name} (" in out and card.what in out for card in MODELS)
    assert (
        "  rgbd (ready)" in out
        and "  sam2 (not ready)" in out
        and "hf download facebook/sam2.1-hiera-small" in out
    )
    assert f"not found: {empty_places}/models/co-tracker/checkpoints/scaled_offline.pth" in out
    assert out.count("CC BY-NC 4.0") >= 3


def test_json_says_the_same(capsys, empty_places):
    snapshot = make_snapshot(empty_places, "facebook/sam2.1-hiera-small")
    assert main(["models", "--json"]) == 0
    entries = {(each["role"], each["name"]): each for each in json.loads(capsys.readouterr().out)}
    assert list(entries) == [(card.role, card.name) for card in MODELS]
    assert entries["depth", "sensor"]["ready"] and entries["depth", "sensor"]["get"] == ""
    sam2 = entries["segmenter", "sam2"]
    assert sam2["found"] and sam2["place"] == str(snapshot) and "hf download" not in sam2["get"]
    assert sam2["ready"] == (not sam2["lacking_packages"])


def test_a_package_that_is_missing_is_told_with_the_command(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    state = examine_model(find_card("tracker", "cotracker"))
    assert state.lacking == ("torch",) and not state.ready
    assert state.get.startswith("pip install ") and "vision]" in state.get and " && git clone " in state.get


def test_a_snapshot_counts_only_if_it_is_whole(empty_places):
    snapshot = make_snapshot(empty_places, "a/b")
    assert find_snapshot("a/b") == snapshot and locate_folder("a/b", "`m`") == str(snapshot)
    assert find_snapshot("a/b", "model.safetensors") is None
    (snapshot / "config.json").unlink()
    assert find_snapshot("a/b") is None
    with pytest.raises(UserError, match="not on this machine.*hf download a/b"):
        locate_folder("a/b", "`m`")
    assert locate_folder("a/b", "`m`", download=True) == "a/b"


# --- in a run -----------------------------------------------------------------------------------------


def choose(robot_path, tmp_path, **options):
    return to_spec(vars(Run(out=tmp_path, object=robot_path, prompt="push it", **options))).perception


def test_a_preset_that_differs_takes_a_path(robot_path, tmp_path):
    chosen = choose(robot_path, tmp_path, perception="rgb,tracker=gmflow:flow.pkl")
    assert (chosen.tracker.name, chosen.tracker.options) == ("gmflow", {"weights": "flow.pkl"})
    assert (chosen.segmenter.name, chosen.depth.name) == ("colour", "ground_contact")


def test_options_choose_by_name_or_name_and_path(robot_path, tmp_path):
    chosen = choose(
        robot_path,
        tmp_path,
        segmenter="sam2:/models/sam2",
        depth="depth_anything",
        tracker="cotracker:co-tracker",
    )
    assert (chosen.segmenter.name, chosen.segmenter.options) == ("sam2", {"weights": "/models/sam2"})
    assert (chosen.depth.name, chosen.depth.options) == ("depth_anything", {})
    assert chosen.tracker.options == {"path": "co-tracker"}
    assert choose(robot_path, tmp_path, depth="depth_anything_3:venv/bin/python").depth.options == {
        "python": "venv/bin/python"
    }
    assert choose(robot_path, tmp_path) == PerceptionChoice()


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (["--segmenter", "sam"], "`--segmenter` is not known"),
        (["--depth", "sensor:file"], "`--depth sensor` takes no path"),
        (["--tracker", "cotracker:"], "`--tracker` lacks the path"),
        (["--tracker", "trackers:x"], "cotracker"),
        (["--tracker", "cotracker:nowhere"], "no checkout of co-tracker"),
    ],
)
def test_bad_choices_are_one_line_and_leave_nothing(options, fragment, tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    arguments = ["run", "--object", str(robot_path), "--prompt", "push it left", "--out", str(out), *options]
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert "physagent: " in error and fragment in error and "Traceback" not in error
    assert not out.exists()


def test_weights_that_allow_no_commercial_use_are_warned_of(robot_path):
    perception = {"tracker": {"name": "cotracker"}, "depth": {"name": "depth_anything"}}
    warnings = resolve(small(robot_path, "push it", perception=perception)).warnings
    (warning,) = (text for text in warnings if "licence" in text)
    assert warning.startswith("`perception.tracker` cotracker: the licence CC BY-NC 4.0")
    for name, weights, warned in (
        ("depth_anything", "depth-anything/Depth-Anything-V2-Large-hf", True),
        ("depth_anything", "depth-anything/Depth-Anything-V2-Small-hf", False),
        ("depth_anything_3", "depth-anything/DA3-LARGE-1.1", True),
        ("depth_anything_3", "depth-anything/DA3METRIC-LARGE", False),
    ):
        choice = PerceptionChoice.model_validate({"depth": {"name": name, "options": {"weights": weights}}})
        assert bool(warn_of_licences(choice)) == warned, weights


def test_paths_of_models_are_the_specs_and_no_part_of_what_a_run_is(robot_path, tmp_path):
    (tmp_path / "weights").mkdir()

    def specify(**options):
        spec = small(
            robot_path, "push it", perception={"depth": {"name": "depth_anything", "options": options}}
        )
        return RunSpec.model_validate(spec.model_dump(mode="json"))

    here = specify(weights="weights").located(tmp_path)
    assert here.perception.depth.options == {"weights": str(tmp_path / "weights")}
    assert specify(weights="owner/name").located(tmp_path).perception.depth.options == {
        "weights": "owner/name"
    }
    assert here.identity() == specify(weights="elsewhere").identity()
    assert here.identity() != specify(weights="weights", ground_height=0.5).identity()
