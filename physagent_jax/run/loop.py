"""The closed loop: a sentence and an object in, a simulated 4D video and its reasons out.

    sentence -> semantic agent -> force field -> scene -> rollout -> pictures -> perception -> motion report
                                      ^                                                          |
                                      +----- executor <- suggestion <- planner (FAIL) <-----------+

Thin host code; everything that computes lives in the layers below. `run.rounds` makes one round.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Literal

from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import AgentError, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.progress import find_best_round
from physagent_jax.motion.schema import AnchorRequest
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.protocols import PerceptionBackends
from physagent_jax.run.account import Account
from physagent_jax.run.artifacts import put_best_on_top, write_best
from physagent_jax.run.chosen_agents import open_agents
from physagent_jax.run.first_picture import check_first_picture
from physagent_jax.run.forecast import Forecast
from physagent_jax.run.observer import Observer, Teller
from physagent_jax.run.provenance import hash_settings, make_manifest
from physagent_jax.run.reading import read_for_scene
from physagent_jax.run.resolve import ResolvedRun
from physagent_jax.run.rounds import Attempt, RoundMaker, Series
from physagent_jax.run.stopping import STOP_REASONS, StopReason, explain_rest, find_stop
from physagent_jax.run.store import PROBE, RunStore
from physagent_jax.run.unknown_parts import UnknownPartError, draw_known
from physagent_jax.scene.body import Body, make_body
from physagent_jax.scene.camera import make_reference_camera
from physagent_jax.scene.coarse import coarsen
from physagent_jax.scene.cost import MINUTES, Cost, Limits, check_cost, estimate_cost
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.standing import damp
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.simulation.ahead import compile_ahead


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
    perception = run.spec.perception.located(run.base_dir)
    chosen = {role: getattr(perception, role) for role in ("segmenter", "depth", "tracker")}
    backends = backends or make_backends(**{role: (each.name, each.options) for role, each in chosen.items()})
    if run.spec.perception.prompt is not None and not backends.segmenter.takes_prompt:
        raise UserError(
            "`perception.prompt` means nothing to this segmenter",
            got=backends.segmenter.name,
            do="Leave it out, or choose another `perception.segmenter`",
        )
    with ExitStack() as stack:
        agents = agents or stack.enter_context(open_agents(run.spec, run.base_dir))
        named = {"agents": agents.names, "perception": backends.names}
        inputs = run.inputs | {role: hash_settings(names) for role, names in named.items()}
        manifest = make_manifest(command=command, prompt=run.spec.prompt, seed=run.spec.seed, inputs=inputs)
        manifest = manifest.model_copy(update=dict(warnings=run.warnings))
        store = stack.enter_context(RunStore.open(out, manifest, overwrite=overwrite, needed=run.files))
        if not store.manifest.complete:
            compile_ahead()  # while the sentence is read and the object loaded
            _Loop(run, agents, backends, Teller(observer or Observer()), store).run(limits or Limits())
        return store


class _Loop:
    """The loop's steps, each timed, each leaving its files."""

    def __init__(
        self, run: ResolvedRun, agents: Agents, backends: PerceptionBackends, teller: Teller, store: RunStore
    ):
        self._run, self._store, self._teller = run, store, teller
        self._account = Account(run, agents, store)
        self._maker = RoundMaker(run, agents, backends, self._account, teller)
        self._stopped: StopReason | None = None

    def run(self, limits: Limits) -> None:
        """Load, read, try, rewrite, and finish; see `run_loop`."""
        store, account, teller = self._store, self._account, self._teller
        body = self._load_object()
        reading = self._read_sentence(body)
        reply = reading.value
        if not reply.unknown_parts:  # else the refusal says it all
            teller.observer.understood(reply)
        with account.watch("prepare"):
            body = self._maker.body = self._run.turn(body, reply)
        try:
            template, cost = self._place(reply, body, limits)
        except UnknownPartError as error:
            path = store.path.with_name(f"{store.path.name}.parts.png")  # a run folder holds a run
            account.refuse(reading, draw_known(error, body, self._maker.template, path))
        except UserError as error:
            account.refuse(reading, error)
        store.begin()
        account.save()
        try:
            account.write_spec()
            store.write("semantic_trace.json", reading.trace)
            store.write("semantic.json", reply)
            store.drop_refused()
            force_field = self._probe(template, body, reply) if self._run.spec.probe else reply.force_field
            patience = max(1.0, limits.minutes / MINUTES)
            forecast = Forecast(cost, self._run.spec.rounds, patience=patience)
            series = Series(store, template, body, "round", forecast)
            with teller.heed_warnings():  # of what is warned of beside the making of a scene
                attempts = list(self._make_rounds(series, force_field, reply))
        except UserError as error:
            if not isinstance(error, AgentError) and store.discard_if_barren():
                account.refuse(reading, error)
            raise
        self._finish(attempts, body)

    def _load_object(self) -> Body:
        """The object at rest, filled and bound; agents are told whether it stands."""
        observer, template, preset = self._teller.observer, self._run.template, self._run.template.preset
        observer.stage("loading and filling the object")
        with self._account.watch("prepare"), self._teller.heed_warnings():
            body = make_body(template.source, preset.filling, preset.domain, self._run.base_dir)
            self._maker.body, self._maker.template = body, self._run.place_for_agents(body)
        observer.assumed(f"the object's file was read as {body.reading}")
        return body

    def _read_sentence(self, body: Body) -> Reply[SemanticReply]:
        """The semantic agent's reply, from the folder if it is there."""
        reply = self._store.read("semantic.json", SemanticReply)
        if reply is not None:
            return Reply(reply, self._store.read("semantic_trace.json", Trace) or Trace())
        if (refused := self._account.recall_refused()) is not None:
            return refused
        self._teller.observer.stage("reading the sentence")
        return read_for_scene(self._run, body, partial(self._account.ask, "semantic", "compile"))

    def _place(self, reply: SemanticReply, body: Body, limits: Limits) -> tuple[SceneTemplate, Cost]:
        """The scene template with what the sentence says about holding, the world and the clip's length, and its cost.

        Raises:
            UserError: It takes too much, or perception could not measure it (`run.first_picture`).
        """
        teller, maker = self._teller, self._maker
        maker.template, notes = self._run.place(body, reply)
        teller.warn(*notes)
        if (note := damp(maker.template, body)[1]) is not None:
            teller.observer.assumed(note)
        with teller.heed_warnings():
            config = fuse(maker.template, body, reply.force_field)
        cost = estimate_cost(config, body, self._run.spec.save.video_size)
        check_cost(cost, limits)
        camera = make_reference_camera(config.camera, config.rendering, config.domain)
        with self._account.watch("prepare"):
            teller.warn(*check_first_picture(config, body, maker.make_segment_prompt(camera)))
        return maker.template, cost

    def _probe(self, template: SceneTemplate, body: Body, reply: SemanticReply) -> ForceField:
        """The best force field of rounds on a coarse version of the scene; the sentence's if there is none."""
        attempts: list[Attempt] = []
        try:
            with self._account.watch.all_to("probe"), warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # as they were heeded for the object in earnest
                with self._account.watch("prepare"):
                    coarse = dataclasses.replace(template, preset=coarsen(template.preset, body))
                    parts = coarse.preset.filling, coarse.preset.domain
                    small = make_body(coarse.source, *parts, self._run.base_dir)
                series = Series(self._store.part(PROBE), coarse, small, "coarse round")
                for attempt in self._make_rounds(series, reply.force_field, reply):
                    attempts.append(attempt)  # one by one: those before an error count
        except UserError as error:
            if isinstance(error, AgentError):
                raise  # no fault of the coarse scene's: rounds in earnest would ask the same agent
            self._teller.warnings += (f"coarse rounds were left out: {error}",)
        if not attempts:
            return reply.force_field
        best = find_best_round([attempt.round.judgement for attempt in attempts])
        self._account.save(probe_iterations=len(attempts), probe_best=best)
        return attempts[best].scene.force_field

    def _make_rounds(
        self, series: Series, force_field: ForceField, reply: SemanticReply
    ) -> Iterator[Attempt]:
        """Try ``force_field`` and what the executor makes of it, until a `StopReason` holds."""
        attempts: list[Attempt] = []
        observer, self._maker.restart_cache = self._teller.observer, None
        for index in range(self._run.spec.rounds):
            context = self._maker.make_context(reply, [attempt.round for attempt in attempts])
            try:
                attempt = self._maker.recall(series, index) or self._maker.make(
                    series, index, force_field, context
                )
            except UserError as error:
                if isinstance(error, AgentError) or not attempts:
                    raise
                self._stopped = "failed round"  # those before it are worth keeping
                self._teller.warn(f"{series.name} {index + 1} is left out: {error}")
                break
            attempts.append(attempt)
            judgements = [each.round.judgement for each in attempts]
            if series.forecast is None:
                observer.probed(index, attempt.name_places())
            else:
                observer.judged(index, attempt.name_places())
                put_best_on_top(
                    self._store, find_best_round(judgements), save_frames=self._run.spec.save.frames
                )
            yield attempt
            self._stopped = find_stop(judgements, self._run.spec.rounds, doubts=bool(reply.unsure))
            if self._stopped is not None:
                break
            # The camera stays, so that the rounds' pictures can be compared, as long as it shows what will happen.
            series = dataclasses.replace(series, camera=attempt.scene.camera)
            rewrite = self._maker.rewrite(series, index, context, attempt.round)
            if rewrite.hold is not None and series.forecast is not None:
                series = self._hold(series, reply, rewrite.hold)
            elif rewrite.force_field == force_field:
                self._stopped = explain_rest(judgements[-1])  # another round would only repeat this one
                break
            force_field = rewrite.force_field
        if self._stopped not in (None, "success", "cap") and series.forecast is not None:
            observer.ended(STOP_REASONS[self._stopped])

    def _hold(self, series: Series, reply: SemanticReply, place: Literal["base"]) -> Series:
        """The same rounds with the object held from now on."""
        held = reply.model_copy(update={"anchor": AnchorRequest(kind=place)})
        self._maker.template, _ = self._run.place(series.body, held)
        self._maker.restart_cache = None
        return dataclasses.replace(series, template=self._maker.template)

    def _finish(self, attempts: list[Attempt], body: Body) -> None:
        """Put the best round's files at the top of the folder and close the manifest."""
        judgements = [attempt.round.judgement for attempt in attempts]
        best = find_best_round(judgements)
        self._teller.observer.stage("writing the results")
        with self._account.watch("write"):
            write_best(self._store, best, attempts[best].scene, body, self._run.spec.save)
        self._account.save(
            iterations=len(attempts),
            best_iteration=best,
            verdict=judgements[best].verdict.value,
            stopped=self._stopped,
            warnings=(*self._run.warnings, *self._teller.warnings),
        )
        self._store.finish()
