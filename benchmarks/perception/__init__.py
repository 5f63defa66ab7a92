"""Perception against exactly known motions: objects, distances, backgrounds and depth noise."""
