"""The only door from a method to the simulator: it charges, records and refuses.

Everything is charged, what failed and what served a line search or a choice of starts too. An oracle may ask for the
distance to the target, its gradient and its Jacobian; others get pictures, and may hand back a gradient by pixels.
"""

from __future__ import annotations

import dataclasses
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property

import jax
import numpy as np

from baselines.brief import make_scene_brief
from baselines.misses import FAILED, Score
from baselines.parametrisation import Parametrisation
from baselines.protocol import Budget, BudgetSpent, Evaluation
from baselines.simulation import Pictures, Rollout, Simulation
from baselines.tasks import Task
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.schema import SceneBrief

GRADIENT_COST = 4.3
"""[forward-equivalents] of a value with its gradient, for clips whose states fit into memory, as the tasks' do.
Measured: 2.7 to 5.2, median 4.0, on the tasks (`benchmarks.headtohead --parts gradients`), 4.1 to 4.7 on a cube of
200,000 and 20,000 particles (`benchmarks.gradients`). The simulation whose schedule it replays is charged as one."""

NEAR = 0.25
"""[1] by which |M| v may differ from that of a simulation whose steps and windows a gradient replays. The steps are as
good there, and a gradient that has to simulate first costs 1 more."""

DIFFERENCE = 0.02
"""[1] step of a Jacobian's differences, in |M| v: far above single precision's noise, far below what bends a path."""

SIDES = 0.15
"""[rad] by which the direction of a `scale` is turned to either side. Its field is k sgn(d) v: when v turns, particles
change sides one by one, and a turn has to take many of them along. Reverse mode sees none of it: the derivative of sgn
is zero where it has one. To both sides, because the best direction is often one of symmetry, at which a difference to
one side alone is none of a slope."""

KINDS = 32
"""Simulations that are remembered for their steps, one per kind of force field."""


class Evaluator:
    """A task's simulator within a budget.

    Attributes:
        task, budget, seed: As given.
        oracle: Whether the target may be asked for.
        rng: For everything random in a method.
        evaluations: What has been tried, in order.
        spent: Forward-equivalents.
        model_calls, tokens: Calls and tokens of language or video models; methods count them here.
    """

    def __init__(
        self,
        task: Task,
        budget: Budget,
        seed: int = 0,
        *,
        oracle: bool = True,
        simulation: Simulation | None = None,
        on_evaluation: Callable[[Evaluation], None] = lambda evaluation: None,
    ):
        """Begin with nothing spent; ``simulation`` in place of the task's own, ``on_evaluation`` is told of each."""
        self.task, self.budget, self.seed, self.oracle = task, budget, seed, oracle
        self.rng = np.random.default_rng(seed)
        self.evaluations: list[Evaluation] = []
        self.spent = 0.0
        self.model_calls = self.tokens = 0
        self._on_evaluation = on_evaluation
        self._begun = time.perf_counter()
        self._simulation = Simulation(task) if simulation is None else simulation
        self._rollouts: OrderedDict[str, tuple[ForceField, Rollout]] = OrderedDict()
        self._power = 1

    @cached_property
    def brief(self) -> SceneBrief:
        """The scene as agents are told of it."""
        return make_scene_brief(self.task.build(self.task.start))

    @property
    def seconds(self) -> float:
        """Wall time since the beginning [s]."""
        return time.perf_counter() - self._begun

    @property
    def remaining(self) -> float:
        """Forward-equivalents that are left, at least 0."""
        return max(0.0, self.budget.forward_equivalents - self.spent)

    @contextmanager
    def sharpened(self, power: int) -> Iterator[None]:
        """Within, all residuals are `sharpen`ed; the objectives that are recorded stay comparable with others."""
        self._power = power
        try:
            yield
        finally:
            self._power = 1

    def find_best(self) -> ForceField | None:
        """Of what has been tried and has numbers; None where there is nothing."""
        best, least = None, float("inf")
        for each in self.evaluations:
            numbers = each.force_field.actions or each.force_field.constraints
            if numbers and each.objective is not None and (best is None or each.objective < least):
                best, least = each.force_field, each.objective
        return best

    def recall(self, force_field: ForceField) -> float | None:
        """The latest objective of what has been tried; None where there is none."""
        known = [each.objective for each in self.evaluations if each.force_field == force_field]
        return known[-1] if known else None

    def score(self, force_field: ForceField, note: str = "") -> Score:
        """The miss of ``force_field`` from the target, for one simulation.

        Raises:
            BudgetSpent: There is nothing left.
            UserError: The method is not marked as an oracle.
        """
        self._need_oracle("score")
        score = self._simulate(force_field)
        self._record(force_field, score, note)
        return score

    def watch(self, force_field: ForceField, note: str = "") -> np.ndarray | None:
        """True paths under ``force_field`` [m], shape (T, n, 3), for one simulation; None where it fails.

        Recorded with its loss, as by `score`.

        Raises:
            BudgetSpent: There is nothing left.
            UserError: The method is not marked as an oracle.
        """
        self._need_oracle("watch")
        rollout = self._simulate_for_steps(force_field)
        score = FAILED if rollout is None else self._rate(self._simulation.compute_residuals(rollout))
        self._record(force_field, score, note)
        return None if rollout is None or score.failed else rollout.x

    def gradient(self, force_field: ForceField, note: str = "") -> tuple[Score, ForceFieldParameters]:
        """The same with the gradient of the loss; zero where the simulation fails.

        Charged `GRADIENT_COST`, one simulation more unless the last one of its kind was `NEAR`, and four for every
        `scale`, whose direction needs differences (`SIDES`).

        Raises:
            BudgetSpent: There is nothing left.
            UserError: The method is not marked as an oracle.
        """
        self._need_oracle("gradient")
        parameters = self._numbers(force_field)
        sharper = dict(power=self._power) if self._power > 1 else {}
        for rollout in self._list_rollouts(force_field):
            self._charge(GRADIENT_COST)
            residuals, gradient = self._simulation.differentiate(rollout, parameters, **sharper)
            score = self._rate(residuals)
            if not score.failed and _is_finite(gradient):
                gradient = self._add_sides(force_field, rollout, parameters, score, gradient)
                self._record(force_field, score, note)
                return score, gradient
        self._record(force_field, FAILED, note)
        return FAILED, _make_zeros(parameters)

    def jacobian(
        self, force_field: ForceField, parametrisation: Parametrisation | None = None, note: str = ""
    ) -> tuple[Score, np.ndarray]:
        """The residuals and their derivatives by the unknowns, by one difference each.

        Forward differences by the steps of the force field's own simulation, so that no step size jumps between them;
        for what turns a `scale`, to both sides (`SIDES`). Those by a window's unknowns are simulated anew: which frames
        a force takes part in is part of a schedule.

        Args:
            force_field: Where.
            parametrisation: By which unknowns; None = |M| v of every action and constraint.
            note: For the record.

        Returns:
            The score and the Jacobian, shape (m, p); with a failed score, shape (0, p).

        Raises:
            BudgetSpent: There is nothing left.
            UserError: The method is not marked as an oracle.
        """
        self._need_oracle("jacobian")
        unknowns = parametrisation or Parametrisation(force_field, self.task.frame_count)
        rollout = self._find_rollout(force_field)
        if rollout is None:
            score = self.score(force_field, note)
            rollout = self._find_rollout(force_field)
            if score.failed or rollout is None:
                return FAILED, np.zeros((0, unknowns.size))
        score = self._rate(self._simulation.compute_residuals(rollout))
        if not self._is_rated(force_field):  # it was played for its pictures
            self._record(force_field, score, note)
        u = unknowns.encode(force_field)
        columns: list[np.ndarray] = []
        for row, item in enumerate(unknowns.entries):
            first, last = row * unknowns.stride, (row + 1) * unknowns.stride
            if unknowns.directions and isinstance(item, Action) and get_skill(item).is_two_sided:
                columns += self._turn(unknowns, rollout, u, first, score)
                first += 3
            columns += [self._difference(unknowns, rollout, u, index, score) for index in range(first, last)]
        return score, np.stack(columns, axis=1) if columns else np.zeros((score.residuals.size, 0))

    def play(self, force_field: ForceField, note: str = "") -> Pictures | None:
        """Pictures of ``force_field``, for one simulation; None where it fails.

        The record has no objective until the method gives one (`rate`).

        Raises:
            BudgetSpent: There is nothing left.
        """
        self._charge(1.0)
        try:
            pictures, rollout = self._simulation.play(force_field)
        except UserError as error:
            self._record(force_field, FAILED, note or str(error))
            return None
        self._keep(force_field, rollout)
        self._record(force_field, None, note)
        return pictures

    def pull_back(
        self,
        force_field: ForceField,
        pixels: np.ndarray,
        truncation: Truncation = WHOLE,
        others: tuple[ForceField, ...] = (),
    ) -> tuple[ForceFieldParameters, np.ndarray]:
        """The gradients by a force field's numbers, and by the weights of others, from one by its pictures' colours.

        Charged `GRADIENT_COST`, less where it does not go back all the way (`Truncation.count_cost`), and one
        simulation more unless ``force_field`` was played last.

        Args:
            force_field: Whose pictures they are.
            pixels: d loss / d colour, colours in [0, 1], shape (T, height, width, 3). Frames of zeros cost nothing to
                draw.
            truncation: How far it goes back.
            others: Force fields that could act in its place (`alternatives`).

        Raises:
            BudgetSpent: There is nothing left.
            UserError: The force field cannot be simulated, or the shape is not that of the pictures.
        """
        rollout = self._find_rollout(force_field) or self._simulate_for_steps(force_field)
        if rollout is None:
            raise UserError("a force field that cannot be simulated has no pictures")
        camera, count = rollout.scene.camera, len(rollout.x)
        if np.shape(pixels) != (wanted := (count, camera.height, camera.width, 3)):
            raise UserError(f"`pixels` must have the pictures' shape {wanted}", got=np.shape(pixels))
        self._charge(truncation.count_cost(count, GRADIENT_COST))
        pixels = np.asarray(pixels, np.float32)
        return self._simulation.pull_back(rollout, self._numbers(force_field), pixels, truncation, others)

    def differentiate_pictures(
        self,
        force_field: ForceField,
        loss: Callable[[jax.Array], jax.Array],
        frames: Sequence[int],
        note: str = "",
    ) -> tuple[float, ForceFieldParameters]:
        """A loss of the pictures, less is better, and its gradient by a force field's numbers.

        Charged and tried as `gradient`; infinite and zero where the simulation fails.

        Args:
            force_field: Where.
            loss: A function of JAX of colours in [0, 1], shape (frames, height, width, 3).
            frames: Frames that it is shown.
            note: For the record.

        Raises:
            BudgetSpent: There is nothing left.
        """
        parameters = self._numbers(force_field)
        for rollout in self._list_rollouts(force_field):
            self._charge(GRADIENT_COST)
            value, gradient = self._simulation.differentiate_pictures(rollout, parameters, loss, frames)
            if np.isfinite(value) and _is_finite(gradient):
                self._record(force_field, value, note)
                return value, gradient
        self._record(force_field, FAILED, note)
        return float("inf"), _make_zeros(parameters)

    def rate(self, objective: float, note: str | None = None) -> None:
        """Give the latest evaluation the method's own objective, less is better.

        Raises:
            UserError: Nothing has been evaluated.
        """
        if not self.evaluations:
            raise UserError("there is no evaluation to be rated")
        latest = self.evaluations[-1]
        note = latest.note if note is None else note
        self.evaluations[-1] = dataclasses.replace(latest, objective=objective, note=note)

    def _need_oracle(self, what: str) -> None:
        if not self.oracle:
            raise UserError(
                f"`{what}` reads true particles, and this method is not marked as an oracle",
                do="Use `play`, or let its `oracle` be true",
            )

    def _charge(self, cost: float) -> None:
        seconds = self.budget.seconds
        if self.remaining <= 0 or (seconds is not None and self.seconds >= seconds):
            raise BudgetSpent
        self.spent += cost

    def _rate(self, residuals: np.ndarray) -> Score:
        return Score.of(residuals, self._power)

    def _record(self, force_field: ForceField, score: Score | float | None, note: str) -> None:
        objective = score.find_objective(self._power) if isinstance(score, Score) else score
        self.evaluations.append(Evaluation(force_field, self.spent, self.seconds, objective, note))
        self._on_evaluation(self.evaluations[-1])

    def _is_rated(self, force_field: ForceField) -> bool:
        return any(
            each.force_field == force_field and each.objective is not None for each in self.evaluations
        )

    def _simulate(self, force_field: ForceField) -> Score:
        rollout = self._simulate_for_steps(force_field)
        return FAILED if rollout is None else self._rate(self._simulation.compute_residuals(rollout))

    def _simulate_for_steps(self, force_field: ForceField) -> Rollout | None:
        """One simulation; None if it fails."""
        self._charge(1.0)
        try:
            rollout = self._simulation.simulate(force_field)
        except UserError:
            return None
        self._keep(force_field, rollout)
        return rollout

    def _list_rollouts(self, force_field: ForceField) -> Iterator[Rollout]:
        """The last simulation if its steps serve, then, if it is asked for, a simulation of the force field's own."""
        near = self._find_near(force_field)
        if near is not None:
            yield near
        own = self._simulate_for_steps(force_field)
        if own is not None:
            yield own

    def _add_sides(
        self,
        force_field: ForceField,
        rollout: Rollout,
        parameters: ForceFieldParameters,
        score: Score,
        gradient: ForceFieldParameters,
    ) -> ForceFieldParameters:
        """The gradient with differences for what turns a `scale`; what reverse mode says along it is kept."""
        slopes = list(gradient.actions)
        for index, action in enumerate(force_field.actions):
            if not get_skill(action).is_two_sided:
                continue
            along = np.asarray(action.vector)
            slope = (np.asarray(slopes[index].vector, float) @ along) * along
            for across in find_tangents(along):
                there = []
                for side in (SIDES, -SIDES):
                    entries = list(parameters.actions)
                    turned = np.cos(side) * along + np.sin(side) * across
                    entries[index] = dataclasses.replace(entries[index], vector=turned)
                    moved = dataclasses.replace(parameters, actions=tuple(entries))
                    there.append((side, self._replay(rollout, moved)))
                values = [(side, np.array([each.loss])) for side, each in there if not each.failed]
                slope = slope + divide(values, np.array([score.loss]))[0] * across
            slopes[index] = dataclasses.replace(slopes[index], vector=slope)
        return dataclasses.replace(gradient, actions=tuple(slopes))

    def _find_near(self, force_field: ForceField) -> Rollout | None:
        """The last simulation, if its steps serve ``force_field``."""
        other, rollout = self._rollouts.get(_describe_kind(force_field), (None, None))
        return rollout if other is not None and are_near(force_field, other) else None

    def _find_rollout(self, force_field: ForceField) -> Rollout | None:
        """The last simulation of its kind, if it is this one's."""
        other, rollout = self._rollouts.get(_describe_kind(force_field), (None, None))
        return rollout if other == force_field else None

    def _keep(self, force_field: ForceField, rollout: Rollout) -> None:
        """Remember the latest simulation of each of the last kinds: searches from several starts take turns."""
        kind = _describe_kind(force_field)
        self._rollouts[kind] = force_field, rollout
        self._rollouts.move_to_end(kind)
        while len(self._rollouts) > KINDS:
            self._rollouts.popitem(last=False)

    def _numbers(self, force_field: ForceField) -> ForceFieldParameters:
        return ForceFieldParameters.of(force_field, self.task.frame_count)

    def _replay(self, rollout: Rollout, parameters: ForceFieldParameters) -> Score:
        self._charge(1.0)
        return self._rate(self._simulation.replay(rollout, parameters))

    def _turn(
        self, unknowns: Parametrisation, rollout: Rollout, u: np.ndarray, first: int, score: Score
    ) -> list[np.ndarray]:
        """The three columns of a `scale`: along its vector, and by turns to both sides of it."""
        vector = u[first : first + 3]
        size = float(np.linalg.norm(vector))
        along = vector / size
        basis, slopes = np.stack([along, *find_tangents(along)]), []
        for way in basis:
            values = []
            for step in (-DIFFERENCE,) if len(slopes) == 0 else (SIDES, -SIDES):
                moved = u.copy()
                if len(slopes) == 0:
                    moved[first : first + 3] = (size + step) * along
                else:
                    moved[first : first + 3] = size * (np.cos(step) * along + np.sin(step) * way)
                there = self._replay(rollout, unknowns.to_parameters(moved))
                if not there.failed:
                    values.append((step if len(slopes) == 0 else size * step, there.residuals))
            slopes.append(divide(values, score.residuals))
        return list((np.stack(slopes, axis=1) @ basis).T)

    def _difference(
        self, unknowns: Parametrisation, rollout: Rollout, u: np.ndarray, index: int, score: Score
    ) -> np.ndarray:
        """One column; a step the other way where the first fails, zero where both do."""
        is_window = index % unknowns.stride >= unknowns.width
        for step in _choose_steps(unknowns, u, index):
            moved = u.copy()
            moved[index] += step
            if is_window:
                there = self._simulate(unknowns.decode(moved))
            else:
                there = self._replay(rollout, unknowns.to_parameters(moved))
            if not there.failed:
                return (there.residuals - score.residuals) / step
        return np.zeros_like(score.residuals)


def divide(values: list[tuple[float, np.ndarray]], here: np.ndarray) -> np.ndarray:
    """A derivative from values at steps to both sides, to one, or, where nothing is known, zero.

    Args:
        values: Pairs of a step and the value there.
        here: The value at step 0.
    """
    match values:
        case [(up, above), (down, below)]:
            return (above - below) / (up - down)
        case [(step, there)]:
            return (there - here) / step
    return np.zeros_like(here)


def find_tangents(vector: np.ndarray) -> np.ndarray:
    """Two unit vectors across a unit vector and each other, shape (2, 3)."""
    across = np.cross(vector, np.eye(3)[np.argmin(np.abs(vector))])
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(vector, across)])


def are_near(a: ForceField, b: ForceField) -> bool:
    """Return whether the steps that `simulate` took for ``b`` serve ``a``: all but |M| v is equal, that by `NEAR`."""
    if _bare(a) != _bare(b):
        return False
    entries = [(*field.actions, *field.constraints) for field in (a, b)]
    return all(
        np.linalg.norm(p.magnitude * np.asarray(p.vector) - q.magnitude * np.asarray(q.vector)) <= NEAR
        for p, q in zip(*entries)
    )


def _describe_kind(force_field: ForceField) -> str:
    return _bare(force_field).model_dump_json()


def _bare(force_field: ForceField) -> ForceField:
    """Without vectors and magnitudes, but for the signs of these."""
    groups = dict(actions=force_field.actions, constraints=force_field.constraints)
    return force_field.model_copy(update={name: tuple(map(_strip, group)) for name, group in groups.items()})


def _strip(item):
    sign = 1.0 if item.magnitude > 0 else -1.0
    return item.model_copy(update=dict(vector=(1.0, 0.0, 0.0), magnitude=sign))


def _choose_steps(unknowns: Parametrisation, u: np.ndarray, index: int) -> tuple[float, float]:
    """A difference's step inwards, then the other way; of a window, one frame."""
    row, column = divmod(index, unknowns.stride)
    if column >= unknowns.width:
        step = 1.0 / (unknowns.frame_count - 1)
        first = u[row * unknowns.stride + unknowns.width] if column > unknowns.width else 0.0
        inwards = -step if u[index] + step > 1.0 - first else step
        return inwards, -inwards
    inwards = -np.copysign(DIFFERENCE, u[index])
    return float(inwards), float(-inwards)


def _is_finite(gradient: ForceFieldParameters) -> bool:
    entries = (*gradient.actions, *gradient.constraints)
    parts = [part for each in entries for part in (each.vector, each.magnitude, each.window)]
    return all(np.isfinite(np.asarray(part)).all() for part in parts)


def _make_zeros(parameters: ForceFieldParameters) -> ForceFieldParameters:
    def zeros(group):
        return tuple(
            dataclasses.replace(
                each,
                vector=np.zeros(3),
                magnitude=np.zeros(()),
                window=np.zeros(2),
            )
            for each in group
        )

    return ForceFieldParameters(zeros(parameters.actions), zeros(parameters.constraints))
