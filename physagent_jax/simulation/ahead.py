"""The kernels that every simulation needs, compiled while there is other work to do."""

from __future__ import annotations

from physagent_jax.kernels import ahead
from physagent_jax.mpm import kernels as transfers
from physagent_jax.render import kernels as blending


def list_targets() -> ahead.Targets:
    """The kernels that simulating and rendering any scene needs."""
    return transfers.AHEAD | blending.AHEAD


def compile_ahead() -> None:
    """Begin to compile what simulating and rendering any scene needs, unless the disk has it (`kernels.ahead`)."""
    ahead.start_compiling(list_targets())
