"""The classical explicit algorithm of warp-mpm and PhysGaussian, written anew on NVIDIA Warp, in float32.

One substep, on a dense cube of (cells + 1)^3 nodes:

zero nodes -> p2g (APIC, RPIC or PIC; force -V0 tau grad w) -> grid_update (p / m + dt g) -> boundaries
-> g2p (PIC velocity, C, x += dt v, trial F = (I + dt sum v_i (x) grad w_i) F) -> stress (return mapping, tau).

The order of operations is that of the solvers it stands for; `stress` comes last rather than first so that F
and tau belong to the x and v that one reads. Where it is faster than those: all planes share one pass over
the nodes (there, each boundary is a pass), a plastic material shares one SVD between return mapping and
stress, neo-Hookean and fluid do none, and on CUDA a substep is one recorded graph. What is right here and
wrong there: planes that slip or separate do, and the Kirchhoff stress of METAL is U diag(tau) U^T.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from benchmarks.peers.scene import Contact, Material, PeerScene


class WarpClassical:
    """Runs a `PeerScene` with Warp.

    Args:
        device: "cpu", "cuda:0", ...; None = a CUDA device if there is one. Warp uses one thread on a CPU.
    """

    name = "warp_classical"

    def __init__(self, device: str | None = None):
        self.device = device

    def available(self) -> str | None:
        """Reason why Warp cannot be used, or None."""
        if importlib.util.find_spec("warp") is None:
            return "warp-lang is not installed; install the extra 'peers'"
        return None

    def version(self) -> str:
        """Warp's version and the device."""
        return f"warp-lang {_import_warp().__version__} on {self._pick_device()}"

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Upload the scene, compile the kernels and take one trial substep."""
        wp = _import_warp()
        from benchmarks.peers import _warp_kernels as kernels

        self._wp, self._kernels = wp, kernels
        self._device = wp.get_device(self._pick_device())
        self._scene, self._dt = scene, float(dt)
        self._allocate()
        self._upload()
        self._graph = None
        self._advance()
        if self._device.is_cuda:
            with wp.ScopedCapture(device=self._device) as capture:
                self._advance()
            self._graph = capture.graph
        self._upload()
        wp.synchronize_device(self._device)

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps.

        Raises:
            RuntimeError: Particles came closer than half a cell to the domain's faces, or are not finite.
        """
        for _ in range(steps):
            if self._graph is None:
                self._advance()
            else:
                self._wp.capture_launch(self._graph)
        self._wp.synchronize_device(self._device)
        if self._lost.numpy()[0]:
            raise RuntimeError("particles left the grid or are no longer finite.")

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return self._x.numpy().copy()

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return self._v.numpy().copy()

    def C(self) -> np.ndarray:
        """Affine velocity matrices [1/s], shape (n, 3, 3)."""
        return self._C.numpy().copy()

    def F(self) -> np.ndarray:
        """Elastic deformation gradients after the return mapping, shape (n, 3, 3); J^(1/3) I for FLUID."""
        return self._F.numpy().copy()

    def tau(self) -> np.ndarray:
        """Kirchhoff stresses [Pa] that belong to F, shape (n, 3, 3)."""
        return self._tau.numpy().copy()

    def _pick_device(self) -> str:
        if self.device is not None:
            return self.device
        return "cuda:0" if _import_warp().is_cuda_available() else "cpu"

    def _allocate(self) -> None:
        wp, scene = self._wp, self._scene
        count, nodes = scene.particle_count, (scene.cells + 1,) * 3

        def array(values: Any, dtype: Any) -> Any:
            return wp.array(np.asarray(values, np.float32), dtype=dtype, device=self._device)

        def empty(shape: Any, dtype: Any) -> Any:
            return wp.zeros(shape, dtype=dtype, device=self._device)

        self._x, self._v = empty(count, wp.vec3), empty(count, wp.vec3)
        self._C, self._F, self._tau = (empty(count, wp.mat33) for _ in range(3))
        self._node_mass, self._node_v = empty(nodes, float), empty(nodes, wp.vec3)
        self._lost = empty(1, wp.int32)
        self._mass, self._volume = array(scene.mass, float), array(scene.volume, float)
        # Nodes lighter than this carry nothing that survives round-off.
        self._empty = 1e-15 * float(scene.mass.min())
        mu, lam = (array(values, float) for values in scene.lame)
        sine = np.sin(np.radians(scene.friction_angle_degrees))
        slope = float(np.sqrt(2 / 3) * 2 * sine / (3 - sine))  # Klar et al. 2016: compression cone
        self._parameters = {
            Material.JELLY: [mu, lam],
            Material.NEO_HOOKEAN: [mu, lam],
            Material.METAL: [mu, lam, array(scene.yield_stress, float)],
            Material.SAND: [mu, lam, slope],
            Material.FLUID: [array(scene.bulk_modulus, float)],
        }[scene.material]
        kinds = {Contact.STICKY: 0, Contact.SLIP: 1, Contact.SEPARATE: 2}
        rows = lambda values: np.asarray(values, np.float32).reshape(-1, 3)  # noqa: E731
        self._planes = [
            array(rows([plane.point for plane in scene.planes]), wp.vec3),
            array(rows([plane.unit_normal() for plane in scene.planes]), wp.vec3),
            wp.array([kinds[plane.contact] for plane in scene.planes], dtype=wp.int32, device=self._device),
            array([plane.friction for plane in scene.planes], float),
        ]

    def _upload(self) -> None:
        """Put the particles where the scene has them, undeformed."""
        scene = self._scene
        identity = np.broadcast_to(np.eye(3, dtype=np.float32), (scene.particle_count, 3, 3))
        for target, values in (
            (self._x, scene.x),
            (self._v, scene.v),
            (self._C, scene.C),
            (self._F, identity),
        ):
            target.assign(np.ascontiguousarray(values, np.float32))
        self._lost.zero_()
        self._compute_stress()

    def _advance(self) -> None:
        kernels, scene, dt, dx = self._kernels, self._scene, self._dt, self._scene.dx
        particles, nodes = scene.particle_count, self._node_mass.shape
        # PIC carries no affine part; RPIC takes r times the symmetric part away.
        keep, swap = (
            (1 - scene.rpic_damping / 2, scene.rpic_damping / 2) if scene.transfer == "apic" else (0, 0)
        )
        self._node_mass.zero_()
        self._node_v.zero_()
        self._launch(
            kernels.p2g,
            particles,
            [self._x, self._v, self._C, self._tau, self._mass, self._volume, dt, dx, scene.cells],
            [float(keep), float(swap), self._node_mass, self._node_v, self._lost],
        )
        gravity = self._wp.vec3(*scene.gravity)
        self._launch(kernels.grid_update, nodes, [self._node_mass, self._node_v, gravity, dt, self._empty])
        if scene.planes or scene.domain_box:
            self._launch(kernels.boundaries, nodes, [self._node_v, *self._planes, scene.domain_box or 0, dx])
        self._launch(
            kernels.g2p,
            particles,
            [self._node_v, dt, dx, scene.cells, self._x, self._v, self._C, self._F],
        )
        self._compute_stress()

    def _compute_stress(self) -> None:
        kernel = getattr(self._kernels, self._scene.material.value)
        self._launch(kernel, self._scene.particle_count, [self._F, *self._parameters, self._tau])

    def _launch(self, kernel: Any, dim: Any, *inputs: list) -> None:
        self._wp.launch(kernel, dim=dim, inputs=sum(inputs, []), device=self._device)


def _import_warp() -> Any:
    """Warp, whose progress messages must not mix with the caller's output."""
    import warp as wp

    wp.config.log_level = wp.LOG_WARNING
    return wp
