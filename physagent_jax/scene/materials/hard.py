"""Metals, stone, glass, wood and plastics at room temperature. All of them are stiff: see `soften`."""

from __future__ import annotations

from physagent_jax.scene.config.material import MaterialModel
from physagent_jax.scene.materials.entry import make_entry

ASHBY = "Ashby, Materials Selection in Mechanical Design, 4th ed. 2011, appendix A"
CALLISTER = "Callister & Rethwisch, Materials Science and Engineering, appendix B"
WOOD_HANDBOOK = "Forest Products Laboratory, Wood Handbook FPL-GTR-190, 2010, ch. 5"
_HARDENING = "The hardening modulus joins yield and ultimate (true) stress by a line."
_BRITTLE = "Breaks rather than yields, which is not modelled."
_GRAIN = "Isotropic here with the stiffness along the grain; across it, wood is 10 to 20 times softer."

METAL, ELASTIC = MaterialModel.VON_MISES, MaterialModel.NEO_HOOKEAN

HARD = (
    make_entry(
        "steel", "low-carbon steel AISI 1020, hot rolled", METAL,
        youngs_modulus=207e9, poissons_ratio=0.30, density=7850.0, yield_stress=210e6, hardening_modulus=1.3e9,
        source=CALLISTER, aliases=("iron",),
        notes="Yields from 210 (hot rolled) to 1500 MPa (hardened alloys); ultimate stress 380 MPa. " + _HARDENING,
    ),
    make_entry(
        "aluminium", "alloy 6061-T6", METAL,
        youngs_modulus=69e9, poissons_ratio=0.33, density=2700.0, yield_stress=276e6, hardening_modulus=0.68e9,
        source=CALLISTER, aliases=("aluminum",),
        notes="Yields from 34 (pure, annealed) to 500 MPa (7075-T6); ultimate stress 310 MPa. " + _HARDENING,
    ),
    make_entry(
        "copper", "electrolytic tough pitch copper C11000, hot rolled", METAL,
        youngs_modulus=115e9, poissons_ratio=0.33, density=8890.0, yield_stress=69e6, hardening_modulus=0.83e9,
        source=CALLISTER,
        notes="Yields at 69 (hot rolled) to 310 MPa (cold worked); ultimate stress 220 MPa. " + _HARDENING,
    ),
    make_entry(
        "lead", "chemical lead", METAL,
        youngs_modulus=13.5e9, poissons_ratio=0.44, density=11340.0, yield_stress=7e6, hardening_modulus=60e6,
        source=CALLISTER,
        notes="Yields at 6 to 8 MPa and creeps at room temperature, which is not modelled. " + _HARDENING,
    ),
    make_entry(
        "glass", "soda-lime glass", ELASTIC,
        youngs_modulus=69e9, poissons_ratio=0.23, density=2500.0,
        source=CALLISTER,
        notes="68 to 72 GPa. " + _BRITTLE + " Strain at break is near 0.1 %.",
    ),
    make_entry(
        "porcelain", "vitrified porcelain, mullite body", ELASTIC,
        youngs_modulus=69e9, poissons_ratio=0.2, density=2400.0,
        source="Kingery, Bowen & Uhlmann, Introduction to Ceramics, 2nd ed. 1976", aliases=("ceramic",),
        notes="50 to 110 GPa with porosity and body; earthenware is half as stiff. " + _BRITTLE,
    ),
    make_entry(
        "alumina", "technical ceramic, 99.9 % Al2O3", ELASTIC,
        youngs_modulus=380e9, poissons_ratio=0.22, density=3980.0,
        source=CALLISTER,
        notes="215 to 413 GPa with purity and porosity. " + _BRITTLE,
    ),
    make_entry(
        "concrete", "plain concrete", ELASTIC,
        youngs_modulus=30e9, poissons_ratio=0.20, density=2400.0,
        source=CALLISTER,
        notes="25.4 to 36.6 GPa. " + _BRITTLE + " Its strength is 3 MPa in tension and ten times that in compression.",
    ),
    make_entry(
        "granite", "sound granite", ELASTIC,
        youngs_modulus=52e9, poissons_ratio=0.25, density=2700.0,
        source="Engineering ToolBox, Young's Modulus; Gere & Goodno, Mechanics of Materials, appendix I",
        aliases=("stone", "rock"),
        notes="40 to 100 GPa, nu 0.2 to 0.3, 2640 to 2880 kg/m^3. " + _BRITTLE,
    ),
    make_entry(
        "ice", "polycrystalline ice at -16 C", ELASTIC,
        youngs_modulus=9.33e9, poissons_ratio=0.325, density=917.0,
        source="Gammon et al. 1983, J. Glaciology 29, 433",
        notes="Dynamic modulus; under slow loads ice creeps and seems softer. " + _BRITTLE,
    ),
    make_entry(
        "oak", "white oak at 12 % moisture, along the grain", ELASTIC,
        youngs_modulus=12.3e9, poissons_ratio=0.37, density=760.0,
        source=WOOD_HANDBOOK, aliases=("wood",),
        notes="Oaks: 9 to 15 GPa. " + _GRAIN,
    ),
    make_entry(
        "pine", "ponderosa pine at 12 % moisture, along the grain", ELASTIC,
        youngs_modulus=8.9e9, poissons_ratio=0.34, density=450.0,
        source=WOOD_HANDBOOK,
        notes="Pines: 8 to 14 GPa, 390 to 600 kg/m^3. " + _GRAIN,
    ),
    make_entry(
        "abs", "acrylonitrile butadiene styrene, moulded", METAL,
        youngs_modulus=2.3e9, poissons_ratio=0.39, density=1050.0, yield_stress=40e6,
        source=f"{ASHBY}; Engineering ToolBox, Young's Modulus", aliases=("plastic",),
        notes="1.1 to 2.9 GPa, yields at 18 to 51 MPa, 1010 to 1210 kg/m^3; nu as usual for stiff polymers.",
    ),
    make_entry(
        "nylon", "polyamide 6,6, dry", METAL,
        youngs_modulus=2.7e9, poissons_ratio=0.39, density=1140.0, yield_stress=60e6,
        source=CALLISTER, aliases=("polyamide",),
        notes="1.6 to 3.8 GPa, yields at 45 to 83 MPa; moisture lowers both.",
    ),
    make_entry(
        "pet", "polyethylene terephthalate", METAL,
        youngs_modulus=3.0e9, poissons_ratio=0.33, density=1350.0, yield_stress=59e6,
        source=CALLISTER,
        notes="2.8 to 4.1 GPa, yields at 57 to 62 MPa.",
    ),
)  # fmt: skip
