"""Kernels compiled ahead: the first time on a machine, each in a process of its own.

Numba compiles for ten seconds or two, on one core, and only once; while an object is loaded and XLA compiles the rest,
the other cores can do it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable

from physagent_jax.kernels import load, use_cpu

_TRANSFERS, _BLENDING = "physagent_jax.mpm.kernels.handlers", "physagent_jax.render.kernels.handlers"
PLAYING = {
    "physagent_p2g_float32": (_TRANSFERS, "p2g", "float32"),
    "physagent_g2p_float32": (_TRANSFERS, "g2p", "float32"),
    "physagent_blend": (_BLENDING, "blend"),
}
"""What simulating and rendering any scene needs: target -> (module, arguments of its `handler`)."""

_running: dict[str, subprocess.Popen] = {}


def begin() -> None:
    """Starts compiling what `PLAYING` names and the disk does not have; does nothing where kernels are not used."""
    if not use_cpu():
        return
    from physagent_jax.kernels import store  # needs Numba, without which there is nothing to do

    for name, (module, *arguments) in PLAYING.items():
        if name not in _running and not store.has(name):
            script = f"from physagent_jax.kernels import ahead; ahead.compile_one({module!r}, {arguments!r})"
            _running[name] = subprocess.Popen(
                [sys.executable, "-c", script], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )


def compile_one(module: str, arguments: Iterable[str]) -> None:
    """Compiles a kernel into the store, in a process that was started for it."""
    load(module).handler(*arguments)


def wait_for(name: str) -> None:
    """Returns when nobody is compiling ``name``; whoever failed has left it to the caller."""
    if name in _running:
        _running.pop(name).wait()
