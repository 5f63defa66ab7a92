"""The command line tells of clips and of the time that is left."""

import pytest

from physagent_jax.cli.console import ConsoleObserver, format_seconds


@pytest.mark.parametrize(
    "seconds, words",
    [(0.2, "5 s"), (12.4, "10 s"), (88.0, "90 s"), (91.0, "2 min"), (3500.0, "58 min"), (7200.0, "2.0 h")],
)
def test_durations_are_said_as_exactly_as_they_are_known(seconds, words):
    assert format_seconds(seconds) == words


def test_the_terminal_tells_the_time_left_once_a_stage(capsys, monkeypatch, tmp_path):
    from physagent_jax.cli import console

    monkeypatch.setattr(console, "PATIENCE", -1.0)
    observer = ConsoleObserver()
    observer.stage("round 1: simulating and rendering")
    for done in range(3):
        observer.remaining(40.0 - done, 130.0)
        observer.frame(done, 3)
    observer.shown(0, tmp_path / "video.mp4")
    observer.close()
    told = capsys.readouterr().err
    assert told.count("clip in about 40 s, end in at most about 2 min") == 1
    assert f"clip of round 1: {tmp_path / 'video.mp4'}" in told
