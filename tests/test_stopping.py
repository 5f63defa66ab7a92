"""Ctrl-C and SIGTERM: the first stops at the next frame and nothing is lost, the second ends at once."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest

from physagent_jax.cli import main
from physagent_jax.cli.console import FrameBar
from physagent_jax.cli.stopping import Stopped, allow_stopping, check


@pytest.mark.usefixtures("quick_plans")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_run_stops_at_the_next_frame_and_goes_on_as_if_never_stopped(
    number, code, tmp_path, robot_path, monkeypatch, capfd
):
    arguments = ["run", "--object", robot_path, "--prompt", "push the robot to the left", "--frames", 8]
    arguments += ["--particles", 300, "--resolution", 64, "--max-iterations", 1, "--video-size", "64x48"]
    arguments = [str(argument) for argument in arguments]
    out, other = tmp_path / "run", tmp_path / "other"
    handler = signal.getsignal(number)
    called = FrameBar.__call__

    def ask(bar, done, total):
        if done == 3:
            signal.raise_signal(number)
        called(bar, done, total)

    with monkeypatch.context() as patch:
        patch.setattr(FrameBar, "__call__", ask)
        assert main([*arguments, "--out", str(out)]) == code
    error = capfd.readouterr().err
    assert "Traceback" not in error and "stopped; the same command takes the run up again" in error
    assert signal.getsignal(number) is handler
    manifest = json.loads((out / "manifest.json").read_text())
    assert not manifest["complete"] and not (out / "iterations").exists()

    assert main([*arguments, "--out", str(out)]) == 0
    assert main([*arguments, "--out", str(other)]) == 0
    names = [name for name in json.loads((out / "manifest.json").read_text())["files"]]
    for name in set(names) - {"manifest.json", "report.html"}:  # these tell seconds
        assert (out / name).read_bytes() == (other / name).read_bytes(), name


def test_nothing_happens_unless_asked():
    with allow_stopping():
        check()
    with allow_stopping():
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Stopped) as stop:
            check()
    assert stop.value.exit_code == 143
    with allow_stopping():
        check()  # a new block knows nothing of the last one


def test_a_second_signal_ends_the_process_at_once():
    program = (
        "import time; from physagent_jax.cli.stopping import allow_stopping\n"
        "with allow_stopping():\n    print('ready', flush=True)\n    while True: time.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        assert "once more" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=240) == -signal.SIGINT  # by itself it would never end
        assert process.stderr.read() == ""
