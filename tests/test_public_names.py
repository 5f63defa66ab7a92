"""The use of the package from beside it: no private names, and no part of the command line."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = "physagent_jax"
COMMAND = f"{PACKAGE}.cli"
BESIDE = ("baselines", "benchmarks", "examples", "tests")
FILES = sorted(path for folder in BESIDE for path in (ROOT / folder).rglob("*.py"))
OF_JAX = ("_cache_size",)  # how many programs a jitted function has compiled
ABOUT_THE_COMMAND_LINE = ("tests/test_cli", "tests/test_stopping")


def is_private(name: str) -> bool:
    parts = [part for part in name.split(".") if part not in OF_JAX]
    return any(part.startswith("_") and not part.startswith("__") for part in parts)


def imported(tree: ast.AST) -> dict[str, str]:
    """Dotted names from the package by the names that they have in the file."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found |= {each.asname or each.name: f"{node.module}.{each.name}" for each in node.names}
        elif isinstance(node, ast.Import):
            found |= {each.asname or each.name.split(".")[0]: each.name if each.asname else each.name.split(".")[0]
                      for each in node.names}  # fmt: skip
    return {name: place for name, place in found.items() if place.split(".")[0] == PACKAGE}


def used(tree: ast.AST) -> list[str]:
    """Dotted names of the package that the file imports, and what it reads or sets of them."""
    names = imported(tree)
    modules = [each.name for node in ast.walk(tree) if isinstance(node, ast.Import) for each in node.names]
    found = [*names.values(), *(name for name in modules if name.split(".")[0] == PACKAGE)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            attributes, base = [node.attr], node.value
            while isinstance(base, ast.Attribute):
                attributes, base = [base.attr, *attributes], base.value
            if isinstance(base, ast.Name) and base.id in names:
                found.append(".".join([names[base.id], *attributes]))
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("setattr"):
            target, *rest = [*node.args, ast.Constant("")]
            if isinstance(target, ast.Name) and target.id in names and isinstance(rest[0], ast.Constant):
                found.append(f"{names[target.id]}.{rest[0].value}")
    return found


def breaches(text: str, place: str) -> list[str]:
    found = []
    for name in used(ast.parse(text)):
        if is_private(name):
            found.append(f"{name} is private")
        if f"{name}.".startswith(f"{COMMAND}.") and not place.startswith(ABOUT_THE_COMMAND_LINE):
            if name != f"{COMMAND}.main" or not place.startswith("tests/"):
                found.append(f"{name} is of the command line")
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_nothing_reaches_inside_the_package(path):
    assert breaches(path.read_text(), path.relative_to(ROOT).as_posix()) == []


@pytest.mark.parametrize(
    ("text", "place", "count"),
    [
        ("from physagent_jax.render.renderer import _rasterize", "tests/a.py", 1),
        ("from physagent_jax.render import renderer as r\nr._rasterize()", "tests/a.py", 1),
        ("import physagent_jax.render._kernels", "benchmarks/a.py", 1),
        ("import physagent_jax as pa\npa.run.loop._Loop", "examples/a.py", 1),
        ("from physagent_jax.run import loop\nmonkeypatch.setattr(loop, '_ask', 3)", "tests/a.py", 1),
        ("from physagent_jax.cli.run import Run", "tests/run/a.py", 1),
        ("from physagent_jax import cli", "baselines/a.py", 1),
        ("from physagent_jax.cli import main", "benchmarks/a.py", 1),
        ("from physagent_jax.cli import main", "tests/a.py", 0),
        ("from physagent_jax.cli.run import Run", "tests/test_cli_input.py", 0),
        ("from physagent_jax.mpm.frame import advance\nadvance._cache_size()", "tests/a.py", 0),
        ("from benchmarks.peers import _warp_kernels", "benchmarks/a.py", 0),
        ("import physagent_jax as pa\npa.__version__\nfrom physagent_jax.agents import protocols", "tests/a.py", 0),
    ],
)  # fmt: skip
def test_the_check_sees_what_it_should(text, place, count):
    assert len(breaches(text, place)) == count
