"""Runs one peer in this interpreter and writes what it did.

    python -m benchmarks.peers.serve --peer NAME --scene scene.npz --dt DT --steps N --sample-every K --out out.npz
    python -m benchmarks.peers.serve --peer NAME

The second form only prints the peer's version, or fails with the reason why it cannot run. The scene is what
`PeerScene.save` wrote; the output is read with `PeerRun.load`. Needs only numpy and the peer's library, so that a peer
may live in an environment of its own.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.peers.base import PEERS, PeerScene, drive, make_peer


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.serve", description=__doc__)
    parser.add_argument("--peer", required=True, choices=sorted(PEERS))
    parser.add_argument("--scene", type=Path)
    parser.add_argument("--dt", type=float, help="substep [s]")
    parser.add_argument("--steps", type=int, help="substeps to run")
    parser.add_argument(
        "--sample-every", type=int, help="substeps between samples; default: sample the end only"
    )
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    peer = make_peer(options.peer)
    if options.scene is None:
        reason = peer.available()
        print(reason or peer.version())
        return 0 if reason is None else 1
    scene = PeerScene.load(options.scene)
    run = drive(peer, scene, options.dt, options.steps, options.sample_every)
    run.save(options.out)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
