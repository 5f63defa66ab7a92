"""Singular values by hand-written kernels, where there are some (see `physagent_jax.kernels`)."""

from physagent_jax.kernels import load


def compiled():
    """The module of the CPU kernels, which needs Numba."""
    return load(f"{__name__}.cpu")
