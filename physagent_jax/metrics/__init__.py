"""Measurements of results: motion against the truth, similarity of pictures and words, image errors."""

from physagent_jax.metrics.true_report import report_true_motion as report_true_motion
