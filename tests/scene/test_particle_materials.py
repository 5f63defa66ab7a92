"""Particles get the materials of their regions, in blocks of equal model."""

from types import SimpleNamespace

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.mpm import materials as m
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.materials import ParticleMaterials
from physagent_jax.scene.config import Material, MaterialModel

X = np.stack(np.meshgrid(*[np.linspace(0.4, 0.6, 4)] * 3, indexing="ij"), -1).reshape(-1, 3)


def materials_of(base, *regions):
    """Materials of a cube of 64 particles; each region is (x from, x to, material)."""
    boxes = tuple(
        c.MaterialRegion(
            point=(0.5 * (low + high), 0.5, 0.5), half_size=(0.5 * (high - low), 1, 1), material=material
        )
        for low, high, material in regions
    )
    config = c.SceneConfig(source=c.Source(path="x.ply"), material=base, material_regions=boxes)
    body = SimpleNamespace(particles=SimpleNamespace(x=X, count=len(X)))
    return ParticleMaterials.of(config, body)  # type: ignore[arg-type]


def in_order(materials):
    order = np.argsort(materials.model, kind="stable")
    return order, materials.permute(order)


SAND = Material(model=MaterialModel.DRUCKER_PRAGER, friction_angle=30.0, cohesion=7.0, density=1600.0)
METAL = Material(model=MaterialModel.VON_MISES, yield_stress=5e3, hardening_modulus=20.0, youngs_modulus=2e5)

BUILT = {
    MaterialModel.NEO_HOOKEAN: (m.NeoHookean, {}),
    MaterialModel.FIXED_COROTATED: (m.FixedCorotated, {}),
    MaterialModel.HENCKY: (m.Hencky, {}),
    MaterialModel.VON_MISES: (m.VonMises, {"yield_stress": 3.0, "hardening_modulus": 4.0}),
    MaterialModel.PLASTICINE: (m.Plasticine, {"yield_stress": 3.0, "softening_modulus": 4.0}),
    MaterialModel.DRUCKER_PRAGER: (m.DruckerPrager, {"friction_angle": 30.0, "cohesion": 4.0}),
    MaterialModel.BRITTLE: (m.Brittle, {"friction_angle": 30.0, "cohesion": 4.0}),
    MaterialModel.VISCOPLASTIC: (m.Viscoplastic, {"yield_stress": 3.0, "plastic_viscosity": 4.0}),
    MaterialModel.SNOW: (
        m.Snow,
        {
            "critical_compression": 0.1,
            "critical_stretch": 0.2,
            "hardening_coefficient": 3.0,
            "hardening_cap": 4.0,
        },
    ),
    MaterialModel.FLUID: (m.Fluid, {"bulk_modulus": 7.0, "tension": True}),
    MaterialModel.RIGID: (m.Rigid, {}),
    MaterialModel.STATIONARY: (m.Rigid, {}),
}
# Where our names for the user differ from the classes'.
ATTRIBUTES = {
    "hardening_modulus": "hardening",
    "softening_modulus": "softening",
    "hardening_coefficient": "hardening",
}


@pytest.mark.parametrize("model", MaterialModel)
def test_every_model_becomes_its_class_with_its_parameters(model):
    law, parameters = BUILT[model]
    material = Material(model=model, youngs_modulus=1e5, poissons_ratio=0.25, **parameters)
    (block,) = ParticleMaterials((material,), np.zeros(3, np.int32)).build_materials()
    assert isinstance(block, law) and block.count == 3
    if model not in (MaterialModel.FLUID, MaterialModel.RIGID, MaterialModel.STATIONARY):
        np.testing.assert_allclose(block.mu, 4e4, rtol=1e-6)  # E / 2.5
        np.testing.assert_allclose(block.lam, 4e4, rtol=1e-6)  # E nu / (1.25 * 0.5)
    for name, value in parameters.items():
        built = getattr(block, ATTRIBUTES.get(name, name))
        np.testing.assert_allclose(built, np.radians(value) if name == "friction_angle" else value, rtol=1e-6)


def test_regions_mix_models_and_the_later_one_wins():
    other = METAL.changed(yield_stress=9e3, density=50.0)
    materials = materials_of(Material(), (0.35, 0.5, SAND), (0.35, 0.43, METAL), (0.55, 0.65, other))
    order, sorted_materials = in_order(materials)
    elastic, metal, sand = sorted_materials.build_materials()
    assert [type(block) for block in (elastic, metal, sand)] == [m.NeoHookean, m.VonMises, m.DruckerPrager]
    assert (elastic.count, metal.count, sand.count) == (16, 32, 16)
    x = X[order][16:48, 0]  # the metal's particles lie at x = 0.4 and at x = 0.6
    np.testing.assert_allclose(metal.yield_stress, np.where(x < 0.5, 5e3, 9e3))
    np.testing.assert_allclose(sorted_materials.density[16:48], np.where(x < 0.5, 200.0, 50.0))
    np.testing.assert_allclose(materials.density, sorted_materials.density[np.argsort(order)])


def test_fluids_with_and_without_tension_are_two_blocks():
    water = Material(model=MaterialModel.FLUID, bulk_modulus=1e5)
    _, materials = in_order(materials_of(water, (0.35, 0.45, water.changed(tension=True, bulk_modulus=3e5))))
    loose, tight = materials.build_materials()
    assert (loose.count, loose.tension, tight.count, tight.tension) == (48, False, 16, True)
    np.testing.assert_allclose(tight.bulk_modulus, 3e5)


def test_viscosity_is_none_unless_something_is_viscous():
    assert materials_of(Material()).viscosity() is None
    assert materials_of(Material(viscosity=0.0), (0.35, 0.45, SAND)).viscosity() is None
    order, materials = in_order(materials_of(Material(), (0.35, 0.45, Material(viscosity=2.5))))
    np.testing.assert_allclose(materials.viscosity(), np.where(X[order][:, 0] < 0.45, 2.5, 0.0))


def test_stationary_particles_and_rigid_bodies_are_told_apart():
    rigid = Material(model=MaterialModel.RIGID)
    still = Material(model=MaterialModel.STATIONARY)
    order, materials = in_order(
        materials_of(Material(), (0.35, 0.42, rigid), (0.45, 0.5, still), (0.58, 0.7, rigid))
    )
    x = X[order][:, 0]
    np.testing.assert_array_equal(materials.find_stationary(), (x > 0.45) & (x < 0.5))
    (one, first), (other, second) = materials.find_rigid_bodies()
    assert (one, other) == (1, 3)
    np.testing.assert_array_equal(first, x < 0.42)
    np.testing.assert_array_equal(second, x > 0.58)
    assert (
        materials_of(Material()).find_rigid_bodies() == ()
        and not materials_of(Material()).find_stationary().any()
    )


def test_a_rigid_body_that_another_region_covers_is_no_body():
    rigid = Material(model=MaterialModel.RIGID)
    assert materials_of(rigid, (0.3, 0.7, SAND)).find_rigid_bodies() == ()


def test_a_region_without_particles_is_refused_by_its_place():
    with pytest.raises(UserError, match=r"`material_regions\[1\]` selects no particle"):
        materials_of(Material(), (0.35, 0.5, SAND), (0.8, 0.9, SAND))
