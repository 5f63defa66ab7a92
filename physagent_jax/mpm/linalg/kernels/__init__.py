"""Singular values by hand-written kernels, where there are some (see `physagent_jax.kernels`)."""

from physagent_jax.kernels import import_kernels


def load_cpu_kernels():
    """The module of the CPU kernels, which needs Numba."""
    return import_kernels(f"{__name__}.cpu")
