"""P2G and G2P by hand-written kernels where there are some, else by pure JAX (`mpm.transfer`)."""

from physagent_jax.kernels import Kernels as Kernels
from physagent_jax.kernels import beside as beside
from physagent_jax.kernels import chosen as chosen
from physagent_jax.kernels import load
from physagent_jax.kernels import use_cpu as use_cpu
from physagent_jax.kernels import using as using

AHEAD = {
    f"physagent_{kernel}_float32": (f"{__name__}.handlers", kernel, "float32") for kernel in ("p2g", "g2p")
}
"""For `kernels.ahead`: what every simulation needs."""


def compiled():
    """The module of the CPU kernels, which needs Numba."""
    return load(f"{__name__}.cpu")
