"""Which scenarios are run: whole axes against each other where it matters most, pairs of values elsewhere."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable

from benchmarks.stability.agreement import agreements
from benchmarks.stability.criteria import Result, watch
from benchmarks.stability.degenerate import Edge, edges
from benchmarks.stability.materials import MATERIALS
from benchmarks.stability.pairwise import covering_array
from benchmarks.stability.scenario import Scenario
from physagent_jax.errors import UserError

FORCES = ("drop", "translation", "scale", "impulse", "torque")
MAGNITUDES = (0.1, 1.0, 10.0, 100.0)
STIFFNESSES = tuple(10.0**k for k in range(3, 10))
AXES: dict[str, tuple] = {
    "material": MATERIALS,
    "step": (("auto", 0.7), ("bound", 0.5), ("bound", 0.95), ("bound", 1.1), ("bound", 2.0), ("fixed", 2e-4)),
    "youngs_modulus": (1e3, 1e5, 1e7),
    "per_cell": (1, 8, 0),
    "wall": ("far", "resting", "corner"),
    "force": ("drop", "translation", "impulse"),
    "cells": (32, 64),
    "dtype": ("float32", "float64"),
    "stress_form": ("mls", "gradient"),
}


def matrix() -> list[Scenario]:
    """Every material x force x magnitude."""
    return [
        Scenario(material, force, magnitude)  # type: ignore[arg-type]
        for material in MATERIALS
        for force in FORCES
        for magnitude in MAGNITUDES
    ]


def stiffness() -> list[Scenario]:
    """Every material from very soft to very stiff, thrown into a corner."""
    return [
        Scenario(material, youngs_modulus=E, wall="corner") for material in MATERIALS for E in STIFFNESSES
    ]


def pairwise() -> list[Scenario]:
    """Every pair of values of `AXES`; of the steps above the bound, every other is forced."""
    scenarios = []
    for index, row in enumerate(covering_array(AXES)):
        scenario = Scenario(**row)
        scenarios.append(dataclasses.replace(scenario, forced=scenario.refusable and index % 2 == 0))
    return scenarios


def degenerate() -> list[Callable[[], Result]]:
    """Inputs that should not be, and runs that must agree."""
    runs = [lambda edge=edge: _at_the_edge(edge) for edge in edges()]
    return runs + [
        lambda name=name, run=run: dataclasses.replace(run(), name=name) for name, run in agreements()
    ]


def _at_the_edge(edge: Edge) -> Result:
    """Judged as any run; what has to be refused fails if it is not."""
    begun = time.perf_counter()
    result = Result(f"{edge.name}, {edge.scenario.material}")
    try:
        run = edge.build()
        watch(edge.scenario, run, run.frames(), result)
        if edge.expected == "refused":
            result.fail("P8", "was accepted without a word")
    except UserError as error:
        result.verdict, result.message = "refused", str(error)
    result.figures["seconds"] = round(time.perf_counter() - begun, 3)
    return result
