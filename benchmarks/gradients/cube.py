"""The cube that is differentiated: of any law, dropped on a floor, eight particles in a cell."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax.numpy as jnp

from benchmarks.peers.drop import SIDE, SIZE, drop
from benchmarks.peers.ours import build
from benchmarks.peers.scene import Material, PeerScene
from physagent_jax.mpm import Model, State, cell_order

NEO_HOOKEAN = "neo-Hookean"
MATERIALS = {  # law, viscosity [Pa s]; E = 1e5 Pa, a fluid's K likewise
    "fixed corotated": (Material.JELLY, 0.0),
    "von Mises": (Material.METAL, 0.0),
    "Drucker-Prager": (Material.SAND, 0.0),
    "fluid": (Material.FLUID, 0.0),
    "viscous fluid": (Material.FLUID, 20.0),
    "Kelvin-Voigt": (Material.NEO_HOOKEAN, 20.0),
}


def make_scene(particles: int, material: Material = Material.NEO_HOOKEAN) -> PeerScene:
    """The cube above the floor, eight particles in a cell."""
    cells = round(SIZE / (SIDE * (8 / particles) ** (1 / 3)))
    scene = drop(particles, Material.NEO_HOOKEAN, cells)
    return dataclasses.replace(scene, material=material, bulk_modulus=scene.youngs_modulus)


def make_cube(
    particles: int, precision: Any, kernels: str = "auto", material: str = NEO_HOOKEAN
) -> tuple[Model, State]:
    """The cube above the floor, its particles sorted, eight in a cell."""
    law, viscosity = MATERIALS.get(material, (Material.NEO_HOOKEAN, 0.0))
    scene = make_scene(particles, law)
    scene = scene.take(cell_order(scene.x, scene.dx))
    scene = dataclasses.replace(scene, x=scene.x.astype(precision), v=scene.v.astype(precision))
    model, state = build(scene, kernels)
    if viscosity:
        model = model.replace(viscosity=jnp.full(particles, viscosity, precision))
    return model, state
