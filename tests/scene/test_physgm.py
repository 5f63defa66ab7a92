import json

import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.materials import LIBRARY
from physagent_jax.scene.physgm import CLASSES, decode_poissons_ratio, decode_youngs_modulus, import_physgm


def test_the_decoding_is_physgms():
    """Values worked out by hand: 10^7.38721 = 2.4390e7, and one standard deviation is a factor 10^2.456477 = 286.07."""
    assert decode_youngs_modulus(0.0) == pytest.approx(2.4390e6, rel=1e-4)
    assert decode_youngs_modulus(1.0) / decode_youngs_modulus(0.0) == pytest.approx(286.07, rel=1e-4)
    assert decode_poissons_ratio(0.0) == 0.398
    assert decode_poissons_ratio(-2.0) == pytest.approx(0.176)


def test_the_file_that_physgm_writes():
    written = json.loads('{\n    "E": 2439000.0,\n    "nu": 0.398,\n    "material": "Rubber"\n}')
    material, warnings = import_physgm(written)
    assert warnings == []
    assert (material.youngs_modulus, material.poissons_ratio) == (2439000.0, 0.398)
    rubber = LIBRARY["natural_rubber"].material
    assert (material.model, material.density) == (rubber.model, rubber.density)
    assert "Rubber" in material.reason and "natural_rubber" in material.reason


def test_the_networks_outputs_give_the_same_material_as_the_file():
    logits = [0.0] * 14
    logits[9] = 3.0
    raw, _ = import_physgm({"E_mu": 0.5, "nu_mu": -1.0, "phys_logits": logits})
    named, _ = import_physgm({"E_mu": 0.5, "nu_mu": -1.0, "material": "Paper"})
    file, _ = import_physgm(
        {"E": decode_youngs_modulus(0.5), "nu": decode_poissons_ratio(-1.0), "material": "Paper"}
    )
    assert raw == named == file


@pytest.mark.parametrize(
    ("name", "model"),
    [
        ("Wood", MaterialModel.NEO_HOOKEAN),
        ("Metal", MaterialModel.VON_MISES),
        ("Sand", MaterialModel.DRUCKER_PRAGER),
        ("Snow", MaterialModel.SNOW),
        ("Plasticine", MaterialModel.PLASTICINE),
        ("Foam", MaterialModel.NEO_HOOKEAN),
    ],
)
def test_classes_get_their_laws(name, model):
    assert import_physgm({"E": 1e6, "nu": 0.3, "material": name})[0].model is model


def test_there_are_physgms_fourteen_classes():
    assert len(CLASSES) == 14 and list(CLASSES)[8] == "Rubber" and set(CLASSES.values()) <= LIBRARY.keys()


def test_strength_follows_the_predicted_stiffness_with_the_strain_at_yield():
    metal, _ = import_physgm({"E": 1e7, "nu": 0.3, "material": "Metal"})
    steel = LIBRARY["steel"].material
    assert metal.yield_stress / metal.youngs_modulus == pytest.approx(
        steel.yield_stress / steel.youngs_modulus
    )
    assert metal.density == steel.density


@pytest.mark.parametrize(("nu", "taken"), [(0.62, 0.49), (0.4999, 0.49), (-0.1, 0.0)])
def test_nu_is_clipped_with_a_warning(nu, taken):
    material, warnings = import_physgm({"E": 1e6, "nu": nu, "material": "Rubber"})
    assert material.poissons_ratio == taken
    assert len(warnings) == 1 and f"{nu:g}" in warnings[0] and f"{taken:g}" in warnings[0]


def test_a_stiffness_that_cannot_be_simulated_is_told():
    (stiff,) = import_physgm({"E": 7e11, "nu": 0.3, "material": "Wood"})[1]
    assert "substeps" in stiff and "so stiff" in stiff and " Pa" not in stiff
    assert import_physgm({"E": 7e11, "nu": 0.3, "material": "Wood"}, warn_of_cost=False)[1] == []
    (limp,) = import_physgm({"E": 50.0, "nu": 0.3, "material": "Rubber"})[1]
    assert "collapse" in limp


def test_an_unknown_class_is_rubber_as_in_physgm():
    material, (warning,) = import_physgm({"E": 1e6, "nu": 0.3, "material": "Unknown"})
    assert material.model is LIBRARY["natural_rubber"].material.model and "'Unknown'" in warning


@pytest.mark.parametrize(
    ("data", "fragment"),
    [
        ([1], "JSON object"),
        ({}, "`E` is missing"),
        ({"E": 1e6, "material": "Wood"}, "`nu` is missing"),
        ({"E": "soft", "nu": 0.3, "material": "Wood"}, "`E` must be a finite number"),
        ({"E": True, "nu": 0.3, "material": "Wood"}, "`E` must be a finite number"),
        ({"E": -1.0, "nu": 0.3, "material": "Wood"}, "positive"),
        ({"E": 1e6, "nu": 0.3}, "class name"),
        ({"E_mu": 0.0, "nu_mu": 0.0, "phys_logits": [1.0]}, "14 numbers"),
        ({"E_mu": 0.0}, "`nu_mu` is missing"),
        ({"E_mu": 200.0, "nu_mu": 0.0, "material": "Wood"}, "finite"),
    ],
)
def test_broken_predictions_name_the_key(data, fragment):
    with pytest.raises(UserError, match=fragment):
        import_physgm(data)


@pytest.mark.parametrize(
    "value", [10**400, 1e300, -1e300, 1e-300, [], "x" * 5000, None, True], ids=lambda v: str(v)[:9]
)
@pytest.mark.parametrize("key", ["E", "nu", "material", "E_mu", "nu_mu", "phys_logits"])
def test_any_value_of_any_key_is_read_or_refused_in_one_line(key, value):
    for data in (
        {"E": 1e6, "nu": 0.3, "material": "Rubber"},
        {"E_mu": 0.1, "nu_mu": 0.1, "phys_logits": [1.0] * 14},
    ):
        try:
            material, warnings = import_physgm(data | {key: value})
        except UserError as error:
            assert "\n" not in str(error) and len(str(error)) < 400
        else:
            assert 1e-3 <= material.youngs_modulus <= 1e13
            assert all(len(warning) < 400 for warning in warnings)
