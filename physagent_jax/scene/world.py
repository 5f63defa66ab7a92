"""What surrounds the object: gravity, the ground that it stands on, walls and blocks that a sentence names."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

import numpy as np

from physagent_jax.forces import calibration
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Boundary, Box, DomainBox, HalfSpace, Surface

LOWEST_FLOOR = 0.15  # [m]; a floor keeps clear of the domain's own wall
STRAYS = 5e-4  # of the particles: so few below all others do not hold an object up
BLOCK_SIZE = 0.5  # [L] side of a block that a sentence names


@dataclasses.dataclass(frozen=True)
class Obstacle:
    """A solid beside the object.

    Attributes:
        kind: "wall" fills all that lies behind its face; "block" is a cube of `BLOCK_SIZE`.
        direction: Where it is, seen from the object, unit vector.
        distance: Of its face from the object's nearest side [L].
    """

    kind: Literal["wall", "block"]
    direction: Sequence[float]
    distance: float


@dataclasses.dataclass(frozen=True)
class World:
    """What surrounds an object.

    Attributes:
        gravity: Where to; "none" = it acts only on what a force field lets fall.
        ground: Whether the object stands on the ground. Without, what falls finds one below it all the same.
        obstacles: Walls and blocks.
    """

    gravity: Literal["down", "up", "none"] = "none"
    ground: bool = False
    obstacles: tuple[Obstacle, ...] = ()


FREE, GROUND = World(), World(gravity="down", ground=True)
WORLDS: dict[str, World] = {"ground": GROUND, "free": FREE}


def find_gravity(world: World) -> tuple[float, float, float]:
    """Acceleration where gravity acts [m/s^2]."""
    return (0.0, 0.0, calibration.GRAVITY if world.gravity == "up" else -calibration.GRAVITY)


def build_boundaries(
    world: World, body: Body, anchor: Anchor, *, drop: bool, friction: float
) -> tuple[Boundary, ...]:
    """The domain's walls, the ground and the obstacles of ``world``.

    Args:
        world: Which of them there are.
        body: The object at rest.
        anchor: What of it is held.
        drop: Whether it falls: the ground is then `calibration.DROP_HEIGHT` below it.
        friction: Of ground and obstacles.
    """
    boundaries: list[Boundary] = [DomainBox()]
    if world.ground or drop:
        height = find_ground_height(world, body, anchor, drop=drop)
        boundaries.append(make_plane((0.0, 0.0, height), (0.0, 0.0, 1.0), friction))
    boundaries += [make_obstacle(each, body, friction) for each in world.obstacles]
    return tuple(boundaries)


def find_ground_height(world: World, body: Body, anchor: Anchor, *, drop: bool) -> float:
    """Height of the ground [m]: under the object's feet, or `calibration.DROP_HEIGHT` below what falls or hangs.

    What is held at its foot does not fall: its ground is right under it.
    """
    foot = find_foot(body) if world.ground else float(body.low[2])
    lifted = anchor.kind == "top" if world.ground else drop
    lifted = (lifted or drop) and anchor.kind != "base"
    height = foot - (calibration.DROP_HEIGHT * body.extent if lifted else 0.0)
    return max(round(height, 4), LOWEST_FLOOR)


def find_foot(body: Body) -> float:
    """Height of the object's lowest particles but for `STRAYS` of them [m]."""
    height = np.sort(body.particles.x[:, 2])
    return float(height[int(STRAYS * len(height))])


def make_obstacle(obstacle: Obstacle, body: Body, friction: float) -> HalfSpace | Box:
    """A wall that stands, or hangs overhead, across ``obstacle.direction``, or a block there, upright in the world."""
    away = np.asarray(obstacle.direction, float)
    x = np.asarray(body.particles.x, float)
    face = float((x @ away).max()) + obstacle.distance * body.extent
    centre = 0.5 * (x.min(0) + x.max(0))
    at = centre + (face - centre @ away) * away  # of the face, straight from the object
    if obstacle.kind == "wall":
        return make_plane(tuple(at.round(4).tolist()), tuple((-away).tolist()), friction)
    half = 0.5 * BLOCK_SIZE * body.extent
    at = at + half * np.abs(away).sum() * away  # so far does the cube reach back along the way
    if abs(away[2]) < 0.5:
        at[2] = find_foot(body) + half  # on the ground
    point = tuple(at.round(4).tolist())
    return Box(point=point, half_size=(half, half, half), surface=Surface.SEPARATE, friction=friction)


def make_plane(point: tuple, normal: tuple, friction: float) -> HalfSpace:
    """The solid behind a plane, which does not hold what leaves it."""
    return HalfSpace(point=point, normal=normal, surface=Surface.SEPARATE, friction=friction)
