"""Run folders: one run each, resumable, never half-written, never at the cost of what stood there."""
