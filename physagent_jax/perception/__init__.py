"""Motion measured from pictures alone: masks, depth, point tracks, lifted to 3D, told as a report.

This package never sees particles. `schema` is free of arrays; `measure.perceive` is the entry point.
"""

from physagent_jax.perception.schema import MotionReport as MotionReport
