"""Parts of one's own say in their fields' metadata what they are; names and lengths say nothing."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import PrescribedMotion
from physagent_jax.mpm.fields import END, PER_PARTICLE, START, find_owner
from physagent_jax.mpm.plan import find_acting
from physagent_jax.mpm.sharding import ParticleLayout
from tests.mpm.blocks import block


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Push:
    """A push of its own strength on each particle, from ``first`` to ``last``."""

    strength: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    first: float = dataclasses.field(metadata=START)
    last: float = dataclasses.field(metadata=END)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Tide:
    """Something whose ``start`` and ``end`` are heights, not times."""

    start: float
    end: float


def test_windows_are_what_is_marked():
    model, state = block()
    model = model.replace(forces=(Push(state.x[:, 0], 0.1, 0.2), Tide(0.1, 0.2)))
    assert len(find_acting(model, 0.15, 0.16).forces) == 2
    assert [type(force) for force in find_acting(model, 0.3, 0.4).select(model).forces] == [Tide]


def test_what_is_marked_goes_with_its_particles():
    model, state = block((2, 2, 1))
    split, _ = ParticleLayout((32,), devices=2).split(
        model.replace(forces=(Push(state.x[:, 0], 0.1, 0.2),)), state
    )
    np.testing.assert_array_equal(split.forces[0].strength, state.x[:, 0])


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mass", "particle"),
        ("materials", "block"),
        ("forces", "particle"),
        ("constraints", "held"),
        ("dt", None),
    ],
)
def test_the_mark_of_a_leaf_is_that_of_the_outermost_field(name, expected):
    model, state = block()
    grip = PrescribedMotion.fixed(jnp.arange(3))
    model = model.replace(forces=(Push(state.x[:, 0], 0.1, 0.2),), constraints=(grip,))
    paths = [path for path, _ in jax.tree_util.tree_leaves_with_path(model) if path[0].name == name]
    assert find_owner(model, paths[0]) == expected
