"""The agents of the loop: semantic (sentence -> force field), planner (judges) and executor (rewrites).

`protocols` are the contracts: each agent is called with a `context` and returns a value of a schema (here or in
`motion`) with a `trace` of how it came about. `registry` makes them by name; `rules` implements them offline, `llm` by
asking a chat model. `hard_rules` repairs any force field, whoever wrote it. No arrays, no jax.
"""
