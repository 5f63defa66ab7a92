"""Hand-written kernels of scenes."""
