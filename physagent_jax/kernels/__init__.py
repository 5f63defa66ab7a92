"""Hand-written kernels: what chooses them, and the plumbing that they share.

The kernels themselves lie where their work is: a package that has some has a folder ``kernels``, and nothing here
knows which do. "auto" takes those of the CPU where the arrays lie on one, or JAX puts them there, and Numba is
installed, and those of CUDA likewise; "reference" is the pure JAX path, "cpu" and "cuda" insist. All give the same
numbers to round-off; forward-mode derivatives exist for the reference only.

Here: SIMD values (`lanes`), XLA's calling convention (`ffi`), the threads that run a kernel together (`team`), the
store of compiled code, and CUDA's compiler and driver (`cuda`).
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any, Literal

import jax
from jax.core import Tracer

from physagent_jax.core.errors import UserError
from physagent_jax.core.once import once
from physagent_jax.kernels.forks import refuse_fork

Kernels = Literal["auto", "reference", "cpu", "cuda"]
log = logging.getLogger(__name__)
_chosen: ContextVar[Kernels] = ContextVar("kernels", default="auto")


@contextmanager
def use_kernels(choice: Kernels) -> Iterator[None]:
    """Let ``choice`` hold for what is traced within, where nobody passes it on."""
    token = _chosen.set(choice)
    try:
        yield
    finally:
        _chosen.reset(token)


@contextmanager
def use_device_of(array: Any) -> Iterator[None]:
    """Let what is computed within be made for the device on which ``array`` lies; JAX's own choice if it is traced.

    Raises:
        UserError: This process was forked from one that computes.
    """
    refuse_fork()
    known = isinstance(array, jax.Array) and not isinstance(array, Tracer)
    device = next(iter(array.devices())) if known else None
    with (
        nullcontext() if device is None or device.platform == find_platform() else jax.default_device(device)
    ):
        yield


def find_platform() -> str:
    """The platform of new arrays: JAX's default device, if one is set, else its backend."""
    device: Any = jax.config.jax_default_device  # type: ignore[attr-defined]
    if device is None:
        return jax.default_backend()
    return device if isinstance(device, str) else device.platform


def use_cpu(kernels: Kernels | None = None) -> bool:
    """Return whether the CPU kernels are to be used; None = as `use_kernels` says.

    Raises:
        UserError: "cpu" is asked for, and not to be had.
    """
    return _decide("cpu", kernels or _chosen.get(), _explain_missing)


def use_cuda(kernels: Kernels | None = None) -> bool:
    """Return whether the CUDA kernels are to be used; None = as `use_kernels` says.

    Raises:
        UserError: "cuda" is asked for, and not to be had.
    """
    return _decide("cuda", kernels or _chosen.get(), _explain_missing_cuda)


def _decide(kind: Kernels, chosen: Kernels, explain: Callable[[], str]) -> bool:
    """Return whether kernels of this kind are to be used, ``explain`` saying why they cannot be."""
    if chosen not in ("auto", kind):
        return False
    missing = explain()
    if chosen == kind and missing:
        raise UserError(f'`kernels="{kind}"` cannot be used: {missing}', do='Use "auto" or "reference"')
    return not missing


def import_kernels(module: str):
    """A module that needs Numba."""
    return importlib.import_module(module)


def describe_kernels(kernels: Kernels) -> str:
    """Describe the kernels in use, for a run's manifest."""
    if use_cuda(kernels):
        return "cuda"
    if not use_cpu(kernels):
        return "reference"
    from physagent_jax.kernels.threads import thread_count

    return f"cpu ({thread_count()} threads)"


def explain_reference() -> str:
    """The reason why "auto" takes pure JAX; "" if it takes kernels."""
    return _explain_missing_cuda() if find_platform() == "gpu" else _explain_missing()


def _explain_missing() -> str:
    """The reason why there are no CPU kernels; "" if there are."""
    if find_platform() != "cpu":
        return f"JAX runs on {find_platform()}"
    return numba_missing()


def _explain_missing_cuda() -> str:
    """The reason why there are no CUDA kernels; "" if there are."""
    if find_platform() != "gpu":
        return f"JAX runs on {find_platform()}"
    return numba_missing() or import_kernels("physagent_jax.kernels.cuda").explain_missing()


@once
def numba_missing() -> str:
    """The reason why Numba's kernels are unavailable; "" if they are available."""
    try:
        import_kernels("physagent_jax.kernels.lanes")
    except ImportError as error:
        log.warning("the CPU kernels are not available (%s): pure JAX serves, several times slower", error)
        return str(error)
    return ""
