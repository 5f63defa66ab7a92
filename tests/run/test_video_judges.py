"""Video judges of others: what is asked of their programs, and what is made of their answers.

Neither their weights nor their packages are here: the programs are stand-ins that take the same arguments.
"""

import json
import sys

import numpy as np
import pytest

from physagent_jax.agents.trace import AgentError
from physagent_jax.chat.base import Generation, Usage
from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.motion.schema import Judgement, Verdict
from physagent_jax.output.video import write_video
from physagent_jax.run.video_judges import ADHERENCE, COMMONSENSE, FRAMES, make_judge

VIDEOPHY2 = """
import argparse, csv
parser = argparse.ArgumentParser()
for name in ("input_csv", "checkpoint", "output_csv", "task"):
    parser.add_argument("--" + name, required=True)
given = parser.parse_args()
rows = list(csv.DictReader(open(given.input_csv)))
assert all(set(row) == {"videopath", "caption"} for row in rows)
with open(given.output_csv, "w") as file:
    out = csv.DictWriter(file, ["videopath", "caption", "score"])
    out.writeheader()
    for index, row in enumerate(rows):
        out.writerow({**row, "score": SCORE})
"""
PHYJUDGE = """
import argparse, json
parser = argparse.ArgumentParser()
for name in ("adapter-dir", "video", "caption"):
    parser.add_argument("--" + name, required=True)
parser.add_argument("--metric")
parser.add_argument("--law")
given = parser.parse_args()
print("loading {weights} of the base model")
print(json.dumps({given.metric or given.law: SCORE}))
"""
CLIPS = 'push it, "hard"', "it spins"


@pytest.fixture
def clips(tmp_path):
    found = []
    for index, sentence in enumerate(CLIPS):
        path = tmp_path / f"{index}.mp4"
        write_video(path, np.full((20, 48, 64, 3), 40 * index, np.uint8), 25)
        found.append((path, sentence))
    return found


def write_program(folder, name, text, score):
    (folder / name).write_text(text.replace("SCORE", score))
    return dict(folder=str(folder), python=sys.executable)


def test_videophy2_is_asked_for_both_scores_of_all_clips(tmp_path, clips):
    score = "index + (3 if given.task == 'sa' else 2)"
    options = write_program(tmp_path, "inference.py", VIDEOPHY2, score) | dict(weights=str(tmp_path))
    judge = make_judge(("videophy2", options))
    assert judge.name == f"videophy2:{tmp_path.name}"
    assert judge.judge(clips) == [{ADHERENCE: 3, COMMONSENSE: 2}, {ADHERENCE: 4, COMMONSENSE: 3}]


def test_phyjudge_is_asked_for_each_metric_and_law(tmp_path, clips):
    score = "5 if given.metric == 'SA' else 4 if given.law else 3"
    judge = make_judge(("phyjudge", write_program(tmp_path, "infer.py", PHYJUDGE, score)))
    (scores,) = judge.judge(clips[:1])
    assert scores[ADHERENCE] == 5 and scores["gravity"] == scores["material"] == 4
    assert scores["temporal order"] == scores["persistence"] == 3


@pytest.mark.parametrize("score", ["0", "6", "float('nan')", "'good'"])
def test_a_score_out_of_range_is_refused(tmp_path, clips, score):
    judge = make_judge(("phyjudge", write_program(tmp_path, "infer.py", PHYJUDGE, score)))
    with pytest.raises(UserError, match="1 to 5|JSON object"):
        judge.judge(clips[:1])


def test_what_is_missing_is_told(tmp_path):
    with pytest.raises(UserError, match="PhyJudge is not there.*infer.py"):
        make_judge(("phyjudge", dict(folder=str(tmp_path), python=sys.executable)))
    (tmp_path / "inference.py").write_text("")
    with pytest.raises(UserError, match="weights of VideoPhy-2 AutoEval are not there"):
        make_judge(("videophy2", dict(folder=str(tmp_path), python=sys.executable)))
    with pytest.raises(UserError, match="needs a Python that has its packages.*`python`"):
        make_judge(("videophy2", dict(folder=str(tmp_path), weights=str(tmp_path))))


def test_a_crash_of_the_program_is_told(tmp_path, clips):
    options = write_program(tmp_path, "infer.py", "raise SystemExit('no GPU')", "")
    with pytest.raises(UserError, match="PhyJudge failed with exit code 1 .got no GPU"):
        make_judge(("phyjudge", options)).judge(clips[:1])


class Scripted:
    """A chat model with eyes that gives prepared answers."""

    name, has_eyes = "scripted", True

    def __init__(self, *answers):
        self.answers, self.asked = list(answers), []

    def generate(self, messages, schema=None):
        self.asked.append(messages)
        text = self.answers.pop(0)
        return Generation(text, None, Usage(), 0.0, self.name)

    def close(self):
        pass


def test_a_served_model_sees_frames_and_the_quoted_sentence(clips):
    model = Scripted('{"semantic_adherence": 4, "physical_commonsense": 2, "reason": "It slides."}')
    judge = make_judge(("served", dict(model=model)))
    assert judge.judge(clips[:1]) == [{ADHERENCE: 4, COMMONSENSE: 2}]
    (message,) = model.asked[0]
    assert len(message.pictures) == FRAMES and json.dumps(CLIPS[0]) in message.text


def test_a_served_model_that_gives_no_scores_is_an_error(clips):
    judge = make_judge(("served", dict(model=Scripted(*['{"semantic_adherence": 9}'] * 3))))
    with pytest.raises(AgentError):
        judge.judge(clips[:1])


def test_the_command_prints_theirs_beside_ours(tmp_path, capsys, clips):
    run = tmp_path / "run"
    (first := run / "iterations" / "0").mkdir(parents=True)
    clips[0][0].rename(run / "video.mp4")
    judgement = Judgement(verdict=Verdict.SUCCESS, score=1.0)
    (first / "judgement.json").write_text(judgement.model_dump_json())
    options = write_program(tmp_path, "infer.py", PHYJUDGE, "4")
    arguments = ["score", str(run), "--judge", "phyjudge", "--folder", options["folder"]]
    assert main([*arguments, "--python", sys.executable]) == 0
    printed = capsys.readouterr().out
    assert "semantic adherence 4" in printed and "ours " in printed
    assert main([*arguments, "--python", sys.executable, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["scores"]["gravity"] == 4 and row["verdict"] == "SUCCESS"
    assert main([*arguments, "--python", sys.executable, "--llm", "http://x"]) == 2
    assert "asks no chat model" in capsys.readouterr().err
