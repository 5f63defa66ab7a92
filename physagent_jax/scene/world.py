"""The surroundings: gravity, the ground, walls and blocks that a sentence names."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from physagent_jax.forces import calibration
from physagent_jax.forces.schema import Opposition
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Boundary, Box, DomainBox, HalfSpace, Surface

LOWEST_FLOOR = 0.15  # [m]; a floor keeps clear of the domain's own wall
STRAYS = 5e-4  # of the particles: so few below all others do not hold an object up
SOLE = 0.03  # [L] of height in which an object's feet are
ROLLED = 15.0  # [degrees] of tipping by which what rolls is told from what stands on an edge
RISEN = 0.3  # share of the rise over an edge of its foot, below which it rolls
BLOCK_SIZE = 0.5  # [L] side of a block that a sentence names


@dataclasses.dataclass(frozen=True)
class Obstacle:
    """A solid beside the object.

    Attributes:
        kind: "wall" fills all that lies behind its face; "block" is a cube of `BLOCK_SIZE`.
        direction: Where it is, seen from the object, unit vector.
        distance: Distance of its face from the object's nearest side [L].
    """

    kind: Literal["wall", "block"]
    direction: Sequence[float]
    distance: float


@dataclasses.dataclass(frozen=True)
class World:
    """The surroundings of an object.

    Attributes:
        gravity: Where to; "none" = it acts only on what a force field lets fall.
        ground: Whether the object stands on the ground. Without, what falls finds one below it all the same.
        obstacles: Walls and blocks.
        drop_height: Clear height under what falls or hangs [L], as far as the domain has room.
        weight: Share of gravity that acts: an object may be too weak for all of it (`scene.standing`).
    """

    gravity: Literal["down", "up", "none"] = "none"
    ground: bool = False
    obstacles: tuple[Obstacle, ...] = ()
    drop_height: float = calibration.DROP_HEIGHT
    weight: float = 1.0


FREE, GROUND = World(), World(gravity="down", ground=True)
WORLDS: dict[str, World] = {"ground": GROUND, "free": FREE}


def find_gravity(world: World) -> tuple[float, float, float]:
    """Acceleration where gravity acts [m/s^2]."""
    g = calibration.GRAVITY * world.weight
    return (0.0, 0.0, g if world.gravity == "up" else -g)


def build_boundaries(
    world: World, body: Body, anchor: Anchor, *, drop: bool, friction: float
) -> tuple[Boundary, ...]:
    """The domain's walls, the ground and the obstacles of ``world``.

    Args:
        world: Which of them there are.
        body: The object at rest.
        anchor: What of it is held.
        drop: Whether it falls: the ground is then `World.drop_height` below it.
        friction: Friction of ground and obstacles.
    """
    boundaries: list[Boundary] = [DomainBox()]
    if world.ground or drop:
        height = find_ground_height(world, body, anchor, drop=drop)
        boundaries.append(make_plane((0.0, 0.0, height), (0.0, 0.0, 1.0), friction))
    boundaries += [make_obstacle(each, body, friction) for each in world.obstacles]
    return tuple(boundaries)


def find_ground_height(world: World, body: Body, anchor: Anchor, *, drop: bool) -> float:
    """Height of the ground [m]: under the object's feet, or `World.drop_height` below what falls or hangs.

    What is held at its foot does not fall: its ground is right under it.
    """
    foot = find_foot(body) if world.ground else float(body.low[2])
    lifted = anchor.kind == "top" if world.ground else drop
    lifted = (lifted or drop) and anchor.kind != "base"
    height = foot - (world.drop_height * body.extent if lifted else 0.0)
    return max(round(height, 4), LOWEST_FLOOR)


def find_foot(body: Body) -> float:
    """Height of the object's lowest particles but for `STRAYS` of them [m]."""
    return _find_lowest_height(body.particles.x[:, 2])


def _find_lowest_height(heights: np.ndarray) -> float:
    return float(np.sort(heights)[int(STRAYS * len(heights))])


def find_footprint(body: Body) -> np.ndarray:
    """The object's lowest `SOLE`, seen from above [m], shape (m, 2)."""
    x = np.asarray(body.particles.x, float)
    return x[x[:, 2] <= find_foot(body) + SOLE * body.extent, :2]


def find_overhang(body: Body) -> float:
    """The distance of the mass centre beyond the edge of the footprint [L]; negative = the object stands."""
    centre = np.average(body.particles.x[:, :2], axis=0, weights=body.particles.volume)
    return measure_overhang(find_footprint(body), centre) / body.extent


def measure_overhang(feet: np.ndarray, centre: np.ndarray) -> float:
    """The distance of ``centre`` (2,) beyond the hull of ``feet`` (m, 2), seen from above [m]; negative = inside."""
    try:
        hull = ConvexHull(feet)
    except (QhullError, ValueError):  # a point or an edge
        return float(np.linalg.norm(feet.mean(0) - centre))
    return float((hull.equations[:, :2] @ centre + hull.equations[:, 2]).max())


def rolls(body: Body) -> bool:
    """Return whether it rolls whichever way it is tipped, rather than rising over the edge of its foot.

    Tipped by an angle t over an edge at a distance b, the mass centre rises from h to h cos t + b sin t; on a round
    underside it stays where it is.
    """
    x, volume = np.asarray(body.particles.x, float), np.asarray(body.particles.volume, float)
    arm = x - np.average(x, axis=0, weights=volume)
    inside, height = -find_overhang(body) * body.extent, -_find_lowest_height(arm[:, 2])
    c, s = np.cos(np.radians(ROLLED)), np.sin(np.radians(ROLLED))
    over_edge = height * (c - 1) + inside * s
    if over_edge <= 0:
        return False
    ways = [np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0, 2 * np.pi, 12, endpoint=False)]
    risen = [-_find_lowest_height(c * arm[:, 2] - s * (arm[:, :2] @ way)) - height for way in ways]
    return bool(np.mean(risen) < RISEN * over_edge)


def find_opposition(
    world: World, body: Body, anchor: Anchor, *, drop: bool, friction: float, damping_rate: float, time: float
) -> Opposition | None:
    """The opposition to motions of the whole object, in closed form; None where it is free or held.

    A spin over the ground is slowed by mu g r / R^2, with r the feet's mean distance from the axis through the mass
    centre and R the radius of gyration; an object stands upright with g b / R^2, b how far inside its foot the mass
    centre is, or from the far edge of its feet where it would fall over by itself. What rolls does not.
    """
    if world.gravity != "down" or anchor.kind != "none":
        return None
    g = -find_gravity(world)[2]
    values = dict(weight=g)
    x, volume = np.asarray(body.particles.x, float), np.asarray(body.particles.volume, float)
    rolling = world.ground and rolls(body)
    if world.ground:  # what is dropped is kept upright too, once it is thrown up again
        height = np.average(x[:, 2], weights=volume) - find_foot(body)
        values["lever"] = 0.0 if rolling else max(height, 0.0)
    if world.ground and not drop:
        arm = x - np.average(x, axis=0, weights=volume)
        about_vertical = np.average((arm[:, :2] ** 2).sum(1), weights=volume)
        about_side = np.average((arm**2).sum(1) - 0.5 * (arm[:, :2] ** 2).sum(1), weights=volume)
        feet = find_footprint(body) - np.average(x[:, :2], axis=0, weights=volume)
        slowing = friction * g
        overhang = find_overhang(body)
        inside = 0.0 if rolling else -overhang * body.extent
        if (
            overhang > 0
        ):  # it may be tipped the other way than it falls by itself: over the far edge of its feet
            inside = float(np.linalg.norm(feet, axis=1).max())
        values |= dict(
            friction=slowing,
            turning=slowing * np.linalg.norm(feet, axis=1).mean() / max(about_vertical, 1e-12),
            tipping=g * inside / max(about_side, 1e-12),
        )
    travel = calibration.TRAVEL * body.extent
    return Opposition(**values, damping_rate=damping_rate, travel=travel, time=time)


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
