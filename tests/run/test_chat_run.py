"""Runs whose agents ask a chat model, from the command line: options, spec, costs, report, and what is told."""

import json

import pytest

from physagent_jax.chat.replay import Recorder
from physagent_jax.cli import main
from physagent_jax.run import chosen_agents
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.spec import RunSpec, read_spec
from tests.agents.llm.scripted import ScriptedModel, push
from tests.run.specs import small

PROMPT = "push the robot to the left"
SMALL = [
    "--frames",
    "10",
    "--particles",
    "600",
    "--resolution",
    "96",
    "--video-size",
    "off",
    "--max-iterations",
    "2",
]
SERVER = ["--llm", "http://127.0.0.1:9/v1", "--model", "tiny"]
READ = {
    "clauses": [{"words": PROMPT, "motion": "push", "relation": "to", "word": "left", "strength": "gentle"}]
}
NO = {"comparison": "It <b>hardly</b> moves.", "verdict": "FAIL", "suggestion": "Push harder."}
YES = {"comparison": "It goes left.", "verdict": "SUCCESS"}
HARDER = {"reason": "More force.", "actions": [push(9.0)]}


@pytest.fixture
def models(monkeypatch):
    """Models that are made in turn, and what was asked for each."""
    made, asked = [], []

    def make(choice, record=None):
        asked.append((choice, record))
        return made[len(asked) - 1]

    monkeypatch.setattr(chosen_agents, "make_model", make)
    return made, asked


def command(robot_path, out, *options):
    return ["run", "--object", str(robot_path), "--prompt", PROMPT, "--out", str(out), *SMALL, *options]


def test_a_run_with_three_agents_that_ask_a_model(tmp_path, robot_path, models, capsys):
    made, asked = models
    made.append(ScriptedModel("hm", READ, NO, HARDER, YES))
    out = tmp_path / "run"
    chosen = ["--reader", "model", "--planner", "chat", "--executor", "chat", *SERVER, "--eyes"]
    assert main(command(robot_path, out, *chosen, "--record", str(tmp_path / "tape"))) == 0
    options = {"url": SERVER[1], "model": "tiny", "eyes": True}
    assert asked == [(("openai", options), tmp_path / "tape")] and made[0].closed and not made[0].answers

    manifest = Manifest.model_validate_json((out / "manifest.json").read_bytes())
    assert (manifest.verdict, manifest.iterations) == ("SUCCESS", 2)
    costs = {cost.agent: cost for cost in manifest.agents}
    assert [costs[role].input_tokens for role in ("semantic", "planner", "executor")] == [200, 200, 100]
    assert costs["semantic"].implementation == "model(scripted:chat-1, clauses)"
    assert sum(cost.latency_seconds for cost in costs.values()) == pytest.approx(5 * 0.25)
    field = json.loads((out / "iterations/1/force_field.json").read_text())
    assert field["actions"][0]["magnitude"] == 1.6  # the hard rules have won

    page = (out / "report.html").read_text()
    for text in ("500 in, 50 out", "It goes left.", "Read by scripted:chat-1", "More force.", "Hard rule:",
                 "the answer holds no JSON object", "waited for models", "How the executor came to it"):  # fmt: skip
        assert text in page, text
    assert "<b>hardly</b>" not in page

    spec = read_spec(out / "run.json")
    assert spec.agents.model is not None and spec.agents.model.options == options
    made.append(ScriptedModel(READ, NO, HARDER, YES))
    assert main(["run", "--spec", str(out / "run.json"), "--out", str(tmp_path / "again"), "--json"]) == 0
    assert asked[1] == (("openai", options), None)
    assert (tmp_path / "again/motion.npz").read_bytes() == (out / "motion.npz").read_bytes()
    capsys.readouterr()


def test_a_recorded_run_is_replayed_without_a_model(tmp_path, robot_path, monkeypatch, capsys):
    tape, first, again = tmp_path / "tape.jsonl", tmp_path / "first", tmp_path / "again"
    chosen = ["--reader", "model", "--planner", "chat", "--executor", "chat"]
    with monkeypatch.context() as patch:
        model = ScriptedModel(READ, NO, HARDER, YES)
        patch.setattr(chosen_agents, "make_model", lambda choice, record: Recorder(model, record))
        assert main(command(robot_path, first, *chosen, *SERVER, "--record", str(tape))) == 0
    assert main(command(robot_path, again, *chosen, "--replay", str(tape))) == 0
    assert (again / "motion.npz").read_bytes() == (first / "motion.npz").read_bytes()
    assert read_spec(again / "run.json").agents.model.options == {"path": str(tape)}
    manifest = Manifest.model_validate_json((again / "manifest.json").read_bytes())
    assert manifest.agents[0].implementation == "model(replay:scripted:chat-1, clauses)"
    assert sum(cost.input_tokens for cost in manifest.agents) == 400

    capsys.readouterr()
    other = [each if each != PROMPT else "push the robot to the right" for each in command(robot_path, again)]
    assert main([*other, *chosen, "--replay", str(tape), "--overwrite"]) == 2
    assert "does not hold this request" in capsys.readouterr().err


def test_a_run_goes_on_with_the_same_model_and_is_another_run_with_another(
    tmp_path, robot_path, models, capsys
):
    made, _ = models
    out = tmp_path / "run"
    chosen = command(robot_path, out, "--planner", "both", *SERVER)
    made += [ScriptedModel(YES), ScriptedModel(), ScriptedModel(name="scripted:other")]
    assert main(chosen) == 0
    assert main(chosen) == 0  # complete: nobody is asked
    capsys.readouterr()
    assert main(chosen) == 2
    assert "--overwrite" in capsys.readouterr().err


def test_a_plan_told_by_both_readers(robot_path, models, capsys):
    made, _ = models
    made.append(ScriptedModel({"clauses": [{"words": PROMPT, "motion": "push", "word": "right"}]}))
    assert main(["plan", PROMPT, "--object", str(robot_path), "--reader", "both", *SERVER]) == 0
    text = capsys.readouterr().out
    assert "unsure" in text and "Grammar and model disagree on the direction" in text and made[0].closed


def test_a_scene_read_by_a_model(robot_path, models):
    import physagent_jax as pa

    models[0].append(ScriptedModel(READ))
    loaded = pa.load_object(robot_path, max_particles=300)
    chosen = {"semantic": "model", "model": {"name": "openai", "options": {"model": "tiny"}}}
    scene = pa.build_scene(loaded, PROMPT, agents=chosen, frame_count=5, width=32, height=32)
    assert scene.config.force_field.actions[0].vector[0] < 0 and models[0][0].closed


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (["--reader", "model"], "`--reader model` asks a language model, and none is named"),
        (["--planner", "both"], "`--planner both` asks a language model"),
        (["--executor", "chat", "--model", "tiny"], "asks a language model"),
        (SERVER, "names a language model that nobody asks"),
        (["--replay", "tape"], "`--replay` names a language model that nobody asks"),
        (["--reader", "both", "--llm", "http://127.0.0.1/v1"], "needs the model's name"),
        (["--reader", "both", "--llm", "nowhere.gguf"], "a server's address, a GGUF file or a folder"),
        (["--reader", "both", *SERVER, "--replay", "tape"], "both say who answers"),
        (["--form", "paper"], "`--form` means nothing"),
        (["--record", "tape"], "nothing to record"),
        (["--model", "tiny"], "`--model` means nothing without `--llm`"),
        (["--semantic", "rules"], "`--semantic` is called `--reader` now"),
    ],
)
def test_options_that_cannot_be_meant(tmp_path, robot_path, options, fragment, capsys):
    assert main(command(robot_path, tmp_path / "run", *options)) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert fragment in line and not (tmp_path / "run").exists()


def test_a_spec_names_a_model_if_and_only_if_somebody_asks_it(robot_path, tmp_path):
    model = {"name": "llama", "options": {"path": "models/tiny.gguf"}}
    for wrong, fragment in (
        ({"semantic": "model"}, "names none"),
        ({"model": model}, "no agent asks"),
        ({"planner": "chat", "model": {"name": "llamma"}}, "llama"),
    ):
        with pytest.raises(ValueError, match=fragment):
            small(robot_path, agents=wrong)
    spec = small(robot_path, agents={"planner": "chat", "model": model})
    located = spec.located(tmp_path)
    assert located.agents.model.options["path"] == str(tmp_path / "models/tiny.gguf")
    assert spec.identity() == located.identity() | {"object": spec.identity()["object"]}
    assert RunSpec.model_validate(json.loads(located.model_dump_json())) == located


def test_a_model_that_is_away_leaves_what_was_tried(tmp_path, robot_path, models, capsys):
    from physagent_jax.chat.base import ModelError

    models[0].append(ScriptedModel(ModelError("the server does not answer", do="Start it")))
    out = tmp_path / "run"
    assert main(command(robot_path, out, "--reader", "model", *SERVER)) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "gave no answer" in line]
    assert "the server does not answer" in line and "semantic_failed_1.json" in line
    assert (out / "semantic_failed_1.json").is_file() and models[0][0].closed
