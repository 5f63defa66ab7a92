"""Inverse problems from synthetic truth: numbers of a scene found again from tracks of its particles."""
