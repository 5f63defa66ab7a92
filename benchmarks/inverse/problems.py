"""The problems: scenes, what is hidden in them, and the wrong starts."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.inverse.scenes import DX, Block
from benchmarks.inverse.unknowns import UNKNOWNS, Unknown
from physagent_jax.scene import config as c
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.parameters import MaterialParameters, SceneParameters

BLOW = 0.03  # [s]
MATERIAL_NAMES = frozenset(field.name for field in dataclasses.fields(MaterialParameters))

Numbers = Mapping[str, Any]


@dataclasses.dataclass(frozen=True)
class Problem:
    """Numbers to be found again.

    Attributes:
        name: Unique.
        block: The scene, with the truth in it or not.
        truth: By the names of `UNKNOWNS`.
        starts: Where searches begin, by what is wrong with them.
        identified: Whether the tracks tell all of them; where not, nothing is to be fitted.
        first: What is sought alone at first; none = all at once.
    """

    name: str
    block: Block
    truth: Numbers
    starts: Mapping[str, Numbers]
    identified: bool = True
    first: tuple[str, ...] = ()

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """In their order."""
        return tuple(UNKNOWNS[name] for name in self.truth)

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every coordinate."""
        return tuple(
            each.name if each.size == 1 else f"{each.name} {axis}"
            for each in self.unknowns
            for axis in "xyz"[: each.size]
        )

    def encode(self, numbers: Numbers) -> np.ndarray:
        """Coordinates, shape (p,)."""
        return np.concatenate([UNKNOWNS[name].encode(numbers[name]) for name in self.truth])

    def decode(self, u: Any) -> dict[str, Any]:
        """Numbers at coordinates, traced or not."""
        found, at = {}, 0
        for each in self.unknowns:
            found[each.name] = each.decode(u[at : at + each.size])
            at += each.size
        return found

    @property
    def stages(self) -> tuple[np.ndarray, ...]:
        """Masks of the coordinates that are sought, one after the other, shape (p,) of bool each."""
        early = np.concatenate([np.full(each.size, each.name in self.first) for each in self.unknowns])
        return (early, np.ones_like(early)) if self.first else (np.ones_like(early),)

    @property
    def scale(self) -> np.ndarray:
        """Of every coordinate, shape (p,)."""
        return np.concatenate([np.full(each.size, each.scale) for each in self.unknowns])

    def put(self, scene: CompiledScene, numbers: Numbers) -> SceneParameters:
        """The scene's parameters with ``numbers``, traced or not."""
        made: dict[str, Any] = {"velocity": numbers.get("velocity", np.array(self.block.velocity))}
        material = {name: value for name, value in numbers.items() if name in MATERIAL_NAMES}
        if material:
            made["materials"] = (MaterialParameters(**material),)
        if "gravity" in numbers:
            made["gravity"] = numbers["gravity"]
        if "friction" in numbers:
            made["friction"] = (None, numbers["friction"])
        if "impulse" in numbers:
            (own,) = SceneParameters.of(scene).constraints
            made["constraints"] = (dataclasses.replace(own, value=numbers["impulse"]),)
        return SceneParameters(**made)


def turn(vector: tuple[float, float, float], degrees: float, factor: float) -> np.ndarray:
    """``vector`` turned about an axis square to it, and made ``factor`` times as long."""
    axis = np.cross(vector, (0.3, 1.0, 0.5))
    turned = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).apply(vector)
    return factor * turned


def times(name: str, truth: float, *factors: float) -> dict[str, Numbers]:
    """Start that are so many times the truth."""
    return {f"{factor:.3g} times": {name: factor * truth} for factor in factors}


def turned(name: str, truth: tuple[float, float, float]) -> dict[str, Numbers]:
    """Start whose direction and length are wrong."""
    cases = ((45.0, 2.0), (60.0, 0.5))
    return {f"{a:g} degrees, {f:g} times": {name: turn(truth, a, f)} for a, f in cases}


JELLY = c.Material(youngs_modulus=3e4, poissons_ratio=0.3, density=1000.0)
SAND = c.Material(
    model=c.MaterialModel.DRUCKER_PRAGER,
    youngs_modulus=1e5,
    poissons_ratio=0.3,
    density=1600.0,
    friction_angle=35.0,
)
METAL = c.Material(
    model=c.MaterialModel.VON_MISES,
    youngs_modulus=1e5,
    poissons_ratio=0.3,
    density=1000.0,
    yield_stress=3e3,
)
LIQUID = c.Material(
    model=c.MaterialModel.FLUID, bulk_modulus=5e4, density=1000.0, viscosity=20.0, tension=False
)
THROW, KICK, PULL = (1.0, 0.5, -1.0), (1.2, -0.8, 0.5), (1.0, -2.0, -9.5)


def kick_top(foot: float) -> c.ParticleImpulse:
    """A blow to the upper half of a block of seven cells that stands at ``foot`` [cells]."""
    middle, half = foot + 5.25, 1.75
    return c.ParticleImpulse(
        point=(0.75, 0.75, middle * DX), half_size=(1.0, 1.0, half * DX), delta_velocity=KICK, duration=BLOW
    )


DROPPED = Block(JELLY, substeps=14, velocity=(0.6, 0.2, -1.5))
THROWN = Block(JELLY, substeps=14)
KICKED = Block(JELLY, substeps=14, low=(8.5, 8.5, 4.0), constraints=(kick_top(4.0),))
SLID = Block(JELLY, substeps=14, low=(4.0, 8.5, 4.0), velocity=(2.0, 0.0, 0.0), floor=0.4)
HEAP = Block(SAND, substeps=14, frame_dt=0.04, cells=(6, 6, 8), low=(9.0, 9.0, 4.0), floor=0.5)
SMASHED = Block(METAL, substeps=16, velocity=(0.5, 0.0, -2.0))
SPILT = Block(LIQUID, substeps=14, frame_dt=0.03, low=(8.5, 8.5, 4.0), floor=0.0)
FLYING = Block(JELLY, substeps=14, low=(8.5, 8.5, 12.0), velocity=(0.5, 0.0, 1.0), floor=None)
LANDED = Block(METAL, substeps=16, velocity=(0.0, 0.0, -0.05), low=(8.5, 8.5, 4.1), gravity=(0.0, 0.0, -0.5))

TOSSED = Block(
    JELLY, substeps=14, low=(8.5, 8.5, 8.0), gravity=(0.0, 0.0, 0.0), floor=None, constraints=(kick_top(8.0),)
)

PROBLEMS = (
    Problem("E", DROPPED, {"youngs_modulus": 3e4}, times("youngs_modulus", 3e4, 3.0, 1 / 3)),
    Problem("nu", DROPPED, {"poissons_ratio": 0.3}, times("poissons_ratio", 0.3, 1 / 3, 1.5)),
    Problem(
        "E and nu",
        DROPPED,
        {"youngs_modulus": 3e4, "poissons_ratio": 0.3},
        {
            "3 and 0.333 times": {"youngs_modulus": 9e4, "poissons_ratio": 0.1},
            "0.333 and 1.5 times": {"youngs_modulus": 1e4, "poissons_ratio": 0.45},
        },
    ),
    Problem("initial velocity", THROWN, {"velocity": np.array(THROW)}, turned("velocity", THROW)),
    Problem("impulse", KICKED, {"impulse": np.array(KICK)}, turned("impulse", KICK)),
    Problem("gravity", DROPPED, {"gravity": np.array(PULL)}, turned("gravity", PULL)),
    Problem("density", DROPPED, {"density": 1000.0}, times("density", 1000.0, 2.0, 0.5)),
    Problem("ground friction", SLID, {"friction": 0.4}, times("friction", 0.4, 1 / 3, 3.0)),
    Problem(
        "friction angle of sand",
        HEAP,
        {"friction_angle": 35.0},
        {f"{angle:g} degrees": {"friction_angle": angle} for angle in (12.0, 50.0)},
    ),
    Problem("yield stress", SMASHED, {"yield_stress": 3e3}, times("yield_stress", 3e3, 3.0, 1 / 3)),
    Problem(
        "E, nu, friction and velocity",
        THROWN,
        {"youngs_modulus": 3e4, "poissons_ratio": 0.3, "friction": 0.3, "velocity": np.array(THROW)},
        {
            "all wrong": {
                "youngs_modulus": 9e4,
                "poissons_ratio": 0.1,
                "friction": 0.1,
                "velocity": turn(THROW, 45.0, 2.0),
            }
        },
        first=("velocity",),
    ),
    Problem("viscosity", SPILT, {"viscosity": 20.0}, times("viscosity", 20.0, 3.0, 1 / 3)),
)
"""Problems that the tracks determine."""

SMOOTH = (Problem("impulse in free flight", TOSSED, {"impulse": np.array(KICK)}, turned("impulse", KICK)),)
"""Without contact: only its loss is looked at, and what the resolution does to it."""

HIDDEN = (
    Problem(
        "E and density",
        DROPPED,
        {"youngs_modulus": 3e4, "density": 1000.0},
        {"3 and 0.5 times": {"youngs_modulus": 9e4, "density": 500.0}},
        identified=False,
    ),
    Problem("E in free flight", FLYING, {"youngs_modulus": 3e4}, times("youngs_modulus", 3e4, 3.0), False),
    Problem(
        "yield stress of what never yields",
        LANDED,
        {"yield_stress": 3e3},
        times("yield_stress", 3e3, 3.0),
        False,
    ),
)
"""Problems that they do not determine.

Only E over density moves an object that falls on a floor; one that flies freely, or lands gently, tells nothing of its
law.
"""
