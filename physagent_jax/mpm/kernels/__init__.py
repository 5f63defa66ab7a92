"""P2G and G2P by hand-written kernels where there are some, else by pure JAX (`mpm.transfer`)."""

from physagent_jax.kernels import Kernels as Kernels
from physagent_jax.kernels import describe_kernels as describe_kernels
from physagent_jax.kernels import import_kernels
from physagent_jax.kernels import use_cpu as use_cpu
from physagent_jax.kernels import use_cuda as use_cuda
from physagent_jax.kernels import use_device_of as use_device_of
from physagent_jax.kernels import use_kernels as use_kernels

AHEAD = {
    f"physagent_{kernel}_float32": (f"{__name__}.handlers", kernel, "float32") for kernel in ("p2g", "g2p")
}
"""For `kernels.ahead`: what every simulation needs."""


def load_cpu_kernels():
    """The module of the CPU kernels, which needs Numba."""
    return import_kernels(f"{__name__}.cpu")


def load_cuda_kernels():
    """The module of the CUDA kernels, which needs Numba."""
    return import_kernels(f"{__name__}.cuda")
