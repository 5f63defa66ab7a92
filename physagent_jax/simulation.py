"""Playing a compiled scene: every frame is simulated, its Gaussians deformed and its picture taken."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import jax
import numpy as np

from physagent_jax.gaussians.binding import deform
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.metrics.motion import true_motion
from physagent_jax.mpm import Frame, simulate, stable_dt
from physagent_jax.mpm.energy import (
    angular_momentum,
    elastic_energy,
    gravitational_energy,
    kinetic_energy,
    momentum,
)
from physagent_jax.mpm.ledger import Exchange
from physagent_jax.render import render
from physagent_jax.run_folder import Ledger, SimulationRecord
from physagent_jax.scene.compile import Scene
from physagent_jax.stopwatch import Stopwatch

Progress = Callable[[int, int], None]
"""Called after every frame with (frames done, frames in all)."""


@dataclasses.dataclass(frozen=True)
class Recording:
    """What playing a scene gives.

    Attributes:
        rgb: Pictures, uint8, shape (T, height, width, 3).
        depth: z-depth [m], 0 where nothing is, shape (T, height, width).
        x: Particle positions [m], shape (T, n, 3).
        F: Deformation gradients, shape (T, n, 3, 3).
        gaussians: Gaussian centres [m], shape (T, g, 3).
        record: Facts and figures, the true motion among them.
    """

    rgb: np.ndarray
    depth: np.ndarray
    x: np.ndarray
    F: np.ndarray
    gaussians: np.ndarray
    record: SimulationRecord


def play(scene: Scene, watch: Stopwatch, progress: Progress | None = None) -> Recording:
    """Simulates and renders all frames of ``scene``.

    Raises:
        UserError: The scene cannot be simulated (`mpm.simulate` says why).
    """
    books, shots = _Books(scene), _Shots()
    for frame in watch.timed("simulate", frames(scene)):
        with watch("render"):
            splats = splats_at(scene, frame)
            picture = render(splats, scene.camera, background=scene.config.rendering.background)
            shots.add(picture, splats, frame)
        with watch("simulate"):
            books.add(frame)
        if progress:
            progress(frame.index + 1, scene.config.timing.frame_count)
    return shots.recording(books)


def frames(scene: Scene) -> Iterator[Frame]:
    """The frames of ``scene``, simulated one after another."""
    timing = scene.config.timing
    return simulate(
        scene.model,
        scene.state,
        frame_count=timing.frame_count,
        frame_dt=timing.frame_dt,
        substep_dt=None if timing.substep_dt == "auto" else timing.substep_dt,
        safety=timing.safety,
        force_substep=timing.force_substep,
        ledger=scene.config.ledger,
    )


def splats_at(scene: Scene, frame: Frame) -> Splats:
    """The Gaussians of one frame."""
    x, F = frame.state.x[scene.back], frame.state.F[scene.back]
    return _deform(scene.body.cloud, scene.body.binding, x, F, scene.body.placement.rotation)


_deform = jax.jit(deform)


class _Shots:
    """Pictures and trajectories as they come."""

    def __init__(self):
        self._rgb, self._depth, self._gaussians, self._x, self._F = [], [], [], [], []

    def add(self, picture, splats: Splats, frame: Frame) -> None:
        self._rgb.append(np.asarray(picture.rgb))
        self._depth.append(np.asarray(picture.depth, np.float32))
        self._gaussians.append(np.asarray(splats.means))
        self._x.append(np.asarray(frame.state.x))
        self._F.append(np.asarray(frame.state.F))

    def recording(self, books: _Books) -> Recording:
        rgb = (np.clip(np.stack(self._rgb), 0, 1) * 255 + 0.5).astype(np.uint8)
        gaussians = np.stack(self._gaussians)
        return Recording(
            rgb,
            np.stack(self._depth),
            np.stack(self._x),
            np.stack(self._F),
            gaussians,
            books.record(gaussians),
        )


class _Books:
    """Energies, momenta and step sizes per frame."""

    def __init__(self, scene: Scene):
        self._scene = scene
        self._frames: list[Frame] = []
        self._budgets: list[dict[str, np.ndarray]] = []
        self._exchanges: list[Exchange] = []
        self._bound = float(stable_dt(scene.model, scene.state))
        mass, x = np.asarray(scene.model.mass), np.asarray(scene.state.x)
        self._centre = (mass[:, None] * x).sum(0) / mass.sum()

    def add(self, frame: Frame) -> None:
        budget = _budget(self._scene.model, frame.state, self._centre)
        self._budgets.append({name: np.asarray(value, float) for name, value in budget.items()})
        if frame.exchange is not None:
            self._exchanges.append(frame.exchange)
        self._stopped = int(frame.state.stopped)
        self._frames.append(dataclasses.replace(frame, state=None, exchange=None))  # type: ignore[arg-type]

    def record(self, gaussians: np.ndarray) -> SimulationRecord:
        done = self._frames[1:]
        series = {name: np.stack([b[name] for b in self._budgets]) for name in self._budgets[0]}
        series["gravitational_energy"] -= series["gravitational_energy"][0]
        return SimulationRecord(
            particle_count=self._scene.body.particles.count,
            gaussian_count=self._scene.body.cloud.count,
            grid_shape=self._frames[-1].grid_shape,
            dx=self._scene.model.grid.dx,
            substeps=sum(f.substeps for f in done),
            substep_dt=tuple(f.dt for f in done),
            stable_dt=self._bound,
            redone_frames={f.index: "; ".join(f.retries) for f in done if f.retries},
            stopped_particles=self._stopped,
            min_volume_ratio=tuple(f.min_J for f in self._frames),
            max_volume_ratio=tuple(f.max_J for f in self._frames),
            ledger=_summed(self._exchanges) if self._exchanges else None,
            truth=true_motion(gaussians),
            **{name: tuple(values.tolist()) for name, values in series.items()},
        )


def _summed(exchanges: list[Exchange]) -> Ledger:
    """Running totals, one entry per frame."""
    names = [field.name for field in dataclasses.fields(Exchange)]
    columns = {name: np.stack([np.asarray(getattr(e, name), float) for e in exchanges]) for name in names}
    return Ledger(**{name: tuple(np.cumsum(column, axis=0).tolist()) for name, column in columns.items()})


@jax.jit
def _budget(model, state, centre):
    return dict(
        kinetic_energy=kinetic_energy(model, state),
        elastic_energy=elastic_energy(model, state),
        gravitational_energy=gravitational_energy(model, state),
        momentum=momentum(model, state),
        angular_momentum=angular_momentum(model, state, centre),
    )
