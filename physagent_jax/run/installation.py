"""The packages that this one requires, by its own metadata, held against what is installed.

Imports nothing but the standard library: it must answer where packages are missing or broken. The metadata writes
requirements as PEP 508 has them; of that this reads names, extras, numeric versions and the marker ``extra``.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import json
import operator
import re
import warnings
from collections.abc import Iterable
from importlib import metadata
from urllib.parse import unquote

from physagent_jax.core.errors import UserError

PROJECT = "physagent-jax"

_REQUIREMENT = re.compile(
    r"(?P<name>[\w.-]+)\s*(?:\[(?P<extras>[^]]*)\])?\s*\(?(?P<clauses>[^;()]*)\)?\s*(?:;(?P<marker>.*))?"
)
_EXTRA_ONLY = re.compile(r"\s*extra\s*==\s*['\"]([\w.-]+)['\"]\s*")
_COMPARISONS = {
    "==": operator.eq, "!=": operator.ne, ">=": operator.ge, "<=": operator.le, ">": operator.gt, "<": operator.lt,
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Requirement:
    """A requirement of a package.

    Attributes:
        name: The distribution's name.
        clauses: Comparisons that its version must pass, such as ((">=", "0.10"), ("!=", "0.10.2")).
        asked: Extras of that distribution that come with it.
        extra: The extra that has this requirement; None = it always holds.
    """

    name: str
    clauses: tuple[tuple[str, str], ...] = ()
    asked: tuple[str, ...] = ()
    extra: str | None = None

    def __str__(self) -> str:
        asked = f"[{','.join(self.asked)}]" if self.asked else ""
        return self.name + asked + ",".join(f"{sign}{version}" for sign, version in self.clauses)


@dataclasses.dataclass(frozen=True)
class Package:
    """A required package as it was found.

    Attributes:
        name: The distribution's name.
        wanted: The requirement.
        installed: The version that is installed; None = none is.
        problem: The reason why it cannot be used; None = it can.
    """

    name: str
    wanted: str
    installed: str | None
    problem: str | None


@dataclasses.dataclass(frozen=True)
class Extra:
    """An optional part of this package.

    Attributes:
        name: The extra's name.
        missing: Requirements that nothing installed meets.
        command: The command that brings them; None = nothing is missing.
    """

    name: str
    missing: tuple[str, ...]
    command: str | None


def parse_requirement(text: str) -> Requirement | None:
    """A line of ``Requires-Dist``; None if its marker asks for more than an extra.

    Raises:
        ValueError: The line is no requirement.
    """
    found = _REQUIREMENT.fullmatch(text.strip())
    if found is None:
        raise ValueError(f"not a requirement: {text!r}")
    marker = found["marker"]
    extra = None if marker is None else _EXTRA_ONLY.fullmatch(marker)
    if marker is not None and extra is None:
        return None
    clauses = []
    for clause in filter(None, map(str.strip, found["clauses"].split(","))):
        sign = clause[:2] if clause[:2] in _COMPARISONS else clause[:1]
        if sign not in _COMPARISONS or not clause[len(sign) :].strip()[:1].isdigit():
            raise ValueError(f"not a requirement: {text!r}")
        clauses.append((sign, clause[len(sign) :].strip()))
    asked = tuple(filter(None, map(str.strip, (found["extras"] or "").split(","))))
    return Requirement(found["name"], tuple(clauses), asked, extra[1] if extra else None)


def is_allowed(version: str, clauses: Iterable[tuple[str, str]]) -> bool:
    """Return whether a version passes all comparisons; only its release counts ("2.6.0+cu124" is 2.6)."""
    return all(_COMPARISONS[sign](*_align(version, other)) for sign, other in clauses)


def find_requirements(name: str = PROJECT) -> tuple[Requirement, ...]:
    """The requirements of an installed distribution, those of its extras among them; () if it is not installed."""
    try:
        lines = metadata.requires(name) or []
    except metadata.PackageNotFoundError:
        return ()
    parsed = (parse_requirement(line) for line in lines)
    return tuple(each for each in parsed if each is not None)


def check_packages() -> tuple[Package, ...]:
    """The packages without which nothing works, each of them imported.

    Raises:
        UserError: This package itself is not installed, so that its requirements are not known.
    """
    required = [each for each in find_requirements() if each.extra is None]
    if not required:
        raise UserError(
            f"{PROJECT} is not installed, so that what it requires is not known",
            do="In a checkout: pip install -e .",
        )
    return tuple(_check_package(each) for each in required)


def check_extras() -> tuple[Extra, ...]:
    """The extras of this package; what they require is looked up, not imported."""
    try:
        names = metadata.metadata(PROJECT).get_all("Provides-Extra") or []
    except metadata.PackageNotFoundError:
        return ()
    missing = {name: tuple(_find_missing(PROJECT, name)) for name in sorted(names)}
    return tuple(
        Extra(name, gone, f"pip install {_name_target(name)}" if gone else None)
        for name, gone in missing.items()
    )


def make_command(packages: Iterable[Package]) -> str:
    """The command that installs what cannot be used of ``packages``."""
    return "pip install " + " ".join(f"'{each.wanted}'" for each in packages if each.problem)


def _check_package(wanted: Requirement) -> Package:
    installed = _find_version(wanted.name)
    problem = None
    if installed is None:
        problem = "is not installed"
    elif not is_allowed(installed, wanted.clauses):
        excluded = any(sign == "!=" and not is_allowed(installed, [(sign, v)]) for sign, v in wanted.clauses)
        problem = f"{installed} is excluded" if excluded else f"{installed} is too old or too new"
    else:
        problem = _find_import_error(wanted.name)
    return Package(wanted.name, str(wanted), installed, problem)


def _find_import_error(name: str) -> str | None:
    """The reason why a distribution's modules cannot be imported; None if they can, or it names none."""
    for module in _list_modules().get(_normalise(name), []):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                importlib.import_module(module)
        except Exception as error:  # whatever an import runs into is what is asked for
            first = (str(error).splitlines() or [""])[0]
            return f"cannot be imported ({type(error).__name__}: {first})"
    return None


@functools.cache
def _list_modules() -> dict[str, list[str]]:
    """The public top-level modules of all installed distributions."""
    found: dict[str, list[str]] = {}
    for module, names in metadata.packages_distributions().items():
        if module.isidentifier() and not module.startswith("_"):
            for name in names:
                found.setdefault(_normalise(name), []).append(module)
    return found


def _find_missing(owner: str, extra: str) -> Iterable[str]:
    """Requirements of a distribution's extra that are not met, and those of the extras that they ask for."""
    for each in find_requirements(owner):
        if each.extra is None or _normalise(each.extra) != _normalise(extra):
            continue
        installed = _find_version(each.name)
        if installed is None or not is_allowed(installed, each.clauses):
            yield str(each)
        elif _normalise(each.name) != _normalise(owner):
            for asked in each.asked:
                yield from _find_missing(each.name, asked)


def _find_version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _name_target(extra: str) -> str:
    """The argument of pip for an extra: the checkout, where this package is installed from one."""
    try:
        origin = json.loads(metadata.distribution(PROJECT).read_text("direct_url.json") or "{}")
    except (metadata.PackageNotFoundError, ValueError):
        origin = {}
    if origin.get("dir_info", {}).get("editable"):
        return f"-e '{unquote(origin['url'].removeprefix('file://'))}[{extra}]'"
    return f"'{PROJECT}[{extra}]'"


def _align(*versions: str) -> list[tuple[int, ...]]:
    """The releases of versions, filled up with zeros to the same length."""
    numbers = [[int(part) for part in re.findall(r"\d+", _find_release(each))] for each in versions]
    longest = max(map(len, numbers))
    return [tuple(each + [0] * (longest - len(each))) for each in numbers]


def _find_release(version: str) -> str:
    found = re.match(r"\d+(\.\d+)*", version)
    return found[0] if found else "0"


def _normalise(name: str) -> str:
    """A distribution's name as all spellings of it compare (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()
