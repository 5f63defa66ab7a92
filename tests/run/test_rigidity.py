"""Hard objects that move as rigid bodies, and what keeps them from it."""

import json

import numpy as np
import pytest
import trimesh

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Amount, ExpectedMotion, MotionKind
from physagent_jax.mpm import simulate
from physagent_jax.run import rigidity
from physagent_jax.run.reading import place_for_field, read_for_scene
from physagent_jax.run.resolve import resolve
from physagent_jax.run.rigidity import RIGID_NOTE, STEP
from physagent_jax.run.spec import MaterialChoice
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.materials import LIBRARY, is_hard
from physagent_jax.scene.priors import PRIORS
from tests.run.specs import small, with_rules

RIGID = MaterialModel.RIGID
KINDS = {kind for kind, prior in PRIORS.items() if prior.hard}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A stool of a seat and four thin legs, and its body at rest."""
    path = tmp_path_factory.mktemp("rigid") / "stool.obj"
    legs = [(x, y) for x in (-0.3, 0.3) for y in (-0.3, 0.3)]
    parts = [trimesh.creation.box((0.1, 0.1, 0.8)).apply_translation((x, y, 0.4)) for x, y in legs]
    trimesh.util.concatenate(
        [*parts, trimesh.creation.box((0.8, 0.8, 0.12)).apply_translation((0, 0, 0.86))]
    ).export(path)
    template = resolve(spec(path, "push the stool to the left")).template
    return path, make_body(template.source, template.preset.filling, template.preset.domain, ".")


def spec(path, prompt, **parts):
    return small(path, prompt, object={"path": str(path), "up": "+z"}, frames=30, particles=1500, **parts)


def place(table, prompt, **parts):
    """Template and reply of a sentence."""
    path, body = table
    run = resolve(spec(path, prompt, **parts))
    reply = read_for_scene(run, body, with_rules().semantic.compile).value
    return run.place(body, reply)[0], reply


@pytest.mark.parametrize(
    "prompt",
    ["push the stool to the left", "drop the stool", "throw the stool up into the air", "spin the stool around",
     "lift the stool up and hold it there", "the stool stands still", "hit the stool hard from the left",
     "tip the stool over to the left", "knock the stool over", "shake the stool",
     "the stool shakes in an earthquake and then stands still", "the stool leans to the left",
     "tilt the stool 30 degrees to the left"],
)  # fmt: skip
def test_what_is_hard_and_moved_as_a_whole_is_rigid(table, prompt):
    template, _ = place(table, prompt)
    assert template.material.model is RIGID and template.preset.timing.substep_dt == STEP
    assert template.material.density == PRIORS["furniture"].density
    assert template.material.reason.startswith("a rigid body, as nothing asks it to deform")


@pytest.mark.parametrize(
    "prompt",
    [
        "squeeze the stool",
        "stretch the stool upwards",
        "twist the stool",
        "the stool wobbles",
        "push the top of the stool to the left",
        "bend the stool to the left",
        "push the stool made of jelly to the left",
        "push the stool made of rubber to the left",
        "the stool is fixed to the floor; the wind pushes it to the left",
    ],
)
def test_what_changes_its_shape_is_not(table, prompt):
    assert place(table, prompt)[0].material.model is not RIGID


def test_what_cannot_bear_its_weight_is_tilted_rather_than_pushed(tmp_path):
    """A hard thing on a thin stem: read as held at its feet, it would be bent by a push, which then slides it along."""
    path = tmp_path / "lamp.obj"
    stem = trimesh.creation.cylinder(0.02, 0.9).apply_translation((0, 0, 0.45))
    foot, shade = trimesh.creation.cylinder(0.2, 0.06), trimesh.creation.cylinder(0.2, 0.3)
    trimesh.util.concatenate(
        [stem, foot.apply_translation((0, 0, 0.03)), shade.apply_translation((0, 0, 1.0))]
    ).export(path)
    template = resolve(spec(path, "")).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    template, reply = place((path, body), "the lamp leans 30 degrees to the left")
    (turn,) = reply.force_field.constraints
    assert turn.constraint_type == "enforce_particle_rotation" and not reply.force_field.actions
    assert template.material.model is RIGID and template.anchor.kind == "none"


@pytest.mark.parametrize(
    ("prompt", "matter", "rigid"),
    [
        ("the statue is hit from the left", "statue", True),
        ("the statue shakes in an earthquake", "statue", True),
        ("the chair is hit from the left", "furniture", True),
        ("a foam statue is hit from the left", "statue", False),
        ("the figure is hit from the left", "object", True),
        ("it is hit by a statue from the left", "object", True),
        ("the figure bends to the left", "object", False),
    ],
)
def test_a_noun_for_something_hard_tells_what_a_nameless_thing_is_made_of(table, prompt, matter, rigid):
    """A hard thing bears its weight, so that it is not held and bent."""
    path, body = table
    nameless = path.with_name("a1.obj")
    nameless.write_bytes(path.read_bytes())
    thing = {"path": str(nameless), "up": "+z", "kind": "object"}
    run = resolve(small(nameless, prompt, object=thing, frames=30, particles=1500))
    reply = read_for_scene(run, body, with_rules().semantic.compile).value
    template, notes = run.place(body, reply)
    assert run.template.matter == matter and (RIGID_NOTE in notes) is rigid
    assert not rigid or template.anchor.kind == "none" and run.find_hold(reply, body) is None


@pytest.mark.parametrize(
    "choice",
    [{"youngs_modulus": 1e6}, {"name": "steel"}, {"name": "wood"}, {"damping_ratio": 0.1}, {"soften": 10.0}],
)
def test_the_users_own_material_stays(table, choice):
    name = {"name": "oak"} if "name" not in choice and "soften" in choice else {}
    assert (
        place(table, "push the stool to the left", material={**name, **choice})[0].material.model is not RIGID
    )


def test_what_would_have_to_be_far_stiffer_than_its_kind_is_rigid(table):
    """A soft kind on thin legs: it lands on them, and is not soft where it is asked to give or is said to be so."""
    for prompt, rigid in {
        "the stool jumps up and lands again": True,
        "squeeze the stool": False,
        "push the stool made of rubber to the left": False,
    }.items():
        for kind in ("animal", "toy"):
            path, body = table
            thing = {"path": str(path), "up": "+z", "kind": kind}
            run = resolve(small(path, prompt, object=thing, frames=30, particles=1500))
            reply = read_for_scene(run, body, with_rules().semantic.compile).value
            template, notes = run.place(body, reply)
            assert (template.material.model is RIGID) is rigid, (prompt, kind)
            assert any("times as stiff as its kind" in note for note in notes) is rigid
            assert template.bearing is None or not rigid


def test_a_sentence_of_steel_makes_soft_kinds_rigid(robot_path):
    run = resolve(small(robot_path, "push the robot made of steel to the left"))
    template = run.template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    reply = read_for_scene(run, body, with_rules().semantic.compile).value
    made, notes = run.place(body, reply)
    assert made.material.model is RIGID and made.material.density == LIBRARY["steel"].material.density
    assert RIGID_NOTE in notes and not any("softened" in note for note in notes)


def test_a_field_without_a_sentence_keeps_the_kinds_stiffness(table):
    path, body = table
    run = resolve(spec(path, "push the stool to the left"))
    _, reply = place(table, "push the stool to the left")
    assert place_for_field(run, body, reply.force_field)[0].material.model is not RIGID


def test_hard_are_kinds_and_materials_that_nobody_sees_bend():
    assert KINDS == {"instrument", "furniture", "vessel", "vehicle", "statue", "building", "tool"}
    hard = {name for name, entry in LIBRARY.items() if is_hard(entry.material)}
    assert {"steel", "glass", "concrete", "oak"} & set(LIBRARY) <= hard
    assert not {"rubber", "cork", "sand", "water", "jelly", "snow"} & hard


def test_a_dropped_stool_lands_on_its_legs_in_its_shape(table):
    """Its mass centre falls as a free body's, and distances within it stay; it then stands, and nothing creeps."""
    template, reply = place(table, "drop the stool")
    _, body = table
    scene = compile_scene(fuse(template, body, reply.force_field), body, ".")
    timing = scene.config.timing
    frames = list(
        simulate(
            scene.windowed,
            scene.state,
            frame_count=30,
            frame_dt=timing.frame_dt,
            substep_dt=timing.substep_dt,
        )
    )
    x = np.array([np.asarray(frame.state.x, np.float64) for frame in frames])
    assert sum(frame.substeps for frame in frames) <= 30 * round(timing.frame_dt / STEP)
    for pair in ((0, -1), (10, 500), (200, 900)):
        lengths = np.linalg.norm(x[:, pair[0]] - x[:, pair[1]], axis=-1)
        np.testing.assert_allclose(lengths, lengths[0], rtol=1e-4)
    height, time = x[:, :, 2].mean(1), 4 * timing.frame_dt
    assert height[0] - height[4] == pytest.approx(9.8 * time**2 / 2, rel=0.05)
    assert height[0] - height[-1] > 0.1 and np.ptp(height[-8:]) < 2e-3
    assert np.abs(x[-1] - x[-8]).max() < 5e-3
    assert json.loads(scene.config.model_dump_json())["material"]["model"] == "rigid"


def test_what_is_called_a_hard_thing_is_rigid(tmp_path):
    """A file whose name tells nothing: the sentence does."""
    path = tmp_path / "scan.obj"
    trimesh.creation.box((0.6, 0.6, 1.0)).export(path)
    for noun, kind in {"statue": "statue", "animal": "object"}.items():
        run = resolve(spec(path, f"the {noun} is suddenly hit from the left"))
        assert run.template.matter == kind and run.template.source.kind == "object"
        body = make_body(run.template.source, run.template.preset.filling, run.template.preset.domain, ".")
        reply = read_for_scene(run, body, with_rules().semantic.compile).value
        assert run.place(body, reply)[0].material.model is RIGID


@pytest.mark.parametrize(
    ("kind", "said", "motion", "hard"),
    [
        ("object", None, MotionKind.FALL, True),
        ("object", None, MotionKind.MOVE, True),
        ("object", "natural_rubber", MotionKind.FALL, False),
        ("toy", None, MotionKind.FALL, False),
        ("cloth", None, MotionKind.FALL, False),
    ],
)
def test_what_nobody_knows_anything_of_keeps_its_shape_unless_it_jiggles(kind, said, motion, hard):
    """The thin band of a pair of headphones went limp where it landed, and in a gust."""
    for jiggles in (False, True):
        fall = ExpectedMotion(kind=motion, window=(0, 20), jiggles=jiggles)
        reply = SemanticReply(force_field=ForceField(default_drop=True), expectations=(fall,))
        assert rigidity.is_hard(MaterialChoice(), kind, said, reply) is (hard and not jiggles)


@pytest.mark.parametrize(
    ("kind", "said", "degrees", "axis", "turned"),
    [
        ("animal", None, 180.0, (0.0, 1.0, 0.0), True),
        ("object", None, 540.0, (1.0, 0.0, 0.0), True),
        ("animal", None, 360.0, (0.0, 1.0, 0.0), False),
        ("animal", None, 180.0, (0.0, 0.0, 1.0), False),
        ("animal", "natural_rubber", 180.0, (0.0, 1.0, 0.0), False),
        ("jelly", None, 180.0, (0.0, 1.0, 0.0), False),
    ],
)
def test_what_is_turned_over_onto_thin_parts_keeps_its_shape(kind, said, degrees, axis, turned):
    """A fish buckled on the fin of its back."""
    amount = Amount(value=degrees, unit="degrees")
    turn = ExpectedMotion(kind=MotionKind.ROTATE, window=(0, 20), direction=axis, amount=amount)
    reply = SemanticReply(force_field=ForceField(), expectations=(turn,))
    assert rigidity.is_turned_over(MaterialChoice(), kind, said, reply) is turned
