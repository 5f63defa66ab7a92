"""The agents of the loop: semantic (sentence -> force field), planner (judges) and executor (rewrites).

`protocols` are the contracts: each agent is called with a `context` and returns a `schema` value with a `trace` of how
it came about. `registry` makes them by name; `rules` implements them offline. `hard_rules` repairs any force field,
whoever wrote it. No arrays, no jax.
"""
