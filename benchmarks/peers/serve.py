"""Runs one peer in this interpreter and writes what it did.

    python -m benchmarks.peers.serve --peer NAME --scene scene.npz --dt DT --steps N --sample-every K --out out.npz

The scene is what `PeerScene.save` wrote; the output is read with `PeerRun.load`. Needs only numpy and the
peer's library, so that a peer may live in an environment of its own.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.peers.base import PEERS, PeerScene, drive, make_peer


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.serve", description=__doc__)
    parser.add_argument("--peer", required=True, choices=sorted(PEERS))
    parser.add_argument("--scene", required=True, type=Path)
    parser.add_argument("--dt", required=True, type=float, help="substep [s]")
    parser.add_argument("--steps", required=True, type=int, help="substeps to run")
    parser.add_argument(
        "--sample-every", type=int, help="substeps between samples; default: sample the end only"
    )
    parser.add_argument("--out", required=True, type=Path)
    options = parser.parse_args()
    scene = PeerScene.load(options.scene)
    run = drive(make_peer(options.peer), scene, options.dt, options.steps, options.sample_every)
    run.save(options.out)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
