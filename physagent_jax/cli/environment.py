"""The environment of commands that compute: checked and set up before they begin."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

from physagent_jax.core.errors import UserError


def prepare() -> None:
    """Check the environment, and let compiled programs be kept.

    Raises:
        UserError: A variable makes no sense, or asks for what this machine does not have.
    """
    try:
        import jax
    except (ValueError, RuntimeError) as error:  # a JAX_... variable of the wrong type
        raise UserError(
            f"JAX does not accept the environment: {error}", do="Mend or unset the variable"
        ) from error
    from physagent_jax.kernels.threads import read_limit

    read_limit()
    _check_xla_flags()
    config: Any = jax.config  # its flags are not typed
    if config.jax_disable_jit:
        raise UserError(
            "`JAX_DISABLE_JIT` runs a simulation operation by operation, which would take hours",
            do="Unset it",
        )
    from physagent_jax.kernels.compile_cache import enable_compile_cache

    enable_compile_cache()
    try:
        jax.devices()
    except (RuntimeError, AssertionError) as error:  # the latter for "cuda" where its plugin is not installed
        raise UserError(
            "JAX finds no such device",
            got=f"JAX_PLATFORMS={os.environ.get('JAX_PLATFORMS', '')}: {error}".strip(": ").splitlines()[0],
            do="Unset `JAX_PLATFORMS`, or set it to cpu",
        ) from error


def _check_xla_flags() -> None:
    """Try the flags in a process of its own: XLA ends the process that has a flag it does not know."""
    flags = os.environ.get("XLA_FLAGS", "").strip()
    if not flags:
        return
    tried = subprocess.run(
        [sys.executable, "-c", "import jax; jax.devices()"],
        env=os.environ | {"JAX_PLATFORMS": "cpu"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
    )
    if tried.returncode:
        raise UserError("XLA does not accept `XLA_FLAGS`", got=flags, do="Mend or unset it")
