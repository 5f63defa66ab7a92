"""Blocks of matter on a lattice, in a small domain: what is thrown, dropped, pushed and left to collapse.

A block is the same at every resolution: with twice as many cells each particle becomes the eight that share its cube,
and their mean is the material point that it was. So tracks of a finer simulation are of the same points.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import lattice
from physagent_jax.gaussians.binding import bind
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.filling import Particles
from physagent_jax.scene.placement import Placement

SIZE = 1.5  # side of the domain [m]
CELLS = 24  # along it
DX = SIZE / CELLS
FLOOR = 4 * DX  # its height [m]
PER_AXIS = 2  # particles of a cell along each axis
FRAMES = 10  # after the first
GRAVITY = (0.0, 0.0, -9.8)
TRACKS = 64


@dataclasses.dataclass(frozen=True)
class Block:
    """A scene of one block.

    Attributes:
        material: What it is made of; nominal where it is sought.
        substeps: Substeps of a frame; the step must suit all that is tried.
        frame_dt: [s].
        cells: Cells of the block along each axis.
        low: Its low corner [cells].
        gravity: [m/s^2].
        velocity: Velocity of all matter at the start [m/s].
        floor: Coulomb's coefficient of the floor; None = there is none.
        constraints: What is done to it.
    """

    material: c.Material
    substeps: int
    frame_dt: float = 0.03
    cells: tuple[int, int, int] = (7, 7, 7)
    low: tuple[float, float, float] = (8.5, 8.5, 4.5)
    gravity: tuple[float, float, float] = GRAVITY
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    floor: float | None = 0.3
    constraints: tuple[Any, ...] = ()

    @property
    def extent(self) -> float:
        """Longest side [m]."""
        return max(self.cells) * DX

    def build(self, finer: int = 1) -> CompiledScene:
        """The scene with cells and steps ``finer`` times as small."""
        boundaries: tuple[Any, ...] = (c.DomainBox(padding=3 * finer),)
        if self.floor is not None:
            floor = c.HalfSpace(point=(0.0, 0.0, FLOOR), normal=(0.0, 0.0, 1.0), friction=self.floor)
            boundaries = (*boundaries, floor)
        config = c.SceneConfig(
            source=c.Source(path="lattice", extent=self.extent),
            material=self.material,
            domain=c.Domain(size=SIZE, cells=CELLS * finer),
            timing=c.Timing(
                frame_count=FRAMES + 1,
                frame_dt=self.frame_dt,
                substep_dt=self.frame_dt / (finer * self.substeps),
            ),
            gravity=self.gravity,
            always_gravity=any(self.gravity),
            boundaries=boundaries,
            constraints=self.constraints,
        )
        return compile_scene(config, self._make_body(finer))

    def choose_tracks(self) -> np.ndarray:
        """The coarse particles that are followed, on the surface, shape (TRACKS,)."""
        place = np.stack(np.unravel_index(np.arange(np.prod(self._shape)), self._shape), -1)
        outside = np.flatnonzero((place == 0).any(1) | (place == np.array(self._shape) - 1).any(1))
        return np.random.default_rng(0).choice(outside, TRACKS, replace=False)

    def find_tracks(self, finer: int = 1) -> np.ndarray:
        """Particles whose mean each track is, shape (TRACKS, finer**3)."""
        place = np.stack(np.unravel_index(self.choose_tracks(), self._shape), -1)
        children = np.stack(np.unravel_index(np.arange(finer**3), (finer,) * 3), -1)
        found = finer * place[:, None] + children
        shape = tuple(finer * n for n in self._shape)
        return np.asarray(np.ravel_multi_index(tuple(np.moveaxis(found, -1, 0)), shape))

    @property
    def _shape(self) -> tuple[int, int, int]:
        nx, ny, nz = (PER_AXIS * n for n in self.cells)
        return nx, ny, nz

    def _make_body(self, finer: int) -> Body:
        low, cells = DX * np.array(self.low), tuple(finer * n for n in self.cells)
        x = lattice(cells, DX / finer, low, PER_AXIS).astype(np.float32)
        count, width = len(x), DX / finer / PER_AXIS
        particles = Particles(x, np.full(count, width**3, np.float32), np.arange(count, dtype=np.int32))
        cloud = GaussianCloud(
            means=jnp.asarray(x),
            quats=jnp.tile(jnp.array([1.0, 0, 0, 0]), (count, 1)),
            scales=jnp.full((count, 3), 0.5 * width),
            opacities=jnp.ones(count),
            sh=jnp.zeros((count, 1, 3)),
        )
        return Body(cloud, Placement(np.eye(3), 1.0, np.zeros(3)), particles, bind(x, x, k=1))
