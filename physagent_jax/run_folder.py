"""The files that a run leaves, as schemas: what the loop writes, the report reads and a resumed run trusts.

run/manifest.json                      versions, seeds, hashes, timings, which iteration is best
run/semantic.json                      the semantic agent's reply
run/scene.json                         the best iteration's fused scene, replayable
run/iterations/k/scene.json            fused scene of iteration k
run/iterations/k/force_field.json      what was simulated
run/iterations/k/motion_report.json    what perception saw
run/iterations/k/judgement.json        what the planner concluded
run/iterations/k/rewrite.json          what the executor changed for k + 1 (absent after the last)
run/iterations/k/simulation.json       `SimulationRecord`
run/iterations/k/video.mp4, motion.npz
run/probe/iterations/k/...             the same but motion.npz, on a coarse version of the scene, if that was asked for
run/video.mp4, motion.npz, frames/     the best iteration's
run/report.html
"""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated

from pydantic import Field, field_validator

from physagent_jax.core.strict import Strict, Vector

FORMAT = 2
"""Of the run folder's layout; 2 added the list of files."""

MOST_ROUNDS = 1000
Rounds = Annotated[int, Field(ge=0, le=MOST_ROUNDS)]


class TrueMotion(Strict):
    """Motion of the particles themselves, in the same measures as the motion report.

    For the report's honesty only: no agent ever sees it.

    Attributes:
        object_size: Longest extent of the rest particles [m].
        centroid: Per frame displacement of the Gaussians' centroid from frame 0 [body lengths].
        rotation_degrees: Per frame, angle of the best rigid fit [deg].
        volume_ratio: Per frame, bounding-box volume over frame 0's.
        stretch: Per frame, extents (standard deviations) along world x, y, z over frame 0's.
    """

    object_size: float
    centroid: tuple[Vector, ...]
    rotation_degrees: tuple[float, ...]
    volume_ratio: tuple[float, ...]
    stretch: tuple[Vector, ...]


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
    """What one rollout did.

    Attributes:
        particle_count, gaussian_count: Sizes.
        grid_shape: Nodes of the grid window.
        dx: [m].
        substeps: Total substeps that count (redone frames once).
        substep_dt: Per frame interval, the substep used [s].
        stable_dt: The closed-form bound at the start [s]; None = there is none, as where nothing has stress.
        redone_frames: Frames that were redone with a smaller step, with the reason.
        stopped_particles: Particle-steps at which a particle was stopped at the domain's wall.
        kinetic_energy, elastic_energy: Per frame [J].
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


class Stages(Strict):
    """Seconds of wall time per stage, compilation apart where it can be told apart [s].

    ``probe`` is all that the coarse rounds took, agents included, but for compilation.
    """

    prepare: float = 0.0
    probe: float = 0.0
    compile: float = 0.0
    simulate: float = 0.0
    render: float = 0.0
    perceive: float = 0.0
    agents: float = 0.0
    write: float = 0.0


class AgentCost(Strict):
    """What the agents cost: calls, tokens (zero for the offline rules), seconds."""

    agent: str
    implementation: str
    calls: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    seconds: float = 0.0


class Manifest(Strict):
    """The run's passport.

    Attributes:
        format: Version of the folder's layout.
        files: What the run has written or is about to, relative to its folder; it touches nothing else there.
        command: How it was started.
        prompt: The sentence.
        versions: Of this package and of what it computes with.
        git_revision: Of the working tree, if it is one.
        platform: Machine, processor, device kind.
        kernels: What the transfers were computed with (`kernels.chosen`).
        seed: Master seed.
        inputs: sha256 of each input file.
        iterations: How many were made.
        best_iteration: Which one the top-level files show.
        verdict: The best iteration's verdict.
        probe_iterations: How many coarse rounds came before.
        probe_best: Which of them gave the force field of iteration 0; None = none, it is the sentence's.
        stages: Wall time summed over iterations.
        reused_frames: Frames, frame 0 among them, that an iteration's folder took over from the round before, which
            had the same forces until then; other figures are of all frames alike.
        agents: Cost per agent.
        warnings: Everything the user should know.
        complete: False while the run is under way (or was stopped).
    """

    format: int = FORMAT
    files: tuple[str, ...] = ()
    command: str
    prompt: str
    versions: dict[str, str]
    git_revision: str | None = None
    platform: str
    kernels: str = "reference"
    seed: int
    inputs: dict[str, str]
    iterations: Rounds = 0
    best_iteration: Rounds | None = None
    verdict: str | None = None
    probe_iterations: Rounds = 0
    probe_best: Rounds | None = None
    stages: Stages = Stages()
    reused_frames: dict[str, int] = {}
    agents: tuple[AgentCost, ...] = ()
    warnings: tuple[str, ...] = ()
    complete: bool = False

    @field_validator("files")
    @classmethod
    def _inside(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for name in value:
            path = PurePosixPath(name)
            if path.is_absolute() or ".." in path.parts or not path.parts:
                raise ValueError(f"`files` are relative to the run folder and inside it (got {name!r})")
        return value
