"""A run as data: written, read, compared; the same whichever way it is said."""

import json
import subprocess
import sys

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec, read_spec
from tests.run.specs import small

# Other than each field's default, and allowed.
OTHERS = {
    "object.up": "-y",
    "object.kind": "plant",
    "object.opacity_threshold": 0.1,
    "object.splat_encoding": "log-logit",
    "object.extent": 0.8,
    "object.parts": [{"name": "hat", "point": [0.0, 0.0, 0.1]}],
    "prompt": "drop it",
    "preset": "paper",
    "overrides.cells": 64,
    "overrides.frame_count": 12,
    "overrides.max_particles": 900,
    "overrides.width": 64,
    "overrides.height": 64,
    "material.name": "muscle",
    "material.soften": 2.0,
    "material.youngs_modulus": 2e4,
    "material.poissons_ratio": 0.1,
    "material.density": 300.0,
    "material.damping_ratio": 0.05,
    "anchor.kind": "top",
    "camera.azimuth_degrees": 30.0,
    "camera.elevation_degrees": 30.0,
    "world": "free",
    "camera.follow": True,
    "friction": 0.5,
    "perception.prompt": {"frame": 3, "points": [[0.5, 0.25]], "labels": [True], "box": [0.1, 0.1, 0.9, 0.9]},
    "rounds": 2,
    "probe": True,
    "seed": 7,
    "ledger": True,
    "save.video_size": [64, 48],
    "save.caption": True,
    "save.arrows": True,
    "save.frames": True,
    "save.splats": "glb",
}


def plain(spec):
    return spec.model_dump(mode="json")


def changed(spec, field, value):
    data = plain(spec)
    *branches, leaf = field.split(".")
    branch = data
    for each in branches:
        branch = branch[each]
    branch[leaf] = value
    return RunSpec.model_validate(data)


@pytest.mark.parametrize("suffix", ["json", "yaml"])
def test_a_spec_survives_its_file(suffix, tmp_path, robot_path):
    spec = small(robot_path)
    for field, value in OTHERS.items():
        spec = changed(spec, field, value)
    path = tmp_path / f"spec.{suffix}"
    path.write_text(spec.model_dump_json() if suffix == "json" else yaml.safe_dump(plain(spec)))
    assert read_spec(path) == spec


@pytest.mark.parametrize("field", OTHERS)
def test_whatever_is_said_otherwise_makes_it_another_run(field, robot_path):
    one, other = small(robot_path), changed(small(robot_path), field, OTHERS[field])
    assert resolve(one).inputs["settings"] != resolve(other).inputs["settings"]


def test_every_field_is_tried():
    """Those left out name files, have one choice only, are in the names of agents (the model), or are a photo's."""

    def leaves(model, prefix=""):
        for name, field in model.model_fields.items():
            inner = field.annotation
            if isinstance(inner, type) and hasattr(inner, "model_fields") and name not in ROLES:
                yield from leaves(inner, f"{prefix}{name}.")
            else:
                yield prefix + name

    files = {"object.path", "material.physgm", "anchor.mask_path", "anchor.point", "anchor.half_size"}
    files |= {"agents.model", "object.photo"}
    assert set(leaves(RunSpec)) == set(OTHERS) | files | {f"{where}.{role}" for role, where in ROLES.items()}


ROLES = {role: "agents" for role in ("semantic", "planner", "executor")}
ROLES |= {role: "perception" for role in ("segmenter", "depth", "tracker")}


PROMPTS = {
    "none": None,
    "point": {"points": [[0.5, 0.5]]},
    "elsewhere": {"points": [[0.5, 0.6]]},
    "not the object": {"points": [[0.5, 0.5]], "labels": [False]},
    "later": {"frame": 2, "points": [[0.5, 0.5]]},
    "box": {"box": [0, 0, 1, 1]},
    "both": {"points": [[0.5, 0.5]], "box": [0, 0, 1, 1]},
    "mask": {"mask_path": "mask.npy"},
    "another mask": {"mask_path": "other.npy"},
    "a copy of the mask": {"mask_path": "far/copy.npy"},
}


@pytest.fixture
def prompted(tmp_path, robot_path):
    """Make a resolved run with a prompt of `PROMPTS`, in a folder with the masks."""
    left, whole = np.zeros((96, 96), bool), np.ones((96, 96), bool)
    left[:, :40] = True
    (tmp_path / "far").mkdir()
    for name, mask in {"mask.npy": left, "other.npy": whole, "far/copy.npy": left}.items():
        np.save(tmp_path / name, mask)
    return lambda prompt: resolve(small(robot_path.resolve(), perception={"prompt": prompt}), tmp_path)


def test_another_prompt_is_another_run_and_another_place_of_its_mask_is_not(prompted):
    inputs = {name: prompted(prompt).inputs for name, prompt in PROMPTS.items()}
    assert inputs.pop("a copy of the mask") == inputs["mask"]
    assert len({json.dumps(each, sort_keys=True) for each in inputs.values()}) == len(inputs)


def test_a_run_keeps_its_prompt_and_where_the_mask_is(prompted, tmp_path):
    run = prompted(PROMPTS["mask"])
    kept = run.spec.located(run.base_dir)
    assert kept.perception.prompt.mask_path == str(tmp_path.resolve() / "mask.npy")
    assert tmp_path.resolve() / "mask.npy" in run.files
    assert resolve(RunSpec.model_validate_json(kept.model_dump_json()), "/").inputs == run.inputs


@pytest.mark.parametrize(
    ("prompt", "words"),
    [
        ({}, "points, a box, both, or a mask alone"),
        ({"box": [0, 0, 1, 1], "mask_path": "mask.npy"}, "a mask alone"),
        ({"labels": [True], "box": [0, 0, 1, 1]}, "one per point"),
        ({"points": [[0.5, 0.5]], "labels": [True, False]}, "one per point"),
        ({"points": [[48, 48]]}, "less than or equal to 1"),
        ({"points": []}, "at least 1"),
        ({"box": [0.5, 0, 0.5, 1]}, "x0 < x1"),
        ({"frame": -1, "box": [0, 0, 1, 1]}, "greater than or equal to 0"),
        ({"frame": 10, "box": [0, 0, 1, 1]}, "Stay within 0..9"),
        ({"mask_path": "none.npy"}, "none.npy"),
        ({"mask_path": "small.npy"}, "shape (96, 96)"),
        ({"mask_path": "numbers.npy"}, "one bool per pixel"),
        ({"mask_path": "empty.npy"}, "shows no object"),
    ],
)
def test_a_prompt_that_says_nothing_is_refused(prompt, words, prompted, tmp_path):
    np.save(tmp_path / "small.npy", np.ones((9, 9), bool))
    np.save(tmp_path / "numbers.npy", np.ones((96, 96)))
    np.save(tmp_path / "empty.npy", np.zeros((96, 96), bool))
    with pytest.raises((UserError, ValidationError)) as caught:
        prompted(prompt)
    assert words in str(caught.value)


def test_where_the_object_lies_makes_no_other_run(tmp_path, robot_path):
    for name in (robot_path.name, robot_path.with_suffix(".card.json").name):
        (tmp_path / name).write_bytes((robot_path.parent / name).read_bytes())
    elsewhere = resolve(small(robot_path.name), tmp_path)
    assert elsewhere.inputs == resolve(small(robot_path)).inputs


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("object: {path: a.ply}\nprompt: push\nrouns: 2\n", "`rounds`"),
        ("object: {path: a.ply}\nprompt: push\nagents: {planner: rulez}\n", "`rules`"),
        ("object: {path: a.ply}\nprompt: push\nperception: {tracker: {name: flo}}\n", "`flow`"),
        ("object: &a {path: a.ply}\nprompt: push\nmaterial: *a\n", "references"),
        ("object: {path: 2001-01-01}\nprompt: push\n", "YAML"),
        ("object: {path: a.ply}\nprompt: push\nperception: {prompt: {frame: 1}}\n", "a mask alone"),
        ("object: {path: a.ply}\nprompt: push\nperception: {prompt: {box: [0, 0, 2, 1]}}\n", "box.2"),
        ("object: {path: a.ply}\nprompt: push\nfriction: .nan\n", "number"),
        ("a: [", "YAML"),
        ("!!python/object/apply:os.system [true]", "YAML"),
        ("object: {path: a.ply}\nprompt: push\nanchor: {kind: mask}\n", "needs a mask"),
        ("object: {path: a.ply}\nprompt: push\nanchor: {point: [1, 1, 1]}\n", "means nothing"),
        ("- 1\n", "RunSpec"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(text, fragment, tmp_path, capsys):
    path = tmp_path / "spec.yaml"
    path.write_text(text)
    assert main(["run", "--spec", str(path), "--out", str(tmp_path / "run")]) == 2
    (line,) = [each for each in capsys.readouterr().err.splitlines() if each]
    assert fragment in line, line
    assert not (tmp_path / "run").exists()


def test_a_spec_and_options_exclude_each_other(tmp_path, capsys, robot_path):
    path = tmp_path / "spec.json"
    path.write_text(small(robot_path).model_dump_json())
    assert main(["run", "--spec", str(path), "--out", str(tmp_path / "run"), "--frames", "5"]) == 2
    assert "--frames" in capsys.readouterr().err
    assert main(["run", "--out", str(tmp_path / "run"), "--prompt", "push it"]) == 2
    assert "--object must be given" in capsys.readouterr().err


def test_agents_by_name_with_options_that_they_do_not_take(robot_path):
    from physagent_jax.run.chosen_agents import open_agents

    spec = small(robot_path, agents={"planner": {"name": "rules", "options": {"temperature": 0.5}}})
    with pytest.raises(UserError, match="does not take these options"), open_agents(spec):
        pass
    with pytest.raises(ValidationError):
        small(robot_path, agents={"planner": 3})


def test_a_spec_is_read_without_jax():
    code = "import sys, physagent_jax.run.spec; print('jax' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]


def test_a_run_leaves_its_spec_which_makes_the_same_run(tmp_path, robot_path, capsys):
    """From another folder too: its paths are absolute."""
    first = tmp_path / "first"
    spec = tmp_path / "spec.yaml"
    asked = small(robot_path, frames=4, particles=300, resolution=32, rounds=1)
    spec.write_text(yaml.safe_dump(plain(asked)))
    assert main(["run", "--spec", str(spec), "--out", str(first)]) == 0
    assert main(["run", "--spec", str(first / "run.json"), "--out", str(tmp_path / "second"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[-1])["frames"] == 4
    for name in ("run.json", "scene.json", "perception.mp4", "motion.npz"):
        assert (first / name).read_bytes() == (tmp_path / "second" / name).read_bytes(), name
