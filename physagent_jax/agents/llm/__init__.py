"""The agents that ask a chat model, their prompts, and answers that fit a schema (`structured.ask`)."""
