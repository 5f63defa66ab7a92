"""The toy prior: a small video model trained here, to test the machinery of score distillation with."""
