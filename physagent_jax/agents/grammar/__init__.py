"""Grammar of a documented language (`patterns.yaml`): sentence -> mentions -> clauses -> `agents.intent.Intent`."""
