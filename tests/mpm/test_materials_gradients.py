"""Derivatives of return mapping and stress, with respect to F and every parameter, against central differences."""

import dataclasses
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.mpm.single_points import (
    COUNT,
    DT,
    MU,
    PARAMETERS,
    E,
    diagonal,
    energy,
    histories,
    material,
    project,
    random_F,
    stress,
)

ALL = list(PARAMETERS)
# At F = I these have a corner, at the tip of their cone or at the end of tension.
CORNER_AT_REST = ("sand", "slurry", "fluid")
# A slurry's friction and cohesion sit at the corner where the cone appears.
CORNER_PARAMETERS = {"slurry": ("friction_angle", "cohesion")}

# What only says where matter breaks: a jump, with no derivative to either side of it.
THRESHOLDS = {"glass": ("cohesion",)}


def states(seed=5):
    """Elastic and plastic ones, F = I, and repeated stretches."""
    F = random_F(0.3, seed).at[: COUNT // 3].set(np.eye(3) + 1e-3 * random_F(1.0, seed + 1)[: COUNT // 3])
    return F.at[0].set(0.9 * jnp.eye(3)).at[1].set(jnp.diag(jnp.array([0.8, 0.8, 1.0])))


def response(law, F, history, dt):
    """A number per particle that depends on all that a step returns, of the order of E."""
    new, past = project(law, F, history, dt)
    weights = jnp.asarray(np.random.default_rng(6).normal(size=(3, 3)), F.dtype)
    memory = past if isinstance(past, jax.Array) else 0.0
    total = (weights * stress(law, new, past)).sum((1, 2)) + energy(law, new, past)
    return total + E * (weights * new).sum((1, 2)) + E * memory


# Run a few times each: compiling is what costs.
@partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
def gradients(law, F, history, dt):
    """With respect to (law, F, history, dt)."""
    return jax.grad(lambda *a: response(*a).sum(), argnums=(0, 1, 2, 3))(law, F, history, dt)


@pytest.mark.parametrize("name", ALL)
def test_gradients_match_central_differences(name, x64):
    law, F, dt = material(name), states(), jnp.asarray(DT)
    history = histories(law)
    by_law, by_F, by_history, by_dt = gradients(law, F, history, dt)
    regular = np.full(COUNT, True)
    if name in CORNER_AT_REST:
        regular[-1] = False

    def check(gradient, plus, minus, h, mask=regular):
        difference = (plus - minus) / (2 * h)
        scale = np.abs(difference[mask]).max()
        np.testing.assert_allclose(gradient[mask] / scale, difference[mask] / scale, atol=1e-6)

    h = 1e-6
    for seed in range(2):
        dF = np.random.default_rng(seed).normal(size=F.shape)
        plus, minus = (response(law, F + sign * h * dF, history, dt) for sign in (1, -1))
        check((by_F * dF).sum((1, 2)), plus, minus, h)
    for field in dataclasses.fields(law):
        value = getattr(law, field.name)
        if not isinstance(value, jax.Array) or field.name in CORNER_PARAMETERS.get(name, ()):
            continue
        step = h * (float(value[0]) or (1.0 if field.name == "friction_angle" else 0.01 * E))
        plus, minus = (
            response(dataclasses.replace(law, **{field.name: value + sign * step}), F, history, dt)
            for sign in (1, -1)
        )
        gradient = getattr(by_law, field.name)
        assert np.isfinite(gradient).all()
        assert (np.abs(gradient).max() > 0) == (field.name not in THRESHOLDS.get(name, ()))
        if not np.any(gradient):
            np.testing.assert_array_equal(plus, minus)
            continue
        check(gradient, plus, minus, step)
    if not isinstance(history, tuple):
        aged = regular & (np.arange(COUNT) % (COUNT - 1) > 0)  # the first and the last are fresh: a corner
        plus, minus = (response(law, F, history + sign * h, dt) for sign in (1, -1))
        check(by_history, plus, minus, h, aged)
    plus, minus = (response(law, F, history, dt * (1 + sign * h)) for sign in (1, -1))
    difference = (plus - minus).sum() / (2 * h * dt)
    np.testing.assert_allclose(by_dt, difference, rtol=1e-6, atol=1e-6 * E)
    assert (by_dt != 0) == (name == "foam")


@pytest.mark.parametrize("name", ALL)
def test_gradients_are_finite_at_rest(name, x64):
    law = material(name)
    F = jnp.broadcast_to(jnp.eye(3), (COUNT, 3, 3))
    for leaf in jax.tree.leaves(gradients(law, F, law.initial_history(), DT)):
        assert np.isfinite(leaf).all()


INACTIVE = {
    "von Mises": ("yield_stress", "hardening"),
    "plasticine": ("yield_stress", "softening"),
    "cohesive soil": ("friction_angle", "cohesion"),
    "clay": ("friction_angle", "cohesion"),
    "foam": ("yield_stress", "plastic_viscosity"),
    "snow": ("critical_compression", "critical_stretch", "hardening_cap"),
}


@pytest.mark.parametrize("name", INACTIVE)
def test_parameters_that_do_not_act_have_exactly_no_gradient(name, x64):
    law = material(name)
    elastic = np.eye(3) + 1e-3 * random_F(1.0)
    by_law = gradients(law, elastic, law.initial_history(), DT)[0]
    for parameter in INACTIVE[name]:
        np.testing.assert_array_equal(getattr(by_law, parameter), 0)
    assert np.abs(by_law.mu).min() > 0
    by_law = gradients(law, states(), histories(law), DT)[0]
    for parameter in INACTIVE[name]:
        assert np.abs(getattr(by_law, parameter)).max() > 0, "but they do act on what yields"


def test_hardening_of_snow_at_its_cap_has_no_gradient(x64):
    law = material("snow")
    by_law = gradients(law, states(), jnp.full(COUNT, 0.2), DT)[0]
    np.testing.assert_array_equal(by_law.hardening, 0)
    assert np.abs(by_law.hardening_cap)[:-1].min() > 0


@pytest.mark.parametrize("viscosity", [0.0, 1e-300, np.inf])
def test_gradients_are_finite_at_the_limits_of_viscosity(viscosity, x64):
    law = material("foam", plastic_viscosity=viscosity)
    for leaf in jax.tree.leaves(gradients(law, states(), (), DT)):
        assert np.isfinite(leaf).all()


@pytest.mark.parametrize("softening", [3 * MU, 20 * MU])
def test_gradients_are_finite_when_plasticine_breaks_at_once(softening, x64):
    law = material("plasticine", softening=softening)
    for leaf in jax.tree.leaves(gradients(law, states(), law.initial_history(), DT)):
        assert np.isfinite(leaf).all()


def test_a_liquid_in_shear_has_the_derivative_of_its_projection_at_rest(x64):
    # With no strength at all the return is F -> J^(1/3) R: smooth at F = I under pressure, although
    # the yield surface has shrunk to a point there.
    cases: dict[str, dict[str, Any]] = {
        "von Mises": dict(yield_stress=0.0, hardening=0.0),
        "plasticine": dict(yield_stress=0.0),
        "foam": dict(yield_stress=0.0, plastic_viscosity=0.0),
        "slurry": {},
    }
    for name, changes in cases.items():
        law = material(name, **changes)
        F, dF = diagonal(*[[-0.1] * 3] * COUNT), np.random.default_rng(7).normal(size=(COUNT, 3, 3))
        tangent = jax.jvp(
            lambda F, law=law: project(law, F, law.initial_history())[0], (F,), (jnp.asarray(dF),)
        )[1]
        trace = np.trace(dF, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
        np.testing.assert_allclose(tangent, trace + (dF - dF.swapaxes(1, 2)) / 2, atol=1e-12)


@pytest.mark.parametrize("name", ["Hencky", "cohesive soil", "snow"])
def test_single_precision_gradients_agree_with_double(name, x64):
    law, F = material(name), states()
    arguments = (law, F, histories(law), jnp.asarray(DT))
    single = jax.tree.map(lambda a: a.astype(jnp.float32), arguments)
    for double, float32 in zip(jax.tree.leaves(gradients(*arguments)), jax.tree.leaves(gradients(*single))):
        assert float32.dtype == jnp.float32
        one, other = np.ravel(double), np.ravel(float32).astype(float)
        assert one @ other >= (1 - 1e-6) * np.linalg.norm(one) * np.linalg.norm(other)
