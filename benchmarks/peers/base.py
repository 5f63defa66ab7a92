"""The interface that every peer has, and how one is run here or in another interpreter."""

from __future__ import annotations

import dataclasses
import importlib
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from benchmarks.peers.scene import Contact as Contact
from benchmarks.peers.scene import Material as Material
from benchmarks.peers.scene import PeerScene as PeerScene
from benchmarks.peers.scene import Plane as Plane

PEERS = {
    "warp_classical": ("benchmarks.peers.warp_classical", "WarpClassical"),
    "genesis": ("benchmarks.peers.genesis", "GenesisMPM"),
    "taichi_mls": ("benchmarks.peers.taichi_mls", "TaichiMLS"),
    "jax_naive": ("benchmarks.peers.jax_naive", "JaxNaive"),
}
"""Module and class of each peer; modules import nothing heavy."""

PYTHON_VARIABLE = "PEER_PYTHON"
"""Environment variable with the interpreter that `run_in` uses if none is given."""


_ROOT = Path(__file__).resolve().parents[2]


class Peer(Protocol):
    """A simulator that can run a `PeerScene`.

    ``load`` compiles and warms up, so that ``run`` afterwards measures simulation only.
    """

    name: str

    def available(self) -> str | None:
        """None if the peer can be used in this interpreter, otherwise the reason why not."""
        ...

    def version(self) -> str:
        """Name, version and device of the library that does the work."""
        ...

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Prepare ``scene`` with a fixed substep ``dt`` [s]; afterwards it is at step 0 and warm.

        Args:
            scene: What to simulate.
            dt: Substep [s].
            granule: `run` will be asked for multiples of this; 0 = for multiples of what suits the peer.

        Raises:
            NotImplementedError: The peer has no counterpart for something in the scene.
        """
        ...

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps and return when the work is done.

        Raises:
            RuntimeError: The simulation broke down.
        """
        ...

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3), in the scene's particle order."""
        ...

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        ...

    def F(self) -> np.ndarray:
        """Elastic deformation gradients, shape (n, 3, 3)."""
        ...


def make_peer(name: str) -> Peer:
    """The peer called ``name``.

    Raises:
        ValueError: There is none.
    """
    if name not in PEERS:
        raise ValueError(f"there is no peer {name!r}; there are {', '.join(PEERS)}.")
    module, cls = PEERS[name]
    return getattr(importlib.import_module(module), cls)()


@dataclasses.dataclass(frozen=True)
class Found:
    """Availability of a peer.

    Attributes:
        python: The interpreter; None = this one.
        version: As `Peer.version`; empty if it cannot run.
        reason: Why it cannot run anywhere, or None.
    """

    python: str | None
    version: str
    reason: str | None


def find(name: str) -> Found:
    """Look for a peer in this interpreter, then in the one that the environment variable ``PEER_PYTHON`` names."""
    peer = make_peer(name)
    reason = peer.available()
    if reason is None:
        return Found(None, peer.version(), None)
    python = os.environ.get(PYTHON_VARIABLE)
    if not python:
        return Found(None, "", reason)
    command = [python, "-m", "benchmarks.peers.serve", "--peer", name]
    asked = subprocess.run(command, cwd=_ROOT, capture_output=True, text=True)
    if asked.returncode != 0:
        return Found(None, "", (asked.stderr or asked.stdout).strip().splitlines()[-1])
    return Found(python, asked.stdout.strip().splitlines()[-1], None)


@dataclasses.dataclass(frozen=True)
class PeerRun:
    """Sampled states of one run, and what it cost.

    Attributes:
        peer, version: Who ran it.
        dt: Substep [s].
        setup_seconds: Wall time of ``load``: compilation, allocation, warm-up.
        steps: Substeps done at each sample, the first is 0, shape (m,).
        seconds: Wall time from each sample to the next, warm, without the sampling, shape (m - 1,).
        x: Positions [m], shape (m, n, 3).
        v: Velocities [m/s], shape (m, n, 3).
    """

    peer: str
    version: str
    dt: float
    setup_seconds: float
    steps: np.ndarray
    seconds: np.ndarray
    x: np.ndarray
    v: np.ndarray

    def save(self, path: Path) -> None:
        """Write the run to an npz file."""
        rest = dict(peer=self.peer, version=self.version, dt=self.dt, setup_seconds=self.setup_seconds)
        np.savez(
            path, rest=np.array(json.dumps(rest)), steps=self.steps, seconds=self.seconds, x=self.x, v=self.v
        )

    @staticmethod
    def load(path: Path) -> PeerRun:
        """Read what `save` wrote."""
        with np.load(path) as stored:
            arrays = {name: stored[name] for name in stored.files if name != "rest"}
            return PeerRun(**json.loads(str(stored["rest"])), **arrays)


def drive(peer: Peer, scene: PeerScene, dt: float, steps: int, sample_every: int | None = None) -> PeerRun:
    """Run ``steps`` substeps in this interpreter and sample every ``sample_every`` of them (default: the end).

    Raises:
        RuntimeError: The peer is not available here.
    """
    reason = peer.available()
    if reason is not None:
        raise RuntimeError(f"{peer.name} cannot run in {sys.executable}: {reason}")
    sample_every = sample_every or steps
    begin = time.perf_counter()
    peer.load(scene, dt, math.gcd(steps, sample_every))
    setup = time.perf_counter() - begin
    samples = [(0, peer.x(), peer.v())]
    seconds = []
    while (done := samples[-1][0]) < steps:
        chunk = min(sample_every, steps - done)
        begin = time.perf_counter()
        peer.run(chunk)
        seconds.append(time.perf_counter() - begin)
        samples.append((done + chunk, peer.x(), peer.v()))
    counts, x, v = (np.asarray(column) for column in zip(*samples))
    return PeerRun(peer.name, peer.version(), dt, setup, counts, np.asarray(seconds), x, v)


def run_in(
    python: str | os.PathLike | None,
    peer: str,
    scene: PeerScene,
    dt: float,
    steps: int,
    sample_every: int | None = None,
    *,
    environment: Mapping[str, str] | None = None,
) -> PeerRun:
    """`drive` in another interpreter, which needs numpy and the peer's library.

    Args:
        python: The interpreter; None = the one named by the environment variable ``PEER_PYTHON``, or this one.
        peer: A name in `PEERS`.
        scene: What to simulate.
        dt: Substep [s].
        steps: Substeps to run.
        sample_every: Substeps between samples; None = sample the end only.
        environment: Variables to add, such as numbers of threads.

    Raises:
        RuntimeError: The other process failed; the message ends with what it printed.
    """
    python = python or os.environ.get(PYTHON_VARIABLE) or sys.executable
    with tempfile.TemporaryDirectory() as folder:
        stored, out = Path(folder, "scene.npz"), Path(folder, "out.npz")
        scene.save(stored)
        command = [os.fspath(python), "-m", "benchmarks.peers.serve", "--peer", peer, "--scene", str(stored)]
        command += ["--dt", repr(float(dt)), "--steps", str(steps), "--out", str(out)]
        command += ["--sample-every", str(sample_every or steps)]
        result = subprocess.run(
            command,
            cwd=_ROOT,
            env={**os.environ, **(environment or {})},
            capture_output=True,
            text=True,
        )
        if result.returncode != 0:
            told = (result.stderr or result.stdout)[-2000:]
            raise RuntimeError(f"{peer} failed in {os.fspath(python)} with code {result.returncode}: {told}")
        return PeerRun.load(out)
