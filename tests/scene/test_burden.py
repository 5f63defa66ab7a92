"""The burden of an object's own weight, against the theory of columns."""

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.calibration import GRAVITY
from physagent_jax.scene.burden import find_burden, measure_burden
from physagent_jax.scene.config import Anchor, Material
from tests.scene.test_standing import template_of

FREE, BASE, TOP = (Anchor(kind=kind, fraction=0.08) for kind in ("none", "base", "top"))
RHO = 500.0


def measure(path, anchor=FREE, *, youngs_modulus=1e5, ground=True):
    template, body, _ = template_of(path)
    material = Material(youngs_modulus=youngs_modulus, poissons_ratio=0.0, density=RHO)
    height = float(body.particles.x[:, 2].min()) if ground else None
    return measure_burden(body, material, anchor, ground=height, dx=template.preset.domain.dx)


@pytest.fixture(scope="module")
def column(tmp_path_factory):
    path = tmp_path_factory.mktemp("column") / "thing.obj"
    trimesh.creation.box((0.2, 0.2, 1.0)).export(path)
    return path


def test_a_column_buckles_under_its_weight_as_greenhill_has_it(column):
    """Greenhill 1881: a column clamped at its foot buckles at w L^3 / (E I) = 7.837, w its weight per length."""
    area, inertia = 0.2**2, 0.2**4 / 12
    share = RHO * GRAVITY * area / (7.837 * 1e5 * inertia)
    assert measure(column).buckling == pytest.approx(share, rel=0.25)


def test_a_column_is_strained_as_a_bar_under_its_weight(column):
    share = measure(column).strain / (0.96 * RHO * GRAVITY / 1e5)
    assert 0.9 < share < 1.6  # cells are coarse, and their edges softer


def test_a_thin_stem_buckles_as_euler_has_it(tmp_path):
    """Euler: P L^2 / (E I) = pi^2 / 4 of a stem that is clamped at its foot and carries P."""
    stem = trimesh.creation.cylinder(0.06, 0.8).apply_translation((0, 0, 0.4))
    head, foot = (trimesh.creation.cylinder(0.25, 0.1).apply_translation((0, 0, z)) for z in (0.85, -0.05))
    trimesh.util.concatenate([stem, head, foot]).export(tmp_path / "thing.obj")
    load = RHO * GRAVITY * np.pi * (0.25**2 * 0.1 + 0.3 * 0.06**2 * 0.8)  # and near a third of the stem
    inertia = np.pi / 4 * 0.06**4
    share = load * 0.85**2 * 4 / (np.pi**2 * 1e5 * inertia)
    assert measure(tmp_path / "thing.obj").buckling == pytest.approx(share, rel=0.4)


def test_what_hangs_does_not_buckle(column):
    """Tension stiffens; pressure is only in the part that is held."""
    standing, hanging = measure(column, BASE), measure(column, TOP, ground=False)
    assert standing.buckling > 1.0 and hanging.buckling < 0.1


def test_a_single_free_node_hardly_buckles(tmp_path):
    """Fewer freedoms than steps: the steps end with what they span."""
    trimesh.creation.icosphere(2, 0.5).export(tmp_path / "thing.obj")
    burden = measure(tmp_path / "thing.obj", Anchor(kind="base", fraction=0.99))
    assert 0 <= burden.buckling < 0.1 and np.isfinite(burden.needed).all()


def test_burdens_go_with_the_compliance_and_are_measured_once(column, monkeypatch):
    template, body, _ = template_of(column)
    soft, firm = (Material(youngs_modulus=each, poissons_ratio=0.0, density=RHO) for each in (2e4, 1e6))
    dx, ground = template.preset.domain.dx, float(body.particles.x[:, 2].min())
    one = find_burden(body, soft, BASE, ground=ground, dx=dx)
    monkeypatch.setattr("physagent_jax.scene.burden.measure_burden", None)
    other = find_burden(body, firm, BASE, ground=ground, dx=dx)
    assert one.buckling == pytest.approx(50 * other.buckling) and one.sag == pytest.approx(50 * other.sag)


def test_what_nothing_holds_bears_nothing(column):
    burden = measure(column, FREE, ground=False)
    assert burden.strain == burden.sag == burden.buckling == 0.0 and burden.needed is None


def test_a_thin_neck_is_not_stiffer_than_it_is(tmp_path):
    """A stiff head of weight W on a short neck of length l gives way at W h l / (E I) = 1, h its middle's height."""
    radius, length, tall, wide = 0.03, 0.1, 0.4, 0.08
    block = trimesh.creation.box((0.4, 0.4, 0.4)).apply_translation((0, 0, -0.2))
    neck = trimesh.creation.cylinder(radius, length + 0.04).apply_translation((0, 0, length / 2))
    head = trimesh.creation.cylinder(wide, tall).apply_translation((0, 0, length + tall / 2))
    trimesh.util.concatenate([block, neck, head]).export(tmp_path / "thing.obj")
    modulus, scale = 7e5, 1 / 0.9  # its longest side becomes 1 m
    load = RHO * GRAVITY * np.pi * wide**2 * tall
    share = scale * load * (length + tall) / 2 * length / (modulus * np.pi / 4 * radius**4)
    template, body, _ = template_of(tmp_path / "thing.obj")
    material = Material(youngs_modulus=modulus, poissons_ratio=0.0, density=RHO)
    ground, dx = float(body.particles.x[:, 2].min()), template.preset.domain.dx
    found = find_burden(body, material, FREE, ground=ground, dx=dx)
    assert found.buckling == pytest.approx(share, rel=0.6) and found.share > 1.0
