"""Readers and judges that ask a model, measured: samples, rows and counts."""

from benchmarks.agents import markdown, reading
from benchmarks.chat_models import Asked
from benchmarks.language.notation import read_split
from tests.agents.llm.scripted import ScriptedModel


def test_a_smaller_sample_is_the_beginning_of_a_larger_one():
    large = reading.draw_sample("development", 30, 40)
    assert (
        reading.draw_sample("development", 10, 40) == large[:10] != reading.draw_sample("development", 10, 41)
    )
    assert len(reading.draw_sample("development", 10**6, 40)) == len(read_split("development"))


def test_rows_of_a_model_and_their_counts(monkeypatch):
    sentences = reading.draw_sample("test", 2, 40)
    model = ScriptedModel({"clauses": []}, "no", "no", "no")
    monkeypatch.setattr(Asked, "open", lambda self: model)
    jobs = reading.list_jobs(sentences, [Asked("tiny=tiny.gguf", None)], ["clauses"])
    assert [job.name for job in jobs] == ["grammar", "tiny, clauses, sentences 1-2"]
    rows = [row for job in jobs for row in job.measure()]
    assert [row["reader"] for row in rows] == ["grammar"] * 2 + ["tiny", "grammar and tiny"] * 2
    silent, unusable = rows[2], rows[4]
    assert (silent["answer"], silent["unusable"], silent["input_tokens"]) == ("refused", False, 100)
    assert (unusable["answer"], unusable["unusable"], unusable["asked again"]) == ("refused", True, 3)
    assert rows[5]["wrong"] == rows[1]["wrong"]  # a model without an answer has no say
    text = str(rows)
    assert not any(sentence.text in text for sentence in sentences)
    section = {"rows": [{"run": 0} | row for row in rows], "runs": [{"quick": False}], "complete": True}
    counted = markdown.condense({"reading": section})["reading"]["rows"]
    assert [row["sentences"] for row in counted] == [2, 2, 2] and counted[1]["unusable"] == 1
    assert "tiny" in reading.write_reading(counted)


def test_models_are_named_on_the_command_line():
    server = Asked("big=http://127.0.0.1:8000/v1#Qwen/Q", None).choice
    assert (server.name, server.options) == ("openai", {"url": "http://127.0.0.1:8000/v1", "model": "Qwen/Q"})
    assert Asked("small=a/b.gguf", None).choice.name == "llama"
    assert Asked("tape=a.jsonl", None).choice.name == "replay"


def test_counts_of_verdicts():
    verdicts = [("SUCCESS", "SUCCESS"), ("SUCCESS", "FAIL"), ("FAIL", "SUCCESS"), ("FAIL", "FAIL")]
    rows = [{"judge": "rules", "label": label, "verdict": verdict, "run": 0} for label, verdict in verdicts]
    section = {"rows": rows, "runs": [{"quick": False}], "complete": True}
    (row,) = markdown.condense({"judging": section})["judging"]["rows"]
    assert (row["false SUCCESS"], row["wrong clips"], row["false FAIL"], row["right clips"]) == (1, 2, 1, 2)
