"""Benchmark of the offline executor from wrong force fields, and of the two kinds of skill."""
