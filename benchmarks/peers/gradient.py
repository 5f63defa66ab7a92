"""Loss and gradient of a scene by one code in this process, timed: what `benchmarks.gradients` runs in others.

    python -m benchmarks.peers.gradient --code NAME --scene scene.npz --dt DT --steps N --threads T

The loss is the mean over the particles of z^2 + 0.1 w . x / 3 at the end, w normal numbers (seed 1); its gradient is by
gravity, initial velocity and stiffness, each as a factor. Prints a line of JSON with the first gradient, and for each
line that it then reads one with the seconds that another takes. Needs only numpy and the code's library, so that a peer
may live in an environment of its own.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import re
import sys
import time
from pathlib import Path
from typing import Protocol

import numpy as np

from benchmarks.peers.scene import PeerScene

CODES = {
    "ours": ("benchmarks.peers.ours_gradient", "Ours"),
    "warp_tape": ("benchmarks.peers.warp_tape", "WarpTape"),
    "taichi_tape": ("benchmarks.peers.taichi_tape", "TaichiTape"),
}
"""Module and class of each code."""
WARM_UPS = (
    2  # gradients after the first one that are not timed: until then memory is still asked of the system
)
_STATUS, _CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


class Differentiable(Protocol):
    """A simulator whose end can be differentiated."""

    name: str

    def version(self) -> str:
        """Name, version and device of the library that does the work."""
        ...

    def load(self, scene: PeerScene, dt: float, steps: int, weight: np.ndarray) -> None:
        """Prepare ``scene`` for ``steps`` substeps of ``dt`` [s]; ``weight`` is w of the loss, shape (n, 3)."""
        ...

    def compute_gradient(self) -> tuple[float, np.ndarray]:
        """The loss, and its derivatives by gravity, initial velocity and stiffness, shape (3,)."""
        ...


def draw_weight(count: int) -> np.ndarray:
    """w of the loss, shape (count, 3)."""
    return np.random.default_rng(1).normal(size=(count, 3))


def read_memory(name: str) -> float | None:
    """A line of what the system says of this process [bytes]; None where it says nothing."""
    if not _STATUS.is_file():
        return None
    found = re.search(rf"{name}:\s+(\d+) kB", _STATUS.read_text())
    return 1024.0 * int(found[1]) if found else None


def reset_peak() -> float | None:
    """Memory of this process now, from which on its peak is counted [bytes]; None where the system does not tell."""
    try:
        _CLEAR.write_text("5")
    except OSError:
        return None
    return read_memory("VmRSS")


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.gradient", description=__doc__)
    parser.add_argument("--code", required=True, choices=sorted(CODES))
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--dt", type=float, required=True, help="substep [s]")
    parser.add_argument("--steps", type=int, required=True)
    parser.add_argument("--threads", type=int, required=True)
    options = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):  # before any library counts the cores
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: options.threads])
    module, cls = CODES[options.code]
    code: Differentiable = getattr(importlib.import_module(module), cls)()
    scene = PeerScene.load(options.scene)
    before = read_memory("VmRSS")
    code.load(scene, options.dt, options.steps, draw_weight(scene.particle_count))
    begun = time.perf_counter()
    loss, gradient = code.compute_gradient()
    first = time.perf_counter() - begun
    for _ in range(WARM_UPS):
        code.compute_gradient()
    sys.stdin.readline()
    peak = read_memory("VmHWM")
    result = {
        "code": code.name,
        "version": code.version(),
        "first_seconds": first,
        "loss": loss,
        "gradient": gradient.tolist(),
        "memory_gb": None if peak is None or before is None else (peak - before) / 1e9,
    }
    print(json.dumps(result), flush=True)
    while sys.stdin.readline():
        begun = time.perf_counter()
        code.compute_gradient()
        print(json.dumps({"seconds": time.perf_counter() - begun}), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
