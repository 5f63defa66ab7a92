"""The scene that codes are timed on: an elastic cube dropped on a sticky floor, as customary for 3D Gaussians."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks.peers.scene import Contact, Material, PeerScene, Plane

SIZE = 2.0  # side of the domain [m]
SIDE = 0.6  # of the cube [m]
FLOOR = 0.2  # height of the floor [m]
GAP = 0.004  # between cube and floor at the start [m]
SPEED = 1.0  # downwards at the start [m/s]
GRAVITY = 9.8  # [m/s^2]
CELLS = 100  # along a side of the domain
DT = 2e-4  # [s]
FRAME_DT = 0.04  # [s]
FRAMES = 50
DENSITY = 1000.0  # [kg/m^3]
YOUNGS_MODULUS = 1e5  # [Pa]
POISSONS_RATIO = 0.3
YIELD_STRESS = 2e3  # bound on |dev tau| of METAL [Pa]; the impact strains the cube well beyond it
FRICTION_ANGLE = 30.0  # of SAND [degrees]
WALLS = 3  # cells


def drop(particles: int, material: Material, cells: int = CELLS) -> PeerScene:
    """The cube of uniformly random particles in random order; the same ones whenever they are as many."""
    rng = np.random.default_rng(0)
    low = np.array([0.5 * (SIZE - SIDE), 0.5 * (SIZE - SIDE), FLOOR + GAP])
    return PeerScene.of(
        (low + SIDE * rng.uniform(size=(particles, 3))).astype(np.float32),
        v=np.array([0.0, 0.0, -SPEED]),
        size=SIZE,
        cells=cells,
        material=material,
        volume=SIDE**3 / particles,
        density=DENSITY,
        youngs_modulus=YOUNGS_MODULUS,
        poissons_ratio=POISSONS_RATIO,
        yield_stress=YIELD_STRESS,
        friction_angle_degrees=FRICTION_ANGLE,
        gravity=(0.0, 0.0, -GRAVITY),
        planes=(Plane((0.0, 0.0, FLOOR), (0.0, 0.0, 1.0), Contact.STICKY),),
        domain_box=WALLS,
    )


def floor_as_wall(scene: PeerScene) -> PeerScene:
    """The scene for a peer without planes: the domain's frictionless wall reaches up to the floor."""
    return dataclasses.replace(scene, planes=(), domain_box=round(FLOOR / scene.dx))
