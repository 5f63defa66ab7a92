"""`PeerScene`: particles, one material, a cubic domain and planes, in plain numpy."""

from __future__ import annotations

import dataclasses
import enum
import json
from pathlib import Path
from typing import Any, Literal

import numpy as np


class Material(enum.StrEnum):
    """Constitutive laws; tau is the Kirchhoff stress, F the elastic deformation gradient.

    JELLY: fixed corotated, tau = 2 mu (F - R) F^T + lam J (J - 1) I.
    NEO_HOOKEAN: tau = mu (F F^T - I) + lam ln J I.
    METAL: Hencky with von Mises return, ||dev tau||_F <= yield_stress, no hardening.
    SAND: Hencky with Drucker-Prager return (Klar et al. 2016), no cohesion, no volume correction.
    FLUID: tau = -J p I with p = K (J^-7 - 1) / 7; tension is allowed.
    """

    JELLY = "jelly"
    NEO_HOOKEAN = "neo_hookean"
    METAL = "metal"
    SAND = "sand"
    FLUID = "fluid"


class Contact(enum.StrEnum):
    """Effect of a plane on grid velocities behind it.

    STICKY: they vanish. SLIP: their normal part vanishes. SEPARATE: their normal part vanishes if it points
    into the solid, and the tangential part then loses up to friction times what was removed (Coulomb).
    """

    STICKY = "sticky"
    SLIP = "slip"
    SEPARATE = "separate"


@dataclasses.dataclass(frozen=True)
class Plane:
    """The solid half-space behind a plane.

    Attributes:
        point: A point of the plane [m].
        normal: Out of the solid; any length but zero.
        contact: Kind of contact.
        friction: Coulomb coefficient, used by SEPARATE.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    contact: Contact = Contact.SEPARATE
    friction: float = 0.0

    def unit_normal(self) -> np.ndarray:
        """The normal with length 1, shape (3,)."""
        normal = np.asarray(self.normal, float)
        return normal / np.linalg.norm(normal)


@dataclasses.dataclass(frozen=True)
class PeerScene:
    """Everything a peer needs to know, except the substep.

    The domain is [0, size]^3 with nodes 0..cells along each side. Build one with `PeerScene.of`, which
    spreads scalars over the particles.

    Attributes:
        x: Positions [m], shape (n, 3).
        v: Velocities [m/s], shape (n, 3).
        C: Affine velocity matrices [1/s], shape (n, 3, 3).
        volume: Rest volume of each particle [m^3], shape (n,).
        density: Mass per rest volume [kg/m^3], shape (n,).
        youngs_modulus: E [Pa], shape (n,); not used by FLUID.
        poissons_ratio: nu, shape (n,); not used by FLUID.
        yield_stress: Bound on the Frobenius norm ||dev tau|| [Pa], shape (n,), METAL only. It is
            sqrt(2/3) times the uniaxial yield stress.
        bulk_modulus: K [Pa], shape (n,), FLUID only.
        friction_angle_degrees: SAND only.
        material: One law for all particles.
        size: Side of the domain [m].
        cells: Cells along a side.
        gravity: [m/s^2].
        planes: Applied in order.
        domain_box: Frictionless separating walls on the nodes with an index below this and above
            ``cells`` minus this; None = no walls.
        transfer: "apic" or "pic" (C is discarded).
        rpic_damping: 0 = APIC, 1 = only the rotational part of C.
    """

    x: np.ndarray
    v: np.ndarray
    C: np.ndarray
    volume: np.ndarray
    density: np.ndarray
    youngs_modulus: np.ndarray
    poissons_ratio: np.ndarray
    yield_stress: np.ndarray
    bulk_modulus: np.ndarray
    friction_angle_degrees: float
    material: Material
    size: float
    cells: int
    gravity: tuple[float, float, float]
    planes: tuple[Plane, ...]
    domain_box: int | None
    transfer: Literal["apic", "pic"]
    rpic_damping: float

    @staticmethod
    def of(
        x: np.ndarray,
        *,
        size: float,
        cells: int,
        material: Material,
        volume: Any,
        density: Any,
        v: Any = 0.0,
        C: Any = 0.0,
        youngs_modulus: Any = 0.0,
        poissons_ratio: Any = 0.0,
        yield_stress: Any = 0.0,
        bulk_modulus: Any = 0.0,
        friction_angle_degrees: float = 0.0,
        gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        planes: tuple[Plane, ...] = (),
        domain_box: int | None = 3,
        transfer: Literal["apic", "pic"] = "apic",
        rpic_damping: float = 0.0,
    ) -> PeerScene:
        """A scene whose per-particle arguments may also be one value for all.

        Raises:
            ValueError: A shape does not fit, or the material lacks a parameter.
        """
        x = np.asarray(x)
        count = len(x)

        def spread(values: Any, *shape: int) -> np.ndarray:
            return np.array(np.broadcast_to(np.asarray(values, x.dtype), (count, *shape)))

        scene = PeerScene(
            x=x,
            v=spread(v, 3),
            C=spread(C, 3, 3),
            volume=spread(volume),
            density=spread(density),
            youngs_modulus=spread(youngs_modulus),
            poissons_ratio=spread(poissons_ratio),
            yield_stress=spread(yield_stress),
            bulk_modulus=spread(bulk_modulus),
            friction_angle_degrees=friction_angle_degrees,
            material=Material(material),
            size=float(size),
            cells=int(cells),
            gravity=tuple(float(g) for g in gravity),  # type: ignore[arg-type]
            planes=tuple(planes),
            domain_box=domain_box,
            transfer=transfer,
            rpic_damping=float(rpic_damping),
        )
        _check(scene)
        return scene

    @property
    def particle_count(self) -> int:
        """Number of particles."""
        return len(self.x)

    @property
    def dx(self) -> float:
        """Grid spacing [m]."""
        return self.size / self.cells

    @property
    def mass(self) -> np.ndarray:
        """Particle mass [kg], shape (n,)."""
        return self.volume * self.density

    @property
    def lame(self) -> tuple[np.ndarray, np.ndarray]:
        """Lame parameters (mu, lam) [Pa], shapes (n,)."""
        E, nu = self.youngs_modulus, self.poissons_ratio
        return E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))

    def take(self, order: np.ndarray) -> PeerScene:
        """The same particles in another order, shape (n,)."""
        arrays = {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return dataclasses.replace(self, **{name: value[order] for name, value in arrays.items()})

    def save(self, path: Path) -> None:
        """Write the scene to an npz file."""
        arrays, rest = {}, {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                arrays[field.name] = value
            elif field.name == "planes":
                rest["planes"] = [dataclasses.asdict(plane) for plane in value]
            else:
                rest[field.name] = value
        np.savez(path, rest=np.array(json.dumps(rest)), **arrays)

    @staticmethod
    def load(path: Path) -> PeerScene:
        """Read what `save` wrote."""
        with np.load(path) as stored:
            arrays = {name: stored[name] for name in stored.files if name != "rest"}
            rest = json.loads(str(stored["rest"]))
        planes = tuple(
            Plane(tuple(p["point"]), tuple(p["normal"]), Contact(p["contact"]), p["friction"])
            for p in rest.pop("planes")
        )
        rest |= dict(gravity=tuple(rest["gravity"]), material=Material(rest["material"]))
        return PeerScene(planes=planes, **arrays, **rest)


_NEEDED = {
    Material.JELLY: ("youngs_modulus",),
    Material.NEO_HOOKEAN: ("youngs_modulus",),
    Material.METAL: ("youngs_modulus", "yield_stress"),
    Material.SAND: ("youngs_modulus", "friction_angle_degrees"),
    Material.FLUID: ("bulk_modulus",),
}


def _check(scene: PeerScene) -> None:
    if scene.x.shape != (scene.particle_count, 3) or scene.particle_count == 0:
        raise ValueError(f"x must have shape (n, 3) with n > 0 (got {scene.x.shape}).")
    for name in ("volume", "density", *_NEEDED[scene.material]):
        if not np.all(np.asarray(getattr(scene, name)) > 0):
            raise ValueError(f"{name} must be positive for {scene.material.value}.")
    if scene.transfer not in ("apic", "pic"):
        raise ValueError(f"transfer must be 'apic' or 'pic' (got {scene.transfer!r}).")
    if not 0 <= scene.rpic_damping <= 1:
        raise ValueError(f"rpic_damping must lie in [0, 1] (got {scene.rpic_damping}).")
    if any(not np.any(plane.normal) for plane in scene.planes):
        raise ValueError("a plane's normal must not be zero.")
