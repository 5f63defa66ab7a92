"""The recording of a simulated scene: pictures, trajectories and the ledger, frame by frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property

import jax
import numpy as np

from physagent_jax.metrics.motion import measure_true_motion
from physagent_jax.mpm import Frame, Schedule, stable_dt
from physagent_jax.mpm.energy import (
    angular_momentum,
    elastic_energy,
    gravitational_energy,
    kinetic_energy,
    momentum,
)
from physagent_jax.mpm.ledger import Exchange
from physagent_jax.render import to_uint8
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.config import SceneConfig
from physagent_jax.simulation.record import Ledger, SimulationRecord


@dataclasses.dataclass(frozen=True)
class FrameOutput:
    """One frame's picture and trajectories.

    Attributes:
        rgb: uint8, shape (height, width, 3).
        depth: z-depth [m], 0 where nothing is, shape (height, width).
        gaussians: Centres [m], shape (g, 3).
        x: Positions of the model's particles [m], shape (n, 3).
        F: Their deformation gradients, shape (n, 3, 3).
    """

    rgb: np.ndarray
    depth: np.ndarray
    gaussians: np.ndarray
    x: np.ndarray
    F: np.ndarray

    @staticmethod
    def of(picture, gaussians: np.ndarray, frame: Frame) -> FrameOutput:
        """A frame as it was rendered; ``gaussians`` as in the attribute."""
        return FrameOutput(
            rgb=to_uint8(picture.rgb),
            depth=np.asarray(picture.depth, np.float32),
            gaussians=gaussians,
            x=np.asarray(frame.state.x),
            F=np.asarray(frame.state.F),
        )

    @property
    def nbytes(self) -> int:
        """Memory that it takes."""
        return sum(getattr(self, field.name).nbytes for field in dataclasses.fields(self))


@dataclasses.dataclass(frozen=True)
class FrameStatistics:
    """One frame's energies, momenta and step.

    Attributes:
        frame: Without its state and exchange.
        stopped: `State.stopped`.
        budget: Energies and momenta by the names that `SimulationRecord` gives them.
        exchange: As in `Frame`.
    """

    frame: Frame
    stopped: int
    budget: dict[str, np.ndarray]
    exchange: Exchange | None

    @staticmethod
    def of(scene: CompiledScene, frame: Frame, centre: np.ndarray) -> FrameStatistics:
        """A frame as it was simulated; angular momentum is about ``centre`` [m], shape (3,)."""
        budget = _find_budget(scene.model, frame.state, centre)
        return FrameStatistics(
            frame=dataclasses.replace(frame, state=None, exchange=None),  # type: ignore[arg-type]
            stopped=int(frame.state.stopped),
            budget={name: np.asarray(value, float) for name, value in budget.items()},
            exchange=frame.exchange,
        )


@dataclasses.dataclass(frozen=True)
class RestartCache:
    """The beginning of a recording, for a scene that shares it.

    Attributes:
        config, body: What was simulated.
        outputs, statistics: Up to the last of ``restarts``.
        restarts: Frames from which the simulation can go on, by number; their states are on the host.
        changed: Whether ``config`` does not tell all numbers (`CompiledScene.changed`): nothing can go on from it.
    """

    config: SceneConfig
    body: Body
    outputs: tuple[FrameOutput, ...]
    statistics: tuple[FrameStatistics, ...]
    restarts: dict[int, Frame]
    changed: bool = False

    @staticmethod
    def of(
        scene: CompiledScene,
        outputs: Sequence[FrameOutput],
        statistics: Sequence[FrameStatistics],
        restarts: dict[int, Frame],
    ) -> RestartCache:
        """The state and history that are needed to continue from ``restarts``."""
        count = max(restarts, default=-1) + 1
        return RestartCache(
            scene.config,
            scene.body,
            tuple(outputs[:count]),
            tuple(statistics[:count]),
            restarts,
            scene.changed,
        )


@dataclasses.dataclass(frozen=True)
class Recording:
    """The result of simulating and rendering a scene.

    Attributes:
        scene: What was simulated.
        rgb: Pictures, uint8, shape (T, height, width, 3).
        depth: z-depth [m], 0 where nothing is, shape (T, height, width).
        x: Positions of the model's particles [m], shape (T, n, 3), wheels turned (`rolling`); ``x[:, scene.back]`` are
            the body's.
        F: Their deformation gradients, shape (T, n, 3, 3).
        gaussians: Gaussian centres [m], shape (T, g, 3).
        record: Facts and figures, the true motion among them.
        frames: As they were simulated, without their states.
        restart_cache: What a scene that begins in the same way may go on from.
        reused_frames: How many frames were taken over from such a cache instead of simulated.
        last: The last frame with its state, from which the clip's ending goes on.
    """

    scene: CompiledScene
    rgb: np.ndarray
    depth: np.ndarray
    x: np.ndarray
    F: np.ndarray
    gaussians: np.ndarray
    record: SimulationRecord
    frames: tuple[Frame, ...]
    restart_cache: RestartCache
    reused_frames: int
    last: Frame

    @staticmethod
    def of(
        scene: CompiledScene,
        outputs: Sequence[FrameOutput],
        statistics: Sequence[FrameStatistics],
        restart_cache: RestartCache,
        last: Frame,
        reused_frames: int = 0,
    ) -> Recording:
        """All frames together; the first ``reused_frames`` of them were taken over."""
        gaussians = np.stack([output.gaussians for output in outputs])
        return Recording(
            scene=scene,
            rgb=np.stack([output.rgb for output in outputs]),
            depth=np.stack([output.depth for output in outputs]),
            x=np.stack([output.x for output in outputs]),
            F=np.stack([output.F for output in outputs]),
            gaussians=gaussians,
            record=_record(scene, statistics, gaussians),
            frames=tuple(each.frame for each in statistics),
            restart_cache=restart_cache,
            reused_frames=reused_frames,
            last=last,
        )

    @cached_property
    def schedule(self) -> Schedule:
        """The steps and windows that were taken, for `trajectory`."""
        return Schedule.of(self.scene.model, self.frames)


def _record(
    scene: CompiledScene, statistics: Sequence[FrameStatistics], gaussians: np.ndarray
) -> SimulationRecord:
    frames = [each.frame for each in statistics]
    done = frames[1:]
    budgets = [each.budget for each in statistics]
    exchanges = [each.exchange for each in statistics if each.exchange is not None]
    series = {name: np.stack([budget[name] for budget in budgets]) for name in budgets[0]}
    bound = float(stable_dt(scene.model, scene.state))
    series["gravitational_energy"] -= series["gravitational_energy"][0]
    return SimulationRecord(
        particle_count=scene.body.particles.count,
        gaussian_count=scene.body.cloud.count,
        grid_shape=frames[-1].grid.shape,
        dx=scene.model.grid.dx,
        substeps=sum(f.substeps for f in done),
        substep_dt=tuple(f.dt for f in done),
        stable_dt=bound if math.isfinite(bound) else None,
        redone_frames={f.index: "; ".join(f.retries) for f in done if f.retries},
        stopped_particles=statistics[-1].stopped,
        min_volume_ratio=tuple(f.min_J for f in frames),
        max_volume_ratio=tuple(f.max_J for f in frames),
        ledger=_sum_ledgers(exchanges) if exchanges else None,
        truth=measure_true_motion(gaussians),
        **{name: tuple(values.tolist()) for name, values in series.items()},
    )


def _sum_ledgers(exchanges: list[Exchange]) -> Ledger:
    """Running totals, one entry per frame."""
    names = [field.name for field in dataclasses.fields(Exchange)]
    columns = {name: np.stack([np.asarray(getattr(e, name), float) for e in exchanges]) for name in names}
    return Ledger(**{name: tuple(np.cumsum(column, axis=0).tolist()) for name, column in columns.items()})


def find_rest_centre(scene: CompiledScene) -> np.ndarray:
    """The mass centre at rest [m], shape (3,)."""
    mass, x = np.asarray(scene.model.mass), np.asarray(scene.state.x)
    return (mass[:, None] * x).sum(0) / mass.sum()


@jax.jit
def _find_budget(model, state, centre):
    return dict(
        kinetic_energy=kinetic_energy(model, state),
        elastic_energy=elastic_energy(model, state),
        gravitational_energy=gravitational_energy(model, state),
        momentum=momentum(model, state),
        angular_momentum=angular_momentum(model, state, centre),
    )
