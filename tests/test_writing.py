"""The check of the writing law: it finds what it should, and lets pass what is right."""

import importlib.util

import pytest

from tests.conftest import REPOSITORY

spec = importlib.util.spec_from_file_location("check_writing", REPOSITORY / ".ci" / "check_writing.py")
assert spec is not None and spec.loader is not None
check_writing = importlib.util.module_from_spec(spec)
spec.loader.exec_module(check_writing)

FUNCTION = 'def f(x):\n    """{head}\n\n    Args:\n        x: {described}\n    """\n'


@pytest.mark.parametrize(
    "head", ["What it does.", "Who looks on.", "How long.", "Where it is.", "Which one.", "Whether it moves."]
)
def test_heads_that_name_nothing_are_found(head):
    assert (
        len(list(check_writing.find_docstring_faults(FUNCTION.format(head=head, described="A width.")))) == 1
    )
    assert len(list(check_writing.find_docstring_faults(f'"""{head}"""'))) == 1


@pytest.mark.parametrize("described", ["Of the pictures [px].", "Likewise."])
def test_descriptions_that_are_no_noun_phrase_are_found(described):
    source = FUNCTION.format(head="Draw.", described=described)
    assert [line for line, _ in check_writing.find_docstring_faults(source)] == [1]


@pytest.mark.parametrize(
    "head", ["Progress callbacks of a run.", "Whatever is left.", "Return whether it moves."]
)
def test_heads_that_name_the_thing_pass(head):
    source = FUNCTION.format(head=head, described="Width of the pictures [px].")
    assert not list(check_writing.find_docstring_faults(source))


def test_long_subjects_are_found():
    assert len(list(check_writing.find_subject_faults(["Mend it", "x" * 72, "x" * 73]))) == 1


@pytest.mark.parametrize("head", ["What it is made of.", "Who reads it.", "Of the ground.", "Likewise."])
def test_attributes_and_constants_are_named_by_their_docstrings(head):
    for indent, before in (("", ""), ("    ", "class A:\n")):
        source = f'{before}{indent}x: int = 0\n{indent}"""{{}}"""\n'
        faults = list(check_writing.find_docstring_faults(source.format(head)))
        assert [line for line, _ in faults] == [source.count("\n")], "the text after the assignment"
        assert not list(check_writing.find_docstring_faults(source.format("Width of the pictures [px].")))
