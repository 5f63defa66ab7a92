"""Cassettes: what is recorded is replayed, and anything else is a loud miss."""

import hashlib
import json

import pytest

from physagent_jax.chat.base import ChatMessage, Generation, ModelError, Usage
from physagent_jax.chat.replay import Recorder, ReplayModel
from physagent_jax.core.errors import UserError

PICTURE = b"\x89PNG one"
ASKED = (ChatMessage("system", "Be brief."), ChatMessage("user", "left or right?", (PICTURE,)))
SCHEMA = {"type": "object", "properties": {"way": {"enum": ["left", "right"]}}}


class Counting:
    """Answers with the number of the request."""

    has_eyes = True

    def __init__(self, name="counting:1"):
        self.name, self.count, self.closed = name, 0, False

    def generate(self, messages, schema=None):
        self.count += 1
        return Generation(
            f'{{"n": {self.count}}}', {"n": self.count}, Usage(5, None), 0.25, "c", ("HTTP 500",)
        )

    def close(self):
        self.closed = True


@pytest.fixture
def cassette(tmp_path):
    path = tmp_path / "deep" / "cassette.jsonl"
    recorder = Recorder(Counting(), path)
    recorder.generate(ASKED, SCHEMA)
    recorder.generate(ASKED[:1])
    return path


def test_what_is_recorded_is_replayed(cassette):
    model = ReplayModel(cassette)
    first = Generation('{"n": 1}', {"n": 1}, Usage(5, None), 0.25, "c", ("HTTP 500",))
    for _ in range(2):
        assert model.generate(ASKED, SCHEMA) == first
        assert model.generate(ASKED[:1]).text == '{"n": 2}'
    assert model.name == "replay:counting:1" and model.has_eyes
    model.close()


def test_the_key_is_the_hash_of_the_whole_request(cassette):
    line = json.loads(cassette.read_text().splitlines()[0])
    text = json.dumps(line["request"], sort_keys=True, separators=(",", ":"))
    assert line["key"] == hashlib.sha256(text.encode()).hexdigest()
    assert line["request"]["messages"][1]["pictures"] == [hashlib.sha256(PICTURE).hexdigest()]
    assert "PNG" not in cassette.read_text()


@pytest.mark.parametrize(
    ("messages", "schema", "words"),
    [
        ((ASKED[0], ChatMessage("user", "left or wrong?", (PICTURE,))), SCHEMA,
         "message 2, user differs at character 9: recorded 'right.', asked 'wrong.'"),
        ((ASKED[0], ChatMessage("user", "left or right", (PICTURE,))), SCHEMA, "message 2, user differs at char"),
        ((ChatMessage("system", "Be long."), ASKED[1]), SCHEMA, "message 1, system differs at character 4"),
        ((ASKED[0], ChatMessage("user", "left or right?", (b"\x89PNG two",))), SCHEMA, "the pictures of message 2"),
        ((ASKED[0], ChatMessage("user", "left or right?")), SCHEMA, "the pictures of message 2"),
        ((ASKED[0], ChatMessage("assistant", "left or right?", (PICTURE,))), SCHEMA, "message 2"),
        ((*ASKED, ChatMessage("user", "again")), SCHEMA, "message 3, user was not recorded and is sent"),
        (ASKED, {"type": "object"}, "the schema differs"),
        (ASKED, None, "message 2, user was not recorded and is sent"),
        (ASKED[:0], SCHEMA, "message 1, system was recorded and is not sent"),
    ],
)  # fmt: skip
def test_a_miss_names_the_cassette_and_the_first_difference(cassette, messages, schema, words):
    with pytest.raises(ModelError, match=words) as caught:
        ReplayModel(cassette).generate(messages, schema)
    assert "cassette.jsonl does not hold this request" in str(caught.value)


def test_what_is_recorded_already_is_not_asked_again(cassette):
    """A recording that was stopped goes on where it was; nothing is paid twice."""
    before, model = cassette.read_bytes(), Counting()
    recorder = Recorder(model, cassette)
    assert recorder.generate(ASKED, SCHEMA).text == '{"n": 1}' and model.count == 0
    assert cassette.read_bytes() == before
    recorder.generate((ASKED[1],))
    assert model.count == 1 and len(cassette.read_text().splitlines()) == 3
    recorder.close()
    assert model.closed and recorder.name == "counting:1" and recorder.has_eyes


def test_recordings_of_the_same_are_the_same(cassette, tmp_path):
    again = Recorder(Counting(), tmp_path / "again.jsonl")
    again.generate(ASKED, SCHEMA)
    again.generate(ASKED[:1])
    assert (tmp_path / "again.jsonl").read_bytes() == cassette.read_bytes()


def test_errors_are_not_recorded(tmp_path):
    class Failing(Counting):
        def generate(self, messages, schema=None):
            raise ModelError("gone")

    with pytest.raises(ModelError, match="gone"):
        Recorder(Failing(), tmp_path / "none.jsonl").generate(ASKED)
    assert not (tmp_path / "none.jsonl").exists()


def test_one_of_several_models_is_named(cassette):
    Recorder(Counting("counting:2"), cassette).generate(ASKED, SCHEMA)
    with pytest.raises(UserError, match="does not hold one model.*counting:1, counting:2"):
        ReplayModel(cassette)
    with pytest.raises(UserError, match="does not hold this model .got counting:3"):
        ReplayModel(cassette, "counting:3")
    assert ReplayModel(cassette, "counting:2").generate(ASKED, SCHEMA).text == '{"n": 1}'
    with pytest.raises(ModelError, match="does not hold this request"):
        ReplayModel(cassette, "counting:2").generate(ASKED[:1])


def test_damaged_cassettes_are_refused(cassette, tmp_path):
    whole = cassette.read_text()
    for text, words in (
        (whole.replace("left or right?", "left or write?"), "line 1 was changed"),
        (whole[:-20], "line 2 is not valid JSON"),
        (whole + "{}\n", "line 3: field `key`: Field required"),
        ("", "does not hold one model"),
    ):
        cassette.write_text(text)
        with pytest.raises(UserError, match=words):
            ReplayModel(cassette)
    with pytest.raises(UserError, match="there is no cassette"):
        ReplayModel(tmp_path / "absent.jsonl")
    with pytest.raises(UserError, match="a folder"):
        ReplayModel(tmp_path)


def test_a_cassette_that_cannot_be_written_is_one_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot write"):
        Recorder(Counting(), tmp_path / "file" / "cassette.jsonl").generate(ASKED)
