"""The solids that act in a scene, as people should see them: plates that press, walls that move, hands that hold."""

from __future__ import annotations

import numpy as np

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
    return [
        tuple(
            block
            for block in (
                *(_draw_grip(each, time, x[index], body.extent) for each in grips),
                *(_draw_obstacle(each, time, x[index], body.extent) for each in moving),
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
