"""The solids that act in a scene, as people should see them: plates that press, walls that move, hands that hold."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.forces.skills import get_skill
from physagent_jax.mpm.constraints import MovingPlate, PrescribedMotion
from physagent_jax.render.blocks import Block
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile.forces import compile_skills
from physagent_jax.scene.config import Box, Cuboid, HalfSpace, SceneConfig

PANEL, THICKNESS = (
    1.15,
    0.02,
)  # times as large as the object across it a plate is drawn; half its thickness [sizes]
GRIP = 1.08  # times as large as what it holds a hand is drawn
FINGER = 0.07  # half the length of what is drawn of a finger or a hand [sizes]
COMES = 0.2  # [s] in which it is seen to come, and to go
_AWAY = 0.3  # [sizes] from where it comes
_HIGH, _BAND = 0.7, 0.08  # of what it acts on, how high its place is, and from there how far that reaches
_PALM = (0.05, 0.05)  # the same of a hand, across its way [sizes]
_LEAST = 0.12  # [s] for which it stays at what it hits
_UPRIGHT = 0.9  # cosine of a way that goes up or down
MOST_HELD = 0.5  # share of the particles; who moves more of the object than that is no hand


def find_actors(config: SceneConfig, body: Body, x: np.ndarray) -> list[tuple[Block, ...]]:
    """The solids that act in each frame; those that stand there all the time belong to the stage.

    Args:
        config: The scene.
        body: Its object.
        x: Positions of the body's particles [m], shape (T, n, 3).
    """
    times = np.arange(len(x)) * config.timing.frame_dt
    grips = _compile_grips(config, body)
    moving = [each for each in config.boundaries if _acts(each)]
    hands = _find_hands(config, x)
    return [
        tuple(
            block
            for block in (
                *(_draw_grip(each, time, x[index], body.extent) for each in grips),
                *(_draw_obstacle(each, time, x[index], body.extent) for each in moving),
                *(each.draw(index, time, body.extent) for each in hands),
            )
            if block is not None
        )
        for index, time in enumerate(times)
    ]


def make_plate(point: np.ndarray, normal: np.ndarray, x: np.ndarray, size: float) -> Block:
    """A plate before the object, a little larger than the object is across it.

    Args:
        point: A point of the plane of its face [m], shape (3,).
        normal: Unit normal out of it, shape (3,).
        x: Points of the object [m], shape (n, 3).
        size: The object's longest side at rest [m].
    """
    aside = np.cross(normal, [0, 0, 1] if abs(normal[2]) < 0.9 else [1, 0, 0])
    aside = aside / np.linalg.norm(aside)
    axes = np.stack([normal, aside, np.cross(normal, aside)])
    low, high = np.quantile(x @ axes.T, [0.005, 0.995], axis=0)
    centre, half = 0.5 * (low + high), 0.5 * PANEL * (high - low)
    half[0] = THICKNESS * size
    centre[0] = point @ normal - half[0]
    return Block(centre @ axes, axes, half)


def _compile_grips(config: SceneConfig, body: Body) -> tuple:
    drawn = tuple(
        each
        for each in config.force_field.constraints
        if not isinstance(each.region, CellsRegion) or get_skill(each).deforms == "plates"
    )
    if not drawn:
        return ()  # what turns about its joint moves by itself
    config = config.model_copy(
        update=dict(force_field=config.force_field.model_copy(update=dict(constraints=drawn)))
    )
    rest, volume = np.asarray(body.particles.x), np.asarray(body.particles.volume)
    return compile_skills(config, body, rest, volume)[1]


@dataclasses.dataclass(frozen=True)
class _Hand:
    """A hand that is shown where something is pushed, and does nothing itself.

    Attributes:
        path: The place that it touches in each frame [m], shape (T, 3).
        way: The unit vector along which it pushes, shape (3,).
        start, end: When it is there [s].
    """

    path: np.ndarray
    way: np.ndarray
    start: float
    end: float

    def draw(self, index: int, time: float, size: float) -> Block | None:
        """The hand in a frame; None while it is not there."""
        early, late = self.start - time, time - self.end
        if max(early, late) >= COMES:
            return None
        away = _AWAY * max(early, late, 0.0) / COMES
        aside = np.cross(self.way, [0, 0, 1] if abs(self.way[2]) < _UPRIGHT else [1, 0, 0])
        aside = aside / np.linalg.norm(aside)
        axes = np.stack([self.way, aside, np.cross(self.way, aside)])
        half = np.array([FINGER, *_PALM]) * size
        return Block(self.path[index] - (half[0] + away * size) * self.way, axes, half)


def _find_hands(config: SceneConfig, x: np.ndarray) -> list[_Hand]:
    """The hands of what is `touched`, on the side that it goes away from; what is turned goes as its top does."""
    field, dt, made = config.force_field, config.timing.frame_dt, []
    for each in (*field.actions, *field.constraints):
        if not each.touched or get_skill(each).deforms == "plates":
            continue
        way = np.sign(each.magnitude) * np.asarray(each.vector, float)
        way = np.cross(way, [0, 0, 1]) if get_skill(each).is_axis else way
        if np.linalg.norm(way) < 1e-6:
            continue
        way = way / np.linalg.norm(way)
        mask = np.ones(x.shape[1], bool) if each.region is None else make_region_mask(each.region, x[0])
        low, high = x[0, mask, 2].min(), x[0, mask, 2].max()
        height = abs(x[0, :, 2] - low - _HIGH * (high - low))
        near = np.flatnonzero(mask & (height <= max(_BAND * (high - low), height[mask].min())))
        middle = x[0, near].mean(0)
        across = np.linalg.norm(np.cross(x[0, near] - middle, way), axis=1)
        touched = near[np.argmin((x[0, near] - middle) @ way + across)]
        first, last = each.active_time or (0, len(x) - 1)
        last = getattr(each, "held_until", None) or last
        start, last = first * dt, last * dt
        end = max(last, start + _LEAST)
        path = x[np.clip(np.arange(len(x)), round(start / dt), round(end / dt)).clip(0, len(x) - 1), touched]
        made.append(_Hand(path.astype(float), way, start, end))
    return made


def _acts(boundary) -> bool:
    """Return whether a boundary comes, goes or moves, so that the stage does not show it."""
    if isinstance(boundary, Cuboid):
        return True
    solid = isinstance(boundary, HalfSpace) or (isinstance(boundary, Box) and not boundary.container)
    return solid and (boundary.start > 0 or any(boundary.velocity))


def _draw_grip(grip, time: float, x: np.ndarray, size: float) -> Block | None:
    if isinstance(grip, MovingPlate):
        face = grip.face
        start, end = float(face.start), float(face.end)
        speed = 0.0 if face.velocity is None else float(np.asarray(face.velocity) @ np.asarray(face.normal))
        comes, goes = (COMES * (grip.edges is not None and sign * speed > 0) for sign in (1, -1))
        if not start - comes <= time < end + goes:
            return None
        moved = 0.0 if face.velocity is None else (time - start) * np.asarray(face.velocity, np.float64)
        point, normal = np.asarray(face.point, np.float64) + moved, np.asarray(face.normal, np.float64)
        if grip.edges is None:
            return make_plate(point, normal, x, size)
        edges = np.asarray(grip.edges, np.float64)
        lengths = np.linalg.norm(edges, axis=1)
        axes = np.concatenate([normal[None], edges / lengths[:, None]])
        half = np.array([FINGER * size, *(1 / lengths)])
        return Block(point - half[0] * normal, axes, half)
    if not isinstance(grip, PrescribedMotion):
        return None
    held = np.asarray(grip.particles)
    active = (np.asarray(grip.start) <= time) & (time < np.asarray(grip.end))
    held = held[np.broadcast_to(active, held.shape) & (held < len(x))]
    if not 0 < len(held) <= MOST_HELD * len(x):
        return None
    low, high = np.quantile(x[held], [0.01, 0.99], axis=0)
    return Block(0.5 * (low + high), np.eye(3), np.maximum(0.5 * GRIP * (high - low), 0.02 * size))


def _draw_obstacle(boundary, time: float, x: np.ndarray, size: float) -> Block | None:
    if not boundary.start <= time < boundary.end:
        return None
    point = np.asarray(boundary.point, np.float64) + (time - boundary.start) * np.asarray(boundary.velocity)
    if isinstance(boundary, HalfSpace):
        return make_plate(point, np.asarray(boundary.normal, np.float64), x, size)
    return Block(point, np.eye(3), np.asarray(boundary.half_size, np.float64))
