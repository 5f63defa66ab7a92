"""Every example runs as its first lines say, and finds what it says; its own assertions are the test."""

import importlib
import re
import runpy
import sys
from pathlib import Path

import imageio.v3 as iio
import pytest

import physagent_jax as pa
from tests.conftest import REPOSITORY

EXAMPLES = sorted((REPOSITORY / "examples").glob("*.py"))
PICTURES = REPOSITORY / "examples" / "make_pictures.py"


def test_there_are_examples_and_each_is_short():
    assert len(EXAMPLES) >= 8
    for path in EXAMPLES:
        lines = path.read_text().splitlines()
        assert 20 <= len(lines) <= 90, path.name
        assert f"python examples/{path.name}" in "\n".join(lines[:6])


@pytest.mark.parametrize(
    "path",
    [pytest.param(each, id=each.stem, marks=[pytest.mark.slow] * (each == PICTURES)) for each in EXAMPLES],
)
def test_an_example_finds_what_it_says(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    monkeypatch.setattr(pa, "enable_compile_cache", lambda: None)  # this process has its own (conftest)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
def test_one_of_the_pictures_is_made(tmp_path, monkeypatch, capsys):
    """All code of that example at its smallest: a run and a film, which tests of both make too."""
    monkeypatch.syspath_prepend(str(PICTURES.parent))
    example = importlib.import_module(PICTURES.stem)
    monkeypatch.setattr(example, "SENTENCES", {"jelly": example.SENTENCES["jelly"]})
    example.main(tmp_path, example.SMALL)
    assert {path.name for path in tmp_path.iterdir()} == {"jelly.gif", "frames.png"}
    assert "drop the jelly" in capsys.readouterr().out


def test_readme_and_pages_show_pictures_that_the_example_makes():
    readme = (REPOSITORY / "README.md").read_text()
    page = (REPOSITORY / "docs" / "getting-started.md").read_text()
    source = (REPOSITORY / "examples" / "make_pictures.py").read_text()
    shown = re.findall(r"!\[.+?\]\((docs/images/.+?)\)", readme)
    shown += [f"docs/{place}" for place in re.findall(r"!\[.+?\]\((images/.+?)\)", page)]
    assert {Path(place).name for place in shown} == {
        "plant.gif",
        "jelly.gif",
        "loaf.gif",
        "robot.gif",
        "frames.png",
    }
    for place in shown:
        assert (REPOSITORY / place).stat().st_size < 1_500_000
        if place.endswith(".gif"):
            frames = iio.imread(REPOSITORY / place)
            assert len(frames) >= 50 and frames.shape[1:] == (
                180,
                320,
                3,
            )  # longer where the sentence asks for it
    sentences = re.findall(r'^    "(?:plant|jelly|loaf|robot)": "(.+)",$', source, re.MULTILINE)
    assert len(sentences) == 4 and all(f"`{sentence}`" in readme for sentence in sentences)
