"""A dense-grid MLS-MPM (Hu et al. 2018) on Taichi, in float32, in the manner of its well-known examples.

One substep, on a dense cube of (cells + 1)^3 nodes: clear -> p2g, which also updates F, projects it and evaluates
the stress, so that one singular value decomposition serves both -> grid (momentum to velocity, gravity, planes,
walls in one pass) -> g2p. Nothing is sorted or sparse. Where a scene starts with C other than zero, F starts at
(I + dt C)^-1, so that the first substep sees undeformed matter as every other code does.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import importlib.util
import os
import sys
from typing import Any

import numpy as np

from benchmarks.peers.scene import Contact, Material, PeerScene

_THREADS_VARIABLE = "TI_CPU_MAX_NUM_THREADS"


class TaichiMLS:
    """Runs a `PeerScene` with Taichi on a CPU. One at a time in a process: each `load` starts Taichi anew.

    Args:
        threads: Threads of the CPU; None = what the environment variable TI_CPU_MAX_NUM_THREADS says, or all.
    """

    name = "taichi_mls"

    def __init__(self, threads: int | None = None):
        self.threads = threads

    def available(self) -> str | None:
        """Reason why Taichi cannot be used, or None."""
        if importlib.util.find_spec("taichi") is None:
            return "taichi is not installed; `pip install taichi==1.7.4`, which exists up to Python 3.13"
        return None

    def version(self) -> str:
        """Taichi's version and the threads."""
        threads = self.threads or os.environ.get(_THREADS_VARIABLE) or _count_cores()
        return f"taichi {importlib.metadata.version('taichi')} on cpu with {threads} thread(s)"

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Compile the kernels for the scene, take one trial substep, and put the particles back."""
        ti = _import_taichi()
        threads = {} if self.threads is None else {"cpu_max_num_threads": self.threads}
        with contextlib.redirect_stdout(sys.stderr):  # it prints, whatever its level of logging
            ti.init(arch=ti.cpu, default_fp=ti.f32, log_level=ti.WARN, **threads)
        self._ti, self._scene, self._dt = ti, scene, float(dt)
        self._fields = self._allocate()
        self._upload()
        self._advance()
        self._upload()
        ti.sync()

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps.

        Raises:
            RuntimeError: Particles came closer than half a cell to the domain's faces, or are not finite.
        """
        for _ in range(steps):
            self._advance()
        self._ti.sync()
        if self._fields.lost[None]:
            raise RuntimeError("particles left the grid or are no longer finite.")

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return self._fields.x.to_numpy()

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return self._fields.v.to_numpy()

    def C(self) -> np.ndarray:
        """Affine velocity matrices [1/s], shape (n, 3, 3)."""
        return self._fields.C.to_numpy()

    def F(self) -> np.ndarray:
        """Deformation gradients that belong to x, before the return mapping of plastic matter, shape (n, 3, 3)."""
        F = self._fields.F.to_numpy()
        return F + np.float32(self._dt) * self.C() @ F

    def _allocate(self) -> Any:
        kernels = importlib.import_module("benchmarks.peers._taichi_kernels")
        scene = self._scene
        laws = {material: getattr(kernels, material.name) for material in Material}
        contacts = {contact: getattr(kernels, contact.name) for contact in Contact}
        planes = tuple(
            (
                tuple(map(float, plane.point)),
                tuple(plane.unit_normal().tolist()),
                contacts[plane.contact],
                float(plane.friction),
            )
            for plane in scene.planes
        )
        # PIC carries no affine part; RPIC takes r times the symmetric part away.
        r = scene.rpic_damping
        keep, swap = (1 - r / 2, r / 2) if scene.transfer == "apic" else (0.0, 0.0)
        sine = np.sin(np.radians(scene.friction_angle_degrees))
        fields = kernels.Fields(
            count=scene.particle_count,
            cells=scene.cells,
            dx=scene.dx,
            dt=self._dt,
            law=laws[scene.material],
            gravity=scene.gravity,
            planes=planes,
            padding=scene.domain_box or 0,
            keep=keep,
            swap=swap,
            empty=1e-15 * float(scene.mass.min()),
            slope=float(np.sqrt(2 / 3) * 2 * sine / (3 - sine)),
        )
        fluid = scene.material is Material.FLUID
        first, second = (scene.bulk_modulus, scene.bulk_modulus) if fluid else scene.lame
        for field, values in (
            (fields.mass, scene.mass),
            (fields.volume, scene.volume),
            (fields.first, first),
            (fields.second, second),
            (fields.bound, scene.yield_stress),
        ):
            field.from_numpy(np.ascontiguousarray(values, np.float32))
        return fields

    def _upload(self) -> None:
        """Put the particles where the scene has them, undeformed."""
        scene, fields = self._scene, self._fields
        for field, values in (
            (fields.x, scene.x),
            (fields.v, scene.v),
            (fields.C, scene.C),
            (fields.F, np.linalg.inv(np.eye(3) + self._dt * scene.C.astype(float))),
        ):
            field.from_numpy(np.ascontiguousarray(values, np.float32))
        fields.lost[None] = 0

    def _advance(self) -> None:
        fields = self._fields
        fields.clear()
        fields.p2g()
        fields.grid()
        fields.g2p()


def _count_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _import_taichi() -> Any:
    """Taichi, whose greeting must not mix with the caller's output."""
    os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
    return importlib.import_module("taichi")
