"""Sentences with what a person understands by them, and how many the offline parser reads the same way."""
