"""Particles split over several devices move as they do on one, and so do their gradients."""

import dataclasses
import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import PrescribedMotion, rollout, rollout_sharded, simulate, step
from physagent_jax.mpm.sharding import ParticleLayout
from tests.conftest import QUICK_TO_COMPILE, REPOSITORY
from tests.mpm.blocks import block


def computed(which, file):
    """The arrays that `sharded_runs` makes in a process with four devices: a process knows but one number of them."""
    variables = dict(
        os.environ,
        JAX_PLATFORMS="cpu",
        JAX_ENABLE_X64="1",
        JAX_DISABLE_MOST_OPTIMIZATIONS="1",  # compiling takes longer than running
        XLA_FLAGS=f"--xla_force_host_platform_device_count=4 {QUICK_TO_COMPILE}".strip(),
    )
    command = [sys.executable, "-m", "tests.mpm.sharded_runs", which, str(file)]
    done = subprocess.run(command, cwd=REPOSITORY, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return dict(np.load(file))


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """All quick comparisons, from one process."""
    return computed("quick", tmp_path_factory.mktemp("sharded") / "runs.npz")


def part(runs, name):
    """The arrays of one result, by their place in it."""
    return {key.removeprefix(name + "/"): value for key, value in runs.items() if key.startswith(name + "/")}


def same(got, expected, tolerance):
    """Up to ``tolerance`` times the largest number of each array."""
    assert got.keys() == expected.keys() and got
    for key, value in expected.items():
        scale = max(1e-6, np.abs(value).max())
        np.testing.assert_allclose(got[key], value, rtol=0, atol=tolerance * scale, err_msg=key)


def test_a_rollout_is_that_of_one_device(runs):
    """Four laws in blocks of 101, 70, 2 and 42 particles; a torque, a stretch, a floor, a clamp and a rigid body."""
    one = part(runs, "one")
    same(part(runs, "four"), one, 1e-12)
    path, yielded = one["1/x"], one["0/history/1"]
    assert np.abs(path[-1] - path[0]).max() > 3e-3 and yielded.max() > 0  # something does happen


def test_gradients_are_those_of_one_device(runs):
    """With respect to what devices share (gravity, torque, stiffness) and what they split (mass, velocity).

    Through sharpened increments, which need the masses of all devices, and for which massless twins count for nothing.
    """
    one = part(runs, "gradients_one")
    same(part(runs, "gradients_four"), one, 1e-10)
    assert all(np.abs(slope).max() > 0 for slope in one.values())


@pytest.mark.slow
def test_gradients_through_a_yielding_metal_are_those_of_one_device(tmp_path):
    """Likewise with a law in principal stretches, whose derivative is a rule of our own."""
    runs = computed("thorough", tmp_path / "runs.npz")
    same(part(runs, "gradients_four"), part(runs, "gradients_one"), 1e-10)


def test_all_that_is_reduced_over_particles_is_global(runs):
    """Time-step bounds, energies, momenta, the frame's health and the ledger, each device answering for all."""
    same(part(runs, "reduced_four"), part(runs, "reduced_one"), 1e-11)


def test_momentum_is_kept(runs):
    """In free flight under a stretch, which gives none: what one device loses another gains."""
    flight = part(runs, "free_flight")
    np.testing.assert_allclose(flight["1/0"], flight["0/0"], atol=1e-12)
    np.testing.assert_allclose(flight["1/1"], flight["0/1"], atol=1e-12)


@pytest.mark.parametrize("devices", ["three", "four"])
def test_padding_is_not_counted(devices, runs):
    """A stopped particle that has massless twins counts once per substep, and is where it would be without them."""
    one, split = part(runs, "wall_one"), part(runs, f"wall_{devices}")
    assert split["1"] == one["1"] > 0
    np.testing.assert_allclose(split["0"], one["0"], atol=1e-12)


def test_a_particle_out_of_the_window_spoils_the_positions_of_all_devices(runs):
    assert np.isnan(runs["out"]).all()


def test_one_device_will_do(x64):
    """Whatever the machine: the same program on a mesh of one."""
    model, state = block((2, 2, 2), dtype=np.float64, gravity=jnp.array([0.0, 0, -9.8]))
    end, path = rollout_sharded(model, state, jax.devices()[:1], frame_count=2, substeps=3)
    expected, _ = rollout(model, state, frame_count=2, substeps=3)
    np.testing.assert_allclose(end.x, expected.x, atol=1e-14)
    np.testing.assert_array_equal(path.x[-1], end.x)


def split_run(model, state):
    return rollout_sharded(model, state, frame_count=1, substeps=1)


@dataclasses.dataclass(frozen=True)
class Strange:
    """A constraint that nobody knows how to split."""


def refused_changes():
    push = UniformAcceleration(jnp.ones((32, 3)), jnp.array(0.0), jnp.array(1.0))
    return [
        (lambda m: m.replace(kernels="cpu"), "CPU kernels serve one device"),
        (lambda m: m.replace(mass=m.mass[:-1]), "same number of particles"),
        (lambda m: m.replace(constraints=(Strange(),)), "Strange cannot be split"),
        (lambda m: m.replace(forces=(push,)), "field `value` as long as there are particles"),
    ]


@pytest.mark.parametrize(("change", "words"), refused_changes())
def test_what_cannot_be_split_is_refused(change, words):
    model, state = block((2, 2, 1))
    with pytest.raises(UserError, match=words):
        split_run(change(model), state)


@dataclasses.dataclass(frozen=True)
class OneForAll:
    """A material that counts its particles otherwise than by its arrays."""

    count: int


jax.tree_util.register_dataclass(OneForAll, data_fields=[], meta_fields=["count"])


def test_a_material_with_a_count_of_its_own_is_refused():
    """Each device would believe it had all the particles."""
    model, state = block((2, 2, 1))
    with pytest.raises(UserError, match="OneForAll cannot be split"):
        ParticleLayout((32,), devices=2).split(model.replace(materials=(OneForAll(32),)), state)


def test_constraints_that_are_traced_are_refused():
    model, state = block((2, 2, 1))
    clamped = model.replace(constraints=(PrescribedMotion.fixed(jnp.arange(3)),))
    with pytest.raises(UserError, match="must be known before"):
        jax.jit(split_run)(clamped, state)


def test_a_split_model_elsewhere_is_refused():
    """`step` outside of a mesh, and `simulate`, which runs on one device."""
    model, state = block((2, 2, 1))
    split = model.replace(axis="particles")
    with pytest.raises(UserError, match="no such mesh axis"):
        step(split, state)
    with pytest.raises(UserError, match="runs on one device"):
        next(simulate(split, state, frame_count=2, frame_dt=0.01))
