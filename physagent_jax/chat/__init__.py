"""Chat models: servers, files and recordings that answer messages in text, by a JSON schema where one is given.

`base` is the protocol, `registry.make_model` makes a model by name. Each adapter imports its package when it is made:
`openai_client` (any compatible server), `transformers_client` and `llama_client` (in process, from files) and `replay`
(recorded exchanges). Nothing here knows of motion or agents.
"""
