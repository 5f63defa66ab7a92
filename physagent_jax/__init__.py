"""Differentiable Material Point Method simulation of 3D Gaussians, with agents around it that read a sentence.

Sub-packages, lowest layer first: `mpm` (the simulator), `forces` (the force field skill library),
`gaussians`, `render`, `scene`, `perception`, `agents`, `metrics`; `synthesis` is the closed loop.
Nothing heavy is imported here: import the layer that you need.
"""

__version__ = "0.1.0"
