"""Parts by name at the command line: `inspect` lists them, `plan` says which was taken, `--part` names others."""

import json

import imageio.v3 as iio
import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.cli.parts import parse_part
from physagent_jax.core.errors import UserError
from physagent_jax.run.part_marks import COLOURS
from tests.scene.test_named_parts import FIGURE, make_pot, write_glb, write_obj

pytestmark = pytest.mark.usefixtures("quick_plans")


@pytest.fixture(autouse=True)
def in_a_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def pot(tmp_path):
    return write_glb(tmp_path / "vessel.glb", make_pot())


@pytest.fixture
def figure(tmp_path):
    return write_obj(tmp_path / "doll.obj")


def run(capsys, *arguments):
    assert main([*map(str, arguments)]) == 0
    return capsys.readouterr().out


def refuse(capsys, *arguments):
    assert main([*map(str, arguments)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "Traceback" not in error
    return error


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("lid=1,2,3,4,5,6", dict(name="lid", box=[1, 2, 3, 4, 5, 6])),
        (" left  arm =-1.5, 2e-1,3", dict(name="left arm", point=[-1.5, 0.2, 3])),
        ("a=b=2", dict(name="a=b", number=2)),
    ],
)
def test_the_forms_of_the_option(text, fields):
    assert parse_part(text) == fields


@pytest.mark.parametrize(
    "text", ["lid", "=1", "lid=", "lid=1,2", "lid=1,2,x", "lid=nan,1,2", "lid=0.5", "lid=m.png", ""]
)
def test_what_is_none_of_them_is_refused_with_all_of_them(text):
    with pytest.raises(UserError, match="NAME=X0,Y0,Z0,X1,Y1,Z1.*NAME=X,Y,Z.*NAME=N"):
        parse_part(text)


def test_inspect_lists_the_parts_and_draws_them_in_their_colours(pot, capsys):
    rows = run(capsys, "inspect", pot, "--out", "seen.png").splitlines()
    parts = [row for row in rows if row.startswith("part ")]
    assert parts[0].startswith("part 1    pot, ") and parts[1].startswith("part 2    lid, ")
    assert all("named in the file" in row for row in parts[:2])
    picture = iio.imread("seen.png")[:360, :480].astype(float)  # the front
    for index, rows in ((0, slice(200, 320)), (1, slice(60, 160))):
        tone = picture / np.maximum(np.linalg.norm(picture, axis=-1, keepdims=True), 1)
        like = tone[rows] @ (COLOURS[index] / np.linalg.norm(COLOURS[index]))
        assert (like > 0.96).sum() > 2000


def test_a_plan_tells_which_part_is_moved_and_what_told_of_it(pot, capsys):
    plan = run(capsys, "plan", "--object", pot, "lift the lid")
    assert "parts: 1 pot, 2 lid" in plan and "on the lid (part 2, named in the file)" in plan
    assert "unsure" not in plan
    said = json.loads(run(capsys, "plan", "--object", pot, "turn the lid", "--json"))
    assert said["targets"][0]["limb"] == 1 and not said["unsure"]
    assert [each["origin"] for each in said["parts"][:2]] == ["file", "file"]


def test_groups_of_an_obj_reach_the_sentence(figure, capsys):
    said = json.loads(run(capsys, "plan", "--object", figure, "raise Arm_L", "--json"))
    assert said["constraints"][0]["region"]["label"] == "left arm (part 2, named in the file)"
    assert said["constraints"][0]["constraint_type"] == "enforce_particle_rotation"


def test_parts_that_are_named_by_the_option(figure, capsys):
    box = "--part=stump=-0.2,-0.2,-0.1,0.2,0.2,0.3"
    point, number = "--part=pump handle=0.6,0,0.85", "--part=mask=4"
    for sentence, label in (
        ("push the stump to the left", "on the stump (part 5"),
        ("raise the pump handle", "on the pump handle (part 3"),
        ("push the mask to the left", "on the mask (part 4"),
    ):
        plan = run(capsys, "plan", "--object", figure, "--up=+z", box, point, number, sentence)
        assert label in plan and "named by --part" in plan and "unsure" not in plan, plan


def test_a_part_that_is_not_known_is_asked_for(pot, capsys):
    error = refuse(capsys, "plan", "--object", pot, "turn the door")
    assert all(
        words in error for words in ("'door'", "1 pot, 2 lid", "--part door=N", f"physagent inspect {pot}")
    )
    plan = run(capsys, "plan", "--object", pot, "--part=door=0,-0.4,-0.6,0.6,0.4,0.6", "turn the door")
    assert "on the door (part" in plan and "unsure" not in plan


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("--part=lid=x", "NAME=N"),
        ("--part=lid=1,1,1,0,0,0", "x0 < x1"),
        ("--part=7=1", "needs letters"),
        ("--part=door=9", "1 body, 2 left arm"),
        ("--part=door=7,7,7,8,8,8", "holds nothing"),
    ],
)
def test_a_wrong_option_is_one_clear_error(figure, capsys, option, words):
    assert words in refuse(capsys, "plan", "--object", figure, "--up=+z", option, "turn the door")
    assert words in refuse(capsys, "inspect", figure, "--up=+z", option)


def test_the_command_of_an_inspection_keeps_the_names(figure, capsys):
    out = run(capsys, "inspect", figure, "--up=+z", "--part=mask=4", "--json")
    found = json.loads(out)
    assert "--part mask=4" in found["command"]
    assert [each["label"] for each in found["parts"]][:4] == ["body", "left arm", "right arm", "mask"]
    assert found["parts"][1]["low"][0] == pytest.approx(
        FIGURE["Arm_L"][0][0] - FIGURE["Arm_L"][1][0], abs=0.05
    )
