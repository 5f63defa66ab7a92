"""The rolling of wheels: they turn about their axles as far as a vehicle goes over the ground.

A vehicle is simulated in one piece. A wheel that runs freely neither drives it nor holds it back, so that its angle
follows from its way alone: without slipping, way = radius * angle. A wheel in the air turns on as fast as before.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.forces.part import ROLLING, Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.mpm import Frame
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.config import HalfSpace

_LEVEL = 0.5  # vertical component of an axle, from which on nothing rolls on it
_BEARS = 0.25  # [radii] over the ground up to which a wheel bears at rest
_TOUCHES = 0.35  # the same, up to which it rolls: what is soft, or goes over a bump, lifts it a little
_OUTER = 0.02  # share of its particles on each side that may lie astray
_CONCENTRIC, _WITHIN = 0.25, 1.1  # [radii] from its axle, of the middle and of all of what turns with it
_OWN = 0.5  # share of what is driven, from which on it is the wheel itself
_MOST = 0.5  # share of the object, from which on it is no wheel of it


@dataclasses.dataclass(frozen=True)
class Wheel:
    """A wheel at rest.

    Attributes:
        particles: Indices of its particles.
        rest: Their places at rest [m], shape (k, 3).
        hub: Its middle [m], shape (3,).
        axle: Unit vector, shape (3,).
        radius: [m]
    """

    particles: np.ndarray
    rest: np.ndarray
    hub: np.ndarray
    axle: np.ndarray
    radius: float


@dataclasses.dataclass
class _Course:
    """The course of a wheel: where its hub is, the angle that it has turned by, and by how much just now [rad]."""

    hub: np.ndarray
    axle: np.ndarray
    angle: float = 0.0
    step: float = 0.0


class Rolling:
    """The turning of all wheels of a vehicle, frame by frame."""

    def __init__(self, wheels: Sequence[Wheel], ground: np.ndarray, up: np.ndarray):
        """Begin at rest.

        Args:
            wheels: The wheels.
            ground: A place on the ground [m], shape (3,).
            up: Its normal, shape (3,).
        """
        self._wheels, self._ground, self._up = wheels, ground, up
        self._courses = [_Course(wheel.hub, wheel.axle) for wheel in wheels]

    @staticmethod
    def of(scene: CompiledScene) -> Rolling:
        """The rolling of a scene's wheels; none where nothing bears them, or something else turns them."""
        grounds = [e for e in scene.config.boundaries if isinstance(e, HalfSpace) and e.normal[2] > _LEVEL]
        ground = np.asarray(grounds[0].point if grounds else (0.0, 0.0, 0.0), float)
        up = np.asarray(grounds[0].normal if grounds else (0.0, 0.0, 1.0), float)
        wheels = find_wheels(scene) if grounds else ()
        return Rolling(wheels, ground, up)

    def advance(self, x: np.ndarray) -> None:
        """Go on to the next frame, turned or not.

        Args:
            x: Positions of the model's particles [m], shape (n, 3).
        """
        for wheel, course in zip(self._wheels, self._courses):
            middle, own = wheel.rest.mean(0), x[wheel.particles].astype(float)
            turn = _fit_turn(wheel.rest - middle, own - own.mean(0))
            hub, axle = own.mean(0) + turn @ (wheel.hub - middle), turn @ wheel.axle
            gap = float((hub - self._ground) @ self._up) - wheel.radius
            if abs(float(axle @ self._up)) < _LEVEL and gap < _TOUCHES * wheel.radius:
                course.step = float(np.cross(self._up, hub - course.hub) @ axle) / wheel.radius
            course.hub, course.axle, course.angle = hub, axle, course.angle + course.step

    def show(self, frame: Frame) -> Frame:
        """The next frame with the wheels turned; the first is the rest pose."""
        if not self._wheels or not frame.index:
            return frame
        x, F = np.asarray(frame.state.x), np.asarray(frame.state.F)
        self.advance(x)
        x, F = self.turn(x, F)
        return dataclasses.replace(frame, state=dataclasses.replace(frame.state, x=x, F=F))

    def turn(self, x: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Particles and their deformation gradients of the frame that it has come to, with the wheels turned.

        Args:
            x: Positions of the model's particles [m], shape (n, 3).
            F: Their deformation gradients, shape (n, 3, 3).
        """
        if not any(course.angle for course in self._courses):
            return x, F
        x, F = x.copy(), F.copy()
        for wheel, course in zip(self._wheels, self._courses):
            turn, own = Rotation.from_rotvec(course.angle * course.axle).as_matrix(), wheel.particles
            x[own] = course.hub + (x[own] - course.hub) @ turn.T
            F[own] = turn @ F[own]
        return x, F


def _fit_turn(rest: np.ndarray, now: np.ndarray) -> np.ndarray:
    """The rotation that brings centred places nearest to others, shape (3, 3) (Kabsch 1976)."""
    u, _, vt = np.linalg.svd(now.T @ rest)
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt


def find_wheels(scene: CompiledScene) -> tuple[Wheel, ...]:
    """The wheels that bear the object at rest, with what turns with them; without those that forces act on."""
    rest = np.asarray(scene.body.particles.x, float)[scene.order]
    parts = scene.body.parts if scene.body.choices else scene.body.named  # who names a wheel names a part
    named = [(part, make_region_mask(part.moved, rest)) for part in parts]
    field = scene.config.force_field
    regions = [e.region for e in (*field.actions, *field.constraints) if e.region is not None]
    driven = [make_region_mask(region, rest) for region in regions]
    low, found = float(rest[:, 2].min()), []
    for part, own in named:
        if _is_wheel(part) and own.any() and own.mean() < _MOST:
            low_corner, high_corner = np.quantile(rest[own], [_OUTER, 1 - _OUTER], axis=0)
            hub = 0.5 * (low_corner + high_corner)
            radius = hub[2] - float(rest[own, 2].min())
            if radius > 0 and hub[2] - low < (1 + _BEARS) * radius:
                found.append((part, own, hub, radius))
    axle = _find_axle([part for part, *_ in found])
    wheels, taken = [], np.zeros(len(rest), bool)
    for _, own, hub, radius in sorted(found, key=lambda each: each[1].sum()):  # a pair of them last
        whole = own | _find_fellows(rest, [mask for _, mask in named], hub, axle, radius)
        free = whole & ~taken
        moves = any((mask & whole).sum() > _OWN * mask.sum() for mask in driven)
        if free.sum() > _OWN * whole.sum() and not moves:
            wheels.append(Wheel(np.flatnonzero(free), rest[free], hub, axle, radius))
        taken |= whole
    return tuple(wheels)


def _is_wheel(part: Part) -> bool:
    """Return whether a part is called a wheel, and has a level axle."""
    return (
        part.axle is not None and abs(part.axle[2]) < _LEVEL and not ROLLING.isdisjoint(split_name(part.name))
    )


def _find_axle(parts: Sequence[Part]) -> np.ndarray:
    """The level axle that all wheels have nearly in common, a unit vector: one alone is known less well."""
    axles = [np.asarray(part.axle, float) * (1.0, 1.0, 0.0) for part in parts] or [np.array([1.0, 0.0, 0.0])]
    total = sum((each * np.copysign(1.0, each @ axles[0]) for each in axles), start=np.zeros(3))
    return total / np.linalg.norm(total)


def _find_fellows(
    rest: np.ndarray, masks: Sequence[np.ndarray], hub: np.ndarray, axle: np.ndarray, radius: float
) -> np.ndarray:
    """The particles of what turns with a wheel, shape (n,): parts that lie about its axle within it, as spokes do."""
    off = rest - hub
    away = np.linalg.norm(off - np.outer(off @ axle, axle), axis=1)
    fellows = np.zeros(len(rest), bool)
    for mask in masks:
        middle = np.linalg.norm(np.cross(off[mask].mean(0), axle)) if mask.any() else np.inf
        beside = mask.any() and abs(float(off[mask].mean(0) @ axle)) < radius
        if beside and middle < _CONCENTRIC * radius and away[mask].max() < _WITHIN * radius:
            fellows |= mask
    return fellows
