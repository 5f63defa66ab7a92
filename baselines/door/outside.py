"""A method behind the door, as the package has it: its process is started, answered and charged from here."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
import sys
import tempfile
import warnings
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from baselines.door import sandbox
from baselines.door.wire import Reply, Scene, receive
from baselines.evaluation import Evaluator
from baselines.parametrisation import Parametrisation
from baselines.protocol import BudgetSpent, Method, MethodFailedError
from baselines.truncation import Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

_KEPT = ("target", "hidden", "task_hash")  # fields of a task that tell the answer


@dataclasses.dataclass(frozen=True)
class ClosedMethod(Method):
    """A method of one's own, in a process that sees scene, sentence and what the evaluator answers.

    Attributes:
        place: ``module:Class`` or ``file.py:Class``; this process never imports it.
        given: Options of the method.
        hidden: Files and folders that its process cannot read.
    """

    place: str
    given: Mapping[str, Any]
    hidden: tuple[Path, ...] = ()

    @property
    def name(self) -> str:
        """As the method says."""
        return str(self._process.about["name"])

    @property
    def oracle(self) -> bool:
        """As the method says."""
        return bool(self._process.about["oracle"])

    @property
    def stochastic(self) -> bool:
        """As the method says."""
        return bool(self._process.about["stochastic"])

    def list_options(self) -> dict[str, Any]:
        """The method's own fields."""
        return dict(self._process.about["options"])

    def with_options(self, options: Mapping[str, Any]) -> Method:
        """The method with other options, in another process."""
        return dataclasses.replace(self, given={**self.given, **options}) if options else self

    def search(self, evaluator: Evaluator) -> None:
        """Let the method search, and answer what it asks until it is done or its seconds are over.

        Raises:
            UserError: The method refuses the task.
            MethodFailedError: It has an error of its own, or its process has ended.
        """
        process = self._process
        try:
            process.search(evaluator)
        except UserError as error:
            if isinstance(error, MethodFailedError):
                self._forget()
            raise
        except BaseException:
            self._forget()
            raise
        if process.has_ended:
            self._forget()

    @cached_property
    def _process(self) -> _Process:
        return _Process(self.place, dict(self.given), self.hidden)

    def _forget(self) -> None:
        """End the process; the next search starts another one."""
        self._process.end()
        self.__dict__.pop("_process", None)


class _Process:
    """The process of a method.

    Attributes:
        about: What the method says of itself.
    """

    def __init__(self, place: str, options: dict[str, Any], hidden: Sequence[Path]):
        folder = tempfile.mkdtemp(prefix="physagent-door-")
        self._connection, other = Pipe()
        paths = os.pathsep.join(dict.fromkeys([*filter(None, sys.path), os.getcwd()]))
        own = dict(PYTHONPATH=paths, PHYSAGENT_DOOR_FOLDER=folder, NUMBA_CACHE_DIR=folder, TMPDIR=folder)
        self._child = subprocess.Popen(
            [sys.executable, "-P", sandbox.__file__, str(other.fileno()), *map(str, hidden), "--", folder],
            stdin=subprocess.DEVNULL,
            env=os.environ | own,
            pass_fds=[other.fileno()],
        )
        other.close()
        self.end = weakref.finalize(self, _end, self._child, self._connection, folder)
        self._connection.send((place, options))
        self.about = self._receive()[0]
        if "invalid" in self.about:
            self.end()
            raise UserError(str(self.about["invalid"]))
        if self.about.get("kept_by") != "landlock":
            warnings.warn(
                f"this system has no Landlock: Python alone keeps files from {place}, which stops no effort",
                stacklevel=2,
            )

    @property
    def has_ended(self) -> bool:
        """Return whether it was ended, or has ended itself."""
        return not self.end.alive or self._child.poll() is not None

    def search(self, evaluator: Evaluator) -> None:
        """As `ClosedMethod.search`."""
        task = evaluator.task
        spec = {name: value for name, value in vars(task.spec).items() if name not in _KEPT}
        mass = np.asarray(task.mass)
        scene = Scene(spec, task.start, task.frame_count, task.frame_dt, mass, evaluator.brief)
        self._connection.send((scene, evaluator.budget, evaluator.seed))
        while self._wait(evaluator):
            header, arrays = self._receive()
            evaluator.model_calls, evaluator.tokens = (
                max(0, int(header.get(name, 0))) for name in ("model_calls", "tokens")
            )
            if "done" in header:
                return
            if "refused" in header:
                raise UserError(str(header["refused"]))
            first = max(0, len(evaluator.evaluations) - 1)  # the latest may be rated
            kind, value = self._answer(evaluator, header, arrays)
            told = tuple(evaluator.evaluations[first:])
            self._connection.send(Reply(kind, value, evaluator.spent, first, told))

    def _wait(self, evaluator: Evaluator) -> bool:
        """Wait for a question; False where the budget's seconds are over first."""
        seconds = evaluator.budget.seconds
        if seconds is None or self._connection.poll(max(0.0, seconds - evaluator.seconds)):
            return True
        self.end()
        return False

    def _receive(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        try:
            header, arrays = receive(self._connection)
        except (EOFError, OSError):
            code = self._child.wait()
            raise MethodFailedError("a method's process has ended", got=f"exit code {code}") from None
        if "broken" in header:
            raise MethodFailedError(
                "a method has failed", got=str(header["broken"]), do="Its traceback is above"
            )
        return header, arrays

    def _answer(self, evaluator: Evaluator, header: dict, arrays: dict) -> tuple[str, Any]:
        """Kind and value of a reply."""
        try:
            with evaluator.sharpened(max(1, int(header.get("power", 1)))):
                return "value", self._ask(evaluator, header, arrays)
        except BudgetSpent:
            return "spent", None
        except MethodFailedError:
            raise
        except UserError as error:
            return "refused", str(error)
        except (KeyError, TypeError, ValueError) as error:  # no question that there is
            return "refused", f"the evaluator cannot answer that: {error}"

    def _ask(self, evaluator: Evaluator, header: dict, arrays: dict) -> Any:
        if header["ask"] == "rate":
            return evaluator.rate(float(header["objective"]), header["note"])
        field = ForceField.model_validate(header["force_field"])
        note = str(header.get("note", ""))
        match header["ask"]:
            case "score" | "watch" | "gradient" | "play" as what:
                return getattr(evaluator, what)(field, note)
            case "jacobian":
                unknowns = header["parametrisation"]
                if unknowns is not None:
                    template = ForceField.model_validate(unknowns.pop("template"))
                    unknowns = Parametrisation(template=template, **unknowns)
                return evaluator.jacobian(field, unknowns, note)
            case "pull_back":
                others = tuple(map(ForceField.model_validate, header["others"]))
                truncation = Truncation(**header["truncation"])
                return evaluator.pull_back(field, arrays["pixels"], truncation, others)
            case "differentiate_pictures":
                frames = [int(frame) for frame in header["frames"]]
                return evaluator.differentiate_pictures(field, self._make_loss(evaluator), frames, note)
        raise ValueError(header["ask"])

    def _make_loss(self, evaluator: Evaluator):
        """A loss of pictures that is computed inside, with its slope by the colours."""

        def ask(rgb: jax.Array) -> tuple[jax.Array, jax.Array]:
            told, first = tuple(evaluator.evaluations), len(evaluator.evaluations)
            self._connection.send(Reply("pictures", np.asarray(rgb), evaluator.spent, first, told[first:]))
            header, arrays = self._receive()
            slope = jnp.asarray(arrays["slope"], rgb.dtype).reshape(rgb.shape)
            return jnp.asarray(header["loss"], rgb.dtype), slope

        @jax.custom_vjp
        def loss(rgb):
            return ask(rgb)[0]

        loss.defvjp(ask, lambda slope, way: (way * slope,))
        return loss


def _end(child: subprocess.Popen, connection: Connection, folder: str) -> None:
    """End a process and remove what it has written."""
    connection.close()
    with suppress(ProcessLookupError):
        child.kill()
    child.wait()
    shutil.rmtree(folder, ignore_errors=True)
