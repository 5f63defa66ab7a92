"""The reading of a sentence for an object that its kind holds, and what becomes of it in a scene."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

import physagent_jax as pa
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Message, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import AnchorRequest
from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.body import Body, make_body
from tests.run.specs import made, small, with_rules

SMALL = dict(frame_count=8, width=64, height=64)
PLANT = {"kind": "plant", "up": "+z"}


@pytest.fixture(scope="module")
def pot(tmp_path_factory):
    """Something as high as it is wide: it stands."""
    path = tmp_path_factory.mktemp("pot") / "pot.obj"
    trimesh.creation.box([0.4, 0.4, 0.4]).export(path)
    return path


@pytest.fixture(scope="module")
def plant(pot):
    return pa.load_object(pot, **PLANT, max_particles=400)


def spec_of(path, prompt, **parts):
    return small(path, prompt, object={"path": str(path), **PLANT}, **parts)


def load(run) -> Body:
    template = run.template
    return make_body(template.source, template.preset.filling, template.preset.domain, ".")


class Scripted(SemanticAgent):
    """Lets the object fall, and keeps what it was told."""

    def __init__(self):
        self.contexts: list[AgentContext] = []

    def compile(self, context):
        self.contexts.append(context)
        trace = Trace(
            model="scripted",
            messages=(Message(role="user", text=str(len(self.contexts))),),
            input_tokens=10,
            output_tokens=len(self.contexts),
        )
        return Reply(SemanticReply(force_field=ForceField(default_drop=True)), trace)


def test_a_plant_that_is_dropped_falls(plant):
    """As a free fall with the drag c of the air does, by g (t - (1 - e^-ct) / c) / c: the clip ends before it lands."""
    scene = pa.build_scene(plant, "drop it", **SMALL)
    assert scene.config.anchor.kind == "none" and "drop" in scene.config.anchor.reason
    recording = pa.simulate_scene(scene)
    fallen = float((recording.x[0] - recording.x[-1])[:, 2].mean())
    c, time = scene.config.transfer.damping_rate, scene.config.timing.duration
    assert c > 0 and fallen == pytest.approx(9.81 * (time - (1 - np.exp(-c * time)) / c) / c, rel=0.01)


def test_a_plant_that_is_bent_keeps_its_foot(plant):
    assert pa.build_scene(plant, "bend it to the left", **SMALL).config.anchor.kind == "base"
    assert pa.build_scene(plant, "push it to the left", **SMALL).config.anchor.kind == "base"


def test_a_force_field_that_lets_a_plant_fall_lets_it_go(plant):
    """With a warning; a hold that somebody has chosen stays."""
    drop = ForceField(default_drop=True)
    with pytest.warns(UserWarning, match="needs the object free"):
        scene = pa.build_scene(plant, force_field=drop, **SMALL)
    assert scene.config.anchor.kind == "none"
    assert pa.build_scene(plant, force_field=drop, anchor="base", **SMALL).config.anchor.kind == "base"
    assert pa.build_scene(plant, **SMALL).config.anchor.kind == "base"


def test_an_agent_is_asked_again_for_the_free_object(pot):
    """Told that nothing holds it; both calls are kept."""
    run, agent = resolve(spec_of(pot, "drop it")), Scripted()
    reading = read_for_scene(run, load(run), agent.compile)
    first, second = agent.contexts
    assert first.brief.anchored and second.brief.anchored is None
    assert first.brief.model_copy(update={"anchored": None}) == second.brief
    assert reading.value.anchor.kind == "none" and "needs the object free" in reading.value.notes[0]
    trace = reading.trace
    assert (trace.input_tokens, trace.output_tokens) == (20, 3)
    assert [message.text for message in trace.messages] == ["1", "2"]


def test_an_agent_is_asked_once_where_nothing_has_to_be_free(pot):
    run, agent = resolve(spec_of(pot, "drop it", anchor={"kind": "none"})), Scripted()
    read_for_scene(run, load(run), agent.compile)
    assert len(agent.contexts) == 1


@pytest.fixture(scope="module")
def leaning(tmp_path_factory):
    """Something with its weight beside what it stands on: its foot is held."""
    path = tmp_path_factory.mktemp("leaning") / "leaning.obj"
    head = trimesh.creation.box([0.6, 0.3, 0.2]).apply_translation([0.35, 0, 0.6])
    trimesh.util.concatenate([trimesh.creation.box([0.1, 0.1, 1.0]), head]).export(path)
    return path


def test_a_reading_for_what_is_held_tells_the_clips_length_anew(tmp_path):
    """A lamp is hard and stands, but not as what sways: it is read again as held, for the same clip."""
    parts = [((0.3, 0.3, 0.05), 0.025), ((0.03, 0.03, 0.8), 0.45), ((0.4, 0.4, 0.3), 1.0)]
    boxes = [trimesh.creation.box(size).apply_translation([0, 0, z]) for size, z in parts]
    trimesh.util.concatenate(boxes).export(path := tmp_path / "lamp.obj")
    sentence = "the lamp gets bumped, sways for a bit and then stands still"
    run = resolve(small(path, sentence, frames=None, object={"path": str(path), "up": "+z"}))
    rules, contexts = make_agents().semantic, []

    def ask(context):
        contexts.append(context)
        return rules.compile(context)

    reply = read_for_scene(run, load(run), ask).value
    assert [each.brief.anchored is None for each in contexts] == [True, False]
    assert (reply.frame_count or 0) > max(each.window[1] for each in reply.expectations)


@pytest.mark.parametrize(
    ("sentence", "weighs"),
    [("it rises into the air and then drops to the ground", True), ("it rises into the air", False)],
)
def test_what_drops_after_a_lift_has_its_weight(leaning, sentence, weighs):
    run = resolve(small(leaning, sentence, object={"path": str(leaning), "up": "+z"}))
    reply = read_for_scene(run, load(run), make_agents().semantic.compile).value
    assert run.place_for_agents(load(run), reply).world.ground is weighs


def test_what_cannot_stand_is_read_as_floating_once_it_is_free(leaning):
    """So is what no kind holds: without weight, what is thrown needs gravity to come down."""
    run, contexts = resolve(spec_of(leaning, "throw it into the air")), []
    rules = make_agents().semantic

    def ask(context):
        contexts.append(context)
        return rules.compile(context)

    reply = read_for_scene(run, load(run), ask).value
    held, free = contexts  # held it bears no weight either: no stiffness that is affordable carries the head
    assert held.brief.anchored is not None and (free.brief.anchored, free.brief.world) == (None, "free")
    assert reply.force_field.default_drop


@pytest.mark.parametrize(
    ("prompt", "anchor", "got"),
    [("hold the base and throw it", "auto", "hold base"), ("drop it", "base", "anchor 'base'")],
)
def test_what_a_held_object_cannot_do_is_refused_before_it_is_simulated(pot, tmp_path, prompt, anchor, got):
    """And leaves no run folder behind."""
    with pytest.raises(UserError, match="is impossible for an object that is held at its base") as caught:
        made(spec_of(pot, prompt, anchor={"kind": anchor}), tmp_path / "run")
    assert got in str(caught.value.got) and not (tmp_path / "run" / "run.json").exists()


def test_nothing_moves_of_what_is_held_as_a_whole(plant, tmp_path):
    mask = tmp_path / "all.npy"
    np.save(mask, np.ones(plant.body.cloud.count, bool))
    choice = {"kind": "mask", "mask_path": str(mask)}
    with pytest.raises(UserError, match="held as a whole"):
        pa.build_scene(plant, "push it to the left", anchor=choice, **SMALL)
    assert pa.build_scene(plant, "nothing moves", anchor=choice, **SMALL).config.anchor.kind == "mask"


def test_a_lift_of_what_is_held_is_warned_of(plant):
    with pytest.warns(UserWarning, match="only stretch"):
        pa.build_scene(plant, "hold the base and lift it", **SMALL)


def test_a_run_tells_why_nothing_is_held_and_goes_on_with_that(pot, tmp_path):
    """In the folder, for the report; the same command reads it from there."""
    spec = spec_of(pot, "drop it", frames=6, particles=300, resolution=64, rounds=1)
    store = made(spec, tmp_path / "run", with_rules())
    reply = json.loads((store.path / "semantic.json").read_text())
    assert reply["anchor"]["kind"] == "none" and any("needs the object free" in x for x in reply["notes"])
    scene = json.loads((store.path / "scene.json").read_text())
    assert scene["anchor"]["kind"] == "none"
    told = SemanticReply.model_validate(reply)
    assert resolve(spec).with_reply(told).anchor.kind == "none" and isinstance(told.anchor, AnchorRequest)
