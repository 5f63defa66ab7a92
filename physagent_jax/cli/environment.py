"""What commands that compute need of their surroundings: checked, and set up, before they begin."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import unknown_name

CACHE_VARIABLE = "PHYSAGENT_COMPILE_CACHE"
_OFF = ("off", "0", "no", "none", "false")
_LAYERS = ("default", "safe", "forksafe", "threadsafe", "tbb", "omp", "workqueue")


def prepare() -> None:
    """Checks the environment, and lets compiled programs be kept.

    Raises:
        UserError: A variable makes no sense, or asks for what this machine does not have.
    """
    _check_numba()
    try:
        import jax
    except (ValueError, RuntimeError) as error:  # a JAX_... variable of the wrong type
        raise UserError(
            f"JAX does not accept the environment: {error}", do="Mend or unset the variable"
        ) from error
    _check_xla_flags()
    config: Any = jax.config  # its flags are not typed
    if config.jax_disable_jit:
        raise UserError(
            "`JAX_DISABLE_JIT` runs a simulation operation by operation, which would take hours",
            do="Unset it",
        )
    enable_compile_cache()
    try:
        jax.devices()
    except (RuntimeError, AssertionError) as error:  # the latter for "cuda" where its plugin is not installed
        raise UserError(
            "JAX finds no such device",
            got=f"JAX_PLATFORMS={os.environ.get('JAX_PLATFORMS', '')}: {error}".strip(": ").splitlines()[0],
            do="Unset `JAX_PLATFORMS`, or set it to cpu",
        ) from error


def enable_compile_cache() -> None:
    """Keeps compiled programs between processes, so that only the first run pays for compilation.

    ``PHYSAGENT_COMPILE_CACHE`` names another folder, or turns it off with ``off``. A folder set through JAX's own
    configuration is left alone. Within the folder, programs lie in one that is private to the user, because JAX loads
    code from it, and belongs to this kind of processor.

    Raises:
        UserError: ``PHYSAGENT_COMPILE_CACHE`` is no folder to write to.
    """
    setting = os.environ.get(CACHE_VARIABLE, "")
    if not setting.isprintable():
        raise UserError(f"`{CACHE_VARIABLE}` is no text", got=ascii(setting), do='Name a folder, or "off"')
    if setting.lower() in _OFF:
        return
    import jax

    from physagent_jax.kernels import programs
    from physagent_jax.kernels.folders import private_folder, processor, usable

    config: Any = jax.config
    if config.jax_compilation_cache_dir is not None:
        return
    if not setting:
        programs.keep_on_disk(private_folder("compiled", processor()))
    elif usable(folder := Path(setting).expanduser() / processor()):
        programs.keep_on_disk(folder)
    else:
        raise UserError(
            f"`{CACHE_VARIABLE}` must name a folder that only you may write to",
            got=setting,
            do='Name another, or "off"',
        )


def _check_numba() -> None:
    count = os.environ.get("NUMBA_NUM_THREADS")
    if count is not None and not (count.isascii() and count.isdigit() and 0 < int(count[:5]) < 10_000):
        raise UserError(
            "`NUMBA_NUM_THREADS` must be a whole number from 1", got=count, do="Unset it to use all cores"
        )
    layer = os.environ.get("NUMBA_THREADING_LAYER")
    if layer is not None and layer not in _LAYERS:
        raise unknown_name("`NUMBA_THREADING_LAYER`", layer, _LAYERS)


def _check_xla_flags() -> None:
    """Tries the flags in a process of its own: XLA ends the process that has a flag it does not know."""
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
