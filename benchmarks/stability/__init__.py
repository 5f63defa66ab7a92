"""Does anything go wrong without saying so: `python -m benchmarks.stability --json OUT`."""
