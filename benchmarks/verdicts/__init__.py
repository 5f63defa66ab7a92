"""Clips with a right or a wrong motion for a sentence, and whether the planner tells them apart."""
