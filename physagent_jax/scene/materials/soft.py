"""Rubbers, foams, sheets, gels, food and tissue."""

from __future__ import annotations

from physagent_jax.scene.materials.entry import make_entry
from physagent_jax.scene.materials.hard import ASHBY, ELASTIC, METAL

_SILICONE = (
    "E from the stress at 100 % strain of a neo-Hookean, 12/7 of it. nu is 0.499 or more; 0.49 costs less "
    "and changes the volume by a few per cent at most."
)
_GEL = "nu is 0.499 or more; 0.49 costs less."

SOFT = (
    make_entry(
        "natural_rubber", "vulcanised natural rubber, unfilled", ELASTIC,
        youngs_modulus=2.0e6, poissons_ratio=0.49, density=930.0,
        source=ASHBY, aliases=("rubber",),
        notes="1.5 to 2.5 MPa; filled tyre rubber up to 10 MPa. " + _GEL,
    ),
    make_entry(
        "ecoflex", "silicone rubber Ecoflex 00-30", ELASTIC,
        youngs_modulus=0.118e6, poissons_ratio=0.49, density=1070.0,
        source="Smooth-On, technical bulletin of Ecoflex (10 psi at 100 % strain)", aliases=("silicone",),
        notes=_SILICONE,
    ),
    make_entry(
        "dragon_skin", "silicone rubber Dragon Skin 30", ELASTIC,
        youngs_modulus=1.02e6, poissons_ratio=0.49, density=1080.0,
        source="Smooth-On, technical bulletin of Dragon Skin (86 psi at 100 % strain)",
        notes=_SILICONE,
    ),
    make_entry(
        "pu_foam", "flexible polyurethane foam of upholstery, 35 kg/m^3", ELASTIC,
        youngs_modulus=38e3, poissons_ratio=0.33, density=35.0,
        source="Gibson & Ashby, Cellular Solids, 2nd ed. 1997", aliases=("foam", "upholstery"),
        notes="E = 45 MPa (35 / 1200)^2, their law of open cells; measured foams: 20 to 100 kPa. Its buckling plateau "
        "is not modelled.",
    ),
    make_entry(
        "cork", "natural cork", ELASTIC,
        youngs_modulus=13e6, poissons_ratio=0.05, density=170.0,
        source="Gibson, Easterling & Ashby 1981, Proc. R. Soc. A 377, 99",
        notes="13 MPa along and around the trunk, 20 MPa radially; nu is near 0. Its buckling plateau is not modelled.",
    ),
    make_entry(
        "leather", "tanned leather", ELASTIC,
        youngs_modulus=0.2e9, poissons_ratio=0.4, density=900.0,
        source=ASHBY,
        notes="0.1 to 0.5 GPa, 810 to 1050 kg/m^3. As a thin sheet it is bent far more easily than a solid of it.",
    ),
    make_entry(
        "cardboard", "paper and cardboard, in its plane", METAL,
        youngs_modulus=3.0e9, poissons_ratio=0.3, density=600.0, yield_stress=20e6,
        source=ASHBY, aliases=("paper",),
        notes="3 to 9 GPa, yields at 15 to 34 MPa, 480 to 860 kg/m^3; across its plane it is 100 times softer.",
    ),
    make_entry(
        "cotton_fabric", "plain weave, along the yarns", ELASTIC,
        youngs_modulus=50e6, poissons_ratio=0.2, density=400.0,
        source="Morton & Hearle, Physical Properties of Textile Fibres, 4th ed. 2008 (fibres: 5 to 11 GPa)",
        aliases=("cotton", "cloth", "fabric"),
        notes="An estimate: the crimp of the yarns leaves some per cent of the fibres' stiffness, 10 to 300 MPa with "
        "weave and load. Cloth bends and shears far more easily than any solid, which is not modelled.",
    ),
    make_entry(
        "bread_crumb", "crumb of white bread", ELASTIC,
        youngs_modulus=8e3, poissons_ratio=0.2, density=220.0,
        source="Scanlon & Zghal 2001, Food Research International 34, 841", aliases=("bread",),
        notes="7 to 50 kPa with strain and method, 100 to 300 kg/m^3; nu as of open foams.",
    ),
    make_entry(
        "gelatine", "gelatine gel of 10 % at room temperature", ELASTIC,
        youngs_modulus=63e3, poissons_ratio=0.49, density=1030.0,
        source="Nguyen et al. 2014, Ultrasound in Medicine & Biology 40, 168", aliases=("gelatin", "jelly"),
        notes="Measured up to 7 % (shear modulus 10.2 kPa) and continued with the square of the content. Table jelly "
        "has 2 to 4 % and 2 to 10 kPa. " + _GEL,
    ),
    make_entry(
        "agar", "agar gel of 2 %", ELASTIC,
        youngs_modulus=150e3, poissons_ratio=0.49, density=1010.0,
        source="Oyen 2014, International Materials Reviews 59, 44 (a compilation)",
        notes="Published values of agar spread from 30 to 700 kPa between 0.5 and 5 %. Brittle; not modelled. " + _GEL,
    ),
    make_entry(
        "muscle", "skeletal muscle at rest, across the fibres", ELASTIC,
        youngs_modulus=12e3, poissons_ratio=0.49, density=1060.0,
        source="Engler et al. 2006, Cell 126, 677; Mendez & Keys 1960, Metabolism 9, 184 (density)",
        aliases=("flesh", "meat"),
        notes="8 to 17 kPa; along the fibres and when tensed, ten times more. " + _GEL,
    ),
)  # fmt: skip
