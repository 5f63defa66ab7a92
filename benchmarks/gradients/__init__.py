"""Benchmark of the gradient of a simulation: its cost, its parts and its precision."""
