"""MLS-MPM as one writes it first in JAX, and as published JAX codes have it, in float32.

The whole substep is one jitted function over dense arrays; P2G is a loop over the 27 nodes of a stencil with one
``.at[].add`` each, G2P one with 27 indexed reads, and the rotation of the corotated law comes from
``jnp.linalg.svd``. The host calls the substep once per step, as those codes do.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import itertools
from functools import partial
from typing import Any

import numpy as np

from benchmarks.peers.scene import Contact, Material, PeerScene

_LAWS = (Material.JELLY, Material.NEO_HOOKEAN)


class JaxNaive:
    """Runs a `PeerScene` with plain JAX, on JAX's default device and as many threads as XLA takes."""

    name = "jax_naive"

    def available(self) -> str | None:
        """Reason why JAX cannot be used, or None."""
        return None if importlib.util.find_spec("jax") else "jax is not installed"

    def version(self) -> str:
        """JAX's version and the device."""
        import jax

        return f"jax {importlib.metadata.version('jax')} on {jax.default_backend()}"

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Upload the scene, compile the substep and take one on trial.

        Raises:
            NotImplementedError: The material is neither of the two elastic ones.
        """
        if scene.material not in _LAWS:
            raise NotImplementedError(f"plain JAX: the material {scene.material.value} is not written.")
        import jax
        import jax.numpy as jnp

        self._jax, self._scene = jax, scene
        f32 = partial(jnp.asarray, dtype=jnp.float32)
        fixed = tuple(f32(values) for values in (scene.mass, scene.volume, *scene.lame))
        substep = jax.jit(partial(_advance, jnp, scene, float(dt)))
        self._advance = lambda particles: substep(fixed, particles)
        identity = np.broadcast_to(np.eye(3), (scene.particle_count, 3, 3))
        self._particles = tuple(f32(values) for values in (scene.x, scene.v, scene.C, identity))
        jax.block_until_ready(self._advance(self._particles))

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps.

        Raises:
            RuntimeError: Particles came closer than half a cell to the domain's faces, or are not finite.
        """
        for _ in range(steps):
            self._particles = self._advance(self._particles)
        self._jax.block_until_ready(self._particles)
        cells = self.x() / self._scene.dx
        if not np.all((cells >= 0.5) & (cells < self._scene.cells - 0.5)):
            raise RuntimeError("particles left the grid or are no longer finite.")

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return np.array(self._particles[0])

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return np.array(self._particles[1])

    def F(self) -> np.ndarray:
        """Deformation gradients, shape (n, 3, 3)."""
        return np.array(self._particles[3])


def _advance(jnp: Any, scene: PeerScene, dt: float, fixed: tuple, particles: tuple) -> tuple:
    """x, v, C, F one substep later."""
    (mass, volume, mu, lam), (x, v, C, F) = fixed, particles
    dx, r = scene.dx, scene.rpic_damping
    base = jnp.floor(x / dx - 0.5).astype(jnp.int32)
    f = x / dx - base
    weights = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1) ** 2, 0.5 * (f - 0.5) ** 2]

    def stencil():
        for i, j, k in itertools.product(range(3), repeat=3):
            node = base + jnp.array([i, j, k])
            weight = weights[i][:, 0] * weights[j][:, 1] * weights[k][:, 2]
            yield (node[:, 0], node[:, 1], node[:, 2]), weight[:, None], (node - x / dx) * dx

    tau = _compute_stress(jnp, scene.material, F, mu[:, None, None], lam[:, None, None])
    transposed = jnp.swapaxes(C, 1, 2)
    carried = jnp.zeros_like(C) if scene.transfer == "pic" else (1 - r / 2) * C - r / 2 * transposed
    affine = mass[:, None, None] * carried - (4 * dt / dx**2) * volume[:, None, None] * tau
    nodes = (scene.cells + 1,) * 3
    momentum, node_mass = jnp.zeros((*nodes, 3), x.dtype), jnp.zeros(nodes, x.dtype)
    for node, weight, reach in stencil():
        share = mass[:, None] * v + jnp.einsum("nij,nj->ni", affine, reach)
        momentum = momentum.at[node].add(weight * share)
        node_mass = node_mass.at[node].add(weight[:, 0] * mass)

    gravity = jnp.asarray(scene.gravity, x.dtype)
    occupied = node_mass[..., None] > 1e-15 * float(scene.mass.min())
    u = jnp.where(occupied, momentum / jnp.where(occupied, node_mass[..., None], 1) + dt * gravity, 0)
    u = _apply_boundaries(jnp, scene, u)

    velocity, moment = jnp.zeros_like(v), jnp.zeros_like(C)
    for node, weight, reach in stencil():
        share = weight * u[node]
        velocity = velocity + share
        moment = moment + share[:, :, None] * reach[:, None, :]
    C = (4 / dx**2) * moment
    return x + dt * velocity, velocity, C, F + dt * jnp.einsum("nij,njk->nik", C, F)


def _compute_stress(jnp: Any, material: Material, F: Any, mu: Any, lam: Any) -> Any:
    """Kirchhoff stress [Pa], shape (n, 3, 3)."""
    one, transposed, J = jnp.eye(3, dtype=F.dtype), jnp.swapaxes(F, 1, 2), jnp.linalg.det(F)[:, None, None]
    if material is Material.NEO_HOOKEAN:
        return mu * (F @ transposed - one) + lam * jnp.log(J) * one
    U, _, Vt = jnp.linalg.svd(F)
    return 2 * mu * (F - U @ Vt) @ transposed + lam * J * (J - 1) * one


def _apply_boundaries(jnp: Any, scene: PeerScene, u: Any) -> Any:
    """Node velocities after all planes in order, and the walls."""
    index = jnp.stack(jnp.meshgrid(*[jnp.arange(scene.cells + 1)] * 3, indexing="ij"), -1)
    for plane in scene.planes:
        normal = jnp.asarray(plane.unit_normal(), u.dtype)
        distance = (index * scene.dx - jnp.asarray(plane.point, u.dtype)) @ normal
        approach = (u @ normal)[..., None]
        along = u - approach * normal
        if plane.contact is Contact.STICKY:
            passed = jnp.zeros_like(u)
        elif plane.contact is Contact.SLIP:
            passed = along
        else:
            speed = jnp.maximum(jnp.linalg.norm(along, axis=-1, keepdims=True), 1e-30)
            slowed = jnp.maximum(1 + plane.friction * approach / speed, 0) * along
            passed = jnp.where(approach < 0, slowed, u)
        # A node on the plane is in the solid; the tolerance covers round-off of its position.
        u = jnp.where((distance <= 1e-4 * scene.dx)[..., None], passed, u)
    padding = scene.domain_box or 0
    if padding:
        u = jnp.where(index < padding, jnp.maximum(u, 0), u)
        u = jnp.where(index > scene.cells - padding, jnp.minimum(u, 0), u)
    return u
