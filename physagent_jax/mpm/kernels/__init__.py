"""P2G, G2P and singular values by hand-written kernels where there are some, else by pure JAX (`mpm.transfer`)."""

from physagent_jax.kernels import Kernels as Kernels
from physagent_jax.kernels import beside as beside
from physagent_jax.kernels import chosen as chosen
from physagent_jax.kernels import load
from physagent_jax.kernels import use_cpu as use_cpu
from physagent_jax.kernels import using as using


def compiled():
    """The module of the CPU kernels, which needs Numba."""
    return load("physagent_jax.mpm.kernels.cpu")
