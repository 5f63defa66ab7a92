"""The gradient of the classical substep by Warp's tape, neo-Hookean, on a dense cube of nodes, in float32.

What a user of warp-mpm writes to differentiate it: every substep has arrays of its own for particles and nodes, the
kernels of a substep (p2g with the stress, grid with gravity and planes, g2p) are recorded, and `Tape.backward` replays
their generated adjoints. Nothing is overwritten, as the tape requires. Import only where Warp is installed.
"""

# The bodies are Warp's language, not Python: its types do not describe element access or matrix products.
# pyright: reportIndexIssue=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportAssignmentType=false, reportAttributeAccessIssue=false, reportGeneralTypeIssues=false

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from benchmarks.peers.scene import PeerScene

wp.config.log_level = wp.LOG_WARNING


class WarpTape:
    """Loss and its gradient for a scene with one sticky floor across z; one thread, as Warp has on a CPU."""

    name = "warp_tape"

    def version(self) -> str:
        """Warp's version and device."""
        return f"warp-lang {wp.__version__} on cpu"

    def load(self, scene: PeerScene, dt: float, steps: int, weight: np.ndarray) -> None:
        """Allocate the arrays of all substeps."""
        self._scene, self._dt, self._steps = scene, float(dt), steps
        n, nodes = scene.particle_count, (scene.cells + 1,) * 3
        mu, lam = scene.lame

        def known(values: Any, dtype: Any) -> Any:
            return wp.array(np.ascontiguousarray(values, np.float32), dtype=dtype, device="cpu")

        def unknown(shape: Any, dtype: Any) -> Any:
            return wp.zeros(shape, dtype=dtype, device="cpu", requires_grad=True)

        self._begun, self._weight = known(scene.v, wp.vec3), known(weight, wp.vec3)
        self._constants = [known(each, float) for each in (scene.mass, scene.volume, mu, lam)]
        self._scales = wp.array(np.ones(3, np.float32), dtype=float, device="cpu", requires_grad=True)
        self._x, self._v = ([unknown(n, wp.vec3) for _ in range(steps + 1)] for _ in range(2))
        self._C, self._F = ([unknown(n, wp.mat33) for _ in range(steps + 1)] for _ in range(2))
        self._x[0].assign(np.ascontiguousarray(scene.x, np.float32))
        self._F[0].assign(np.broadcast_to(np.eye(3, dtype=np.float32), (n, 3, 3)).copy())
        self._mass = [unknown(nodes, float) for _ in range(steps)]
        self._momentum, self._velocity = ([unknown(nodes, wp.vec3) for _ in range(steps)] for _ in range(2))
        self._loss = unknown(1, float)

    def compute_gradient(self) -> tuple[float, np.ndarray]:
        """The loss, and its derivatives by gravity, initial velocity and stiffness, each as a factor, shape (3,)."""
        for arrays in (self._mass, self._momentum):
            for array in arrays:
                array.zero_()
        self._loss.zero_()
        with wp.Tape() as tape:
            self._simulate()
        tape.backward(self._loss)
        gradient = self._scales.grad.numpy().astype(float)
        value = float(self._loss.numpy()[0])
        tape.zero()
        return value, gradient

    def _simulate(self) -> None:
        scene, n = self._scene, self._scene.particle_count
        nodes, empty = self._mass[0].shape, 1e-15 * float(scene.mass.min())
        floor = scene.planes[0].point[2] * (1 + 1e-6)
        launch = lambda kernel, dim, *inputs: wp.launch(kernel, dim=dim, inputs=list(inputs), device="cpu")  # noqa: E731
        launch(begin, n, self._begun, self._scales, self._v[0])
        for s in range(self._steps):
            before = self._x[s], self._v[s], self._C[s], self._F[s]
            after = self._x[s + 1], self._v[s + 1], self._C[s + 1], self._F[s + 1]
            launch(
                p2g,
                n,
                *before,
                *self._constants,
                self._scales,
                self._dt,
                scene.dx,
                self._mass[s],
                self._momentum[s],
            )
            launch(
                grid, nodes, self._mass[s], self._momentum[s], self._scales, wp.vec3(*scene.gravity), self._dt,
                scene.dx, empty, floor, scene.domain_box or 0, self._velocity[s],
            )  # fmt: skip
            launch(g2p, n, self._velocity[s], before[0], before[3], self._dt, scene.dx, *after)
        launch(add_loss, n, self._x[-1], self._weight, 1.0 / n, self._loss)


@wp.func
def spline(f: float) -> wp.vec3:
    """Weights of three nodes for a particle ``f`` cells beyond the first."""
    return wp.vec3(0.5 * (1.5 - f) * (1.5 - f), 0.75 - (f - 1.0) * (f - 1.0), 0.5 * (f - 0.5) * (f - 0.5))


@wp.func
def spline_slope(f: float) -> wp.vec3:
    """Their derivatives."""
    return wp.vec3(f - 1.5, 2.0 - 2.0 * f, f - 0.5)


@wp.kernel
def begin(begun: wp.array[wp.vec3], scales: wp.array[float], v: wp.array[wp.vec3]):
    """The scaled initial velocity."""
    p = wp.tid()
    v[p] = scales[1] * begun[p]


@wp.kernel
def p2g(
    x: wp.array[wp.vec3],
    v: wp.array[wp.vec3],
    C: wp.array[wp.mat33],
    F: wp.array[wp.mat33],
    mass: wp.array[float],
    volume: wp.array[float],
    mu: wp.array[float],
    lam: wp.array[float],
    scales: wp.array[float],
    dt: float,
    dx: float,
    node_mass: wp.array3d[float],
    momentum: wp.array3d[wp.vec3],
):
    """Stress, mass and momentum to the nodes."""
    p = wp.tid()
    g = x[p] / dx
    bx, by, bz = int(g[0] - 0.5), int(g[1] - 0.5), int(g[2] - 0.5)
    fx, fy, fz = g[0] - float(bx), g[1] - float(by), g[2] - float(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    sx, sy, sz = spline_slope(fx), spline_slope(fy), spline_slope(fz)
    f = F[p]
    one = wp.identity(n=3, dtype=float)
    pressure = lam[p] * wp.log(wp.determinant(f))
    tau = scales[2] * (mu[p] * (f * wp.transpose(f) - one) + pressure * one)
    force = (-dt * volume[p] / dx) * tau
    m = mass[p]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                slope = wp.vec3(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                reach = dx * wp.vec3(float(i) - fx, float(j) - fy, float(k) - fz)
                share = (weight * m) * (v[p] + C[p] * reach) + force * slope
                wp.atomic_add(node_mass, bx + i, by + j, bz + k, weight * m)
                wp.atomic_add(momentum, bx + i, by + j, bz + k, share)


@wp.func
def wall(u: float, index: int, last: int, padding: int) -> float:
    """One velocity component without its outward part inside the walls."""
    if index < padding:
        return wp.max(u, 0.0)
    if index > last - padding:
        return wp.min(u, 0.0)
    return u


@wp.kernel
def grid(
    node_mass: wp.array3d[float],
    momentum: wp.array3d[wp.vec3],
    scales: wp.array[float],
    gravity: wp.vec3,
    dt: float,
    dx: float,
    empty: float,
    floor: float,
    padding: int,
    velocity: wp.array3d[wp.vec3],
):
    """Momentum to velocity, gravity, the sticky floor, and the walls of the domain."""
    i, j, k = wp.tid()
    m = node_mass[i, j, k]
    if m > empty and dx * float(k) > floor:
        u = momentum[i, j, k] / m + (dt * scales[0]) * gravity
        last = node_mass.shape[0] - 1
        velocity[i, j, k] = wp.vec3(
            wall(u[0], i, last, padding), wall(u[1], j, last, padding), wall(u[2], k, last, padding)
        )
    else:
        velocity[i, j, k] = wp.vec3()


@wp.kernel
def g2p(
    velocity: wp.array3d[wp.vec3],
    x: wp.array[wp.vec3],
    F: wp.array[wp.mat33],
    dt: float,
    dx: float,
    x_after: wp.array[wp.vec3],
    v_after: wp.array[wp.vec3],
    C_after: wp.array[wp.mat33],
    F_after: wp.array[wp.mat33],
):
    """Velocities back to the particles, which move with them."""
    p = wp.tid()
    g = x[p] / dx
    bx, by, bz = int(g[0] - 0.5), int(g[1] - 0.5), int(g[2] - 0.5)
    fx, fy, fz = g[0] - float(bx), g[1] - float(by), g[2] - float(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    sx, sy, sz = spline_slope(fx), spline_slope(fy), spline_slope(fz)
    v = wp.vec3()
    affine = wp.mat33()
    gradient = wp.mat33()
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                slope = wp.vec3(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                reach = wp.vec3(float(i) - fx, float(j) - fy, float(k) - fz)
                u = velocity[bx + i, by + j, bz + k]
                v = v + weight * u
                affine = affine + wp.outer(weight * u, reach)
                gradient = gradient + wp.outer(u, slope)
    v_after[p] = v
    C_after[p] = (4.0 / dx) * affine
    F_after[p] = F[p] + (dt / dx) * (gradient * F[p])
    x_after[p] = x[p] + dt * v


@wp.kernel
def add_loss(x: wp.array[wp.vec3], weight: wp.array[wp.vec3], share: float, loss: wp.array[float]):
    """Mean of z^2 + 0.1 w . x / 3 over the particles."""
    p = wp.tid()
    wp.atomic_add(loss, 0, share * (x[p][2] * x[p][2] + (0.1 / 3.0) * wp.dot(weight[p], x[p])))
