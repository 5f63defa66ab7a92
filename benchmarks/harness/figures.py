"""Figures, where matplotlib is installed."""

from __future__ import annotations

from typing import Any

from benchmarks.harness.command import say
from physagent_jax.core.errors import UserError


def import_pyplot() -> Any:
    """``matplotlib.pyplot``, drawing into files.

    Raises:
        UserError: matplotlib is not installed.
    """
    try:
        import matplotlib
    except ModuleNotFoundError:
        raise UserError("plots need matplotlib", do="Install the extra `benchmarks`") from None
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def can_plot() -> bool:
    """Return whether figures can be drawn; where they cannot, this is said, before anything is measured."""
    try:
        import_pyplot()
    except UserError as error:
        say(str(error))
        return False
    return True
