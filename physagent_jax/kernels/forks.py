"""Refusal of forked processes in which JAX would hang: they have none of the threads with which the parent computes."""

from __future__ import annotations

import os
from typing import Any

from jax._src import xla_bridge

from physagent_jax.core.errors import UserError

_bridge: Any = xla_bridge
_parent_computes = _is_stuck = False


def refuse_fork() -> None:
    """Called first by whatever computes.

    Raises:
        UserError: This process was forked from one that had JAX compute before.
    """
    if _is_stuck:
        raise UserError(
            "JAX cannot compute in a process that was forked from one in which it has computed",
            do='Start processes with `multiprocessing.get_context("spawn")`, or fork before anything is computed',
        )


def _look_before() -> None:
    global _parent_computes
    _parent_computes = _bridge.backends_are_initialized()


def _look_after() -> None:
    global _is_stuck
    _is_stuck = _is_stuck or _parent_computes


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_look_before, after_in_child=_look_after)
