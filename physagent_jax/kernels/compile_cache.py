"""Compiled programs that outlive their process."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import jax

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import programs
from physagent_jax.kernels.folders import describe_processor, is_usable, make_private_folder

CACHE_VARIABLE = "PHYSAGENT_COMPILE_CACHE"
_OFF = ("off", "0", "no", "none", "false")


def enable_compile_cache() -> None:
    """Keep compiled programs between processes, so that only the first run pays for compilation.

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
    config: Any = jax.config
    if config.jax_compilation_cache_dir is not None:
        return
    if not setting:
        programs.keep_on_disk(make_private_folder("compiled", describe_processor()))
    elif is_usable(folder := Path(setting).expanduser() / describe_processor()):
        programs.keep_on_disk(folder)
    else:
        raise UserError(
            f"`{CACHE_VARIABLE}` must name a folder that only you may write to",
            got=setting,
            do='Name another, or "off"',
        )
