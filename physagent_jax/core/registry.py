"""What can be chosen by name: each entry is imported when it is chosen, with whatever heavy package it needs."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import unknown_name

Choice = str | tuple[str, Mapping[str, Any]]
"""A name, or a name with the options that the implementation is made with."""


@dataclasses.dataclass(frozen=True)
class Registry:
    """Implementations of one protocol.

    Attributes:
        what: What is chosen, as the user would say ("`agents.planner`").
        entries: "module:attribute" of a callable that makes the implementation from its options, by name.
    """

    what: str
    entries: Mapping[str, str]

    def check(self, name: str) -> str:
        """``name``, if there is such an entry.

        Raises:
            UserError: There is none.
        """
        if name not in self.entries:
            raise unknown_name(self.what, name, self.entries)
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
        try:
            return factory(**options)
        except TypeError as error:
            raise UserError(f"{self.what} {name!r} does not take these options", got=error) from None
