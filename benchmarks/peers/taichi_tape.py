"""The gradient of an MLS-MPM substep by Taichi's automatic differentiation, neo-Hookean, dense grid, in float32.

In the manner of DiffTaichi (Hu et al. 2020): the particles of every substep are kept, the nodes are not; the reverse
pass fills them again substep by substep before the kernels' generated adjoints run. Import only where Taichi is
installed. No ``from __future__ import annotations`` here: Taichi needs the annotations of a kernel as types.
"""

# The bodies are Taichi's language, not Python.
# pyright: reportIndexIssue=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAttributeAccessIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import contextlib
import importlib.metadata
import os
import sys

import numpy as np
import taichi as ti

from benchmarks.peers.scene import PeerScene


class TaichiTape:
    """Loss and its gradient for a scene with one sticky floor across z."""

    name = "taichi_tape"

    def version(self) -> str:
        """Taichi's version and its threads."""
        return f"taichi {importlib.metadata.version('taichi')} on cpu"

    def load(self, scene: PeerScene, dt: float, steps: int, weight: np.ndarray) -> None:
        """Start Taichi with as many threads as this process has cores, and allocate the particles of all substeps."""
        with contextlib.redirect_stdout(sys.stderr):  # it prints, whatever its level of logging
            ti.init(
                arch=ti.cpu,
                default_fp=ti.f32,
                log_level=ti.WARN,
                cpu_max_num_threads=len(os.sched_getaffinity(0)),
            )
        self._kernels = Kernels(scene, float(dt), steps, weight)

    def compute_gradient(self) -> tuple[float, np.ndarray]:
        """The loss, and its derivatives by gravity, initial velocity and stiffness, each as a factor, shape (3,)."""
        kernels = self._kernels
        kernels.loss[None] = 0.0
        kernels.begin()
        for s in range(kernels.steps):
            kernels.clear()
            kernels.p2g(s)
            kernels.grid()
            kernels.g2p(s)
        kernels.add_loss()
        kernels.clear_adjoints()
        kernels.loss.grad[None] = 1.0
        kernels.add_loss.grad()
        for s in reversed(range(kernels.steps)):
            kernels.clear()
            kernels.p2g(s)
            kernels.grid()
            kernels.g2p.grad(s)
            kernels.grid.grad()
            kernels.p2g.grad(s)
        kernels.begin.grad()
        ti.sync()
        return float(kernels.loss[None]), kernels.scales.grad.to_numpy().astype(float)


@ti.data_oriented
class Kernels:
    """Particles of all substeps, nodes of one, and the kernels on them."""

    def __init__(self, scene: PeerScene, dt: float, steps: int, weight: np.ndarray):
        self.steps, self.count, self.dt, self.dx = steps, scene.particle_count, dt, scene.dx
        self.cells, self.padding = scene.cells, scene.domain_box or 0
        self.gravity, self.empty = scene.gravity, 1e-15 * float(scene.mass.min())
        self.floor = float(scene.planes[0].point[2]) * (1 + 1e-6)
        shape = (steps + 1, self.count)
        self.x, self.v = (ti.Vector.field(3, ti.f32, shape, needs_grad=True) for _ in range(2))
        self.C, self.F = (ti.Matrix.field(3, 3, ti.f32, shape, needs_grad=True) for _ in range(2))
        nodes = (scene.cells + 1,) * 3
        self.node_mass = ti.field(ti.f32, nodes, needs_grad=True)
        self.momentum, self.velocity = (ti.Vector.field(3, ti.f32, nodes, needs_grad=True) for _ in range(2))
        self.scales, self.loss = ti.field(ti.f32, 3, needs_grad=True), ti.field(ti.f32, (), needs_grad=True)
        self.mass, self.volume, self.mu, self.lam = (ti.field(ti.f32, self.count) for _ in range(4))
        self.begun, self.weight, self.rest = (ti.Vector.field(3, ti.f32, self.count) for _ in range(3))
        mu, lam = scene.lame
        for field, values in (
            (self.mass, scene.mass), (self.volume, scene.volume), (self.mu, mu), (self.lam, lam),
            (self.begun, scene.v), (self.weight, weight), (self.rest, scene.x), (self.scales, np.ones(3)),
        ):  # fmt: skip
            field.from_numpy(np.ascontiguousarray(values, np.float32))
        self.place()

    @ti.kernel
    def place(self):
        """The particles of the first substep, undeformed."""
        for p in range(self.count):
            self.x[0, p] = self.rest[p]
            self.F[0, p] = ti.Matrix.identity(ti.f32, 3)

    @ti.kernel
    def begin(self):
        """The scaled initial velocity."""
        for p in range(self.count):
            self.v[0, p] = self.scales[1] * self.begun[p]

    @ti.kernel
    def clear(self):
        """Empty the nodes and their adjoints."""
        for node in ti.grouped(self.node_mass):
            self.node_mass[node] = 0.0
            self.node_mass.grad[node] = 0.0
            self.momentum[node] = ti.Vector([0.0, 0.0, 0.0])
            self.momentum.grad[node] = ti.Vector([0.0, 0.0, 0.0])
            self.velocity.grad[node] = ti.Vector([0.0, 0.0, 0.0])

    @ti.kernel
    def clear_adjoints(self):
        """Empty the adjoints of the particles and of what is asked for."""
        for s, p in self.x:
            self.x.grad[s, p] = ti.Vector.zero(ti.f32, 3)
            self.v.grad[s, p] = ti.Vector.zero(ti.f32, 3)
            self.C.grad[s, p] = ti.Matrix.zero(ti.f32, 3, 3)
            self.F.grad[s, p] = ti.Matrix.zero(ti.f32, 3, 3)
        for i in range(3):
            self.scales.grad[i] = 0.0

    @ti.kernel
    def p2g(self, s: ti.i32):
        """F grows with C; stress, mass and momentum go to the nodes."""
        for p in range(self.count):
            g = self.x[s, p] / self.dx
            base = ti.cast(g - 0.5, ti.i32)
            f = g - ti.cast(base, ti.f32)
            w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
            F = self.F[s, p] + self.dt * (self.C[s, p] @ self.F[s, p])
            self.F[s + 1, p] = F
            one = ti.Matrix.identity(ti.f32, 3)
            tau = self.mu[p] * (F @ F.transpose() - one) + self.lam[p] * ti.log(F.determinant()) * one
            m = self.mass[p]
            affine = m * self.C[s, p] - (4.0 * self.dt / self.dx**2 * self.volume[p] * self.scales[2]) * tau
            for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                offset = ti.Vector([i, j, k])
                weight = w[i][0] * w[j][1] * w[k][2]
                reach = (ti.cast(offset, ti.f32) - f) * self.dx
                self.momentum[base + offset] += weight * (m * self.v[s, p] + affine @ reach)
                self.node_mass[base + offset] += weight * m

    @ti.kernel
    def grid(self):
        """Momentum to velocity, gravity, the sticky floor, and the walls of the domain."""
        for i, j, k in self.node_mass:
            u = ti.Vector([0.0, 0.0, 0.0])
            if self.node_mass[i, j, k] > self.empty and self.dx * k > self.floor:
                u = self.momentum[i, j, k] / self.node_mass[i, j, k] + self.dt * self.scales[0] * ti.Vector(
                    self.gravity
                )
            for d in ti.static(range(3)):
                index = ti.static((i, j, k))[d]
                if index < self.padding:
                    u[d] = ti.max(u[d], 0.0)
                if index > self.cells - self.padding and ti.static(self.padding > 0):
                    u[d] = ti.min(u[d], 0.0)
            self.velocity[i, j, k] = u

    @ti.kernel
    def g2p(self, s: ti.i32):
        """Velocities and C back to the particles, which move."""
        for p in range(self.count):
            g = self.x[s, p] / self.dx
            base = ti.cast(g - 0.5, ti.i32)
            f = g - ti.cast(base, ti.f32)
            w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
            velocity = ti.Vector.zero(ti.f32, 3)
            affine = ti.Matrix.zero(ti.f32, 3, 3)
            for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
                offset = ti.Vector([i, j, k])
                share = w[i][0] * w[j][1] * w[k][2] * self.velocity[base + offset]
                velocity += share
                affine += share.outer_product(ti.cast(offset, ti.f32) - f)
            self.v[s + 1, p] = velocity
            self.C[s + 1, p] = (4.0 / self.dx) * affine
            self.x[s + 1, p] = self.x[s, p] + self.dt * velocity

    @ti.kernel
    def add_loss(self):
        """Mean of z^2 + 0.1 w . x / 3 over the particles."""
        for p in range(self.count):
            x = self.x[self.steps, p]
            self.loss[None] += (x[2] ** 2 + 0.1 / 3.0 * self.weight[p].dot(x)) / self.count
