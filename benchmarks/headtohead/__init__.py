"""All methods on the same tasks with equal budgets: `python -m benchmarks.headtohead`."""
