"""Gradient and score-distillation methods on the same simulator and the same scenes as the agent loop."""
