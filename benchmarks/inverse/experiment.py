"""Tracks of a hidden scene, and how far a guess is off: simulated as the product does it, with its derivatives."""

from __future__ import annotations

import dataclasses
from functools import cached_property

import jax
import jax.numpy as jnp
import numpy as np

import physagent_jax as pa
from baselines.evaluation import GRADIENT_COST
from benchmarks.inverse.fitting import Failed
from benchmarks.inverse.problems import Numbers, Problem
from benchmarks.inverse.scenes import FRAMES
from physagent_jax.core.errors import UserError
from physagent_jax.mpm import Frame, Schedule, simulate
from physagent_jax.scene.compile import CompiledScene

UNIT = 1e-3  # of the object's longest side: the noise of a good tracker, in which residuals are measured
DIFFERENCE = 0.02  # of a coordinate's scale: step of a Jacobian's differences


@dataclasses.dataclass(frozen=True)
class Data:
    """Origin of the tracks.

    Attributes:
        finer: Times as many cells along an axis, and substeps, as the search has.
        noise: Standard deviation of each coordinate, in shares of the object's longest side.
        seed: Seed of the noise.
    """

    finer: int = 1
    noise: float = 0.0
    seed: int = 0


EXACT = Data()


class Experiment:
    """A problem with its tracks; charges what simulations cost.

    Attributes:
        problem: What is sought.
        data: How the tracks are made.
        spent: Forward-equivalents so far, a gradient at `baselines.evaluation.GRADIENT_COST`.
    """

    def __init__(self, problem: Problem, data: Data = EXACT):
        self.problem, self.data, self.spent = problem, data, 0.0
        self._scene = problem.block.build()
        self._tracked = self._scene.back[problem.block.find_tracks()]
        self._unit = UNIT * problem.block.extent
        self._last: tuple[np.ndarray, Schedule] | None = None

    @property
    def particle_count(self) -> int:
        """Of the scene that is searched."""
        return self._scene.body.particles.count

    @property
    def substeps(self) -> int:
        """Of its clip."""
        return FRAMES * self.problem.block.substeps

    @cached_property
    def observed(self) -> np.ndarray:
        """The tracks [m], shape (FRAMES, TRACKS, 3)."""
        problem, data = self.problem, self.data
        scene = self._scene if data.finer == 1 else problem.block.build(data.finer)
        tracked = scene.back[problem.block.find_tracks(data.finer)]
        frames = _simulate(scene, problem, problem.truth)
        clean = np.stack([np.asarray(frame.state.x, np.float64)[tracked].mean(1) for frame in frames[1:]])
        drawn = np.random.default_rng(data.seed).normal(size=clean.shape)
        return clean + data.noise * problem.block.extent * drawn

    def compute_residuals(self, u: np.ndarray) -> np.ndarray:
        """Residuals of the tracks in `UNIT`, shape (m,); one simulation.

        Raises:
            Failed: It cannot be simulated.
        """
        self.spent += 1.0
        try:
            frames = _simulate(self._scene, self.problem, _to_host(self.problem.decode(u)))
        except UserError as error:
            raise Failed(str(error)) from error
        self._last = np.array(u), Schedule.of(self._scene.model, frames)
        x = np.stack([np.asarray(frame.state.x) for frame in frames[1:]])
        return self._compare(x).astype(np.float64)

    def compute_loss(self, u: np.ndarray) -> float:
        """Half the residuals' square; one simulation."""
        return 0.5 * float(np.sum(self.compute_residuals(u) ** 2))

    def compute_gradient(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """The loss and its gradient by the coordinates, shape (p,), along the steps of the simulation at ``u``.

        That is done first where it is not the last one.

        Raises:
            Failed: It cannot be simulated.
        """
        if self._last is None or not np.array_equal(self._last[0], u):
            self.compute_residuals(u)
        assert self._last is not None
        schedule = self._last[1]
        self.spent += GRADIENT_COST

        def respond(u):
            parameters = self.problem.put(self._scene, self.problem.decode(u))
            return 0.5 * (self._compare(pa.trajectory(self._scene, parameters, schedule).x[1:]) ** 2).sum()

        loss, gradient = jax.value_and_grad(respond)(jnp.asarray(u, self._scene.state.x.dtype))
        if not (np.isfinite(loss) and np.isfinite(gradient).all()):
            raise Failed("the loss or its gradient is not finite")
        return float(loss), np.asarray(gradient, np.float64)

    def compute_jacobian(
        self, u: np.ndarray, residuals: np.ndarray, columns: tuple[int, ...] | None = None
    ) -> np.ndarray:
        """The residuals' derivative by the coordinates, shape (m, p): p simulations.

        Args:
            u: Where.
            residuals: There.
            columns: By these coordinates alone; None = by all.

        Raises:
            Failed: One cannot be simulated.
        """
        made = []
        for axis in range(len(u)) if columns is None else columns:
            near, size = np.array(u), DIFFERENCE * self.problem.scale[axis]
            near[axis] += size
            made.append((self.compute_residuals(near) - residuals) / size)
        return np.stack(made, 1)

    def compute_central_jacobian(self, u: np.ndarray, factor: float = 1.0) -> np.ndarray:
        """The same by central differences, 2 p simulations, with steps ``factor`` times as long.

        Raises:
            Failed: One cannot be simulated.
        """
        columns = []
        for axis, size in enumerate(factor * DIFFERENCE * self.problem.scale):
            step = size * np.eye(len(u))[axis]
            columns.append((self.compute_residuals(u + step) - self.compute_residuals(u - step)) / (2 * size))
        return np.stack(columns, 1)

    def _compare(self, x):
        """Residuals of the model's particles after the first frame [m], shape (FRAMES, n, 3)."""
        return ((x[:, self._tracked].mean(2) - self.observed.astype(x.dtype)) / self._unit).ravel()


def _simulate(scene: CompiledScene, problem: Problem, numbers: Numbers) -> list[Frame]:
    """All frames, on the whole grid of the small domain: then all guesses run the same compiled program."""
    scene, timing = scene.with_parameters(problem.put(scene, numbers)), scene.config.timing
    assert timing.substep_dt != "auto"
    return list(
        simulate(
            scene.model,
            scene.state,
            frame_count=FRAMES + 1,
            frame_dt=timing.frame_dt,
            substep_dt=timing.substep_dt,
        )
    )


def _to_host(numbers: Numbers) -> Numbers:
    return {name: np.asarray(value, np.float64) for name, value in numbers.items()}
