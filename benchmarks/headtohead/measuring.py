"""Rows of the head-to-head: fits with their memory, and what a gradient costs."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from baselines.measuring import measure_fit
from baselines.simulation import Simulation
from baselines.tasks import Task
from benchmarks import harness
from benchmarks.harness import Row
from benchmarks.headtohead.entrants import Entrant
from benchmarks.peers.gradient import read_memory, reset_peak
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField

_FOLDERS = (
    "weights",
    "clip",
    "model",
    "record",
)  # options that say where a model lies on this machine: rows do not


def measure(entrant: Entrant, task: Task, marks: Sequence[float], seed: int, budget: float) -> list[Row]:
    """`measure_fit` of an entrant, with the memory that it took."""
    memory, begun = reset_peak(), time.perf_counter()
    options = {name: value for name, value in entrant.options.items() if name not in _FOLDERS}
    names = {"label": entrant.label, "method": entrant.method, "options": options}
    row = measure_fit(entrant.make(), task, marks, seed, budget, names)
    if not row["marks"]:
        return [row]
    peak = read_memory("VmHWM")
    row["memory_gb"] = None if peak is None or memory is None else (peak - memory) / 1e9
    last = row["marks"][-1]
    harness.say(
        f"{task.spec.name:32s} {entrant.label:36s} seed {seed} error {last['error']:8.3g} "
        f"{'success' if last['success'] else ''} {time.perf_counter() - begun:.1f} s"
    )
    return [row]


def measure_gradient(task: Task, witness: ForceField, repeats: int) -> list[Row]:
    """Seconds of a simulation with its residuals, and of a value with its gradient along it, warm and in turn."""
    simulation = Simulation(task)
    parameters = ForceFieldParameters.of(witness, task.frame_count)

    def measure_pair() -> tuple[float, float]:
        begun = time.perf_counter()
        rollout = simulation.simulate(witness)
        simulation.compute_residuals(rollout)
        simulated = time.perf_counter()
        simulation.differentiate(rollout, parameters)
        return simulated - begun, time.perf_counter() - simulated

    measure_pair()  # compiles
    pairs = [measure_pair() for _ in range(repeats)]
    ratios = sorted(gradient / plain for plain, gradient in pairs)
    plain, gradient = np.median(pairs, axis=0).tolist()
    row = {
        "task": task.spec.name,
        "family": task.spec.family,
        "split": task.spec.split,
        "plain_seconds": plain,
        "gradient_seconds": gradient,
        "ratio": float(np.median(ratios)),
        "ratio_range": [ratios[0], ratios[-1]],
    }
    harness.say(f"{task.spec.name:32s} {plain:.3f} s, with its gradient {gradient:.3f} s: {row['ratio']:.2f}")
    return [row]
