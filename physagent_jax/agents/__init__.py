"""The agents of the loop: semantic (sentence -> force field), planner (judges) and executor (rewrites).

`schema` and `protocols` are the contracts; `rules` implements them offline. `hard_rules` repairs any force field,
whoever wrote it. No arrays, no jax.
"""
