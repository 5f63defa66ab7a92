"""Hashes of the code that figures depend on, now and at a revision.

Comments, docstrings and empty lines of Python files do not count: no figure changes by them.
"""

from __future__ import annotations

import ast
import hashlib
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path

from physagent_jax.core.errors import UserError

ROOT = Path(__file__).resolve().parents[2]


def hash_sources(sources: Sequence[str], revision: str | None = None) -> dict[str, str]:
    """A hash for each source: of the working tree's tracked files, or of those at a revision."""
    return {source: _hash_files(_list_files(source, revision), revision) for source in sources}


def is_known(revision: str) -> bool:
    """Return whether the repository has a commit."""
    return _run("cat-file", "-e", f"{revision}^{{commit}}") is not None


def is_checkout() -> bool:
    """Return whether this is a git checkout with all of its history."""
    return (_run("rev-parse", "--is-shallow-repository") or b"").strip() == b"false"


def find_newest(revisions: Iterable[str]) -> str | None:
    """The revision that was committed last; None where there are none."""
    return max(revisions, key=_read_time, default=None)


def find_oldest(revisions: Iterable[str]) -> str | None:
    """The revision that was committed first; None where there are none."""
    return min(revisions, key=_read_time, default=None)


def _read_time(revision: str) -> int:
    return int(_need("log", "-1", "--format=%ct", revision))


def read_date(revision: str) -> str:
    """The day on which a revision was committed."""
    return _need("log", "-1", "--format=%cs", revision).decode().strip()


def read_object(name: str) -> bytes:
    """A file at a revision, ``REVISION:PATH``."""
    return _need("show", name)


def strip_python(source: str) -> str:
    """Python code without docstrings, comment lines and empty lines; any other text as it is."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return source
    words: set[int] = set()  # lines of docstrings
    texts: set[int] = set()  # lines of strings that go over several
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and _is_string(node.value):
            words.update(_list_lines(node))
        elif _is_string(node) or isinstance(node, ast.JoinedStr):
            texts.update(lines if len(lines := _list_lines(node)) > 1 else ())
    kept = []
    for number, line in enumerate(source.splitlines(), 1):
        bare = line.strip()
        if number in texts - words or (number not in words and bare and not bare.startswith("#")):
            kept.append(line)
    return "\n".join(kept)


def _is_string(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _list_lines(node: ast.AST) -> range:
    return range(node.lineno, node.end_lineno + 1)  # type: ignore[attr-defined]


def _hash_files(names: Sequence[str], revision: str | None) -> str:
    digest = hashlib.sha256()
    for name, content in zip(names, _read_files(names, revision)):
        if name.endswith(".py"):
            content = strip_python(content.decode()).encode()
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def _list_files(source: str, revision: str | None) -> list[str]:
    if revision is None:
        named = _need("ls-files", "-z", "--", source)
        return sorted(name for name in named.decode().split("\0") if name and (ROOT / name).is_file())
    named = _need("ls-tree", "-r", "-z", "--name-only", revision, "--", source)
    return sorted(filter(None, named.decode().split("\0")))


def _read_files(names: Sequence[str], revision: str | None) -> list[bytes]:
    if revision is None:
        return [(ROOT / name).read_bytes() for name in names]
    asked = "".join(f"{revision}:{name}\n" for name in names).encode()
    answer, contents = _need("cat-file", "--batch", given=asked), []
    for _ in names:
        head, answer = answer.split(b"\n", 1)
        size = int(head.split()[-1])
        contents.append(answer[:size])
        answer = answer[size + 1 :]
    return contents


def _need(*words: str, given: bytes | None = None) -> bytes:
    found = _run(*words, given=given)
    if found is None:
        raise UserError(
            f"`git {' '.join(words[:3])}` failed", do="Run it in a git checkout with its whole history"
        )
    return found


def _run(*words: str, given: bytes | None = None) -> bytes | None:
    try:
        done = subprocess.run(["git", *words], cwd=Path(ROOT), input=given, capture_output=True)
    except FileNotFoundError:  # there is no git
        return None
    return done.stdout if done.returncode == 0 else None
