"""The program behind the door: it makes a method, and lets it search with an evaluator that asks outside."""

from __future__ import annotations

import dataclasses
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

import jax
import jax.numpy as jnp
import numpy as np

from baselines.door.sandbox import hide_by_hook
from baselines.door.wire import Reply, Scene, send
from baselines.evaluation import Evaluator
from baselines.methods import make_method
from baselines.misses import Score
from baselines.parametrisation import Parametrisation
from baselines.protocol import Budget, BudgetSpent, Method
from baselines.simulation import Pictures
from baselines.tasks import TaskSpec
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField


class AskedTask:
    """A task as a method sees it from behind the door: without target, judge and simulator."""

    def __init__(self, scene: Scene):
        self.spec = TaskSpec.model_construct(**scene.spec)
        self.start, self.frame_count = scene.start, scene.frame_count
        self.frame_dt, self.mass = scene.frame_dt, scene.mass

    def __getattr__(self, name: str) -> NoReturn:
        raise UserError(f"`task.{name}` stays outside the door", do="Ask the evaluator")


class AskingEvaluator(Evaluator):
    """The evaluator from behind the door: what it holds is a copy, and changes nothing outside."""

    def __init__(self, connection: Connection, scene: Scene, budget: Budget, seed: int, oracle: bool):
        asked: Any = AskedTask(scene)
        nothing: Any = ()
        super().__init__(asked, budget, seed, oracle=oracle, simulation=nothing)
        self._connection, self.brief = connection, scene.brief

    def score(self, force_field: ForceField, note: str = "") -> Score:
        """As the evaluator's."""
        return self._ask("score", force_field=force_field, note=note)

    def watch(self, force_field: ForceField, note: str = "") -> np.ndarray | None:
        """As the evaluator's."""
        return self._ask("watch", force_field=force_field, note=note)

    def gradient(self, force_field: ForceField, note: str = "") -> tuple[Score, ForceFieldParameters]:
        """As the evaluator's."""
        return self._ask("gradient", force_field=force_field, note=note)

    def jacobian(
        self, force_field: ForceField, parametrisation: Parametrisation | None = None, note: str = ""
    ) -> tuple[Score, np.ndarray]:
        """As the evaluator's."""
        return self._ask("jacobian", force_field=force_field, parametrisation=parametrisation, note=note)

    def play(self, force_field: ForceField, note: str = "") -> Pictures | None:
        """As the evaluator's."""
        return self._ask("play", force_field=force_field, note=note)

    def pull_back(
        self,
        force_field: ForceField,
        pixels: np.ndarray,
        truncation: Truncation = WHOLE,
        others: tuple[ForceField, ...] = (),
    ) -> tuple[ForceFieldParameters, np.ndarray]:
        """As the evaluator's."""
        pixels = np.asarray(pixels, np.float32)
        return self._ask(
            "pull_back",
            force_field=force_field,
            truncation=truncation,
            others=others,
            arrays=dict(pixels=pixels),
        )

    def differentiate_pictures(
        self,
        force_field: ForceField,
        loss: Callable[[jax.Array], jax.Array],
        frames: Sequence[int],
        note: str = "",
    ) -> tuple[float, ForceFieldParameters]:
        """As the evaluator's; the loss is computed here, of pictures that come from outside."""
        return self._ask(
            "differentiate_pictures",
            force_field=force_field,
            frames=list(map(int, frames)),
            note=note,
            loss=loss,
        )

    def rate(self, objective: float, note: str | None = None) -> None:
        """As the evaluator's."""
        self._ask("rate", objective=float(objective), note=note)

    def _ask(
        self,
        what: str,
        *,
        loss: Callable | None = None,
        arrays: dict[str, np.ndarray] | None = None,
        **fields,
    ) -> Any:
        header = {"ask": what, "power": self._power, **fields}
        send(self._connection, self.count() | header, arrays)
        while True:
            reply: Reply = self._connection.recv()
            self.spent = reply.spent
            self.evaluations[reply.first :] = reply.evaluations
            match reply.kind:
                case "pictures" if loss is not None:
                    value, slope = jax.value_and_grad(loss)(jnp.asarray(reply.value))
                    send(self._connection, dict(loss=float(value)), dict(slope=np.asarray(slope)))
                case "spent":
                    raise BudgetSpent
                case "refused":
                    raise UserError(reply.value)
                case _:
                    return reply.value

    def count(self) -> dict[str, int]:
        """Calls and tokens of models so far, for the message."""
        return {"model_calls": self.model_calls, "tokens": self.tokens}


def serve(connection: Connection, kept_by: str) -> None:
    """Make the method that the first message names, say what it is and what keeps files from it, and search."""
    place, options = connection.recv()
    with _told(connection):
        method: Method = make_method(place, options)
        about = dict(name=method.name, oracle=bool(method.oracle), stochastic=bool(method.stochastic))
        send(connection, about | {"options": dataclasses.asdict(method), "kept_by": kept_by})
        while True:
            scene, budget, seed = connection.recv()
            evaluator = AskingEvaluator(connection, scene, budget, seed, bool(method.oracle))
            try:
                method.search(evaluator)
            except BudgetSpent:
                pass
            except UserError as error:
                send(connection, evaluator.count() | {"refused": str(error)})
                continue
            send(connection, evaluator.count() | {"done": True})


@contextmanager
def _told(connection: Connection) -> Iterator[None]:
    """Say outside why the program ends."""
    try:
        yield
    except (EOFError, ConnectionError):
        return  # nobody asks any more
    except UserError as error:
        send(connection, {"invalid": str(error)})
    except Exception as error:
        traceback.print_exc()
        send(connection, {"broken": f"{type(error).__name__}: {error}"[:300]})


def main(arguments: list[str]) -> None:
    """Run the program; `baselines.door.sandbox` starts it."""
    file, *kept = arguments
    os.environ["TMPDIR"] = os.environ["PHYSAGENT_DOOR_FOLDER"]
    if kept != ["landlock"]:
        cut = kept.index("--")
        hide_by_hook([Path(path) for path in kept[:cut]], [Path(path) for path in kept[cut + 1 :]])
    serve(Connection(int(file)), "landlock" if kept == ["landlock"] else "audit hook")


if __name__ == "__main__":
    main(sys.argv[1:])
