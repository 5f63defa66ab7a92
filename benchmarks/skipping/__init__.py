"""Benchmark of work that the simulator leaves out: what it saves, and that it changes nothing."""
