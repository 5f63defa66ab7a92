"""The schema of `simulation.json`: the record of one simulation."""

from __future__ import annotations

from physagent_jax.core.strict import Strict, Vector
from physagent_jax.metrics.motion import TrueMotion


class Ledger(Strict):
    """Energy and momentum exchanged up to each frame (`mpm.ledger.Exchange`, summed).

    Attributes:
        force_work, boundary_work: Put in by body forces (without gravity), and by boundaries and constraints [J].
        plastic_dissipation, viscous_dissipation: Taken out by plasticity and viscosity [J].
        numerical_loss: Taken out by the transfers: what closes the balance [J].
        force_impulse, boundary_impulse: [kg m/s].
    """

    force_work: tuple[float, ...]
    boundary_work: tuple[float, ...]
    plastic_dissipation: tuple[float, ...]
    viscous_dissipation: tuple[float, ...]
    numerical_loss: tuple[float, ...]
    force_impulse: tuple[Vector, ...]
    boundary_impulse: tuple[Vector, ...]


class SimulationRecord(Strict):
    """The record of one rollout.

    Attributes:
        particle_count, gaussian_count: Sizes.
        grid_shape: Nodes of the grid window.
        dx: [m].
        substeps: Total substeps that count (redone frames once).
        substep_dt: Per frame interval, the substep used [s].
        stable_dt: The closed-form bound at the start [s]; None = there is none, as where nothing has stress.
        redone_frames: Frames that were redone with a smaller step, with the reason.
        stopped_particles: Particle-steps at which a particle was stopped at the domain's wall.
        kinetic_energy, elastic_energy: Per frame [J]. Matter that is led for the whole clip has next to no elastic
            energy: its stress moves nothing, and it is soft (`scene.compile.idle`).
        gravitational_energy: Per frame, over frame 0's [J]; empty in records of earlier versions.
        momentum: Per frame [kg m/s].
        angular_momentum: Per frame, about the mass centre of frame 0 [kg m^2/s]; empty as above.
        ledger: What was exchanged; None = not asked for (`SceneConfig.ledger`).
        min_volume_ratio, max_volume_ratio: Per frame, extremes of det F.
        truth: The true motion.
    """

    particle_count: int
    gaussian_count: int
    grid_shape: tuple[int, int, int]
    dx: float
    substeps: int
    substep_dt: tuple[float, ...]
    stable_dt: float | None
    redone_frames: dict[int, str] = {}
    stopped_particles: int = 0
    kinetic_energy: tuple[float, ...]
    elastic_energy: tuple[float, ...]
    gravitational_energy: tuple[float, ...] = ()
    momentum: tuple[Vector, ...]
    angular_momentum: tuple[Vector, ...] = ()
    ledger: Ledger | None = None
    min_volume_ratio: tuple[float, ...]
    max_volume_ratio: tuple[float, ...]
    truth: TrueMotion | None = None
