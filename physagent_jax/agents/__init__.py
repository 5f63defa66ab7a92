"""The agents of the loop: semantic (sentence -> force field), planner (judges) and executor (rewrites).

`schema` and `protocols` are the contracts; `rule_semantic`, `rule_planner` and `rule_executor` implement
them offline. `hard_rules` repairs any force field, whoever wrote it. No arrays, no jax.
"""
