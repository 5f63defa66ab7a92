"""A part that bears the rest takes it along; one that bears nothing moves alone."""

import pytest
import trimesh

from physagent_jax.agents.registry import make_agents
from physagent_jax.forces.regions import grade_part, make_region_mask
from physagent_jax.motion.schema import MotionKind
from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.body import make_body
from tests.run.specs import small
from tests.scene.test_named_parts import write_glb, write_obj


@pytest.fixture(scope="module")
def statue(tmp_path_factory):
    """A slim figure on a broad block, one mesh."""
    path = tmp_path_factory.mktemp("statue") / "statue.obj"
    block, figure = trimesh.creation.box((0.6, 0.6, 0.4)), trimesh.creation.box((0.3, 0.3, 0.9))
    figure.apply_translation((0, 0, 0.6))
    trimesh.util.concatenate([block, figure]).export(path)
    return path


@pytest.fixture(scope="module")
def body(statue):
    template = resolve(spec(statue, "x")).template
    return make_body(template.source, template.preset.filling, template.preset.domain, ".")


def spec(path, prompt, kind="object"):
    return small(
        path, prompt, object={"path": str(path), "up": "+z", "kind": kind}, world="ground", frames=50
    )


def read(path, body, prompt, kind="object"):
    run = resolve(spec(path, prompt, kind))
    agents = make_agents()
    return read_for_scene(run, body, agents.semantic.compile).value


@pytest.mark.parametrize(
    "prompt", ["push the pedestal to the left", "lift the base", "slide the plinth slowly backwards"]
)
def test_what_bears_the_rest_takes_it_along(statue, body, prompt):
    reply = read(statue, body, prompt)
    assert reply.force_field.actions and all(each.region is None for each in reply.force_field.actions)
    assert not any(each.partial for each in reply.expectations)
    assert any("bears the rest" in note for note in reply.notes)


def test_a_pot_is_no_place_to_which_its_plant_is_rooted_when_it_is_pushed(statue, body):
    reply = read(statue, body, "push the flowerpot to the right", kind="plant")
    assert reply.anchor.kind == "none" and all(each.region is None for each in reply.force_field.actions)


@pytest.mark.parametrize(
    "prompt", ["push the top to the left", "bend the base to the left", "press the pedestal down"]
)
def test_other_parts_and_other_motions_stay_as_they_are(statue, body, prompt):
    reply = read(statue, body, prompt)
    assert not any("bears the rest" in note for note in reply.notes)


@pytest.mark.parametrize("prompt", ["the base comes off and flies to the left", "the pedestal breaks off"])
def test_what_comes_off_takes_nothing_along(statue, body, prompt):
    reply = read(statue, body, prompt)
    assert [each.manner for each in reply.expectations] == ["detach"] and reply.expectations[0].partial
    assert not any("bears the rest" in note for note in reply.notes)


CAR = {  # centre and half sizes, z up, in pieces with a gap
    "body": ((0, 0, 0.35), (0.5, 0.25, 0.15)),
    "front bumper": ((0.55, 0, 0.25), (0.03, 0.25, 0.05)),
    "wheels": ((0, 0, 0.1), (0.4, 0.25, 0.09)),
    "roof": ((0, 0, 0.6), (0.25, 0.2, 0.08)),
}


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    path = write_obj(tmp_path_factory.mktemp("car") / "car.obj", CAR, "o")
    template = resolve(spec(path, "x")).template
    return path, make_body(template.source, template.preset.filling, template.preset.domain, ".")


def test_a_fixed_end_that_is_lifted_tilts_the_whole(car):
    reply = read(*car, "lift the front bumper")
    (turn,) = reply.force_field.constraints
    assert turn.region is None and turn.constraint_type == "enforce_particle_rotation"
    assert turn.vector == pytest.approx((0, -1, 0), abs=0.2) and turn.held_until  # its nose goes up
    assert reply.anchor.kind is None and reply.expectations[0].kind is MotionKind.ROTATE


def test_until_it_stands_on_its_other_end_it_is_turned_there(car):
    plain = read(*car, "lift the front bumper").expectations[0].amount
    far = read(*car, "lift the front bumper until it stands on its back end").expectations[0].amount
    assert far.value > 3 * plain.value


def test_what_is_high_up_is_raised_alone(car):
    assert read(*car, "lift the roof").force_field.constraints[0].region is not None


def test_a_bucket_is_raised_alone(tmp_path):
    """By its own joint, under whatever name the file gives it."""
    digger = {name: CAR[name] for name in ("body", "wheels")} | {"shovel": CAR["front bumper"]}
    path = write_obj(tmp_path / "digger.obj", digger, "o")
    template = resolve(spec(path, "x")).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    reply = read(path, body, "the digger raises its bucket")
    assert [each.region is None for each in reply.force_field.constraints] == [False]
    assert reply.expectations[0].limb is not None and not reply.unsure


def test_a_lever_is_raised_alone(tmp_path):
    """It is a handle too, and has a joint."""
    machine = {name: CAR[name] for name in ("body", "wheels")} | {"lever": CAR["front bumper"]}
    path = write_obj(tmp_path / "machine.obj", machine, "o")
    template = resolve(spec(path, "x")).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    reply = read(path, body, "the lever goes up")
    assert [each.region is None for each in reply.force_field.constraints] == [False]


def test_something_is_tilted_by_one_of_its_handles(tmp_path):
    """A pot of one mesh: both handles are found by their shape alone, and neither bends."""
    pot = trimesh.creation.cylinder(0.4, 0.5)
    handles = [trimesh.creation.torus(0.16, 0.04).apply_translation((x, 0, 0.1)) for x in (-0.46, 0.46)]
    path = tmp_path / "pot.obj"
    trimesh.util.concatenate([pot, *handles]).export(path)
    template = resolve(spec(path, "x")).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    reply = read(path, body, "someone grabs the pot by one handle and lifts that side up so it is tilted")
    (turn,), (motion,) = reply.force_field.constraints, reply.expectations
    assert turn.region is None and turn.held_until and motion.kind is MotionKind.ROTATE
    assert abs(turn.vector[1]) > 0.9 and not reply.unsure


def test_wheels_that_are_pushed_take_the_car_along(car):
    reply = read(*car, "push the wheels to the left")
    assert not reply.force_field.constraints and reply.anchor.kind is None
    assert [each.region for each in reply.force_field.actions] == [None]


def test_an_open_piece_that_is_pressed_takes_along_what_lies_around_it(tmp_path):
    """It is of one skin with the rest: its border bends, and it leaves no hole."""
    shell = trimesh.creation.box((1.0, 0.5, 0.5)).subdivide().subdivide().subdivide()
    high = shell.triangles_center[:, 2] > 0.15
    meshes = {
        name: trimesh.Trimesh(shell.vertices, shell.faces[chosen], process=False)
        for name, chosen in (("body", ~high), ("roof", high))
    }
    path = write_glb(tmp_path / "car.glb", meshes)
    run = resolve(small(path, "press the roof down", world="ground", frames=50))
    template = run.template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    reply = read_for_scene(run, body, make_agents().semantic.compile).value
    (made,) = reply.force_field.constraints
    assert made.bend is not None and made.bend.rest == reply.anchor.region
    led, share, _ = grade_part(made.bend, body.particles.x)
    roof = make_region_mask(made.region, body.particles.x)
    assert led.sum() > 1.3 * roof.sum() and share.min() < 0.2 and share.max() == 1


def test_what_a_figure_holds_is_lifted_alone(tmp_path):
    figure = {**CAR, "head": ((0, 0, 0.8), (0.1, 0.1, 0.1))}
    figure["hatchet"] = figure.pop("front bumper")
    path = write_obj(tmp_path / "figure.obj", figure, "o")
    template = resolve(spec(path, "x")).template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    assert read(path, body, "lift the hatchet").force_field.constraints[0].region is not None


def test_the_cushion_of_a_pillow_is_all_of_it(tmp_path):
    """It was taken for the cushion of a seat, and moved alone."""
    path = tmp_path / "pillow.obj"
    trimesh.creation.box((0.8, 0.8, 0.2)).export(path)
    for kind, region in (("pillow", False), ("furniture", True)):
        run = resolve(spec(path, "push the cushion", kind))
        body = make_body(run.template.source, run.template.preset.filling, run.template.preset.domain, ".")
        assert any(part.name == "cushion" for part in run.list_parts(body)) is region
