"""The material library on the command line."""

import dataclasses
import json

import pytest

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.run.material import AFFORDABLE, resolve_material
from physagent_jax.run.spec import MaterialChoice
from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.materials import LIBRARY, count_substeps, soften_material
from physagent_jax.scene.materials.soften import explain_softening
from physagent_jax.scene.presets import PRESETS, PresetName
from physagent_jax.scene.priors import choose_material

FAST = PRESETS[PresetName.FAST]


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")


def test_the_table_lists_every_material_with_its_price(capsys):
    assert main(["materials"]) == 0
    out = capsys.readouterr().out
    assert all(name in out for name in LIBRARY)
    assert "207 GPa" in out and "7850 kg/m\u00b3" in out
    steel = count_substeps(LIBRARY["steel"].material, FAST.domain.dx, 2.0)
    assert f"{steel:,}".replace(",", "\u202f") in out


def test_one_material_is_shown_with_its_sources(capsys):
    assert main(["materials", "wet-sand"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    sand = LIBRARY["wet_sand"]
    assert "friction angle 33\u00b0" in out and "cohesion 1 kPa" in out and "20 MPa" in out
    assert sand.source in out and "capillary" in out


def test_json_holds_what_a_scene_file_takes(capsys):
    assert main(["materials", "aluminum", "--json"]) == 0
    entry = json.loads(capsys.readouterr().out)
    assert entry["name"] == "aluminium" and entry["source"] == LIBRARY["aluminium"].source
    assert (
        type(LIBRARY["aluminium"].material).model_validate(entry["material"]) == LIBRARY["aluminium"].material
    )
    assert entry["substeps"] > 1e5 and 0 < entry["stable_step"] < 1e-5
    assert main(["materials", "--json"]) == 0
    assert [each["name"] for each in json.loads(capsys.readouterr().out)] == list(LIBRARY)


def test_an_unknown_name_is_answered_with_close_ones(capsys):
    assert main(["materials", "stell"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("physagent: ") and "steel" in error and "Traceback" not in error


# --- in a run -----------------------------------------------------------------------------------------


def chosen(kind="robot", **choice):
    return resolve_material(MaterialChoice(**choice), kind, FAST)


def test_without_options_the_kind_decides():
    assert chosen("sand") == (choose_material("sand"), ())


def test_a_named_material_is_taken_whole():
    material, warnings = chosen(name="natural rubber")
    assert material == LIBRARY["natural_rubber"].material and warnings == ()


def test_a_model_keeps_the_kinds_values():
    material, _ = chosen(name="fixed_corotated")
    prior = choose_material("robot")
    assert material.model is MaterialModel.FIXED_COROTATED
    assert (material.youngs_modulus, material.density) == (prior.youngs_modulus, prior.density)
    assert chosen("sand", name="hencky")[0].friction_angle is None
    with pytest.raises(UserError, match="`von_mises` needs `yield_stress`.*physagent materials"):
        chosen(name="von_mises")


def test_what_a_sentence_makes_it_of_is_not_much_softer_in_a_longer_clip():
    """Rubber of ten seconds was 25 times as soft as that of two, and sagged under its weight."""
    timing = FAST.timing.model_copy(update=dict(frame_count=5 * (FAST.timing.frame_count - 1) + 1))
    long = dataclasses.replace(FAST, timing=timing)
    presets = (
        resolve_material(MaterialChoice(), "robot", each, said="natural_rubber") for each in (FAST, long)
    )
    short, longer = (material.youngs_modulus for material, _ in presets)
    assert short / 6 < longer <= short


def test_options_overrule_single_values():
    material, _ = chosen(name="muscle", youngs_modulus=5e4, density=900.0)
    muscle = LIBRARY["muscle"].material
    assert (material.youngs_modulus, material.density) == (5e4, 900.0)
    assert material.poissons_ratio == muscle.poissons_ratio
    assert "youngs_modulus, density chosen" in material.reason and muscle.reason in material.reason


def test_a_stiff_material_is_warned_about_with_a_remedy_that_works():
    _, (warning,) = chosen(name="steel")
    assert "substeps" in warning
    factor = float(warning.split("`material.soften` ")[1].split()[0])
    material, warnings = chosen(name="steel", soften=factor)
    assert warnings == () and count_substeps(material, FAST.domain.dx, 1.96) <= AFFORDABLE
    steel = LIBRARY["steel"].material
    assert material.yield_stress / material.youngs_modulus == pytest.approx(
        steel.yield_stress / steel.youngs_modulus
    )
    assert chosen(name="steel", soften="auto")[0] == material


def test_auto_softening_leaves_affordable_materials_alone():
    assert chosen(name="gelatine", soften="auto")[0] == LIBRARY["gelatine"].material


def test_softening_that_shows_is_among_the_warnings():
    gel = LIBRARY["gelatine"].material
    _, (warning,) = chosen(name="gelatine", soften=5.0)
    load = gel.density * 9.80665
    assert f"strains it by {100 * 5 * load / gel.youngs_modulus:.2g} %" in warning and "5 times" in warning
    _, (warning,) = chosen(name="lead", soften=1000.0)
    assert "makes it yield" in warning
    assert chosen(name="gelatine", soften=1.01)[1] == ()  # a strain of 0.2 % more


def test_softening_a_liquid_is_measured_by_its_compression():
    water = LIBRARY["water"].material
    load = water.density * 9.80665
    factor = 0.03 * water.bulk_modulus / load  # its own weight then compresses a column of a metre by 3 %
    assert "3 %" in (explain_softening(water, soften_material(water, factor)) or "")
    assert explain_softening(water, soften_material(water, factor / 10)) is None
    assert explain_softening(water, soften_material(water, factor / 10), length=10.0) is not None


def test_a_prediction_replaces_the_kinds_prior(tmp_path):
    path = tmp_path / "predicted_phys.json"
    path.write_text(json.dumps({"E": 3.0e5, "nu": 0.6, "material": "Foam"}))
    material, warnings = chosen(physgm=str(path))
    assert (material.youngs_modulus, material.poissons_ratio) == (3.0e5, 0.49)
    assert material.density == LIBRARY["pu_foam"].material.density
    assert len(warnings) == 1 and "nu = 0.6" in warnings[0]
    with pytest.raises(ValueError, match="`physgm` and `name`"):
        chosen(physgm=str(path), name="steel")


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (["--material", "unobtainium"], "no such material"),
        (["--material", "von_mise"], "von_mises"),
        (["--soften", "0.5"], "at least 1"),
        (["--physgm", "nowhere.json"], "nowhere.json"),
    ],
)
def test_bad_choices_are_one_line_and_leave_nothing(options, fragment, tmp_path, robot_path, capsys):
    out = tmp_path / "run"
    arguments = ["run", "--object", str(robot_path), "--prompt", "push it left", "--out", str(out), *options]
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert "physagent: " in error and fragment in error and "Traceback" not in error
    assert not out.exists()
