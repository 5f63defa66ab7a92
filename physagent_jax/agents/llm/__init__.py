"""Chat models, and answers of theirs that fit a schema.

`base` is the protocol, `structured.ask` the one way to a checked answer, `registry.make_model` makes a model by name.
Each adapter imports its package when it is made: `openai_client` (any compatible server), `transformers_client` and
`llama_client` (in process, from files) and `replay` (recorded exchanges).
"""
