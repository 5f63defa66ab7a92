"""Other simulators behind one small interface, so that ours is compared on the very same scene.

A peer takes a `PeerScene` (plain numpy arrays), advances it by a number of substeps and hands back positions
and velocities. What is compared, accuracy or time, is the caller's business: a peer only simulates.

- `warp_classical.WarpClassical`: the classical algorithm of the Warp solvers that 3D Gaussian simulation is
  usually built on (warp-mpm, PhysGaussian): dense grid, gradient-of-weight force, fixed substep, one thread
  on a CPU or one CUDA device. Written anew from the algorithm, because those solvers have no licence and
  their frictional planes and metal stress are wrong; so it is a fair and correct stand-in, and an
  independent implementation to check our own against.
- `genesis.GenesisMPM`: Genesis' MPM solver (MLS-MPM), if `genesis-world` is installed.
- `taichi_mls.TaichiMLS`: dense MLS-MPM as Taichi's examples do it, on any number of threads.
- `jax_naive`: the way other JAX simulators do it, 27 scattered additions per particle: what the kernels save.
- `ours.Ours`: our own simulator behind the same interface.

Scenes that all can run: `drop` (a cube dropped on a floor, as customary) and `flight` (a cube in free flight, whose
errors converge).

`base` needs numpy only. Warp, Taichi and Genesis are imported when a peer is loaded; one that lives in another
interpreter is run there by `base.run_in`.
"""

from benchmarks.peers.base import Contact as Contact
from benchmarks.peers.base import Material as Material
from benchmarks.peers.base import Peer as Peer
from benchmarks.peers.base import PeerRun as PeerRun
from benchmarks.peers.base import PeerScene as PeerScene
from benchmarks.peers.base import Plane as Plane
from benchmarks.peers.base import drive as drive
from benchmarks.peers.base import make_peer as make_peer
from benchmarks.peers.base import run_in as run_in
