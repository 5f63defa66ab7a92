"""Models and states for the simulator: values at the edges, operands of other types and shapes.

With values, `simulate` gives finite frames or refuses. With types and shapes,
    the CPU kernels and the reference give the
same numbers, or both refuse. All cases have the same particles, so that few programs are compiled.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import Model, NeoHookean, State, VonMises, rollout, simulate
from tests.fuzz.contract import Breach, Case, Fault
from tests.fuzz.drawing import Draw
from tests.mpm.blocks import block

COUNT, CELLS, SIZE, DT = 8, 12, 1.0, 1e-4
FIELDS = ("x", "v", "C", "F", "mass", "volume", "mu", "lam", "gravity", "dt")
EXTREMES = (
    0.0,
    -1.0,
    1e-6,
    1e-7,
    1e-20,
    1e-38,
    1e-45,
    3.0,
    94.0,
    3400.0,
    1e6,
    1e12,
    1e20,
    3e38,
    -1e30,
    np.nan,
    np.inf,
)
# What `rollout` may be given beside float32: which operands, and of what type or shape.
OTHER_TYPES = (
    ("mass", "float64"), ("volume", "int32"), ("mu", "float64"), ("gravity", "float64"),
    ("gravity", "int32"), ("dt", "float64"), ("v", "float64"), ("F", "float64"), ("x", "float64"),
    ("mass", "float16"), ("mu", "int32"), ("force", "float64"),
)  # fmt: skip
OTHER_SHAPES = (
    ("mass", "one"), ("mass", "column"), ("volume", "short"), ("mu", "one"), ("gravity", "column"),
    ("v", "transposed"), ("F", "flat"), ("dt", "column"), ("C", "short"), ("mass", "scalar"),
)  # fmt: skip


def make(draw: Draw) -> Case:
    """One model and state."""
    if draw.chance(0.2):
        changes = draw.sample(OTHER_TYPES, draw.one([1, 1, 1, 2]))
        return Case(
            f"rollout with {changes}", lambda _: _compare(changes), refusals=(UserError,), seconds=60.0
        )
    if draw.chance(0.15):
        shape = draw.one(OTHER_SHAPES)
        refusals = (
            UserError,
            TypeError,
            ValueError,
        )  # JAX's own words for shapes that do not fit are refusals too
        return Case(f"rollout with {shape}", lambda _: _compare([shape]), refusals=refusals, seconds=60.0)
    law = draw.one([NeoHookean, NeoHookean, VonMises])
    kernels = draw.one(["auto", "auto", "reference"])
    changes: list[tuple[str, Any, bool]] = []
    for _ in range(draw.one([1, 1, 2])):
        changes.append((draw.one(FIELDS), draw.one(EXTREMES), draw.chance(0.5)))
    what = ", ".join(f"{name} = {value:g}{'' if whole else ' once'}" for name, value, whole in changes)
    return Case(
        f"{law.__name__}, {kernels}: {what}", lambda _: _simulate(law, kernels, changes), seconds=60.0
    )


def warm_up() -> None:
    """The programs of the usual case."""
    _simulate(NeoHookean, "auto", [])


def _make_usual(law=NeoHookean, kernels="auto") -> tuple[Model, State]:
    """Eight particles in the middle of the domain that fly a little and are sheared a little."""

    def material(mu, lam):
        if law is NeoHookean:
            return law(mu, lam)
        return law(mu, lam, jnp.full(COUNT, 1e3, mu.dtype), jnp.zeros(COUNT, mu.dtype))

    model, state = block(
        (1, 1, 1), size=SIZE, grid_cells=CELLS, low=(0.5, 0.5, 0.5), dt=DT, material=material, kernels=kernels,
        gravity=jnp.asarray([0.0, 0.0, -9.8], jnp.float32),
    )  # fmt: skip
    rng = np.random.default_rng(0)
    F = np.eye(3) + 0.02 * rng.normal(size=(COUNT, 3, 3))
    v = jnp.asarray(rng.normal(size=(COUNT, 3)), jnp.float32)
    state = State.at_rest(state.x, v, model.materials)
    return model, dataclasses.replace(state, F=jnp.asarray(F, jnp.float32))


def _get(model: Model, state: State, name: str):
    owner: Any = state if hasattr(state, name) else model if hasattr(model, name) else model.materials[0]
    return getattr(owner, name)


def _set(model: Model, state: State, name: str, value) -> tuple[Model, State]:
    if hasattr(state, name):
        return model, dataclasses.replace(state, **{name: value})
    if hasattr(model, name):
        return model.replace(**{name: value}), state
    return model.replace(materials=(dataclasses.replace(model.materials[0], **{name: value}),)), state


def _simulate(law, kernels: str, changes):
    model, state = _make_usual(law, kernels)
    for name, value, whole in changes:
        array = np.array(_get(model, state, name), copy=True)
        with np.errstate(all="ignore"):
            array[...] = value if whole or not array.ndim else array
            if not whole and array.ndim:
                array.flat[0] = value
        model, state = _set(model, state, name, jax.device_put(array))
    return [
        dataclasses.replace(f, order=None) for f in simulate(model, state, frame_count=2, frame_dt=20 * DT)
    ]


def _compare(changes):
    """The end of a short rollout by the reference and by the kernels; both refuse, or both give the same."""
    with jax.enable_x64(True):
        answers = [_advance(kernels, changes) for kernels in ("reference", "cpu")]
    refused = [answer for answer in answers if isinstance(answer, Exception)]
    if len(refused) == 1:
        which = "reference" if refused[0] is answers[0] else "kernels"
        raise Breach(
            Fault.SILENT, f"only the {which} refused: {type(refused[0]).__name__}: {refused[0]}"[:300]
        )
    if refused:
        raise refused[-1]
    one, other = answers
    for name in ("x", "v", "F"):
        got, expected = (np.asarray(getattr(each, name), float) for each in (other, one))
        scale = np.abs(expected).max()
        if not np.allclose(got, expected, rtol=0, atol=1e-4 * max(scale, 1e-6), equal_nan=True):
            worst = np.nanmax(np.abs(got - expected)) if np.isfinite(got).any() else np.nan
            raise Breach(
                Fault.SILENT, f"kernels and reference differ in {name} by {worst:.3g} of {scale:.3g}"
            )
    return other.x, other.v, other.F


def _advance(kernels: str, changes):
    model, state = _make_usual(kernels=kernels)
    try:
        for name, change in changes:
            if name == "force":
                push = UniformAcceleration(
                    *(jnp.asarray(part, change) for part in ((1.0, 2.0, 3.0), 0.0, 1.0))
                )
                model = model.replace(forces=(push,))
                continue
            array = np.asarray(_get(model, state, name))
            model, state = _set(model, state, name, jnp.asarray(_change(array, change)))
        return rollout(model, state, frame_count=1, substeps=2)[0]
    except (UserError, TypeError, ValueError) as error:
        return error


def _change(array: np.ndarray, change: str) -> np.ndarray:
    match change:
        case "one":
            return array.reshape(-1)[:1]
        case "column":
            return array.reshape(-1, 1)
        case "short":
            return array[:-1]
        case "scalar":
            return array.reshape(-1)[0]
        case "flat":
            return array.reshape(len(array), -1)
        case "transposed":
            return array.T
    with np.errstate(all="ignore"):
        return np.ceil(array).astype(change) if np.dtype(change).kind == "i" else array.astype(change)
