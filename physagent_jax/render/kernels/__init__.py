"""Blending by hand-written kernels, where there are some (see `physagent_jax.kernels`)."""
