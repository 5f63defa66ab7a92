"""Sand, soil, clay and snow."""

from __future__ import annotations

from physagent_jax.scene.config.material import MaterialModel
from physagent_jax.scene.materials.entry import make_entry

_BOWLES = "Bowles, Foundation Analysis and Design, 5th ed. 1996"
_TERZAGHI = "Terzaghi, Peck & Mesri, Soil Mechanics in Engineering Practice, 3rd ed. 1996"
_STOMAKHIN = "Stomakhin et al. 2013, ACM Trans. Graph. 32, 102"
_DENSITY = "Cuffey & Paterson, The Physics of Glaciers, 4th ed. 2010 (density)"
_EFFECTIVE = (
    "Effective values of a simulation, chosen to look right; the elastic modulus of real snow is higher."
)
_SAND = "The stiffness hardly shows: Klar et al. 2016 simulate sand with 0.35 MPa."

SAND, SNOW = MaterialModel.DRUCKER_PRAGER, MaterialModel.SNOW

GRANULAR = (
    make_entry(
        "dry_sand", "loose to medium dry sand", SAND,
        youngs_modulus=20e6, poissons_ratio=0.3, density=1600.0, friction_angle=33.0, cohesion=0.0,
        source=f"{_BOWLES} (E); {_TERZAGHI} (friction)", aliases=("sand",),
        notes="10 to 25 MPa loose, 50 to 80 dense; 28 (round, loose) to 45 degrees (angular, dense). " + _SAND,
    ),
    make_entry(
        "wet_sand", "moist sand, held together by capillary bridges", SAND,
        youngs_modulus=20e6, poissons_ratio=0.3, density=1800.0, friction_angle=33.0, cohesion=1e3,
        source="Richefeu et al. 2006, Phys. Rev. E 73, 051304; Lu & Likos, Unsaturated Soil Mechanics, 2004",
        notes="Cohesion of some hundred Pa for coarse and a few kPa for fine sand, little affected by how much water; "
        "1 kPa is between. Under water it is gone. " + _SAND,
    ),
    make_entry(
        "soil", "firm clayey soil", SAND,
        youngs_modulus=20e6, poissons_ratio=0.3, density=1800.0, friction_angle=25.0, cohesion=10e3,
        source=f"{_BOWLES}; Wood, Soil Behaviour and Critical State Soil Mechanics, 1990", aliases=("earth", "dirt"),
        notes="15 to 50 MPa, 20 to 30 degrees, 5 to 25 kPa.",
    ),
    make_entry(
        "wet_clay", "soft saturated clay, as for pottery", MaterialModel.VON_MISES,
        youngs_modulus=5e6, poissons_ratio=0.45, density=1850.0, yield_stress=40e3,
        source=f"{_TERZAGHI} (soft clay); {_BOWLES} (E)", aliases=("clay",),
        notes="Unconfined compressive strength of soft clay: 25 to 50 kPa, which is its uniaxial yield stress when "
        "water cannot drain; 5 to 25 MPa.",
    ),
    make_entry(
        "plasticine", "oil-based modelling clay", MaterialModel.PLASTICINE,
        youngs_modulus=3e6, poissons_ratio=0.45, density=1700.0, yield_stress=0.15e6, softening_modulus=0.0,
        source="Green 1951, Phil. Mag. 42, 365; Sofuoglu & Rasty 2000, Tribology International 33, 523",
        aliases=("modelling_clay", "modeling_clay"),
        notes="Flows at 0.1 to 0.3 MPa with temperature and rate; E and density vary as widely with the make. It does "
        "not soften here: set `softening_modulus` to let it tear.",
    ),
    make_entry(
        "fresh_snow", "dry new snow", SNOW,
        youngs_modulus=4.8e4, poissons_ratio=0.2, density=100.0, critical_compression=1.9e-2, critical_stretch=5e-3,
        hardening_coefficient=5.0,
        source=f"{_STOMAKHIN}, their low values; {_DENSITY}", aliases=("powder_snow",),
        notes="50 to 70 kg/m^3 right after falling, 100 to 200 if damp. " + _EFFECTIVE,
    ),
    make_entry(
        "packed_snow", "wind-packed or trodden snow", SNOW,
        youngs_modulus=1.4e5, poissons_ratio=0.2, density=400.0, critical_compression=2.5e-2, critical_stretch=7.5e-3,
        hardening_coefficient=10.0,
        source=f"{_STOMAKHIN}, table 2; {_DENSITY}", aliases=("snow",),
        notes="350 to 400 kg/m^3. " + _EFFECTIVE,
    ),
)  # fmt: skip
