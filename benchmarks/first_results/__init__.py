"""Twelve sentences over four objects: what was asked, simulated, perceived and true, and everything odd."""
