"""The oracle gradient baseline: Adam on the force parameters, through the simulator itself.

It minimises the distance to the true target path, which no method that looks at pictures or text knows:
the upper bound of what gradients can do on these tasks. Adam: Kingma & Ba 2015, from optax.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable

import jax
import jax.numpy as jnp
import optax

from baselines.path_tasks import Parameters, Task
from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class Step:
    """One iteration.

    Attributes:
        iteration: From 0.
        loss: Before the update, in squared body lengths.
        gradient_norm: Of the loss with respect to the parameters.
        magnitude: Of the action.
        vector: Its direction.
        seconds: Wall time of the iteration [s]; the first one compiles.
    """

    iteration: int
    loss: float
    gradient_norm: float
    magnitude: float
    vector: tuple[float, float, float]
    seconds: float


def optimise(
    task: Task,
    *,
    iterations: int = 40,
    learning_rate: float = 0.1,
    tolerance: float = 1e-6,
    on_step: Callable[[Step], None] = lambda step: None,
) -> tuple[Parameters, list[Step]]:
    """Projected Adam from the task's start until ``iterations`` or a loss below ``tolerance``.

    Args:
        task: What to solve.
        iterations: At most this many gradients.
        learning_rate: Of Adam; decays to a tenth by a cosine.
        tolerance: Loss at which to stop [body lengths^2].
        on_step: Called after every iteration.

    Returns:
        The best parameters seen, and all steps.

    Raises:
        UserError: A loss or gradient is not finite.
    """
    parameters = Parameters.of(task.spec.start_vector, task.spec.start_magnitude)
    optimiser = optax.adam(optax.cosine_decay_schedule(learning_rate, iterations, alpha=0.1))
    moments = optimiser.init(parameters.push)
    gradient = jax.jit(jax.value_and_grad(task.loss))
    best, history = (float("inf"), parameters), []
    for iteration in range(iterations):
        begun = time.perf_counter()
        loss, slope = jax.block_until_ready(gradient(parameters))
        if not math.isfinite(float(loss)) or not math.isfinite(float(optax.tree.norm(slope))):
            raise UserError(
                f"the gradient is not finite at iteration {iteration} (loss {float(loss):.3g})",
                do="Lower --learning-rate",
            )
        x, y, z = parameters.direction
        step = Step(
            iteration,
            float(loss),
            float(optax.tree.norm(slope)),
            float(parameters.magnitude),
            (float(x), float(y), float(z)),
            time.perf_counter() - begun,
        )
        history.append(step)
        on_step(step)
        best = min(best, (step.loss, parameters), key=lambda pair: pair[0])
        if step.loss < tolerance:
            break
        updates, moments = optimiser.update(slope.push, moments)
        parameters = Parameters(jnp.asarray(optax.apply_updates(parameters.push, updates))).projected()
    return best[1], history
