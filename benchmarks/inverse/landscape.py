"""Slices of the loss along one number, with the gradient by our adjoint at every point."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks import harness
from benchmarks.harness import Rows
from benchmarks.inverse.experiment import EXACT
from benchmarks.inverse.measuring import prepare


@dataclasses.dataclass(frozen=True)
class Slice:
    """A line through a problem's coordinates.

    Attributes:
        name: Unique.
        problem: Whose loss.
        axis: Which coordinate; the others are the truth's.
        reach: From the truth to either end.
        kind: "smooth" or "contact".
    """

    name: str
    problem: str
    axis: int
    reach: float
    kind: str


SLICES = (
    Slice("impulse in free flight", "impulse in free flight", 0, 1.5, "smooth"),
    Slice("E of what is dropped", "E", 0, 1.2, "contact"),
    Slice("downward velocity of what is dropped", "initial velocity", 2, 1.0, "contact"),
    Slice("friction of the ground", "ground friction", 0, 2.0, "contact"),
)


def measure_slice(part: Slice, points: int) -> Rows:
    """Losses and derivatives at evenly spaced points, and how the two agree.

    ``roughness`` is what the loss is off, at the worst, by the cubic Hermite interpolation of its neighbours but one:
    of a smooth function with right derivatives it is small.
    """
    experiment = prepare(part.problem, EXACT)
    truth = experiment.problem.encode(experiment.problem.truth)
    offsets = np.linspace(-part.reach, part.reach, points)
    losses, slopes = [], []
    for offset in offsets:
        u = np.array(truth)
        u[part.axis] += offset
        losses.append(experiment.compute_loss(u))
        slopes.append(float(experiment.compute_gradient(u)[1][part.axis]))
    values, derivatives = np.array(losses), np.array(slopes)
    between = 0.5 * (values[:-2] + values[2:]) + 2 * (offsets[1] - offsets[0]) / 8 * (
        derivatives[:-2] - derivatives[2:]
    )
    roughness = float(np.abs(values[1:-1] - between).max() / values.max())
    uphill = derivatives * offsets >= 0
    row = {
        "slice": part.name,
        "kind": part.kind,
        "label": experiment.problem.labels[part.axis],
        "u": (truth[part.axis] + offsets).tolist(),
        "offsets": offsets.tolist(),
        "losses": losses,
        "slopes": slopes,
        "roughness": roughness,
        "towards_truth": float(np.mean(uphill)),
    }
    harness.say(
        f"{part.name}: roughness {roughness:.2g}, downhill is towards the truth at {np.mean(uphill):.0%}"
    )
    return [row]
