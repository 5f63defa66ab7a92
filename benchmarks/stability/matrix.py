"""Scenarios of the stress matrix."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial

from benchmarks.stability.comparisons import comparisons
from benchmarks.stability.criteria import Result, examine
from benchmarks.stability.degenerate import Edge, edges
from benchmarks.stability.materials import MATERIALS
from benchmarks.stability.pairwise import covering_array
from benchmarks.stability.scenario import LUMPED, Scenario, StepRule
from physagent_jax.mpm import Lumped, Sharpened
from physagent_jax.mpm.timestep import SAFETY

FORCES = ("drop", "translation", "scale", "impulse", "torque")
MAGNITUDES = (0.1, 1.0, 10.0, 100.0)
MODULI = (1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9)  # [Pa]

# (rule, forced): below the bound, above it (to be refused), above it by force, and one step for everything.
STEPS: tuple[tuple[StepRule, bool], ...] = (
    (("auto", SAFETY), False),
    (("bound", 0.25), False),
    (("bound", 0.5), False),
    (("bound", 0.8), False),
    (("bound", 0.95), False),
    (("bound", 1.1), False),
    (("bound", 2.0), False),
    (("bound", 1.1), True),
    (("bound", 2.0), True),
    (("fixed", 2e-4), False),
)
_KEYS = {  # what makes another executable
    "material": MATERIALS,
    "cells": (32, 64, 100),
    "per_cell": (1, 8, 0),
    "dtype": ("float32", "float64"),
    "stress_form": ("mls", "gradient"),
}
_AXES = {
    **_KEYS,
    "force": FORCES,
    "youngs_modulus": (1e3, 1e4, 1e5, 1e6, 1e7),
    "poissons_ratio": (0.0, 0.3, 0.45),
    "step": STEPS,
    "wall": ("far", "resting", "corner"),
    "magnitude": (1.0, 10.0),
}


def matrix() -> list[Scenario]:
    """Every material, force and magnitude, with the automatic step."""
    return [Scenario(m, f, magnitude) for m in MATERIALS for f in FORCES for magnitude in MAGNITUDES]


def pairwise(seed: int = 0) -> list[Scenario]:
    """A covering array over all other axes: all pairs of values occur. Some need x64."""
    keys = [tuple(row.values()) for row in covering_array(_KEYS, seed)]
    rows = covering_array(_AXES, seed, keys)
    rows.sort(
        key=lambda row: [_KEYS[name].index(row[name]) for name in _KEYS]
    )  # one executable after the other
    scenarios = []
    for row in rows:
        rule, forced = row.pop("step")
        scenarios.append(Scenario(**row, step=rule, forced=forced, most_steps=600))
    return scenarios


def stiffness() -> list[Scenario]:
    """Every material from 1 kPa to 1 GPa, thrown into a corner, with the automatic step."""
    return [Scenario(m, youngs_modulus=E, wall="corner") for m in MATERIALS for E in MODULI]


def degenerate(inertia: Lumped | Sharpened = LUMPED) -> list[tuple[str, Callable[[], Result]]]:
    """Inputs at the edge of sense, and the criteria that compare runs, by name."""
    return [
        *((f"{edge.name}: {edge.scenario.material}", partial(_judge, edge, inertia)) for edge in edges()),
        *comparisons(inertia),
    ]


def _judge(edge: Edge, inertia: Lumped | Sharpened) -> Result:
    """FAIL too where the input was expected to be refused and was not, or the other way round."""
    edge = dataclasses.replace(edge, scenario=dataclasses.replace(edge.scenario, inertia=inertia))
    result = examine(edge.scenario, edge.name, edge.build)
    if edge.expected != "either" and result.verdict != edge.expected and not result.failed:
        result.fail("input", f"{result.verdict}, expected {edge.expected}: {result.message}")
    return result
