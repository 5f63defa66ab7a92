"""The clip of each round: there before the round is judged, and still there when the run is stopped."""

import pytest

from physagent_jax.output.video import read_video
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.observer import Observer
from tests.run.specs import made, small
from tests.run.test_loop import scripted

SIZE = (64, 48)
PLANNED, LONGEST = 5, 5 + 25  # frames: those planned, and with a second in which it may still move


class Listener(Observer):
    """Notes what it is told of clips and rounds, and what is in the clip's file then."""

    def __init__(self):
        self.told, self.left = [], []

    def shown(self, index, clip):
        shape = read_video(clip).shape
        assert PLANNED <= shape[0] <= LONGEST and shape[1:] == (48, 64, 3)
        self.told.append(("clip", index))

    def judged(self, index, judgement):
        self.told.append(("judged", index))

    def remaining(self, clip, run):
        self.left.append((clip, run))


def asked(robot_path):
    return small(robot_path, frames=5, save=dict(video_size=SIZE))


def test_a_clip_comes_before_its_judgement_and_stays_when_the_run_is_stopped(tmp_path, robot_path):
    out, listener = tmp_path / "run", Listener()
    with pytest.raises(KeyboardInterrupt):
        made(asked(robot_path), out, scripted([0.2], interrupt=True), observer=listener)
    assert listener.told == [("clip", 0), ("judged", 0)]
    assert (out / "video.mp4").samefile(out / "iterations/0/video.mp4")
    clip, run = listener.left[-1]
    assert 0 < clip < run and len(listener.left) >= 5

    store = made(asked(robot_path), out, scripted([1.0]), observer=listener)
    assert listener.told[2:] == [("judged", 0), ("clip", 1), ("judged", 1)]
    assert (out / "video.mp4").samefile(out / "iterations/1/video.mp4")
    assert store.manifest.best_iteration == 1 and (out / "iterations/0/video.mp4").is_file()


def test_the_manifest_tells_when_the_first_clip_was_there(tmp_path, robot_path):
    store = made(asked(robot_path), tmp_path / "run", scripted([1.0]))
    first = Manifest.model_validate_json((store.path / "manifest.json").read_bytes()).first_clip
    assert first is not None and 0 < first.draw < first.seconds
    stages = first.stages.model_dump()
    assert sum(stages.values()) + first.draw <= first.seconds + 0.01
    assert stages["simulate"] > 0 and stages["perceive"] == 0


def test_a_round_without_a_clip_gets_one_when_the_run_is_taken_up(tmp_path, robot_path):
    """As where its folder is of an earlier version, or the process died between the two files."""
    out = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        made(asked(robot_path), out, scripted([0.5], interrupt=True))
    for name in ("video.mp4", "iterations/0/video.mp4"):
        (out / name).unlink()
    store = made(asked(robot_path), out, scripted([0.2, 0.1]))
    assert store.manifest.best_iteration == 0
    assert read_video(out / "video.mp4").shape == (5, 48, 64, 3)


def test_a_clip_that_cannot_be_drawn_ends_the_round(tmp_path, robot_path, monkeypatch):
    from physagent_jax.run import rounds

    def refuse(*_):
        raise RuntimeError("no pictures today")

    monkeypatch.setattr(rounds, "write_clip", refuse)
    with pytest.raises(RuntimeError, match="no pictures today"):
        made(asked(robot_path), tmp_path / "run", scripted([1.0]))
