"""The peers against exact discrete answers, closed forms and the published behaviour of the classical form.

Warp's kernels compile once, for some seconds, and are cached.
"""

import os
from typing import Any

import numpy as np
import pytest
from scipy.linalg import polar
from scipy.optimize import curve_fit

from benchmarks.peers import Contact, Material, PeerRun, PeerScene, Plane, drive, make_peer, run_in
from benchmarks.peers.genesis import GenesisMPM
from benchmarks.peers.warp_classical import WarpClassical

DX = 0.05
REASON = WarpClassical().available()
needs_warp = pytest.mark.skipif(REASON is not None, reason=str(REASON))
GENESIS_PYTHON = os.environ.get("PEER_PYTHON")
needs_genesis = pytest.mark.skipif(
    GENESIS_PYTHON is None, reason="set PEER_PYTHON to an interpreter that has genesis-world"
)


def lattice(cells, low=(6, 6, 6), per_axis=2):
    """Eight particles per cell in a box of ``cells`` cells whose low corner is node ``low``."""
    axes = [(np.arange(count * per_axis) + 0.5) / per_axis + start for count, start in zip(cells, low)]
    return (np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3) * DX).astype(np.float32)


def block(cells=(4, 4, 4), low=(6, 6, 6), grid_cells=20, **changes):
    """An elastic block of E = 1e5 Pa in a cubic domain."""
    settings: dict[str, Any] = dict(
        size=grid_cells * DX,
        cells=grid_cells,
        material=Material.NEO_HOOKEAN,
        volume=(DX / 2) ** 3,
        density=1000.0,
        youngs_modulus=1e5,
        poissons_ratio=0.3,
    )
    return PeerScene.of(lattice(cells, low), **(settings | changes))


def loaded(scene, dt):
    peer = WarpClassical()
    peer.load(scene, dt)
    return peer


def momentum(scene, v):
    return (scene.mass[:, None].astype(float) * v).sum(0)


# What moves rigidly


@needs_warp
@pytest.mark.parametrize("material", [Material.NEO_HOOKEAN, Material.JELLY, Material.METAL])
def test_free_fall_is_the_exact_discrete_parabola(material):
    steps, dt, g, v0 = 300, 1e-3, -1.0, np.array([0.1, 0, 0.2])
    scene = block(material=material, yield_stress=1e4, gravity=(0, 0, g), v=v0)
    peer = loaded(scene, dt)
    peer.run(steps)
    fall = steps * v0 * dt + np.array([0, 0, g]) * dt**2 * steps * (steps + 1) / 2
    np.testing.assert_allclose(peer.x(), scene.x + fall, atol=2e-5)
    np.testing.assert_allclose(peer.v(), scene.v + [0, 0, steps * g * dt], atol=2e-5)
    np.testing.assert_allclose(peer.F(), np.broadcast_to(np.eye(3), peer.F().shape), atol=1e-4)


@needs_warp
def test_momentum_of_a_vibrating_block_is_constant():
    rng = np.random.default_rng(0)
    x = lattice((4, 4, 4))
    scene = block(v=0.2 * rng.normal(size=x.shape) + 0.1)
    peer = loaded(scene, 1e-3)
    peer.run(300)
    np.testing.assert_allclose(momentum(scene, peer.v()), momentum(scene, scene.v), rtol=1e-5)
    assert np.abs(peer.F() - np.eye(3)).max() > 1e-3  # it did vibrate


def spin(**changes):
    """A cube of 8 cells turning once at omega dt = 1.6e-2, Courant number 0.3: kinetic energy, L_z left."""
    omega_dt = 1.6e-2
    wave_speed = np.sqrt(1e5 * 0.7 / (1.3 * 0.4) / 1000)
    dt = 0.3 * DX / wave_speed
    omega = omega_dt / dt
    W = np.array([[0, -omega, 0], [omega, 0, 0], [0, 0, 0]])
    x = lattice((8, 8, 8))
    scene = block((8, 8, 8), v=(x - x.mean(0)) @ W.T, C=W, **changes)
    peer = loaded(scene, dt)
    peer.run(round(2 * np.pi / omega_dt))

    def angular(x, v, C):
        x, v, C = (a.astype(float) for a in (x - x.mean(0), v, C))
        return (np.cross(x, v)[:, 2] + DX**2 / 4 * (C[:, 1, 0] - C[:, 0, 1])).sum()

    energy = (peer.v() ** 2).sum() / (scene.v**2).sum()
    return energy, angular(peer.x(), peer.v(), peer.C()) / angular(scene.x, scene.v, scene.C)


@needs_warp
def test_rigid_spin_loses_no_more_energy_than_apic_does():
    """An independent float64 code loses 3.6 % of the kinetic energy per revolution in this case."""
    energy, angular = spin()
    assert 0.03 < 1 - energy < 0.04
    assert abs(angular - 1) < 1e-4


@needs_warp
def test_pic_does_not_keep_a_spin_and_rpic_does():
    assert spin(transfer="pic")[0] < 0.01
    energy, angular = spin(rpic_damping=1.0)
    assert energy > 0.96 and abs(angular - 1) < 1e-4


@needs_warp
def test_rpic_damping_takes_the_energy_of_vibrations():
    x = lattice((4, 4, 4))
    energies = []
    for damping in (0.0, 0.5, 1.0):
        peer = loaded(block(v=0.2 * np.sin(12 * x), rpic_damping=damping), 1e-3)
        peer.run(100)
        energies.append((peer.v() ** 2).sum())
    assert energies[0] > energies[1] > energies[2]


# Elastic waves


def bar_frequency_error(cells):
    """Relative error of f = c0 / (2 L) for a free bar with nu = 0 at Courant number 0.3."""
    speed = np.sqrt(1e5 / 1000)
    length = cells * DX
    dt = 0.3 * DX / speed
    x = lattice((cells, 4, 4))
    mode = np.cos(np.pi * (x[:, 0] - 6 * DX) / length)
    v = np.zeros_like(x)
    v[:, 0] = 1e-3 * speed * mode
    peer = loaded(block((cells, 4, 4), grid_cells=cells + 12, poissons_ratio=0.0, v=v), dt)
    exact = speed / (2 * length)
    signal = []
    for _ in range(int(3 / exact / dt)):
        peer.run(1)
        signal.append((peer.v()[:, 0] * mode).mean())
    t = (np.arange(len(signal)) + 1) * dt

    def damped(t, a, f, decay, phase):
        return a * np.exp(-decay * t) * np.cos(2 * np.pi * f * t + phase)

    fitted, _ = curve_fit(damped, t, signal, p0=[5e-4 * speed, exact, 0.01 * exact, 0])
    return fitted[1] / exact - 1


@needs_warp
def test_bar_frequency_is_that_of_the_gradient_form():
    """Errors of an independent float64 code with -V0 tau grad w: -1.85 % at 8 cells, -0.48 % at 16.

    The MLS form has -1.51 % and -0.39 %, outside the margin of 15 %: the test tells the two apart. The rest
    is where the bar's ends lie within a cell, on which the gradient form depends.
    """
    errors = [bar_frequency_error(cells) for cells in (8, 16)]
    np.testing.assert_allclose(errors, [-0.0185, -0.0048], rtol=0.15)
    assert np.log2(errors[0] / errors[1]) > 1.8


# One particle at a time: a particle alone with v = 0 and C has F = I + dt C after one substep


def stretched(material, C, dt=1e-3, **changes):
    """F and tau of particles far from each other after one substep with the given C, shape (n, 3, 3)."""
    corners = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3)[: len(C)]
    x = (5.3 + 5 * corners).astype(np.float32) * DX
    settings: dict[str, Any] = dict(volume=1e-6, density=1000.0, youngs_modulus=1e5, poissons_ratio=0.3)
    scene = PeerScene.of(x, size=30 * DX, cells=30, material=material, C=C, **(settings | changes))
    peer = loaded(scene, dt)
    peer.run(1)
    return peer.F().astype(float), peer.tau().astype(float)


def random_C(count=40, size=150.0):
    return np.random.default_rng(1).uniform(-size, size, (count, 3, 3))


MU, LAM = 1e5 / 2.6, 1e5 * 0.3 / (1.3 * 0.4)
BULK = LAM + 2 * MU / 3


def close(actual, expected, modulus=1e5):
    np.testing.assert_allclose(actual, expected, atol=1e-5 * modulus)


@needs_warp
def test_elastic_stresses_are_their_closed_forms():
    C = random_C()
    trial = np.eye(3) + 1e-3 * C
    J = np.linalg.det(trial)[:, None, None]
    F, tau = stretched(Material.JELLY, C)
    np.testing.assert_allclose(F, trial, atol=2e-6)
    R = np.array([polar(f)[0] for f in trial])
    close(tau, 2 * MU * (trial - R) @ trial.swapaxes(1, 2) + LAM * J * (J - 1) * np.eye(3))
    _, tau = stretched(Material.NEO_HOOKEAN, C)
    close(tau, MU * (trial @ trial.swapaxes(1, 2) - np.eye(3)) + LAM * np.log(J) * np.eye(3))
    F, tau = stretched(Material.FLUID, C, bulk_modulus=1e4)
    np.testing.assert_allclose(F, np.cbrt(J) * np.eye(3), atol=2e-6)
    close(tau, -J * 1e4 * (J**-7.0 - 1) / 7 * np.eye(3), modulus=1e5)


def deviator(tau):
    return tau - np.trace(tau, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)


@needs_warp
def test_metal_stress_stops_at_the_yield_stress_and_keeps_the_volume():
    C = random_C()
    F, tau = stretched(Material.METAL, C, yield_stress=500.0)
    np.testing.assert_allclose(np.linalg.norm(deviator(tau), axis=(1, 2)), 500, rtol=2e-3)
    J = np.linalg.det(np.eye(3) + 1e-3 * C)
    np.testing.assert_allclose(np.linalg.det(F), J, rtol=1e-5)
    close(np.trace(tau, axis1=1, axis2=2), 3 * BULK * np.log(J))
    # Uniaxial strain: tau_1 = K e + sqrt(2/3) * bound after yield, (lam + 2 mu) e before.
    strain = np.array([1e-3, 0.05, 0.2])
    axial = np.zeros((3, 3, 3))
    axial[:, 0, 0] = np.expm1(strain) / 1e-3
    _, tau = stretched(Material.METAL, axial, yield_stress=500.0)
    elastic = (LAM + 2 * MU) * strain[:1]
    close(tau[:, 0, 0], np.concatenate([elastic, BULK * strain[1:] + np.sqrt(2 / 3) * 500]))


@needs_warp
def test_a_sheared_block_of_metal_holds_the_plateau_of_simple_shear():
    """tau_12 = bound / sqrt 2, in the material that a linear velocity field shears far beyond yield."""
    rate, bound = 20.0, 300.0
    W = np.array([[0, rate, 0], [0, 0, 0], [0, 0, 0]])
    x = lattice((4, 4, 4))
    changes: dict[str, Any] = dict(
        material=Material.METAL, yield_stress=bound, density=1e7
    )  # too heavy to feel its stress
    peer = loaded(block(v=(x - x.mean(0)) @ W.T, C=W, **changes), 1e-4)
    peer.run(50)
    np.testing.assert_allclose(peer.tau()[:, 0, 1], bound / np.sqrt(2), rtol=0.02)


@needs_warp
def test_sand_yields_at_the_cone_and_has_no_tension():
    phi = np.radians(30)
    C = np.zeros((3, 3, 3))
    # Triaxial compression beyond yield; elastic compression; expansion with shear.
    C[0] = np.diag(np.expm1([-0.3, 0.05, 0.05])) / 1e-3
    C[1] = np.diag(np.expm1([-0.1, -0.09, -0.09])) / 1e-3
    C[2] = [[50, 80, 0], [0, 10, 0], [0, 0, 0]]
    F, tau = stretched(Material.SAND, C, friction_angle_degrees=30.0)
    principal = np.diagonal(tau[0])
    np.testing.assert_allclose(principal[0] / principal[1:], (1 + np.sin(phi)) / (1 - np.sin(phi)), rtol=1e-4)
    np.testing.assert_allclose(np.linalg.det(F[0]), np.exp(-0.2), rtol=1e-5)
    strain = np.array([-0.1, -0.09, -0.09])
    close(np.diagonal(tau[1]), 2 * MU * strain + LAM * strain.sum())
    close(tau[2], 0)
    np.testing.assert_allclose(F[2].T @ F[2], np.eye(3), atol=1e-5)


# Boundaries


FLOOR: dict[str, Any] = dict(point=(0, 0, 6 * DX), normal=(0, 0, 2))


@needs_warp
def test_friction_takes_its_share_of_the_normal_impulse():
    """While all of the block slides, the tangential impulse is friction times the normal impulse, exactly."""
    steps, dt, g, friction = 200, 1e-3, 5.0, 0.4
    floor = Plane(**FLOOR, contact=Contact.SEPARATE, friction=friction)
    scene = block(v=(1.0, 0, -0.1), gravity=(0, 0, -g), planes=(floor,), grid_cells=24)
    peer = loaded(scene, dt)
    peer.run(steps)
    impulse = momentum(scene, peer.v()) - momentum(scene, scene.v)
    normal = impulse[2] + float(scene.mass.sum()) * g * steps * dt
    assert normal > 0 and peer.v()[:, 0].min() > 0.1
    np.testing.assert_allclose(impulse[0], -friction * normal, rtol=1e-3)


@needs_warp
@pytest.mark.parametrize(("contact", "kept"), [("separate", [1, 1]), ("slip", [1, 0]), ("sticky", [0, 0])])
def test_only_what_the_plane_holds_slows_a_block_that_leaves_it(contact, kept):
    scene = block(v=(1.0, 0, 0.5), planes=(Plane(**FLOOR, contact=Contact(contact)),))
    peer = loaded(scene, 1e-3)
    peer.run(20)
    ratio = (momentum(scene, peer.v()) / np.maximum(momentum(scene, scene.v), 1e-9))[[0, 2]]
    np.testing.assert_allclose(ratio[np.array(kept) == 1], 1, atol=1e-5)
    assert np.all(ratio[np.array(kept) == 0] < 0.9)


@needs_warp
def test_domain_box_stops_slides_and_lets_go():
    scene = block(v=(-2.0, 0, 0.3), low=(4, 8, 8), domain_box=3)
    peer = loaded(scene, 1e-3)
    peer.run(150)
    assert peer.x()[:, 0].min() > 2 * DX
    before, after = momentum(scene, scene.v), momentum(scene, peer.v())
    assert after[0] > 0  # it bounced
    np.testing.assert_allclose(after[2], before[2], rtol=1e-4)


@needs_warp
def test_leaving_the_grid_is_an_error_not_a_wrong_answer():
    peer = loaded(block(v=(-5.0, 0, 0), domain_box=None), 1e-3)
    with pytest.raises(RuntimeError, match="left the grid"):
        peer.run(100)


# The interface


def test_scene_survives_its_file(tmp_path):
    plane = Plane((0, 0, 0.2), (0, 0, 1), Contact.STICKY, 0.3)
    scene = block(
        material=Material.SAND, friction_angle_degrees=30.0, planes=(plane,), domain_box=None, v=1.0
    )
    scene.save(tmp_path / "scene.npz")
    again = PeerScene.load(tmp_path / "scene.npz")
    for name, value in vars(scene).items():
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(getattr(again, name), value)
            assert getattr(again, name).dtype == value.dtype
        else:
            assert getattr(again, name) == value


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (dict(material=Material.METAL), "yield_stress"),
        (dict(density=0.0), "density"),
        (dict(rpic_damping=2.0), "rpic_damping"),
        (dict(planes=(Plane((0, 0, 0), (0, 0, 0)),)), "normal"),
    ],
)
def test_scene_refuses_what_makes_no_sense(changes, message):
    with pytest.raises(ValueError, match=message):
        block(**changes)


def test_unknown_peer_is_named():
    with pytest.raises(ValueError, match="warp_classical, genesis"):
        make_peer("taichi")


@needs_warp
def test_a_loaded_peer_starts_at_the_scene_and_repeats_itself():
    scene = block(v=0.2 * np.sin(12 * lattice((4, 4, 4))), gravity=(0, 0, -1))
    first, second = (drive(WarpClassical("cpu"), scene, 1e-3, 30, 20) for _ in range(2))
    np.testing.assert_array_equal(first.steps, [0, 20, 30])
    np.testing.assert_array_equal(first.x[0], scene.x)
    np.testing.assert_array_equal(first.v, second.v)
    assert first.seconds.shape == (2,)


@needs_warp
def test_another_interpreter_gives_the_same_answer(monkeypatch):
    monkeypatch.delenv("PEER_PYTHON", raising=False)
    scene = block(v=0.2 * np.sin(12 * lattice((4, 4, 4))))
    there = run_in(None, "warp_classical", scene, 1e-3, 20, 10)
    here = drive(WarpClassical(), scene, 1e-3, 20, 10)
    assert isinstance(there, PeerRun) and there.version == here.version
    np.testing.assert_allclose(there.x, here.x, atol=1e-6)


def test_failure_in_another_interpreter_is_told():
    scene = block(material=Material.FLUID, bulk_modulus=1e4)
    with pytest.raises(RuntimeError, match="(?s)genesis failed .*(not installed|the material fluid differs)"):
        run_in(None, "genesis", scene, 1e-3, 10)


# Genesis


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (dict(material=Material.SAND, friction_angle_degrees=30.0), "material sand"),
        (dict(density=np.linspace(1, 2, 512)), "density"),
        (dict(planes=(Plane(**FLOOR),)), "planes"),
        (dict(rpic_damping=0.5), "APIC"),
    ],
)
def test_genesis_refuses_what_it_has_no_counterpart_for(changes, message):
    with pytest.raises(NotImplementedError, match=message):
        GenesisMPM().load(block(**changes), 1e-3)


@needs_genesis
@needs_warp
@pytest.mark.slow
@pytest.mark.parametrize("material", [Material.NEO_HOOKEAN, Material.JELLY])
def test_genesis_and_warp_agree_on_a_block_that_spins_falls_and_hits_the_wall(material):
    x = lattice((4, 4, 4), low=(8, 8, 4))
    W = np.array([[0, -4.0, 0], [4, 0, 0], [0, 0, 0]])
    changes: dict[str, Any] = dict(
        v=(x - x.mean(0)) @ W.T + [0, 0, -1.0], C=W, material=material, gravity=(0, 0, -9.8)
    )
    scene = block(low=(8, 8, 4), **changes)
    there = run_in(GENESIS_PYTHON, "genesis", scene, 5e-4, 200, 20)
    here = drive(WarpClassical(), scene, 5e-4, 200, 20)
    np.testing.assert_allclose(there.x[0], scene.x)
    np.testing.assert_allclose(there.x.mean(1), here.x.mean(1), atol=0.02 * DX)
    assert here.v[-1, :, 2].mean() > 0  # both bounced
    assert np.abs(there.x - here.x).max() < 0.3 * DX
