"""Packages that an optional part needs, imported when it is chosen."""

from __future__ import annotations

import importlib
from typing import Any

from physagent_jax.core.errors import MissingPackageError


def import_package(name: str, what: str, extra: str) -> Any:
    """A package that an optional part needs, of an extra of this project.

    Args:
        name: Name of the module.
        what: What needs it, for the message ("the chat model `llama`").
        extra: The extra.

    Raises:
        MissingPackageError: It is not installed, or cannot be imported.
    """
    try:
        return importlib.import_module(name)
    except (
        ImportError,
        OSError,
        RuntimeError,
    ) as error:  # a broken installation of torch raises any of these
        raise MissingPackageError(f"{what} needs a package ({error})", extra) from None
