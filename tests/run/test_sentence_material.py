"""The material that a sentence chooses, against the user's, in plan and run, and in what a run leaves."""

import json

import pytest

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.api import build_scene, load_object
from physagent_jax.cli import main
from physagent_jax.report.html import write_report
from physagent_jax.run.material import resolve_material
from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import MaterialChoice, RunSpec
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import MaterialModel, SceneConfig
from physagent_jax.scene.materials import find_material
from physagent_jax.scene.presets import PRESETS
from physagent_jax.scene.priors import PRIORS, choose_damping_ratio, choose_material
from tests.run.specs import made, small, with_rules

JELLY = "push the robot made of jelly to the left"


@pytest.fixture(scope="module")
def body(robot_path):
    template = resolve(small(robot_path)).template
    return make_body(template.source, template.preset.filling, template.preset.domain, ".")


def place(robot_path, body, prompt, **parts):
    """Template, notes and the reply of a sentence."""
    run = resolve(small(robot_path, prompt, **parts))
    reply = read_for_scene(run, body, with_rules().semantic.compile).value
    template, notes = run.place(body, reply)
    return template, reply, [*reply.notes, *notes]


def test_the_sentence_chooses_where_nobody_did(robot_path, body):
    template, reply, notes = place(robot_path, body, JELLY)
    assert reply.materials == ("jelly",) and not reply.unsure
    prior = choose_material("jelly")
    assert template.material.model is prior.model
    assert template.material.youngs_modulus == prior.youngs_modulus != choose_material("robot").youngs_modulus
    assert template.material.reason.startswith("'made of jelly' in the sentence")
    assert template.damping_ratio == choose_damping_ratio("jelly") and template.damping_kind == "jelly"
    assert "material: jelly, by 'made of jelly' in the sentence; --material overrides" in notes
    (evidence,) = [each for each in reply.evidence if each.field == "material"]
    assert (evidence.words, evidence.value) == ("made of jelly", "jelly")


def test_without_such_words_nothing_changes(robot_path, body):
    template, reply, _ = place(robot_path, body, "push the robot to the left")
    assert reply.materials == () and template.material == resolve(small(robot_path)).template.material


def test_the_users_choice_goes_first_with_a_note(robot_path, body):
    template, _, notes = place(robot_path, body, JELLY, material={"name": "cork"})
    assert template.material.youngs_modulus == find_material("cork").material.youngs_modulus
    assert "the sentence says 'made of jelly', but cork is chosen for the run: that stays" in notes


def test_the_same_choice_twice_needs_no_note(robot_path, body):
    sentence = "push the rubber robot to the left"
    for name in ("rubber", "natural rubber", "natural_rubber"):
        _, _, notes = place(robot_path, body, sentence, material={"name": name})
        assert not any("stays" in note for note in notes)


def test_single_values_of_the_user_hold_over_the_sentences_material(robot_path, body):
    template, _, _ = place(robot_path, body, JELLY, material={"density": 333.0})
    assert template.material.density == 333.0
    assert template.material.youngs_modulus == choose_material("jelly").youngs_modulus


def test_a_true_material_is_softened_until_a_round_is_affordable(robot_path, body):
    template, _, notes = place(robot_path, body, "push the granite robot to the left")
    true = find_material("granite").material
    assert template.material.density == true.density
    assert 1e6 < template.material.youngs_modulus < true.youngs_modulus / 10
    assert "times as soft" in template.material.reason
    kept, _, _ = place(robot_path, body, "push the granite robot to the left", material={"soften": 1.0})
    assert kept.material.youngs_modulus == true.youngs_modulus


@pytest.mark.parametrize(
    ("prompt", "note"),
    [
        (
            "push the robot made of crumb to the left",
            "no material stands for 'crumb' in 'made of crumb', so that it is not used: "
            "--material bread_crumb is the nearest",
        ),
        (
            "push the metal robot made of jelly to the left",
            "the sentence names several materials ('metal robot' and 'made of jelly') and an object has one: its "
            "kind's stays; --material chooses one",
        ),
    ],
)
def test_what_is_not_used_is_told(robot_path, body, prompt, note):
    template, _, notes = place(robot_path, body, prompt)
    assert note in notes
    assert template.material.youngs_modulus == resolve(small(robot_path)).template.material.youngs_modulus


def test_the_nearest_material_is_called_so(robot_path, body):
    _, _, notes = place(robot_path, body, "push the robot made of gold to the left")
    told = "material: copper, the nearest to 'gold' that there is, by 'made of gold' in the sentence"
    assert any(note.startswith(told) for note in notes)


def test_a_material_that_it_becomes_is_there_from_the_first_frame(robot_path, body):
    reply = SemanticReply.model_validate(
        {"force_field": {"default_drop": True}, "materials": ["sand"], "expectations": []}
    )
    run = resolve(small(robot_path, "it turns to sand and falls"))
    assert run.place(body, reply)[0].material.model is MaterialModel.DRUCKER_PRAGER
    told = read_for_scene(run, body, with_rules().semantic.compile).value
    assert any("in the sentence from the first frame on" in note for note in told.notes)


def test_a_word_of_the_objects_name_chooses_what_is_made_for_visible_motion(tmp_path, robot_path):
    """A duck of sand is sand; a porcelain doll keeps the stiffness of dolls unless somebody asks for porcelain."""
    for name, expected in (("sand duck", MaterialModel.DRUCKER_PRAGER), ("porcelain duck", None)):
        path = tmp_path / f"{name.replace(' ', '_')}.ply"
        path.write_bytes(robot_path.read_bytes())
        run = resolve(small(path, f"push the {name} to the left"))
        template = run.template
        loaded = make_body(template.source, template.preset.filling, template.preset.domain, ".")
        reply = read_for_scene(run, loaded, with_rules().semantic.compile).value
        chosen = run.place(loaded, reply)[0].material
        if expected is None:
            assert chosen.model is choose_material("animal").model
            assert any("belongs to the object's name" in note for note in reply.notes)
            assert any("--material porcelain chooses it" in note for note in reply.notes)
        else:
            assert chosen.model is expected


def test_words_of_a_model_that_are_not_in_the_sentence_stand_for_themselves(robot_path, body):
    reply = SemanticReply.model_validate({"force_field": {}, "materials": ["Snow", "snow"]})
    run = resolve(small(robot_path, "push the robot"))
    assert run.place(body, reply)[0].material.model is MaterialModel.SNOW
    assert run.find_material(reply).phrase == "snow"


# --- end to end ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def finished(tmp_path_factory, robot_path):
    spec = small(robot_path, "drop the robot made of jelly", frames=4, particles=300, resolution=64, rounds=1)
    return made(spec, tmp_path_factory.mktemp("jelly") / "run")


def test_a_run_simulates_the_sentences_material_and_keeps_the_reason(finished):
    scene = SceneConfig.model_validate_json((finished.path / "scene.json").read_text())
    assert scene.material.youngs_modulus == PRIORS["jelly"].youngs_modulus
    assert scene.material.density == PRIORS["jelly"].density
    assert "'made of jelly' in the sentence" in scene.material.reason
    reply = finished.read("semantic.json", SemanticReply)
    assert reply.materials == ("jelly",)
    assert any("--material overrides" in note for note in reply.notes)
    page = write_report(finished.path).read_text()
    assert "material: jelly, by" in page


def test_a_resumed_run_keeps_the_material(tmp_path, robot_path):
    spec = small(robot_path, "drop the robot made of jelly", frames=4, particles=300, resolution=64, rounds=2)

    class Stopped(Exception):
        pass

    rules = with_rules()

    class Stopping(type(rules.planner)):
        def judge(self, context, seen):
            raise Stopped

    Stopping.__name__ = Stopping.__qualname__ = type(rules.planner).__qualname__
    Stopping.__module__ = type(rules.planner).__module__
    with pytest.raises(Stopped):
        made(spec, tmp_path / "run", with_rules(planner=Stopping()))
    store = made(spec, tmp_path / "run")
    for path in sorted(store.path.glob("iterations/*/scene.json")):
        material = SceneConfig.model_validate_json(path.read_text()).material
        assert material.youngs_modulus == PRIORS["jelly"].youngs_modulus


def test_the_plan_tells_the_material_and_takes_another(robot_path, capsys):
    line = ["plan", JELLY, "--object", str(robot_path), "--frames", "10", "--json"]
    assert main(line) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["materials"] == ["jelly"] and any("material: jelly" in each for each in told["assumptions"])
    assert main([*line, "--material", "cork"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert any("cork is chosen for the run" in each for each in told["assumptions"])


def test_a_scene_built_from_a_sentence_has_its_material(robot_path):
    loaded = load_object(robot_path, max_particles=300)
    scene = build_scene(loaded, JELLY, frame_count=4)
    assert scene.config.material.youngs_modulus == PRIORS["jelly"].youngs_modulus
    assert isinstance(loaded.spec, RunSpec)


@pytest.mark.parametrize(
    ("words", "model"),
    [("of glass falls and cracks", "brittle"), ("of chocolate melts", "viscoplastic")],
)
def test_what_matter_becomes_outweighs_what_it_was(robot_path, body, words, model):
    chosen, _, _ = place(robot_path, body, f"the robot made {words}")
    assert chosen.material.model == model


@pytest.mark.parametrize(("chosen", "shown"), [({}, 0.45), ({"poissons_ratio": 0.48}, 0.48)])
def test_a_chosen_nu_is_kept_where_the_sentence_names_the_material(chosen, shown):
    material, _ = resolve_material(MaterialChoice(**chosen), "object", PRESETS["fast"], said="natural_rubber")
    assert material.poissons_ratio == shown
