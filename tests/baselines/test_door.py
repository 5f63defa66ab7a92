"""Methods of one's own behind the door: what they get is the evaluator's, and what they reach for is not there."""

import dataclasses
import io
import json
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path

import numpy as np
import pytest

from baselines.door import sandbox
from baselines.door.wire import receive, send
from baselines.evaluation import Evaluator
from baselines.methods import make_method
from baselines.protocol import Budget, MethodFailedError
from physagent_jax.core.errors import UserError

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # to compile takes longest

ALL = """
import dataclasses
import jax.numpy as jnp
import numpy as np
from baselines.parametrisation import Parametrisation
from baselines.protocol import Method

@dataclasses.dataclass(frozen=True)
class All(Method):
    least: float = 0.1
    name, oracle, stochastic = "all", True, True

    def search(self, evaluator):
        field = evaluator.task.start
        evaluator.score(field, evaluator.brief.object_name)
        with evaluator.sharpened(2):
            _, gradient = evaluator.gradient(field)
        note = str(gradient.actions[0].vector)
        _, slopes = evaluator.jacobian(field, Parametrisation(field, evaluator.task.frame_count), note)
        pictures = evaluator.play(field, str(slopes.sum()))
        evaluator.rate(float(evaluator.rng.normal()))
        pixels = np.zeros(pictures.rgb.shape)
        pixels[-1] = 1e-3
        by_field, _ = evaluator.pull_back(field, pixels)
        evaluator.watch(field, str(by_field.actions[0].vector))
        evaluator.model_calls, evaluator.tokens = 3, 40
        shown = evaluator.differentiate_pictures(field, lambda rgb: jnp.mean(rgb**2), [0, 7])
        evaluator.watch(field, f"{shown[0]:.4g}")
        assert evaluator.recall(field) is not None and evaluator.remaining > 0
        while True:
            evaluator.score(field)
"""

CHEAT = """
import dataclasses, gc, os, pathlib
from baselines.protocol import Method
from physagent_jax.metrics.targets import Target

@dataclasses.dataclass(frozen=True)
class Cheat(Method):
    file: str
    name, oracle, stochastic = "cheat", False, False

    def search(self, evaluator):
        task = evaluator.task
        ways = [lambda: task.target, lambda: task.spec.target, lambda: task.spec.hidden.actions,
                lambda: evaluator._simulation.task, lambda: pathlib.Path(self.file).read_text(),
                lambda: pathlib.Path(self.file).write_text("{}"), lambda: open(f"/proc/{os.getppid()}/mem", "rb"),
                lambda: next(each for each in gc.get_objects() if isinstance(each, Target)),
                lambda: evaluator.score(evaluator.task.start)]
        for number, way in enumerate(ways):
            try:
                print("reached:", number, str(way())[:80], flush=True)
            except Exception as error:
                print("kept:", number, error, flush=True)
        evaluator.oracle, evaluator.spent = True, -100.0
        evaluator.play(evaluator.task.start)
        evaluator.rate(-1e9)
        raise ZeroDivisionError("at the end")
"""


def test_all_that_is_asked_is_answered_and_charged_as_without_a_door(tiny, tmp_path, monkeypatch):
    (tmp_path / "all.py").write_text(ALL)
    place = f"{tmp_path}/all.py:All"
    closed, open_ = (make_method(place, dict(least=0.2), hidden) for hidden in ([tmp_path / "tasks"], None))
    assert closed.list_options() == open_.list_options() == dict(least=0.2)
    assert (closed.name, closed.oracle, closed.stochastic) == ("all", True, True)
    one, other = (method.fit(tiny, Budget(25.0), 3) for method in (closed, open_))

    def strip(each):
        return dataclasses.replace(each, seconds=0.0, objective=None)

    rated = [np.array([each.objective for each in result.evaluations], float) for result in (one, other)]
    np.testing.assert_allclose(*rated, rtol=1e-5)  # a loss is computed by each with its own programs
    assert list(map(strip, one.evaluations)) == list(map(strip, other.evaluations))
    for name in ("method", "task", "seed", "start", "oracle", "spent", "model_calls", "tokens"):
        assert getattr(one, name) == getattr(other, name)
    assert one.model_calls == 3 and one.tokens == 40
    with pytest.raises(UserError, match="colour"):
        print(make_method(place, dict(colour=1), []).name)


def test_a_cheat_reaches_nothing_and_its_failure_is_told(tiny, tmp_path, capfd):
    (tmp_path / "cheat.py").write_text(CHEAT)
    (tmp_path / "tasks").mkdir()
    secret = tmp_path / "tasks" / "drop.json"
    secret.write_text('"the answer"')
    method = make_method(f"{tmp_path}/cheat.py:Cheat", dict(file=str(secret)), [secret.parent])
    evaluator = Evaluator(tiny, Budget(5.0), oracle=method.oracle)
    with pytest.raises(MethodFailedError, match="ZeroDivisionError: at the end"):
        method.finish(evaluator)
    printed = capfd.readouterr().out
    assert printed.count("kept:") == 9 and "reached:" not in printed, printed
    assert secret.read_text() == '"the answer"' and evaluator.spent == 1.0 and not evaluator.oracle


def test_a_system_without_landlock_is_told(tmp_path, monkeypatch):
    (tmp_path / "all.py").write_text(ALL)
    without = tmp_path / "without.py"
    without.write_text(Path(sandbox.__file__).read_text().replace("if restrict(hidden, folders)", "if False"))
    monkeypatch.setattr(sandbox, "__file__", str(without))
    with pytest.warns(UserWarning, match="no Landlock: Python alone"):
        assert make_method(f"{tmp_path}/all.py:All", {}, [tmp_path / "tasks"]).name == "all"


REACH = """
import runpy, pathlib, subprocess, sys
door = runpy.run_path({file!r})
hidden, folders = door["list_hidden"]([pathlib.Path({hidden!r})]), [pathlib.Path({own!r}), pathlib.Path("/dev")]
print("none") or sys.exit() if {kernel} and not door["restrict"](hidden, folders) else None
{kernel} or door["hide_by_hook"](hidden, folders)
for path, mode in {wanted!r}:
    try:
        open(path, mode).close()
        print("open")
    except PermissionError:
        print("kept")
print("kept" if subprocess.run(["cat", {hidden!r} + "/a"], capture_output=True).returncode else "open")
"""


@pytest.mark.parametrize("kernel", [True, False], ids=["landlock", "audit hook"])
def test_files_are_hidden_with_all_that_leads_to_them(tmp_path, kernel):
    hidden, own = tmp_path / "hidden", tmp_path / "own"
    for folder in (hidden, own):
        folder.mkdir()
        (folder / "a").write_text("text")
    (tmp_path / "link").symlink_to(hidden)
    (tmp_path / "beside").write_text("text")
    wanted = [("hidden/a", "r"), ("link/a", "r"), ("own/../hidden/a", "r"), ("beside", "w"), ("beside", "r")]
    wanted = [(str(tmp_path / path), mode) for path, mode in [*wanted, ("own/a", "r"), ("own/b", "w")]]
    script = REACH.format(
        file=sandbox.__file__, hidden=str(hidden), own=str(own), kernel=kernel, wanted=wanted
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    if kernel and said.stdout == "none\n":
        pytest.skip("this kernel has no Landlock")
    last = ["kept"] if kernel else []  # by the hook no program starts at all
    assert said.stdout.split() == ["kept"] * 4 + ["open"] * 3 + last, said.stderr
    assert kernel or "may start no program" in said.stderr


def test_what_comes_out_is_data(tmp_path):
    inner, outer = Pipe()
    send(outer, dict(ask="play", note=np.float32(0.5)), dict(pixels=np.arange(3.0)))
    header, arrays = receive(inner)
    assert header == dict(ask="play", note=0.5) and np.array_equal(arrays["pixels"], np.arange(3.0))
    for content in (
        b"nothing",
        make_archive(header=np.array([Path("/")], object)),
        make_archive(other=np.ones(1)),
    ):
        outer.send_bytes(content)
        with pytest.raises(UserError, match="no message"):
            receive(inner)
    with pytest.raises(TypeError, match="cannot be sent"):
        send(outer, dict(ask=tmp_path))


def make_archive(**arrays) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def test_a_question_that_there_is_not_is_refused_and_charges_nothing(tiny):
    from baselines.door.outside import _Process

    class Talk(_Process):
        def __init__(self):
            self._connection, self.inside = Pipe()

    talk, evaluator = Talk(), Evaluator(tiny, Budget(5.0), oracle=False)
    field = tiny.start.model_dump(mode="json")
    for header in (
        dict(ask="judge", force_field=field),
        dict(ask="score", force_field=field),
        dict(ask="play", force_field=dict(actions=[dict(action_type="wish")])),
        dict(ask="pull_back", force_field=field, others=[], truncation=dict(first=0), x=1),
        dict(ask="rate", objective=1.0, note=None),
        {},
    ):
        kind, value = talk._answer(evaluator, json.loads(json.dumps(header)), {})
        assert kind == "refused" and value
    assert evaluator.spent == 0
