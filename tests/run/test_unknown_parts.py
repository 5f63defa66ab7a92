"""A sentence about a part that the object does not show: nothing is simulated, and the part is asked for."""

import numpy as np
import pytest

import physagent_jax as pa
from physagent_jax.core.errors import UserError
from physagent_jax.run import loop, unknown_parts
from physagent_jax.run.preview import is_preview
from tests.run.specs import made, small
from tests.scene.test_named_parts import COARSE, write_obj


@pytest.fixture
def doll(tmp_path):
    return write_obj(tmp_path / "doll.obj")


def spec_of(path, prompt, **choice):
    return small(path, prompt, cells=48, object={"path": str(path), "up": "+z", **choice})


def test_a_run_stops_before_it_simulates_and_draws_the_parts(doll, tmp_path, monkeypatch):
    """The picture is that of `inspect`, and is tested there: to render it takes long."""
    monkeypatch.setattr(unknown_parts, "draw_preview", lambda *_: np.zeros((4, 4, 3), np.uint8))
    monkeypatch.setattr(loop, "compile_ahead", lambda: None)
    with pytest.raises(UserError) as error:
        made(spec_of(doll, "swing the doll's axe"), tmp_path / "runs" / "one")
    picture = tmp_path / "runs" / "one.parts.png"
    told = ("'axe'", "doll", "1 body, 2 left arm, 3 right arm, 4 head", "--part axe=N", str(picture))
    assert all(words in str(error.value) for words in told)
    assert is_preview(picture)
    assert not any((tmp_path / "runs" / "one").glob("*"))


def test_the_programmatic_interface_refuses_it_too(doll):
    loaded = pa.load_object(doll, up="+z", **COARSE)
    with pytest.raises(UserError, match=r"'tail'.*1 body.*--part tail=N.*physagent inspect"):
        pa.build_scene(loaded, prompt="the doll wags its tail")


def test_a_part_that_is_named_is_known(doll):
    """By its number here; `tests/test_cli_parts.py` has the other ways."""
    loaded = pa.load_object(doll, up="+z", parts=[dict(name="axe", number=2)], **COARSE)
    assert pa.build_scene(loaded, prompt="swing the doll's axe").config.force_field.constraints
