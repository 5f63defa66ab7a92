"""A slightly tilted capture is set upright, and nothing else is turned."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians import write_ply
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, MotionKind, WorldRequest
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene.body import make_body
from physagent_jax.scene.level import LARGEST_TILT, find_tilt
from physagent_jax.scene.mesh import sample_mesh
from physagent_jax.scene.placement import find_tilt_rotation
from physagent_jax.scene.world import find_overhang

AXIS = np.array([0.8, 0.6, 0.0])


def sample_box(size=(0.5, 0.4, 1.0), count=20_000):
    return np.asarray(trimesh.sample.sample_surface(trimesh.creation.box(size), count, seed=0)[0])


def turn(points, degrees, axis=AXIS):
    return points @ Rotation.from_rotvec(degrees * axis, degrees=True).as_matrix().T


@pytest.mark.parametrize("degrees", [-9.0, 10.0, 12.0])
def test_a_tilted_box_is_set_on_its_base(degrees):
    points = turn(sample_box(), degrees)
    tilt = find_tilt(points)
    assert tilt is not None
    np.testing.assert_allclose(tilt, -degrees * AXIS[:2], atol=0.7)
    level = points @ find_tilt_rotation(tilt).T
    lowest = level[level[:, 2] < level[:, 2].min() + 0.02]
    assert np.ptp(lowest[:, 0]) > 0.45 and np.ptp(lowest[:, 1]) > 0.35


def test_what_stands_is_not_turned_nor_what_never_stood():
    box = sample_box()
    assert find_tilt(box) is None
    assert find_tilt(turn(box, LARGEST_TILT + 20)) is None
    assert find_tilt(turn(sample_box((0.2, 0.2, 0.2)), 0.4)) is None  # within what feet may differ by
    assert find_tilt(np.zeros((3, 3)) + np.arange(3)[:, None]) is None


def export(path, degrees):
    mesh = trimesh.creation.box((0.5, 0.4, 1.0))
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), AXIS))
    mesh.export(path)
    return path


def load(path, **parts):
    overrides = {"max_particles": 3000, "cells": 48}
    spec = {"object": {"path": str(path), "up": "+z"}, "prompt": "x", "overrides": overrides, **parts}
    run = resolve(RunSpec.model_validate(spec))
    template = run.template
    return run, make_body(template.source, template.preset.filling, template.preset.domain, ".")


def test_a_run_on_the_ground_sets_it_upright_and_says_so(tmp_path):
    path = export(tmp_path / "box.obj", 10.0)
    run, body = load(path)
    assert find_overhang(body) < 0
    assert any("turned by 10" in text or "turned by 9.9" in text for text in run.warnings)
    for parts in ({"world": "free"}, {"anchor": {"kind": "base"}}):
        run, body = load(path, **parts)
        assert run.template.source.tilt == (0.0, 0.0) and find_overhang(body) > 0
        assert not any("turned by" in text for text in run.warnings)


def test_a_mesh_that_leans_far_is_set_on_the_ground_and_a_capture_is_not(tmp_path):
    """A mesh is drawn without a ground; a capture stood as it was captured."""
    path = export(tmp_path / "box.obj", 42.0)
    run, body = load(path)
    assert find_overhang(body) < 0 and run.template.world.ground
    assert any("turned by 42" in text or "turned by 41.9" in text for text in run.warnings)
    write_ply(tmp_path / "box.ply", sample_mesh(path, count=4000, seed=0)[0])
    assert load(tmp_path / "box.ply")[0].template.source.tilt == (0.0, 0.0)


def test_what_the_sentence_turns_begins_so_and_falls_free(tmp_path):
    """Upside down, all that was above is below, in the body and in the scene alike."""
    run, body = load(export(tmp_path / "box.obj", 0.0))
    world = WorldRequest(attitude=(180.0, 0.0), gravity="down")
    fall = ExpectedMotion(kind=MotionKind.FALL, window=(0, 20))
    reply = SemanticReply(
        force_field=ForceField(default_drop=True),
        expectations=(fall,),
        anchor=AnchorRequest(kind="none"),
        world=world,
    )
    turned = run.turn(body, reply)
    template, _ = run.place(turned, reply)
    assert template.source.attitude == (180.0, 0.0) and template.anchor.kind == "none"
    middle = np.asarray(body.cloud.means).mean(0)
    flipped = (np.asarray(body.cloud.means) - middle) * (1, -1, -1)
    np.testing.assert_allclose(
        np.asarray(turned.cloud.means).mean(0) + flipped, turned.cloud.means, atol=1e-5
    )
    assert run.turn(body, SemanticReply(force_field=ForceField())) is body


@pytest.mark.parametrize(
    "name, up, known",
    [("a.glb", "+y", True), ("a.GLTF", "+y", True), ("a.obj", "+y", False), ("a.stl", "+z", False)],
)
def test_gltf_says_which_axis_is_up_and_other_formats_do_not(tmp_path, name, up, known):
    """+Y by the glTF 2.0 specification, section 3.4, and by habit for OBJ; a choice of the user's goes before it."""
    path = tmp_path / name
    made = trimesh.creation.box((0.5, 0.4, 1.0)).export(file_type=path.suffix.lower()[1:])
    for beside, content in made.items() if isinstance(made, dict) else ():
        (tmp_path / beside).write_bytes(content)
    path.write_bytes(
        made if isinstance(made, bytes) else made["model.gltf"] if isinstance(made, dict) else made.encode()
    )
    run = load(path, object={"path": str(path)})[0]
    assert run.template.source.up == up
    assert any("axis is not known" in text for text in run.warnings) != known
    assert load(path, object={"path": str(path), "up": "-x"})[0].template.source.up == "-x"
