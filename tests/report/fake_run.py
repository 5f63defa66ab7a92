"""A run folder as the loop leaves it, made without simulating: a square that a wind pushes to the left."""

from __future__ import annotations

import math
from pathlib import Path

import imageio.v3 as iio
import numpy as np
from pydantic import BaseModel

from physagent_jax.agents.schema import Evidence, Rewrite, SemanticReply
from physagent_jax.agents.trace import Message, Trace
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    BoxRegion,
    ConstraintType,
    ForceField,
    SkillScaling,
    VelocityConstraint,
)
from physagent_jax.metrics.motion import TrueMotion
from physagent_jax.motion.schema import AnchorRequest, Check, ExpectedMotion, Judgement, MotionKind, Verdict
from physagent_jax.output.video import write_video
from physagent_jax.perception.schema import MotionReport, Oscillation, Quality, WindowMotion
from physagent_jax.run.manifest import AgentCost, Manifest, Stages
from physagent_jax.scene import config
from physagent_jax.simulation.record import SimulationRecord

PROMPT = "A strong wind bends the plant to the left, then lets go zestfully"
FRAMES, FRAME_DT = 50, 0.04
MAGNITUDES = (0.6, 0.9, 1.3)
REACHES = (0.08, 0.17, 0.31)  # largest displacement of each round [body lengths]
SCORES = (0.35, 0.58, 0.93)
LEFT = (-1.0, 0.0, 0.0)


def build_run(folder: Path, *, prompt: str = PROMPT, size: int = 48) -> Path:
    """Three rounds: the wind is too weak, still too weak, then right."""
    last = len(MAGNITUDES) - 1
    for index in range(last + 1):
        _build_round(folder / "iterations" / str(index), index, prompt, size, is_last=index == last)
    store(folder / "semantic.json", _make_reply())
    store(
        folder / "semantic_trace.json",
        _make_trace("I read: a wind, to the left.", errors=("`magnitude` is missing",)),
    )
    store(folder / "scene.json", _make_scene(prompt, _make_force_field(last)))
    store(folder / "manifest.json", _make_manifest(prompt))
    (folder / "perception.mp4").write_bytes((folder / f"iterations/{last}/perception.mp4").read_bytes())
    write_video(folder / "video.mp4", moving_square(last, 2 * size), 1 / FRAME_DT)
    return folder


def store(path: Path, model: BaseModel) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(model.model_dump_json(indent=2), encoding="utf-8")


def sway(index: int) -> list[float]:
    """Displacement to the left per frame: pushed until frame 25, then swinging back, damped."""
    values = []
    for frame in range(FRAMES):
        if frame <= 25:
            shape = 0.5 - 0.5 * math.cos(math.pi * frame / 25)
        else:
            shape = math.exp(-(frame - 25) / 14) * math.cos(2 * math.pi * (frame - 25) / 16)
        values.append(REACHES[index] * shape)
    return values


def moving_square(index: int, size: int) -> np.ndarray:
    """Pictures of a leaning plant-like shape: uint8, shape (T, size, size, 3)."""
    rows, columns = np.mgrid[0:size, 0:size] / size
    height = np.clip((0.9 - rows) / 0.7, 0, 1)
    frames = np.full((FRAMES, size, size, 3), 255, np.uint8)
    for frame, reach in enumerate(sway(index)):
        centre = 0.5 - 0.8 * reach * height**2
        pot = (rows > 0.8) & (rows < 0.93) & (abs(columns - 0.5) < 0.13)
        stem = (rows > 0.3) & (rows <= 0.8) & (abs(columns - centre) < 0.03)
        crown = ((columns - centre) / 0.2) ** 2 + ((rows - 0.32) / 0.17) ** 2 < 1
        frames[frame][stem], frames[frame][crown], frames[frame][pot] = (
            (96, 130, 60),
            (52, 140, 88),
            (176, 96, 62),
        )
    return frames


def _build_round(folder: Path, index: int, prompt: str, size: int, *, is_last: bool) -> None:
    field = _make_force_field(index)
    store(folder / "scene.json", _make_scene(prompt, field))
    store(folder / "force_field.json", field)
    store(folder / "motion_report.json", _make_motion(index))
    store(folder / "planner_trace.json", _make_trace(f"Round {index + 1}: too little < enough."))
    store(folder / "judgement.json", _make_judgement(index))
    store(folder / "simulation.json", _make_simulation(index))
    frames = moving_square(index, size)
    write_video(folder / "perception.mp4", frames, 1 / FRAME_DT)
    iio.imwrite(folder / "overlay.png", np.concatenate(frames[::10], axis=1))
    if not is_last:
        store(folder / "executor_trace.json", Trace())
        store(folder / "rewrite.json", _make_rewrite(index))


def _make_trace(reply: str, errors: tuple[str, ...] = ()) -> Trace:
    messages = (
        Message(role="system", text="You answer in JSON."),
        Message(role="user", text="What now?", pictures=2),
    )
    return Trace(
        model="some-model",
        messages=messages,
        raw_reply=reply,
        validation_errors=errors,
        input_tokens=1204,
        output_tokens=32,
        latency_seconds=1.5,
    )


def _make_force_field(index: int) -> ForceField:
    push = Action(
        action_type=ActionType.TRANSLATION,
        vector=LEFT,
        magnitude=MAGNITUDES[index],
        active_time=(0, 25),
        region=BoxRegion(low=(0, 0, 0.4), high=(1, 1, 1)),
    )
    twist = Action(action_type=ActionType.TORQUE, vector=(0, 0, 1), magnitude=-0.4, active_time=(5, 15))
    constraint = VelocityConstraint(
        constraint_type=ConstraintType.PARTICLE_IMPULSE,
        vector=(-1, 0, 0.4),
        magnitude=0.5,
        active_time=(0, 2),
    )
    return ForceField(actions=(push, twist), constraints=(constraint,) if index else ())


def _make_reply() -> SemanticReply:
    return SemanticReply(
        force_field=_make_force_field(0).model_copy(update={"constraints": ()}),
        expectations=(
            ExpectedMotion(kind=MotionKind.MOVE, direction=LEFT, strength=1.3, window=(0, 25), words="bends"),
            ExpectedMotion(kind=MotionKind.SWAY, direction=LEFT, window=(25, 49), repeats=2, released=True),
        ),
        anchor=AnchorRequest(kind="base", words="plant"),
        evidence=(
            Evidence(
                words="wind bends", field="actions[0].action_type", value="translation", why="A wind pushes."
            ),
            Evidence(
                words="strong",
                field="actions[0].magnitude",
                value="0.60",
                why="Strong asks for more than 1, but a first try on a slender plant starts low.",
            ),
            Evidence(
                words="to the left", field="actions[0].vector", value="(-1, 0, 0)", why="The viewer's left."
            ),
            Evidence(
                words="then lets go", field="actions[0].active_time", value="[0, 25]", why="Ends half-way."
            ),
            Evidence(words="plant", field="anchor.kind", value="base", why="Plants stand in the ground."),
        ),
        not_understood=("zestfully",),
        notes=("The wind is even over the upper part of the plant.", "Letting go happens half-way through."),
    )


def _make_scene(prompt: str, field: ForceField) -> config.SceneConfig:
    return config.SceneConfig(
        prompt=prompt,
        source=config.Source(path="assets/ficus.ply", name="ficus", kind="plant"),
        material=config.Material(
            youngs_modulus=2e6, density=200, reason="Prior for plants: stems of soft wood."
        ),
        timing=config.Timing(frame_count=FRAMES, frame_dt=FRAME_DT),
        boundaries=(
            config.DomainBox(),
            config.HalfSpace(point=(2, 2, 1.5), normal=(0, 0, 1), surface="separate", friction=0.3),
        ),
        anchor=config.Anchor(
            kind="base", reason="The sentence speaks of a plant, and plants stand in the ground."
        ),
        force_field=field,
        scaling=SkillScaling(
            translation=2.0,
            scale=60.0,
            impulse=2.0,
            torque=3.14,
            velocity=1.0,
            reason="closed forms for L = 1 m",
        ),
    )


def _make_windows(index: int) -> tuple[WindowMotion, ...]:
    x = [-value for value in sway(index)]
    windows = []
    for first, last in ((0, 49), (0, 12), (12, 25), (25, 37), (37, 49)):
        moved = [value - x[first] for value in x[first : last + 1]]
        peak = max(range(len(moved)), key=lambda i, moved=moved: abs(moved[i]))
        windows.append(
            WindowMotion(
                first=first,
                last=last,
                displacement=(moved[-1], 0.0, 0.01),
                path_length=sum(abs(b - a) for a, b in zip(moved, moved[1:])),
                peak_displacement=(moved[peak], 0.0, 0.0),
                peak_frame=first + peak,
                rotation_axis=(0.0, 1.0, 0.0),
                rotation_degrees=40 * abs(moved[-1]),
                stretch=((1.02, 0, 0), (0, 1.0, 0), (0, 0, 0.98)),
                volume_ratio=1.01 if last < 40 else None,
                unobservable={} if last < 40 else {"volume_ratio": "part of the object is hidden"},
            )
        )
    return tuple(windows)


def _make_motion(index: int) -> MotionReport:
    ripple = [0.006 * math.sin(1.7 * frame) for frame in range(FRAMES)]
    seen = [
        None if frame in (33, 34) else (-0.97 * s + r, 0.3 * r, -0.1 * s)
        for frame, (s, r) in enumerate(zip(sway(index), ripple))
    ]
    return MotionReport(
        frame_count=FRAMES,
        frame_dt=FRAME_DT,
        object_size=0.98,
        object_center=(2.0, 2.0, 2.0),
        windows=_make_windows(index),
        centroid=tuple(seen),
        rotation_degrees=tuple(None if c is None else 45 * abs(c[0]) for c in seen),
        volume_ratio=tuple(1 + 0.2 * r for r in ripple),
        oscillation=Oscillation(direction=LEFT, frequency_hz=1.56, amplitude=REACHES[index] / 2, reversals=4),
        onset_frame=2,
        settle_frame=None,
        quality=Quality(
            tracks_kept=0.94,
            fit_residual=0.011,
            depth_noise=0.002,
            mask_fraction=0.14,
            leaves_frame=None,
            notes=("Two frames were not observable: the leaves hid each other.",),
        ),
        text=(
            f"The object moves to the left by up to {REACHES[index]:.2f} body lengths until frame 25, then swings "
            "back and forth twice with falling amplitude. It does not leave its place: the lower part stays where "
            "it is. It turns little and keeps its volume."
        ),
    )


def _make_judgement(index: int) -> Judgement:
    good = index == len(MAGNITUDES) - 1
    reach = REACHES[index]
    return Judgement(
        verdict=Verdict.SUCCESS if good else Verdict.FAIL,
        score=SCORES[index],
        checks=(
            Check(
                expectation=0,
                question="Does it move to the left while the wind blows?",
                expected="0.25 to 0.60 body lengths",
                observed=f"{reach:.2f} body lengths",
                passed=good,
                score=1.0 if good else reach / 0.31,
                margin=(reach - 0.25) / 0.1,
                confidence=0.83,
                gain=None if good else 0.31 / reach,
                remedy="" if good else f"Multiply the push by {0.31 / reach:.1f}.",
            ),
            Check(
                expectation=1,
                question="Does it swing back when the wind stops?",
                expected="at least 2 reversals",
                observed="4 reversals",
                passed=True,
                score=1.0,
            ),
            Check(
                expectation=1,
                question="Is it still at the end?",
                expected="no motion after frame 45",
                observed="the leaves hide the stem",
                passed=None,
                score=0.5,
            ),
        ),
        suggestion=""
        if good
        else "The bend is too small. Push harder; keep direction and timing as they are.",
    )


def _make_rewrite(index: int) -> Rewrite:
    before, after = MAGNITUDES[index : index + 2]
    return Rewrite(
        force_field=_make_force_field(index + 1),
        changes=(f"actions[0].magnitude from {before} to {after}: the bend was too small.",),
        rules_applied=("magnitude_range", "anchored_objects_keep_impulse")
        if index == 0
        else ("magnitude_range",),
    )


def _make_simulation(index: int) -> SimulationRecord:
    path = sway(index)
    speed = [0.0] + [(b - a) / FRAME_DT for a, b in zip(path, path[1:])]
    return SimulationRecord(
        particle_count=18_342,
        gaussian_count=31_007,
        grid_shape=(64, 48, 72),
        dx=4 / 96,
        substeps=49 * 80 + 40,
        substep_dt=tuple(5e-4 if k != 11 else 2.5e-4 for k in range(FRAMES - 1)),
        stable_dt=6.4e-4,
        redone_frames={12: "velocity above the grid's limit"} if index == 2 else {},
        stopped_particles=3 if index == 2 else 0,
        kinetic_energy=tuple(0.4 * v * v for v in speed),
        elastic_energy=tuple(6 * p * p for p in path),
        momentum=tuple((-8.0 * v, 0.2 * v, -0.8 * v) for v in speed),
        min_volume_ratio=tuple(1 - 0.3 * abs(p) for p in path),
        max_volume_ratio=tuple(1 + 0.4 * abs(p) for p in path),
        truth=TrueMotion(
            object_size=1.0,
            centroid=tuple((-p, 0.0, -0.1 * p) for p in path),
            rotation_degrees=tuple(44 * abs(p) for p in path),
            volume_ratio=tuple(1 + 0.02 * p for p in path),
            stretch=tuple((1 + 0.1 * p, 1.0, 1 - 0.08 * p) for p in path),
        ),
    )


def _make_manifest(prompt: str) -> Manifest:
    return Manifest(
        command='physagent run assets/ficus.ply "..." --seed 7',
        prompt=prompt,
        versions={"physagent-jax": "0.1.0", "jax": "0.12.0", "numpy": "2.4.6"},
        git_revision="5097a1b",
        platform="Linux x86_64, 2 cores, CPU",
        seed=7,
        inputs={"assets/ficus.ply": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"},
        iterations=3,
        best_iteration=2,
        verdict="SUCCESS",
        stages=Stages(
            prepare=2.1, compile=6.4, simulate=31.5, render=9.8, perceive=14.2, agents=7.516, write=1.3
        ),
        agents=(
            AgentCost(agent="semantic", implementation="rules", calls=1, seconds=0.012),
            AgentCost(
                agent="planner",
                implementation="chat model",
                calls=3,
                input_tokens=5210,
                output_tokens=884,
                seconds=7.5,
                latency_seconds=7.1,
            ),
            AgentCost(agent="executor", implementation="rules", calls=2, seconds=0.004),
        ),
        warnings=("Frame 12 of round 3 was redone with half the time step.",),
        complete=True,
    )
