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
from physagent_jax.mpm.energy import elastic_energy, kinetic_energy, momentum
from physagent_jax.render import render
from physagent_jax.run_folder import SimulationRecord
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
    ledger, shots = _Ledger(scene), _Shots()
    for frame in watch.timed("simulate", frames(scene)):
        with watch("render"):
            splats = splats_at(scene, frame)
            picture = render(splats, scene.camera, background=scene.config.rendering.background)
            shots.add(picture, splats, frame)
        with watch("simulate"):
            ledger.add(frame)
        if progress:
            progress(frame.index + 1, scene.config.timing.frame_count)
    return shots.recording(ledger)


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
    )


def splats_at(scene: Scene, frame: Frame) -> Splats:
    """The Gaussians of one frame."""
    x, F = _in_body_order(scene, frame.state.x), _in_body_order(scene, frame.state.F)
    return _deform(scene.body.cloud, scene.body.binding, x, F, scene.body.placement.rotation)


_deform = jax.jit(deform)


def _in_body_order(scene: Scene, values: jax.Array) -> jax.Array:
    """Model particles are grouped by material; the binding counts them as the body does."""
    if np.array_equal(scene.order, np.arange(len(scene.order))):
        return values
    return values[np.argsort(scene.order)]


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

    def recording(self, ledger: _Ledger) -> Recording:
        rgb = (np.clip(np.stack(self._rgb), 0, 1) * 255 + 0.5).astype(np.uint8)
        gaussians = np.stack(self._gaussians)
        return Recording(
            rgb,
            np.stack(self._depth),
            np.stack(self._x),
            np.stack(self._F),
            gaussians,
            ledger.record(gaussians),
        )


class _Ledger:
    """Energies, momenta and step sizes per frame."""

    def __init__(self, scene: Scene):
        self._scene = scene
        self._frames: list[Frame] = []
        self._rows: list[tuple[float, float, tuple[float, float, float]]] = []
        self._bound = float(stable_dt(scene.model, scene.state))

    def add(self, frame: Frame) -> None:
        kinetic, elastic, p = _budget(self._scene.model, frame.state)
        self._frames.append(dataclasses.replace(frame, state=None))  # type: ignore[arg-type]
        self._stopped = int(frame.state.stopped)
        self._rows.append((float(kinetic), float(elastic), tuple(np.asarray(p, float).tolist())))

    def record(self, gaussians: np.ndarray) -> SimulationRecord:
        done = self._frames[1:]
        kinetic, elastic, p = zip(*self._rows)
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
            kinetic_energy=kinetic,
            elastic_energy=elastic,
            momentum=p,
            min_volume_ratio=tuple(f.min_J for f in self._frames),
            max_volume_ratio=tuple(f.max_J for f in self._frames),
            truth=true_motion(gaussians),
        )


@jax.jit
def _budget(model, state):
    return kinetic_energy(model, state), elastic_energy(model, state), momentum(model, state)
