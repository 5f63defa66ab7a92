"""Files that a run leaves: videos, motion, per-frame splats."""
