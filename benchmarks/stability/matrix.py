"""Which scenarios are run: whole axes against each other where it matters most, pairs of values elsewhere."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.stability.criteria import Result
from benchmarks.stability.degenerate import INPUTS
from benchmarks.stability.materials import MATERIALS
from benchmarks.stability.scenario import Scenario

FORCES = ("drop", "translation", "scale", "impulse", "torque")
MAGNITUDES = (0.1, 1.0, 10.0, 100.0)
STIFFNESSES = tuple(10.0**k for k in range(3, 10))
AXES: dict[str, tuple] = {
    "material": MATERIALS,
    "step": (
        ("auto", 0.7), ("bound", 0.25), ("bound", 0.5), ("bound", 0.95), ("bound", 1.1), ("bound", 2.0), ("fixed", 2e-4),
    ),
    "youngs_modulus": (1e3, 1e5, 1e7),
    "per_cell": (1, 8, 0),
    "wall": ("far", "resting", "corner"),
    "force": ("drop", "translation", "impulse"),
    "cells": (32, 64),
    "dtype": ("float32", "float64"),
    "stress_form": ("mls", "gradient"),
}  # fmt: skip


def matrix() -> list[Scenario]:
    """Every material x force x magnitude."""
    return [
        Scenario(material, force, magnitude)  # type: ignore[arg-type]
        for material in MATERIALS
        for force in FORCES
        for magnitude in MAGNITUDES
    ]


def stiffness() -> list[Scenario]:
    """Every material from very soft to very stiff, dropped into a corner."""
    return [
        Scenario(material, youngs_modulus=E, wall="corner") for material in MATERIALS for E in STIFFNESSES
    ]


def pairwise() -> list[Scenario]:
    """Every pair of values of `AXES`; steps above the bound are forced in every other run, and refused otherwise."""
    scenarios = []
    for index, row in enumerate(covering(AXES)):
        scenario = Scenario(**row)
        scenarios.append(dataclasses.replace(scenario, forced=scenario.refusable and index % 2 == 0))
    return scenarios


def degenerate() -> list[tuple[str, Callable[[], Result]]]:
    """Inputs that should not be, and runs that must agree."""
    return list(INPUTS.items())


def covering(axes: dict[str, Sequence], seed: int = 0) -> list[dict]:
    """Rows in which every pair of values of two axes occurs: greedy, best of some random candidates per row."""
    rng = np.random.default_rng(seed)
    names = list(axes)
    missing = {
        (a, i, b, j)
        for a, b in itertools.combinations(names, 2)
        for i in range(len(axes[a]))
        for j in range(len(axes[b]))
    }
    rows = []
    while missing:
        rows.append(
            max((_candidate(axes, missing, rng) for _ in range(30)), key=lambda row: _news(row, missing))
        )
        missing -= set(_pairs(rows[-1]))
    return [{name: axes[name][i] for name, i in row.items()} for row in rows]


def _candidate(axes: dict[str, Sequence], missing: set, rng: np.random.Generator) -> dict[str, int]:
    """A row around one missing pair, its other values at random."""
    a, i, b, j = sorted(missing)[rng.integers(len(missing))]
    row = {name: int(rng.integers(len(values))) for name, values in axes.items()}
    return row | {a: i, b: j}


def _pairs(row: dict[str, int]):
    return ((a, row[a], b, row[b]) for a, b in itertools.combinations(row, 2))


def _news(row: dict[str, int], missing: set) -> int:
    return sum(pair in missing for pair in _pairs(row))
