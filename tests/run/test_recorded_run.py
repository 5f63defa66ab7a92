"""A run whose sentence was read by a real model, Qwen2.5-Coder 1.5B, replayed from its recorded answers.

The prompts are part of the record: whoever changes a prompt or the words of the lexicon records again, as
`RECORD` says, with the model's file (`python -m benchmarks.agents.models qwen2.5-coder-1.5b`).
"""

import json
import re
from pathlib import Path

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.cli import main
from physagent_jax.run.manifest import Manifest

CASSETTE = Path(__file__).with_name("cassettes") / "qwen2.5-coder-1.5b.jsonl"
PROMPT = "a strong wind pushes the robot to the left, then it spins clockwise"
OPTIONS = (
    "--frames 10 --particles 600 --resolution 96 --video-size off --max-iterations 1 "
    "--reader model --form by-clause"
).split()
RECORD = f"record again: run {PROMPT!r} with {' '.join(OPTIONS)} --llm FILE --record {CASSETTE.name}"


def test_a_run_read_by_a_real_model(tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    command = ["run", "--object", str(robot_path), "--prompt", PROMPT, "--out", str(out), *OPTIONS]
    assert main([*command, "--replay", str(CASSETTE)]) == 0, RECORD
    told = " ".join(capsys.readouterr().err.split())
    assert "Read by" in told and "qwen2.5-coder-1.5b, by-clause" in told
    reply = SemanticReply.model_validate_json((out / "semantic.json").read_text())
    (push,), (turn,) = reply.force_field.actions, reply.force_field.constraints
    assert (push.action_type.value, push.vector) == ("translation", (-1.0, 0.0, 0.0)) and push.magnitude > 1.2
    assert (turn.constraint_type.value, turn.vector) == ("enforce_particle_rotation", (0.0, 0.0, -1.0))
    manifest = Manifest.model_validate_json((out / "manifest.json").read_text())
    asked = manifest.agents[0]
    assert (
        "qwen2.5-coder-1.5b" in asked.implementation
        and asked.input_tokens > 500 < 10 * asked.output_tokens + 500
    )
    page = (out / "report.html").read_text()
    assert "qwen2.5-coder-1.5b" in page


def test_the_record_holds_answers_of_the_model_and_no_key():
    rows = [json.loads(line) for line in CASSETTE.read_text().splitlines()]
    assert len(rows) >= 2
    assert not re.search(r"(?i)api[_-]?key|bearer|sk-[a-z0-9]{8}", CASSETTE.read_text())
