"""Force fields that could act in place of the one that does: which way a clip would go with them, to first order.

A straight-through choice (Bengio et al. 2013) simulates what is chosen and differentiates the mixture of all. The
acceleration of that mixture is a_0 of the chosen force field and, by weights w, what each other one would change of it,

    a = a_0 + sum_k w_k (a_k - a_0)   at w = 0.

So each force field is compiled as a whole. A strength that goes to zero in its place will not do: over the ground
friction is overcome by a jump, a blow grows with the square root of its strength, and what an action is given goes by
those beside it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.schema import ForceField
from physagent_jax.mpm.protocols import BodyForce
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.compile.forces import compile_skills


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Alternatives:
    """A body force: what others would change, by weights of 0.

    Derivatives are right at those weights alone: the ones by positions and velocities, which they make zero, are left
    out.

    Attributes:
        weights: w, shape (alternatives,).
        terms: The terms of each alternative that would act.
        instead: What acts.
    """

    weights: jax.Array
    terms: tuple[tuple[BodyForce, ...], ...]
    instead: tuple[BodyForce, ...]

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        return self._mix(jnp.zeros_like(x), lambda term: term.acceleration(x, v, mass, time, dt))

    def gradient(self, x, time, dt):
        """d acceleration / d x [1/s^2], shape (n, 3, 3)."""
        return self._mix(jnp.zeros((*x.shape, 3), x.dtype), lambda term: term.gradient(x, time, dt))

    def _mix(self, none: jax.Array, evaluate: Callable[[BodyForce], jax.Array | None]) -> jax.Array:
        def add(terms):
            values = [value for term in terms if (value := evaluate(term)) is not None]
            return sum(values, none)

        own = add(self.instead)
        changes = jnp.stack([add(terms) - own for terms in self.terms])
        return jnp.tensordot(self.weights, jax.lax.stop_gradient(changes), 1)


def compile_alternatives(scene: CompiledScene, others: Sequence[ForceField]) -> Alternatives:
    """Compile the changes that ``others``, at least one, would make to the scene's own force field.

    Args:
        scene: With its own force field.
        others: With the same constraints and the same fall: only actions may differ.

    Raises:
        UserError: A region selects nothing, or a window lies outside the clip.
    """
    rest, volume = np.asarray(scene.state.x), np.asarray(scene.model.volume)

    def compile_terms(other: ForceField) -> tuple[BodyForce, ...]:
        config = scene.config.model_copy(update=dict(force_field=other))
        return compile_skills(config, scene.body, rest, volume)[0]

    return Alternatives(
        weights=jnp.zeros(len(others), scene.state.x.dtype),
        terms=tuple(map(compile_terms, others)),
        instead=scene.origins.split_forces(scene.model)[0],
    )
