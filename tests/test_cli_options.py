"""The options of `physagent run` against the spec that they say, and what the terminal tells."""

import dataclasses
import sys
import typing
import warnings
from pathlib import Path

import pytest

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.cli import join_options
from physagent_jax.cli.console import ConsoleObserver, tell_warnings_plainly
from physagent_jax.cli.options import OPTIONS, to_spec
from physagent_jax.cli.run import Run
from physagent_jax.cli.simulate import Simulate
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Judgement, Verdict
from physagent_jax.output.splats import WRITERS, SplatFormat
from physagent_jax.run.spec import PhotoChoice, SaveChoice
from tests.run.specs import small


def test_options_say_what_a_spec_says(tmp_path, robot_path):
    command = Run(
        out=tmp_path, object=robot_path, prompt="drop it", frames=12, particles=900, resolution=64, seed=7,
        anchor="box", anchor_box=(2, 2, 2, 1, 1, 0.5), soften=3.0, save_splats="spz", max_iterations=2,
        video_size="160x90", follow=True, reader="model", form="by-clause", llm="http://127.0.0.1:8000/v1", model="m",
    )  # fmt: skip
    spec = small(
        robot_path, "drop it", frames=12, particles=900, resolution=64, cells=None, seed=7, rounds=2,
        anchor=dict(kind="box", point=(2, 2, 2), half_size=(1, 1, 0.5)),
        material=dict(soften=3.0), save=dict(splats="spz", video_size=(160, 90)), camera=dict(follow=True),
        agents=dict(
            semantic=dict(name="model", options=dict(form="by-clause")),
            model=dict(name="openai", options=dict(url="http://127.0.0.1:8000/v1", model="m")),
        ),
    )  # fmt: skip
    assert to_spec(vars(command)) == spec


def test_an_image_stands_in_place_of_an_object(tmp_path, robot_path):
    command = Run(
        out=tmp_path, image=Path("cup.jpg"), image_box=(1, 2, 30, 40), image_fov=50, elevation=20, prompt="push it left"
    )  # fmt: skip
    spec = to_spec(vars(command))
    assert spec.object.path == "cup.jpg" and spec.camera.elevation_degrees == 20
    assert spec.object.photo == PhotoChoice(box=(1, 2, 30, 40), fov_degrees=50)
    assert to_spec(vars(Run(out=tmp_path, image=Path("cup.jpg"), prompt="."))).object.photo == PhotoChoice()
    for changes, match in (
        (dict(object=robot_path), "both say what moves"),
        (dict(image=None, object=robot_path), "means nothing without `--image`"),
        (dict(image_box=(30, 2, 1, 40)), "x0 < x1"),
        (dict(image_mask=Path("m.png")), "both say where the object is"),
    ):
        with pytest.raises(UserError, match=match):
            to_spec(vars(dataclasses.replace(command, **changes)))


def test_every_option_sets_a_field():
    """But those that say where, at what price, and how it is told; four together set `agents.model`."""
    beside = {"out", "spec", "record", "anchor_box", "max_minutes", "max_memory", "overwrite", "json_line"}
    beside |= {"llm", "model", "eyes", "replay", "sentence", "image"}
    attributes = {option.removeprefix("--").replace("-", "_") for option in OPTIONS.values()}
    assert attributes | beside == {field.name for field in dataclasses.fields(Run)}


def test_the_terminal_tells_what_was_assumed_and_not_understood(capsys):
    reply = SemanticReply(
        force_field=ForceField(),
        expectations=(),
        notes=("left is [the viewer's].",),
        not_understood=("purple",),
    )
    ConsoleObserver().understood(reply)
    told = capsys.readouterr().err
    assert "assumed: left is [the viewer's]." in told and "not understood: purple\n" in told


def test_the_terminal_tells_how_a_judgement_came_about(capsys):
    judgement = Judgement(verdict=Verdict.FAIL, notes=("Rules and model [disagree].",))
    ConsoleObserver().judged(0, judgement)
    assert "round 1: FAIL" in (told := capsys.readouterr().err) and "Rules and model [disagree]." in told


def test_a_doubt_about_what_may_be_the_object_says_how_to_name_it(capsys):
    """A word that only decorates is not doubted, and gets no hint."""
    reply = SemanticReply(
        force_field=ForceField(),
        expectations=(),
        not_understood=("purple", "cow"),
        unsure=("'cow' is not understood.",),
    )
    ConsoleObserver().understood(reply)
    assert "not understood: purple, cow (the object is called by its file's name" in capsys.readouterr().err


def test_the_formats_are_the_same_everywhere():
    formats = set(WRITERS)
    assert set(typing.get_args(SplatFormat)) == formats
    for command in (Run, Simulate):
        given, none = typing.get_args(typing.get_type_hints(command)["save_splats"])
        assert set(typing.get_args(given)) == formats and none is type(None)
    assert set(typing.get_args(SaveChoice.model_fields["splats"].annotation)) == formats | {False}


@pytest.mark.parametrize(
    ("line", "parsed"),
    [
        ("--save-splats", "--save-splats=ply"),
        ("--save-splats --json", "--save-splats=ply --json"),
        ("--save-splats spz", "--save-splats=spz"),
        ("--save-splats=glb --up -y", "--save-splats=glb --up=-y"),
        ("--save-splats scene.json", "--save-splats=ply scene.json"),
    ],
)
def test_the_option_may_stand_without_a_format(line, parsed):
    assert join_options(line.split()) == parsed.split()


def test_spec_files_of_before_are_read():
    assert SaveChoice.model_validate({"splats": True}).splats == "ply"
    assert SaveChoice.model_validate({"splats": False}) == SaveChoice()
    assert SaveChoice.model_validate({"splats": "spz"}).splats == "spz"


@pytest.fixture
def plain(monkeypatch):
    """Warnings as the command line tells them; what showed them before comes back."""
    monkeypatch.setattr(sys, "warnoptions", [])
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        tell_warnings_plainly()
        yield


def test_a_warning_that_nothing_caught_is_one_plain_line(plain, capsys):
    for _ in range(2):
        warnings.warn("raise `overrides.max_particles`: it may tear", stacklevel=1)
    warnings.warn("invalid value in divide", RuntimeWarning, stacklevel=1)
    assert capsys.readouterr().err == "warning: raise `--particles`: it may tear\n"


def test_who_asks_python_for_warnings_gets_them_as_they_are(monkeypatch):
    before = warnings.showwarning
    monkeypatch.setattr(sys, "warnoptions", ["default"])
    tell_warnings_plainly()
    assert warnings.showwarning is before
