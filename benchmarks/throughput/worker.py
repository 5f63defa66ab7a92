"""One code in a process of its own, kept alive and driven by a line of JSON at a time.

    python -m benchmarks.throughput.worker --code NAME --threads N [--kernels KERNELS] [--unsorted] [--double]

Every request is answered by one line: {"do": "load", "scene": FILE, "dt": DT}, {"do": "run", "steps": N},
{"do": "height"}, {"do": "positions", "out": FILE}, {"do": "memory"}; of "ours" also {"do": "stages", "repeats": N} and
{"do": "job", "scene": FILE, "frames": N, "frame_dt": DT, "out": FILE}. What goes wrong is answered with "error".
Imports numpy and the code's own library only, so that a peer may live in another interpreter. What libraries print
goes to the standard error stream.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.base import PeerScene, make_peer


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.throughput.worker", description=__doc__)
    parser.add_argument("--code", required=True, help="ours, or a name in benchmarks.peers.base.PEERS")
    parser.add_argument("--threads", required=True, type=int)
    parser.add_argument("--kernels", default="auto", help="of ours")
    parser.add_argument("--unsorted", action="store_true", help="ours takes the particles as they come")
    parser.add_argument("--double", action="store_true", help="ours computes in float64")
    options = parser.parse_args()
    if options.double:
        os.environ["JAX_ENABLE_X64"] = "1"
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    _restrict(options.threads)
    worker = Worker(options.code, options.kernels, not options.unsorted)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = getattr(worker, request.pop("do"))(**request)
        except Exception as error:  # whatever it is, the benchmark goes on without this code
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
    return 0


class Worker:
    """The requests.

    Args:
        code: "ours" or the name of a peer.
        kernels: As in `Model`, of ours.
        sort: As in `Ours`.
    """

    def __init__(self, code: str, kernels: str, sort: bool):
        self._code, self._kernels, self._sort = code, kernels, sort
        self._peer: Any = None

    def load(self, scene: str, dt: float, granule: int = 0) -> dict:
        """Imports, compiles and warms up."""
        begun = time.perf_counter()
        self._peer = self._make_peer()
        reason = self._peer.available()
        if reason is not None:
            return {"error": reason}
        self._peer.load(PeerScene.load(Path(scene)), dt, granule)
        return {"seconds": time.perf_counter() - begun, "version": self._peer.version()}

    def run(self, steps: int) -> dict:
        """Seconds of ``steps`` substeps; of them, what compiling took, and processor seconds."""
        compiled = getattr(self._peer, "compile_seconds", 0.0)
        used, begun = time.process_time(), time.perf_counter()
        self._peer.run(steps)
        seconds, used = time.perf_counter() - begun, time.process_time() - used
        compiled = getattr(self._peer, "compile_seconds", 0.0) - compiled
        return {"seconds": seconds, "compile_seconds": compiled, "processor_seconds": used}

    def height(self) -> dict:
        """Height of the mass centre of equal particles [m]."""
        return {"height": float(self._peer.x()[:, 2].mean(dtype=float))}

    def positions(self, out: str) -> dict:
        """Write the positions [m], in the scene's order."""
        np.save(out, self._peer.x())
        return {}

    def memory(self) -> dict:
        """The most memory that this process has held [MB]."""
        return {"peak_mb": peak_mb()}

    def stages(self, repeats: int) -> dict:
        """Milliseconds per stage of ours."""
        from benchmarks.throughput.ours import stages

        return {"milliseconds": stages(self._peer, repeats)}

    def job(self, scene: str, frames: int, frame_dt: float | None = None, out: str | None = None) -> dict:
        """A whole clip of ours; ``out`` gets the positions of every frame [m]."""
        from benchmarks.throughput.ours import job

        return job(PeerScene.load(Path(scene)), frames, frame_dt, sort=self._sort, out=out)

    def _make_peer(self) -> Any:
        if self._code == "ours":
            from benchmarks.peers.ours import Ours

            return Ours(self._kernels, self._sort)
        return make_peer(self._code)


def _restrict(threads: int) -> None:
    """Keep this process on ``threads`` cores: libraries' own settings do not reach all of their threads."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[-threads:])


def peak_mb() -> float:
    """Peak resident memory [MB]. Linux' own counter first: that of getrusage outlives exec, with the parent's peak."""
    status = Path("/proc/self/status")
    if status.is_file():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


if __name__ == "__main__":
    sys.exit(main())
