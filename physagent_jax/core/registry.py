"""Implementations chosen by name: each is imported when it is chosen, with whatever heavy package it needs."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name, suggest

Choice = str | tuple[str, Mapping[str, Any]]
"""A name, or a name with the options that the implementation is made with."""


@dataclasses.dataclass(frozen=True)
class Registry:
    """Implementations of one protocol.

    Attributes:
        what: What is chosen, as the user would say ("`agents.planner`").
        entries: "module:attribute" of a callable that makes the implementation from its options, by name. What it can
            be called with by keyword are the options; it refuses their values itself, with a `UserError`.
    """

    what: str
    entries: Mapping[str, str]

    def check(self, name: str) -> str:
        """``name``, if there is such an entry.

        Raises:
            UserError: There is none.
        """
        if name not in self.entries:
            raise explain_unknown_name(self.what, name, self.entries)
        return name

    def make(self, choice: Choice) -> Any:
        """The implementation that is chosen.

        Raises:
            UserError: There is no such entry, the package that it needs is missing, or it does not have such options.
        """
        name, options = (choice, {}) if isinstance(choice, str) else choice
        module, attribute = self.entries[self.check(name)].split(":")
        try:
            factory = getattr(importlib.import_module(module), attribute)
        except ImportError as error:
            missing = f"{self.what} {name!r} needs a package that is not installed"
            raise UserError(missing, got=error, do="Install it, or choose another") from None
        _check_options(f"{self.what} {name!r}", options, factory)
        return factory(**options)


def _check_options(what: str, options: Mapping[str, Any], factory: Callable[..., Any]) -> None:
    """Raise what is wrong with the names of ``options`` before ``factory`` is called: errors inside are its own."""
    taken = _list_parameters(factory)
    if not any(each.kind is each.VAR_KEYWORD for each in taken):
        names = [each.name for each in taken if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
        unknown = [name for name in options if name not in names]
        if unknown:
            hint = suggest(unknown[0], names) if names else "It takes none"
            raise UserError(f"{what} does not take these options", got=", ".join(unknown)[:80], do=hint)
    needed = [each.name for each in taken if each.default is each.empty and each.kind not in _COLLECTING]
    missing = [name for name in needed if name not in options]
    if missing:
        raise UserError(
            f"{what} needs the options {', '.join(f'`{name}`' for name in missing)}", do="Give them"
        )


_COLLECTING = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)


def _list_parameters(factory: Callable[..., Any]) -> list[inspect.Parameter]:
    """Parameters with which ``factory`` can be called.

    A class that derives from a protocol and has no ``__init__`` of its own inherits `typing`'s until it is first made
    and `object`'s afterwards: both seem to take anything and take nothing.
    """
    if isinstance(factory, type) and factory.__new__ is object.__new__:
        init = factory.__init__
        if init is object.__init__ or getattr(init, "__module__", "") == "typing":
            return []
    return list(inspect.signature(factory).parameters.values())
