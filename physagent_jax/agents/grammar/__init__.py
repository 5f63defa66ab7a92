"""The grammar: sentence -> mentions -> clauses -> `agents.intent.Intent`, for a documented language (`patterns.yaml`)."""
