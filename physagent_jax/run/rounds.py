"""One round of a run: a force field simulated, looked at and judged, its files left; or read back."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.naming import name_places
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Judgement
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.protocols import PerceptionBackends, SegmentPrompt
from physagent_jax.perception.schema import MotionReport
from physagent_jax.render.camera import Camera
from physagent_jax.run.account import Account
from physagent_jax.run.artifacts import rehearse_clip, write_clip, write_rollout, write_verdict
from physagent_jax.run.brief import make_brief
from physagent_jax.run.forecast import Forecast
from physagent_jax.run.key_frames import VideoKeyFrames
from physagent_jax.run.observer import Teller
from physagent_jax.run.prompt import make_part_prompts, make_prompt, read_mask
from physagent_jax.run.resolve import ResolvedRun
from physagent_jax.run.store import PLAIN_VIDEO, RunStore
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.config import CameraConfig, SceneConfig
from physagent_jax.scene.fuse import SceneTemplate, fuse
from physagent_jax.scene.world import find_ground_height
from physagent_jax.simulation.ending import Moved, go_on
from physagent_jax.simulation.recording import Recording, RestartCache
from physagent_jax.simulation.simulate import simulate_scene
from physagent_jax.simulation.stopwatch import stay_aside
from physagent_jax.simulation.views import draw_ending, reframe


@dataclasses.dataclass(frozen=True)
class Attempt:
    """One round of the loop, just made or read back: its scene, and what agents are told of it."""

    scene: SceneConfig
    round: Round

    def name_places(self) -> Judgement:
        """Its judgement with the names of actions for people in its suggestion."""
        named = name_places(self.round.judgement.suggestion, self.round.force_field)
        return self.round.judgement.model_copy(update={"suggestion": named})


@dataclasses.dataclass(frozen=True)
class Series:
    """Rounds on one version of the scene.

    Attributes:
        store: Where they are kept.
        template, body: What they have in common.
        name: Name of one of the files.
        forecast: Estimate of the time that is left; None = nobody is told, as the rounds are not in earnest.
        camera: Camera of the round before; None = there is none.
    """

    store: RunStore
    template: SceneTemplate
    body: Body
    name: str
    forecast: Forecast | None = None
    camera: CameraConfig | None = None


def _find_ground(series: Series, force_field: ForceField) -> float | None:
    """Height of the ground that the object touches at first [m]; None if it floats, hangs, or is let fall."""
    world, anchor = series.template.world, series.template.anchor
    if not world.ground or force_field.default_drop or anchor.kind == "top":
        return None
    return find_ground_height(world, series.body, anchor, drop=False)


class RoundMaker:
    """Makes rounds, each step timed, each leaving its files.

    Attributes:
        template, body: Scene and object that agents are told of; they go before the first call.
        restart_cache: What the next simulation may go on from; None = nothing.
    """

    template: SceneTemplate
    body: Body

    def __init__(
        self, run: ResolvedRun, agents: Agents, backends: PerceptionBackends, account: Account, teller: Teller
    ):
        self._run, self._planner, self._backends = run, agents.planner, backends
        self._account, self._teller, self._watch = account, teller, account.watch
        self._skills, self._rehearsed = describe_skills(), False  # whether the clip's programs are there
        self.restart_cache: RestartCache | None = None

    def make_context(self, reading: SemanticReply, rounds: Sequence[Round]) -> AgentContext:
        """The context of an agent's call."""
        brief = make_brief(
            self.template, frames_fixed=self._run.frames_fixed, parts=self._run.list_parts(self.body)
        )
        brief = brief.model_copy(update={"may_be_held": self._run.spec.anchor.kind == "auto"})
        return AgentContext(self._run.spec.prompt, brief, self._skills, reading, tuple(rounds))

    def make_segment_prompt(self, camera: Camera) -> SegmentPrompt | None:
        """The prompt that marks the object in the pictures of ``camera``; None if the spec gives none."""
        choice, preset = self._run.spec.perception.prompt, self.template.preset
        if choice is None:
            return None
        size = preset.rendering.width, preset.rendering.height, preset.timing.frame_count
        mask = read_mask(choice, *size, self._run.base_dir)
        return make_prompt(choice, camera.width, camera.height, mask)

    def make(self, series: Series, index: int, force_field: ForceField, context: AgentContext) -> Attempt:
        """Simulate ``force_field``, look at the pictures, judge them, and leave the round's files."""
        store, folder = series.store, f"iterations/{index}/"
        with self._watch("prepare"), self._teller.heed_warnings():
            config = fuse(series.template, series.body, force_field, keep=series.camera)
            scene = compile_scene(config, series.body, self._run.base_dir)
        recording = self._simulate(series, index, scene)
        scene, config = recording.scene, recording.scene.config
        moved, ending = None, None
        if self._planner.watches_ending(context) and self._run.spec.perception.prompt is None:
            moved, ending = self._look_at_ending(recording)
        with ThreadPoolExecutor(1) as pool:
            writing = pool.submit(self._write_recording, series, index, scene, recording, moved)
            self._teller.observer.stage(f"{series.name} {index + 1}: measuring the motion")
            windows = self._planner.windows(context)
            with self._watch("perceive"):
                seen = perceive(
                    recording.rgb,
                    recording.depth,
                    scene.camera,
                    frame_dt=config.timing.frame_dt,
                    windows=windows,
                    backends=self._backends,
                    prompt=self.make_segment_prompt(scene.camera),
                    parts=make_part_prompts(context, series.body),
                    ground=_find_ground(series, force_field),
                    length=series.body.extent,
                )
            with self._watch("write"):
                writing.result()
        key_frames = VideoKeyFrames(store.round_folder(index) / PLAIN_VIDEO)
        observation = Observation(force_field, seen.report, key_frames, ending=ending)
        answer = self._account.ask("planner", "judge", context, observation, store=store, folder=folder)
        with self._watch("write"):
            store.write(f"{folder}planner_trace.json", answer.trace)
            write_verdict(store, index, recording.rgb, seen, answer.value)
        if series.forecast is not None:
            series.forecast.end_round()
        self._account.save()
        return Attempt(config, Round(force_field, seen.report, key_frames, answer.value))

    def _look_at_ending(self, recording: Recording) -> tuple[Moved, MotionReport | None]:
        """The particles to the true end, and the motion from the last planned frame on; None if it ends there."""
        with self._watch("simulate"):
            moved = go_on(recording)
        if len(moved[0]) == len(recording.x):
            return moved, None
        with self._watch("render"):
            pictures = draw_ending(recording, *moved)
        scene, dt = recording.scene, recording.scene.config.timing.frame_dt
        length, backends = scene.body.extent, self._backends
        with self._watch("perceive"):
            seen = perceive(*pictures, scene.camera, frame_dt=dt, backends=backends, length=length)
        return moved, seen.report

    def _simulate(self, series: Series, index: int, scene: CompiledScene) -> Recording:
        """The recording of a round, with what can be kept of the one before."""
        observer, forecast = self._teller.observer, series.forecast

        def tell_frame(done: int, total: int) -> None:
            if forecast is not None:
                forecast.count_frame(done, total)
                observer.remaining(*forecast.find_left())
            observer.frame(done, total)

        observer.stage(f"{series.name} {index + 1}: simulating and rendering")
        with ThreadPoolExecutor(1) as pool:
            if forecast is not None:
                forecast.begin_round(index, scene.substeps * (scene.config.timing.frame_count - 1))
                pool.submit(self._rehearse, scene)
            cache = self.restart_cache
            most = forecast.most_substeps if forecast is not None else math.inf
            recording = simulate_scene(
                scene,
                watch=self._watch,
                progress=tell_frame,
                restart_cache=cache,
                most_substeps=most,
                foresee=index > 0,  # a few slow frames are no reason to do without any clip
            )
        placed = series.template.camera.target is not None or self._run.spec.perception.prompt is not None
        if not placed:  # a prompt tells pixels of the first picture
            with self._watch("render"):
                recording = reframe(recording)
        self.restart_cache = recording.restart_cache
        if forecast is not None:
            forecast.end_simulation()
        folder = series.store.round_folder(index).relative_to(self._account.store.path).as_posix()
        if recording.reused_frames:
            self._account.reused[folder] = recording.reused_frames
        return recording

    def _rehearse(self, scene: CompiledScene) -> None:
        """Compile what the clip needs on a core that the simulation leaves free; errors come when it is drawn."""
        size = self._run.spec.save.video_size
        if size is not None and not self._rehearsed:
            self._rehearsed = True
            with stay_aside():
                rehearse_clip(scene, size)

    def _write_recording(
        self, series: Series, index: int, scene: CompiledScene, recording: Recording, moved: Moved | None
    ) -> None:
        """Leave what was simulated, the clip for people first; meanwhile another thread measures the motion."""
        forecast, store, save = series.forecast, series.store, self._run.spec.save
        with stay_aside():
            if forecast is not None and save.video_size is not None:
                begun, stages = time.perf_counter(), self._watch.seconds()
                clip = write_clip(store, index, scene, recording, save.video_size, save.notes, moved)
                if index == 0:
                    self._account.note_first_clip(begun, stages)
                forecast.show_clip()
                self._teller.observer.shown(index, clip)
            earnest = forecast is not None
            frames = save.frames and earnest
            write_rollout(store, index, scene, recording, save_motion=earnest, save_frames=frames)

    def recall(self, series: Series, index: int) -> Attempt | None:
        """Round ``index`` from the folder, if it is complete."""
        folder = f"iterations/{index}"
        judgement = series.store.read(f"{folder}/judgement.json", Judgement)
        scene = series.store.read(f"{folder}/scene.json", SceneConfig)
        report = series.store.read(f"{folder}/motion_report.json", MotionReport)
        if judgement is None or scene is None or report is None:
            return None
        key_frames = VideoKeyFrames(series.store.round_folder(index) / PLAIN_VIDEO)
        return Attempt(scene, Round(scene.force_field, report, key_frames, judgement))

    def rewrite(self, series: Series, index: int, context: AgentContext, failed: Round) -> Rewrite:
        """The executor's next force field, from the folder if it is there."""
        folder = f"iterations/{index}/"
        rewrite = series.store.read(f"{folder}rewrite.json", Rewrite)
        if rewrite is None:
            answer = self._account.ask(
                "executor", "rewrite", context, failed, store=series.store, folder=folder
            )
            rewrite = answer.value
            series.store.write(f"{folder}executor_trace.json", answer.trace)
            series.store.write(f"{folder}rewrite.json", rewrite)
            self._account.save()
        return rewrite
