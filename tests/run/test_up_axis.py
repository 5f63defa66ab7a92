"""The up axis that a run takes is the one that an inspection suggests, whoever states it."""

import pytest
import trimesh

from physagent_jax.run.inspection import inspect_object
from physagent_jax.run.resolve import resolve
from tests.run.specs import small

pytestmark = pytest.mark.usefixtures("quick_plans")


@pytest.fixture
def vase(tmp_path):
    """A cone on its flat base, y up, in a file that does not say so."""
    mesh = trimesh.creation.cone(radius=0.4, height=1.0, sections=64)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(-1.5707963, (1, 0, 0)))
    path = tmp_path / "vase.obj"
    mesh.export(path)
    return path


def test_the_shape_tells_it(vase):
    run = resolve(small(vase, "drop it"))
    assert run.template.source.up == inspect_object(vase).up.axis == "+y"
    assert any(
        "nothing states the file's up axis: +y is taken, as its -y side is flat" in each
        for each in run.warnings
    )


def test_what_is_given_goes_first(vase):
    run = resolve(small(vase, "drop it", object={"path": str(vase), "up": "+x"}))
    assert run.template.source.up == "+x" and not any("up axis" in each for each in run.warnings)


@pytest.mark.parametrize(("suffix", "axis"), [(".obj", "+y"), (".stl", "+z")])
def test_a_ball_takes_the_usual_one_and_says_so(tmp_path, suffix, axis):
    path = tmp_path / f"ball{suffix}"
    trimesh.creation.icosphere(3).export(path)
    run = resolve(small(path, "drop it"))
    assert run.template.source.up == inspect_object(path).up.axis == axis
    (note,) = [each for each in run.warnings if "up axis" in each]
    assert note.startswith("the file's up axis is not known") and "pass `--up`" in note


def test_a_loaded_object_keeps_its_own(vase):
    run = resolve(small(vase, "drop it"))
    source = run.template.source.model_copy(update=dict(up="-z"))
    assert resolve(small(vase, "drop it"), source=source).template.source.up == "-z"
