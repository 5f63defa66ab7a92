"""From a damping ratio to what the simulation takes: viscosity, or drag.

A person can say how fast an object's swing dies out without knowing how large or stiff it is: zeta is the share of
critical damping of its lowest mode, whose amplitude falls as exp(-zeta w t); twice that is the loss factor. Of
Rayleigh's two dissipative terms,

    held   drag of all velocities at a rate d:  zeta = d / (2 w), whatever the mode
    free   Kelvin-Voigt viscosity eta:          zeta = eta w / (2 mu) of shear and torsion,
                                                zeta = eta w (1 + nu) / (3 mu) of bending and stretch

(d ln E / d ln mu = 2 (1 + nu) / 3 at constant K). Drag would keep what is free from flying; viscosity leaves momentum
alone, but an explicit step resolves how it spreads over a cell (`mpm.timestep`), so that it costs substeps.

The lowest mode is that of a beam. Held at an end: Rayleigh's quotient of its deflection under a uniform load across it,
w^2 = sum m u / sum m u^2 per unit of load, with the sections as they are, bending and shear (Timoshenko). Free: the
lower of the first bending mode, 4.730^2 sqrt(E I / (rho A L^4)), and the first torsional one, pi sqrt(mu / rho) / L
(Blevins 1979, Formulas for Natural Frequency and Mode Shape, chapter 8).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from physagent_jax.mpm import lame_parameters
from physagent_jax.scene.config import Material, SceneConfig
from physagent_jax.scene.materials.cost import stiffness

MOST_SLOWER = 1.5  # times as many substeps that a ratio nobody has asked for may take
_BENDING = 4.73004**2  # of a beam with free ends
_SHEAR_SHARE = 5 / 6  # of a solid section's area that bears shear
_MOST_SECTIONS = 24


@dataclasses.dataclass(frozen=True)
class Mode:
    """An object's lowest mode.

    Attributes:
        frequency: Angular, w [rad/s].
        bends: Whether it bends rather than twists or shears.
        held: Whether something holds the object.
    """

    frequency: float
    bends: bool
    held: bool


def find_lowest_mode(
    x: np.ndarray,
    volume: np.ndarray,
    held: np.ndarray,
    material: Material,
    firmness: np.ndarray | None = None,
) -> Mode:
    """The lowest mode of an object of ``material``, as that of a beam.

    Args:
        x: Rest positions [m], shape (n, 3).
        volume: [m^3], shape (n,).
        held: Particles that do not move, shape (n,).
        material: What it is made of.
        firmness: Factors of its stiffness, shape (n,); None = 1.
    """
    firmness = np.ones(len(x)) if firmness is None else firmness
    x, volume = np.asarray(x, np.float64), np.asarray(volume, np.float64)
    if held.any() and not held.all():
        centre = np.average(x[held], axis=0, weights=volume[held])
        frequency = _find_held_frequency(x[~held] - centre, volume[~held], firmness[~held], material)
        return Mode(frequency, bends=True, held=True)
    mean = 1 / np.average(1 / firmness, weights=volume)  # as of parts in a row
    bending, torsion = (math.sqrt(mean) * each for each in _find_free_frequencies(x, volume, material))
    return Mode(min(bending, torsion), bends=bending < torsion, held=bool(held.any()))


def compute_viscosity(ratio: float, material: Material, mode: Mode) -> float:
    """Kelvin-Voigt viscosity eta [Pa s] that gives ``mode`` the damping ``ratio``."""
    mu, _ = lame_parameters(material.youngs_modulus, material.poissons_ratio)
    share = 2 * (1 + material.poissons_ratio) / 3 if mode.bends else 1.0
    return 2 * ratio * float(mu) / (mode.frequency * share)


def compute_drag(ratio: float, mode: Mode) -> float:
    """Rate of drag [1/s] that gives ``mode`` the damping ``ratio``."""
    return 2 * ratio * mode.frequency


def find_slowdown(viscosity: float, material: Material, dx: float, most: float = 1.0) -> float:
    """The factor of substeps that ``viscosity`` [Pa s] needs: s - 1 / s = 4 eta / (dx sqrt(rho k)).

    So says the bound of `mpm.timestep`, with k ``most`` times the material's stiffness at rest.
    """
    half = 2 * viscosity / (dx * math.sqrt(material.density * most * stiffness(material)))
    return half + math.sqrt(half**2 + 1)


def find_scene_slowdown(
    config: SceneConfig, x: np.ndarray, volume: np.ndarray, firmness: np.ndarray | None, most: float
) -> float:
    """The factor of substeps that a scene needs for its damping ratio.

    Args:
        config: The scene.
        x: Its particles at rest [m], shape (n, 3).
        volume: [m^3], shape (n,).
        firmness: Factors of its stiffness, shape (n,); None = 1.
        most: The largest of them.
    """
    material = config.material
    if not material.damping_ratio or config.anchor.kind != "none":
        return 1.0
    mode = find_lowest_mode(x, volume, np.zeros(len(x), bool), material, firmness)
    return find_slowdown(
        compute_viscosity(material.damping_ratio, material, mode), material, config.domain.dx, most
    )


def find_affordable_ratio(
    ratio: float, material: Material, mode: Mode, dx: float, most: float = 1.0
) -> float:
    """``ratio``, or the largest below it that needs at most `MOST_SLOWER` times as many substeps; drag needs none."""
    if mode.held:
        return ratio
    room = (MOST_SLOWER - 1 / MOST_SLOWER) * dx * math.sqrt(material.density * most * stiffness(material)) / 4
    largest = ratio * room / compute_viscosity(ratio, material, mode) if ratio else 0.0
    return ratio if largest >= ratio else float(f"{largest:.2g}")


def _find_free_frequencies(x: np.ndarray, volume: np.ndarray, material: Material) -> tuple[float, float]:
    """Angular frequencies of the first bending and torsional mode [rad/s], of the bar with the same second moments."""
    spread = np.linalg.eigvalsh(np.atleast_2d(np.cov(x.T, aweights=volume, ddof=0)))
    size = np.cbrt(volume.mean())  # of the matter about a particle
    thinnest, longest = np.maximum(spread[[0, -1]], 0) + size**2 / 12
    length = math.sqrt(12 * longest)
    mu, _ = lame_parameters(material.youngs_modulus, material.poissons_ratio)
    bending = _BENDING * math.sqrt(thinnest * material.youngs_modulus / material.density) / length**2
    return bending, math.pi * math.sqrt(float(mu) / material.density) / length


def _find_held_frequency(arm: np.ndarray, volume, firmness, material: Material) -> float:
    """Angular frequency of the first mode of a beam [rad/s]; ``arm`` from the middle of what is held [m], (n, 3)."""
    mean = np.average(arm, axis=0, weights=volume)
    length = np.linalg.norm(mean)
    axis = mean / length if length > 1e-6 * np.abs(arm).max() else np.linalg.eigh(arm.T @ arm)[1][:, -1]
    along = np.abs(arm @ axis)  # what is held in the middle swings on both sides
    across = arm - np.outer(arm @ axis, axis)
    directions = np.linalg.eigh((across * volume[:, None]).T @ across)[1][:, 1:]
    return min(
        _find_cantilever_frequency(along, across @ each, volume, firmness, material) for each in directions.T
    )


def _find_cantilever_frequency(s: np.ndarray, y: np.ndarray, volume, firmness, material: Material) -> float:
    """Rayleigh's quotient of the deflection along y of a beam along s, both [m], shape (n,)."""
    size = np.cbrt(volume.mean())
    start, end = s.min() - 0.5 * size, s.max() + 0.5 * size
    count = min(_MOST_SECTIONS, max(2, round((end - start) / (2 * size))))
    h = (end - start) / count
    index = np.minimum(((s - start) / h).astype(int), count - 1)
    filled = np.bincount(index, volume, count)
    matter = np.maximum(filled, 1e-300)
    middle = np.bincount(index, volume * y, count) / matter
    inertia = firmness * ((y - middle[index]) ** 2 + size**2 / 12)
    second = np.bincount(index, volume * inertia, count) / matter
    firm = np.bincount(index, volume * firmness, count) / matter
    places, some = np.arange(count), filled > 0.0  # across a gap the beam goes on as it is beside it
    area = np.interp(places, places[some], filled[some]) / h
    radius, firm = (np.interp(places, places[some], each[some]) for each in (second, firm))

    mu, _ = lame_parameters(material.youngs_modulus, material.poissons_ratio)
    mass = material.density * filled
    shear = (
        mass[::-1].cumsum()[::-1] - 0.5 * mass
    )  # force across the middle of each section, per unit acceleration
    at_end = shear - 0.5 * mass
    moment = h * (at_end[::-1].cumsum()[::-1] + 0.125 * mass)
    curvature = moment / (material.youngs_modulus * area * radius)
    slope = h * (curvature.cumsum() - 0.5 * curvature) + shear / (_SHEAR_SHARE * float(mu) * firm * area)
    deflection = h * (slope.cumsum() - 0.5 * slope)
    return math.sqrt((mass * deflection).sum() / (mass * deflection**2).sum())
