"""For the record: does score distillation point towards the target? No method may use this."""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.parametrisation import Parametrisation
from baselines.scores.protocol import ScorePrior
from baselines.simulation import Simulation
from baselines.tasks import Task
from baselines.truncation import WHOLE, Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Distillation gradients beside the true one, both by |M| v of every action.

    Attributes:
        prior: Whose gradients.
        toy: Whether that is the toy prior.
        draws: How many gradients, each of the prior's own number of draws.
        cosine: Cosine of the mean gradient with the true one; 1 points to the target as well as descent on the
            truth does.
        cosines: Cosines of each gradient, shape (draws,).
        share_downhill: Share downhill of the gradients against which a step lessens the true loss: cosine above 0.
        mean: Mean gradient, shape (p,).
        variance: Variance of each component over the draws, shape (p,).
        signal_to_noise: |mean|^2 over the sum of the variances: 1 over it is about how many gradients a mean takes.
        true_gradient: Shape (p,).
    """

    prior: str
    toy: bool
    draws: int
    cosine: float
    cosines: np.ndarray
    share_downhill: float
    mean: np.ndarray
    variance: np.ndarray
    signal_to_noise: float
    true_gradient: np.ndarray


def compare_with_truth(
    task: Task,
    force_field: ForceField,
    prior: ScorePrior,
    *,
    draws: int = 64,
    seed: int = 0,
    truncation: Truncation = WHOLE,
) -> Comparison:
    """Draw gradients of score distillation and compare them with that of the task's own loss.

    Nothing is charged, for nothing of it is shown to a method.

    Args:
        task: Whose target is the truth.
        force_field: Where.
        prior: Who looks.
        draws: Gradients.
        seed: Seed of their noise.
        truncation: How far they go back; the true one goes all the way.

    Raises:
        UserError: A gradient vanishes, so that it has no direction, or the force field cannot be simulated.
    """
    simulation = Simulation(task)
    pictures, rollout = simulation.play(force_field)
    unknowns = Parametrisation(force_field, task.frame_count)
    parameters = ForceFieldParameters.of(force_field, task.frame_count)
    _, slope = simulation.differentiate(rollout, parameters)
    true = unknowns.pull_back(force_field, slope)
    video = pictures.rgb.astype(np.float32) / 255
    made = []
    for index in range(draws):
        pixels = prior.gradient(video, task.spec.sentence, seed * 100_003 + index)
        pulled, _ = simulation.pull_back(rollout, parameters, pixels, truncation)
        made.append(unknowns.pull_back(force_field, pulled))
    return summarise(prior, np.array(made), true)


def summarise(prior: ScorePrior, gradients: np.ndarray, true: np.ndarray) -> Comparison:
    """The comparison of gradients, shape (draws, p), with the true one, shape (p,)."""
    mean, variance = gradients.mean(0), gradients.var(0, ddof=1)
    cosines = np.array([find_cosine(each, true) for each in gradients])
    return Comparison(
        prior=prior.name,
        toy=prior.toy,
        draws=len(gradients),
        cosine=find_cosine(mean, true),
        cosines=cosines,
        share_downhill=float((cosines > 0).mean()),
        mean=mean,
        variance=variance,
        signal_to_noise=float(mean @ mean / variance.sum()) if variance.sum() > 0 else float("inf"),
        true_gradient=true,
    )


def find_cosine(a: np.ndarray, b: np.ndarray) -> float:
    """Of the angle between two vectors.

    Raises:
        UserError: One of them is zero or not finite.
    """
    scale = np.linalg.norm(a) * np.linalg.norm(b)
    if not (np.isfinite(scale) and scale > 0):
        raise UserError("a gradient that vanishes or is not finite has no direction", got=f"{a} and {b}")
    return float(a @ b / scale)
