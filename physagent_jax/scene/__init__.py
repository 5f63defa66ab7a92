"""Scenes: configuration, object loading and placement, filling, material priors, anchors, imports."""
