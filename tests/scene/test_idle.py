"""Idle matter: led for the whole clip, it is not stiff, and its strain shortens no step."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from physagent_jax.core.arrays import to_device
from physagent_jax.forces.schema import BoxRegion, ForceField, VelocityConstraint
from physagent_jax.mpm import stable_dt
from physagent_jax.scene import config as c
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.compile import scene as compile_module
from physagent_jax.scene.compile.idle import is_led_to_end
from physagent_jax.simulation.simulate import simulate_frames
from tests.scene.small_scenes import make_config, make_small_body

FRAMES = 4
REST = BoxRegion(low=(0, 0, 0), high=(1, 1, 0.5))
TOP = BoxRegion(low=(0, 0, 0.5), high=(1, 1, 1))
STIFF = c.Material(youngs_modulus=3e5, density=400.0)


@pytest.fixture(scope="module")
def body(tmp_path_factory):
    return make_small_body(tmp_path_factory.mktemp("jelly"))


def lead(body, held_until=FRAMES - 1, window=(0, 2), material=STIFF, anchor=REST):
    """The jelly with its upper half drawn up far beyond its own height, and its lower half held."""
    drawn = VelocityConstraint(
        constraint_type="enforce_particle_translation",
        vector=(0, 0, 1),
        magnitude=1.6,
        gain=2.0,
        active_time=window,
        held_until=held_until,
        region=TOP,
    )
    config = make_config(
        Path("/unread"),
        FRAMES,
        material=material,
        anchor=c.Anchor(kind="region", region=anchor, reason="test"),
        force_field=ForceField(constraints=(drawn,)),
    )
    return compile_scene(config, body)


def soften(scene):
    firmness = scene.materials.firmness
    return np.zeros(len(scene.state.x), bool) if firmness is None else firmness < 0.5


def test_its_strain_costs_no_steps(body):
    """Drawn to four times its length it would take a third of the steps at rest; the stress is nobody's business."""
    led, free = lead(body), lead(body, held_until=None)
    assert soften(led).all() and not soften(free).any()
    drawn = np.broadcast_to(np.diag([1, 1, 4]).astype(np.float32), free.state.F.shape)

    def find_step(scene):
        return float(stable_dt(scene.model, dataclasses.replace(scene.state, F=to_device(drawn))))

    assert find_step(free) < 0.5 * float(stable_dt(free.model, free.state))
    assert find_step(led) > 10 * find_step(free)


def test_what_is_led_to_the_planned_end_is_idle_too(body):
    """Nobody lets it go: the clip ends there, whether it is held or moves on."""
    moved = lead(body, held_until=None, window=(0, FRAMES - 1))
    assert soften(moved).all() and is_led_to_end(moved.config)
    let_go = lead(body, held_until=None, window=(0, FRAMES - 2))
    assert not soften(let_go).any() and not is_led_to_end(let_go.config)


def test_what_is_rocked_until_the_end_does_not_fall_over_after_it(body):
    """Let go in mid-swing it would tip; what is spun on its foot runs out."""
    for axis, kept in {(1.0, 0.0, 0.0): True, (0.0, 0.0, 1.0): False}.items():
        turn = VelocityConstraint(
            constraint_type="enforce_particle_rotation",
            vector=axis,
            magnitude=1.0,
            active_time=(0, FRAMES - 1),
        )
        config = make_config(
            Path("/unread"), FRAMES, material=STIFF, force_field=ForceField(constraints=(turn,))
        )
        scene = compile_scene(config, body)
        assert is_led_to_end(scene.config) is kept and soften(scene).all() == kept


def test_what_is_free_for_a_while_keeps_its_stiffness(body):
    assert not soften(lead(body, window=(1, 2))).all()
    part = soften(lead(body, anchor=BoxRegion(low=(0, 0, 0), high=(1, 1, 0.1))))
    assert not part.all()


def test_what_flows_by_its_stress_keeps_its_stiffness(body):
    metal = c.Material(
        model=c.MaterialModel.VON_MISES,
        youngs_modulus=3e5,
        density=400.0,
        yield_stress=3e3,
        hardening_modulus=0,
    )
    assert not soften(lead(body, material=metal)).any()


def test_what_is_free_goes_as_if_idle_matter_were_stiff(body, monkeypatch):
    """Exactly: no node that a free particle shares has any of its stress. The middle is free, between both grips."""
    config = lead(body, anchor=BoxRegion(low=(0, 0, 0), high=(1, 1, 0.2))).config
    timing = config.timing.model_copy(update=dict(substep_dt=5e-4))
    config = config.model_copy(update=dict(domain=c.Domain(size=3.0, cells=60), timing=timing))
    ends = []
    for drop in (False, True):
        if drop:
            monkeypatch.setattr(
                compile_module, "find_idle", lambda *given: np.zeros(len(body.particles.x), bool)
            )
        scene = compile_scene(config, body)
        idle = soften(scene)
        assert not idle.all() and idle.any() != drop
        *_, last = simulate_frames(scene, None)
        ends.append(np.asarray(last.state.x))
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-6)
    assert np.abs(ends[0] - np.asarray(scene.state.x)).max() > 0.1
