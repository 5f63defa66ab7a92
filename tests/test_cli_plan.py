"""`physagent plan`: what a sentence would do, without simulating it."""

import json

import pytest
import trimesh

from physagent_jax.cli import main
from tests.scene.photos import make_ball_mask, write_photo

quickly = pytest.mark.usefixtures("quick_plans")


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")


def plan(capsys, robot_path, *arguments):
    assert main(["plan", "--object", str(robot_path), *arguments]) == 0
    return capsys.readouterr().out


@quickly
def test_a_plan_in_json(robot_path, capsys):
    """Targets, actions, world, clip and what was not understood, in one line."""
    sentence = (
        "push it half a body length to the left against a wall, then rotate it by 90 degrees, melodiously"
    )
    out = plan(capsys, robot_path, sentence, "--json")
    assert out.count("\n") == 1
    said = json.loads(out)
    assert [each["kind"] for each in said["targets"]] == ["move", "rotate"]
    assert [each["amount"] for each in said["targets"]] == [
        {"value": 0.5, "unit": "lengths"},
        {"value": 90.0, "unit": "degrees"},
    ]
    assert said["actions"][0]["action_type"] == "translation"
    assert said["world"]["obstacles"][0]["kind"] == "wall"
    assert said["frames"] > 50 and said["seconds"] == pytest.approx((said["frames"] - 1) * 0.04)
    assert said["not_understood"] == ["melodiously"] and said["unsure"]


@quickly
def test_a_plan_of_a_photo_says_what_was_made_up(tmp_path, capsys):
    write_photo(tmp_path / "ball.png", make_ball_mask())
    assert main(["plan", "--image", str(tmp_path / "ball.png"), "push the ball to the left"]) == 0
    told = capsys.readouterr().out
    assert "one photo shows one side of an object" in told and "made up" in told
    assert main(["plan", "--image", str(tmp_path / "gone.png"), "push it left"]) == 2


@quickly
def test_the_sentence_stands_alone_or_behind_its_option(robot_path, capsys):
    """Both commands take both; two sentences that differ are refused."""
    alone = plan(capsys, robot_path, "push it left", "--json")
    assert plan(capsys, robot_path, "--prompt", "push it left", "--json") == alone
    both = ["--object", str(robot_path), "push it left", "--prompt", "push it right"]
    for command in (["plan"], ["run", "--out", "nowhere"]):
        assert main([*command, *both]) == 2
        assert "two sentences are given" in capsys.readouterr().err
        assert main([*command, "--object", str(robot_path)]) == 2
        assert "--prompt must be given" in capsys.readouterr().err
    assert main(["run", "--out", "nowhere", "--object", str(robot_path), "be"]) == 2
    assert "'be'" in capsys.readouterr().err  # it was read as the sentence


@quickly
def test_a_plan_says_where_the_object_will_be(robot_path, tmp_path, capsys):
    """On the ground if it stands there; the robot would fall over, so that it slides without weight, as in a run."""
    cube = tmp_path / "cube.obj"
    trimesh.creation.box([0.4, 0.4, 0.4]).export(cube)
    said = json.loads(plan(capsys, cube, "push it left", "--json", "--up", "+z"))
    assert said["world"]["surroundings"] == "ground"
    said = json.loads(plan(capsys, robot_path, "push it left", "--json", "--world", "ground"))
    assert said["world"]["surroundings"] == "free"
    assert any("without weight" in each for each in said["assumptions"])


@quickly
@pytest.mark.parametrize("sentence", ["bend it to the left, then let go", "hit it from the left", "shake it"])
def test_a_plan_says_that_feet_are_held_and_why(sentence, robot_path, capsys):
    """Of what would fall over, where nothing moves it off."""
    said = json.loads(plan(capsys, robot_path, sentence, "--json"))
    assert said["world"]["surroundings"] == "ground" and "its feet are held" in said["anchor"]["held"]
    assert any("its feet are held" in each for each in said["assumptions"])


@quickly
@pytest.mark.parametrize("sentence", ["knock it over to the left", "throw it into the air"])
def test_what_cannot_stand_falls_with_its_weight(sentence, robot_path, capsys):
    """It was without weight once, hung there, and went off."""
    said = json.loads(plan(capsys, robot_path, sentence, "--json"))
    assert said["world"]["gravity"] == "down" and said["anchor"]["held"] is None


@quickly
def test_a_plan_in_words(robot_path, capsys):
    """The same for people; a fixed clip keeps its length."""
    out = plan(
        capsys, robot_path, "hold its feet and bend the head to the left, then let go", "--frames", "30"
    )
    lines = out.splitlines()
    assert lines[0] == "should be seen:" and "move left" in lines[1] and "then let go" in lines[1]
    assert "held: " in out and "feet" in out
    assert "clip: 30 frames, 1.16 s" in out


@quickly
def test_a_plan_of_what_falls_has_gravity(robot_path, capsys):
    """Wherever it would be otherwise."""
    assert "surroundings: gravity acts, the ground is below it\n" in plan(
        capsys, robot_path, "drop it", "--world", "free"
    )
    assert "surroundings: it floats in empty space\n" in plan(
        capsys, robot_path, "push it left", "--world", "free"
    )


@quickly
def test_a_plan_tells_what_grips_and_turns(robot_path, capsys):
    out = plan(capsys, robot_path, "twist the robot by 90 degrees")
    assert out.count("keeps turning") == 1 and "then held until frame" in out  # its feet are held
    out = plan(capsys, robot_path, "twist the robot by 90 degrees", "--anchor", "none")
    assert out.count("keeps turning") == 2


@quickly
@pytest.mark.parametrize("sentence", ["Schieb den Roboter nach links", "", "asdf qwer zxcv"])
def test_what_a_run_refuses_a_plan_refuses(sentence, robot_path, capsys):
    """Exit code 2 and one line."""
    assert main(["plan", "--object", str(robot_path), sentence]) == 2
    error = capsys.readouterr().err
    assert error.count("physagent: ") == 1 and "Traceback" not in error


def test_a_missing_object_is_refused(tmp_path, capsys):
    """As for a run."""
    assert main(["plan", "--object", str(tmp_path / "gone.ply"), "push it left"]) == 2
    assert "gone.ply" in capsys.readouterr().err


def test_a_plan_says_what_of_the_object_is_loose_and_how_it_is_damped(tmp_path, capsys):
    """Known once the object is loaded, long before anything is simulated."""
    apart = trimesh.util.concatenate(
        [
            trimesh.creation.box([0.4, 0.4, 0.4]),
            trimesh.creation.box([0.2, 0.2, 0.2]).apply_translation([0.9, 0, 0]),
        ]
    )
    apart.export(tmp_path / "pair.obj")
    said = json.loads(
        plan(capsys, tmp_path / "pair.obj", "push it to the left", "--json", "--kind", "pillow")
    )
    (loose,) = [each for each in said["assumptions"] if "joined to the rest by nothing" in each]
    assert "1 piece(s)" in loose and "at 0.50 L" in loose
    (damped,) = [each for each in said["assumptions"] if "damping ratio" in each]
    assert "`--damping-ratio` 0.1" in damped


@pytest.fixture
def pot(tmp_path):
    path = tmp_path / "pot.obj"
    trimesh.creation.box([0.4, 0.4, 0.4]).export(path)
    return path


@quickly
def test_a_hold_of_the_kind_gives_way_to_a_fall(pot, capsys):
    """And the plan says so; what bends keeps it."""
    lines = plan(capsys, pot, "drop it", "--kind", "plant", "--up", "+z").splitlines()
    assert "held: nowhere" in lines
    assert any(line.startswith("assumed: 'drop' needs the object free") for line in lines)
    said = json.loads(plan(capsys, pot, "bend it left", "--kind", "plant", "--up", "+z", "--json"))
    assert "rooted" in said["anchor"]["held"] and not any("free" in each for each in said["assumptions"])


@quickly
@pytest.mark.parametrize("words", [["drop it", "--anchor", "base"], ["hold the base and throw it"]])
def test_a_motion_that_its_hold_makes_impossible_is_refused(words, pot, capsys):
    """With both ways out, by the command that only plans."""
    assert main(["plan", "--object", str(pot), "--kind", "plant", "--up", "+z", *words]) == 2
    error = capsys.readouterr().err
    assert "impossible" in error and "Leave out" in error and "or ask for" in error
