"""The closed loop: a sentence and an object in, a simulated 4D video and its reasons out.

    sentence -> semantic agent -> force field -> scene -> rollout -> pictures -> perception -> motion report
                                      ^                                                          |
                                      +----- executor <- suggestion <- planner (FAIL) <-----------+

Thin host code; everything that computes lives in the layers below.
"""

from __future__ import annotations

import dataclasses
import functools
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, NoReturn

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import AgentError, FailedCall, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.naming import name_places
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.progress import find_best_round, has_stalled
from physagent_jax.motion.schema import AnchorRequest, Judgement, SceneBrief, Verdict
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.protocols import PerceptionBackends, SegmentPrompt
from physagent_jax.perception.schema import MotionReport
from physagent_jax.render.camera import Camera
from physagent_jax.run.agent_calls import AgentCalls
from physagent_jax.run.artifacts import (
    put_best_on_top,
    rehearse_clip,
    write_best,
    write_clip,
    write_rollout,
    write_verdict,
)
from physagent_jax.run.brief import make_brief
from physagent_jax.run.chosen_agents import open_agents
from physagent_jax.run.first_picture import check_first_picture
from physagent_jax.run.forecast import Forecast
from physagent_jax.run.key_frames import VideoKeyFrames
from physagent_jax.run.manifest import STOP_REASONS, FirstClip, Stages, StopReason
from physagent_jax.run.observer import Observer
from physagent_jax.run.prompt import make_part_prompts, make_prompt, read_mask
from physagent_jax.run.provenance import hash_settings, make_manifest
from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.refused import REFUSED, RefusedReading
from physagent_jax.run.resolve import ResolvedRun
from physagent_jax.run.spec import RunSpec
from physagent_jax.run.store import PLAIN_VIDEO, PROBE, RunStore
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.camera import make_reference_camera
from physagent_jax.scene.coarse import coarsen
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.config import CameraConfig, SceneConfig
from physagent_jax.scene.cost import Cost, Limits, check_cost, estimate_cost
from physagent_jax.scene.fuse import SceneTemplate, damp, fuse
from physagent_jax.simulation.ahead import compile_ahead
from physagent_jax.simulation.recording import Recording, RestartCache
from physagent_jax.simulation.simulate import simulate_scene
from physagent_jax.simulation.stopwatch import Stopwatch, stay_aside

_FARTHER = 1.5  # times the distance from which the object was seen to leave the picture


@dataclasses.dataclass(frozen=True)
class Attempt:
    """One round of the loop, just made or read back: its scene, and what agents are told of it."""

    scene: SceneConfig
    round: Round


def backends_of(spec: RunSpec) -> PerceptionBackends:
    """The perception backends that ``spec`` names.

    Raises:
        UserError: One of them needs what is not installed, or does not take its options.
    """
    chosen = {role: getattr(spec.perception, role) for role in ("segmenter", "depth", "tracker")}
    return make_backends(**{role: (each.name, each.options) for role, each in chosen.items()})


def find_stop(judgements: Sequence[Judgement], cap: int, *, doubts: bool = False) -> StopReason | None:
    """The reason to make no further round, as far as the judgements tell; None = go on.

    Args:
        judgements: Judgements of the rounds so far, oldest first.
        cap: Number of rounds at most.
        doubts: Whether the sentence is not understood for certain: what fails then is not the force.
    """
    if judgements[-1].verdict is Verdict.SUCCESS:
        return "success"
    if has_stalled(judgements):
        return "no improvement"
    if len(judgements) >= cap:
        return "cap"
    return "doubts" if doubts else None


def _widen(attempt: Attempt) -> CameraConfig:
    """The camera of a round; from farther away if the object has left its picture."""
    camera = attempt.scene.camera
    if attempt.round.report.quality.leaves_frame is None:
        return camera
    return camera.model_copy(update={"distance": _FARTHER * camera.distance})


def explain_rest(judgement: Judgement) -> StopReason:
    """The reason for which an executor leaves a force field as it is."""
    unseen = any(check.passed is None for check in judgement.checks)
    failed = any(check.passed is False for check in judgement.checks)
    return "not observable" if unseen and not failed else "nothing left to try"


def run_loop(
    run: ResolvedRun,
    out: str | Path,
    *,
    agents: Agents | None = None,
    backends: PerceptionBackends | None = None,
    observer: Observer | None = None,
    limits: Limits | None = None,
    overwrite: bool = False,
    command: str = "",
) -> RunStore:
    """Run the loop until the planner is satisfied, no round improves, or the rounds are used up; resume a stopped run.

    A run with other agents or another perception is another run: what they said of one does not mix with the other.

    Args:
        run: What to make.
        out: Run folder.
        agents: Who reads, judges and rewrites; None = whom the spec names.
        backends: What perception sees with; None = what the spec names.
        observer: Told of the progress.
        limits: What a round may take.
        overwrite: Replace another run in ``out``.
        command: How the run was started, for the record.

    Returns:
        The finished run folder. The report page is the caller's to write (`report.html.write_report`).

    Raises:
        UserError: Input that a person can mend; a run folder is only begun once object and sentence
            are understood. What a model said of the sentence until then is kept (`run.refused`).
        AgentError: An agent gave no answer. What it tried is in the run folder, its tokens are counted there, and the
            same call goes on with the same question.
    """
    if agents is None:
        with open_agents(run.spec, run.base_dir) as agents:
            return run_loop(
                run,
                out,
                agents=agents,
                backends=backends,
                observer=observer,
                limits=limits,
                overwrite=overwrite,
                command=command,
            )
    backends = backends or backends_of(run.spec)
    if run.spec.perception.prompt is not None and not backends.segmenter.takes_prompt:
        raise UserError(
            "`perception.prompt` means nothing to this segmenter",
            got=backends.segmenter.name,
            do="Leave it out, or choose another `perception.segmenter`",
        )
    named = {"agents": hash_settings(agents.names), "perception": hash_settings(backends.names)}
    inputs = {**run.inputs, **named}
    manifest = make_manifest(command=command, prompt=run.spec.prompt, seed=run.spec.seed, inputs=inputs)
    manifest = manifest.model_copy(update=dict(warnings=run.warnings))
    with RunStore.open(out, manifest, overwrite=overwrite, needed=run.files) as store:
        if store.manifest.complete:
            return store
        compile_ahead()  # while the sentence is read and the object loaded
        loop = _Loop(run, agents, backends, observer or Observer(), store)
        body = loop.load_object()
        reading = loop.read_sentence(body)
        reply = reading.value
        loop.observer.understood(reply)
        try:
            template = loop.apply_reply(reply, body)
            with loop.tell_warnings():
                config = fuse(template, body, reply.force_field)
            cost = estimate_cost(config, body, run.spec.save.video_size)
            check_cost(cost, limits or Limits())
            loop.expect(cost)
            loop.check_pictures(config, body)
        except UserError as error:
            loop.refuse(reading, error)
        store.begin()
        loop.save_costs()
        try:
            loop.write_spec()
            store.write("semantic_trace.json", reading.trace)
            store.write("semantic.json", reply)
            store.drop_refused()
            force_field = reply.force_field
            if run.spec.probe:
                force_field = loop.probe(template, body, reply)
            series = _Series(store, template, body, "round", loop.observer.judged)
            with loop.tell_warnings():  # of what is warned of beside the making of a scene
                attempts = list(loop.rounds(series, force_field, reply))
        except AgentError:
            raise
        except UserError as error:
            if store.discard_if_barren():
                loop.refuse(reading, error)
            raise
        loop.finish(attempts, body)
        return store


@dataclasses.dataclass(frozen=True)
class _Series:
    """Rounds on one version of the scene.

    Attributes:
        store: Where they are kept.
        template, body: What they have in common.
        name: Name of one of the files.
        judged: Told of every judgement.
        camera: Camera of the round before; None = there is none.
    """

    store: RunStore
    template: SceneTemplate
    body: Body
    name: str
    judged: Callable[[int, Judgement], None]
    camera: CameraConfig | None = None


class _Loop:
    """The loop's steps, each timed, each leaving its files."""

    def __init__(
        self,
        run: ResolvedRun,
        agents: Agents,
        backends: PerceptionBackends,
        observer: Observer,
        store: RunStore,
    ):
        self._run, self._agents, self._backends = run, agents, backends
        self.observer, self._store, self._skills = observer, store, describe_skills()
        self._watch = Stopwatch(store.manifest.stages.model_dump())
        self._calls = AgentCalls(agents, store.manifest.agents)
        self._template = run.template
        self._restart_cache: RestartCache | None = None
        self._parts: tuple[Part, ...] = ()
        self._reused = dict(store.manifest.reused_frames)
        self._warnings: tuple[str, ...] = ()
        self._stopped: StopReason | None = None
        self._begun = time.perf_counter()
        self._forecast: Forecast | None = None
        self._rehearsed = False  # whether the clip's programs are there
        self._first_clip: FirstClip | None = store.manifest.first_clip

    def expect(self, cost: Cost) -> None:
        """Begin to say how long the run will take, from what a round should cost."""
        self._forecast = Forecast(cost, self._run.spec.rounds)

    def read_sentence(self, body: Body) -> Reply[SemanticReply]:
        """The semantic agent's reply, from the folder if it is there."""
        reply = self._store.read("semantic.json", SemanticReply)
        if reply is not None:
            return Reply(reply, self._store.read("semantic_trace.json", Trace) or Trace())
        refused = self._store.find_refused()
        if refused is not None:
            self._calls = AgentCalls(self._agents, refused.agents)
            return Reply(refused.reply, refused.trace)
        self.observer.stage("reading the sentence")
        ask = functools.partial(self._ask, self._store, "", "semantic", "compile")
        return read_for_scene(self._run, body, ask)

    def refuse(self, reading: Reply[SemanticReply], error: UserError) -> NoReturn:
        """End a run that has simulated nothing; what a model said of the sentence is kept, for it is paid for.

        Raises:
            UserError: ``error``, with the place of what is kept.
        """
        if reading.trace.is_empty:
            raise error  # rules say the same again, for nothing
        self._store.keep_refused(
            RefusedReading(
                inputs=self._store.manifest.inputs,
                prompt=self._run.spec.prompt,
                error=str(error),
                reply=reading.value,
                trace=reading.trace,
                agents=tuple(self._calls.costs.values()),
            )
        )
        kept = f"The sentence has been read: {self._store.path / REFUSED} keeps that for the same run"
        do = f"{error.do.rstrip('.')}. {kept}" if error.do else kept
        raise UserError(error.what, got=error.got, do=do) from error

    def write_spec(self) -> None:
        """Leave what was asked for."""
        self._store.write("run.json", self._run.spec.located(self._run.base_dir))

    def load_object(self) -> Body:
        """The object at rest, filled and bound; agents are told whether it stands."""
        self.observer.stage("loading and filling the object")
        template = self._run.template
        preset = template.preset
        with self._watch("prepare"), self.tell_warnings():
            body = make_body(template.source, preset.filling, preset.domain, self._run.base_dir)
            self._template, _ = self._run.place(body)
            self._parts = body.parts
        self.observer.assumed(f"the object's file was read as {body.reading}")
        return body

    @contextmanager
    def tell_warnings(self) -> Iterator[None]:
        """Notes what is warned of within, and tells the observer what he has not been told."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            yield
        for text in dict.fromkeys(str(warning.message) for warning in caught):
            if text not in self._warnings:
                self._warnings += (text,)
                self.observer.warned(text)

    def apply_reply(self, reply: SemanticReply, body: Body) -> SceneTemplate:
        """The scene template with what the sentence says about holding, the world and the clip's length."""
        self._template, notes = self._run.place(body, reply)
        self._warnings += notes
        for note in notes:
            self.observer.warned(note)
        if (note := damp(self._template, body)[1]) is not None:
            self.observer.assumed(note)
        return self._template

    def check_pictures(self, config: SceneConfig, body: Body) -> None:
        """Refuse a scene that perception could not measure, and warn of one that it can measure in part.

        Raises:
            UserError: Nothing could be measured (`run.first_picture`).
        """
        camera = make_reference_camera(config.camera, config.rendering, config.domain)
        with self._watch("prepare"):
            notes = check_first_picture(config, body, self._make_segment_prompt(camera))
        self._warnings += notes
        for note in notes:
            self.observer.warned(note)

    def probe(self, template: SceneTemplate, body: Body, reply: SemanticReply) -> ForceField:
        """The best force field of rounds on a coarse version of the scene; the sentence's if there is none."""
        attempts: list[Attempt] = []
        try:
            with self._watch.all_to("probe"), warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # as they were heeded for the object in earnest
                series = self._coarsen(template, body)
                for attempt in self.rounds(series, reply.force_field, reply):
                    attempts.append(attempt)  # one by one: those before an error count
        except AgentError:
            raise  # no fault of the coarse scene's: rounds in earnest would ask the same agent
        except UserError as error:
            self._warnings += (f"coarse rounds were left out: {error}",)
        if not attempts:
            return reply.force_field
        best = find_best_round([attempt.round.judgement for attempt in attempts])
        self.save_costs(probe_iterations=len(attempts), probe_best=best)
        return attempts[best].scene.force_field

    def _coarsen(self, template: SceneTemplate, body: Body) -> _Series:
        with self._watch("prepare"):
            preset = coarsen(template.preset, body)
            coarse = dataclasses.replace(template, preset=preset)
            base_dir = self._run.base_dir
            small = make_body(template.source, preset.filling, preset.domain, base_dir)
        return _Series(self._store.part(PROBE), coarse, small, "coarse round", self.observer.probed)

    def rounds(self, series: _Series, force_field: ForceField, reply: SemanticReply) -> Iterator[Attempt]:
        """Try ``force_field`` and what the executor makes of it, until a `StopReason` holds."""
        attempts: list[Attempt] = []
        self._restart_cache = None
        for index in range(self._run.spec.rounds):
            context = self._make_context(reply, [attempt.round for attempt in attempts])
            try:
                attempt = self.recall(series, index) or self.attempt(series, index, force_field, context)
            except AgentError:
                raise
            except UserError as error:
                if not attempts:
                    raise
                self._leave_out(f"{series.name} {index + 1}", error)  # the rounds before it are worth keeping
                break
            attempts.append(attempt)
            series.judged(index, _name_in(attempt.round.judgement, attempt.round.force_field))
            if series.store is self._store:
                best = find_best_round([each.round.judgement for each in attempts])
                put_best_on_top(self._store, best, save_frames=self._run.spec.save.frames)
            yield attempt
            judgements = [each.round.judgement for each in attempts]
            self._stopped = find_stop(judgements, self._run.spec.rounds, doubts=bool(reply.unsure))
            if self._stopped is not None:
                break
            # The camera stays, so that the rounds' pictures can be compared, as long as it shows what will happen.
            series = dataclasses.replace(series, camera=_widen(attempt))
            rewrite = self.rewrite(series, index, context, attempt.round)
            if rewrite.hold is not None and series.store is self._store:
                series = self._hold(series, reply, rewrite.hold)
            elif rewrite.force_field == force_field:
                self._stopped = explain_rest(judgements[-1])  # another round would only repeat this one
                break
            force_field = rewrite.force_field
        if self._stopped not in (None, "success", "cap") and series.store is self._store:
            self.observer.ended(STOP_REASONS[self._stopped])

    def _hold(self, series: _Series, reply: SemanticReply, place: Literal["base"]) -> _Series:
        """The same rounds with the object held from now on."""
        held = reply.model_copy(update={"anchor": AnchorRequest(kind=place)})
        self._template, _ = self._run.place(series.body, held)
        self._restart_cache = None
        return dataclasses.replace(series, template=self._template)

    def _leave_out(self, name: str, error: UserError) -> None:
        """Note a round that could not be simulated."""
        self._stopped, note = "failed round", f"{name} is left out: {error}"
        self._warnings += (note,)
        self.observer.warned(note)

    def attempt(self, series: _Series, index: int, force_field: ForceField, context: AgentContext) -> Attempt:
        """Simulate ``force_field``, look at the pictures, judge them, and leave the round's files."""
        with self._watch("prepare"), self.tell_warnings():
            config = fuse(series.template, series.body, force_field, keep=series.camera)
            scene = compile_scene(config, series.body, self._run.base_dir)
        name = f"{series.name} {index + 1}"
        earnest = series.store is self._store
        forecast = self._forecast if earnest else None
        if forecast is not None:
            forecast.begin_round(index)

        def tell_frame(done: int, total: int) -> None:
            if forecast is not None:
                forecast.count_frame(done, total)
                self.observer.remaining(*forecast.find_left())
            self.observer.frame(done, total)

        self.observer.stage(f"{name}: simulating and rendering")
        with ThreadPoolExecutor(1) as pool:
            if earnest:
                pool.submit(self._rehearse, scene)
            recording = simulate_scene(
                scene,
                watch=self._watch,
                progress=tell_frame,
                restart_cache=self._restart_cache,
            )
        self._restart_cache = recording.restart_cache
        if recording.reused_frames:
            folder = series.store.round_folder(index).relative_to(self._store.path).as_posix()
            self._reused[folder] = recording.reused_frames
        if forecast is not None:
            forecast.end_simulation()
        with ThreadPoolExecutor(1) as pool:
            writing = pool.submit(self._write_recording, series.store, index, scene, recording)
            self.observer.stage(f"{name}: measuring the motion")
            windows = self._agents.planner.windows(context)
            with self._watch("perceive"):
                seen = perceive(
                    recording.rgb,
                    recording.depth,
                    scene.camera,
                    frame_dt=config.timing.frame_dt,
                    windows=windows,
                    backends=self._backends,
                    prompt=self._make_segment_prompt(scene.camera),
                    parts=make_part_prompts(context, series.body),
                )
            with self._watch("write"):
                writing.result()
        key_frames = VideoKeyFrames(series.store.round_folder(index) / PLAIN_VIDEO)
        observation = Observation(force_field, seen.report, key_frames)
        answer = self._ask(series.store, f"iterations/{index}/", "planner", "judge", context, observation)
        with self._watch("write"):
            series.store.write(f"iterations/{index}/planner_trace.json", answer.trace)
            write_verdict(series.store, index, recording.rgb, seen, answer.value)
        if forecast is not None:
            forecast.end_round()
        self.save_costs()
        return Attempt(config, Round(force_field, seen.report, key_frames, answer.value))

    def _rehearse(self, scene: CompiledScene) -> None:
        """Compile what the clip needs on a core that the simulation leaves free; errors come when it is drawn."""
        size = self._run.spec.save.video_size
        if size is not None and not self._rehearsed:
            self._rehearsed = True
            with stay_aside():
                rehearse_clip(scene, size)

    def _write_recording(
        self, store: RunStore, index: int, scene: CompiledScene, recording: Recording
    ) -> None:
        """Leave what was simulated, the clip for people first; meanwhile another thread measures the motion."""
        earnest, save = store is self._store, self._run.spec.save
        with stay_aside():
            if earnest and save.video_size is not None:
                begun, stages = time.perf_counter(), self._watch.seconds()
                clip = write_clip(store, index, scene, recording, save.video_size, save.notes)
                now = time.perf_counter()
                if self._first_clip is None and index == 0:
                    times = {"seconds": now - self._begun, "draw": now - begun}
                    self._first_clip = FirstClip(
                        **{name: round(each, 4) for name, each in times.items()}, stages=Stages(**stages)
                    )
                if self._forecast is not None:
                    self._forecast.show_clip()
                self.observer.shown(index, clip)
            frames = save.frames and earnest
            write_rollout(store, index, scene, recording, save_motion=earnest, save_frames=frames)

    def recall(self, series: _Series, index: int) -> Attempt | None:
        """Round ``index`` from the folder, if it is complete."""
        folder = f"iterations/{index}"
        judgement = series.store.read(f"{folder}/judgement.json", Judgement)
        scene = series.store.read(f"{folder}/scene.json", SceneConfig)
        report = series.store.read(f"{folder}/motion_report.json", MotionReport)
        if judgement is None or scene is None or report is None:
            return None
        key_frames = VideoKeyFrames(series.store.round_folder(index) / PLAIN_VIDEO)
        return Attempt(scene, Round(scene.force_field, report, key_frames, judgement))

    def rewrite(self, series: _Series, index: int, context: AgentContext, failed: Round) -> Rewrite:
        """The executor's next force field, from the folder if it is there."""
        folder = f"iterations/{index}/"
        rewrite = series.store.read(f"{folder}rewrite.json", Rewrite)
        if rewrite is None:
            answer = self._ask(series.store, folder, "executor", "rewrite", context, failed)
            rewrite = answer.value
            series.store.write(f"{folder}executor_trace.json", answer.trace)
            series.store.write(f"{folder}rewrite.json", rewrite)
            self.save_costs()
        return rewrite

    def finish(self, attempts: list[Attempt], body: Body) -> None:
        """Put the best round's files at the top of the folder and close the manifest."""
        judgements = [attempt.round.judgement for attempt in attempts]
        best = find_best_round(judgements)
        self.observer.stage("writing the results")
        with self._watch("write"):
            save = self._run.spec.save
            write_best(
                self._store,
                best,
                attempts[best].scene,
                body,
                save_frames=save.frames,
                save_splats=save.splats,
                video_size=save.video_size,
                notes=save.notes,
            )
        self.save_costs(
            iterations=len(attempts),
            best_iteration=best,
            verdict=judgements[best].verdict.value,
            stopped=self._stopped,
            warnings=(*self._run.warnings, *self._warnings),
        )
        self._store.finish()

    def _ask(self, store: RunStore, folder: str, role: str, method: str, *arguments) -> Reply:
        """Call an agent; if it has no answer, what it tried is left in ``folder``."""
        try:
            with self._watch("agents"):
                return self._calls.ask(role, method, *arguments)
        except AgentError as error:
            self._store.begin()
            self.write_spec()
            name = f"{folder}{role}_failed_{self._calls.costs[role].failed_calls}.json"
            store.write(name, FailedCall(error=str(error), trace=error.trace))
            self.save_costs()
            do = f"{error.do or 'The same command asks again'}; {store.path / name} holds the exchange"
            raise AgentError(error.what, trace=error.trace, got=error.got, do=do) from error

    def save_costs(self, **changes) -> None:
        """Write what the run has cost so far into the manifest, with ``changes`` to it."""
        costs = dict(stages=Stages(**self._watch.seconds()), agents=tuple(self._calls.costs.values()))
        self._store.update(**costs, first_clip=self._first_clip, reused_frames=self._reused, **changes)

    def _make_segment_prompt(self, camera: Camera) -> SegmentPrompt | None:
        """The prompt that marks the object in the pictures of ``camera``; None if the spec gives none."""
        choice, preset = self._run.spec.perception.prompt, self._template.preset
        if choice is None:
            return None
        size = (preset.rendering.width, preset.rendering.height)
        mask = read_mask(choice, *size, preset.timing.frame_count, self._run.base_dir)
        return make_prompt(choice, camera.width, camera.height, mask)

    def _make_context(
        self, reading: SemanticReply | None = None, rounds: Iterable[Round] = ()
    ) -> AgentContext:
        """The context of an agent's call."""
        return AgentContext(self._run.spec.prompt, self._make_brief(), self._skills, reading, tuple(rounds))

    def _make_brief(self) -> SceneBrief:
        brief = make_brief(self._template, frames_fixed=self._run.frames_fixed, parts=self._parts)
        return brief.model_copy(update={"may_be_held": self._run.spec.anchor.kind == "auto"})


def _name_in(judgement: Judgement, force_field: ForceField) -> Judgement:
    """The judgement with the names of actions for people in its suggestion."""
    return judgement.model_copy(update=dict(suggestion=name_places(judgement.suggestion, force_field)))
