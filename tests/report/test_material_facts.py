"""The report says what acts in a material of any model."""

import re

import pytest

from physagent_jax.report.facts import describe_property, make_scene_facts
from physagent_jax.scene.config import Material, MaterialModel, MaterialRegion, SceneConfig, Source
from physagent_jax.scene.materials import LIBRARY


def page_text(scene):
    """The facts without markup."""
    return " ".join(
        re.sub(r"<[^>]+>", " ", "".join(str(part) for part in make_scene_facts(scene, None))).split()
    )


def scene_of(material, *regions):
    boxes = tuple(MaterialRegion(point=(1, 1, 1), half_size=(1, 1, 1), material=each) for each in regions)
    return SceneConfig(source=Source(path="x.ply"), material=material, material_regions=boxes)


@pytest.mark.parametrize(
    ("name", "said", "unsaid"),
    [
        ("steel", ["von mises", "modulus 207 GPa", "yield stress 210 MPa", "hardening modulus 1.3 GPa"], []),
        ("wet_sand", ["drucker prager", "friction angle 33\u00b0", "cohesion 1 kPa"], ["yield"]),
        (
            "honey",
            ["fluid", "bulk modulus 4.6 GPa", "viscosity 10 Pa s", "bears tension no"],
            ["Young", "Poisson"],
        ),
        ("packed_snow", ["snow", "critical compression 0.025", "hardening cap 20"], ["viscosity"]),
    ],
)
def test_models_are_told_with_their_own_properties(name, said, unsaid):
    text = page_text(scene_of(LIBRARY[name].material))
    material = text[text.index("Material") : text.index("World")]
    assert all(words in material for words in said), material
    assert not any(word in material for word in unsaid), material


def test_regions_tell_theirs_in_one_cell():
    still = Material(model=MaterialModel.STATIONARY, density=70.0)
    text = page_text(scene_of(Material(), LIBRARY["plasticine"].material, still))
    assert "yield stress 150 kPa, softening modulus 0" in text
    assert "stationary density 70 kg/m\u00b3 \u2014" in text


def test_properties_in_words():
    assert describe_property(True, "") == "yes" and describe_property(0.3, "") == "0.3"
    assert (
        describe_property(1e-3, "Pa s") == "1 mPa s"
        and describe_property(7850.0, "kg/m\u00b3") == "7850 kg/m\u00b3"
    )
