"""`physagent doctor`: what is installed, what is missing, and the command that brings it."""

import importlib.metadata
import json
import subprocess
import sys

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from physagent_jax.cli import main
from physagent_jax.run.installation import (
    PROJECT,
    check_extras,
    check_packages,
    is_allowed,
    parse_requirement,
)

VERSIONS = "0.9 0.10 0.10.0 0.10.1 0.10.2 0.11 0.11.0 0.11.1 0.11.2 0.36 1 1.2.0 1.7 1.19 2 2.0 2.6.1 3.11 13".split()
WITHOUT = (
    "import sys; sys.modules[{module!r}] = None; from physagent_jax.cli import main; sys.exit(main({line!r}))"
)


@pytest.fixture(autouse=True)
def no_cache(monkeypatch):
    monkeypatch.setenv("PHYSAGENT_COMPILE_CACHE", "off")


@pytest.fixture
def installed(monkeypatch):
    """Let a distribution appear in another version; None = it is not installed."""
    changed, read = {}, importlib.metadata.version

    def version(name):
        if name not in changed:
            return read(name)
        if changed[name] is None:
            raise importlib.metadata.PackageNotFoundError(name)
        return changed[name]

    monkeypatch.setattr(importlib.metadata, "version", version)
    return changed


def run_without(module, *line):
    """Run a command in a process of its own in which a module cannot be imported."""
    script = WITHOUT.format(module=module, line=list(line))
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)


def test_a_complete_installation_in_json(capsys):
    """Exit code 0, and the versions are those of the packages themselves."""
    import jax
    import numpy

    assert main(["doctor", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    versions = {each["name"]: each["installed"] for each in said["packages"]}
    assert (versions["jax"], versions["numpy"]) == (jax.__version__, numpy.__version__)
    assert said["problems"] == [] and said["python"] == sys.version.split()[0]
    assert said["compute"]["platform"] == jax.default_backend()
    assert len(said["compute"]["devices"]) == len(jax.devices())
    assert 1 <= said["threads"]["kernels"] <= said["threads"]["usable"] <= said["threads"]["cores"]
    assert "libx264" in said["video"] and said["free_disk"] > 0
    assert {each["name"] for each in said["caches"]} >= {"programs"}


def test_a_complete_installation_in_words(capsys):
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert out.endswith("all that a run needs is there\n")
    for title in ("python", "packages", "devices", "kernels", "threads", "caches", "video", "free", "extras"):
        assert f"\n{title:<10} " in out


def test_requirements_are_read_as_packaging_reads_them():
    """All lines of the project's own metadata and those of jax, and their comparisons of versions."""
    read = 0
    for name in (PROJECT, "jax", "numba", "pydantic"):
        for line in importlib.metadata.requires(name) or ():
            mine, theirs = parse_requirement(line), Requirement(line)
            if mine is None:
                assert theirs.marker is not None
                continue
            read += 1
            assert (mine.name, set(mine.asked)) == (theirs.name, theirs.extras)
            assert SpecifierSet(",".join(map("".join, mine.clauses))) == theirs.specifier
            assert (mine.extra is None) == (theirs.marker is None)
            assert theirs.marker is None or theirs.marker.evaluate({"extra": mine.extra})
            for version in VERSIONS:
                assert is_allowed(version, mine.clauses) == theirs.specifier.contains(version), (
                    line,
                    version,
                )
    assert read > 30


@pytest.mark.parametrize("line", ["", "numpy>=", "numpy >> 2", "a b", "numpy=2", "[x]"])
def test_what_is_no_requirement(line):
    with pytest.raises(ValueError, match="not a requirement"):
        parse_requirement(line)


@pytest.mark.parametrize("version", ["0.10.2", "0.11.0", "0.11.1"])
def test_versions_of_jax_that_are_excluded(version, installed, capsys):
    """They give wrong results: exit code 2, the reason, and the command that brings another one."""
    installed["jax"] = version
    assert main(["doctor"]) == 2
    out, err = capsys.readouterr()
    assert f"jax {version} is excluded" in out
    assert err.startswith("physagent: ") and err.count("\n") == 1
    assert "pip install 'jax" in err and f"!={version}" in err


def test_packages_that_are_missing_or_too_old(installed):
    installed |= {"plyfile": None, "scipy": "1.2.0"}
    found = {each.name: each.problem for each in check_packages() if each.problem}
    assert found == {"plyfile": "is not installed", "scipy": "1.2.0 is too old or too new"}


def test_extras_and_the_commands_that_bring_them(installed):
    """Also what an extra of another package asks for, such as CUDA's plugin for JAX."""
    installed |= {"optax": None, "jax-cuda13-plugin": None}
    found = {each.name: each for each in check_extras()}
    assert set(found) == set(importlib.metadata.metadata(PROJECT).get_all("Provides-Extra"))
    assert "optax>=0.2.5" in found["baselines"].missing
    assert "[baselines]" in found["baselines"].command and "pip install" in found["baselines"].command
    assert any(each.startswith("jax-cuda13-plugin") for each in found["cuda"].missing)


def test_an_extra_that_is_complete(installed):
    lines = [Requirement(line) for line in importlib.metadata.requires(PROJECT)]
    installed |= {
        each.name: "999" for each in lines if each.marker and each.marker.evaluate({"extra": "sds"})
    }
    (sds,) = [each for each in check_extras() if each.name == "sds"]
    assert (sds.missing, sds.command) == ((), None)


@pytest.mark.parametrize(
    ("module", "name"), [("tyro", "tyro"), ("pydantic", "pydantic"), ("jax", "jax"), ("yaml", "pyyaml"), ("av", "av")]
)  # fmt: skip
def test_it_works_without_packages(module, name):
    """Whichever is missing: the report stands, one line says what to do, and there is no traceback."""
    done = run_without(module, "doctor", "--json")
    assert done.returncode == 2 and "Traceback" not in done.stderr
    said = json.loads(done.stdout)
    broken = {each["name"] for each in said["packages"] if each["problem"]}
    assert name in broken
    lines = [line for line in done.stderr.splitlines() if line.startswith("physagent: ")]
    assert len(lines) == 1 and name in lines[0] and "pip install" in lines[0]


def test_other_commands_point_to_it():
    """A package that is missing is one line, not a traceback."""
    done = run_without("tyro", "materials")
    assert done.returncode == 2
    assert done.stderr == "physagent: the package `tyro` is missing. `physagent doctor` says how to get it.\n"


@pytest.mark.parametrize(
    ("name", "value"),
    [("NUMBA_NUM_THREADS", "0"), ("XLA_FLAGS", "--no_such_flag"), ("PHYSAGENT_COMPILE_CACHE", "a\tb")],
)  # fmt: skip
def test_an_environment_that_a_run_refuses(name, value, monkeypatch, capsys):
    """It is reported, and the variable is listed."""
    monkeypatch.setenv(name, value)
    assert main(["doctor"]) == 2
    out, err = capsys.readouterr()
    assert f"{name}={value}" in out and name in err and err.count("physagent: ") == 1


def test_options_that_it_does_not_have(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["doctor", "--jsno"])
    assert stopped.value.code == 2
