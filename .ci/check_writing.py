"""Check the writing law of CONTRIBUTING.md as far as a script can: docstring heads, descriptions, commit subjects.

Docstrings are those of modules, classes and functions, and the texts that follow an attribute or a constant.

Prints one line per fault and exits with 1 if there is any.
"""

from __future__ import annotations

import ast
import itertools
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
LAW_SINCE = "01ff001"  # subjects of earlier commits are history
LONGEST_SUBJECT = 72

_HEAD = re.compile(r"(What|Who|Whose|How|Which|Where|When|Why|Whether)\b")
_GENITIVE = re.compile(r"\s+[\w, *]+: (Of |Likewise\b)")
_BARE_GENITIVE = re.compile(r"(Of |Likewise\b)")
_DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def find_docstring_faults(source: str) -> Iterator[tuple[int, str]]:
    """Yield (line, fault) of docstrings that break the law.

    Args:
        source: Text of a Python module.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, _DOCUMENTED) and (text := ast.get_docstring(node)):
            line = getattr(node, "lineno", 1)
            lines = text.splitlines()
            if _HEAD.match(lines[0]):
                yield line, f"the head does not name the thing: {lines[0]!r}"
            for each in lines:
                if _GENITIVE.match(each):
                    yield line, f"the description is no whole noun phrase: {each.strip()!r}"
        for line, text in _list_attribute_docstrings(node):
            head = text.strip().partition("\n")[0]
            if _HEAD.match(head):
                yield line, f"the head does not name the thing: {head!r}"
            if _BARE_GENITIVE.match(head):
                yield line, f"the description is no whole noun phrase: {head!r}"


def _list_attribute_docstrings(node: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield (line, text) of the strings that follow an assignment in a module's or a class's body."""
    if not isinstance(node, ast.Module | ast.ClassDef):
        return
    for assignment, after in itertools.pairwise(node.body):
        if not isinstance(assignment, ast.Assign | ast.AnnAssign) or not isinstance(after, ast.Expr):
            continue
        if isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
            yield after.lineno, after.value.value


def find_subject_faults(subjects: list[str]) -> Iterator[str]:
    """Yield a fault for each commit subject that is too long."""
    for subject in subjects:
        if len(subject) > LONGEST_SUBJECT:
            yield f"the commit subject has {len(subject)} characters, at most {LONGEST_SUBJECT}: {subject!r}"


def _list_files(*patterns: str) -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "--", *patterns], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    return [REPOSITORY / name for name in listed.stdout.split("\n") if name]


def _read_subjects() -> list[str] | None:
    """The subjects since the law; None where the history does not reach back to it."""
    command = ["git", "log", "--no-merges", "--format=%s", f"{LAW_SINCE}..HEAD"]
    logged = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True)
    return logged.stdout.splitlines() if logged.returncode == 0 else None


def main() -> int:
    """Check the whole checkout."""
    faults = [
        f"{path.relative_to(REPOSITORY)}:{line}: {fault}"
        for path in _list_files("*.py")
        if path.is_file()
        for line, fault in find_docstring_faults(path.read_text())
    ]
    subjects = _read_subjects()
    if subjects is None:
        print(f"commit subjects are not checked: the history does not hold {LAW_SINCE}")
    else:
        faults += find_subject_faults(subjects)
    print("\n".join(faults) or "the writing law holds")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
