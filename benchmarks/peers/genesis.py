"""Genesis' MPM solver (MLS-MPM, APIC, float32) behind the `Peer` interface; written for genesis-world 1.4.5.

Install it in an environment of its own, because it pins much (torch is not among its dependencies):
``python3.11 -m venv ENV && ENV/bin/pip install torch genesis-world==1.4.5``, and give ``ENV/bin/python`` to
`base.run_in`. Importing and building takes about a minute.

Particles come from arrays: an entity of the morph `Nowhere` reserves their number, and the solver's
`set_state` places them, with x, v, C and F. What has no counterpart is refused by `load`:

- materials other than JELLY and NEO_HOOKEAN (Genesis' sand corrects volume, its liquid has another
  equation of state, its elasto-plastic solid another yield limit);
- volume, density and stiffness that differ between particles (Genesis has them per solver or entity);
- planes (Genesis makes them rigid bodies with another law of contact), PIC and RPIC.

The domain's walls are Genesis' own: nodes as in `PeerScene.domain_box`, and particles are moreover clamped
to the region inside them. Without walls, Genesis still clamps a few cells outside the domain. Genesis
updates F at the start of a substep, so that F lags x by one substep.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import math
import os
from typing import Any

import numpy as np

from benchmarks.peers.scene import Material, PeerScene

_MODELS = {Material.JELLY: "corotation", Material.NEO_HOOKEAN: "neohooken"}


class GenesisMPM:
    """Runs a `PeerScene` with Genesis; on a CPU with ``QD_NUM_THREADS`` threads, one by default.

    Args:
        substeps: Substeps per call of Genesis' step, whose overhead in Python they share; fewer where `load`
            is asked for a granule that it does not divide. `run` takes multiples of it.
    """

    name = "genesis"

    def __init__(self, substeps: int = 10):
        self.substeps = substeps

    def available(self) -> str | None:
        """Reason why Genesis cannot be used, or None."""
        for package in ("genesis-world", "torch"):
            try:
                importlib.metadata.version(package)
            except importlib.metadata.PackageNotFoundError:
                return f"{package} is not installed; see benchmarks/peers/genesis.py"
        return None

    def version(self) -> str:
        """Genesis' version and the device."""
        threads = os.environ.get("QD_NUM_THREADS", "1")
        device = "cuda" if _has_cuda() else f"cpu with {threads} thread(s)"
        return f"genesis-world {importlib.metadata.version('genesis-world')} on {device}"

    def load(self, scene: PeerScene, dt: float, granule: int = 0) -> None:
        """Build the scene, compile it by one call of Genesis' step, and put the particles back.

        Raises:
            NotImplementedError: Genesis has no counterpart for something in the scene.
        """
        reason = unsupported(scene)
        if reason is not None:
            raise NotImplementedError(f"Genesis: {reason}")
        self._scene, self.substeps = scene, math.gcd(self.substeps, granule)
        self._build(dt)
        self._place_particles()
        self._world.step()
        self._place_particles()

    def run(self, steps: int) -> None:
        """Advance by ``steps`` substeps.

        Raises:
            ValueError: ``steps`` is not a multiple of the substeps per call.
            RuntimeError: Genesis found positions that are not numbers.
        """
        if steps % self.substeps:
            raise ValueError(f"steps must be a multiple of {self.substeps} for Genesis (got {steps}).")
        try:
            for _ in range(steps // self.substeps):
                self._world.step()
            self._synchronize()
        except self._error as error:
            raise RuntimeError(f"Genesis stopped: {error}") from error

    def x(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return self._entity.get_particles_pos().cpu().numpy().copy()

    def v(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return self._entity.get_particles_vel().cpu().numpy().copy()

    def F(self) -> np.ndarray:
        """Deformation gradients one substep before x, shape (n, 3, 3)."""
        state = self._solver.get_state(self._world.sim.cur_substep_local)
        return state.F[0].cpu().numpy().copy()

    def _build(self, dt: float) -> None:
        # By name, because this module has the same one.
        gs: Any = importlib.import_module("genesis")
        scene = self._scene
        if not gs._initialized:
            gs.init(backend=gs.gpu if _has_cuda() else gs.cpu, precision="32", logging_level="warning")
        self._error = gs.GenesisException
        # Genesis' walls hold nodes up to 3 cells inside its bounds, ours those with an index below domain_box.
        # The small surplus keeps round-off from excluding the last layer of nodes.
        walls = -2 if scene.domain_box is None else scene.domain_box
        inset = (walls - 4 + 1e-3) * scene.dx
        sim = gs.options.SimOptions(dt=dt * self.substeps, substeps=self.substeps, gravity=scene.gravity)
        mpm = gs.options.MPMOptions(
            lower_bound=(inset,) * 3,
            upper_bound=(scene.size - inset,) * 3,
            grid_density=scene.cells / scene.size,
            particle_size=float(scene.volume[0]) ** (1 / 3),
        )
        self._world = gs.Scene(sim_options=sim, mpm_options=mpm, show_viewer=False)
        self._entity = self._world.add_entity(
            material=gs.materials.MPM.Elastic(
                E=float(scene.youngs_modulus[0]),
                nu=float(scene.poissons_ratio[0]),
                rho=float(scene.density[0]),
                model=_MODELS[scene.material],
            ),
            morph=gs.morphs.Nowhere(n_particles=scene.particle_count),
        )
        self._world.build()
        self._solver: Any = self._world.sim.mpm_solver

    def _place_particles(self) -> None:
        """Put the particles where the scene has them, undeformed."""
        torch: Any = importlib.import_module("torch")
        scene, frame = self._scene, self._world.sim.cur_substep_local
        state = self._solver.get_state(frame)
        identity = np.broadcast_to(np.eye(3), (scene.particle_count, 3, 3))
        for target, values in (
            (state.pos, scene.x),
            (state.vel, scene.v),
            (state.C, scene.C),
            (state.F, identity),
        ):
            target.copy_(torch.from_numpy(np.array(values, np.float32))[None])
        state.Jp.fill_(1.0)
        state.active.fill_(True)
        self._solver.set_state(frame, state)

    def _synchronize(self) -> None:
        # Reading one number makes the host wait for the device.
        self._entity.get_particles_pos()[0, 0].item()


def unsupported(scene: PeerScene) -> str | None:
    """Part of ``scene`` that Genesis has no counterpart for, or None."""
    if scene.material not in _MODELS:
        return f"the material {scene.material.value} differs from Genesis' own."
    for name in ("volume", "density", "youngs_modulus", "poissons_ratio"):
        values = getattr(scene, name)
        if np.any(values != values[0]):
            return f"{name} must be the same for all particles."
    if scene.planes:
        return "planes are rigid bodies there, with another law of contact."
    if scene.transfer != "apic" or scene.rpic_damping != 0:
        return "transfers are APIC without damping."
    return None


def _has_cuda() -> bool:
    torch: Any = importlib.import_module("torch")
    return torch.cuda.is_available()
