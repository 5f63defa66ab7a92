"""The grammar: sentence -> mentions -> clauses -> `agents.intent.Intent`."""
