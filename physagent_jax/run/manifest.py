"""The run folder: the files that a run leaves, and its manifest, which a resumed run trusts.

run/manifest.json                      versions, seeds, hashes, timings, which round is best
run/semantic.json                      the semantic agent's reply
run/semantic_trace.json                how it came about: `agents.trace.Trace`
run/scene.json                         the best round's fused scene, replayable
run/iterations/k/scene.json            fused scene of iteration k
run/iterations/k/force_field.json      what was simulated
run/iterations/k/motion_report.json    what perception saw
run/iterations/k/judgement.json        what the planner concluded
run/iterations/k/rewrite.json          what the executor changed for k + 1 (absent after the last)
run/iterations/k/planner_trace.json    how the judgement came about
run/iterations/k/executor_trace.json   how the rewrite came about
run/iterations/k/planner_failed_n.json executor's and, at the top, semantic's likewise: a call without an answer,
                                       `agents.trace.FailedCall`; n counts those of the agent
run/iterations/k/simulation.json       `SimulationRecord`
run/iterations/k/video.mp4             the round drawn for people: ground, shadow, horizon, a camera of its own
run/iterations/k/perception.mp4        the plain pictures that perception and agents get
run/iterations/k/motion.npz            particles and Gaussians, frame by frame
run/probe/iterations/k/...             the same but motion.npz and video.mp4, on a coarse version of the scene, if that
                                       was asked for
run/video.mp4, perception.mp4,         the best round's, of those so far; the first round's video.mp4 is there
    motion.npz                         before the round is judged
run/frames/                            its plain pictures, on request
run/report.html
run/refused.json                       `run.refused.RefusedReadings`: of no run in particular, so in no list of files
"""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated

from pydantic import Field, field_validator

from physagent_jax.core.strict import Strict
from physagent_jax.run.stopping import StopReason

FORMAT = 3
"""Version of the run folder's layout; 2 added the list of files, 3 the plain video beside the one for people."""

MOST_ROUNDS = 1000
Rounds = Annotated[int, Field(ge=0, le=MOST_ROUNDS)]


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


class FirstClip(Strict):
    """Seconds until the first clip for people was there.

    Attributes:
        seconds: Since the run began, without the start of Python [s].
        draw: The part of them in which the clip was drawn and written, after the simulation [s].
        stages: What was charged to stages until then.
    """

    seconds: float
    draw: float
    stages: Stages


class AgentCost(Strict):
    """The cost of an agent.

    Attributes:
        agent: Its role.
        implementation: Its name.
        calls: Those without an answer included.
        failed_calls: Those without an answer.
        input_tokens, output_tokens: Tokens of all calls; zero for the offline rules.
        seconds: Time of all calls [s].
        latency_seconds: Time in them that was waited for a model [s].
    """

    agent: str
    implementation: str
    calls: int = 0
    failed_calls: int = 0
    input_tokens: int = 0
    output_tokens: int = 0
    seconds: float = 0.0
    latency_seconds: float = 0.0


class Manifest(Strict):
    """The run's passport.

    Attributes:
        format: Version of the folder's layout.
        files: What the run has written or is about to, relative to its folder; it touches nothing else there.
        command: How it was started.
        prompt: The sentence.
        versions: Versions of this package and of what it computes with.
        git_revision: Git revision of the working tree, if it is one.
        platform: Machine, processor, device kind.
        kernels: What the transfers were computed with (`kernels.describe_kernels`).
        seed: Master seed.
        inputs: sha256 of each input file, of the settings and of the names of agents and perception; they identify
            the run.
        iterations: How many were made.
        best_iteration: Which one the top-level files show.
        verdict: The best round's verdict.
        stopped: Reason for which no further round was made; None while the run is under way.
        probe_iterations: How many coarse rounds came before.
        probe_best: Which of them gave the force field of the first round; None = none, it is the sentence's.
        stages: Wall time summed over rounds.
        first_clip: When the first clip was there; None if there is none, or a stopped run was taken up before it was.
        reused_frames: Frames, frame 0 among them, that a round's folder took over from the round before, which
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
    stopped: StopReason | None = None
    probe_iterations: Rounds = 0
    probe_best: Rounds | None = None
    stages: Stages = Stages()
    first_clip: FirstClip | None = None
    reused_frames: dict[str, int] = {}
    agents: tuple[AgentCost, ...] = ()
    warnings: tuple[str, ...] = ()
    complete: bool = False

    @field_validator("files")
    @classmethod
    def _list_inside(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for name in value:
            path = PurePosixPath(name)
            if path.is_absolute() or ".." in path.parts or not path.parts:
                raise ValueError(f"`files` are relative to the run folder and inside it (got {name!r})")
        return value
