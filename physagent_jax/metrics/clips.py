"""The true paths of an object's particles, and what motion of a part of it they amount to; differentiable.

All functions have finite derivatives at rest, where nothing moves and every deformation gradient is the identity.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError

END_SHARE = 1 / 3
"""Share of the mass that is an end of the object, as in the motion report."""
_FLAT = 1e-6  # of the spread: what is flatter stays as it is in the affine map
_TINY = 1e-12  # added below roots, so that their derivative is finite
Part = tuple[float, float, float] | None


class Clip:
    """An object's particles, frame by frame, in body lengths from the rest pose's mass centre.

    Args:
        x: True positions [m], shape (T, n, 3); frame 0 is the rest pose. May be traced.
        mass: [kg], shape (n,).
        frame_dt: Seconds per frame [s].

    Raises:
        UserError: A shape does not fit.
    """

    def __init__(self, x, mass, frame_dt: float):
        self.x, mass = jnp.asarray(x), jnp.asarray(mass)
        if self.x.ndim != 3 or self.x.shape[-1] != 3 or not self.x.size:
            raise UserError("`x` must have the shape (T, n, 3)", got=self.x.shape)
        if mass.shape != self.x.shape[1:2]:
            raise UserError("`mass` must have one number for each particle of `x`", got=mass.shape)
        self.frame_dt = float(frame_dt)
        rest = jax.lax.stop_gradient(self.x[0])
        size = jnp.maximum(jnp.ptp(rest, axis=0).max(), 1e-9)
        self.weight = (mass / mass.sum()).astype(self.x.dtype)
        self.x = (self.x - self.weight @ rest) / size
        self._rest = jax.lax.stop_gradient(self.x[0])
        self._maps: dict[Part, jax.Array] = {}

    @property
    def frame_count(self) -> int:
        """T."""
        return self.x.shape[0]

    def weigh(self, part: Part) -> jax.Array:
        """Share of each particle in a part's mass, shape (n,)."""
        if part is None:
            return self.weight
        order = jnp.argsort(-(self._rest @ jnp.asarray(part, self.x.dtype)))
        sorted_weight = self.weight[order]
        before = jnp.cumsum(sorted_weight) - sorted_weight
        chosen = jnp.zeros_like(self.weight).at[order].set(jnp.where(before < END_SHARE, sorted_weight, 0.0))
        return chosen / chosen.sum()

    def centre(self, part: Part) -> jax.Array:
        """Mass centre of a part [body lengths], shape (T, 3)."""
        return jnp.einsum("n,tni->ti", self.weigh(part), self.x)

    def maps(self, part: Part) -> jax.Array:
        """Linear part of the best affine map of a part from the rest pose, shape (T, 3, 3)."""
        if part not in self._maps:
            weight = self.weigh(part)
            arm = self.x - jnp.einsum("n,tni->ti", weight, self.x)[:, None]
            spread = jnp.einsum("n,tni,nj->tij", weight, arm, jax.lax.stop_gradient(arm[0]))
            rest = jax.lax.stop_gradient(spread[0])
            floor = (_FLAT * jnp.trace(rest) + _TINY) * jnp.eye(3, dtype=rest.dtype)
            self._maps[part] = (spread + floor) @ jnp.linalg.inv(rest + floor)
        return self._maps[part]

    def turned(self, part: Part, axis: tuple[float, float, float]) -> jax.Array:
        """The rotation of a part about a direction since frame 0 [degrees], shape (T,).

        The sum of what each frame turns it: of half a turn per frame at most. About one axis, that is the angle.
        """
        rotations = find_rotations(self.maps(part))
        steps = rotations[1:] @ jnp.swapaxes(rotations[:-1], 1, 2)
        angles = jnp.degrees(find_rotation_vectors(steps) @ jnp.asarray(axis, self.x.dtype))
        return jnp.concatenate([jnp.zeros(1, angles.dtype), jnp.cumsum(angles)])

    def moved(self, part: Part, first: int) -> jax.Array:
        """Root mean square displacement of a part's particles since frame ``first``, shape (T - first,)."""
        square = jnp.einsum("n,tni->t", self.weigh(part), (self.x[first:] - self.x[first]) ** 2)
        return compute_root(square)

    def link_growth(self, sample: int, neighbours: int) -> jax.Array:
        """Distance between neighbours over that at rest, shape (T, links).

        Particles at one place (copies of each other) are no news: a hundredth of a body length is added to both.
        """
        stride = max(1, self.x.shape[1] // sample)
        x, rest = self.x[:, ::stride], self._rest[::stride]
        count = min(neighbours, rest.shape[0] - 1)
        if count < 1:
            return jnp.ones((self.frame_count, 1), self.x.dtype)
        apart = jnp.sum((rest[:, None] - rest[None]) ** 2, -1) + jnp.diag(jnp.full(rest.shape[0], jnp.inf))
        square, near = jax.lax.top_k(-apart, count)
        now = jnp.sum((x[:, :, None] - x[:, near]) ** 2, -1)
        return (jnp.sqrt(now + 1e-4) / jnp.sqrt(1e-4 - square)).reshape(self.frame_count, -1)


def compute_root(square: jax.Array) -> jax.Array:
    """Square root, less than 1e-5 too small, with a finite derivative at zero."""
    return jnp.sqrt(square + 1e-10) - 1e-5


def find_rotations(maps: jax.Array) -> jax.Array:
    """Rotations of the polar decompositions, shape (T, 3, 3).

    Their value is from a singular value decomposition, whose own derivative fails where stretches are equal. The
    derivative of R in A = R S is that of R (1 + [w]), with (tr S - S) w the axial vector of R^T A - A^T R, which is
    zero.
    """
    fixed = jax.lax.stop_gradient(maps)
    u, _, vt = jnp.linalg.svd(fixed)
    flip = jnp.sign(jnp.linalg.det(u @ vt))
    u = u.at[..., 2].multiply(flip[..., None])
    rotation = u @ vt
    local = jnp.swapaxes(rotation, -1, -2) @ maps
    stretch = jax.lax.stop_gradient(0.5 * (local + jnp.swapaxes(local, -1, -2)))
    eye = jnp.eye(3, dtype=maps.dtype)
    inertia = (jnp.trace(stretch, axis1=-2, axis2=-1) + 1e-6)[..., None, None] * eye - stretch
    axial = _take_axial(local)
    w = jnp.linalg.solve(inertia, (axial - jax.lax.stop_gradient(axial))[..., None])[..., 0]
    return rotation @ (eye + _make_skew(w))


def find_rotation_vectors(rotations: jax.Array) -> jax.Array:
    """Axis times angle [rad] of rotations by less than half a turn, shape (T, 3)."""
    axial = 0.5 * _take_axial(rotations)
    sine = jnp.sqrt(jnp.sum(axial**2, -1) + _TINY)
    cosine = 0.5 * (jnp.trace(rotations, axis1=-2, axis2=-1) - 1.0)
    return axial * (jnp.arctan2(sine, cosine) / sine)[..., None]


def _take_axial(matrix: jax.Array) -> jax.Array:
    """Axial vector of M - M^T, shape (..., 3)."""
    return jnp.stack(
        [matrix[..., i, j] - matrix[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))],
        axis=-1,
    )


def _make_skew(w: jax.Array) -> jax.Array:
    zero = jnp.zeros_like(w[..., 0])
    rows = ((zero, -w[..., 2], w[..., 1]), (w[..., 2], zero, -w[..., 0]), (-w[..., 1], w[..., 0], zero))
    return jnp.stack([jnp.stack(row, -1) for row in rows], -2)
