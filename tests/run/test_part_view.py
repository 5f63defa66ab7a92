"""The camera of a run about a part: it goes where the motion is seen, unless the user has chosen its place."""

import pytest
import trimesh

from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.body import make_body
from tests.run.specs import small, with_rules


@pytest.fixture(scope="module")
def figure(tmp_path_factory):
    """A ball on a slim neck on a larger ball, all around alike."""
    path = tmp_path_factory.mktemp("view") / "figure.obj"
    radii = {0.0: 0.35, 0.38: 0.08, 0.55: 0.17}  # by the height of each ball
    balls = [trimesh.creation.icosphere(3, r).apply_translation((0, 0, z)) for z, r in radii.items()]
    trimesh.util.concatenate(balls).export(path)
    return path


@pytest.mark.parametrize(
    ("prompt", "azimuth", "turned"),
    [
        ("the head of the figure bends towards us", None, True),
        ("the head of the figure bends towards us", 0.0, False),
        ("push the head of the figure to the left", None, False),
        ("push the figure away from us", None, False),
    ],
)
def test_the_camera_goes_to_where_a_parts_motion_is_seen(figure, prompt, azimuth, turned):
    chosen = {} if azimuth is None else {"camera": {"azimuth_degrees": azimuth}}
    run = resolve(small(figure, prompt, object={"path": str(figure), "up": "+z"}, particles=1500, **chosen))
    body = make_body(run.template.source, run.template.preset.filling, run.template.preset.domain, ".")
    template, notes = run.place(body, read_for_scene(run, body, with_rules().semantic.compile).value)
    assert (template.camera != run.template.camera) is turned
    assert any("the part's motion is seen" in note for note in notes) is turned
