"""Liquids at 20 C, and pastes that stand until they are pushed."""

from __future__ import annotations

from physagent_jax.scene.config.material import MaterialModel
from physagent_jax.scene.materials.entry import make_entry

_CRC = "CRC Handbook of Chemistry and Physics"
_SOUND = "K = rho c^2 with a speed of sound of"
_PASTE = "The uniaxial yield stress is sqrt(3) times the one in shear, `plastic_viscosity` twice Bingham's viscosity."
_REGULARISED = (
    "E is not a measured value: it lets the paste yield at a strain of about 1 %. Shear thinning is left out."
)

FLUID, PASTE = MaterialModel.FLUID, MaterialModel.VISCOPLASTIC

LIQUIDS = (
    make_entry(
        "water", "fresh water", FLUID,
        density=998.0, bulk_modulus=2.19e9, viscosity=1.0e-3,
        source=_CRC,
        notes=f"{_SOUND} 1482 m/s. What is seen does not depend on K while c is 10 times the speed of the flow.",
    ),
    make_entry(
        "olive_oil", "olive oil", FLUID,
        density=913.0, bulk_modulus=1.89e9, viscosity=0.084,
        source=f"{_CRC} (viscosity); Kaye & Laby, Tables of Physical and Chemical Constants (sound)", aliases=("oil",),
        notes=f"{_SOUND} 1440 m/s. Halves its viscosity with every 16 degrees.",
    ),
    make_entry(
        "glycerol", "pure glycerol", FLUID,
        density=1261.0, bulk_modulus=4.57e9, viscosity=1.41,
        source=f"{_CRC}; Segur & Oberstar 1951, Ind. Eng. Chem. 43, 2117 (viscosity)", aliases=("glycerine",),
        notes=f"{_SOUND} 1904 m/s. One per cent of water lowers the viscosity by a fifth.",
    ),
    make_entry(
        "honey", "liquid honey of 17 % water", FLUID,
        density=1420.0, bulk_modulus=4.6e9, viscosity=10.0,
        source="White 1975, Physical Characteristics of Honey, in Crane (ed.), Honey: A Comprehensive Survey",
        aliases=("syrup",),
        notes="2 to 20 Pa s with water and temperature. K is that of glycerol, which is of the same sort.",
    ),
    make_entry(
        "molten_chocolate", "tempered milk chocolate", PASTE,
        youngs_modulus=0.13e6, poissons_ratio=0.49, density=1270.0, yield_stress=62.5, plastic_viscosity=17.4,
        source="Bergemann et al. 2018, J. Rheology 62, 1187", aliases=("chocolate",),
        notes="Shear modulus 44 kPa, yield stress in shear 36 Pa, viscosity 8.7 Pa s. " + _PASTE,
    ),
    make_entry(
        "toothpaste", "toothpaste", PASTE,
        youngs_modulus=30e3, poissons_ratio=0.495, density=1300.0, yield_stress=350.0, plastic_viscosity=20.0,
        source="Barnes 1999, J. Non-Newtonian Fluid Mechanics 81, 133; Steffe, Rheological Methods, 2nd ed. 1996",
        notes="Yield stress in shear 20 to 350 Pa, here 200; viscosity of the order of 10 Pa s. "
        f"{_PASTE} {_REGULARISED}",
    ),
    make_entry(
        "mud", "thick mud", PASTE,
        youngs_modulus=30e3, poissons_ratio=0.495, density=1600.0, yield_stress=170.0, plastic_viscosity=4.0,
        source="Coussot, Mudflow Rheology and Dynamics, 1997",
        notes=f"Yield stress in shear 10 to 1000 Pa with the solids, here 100; viscosity 0.1 to 10 Pa s. {_PASTE} "
        f"{_REGULARISED}",
    ),
)  # fmt: skip
