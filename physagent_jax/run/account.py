"""The account of a run: its agents' answers, and what everything has cost so far."""

from __future__ import annotations

import time
from typing import NoReturn

from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import AgentError, FailedCall, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.run.manifest import AgentCost, FirstClip, Stages
from physagent_jax.run.refused import REFUSED, RefusedReading
from physagent_jax.run.resolve import ResolvedRun
from physagent_jax.run.store import RunStore
from physagent_jax.simulation.stopwatch import Stopwatch


class Account:
    """Asks agents, and keeps in the manifest what a run has cost.

    Attributes:
        store: The run folder.
        watch: Adds up the time of each stage.
        reused: Frames that a round took over from another one, by the round's folder.
    """

    def __init__(self, run: ResolvedRun, agents: Agents, store: RunStore):
        self.store, self._run, self._agents = store, run, agents
        self.watch = Stopwatch(store.manifest.stages.model_dump())
        self._costs = {cost.agent: cost for cost in store.manifest.agents}
        self.reused = dict(store.manifest.reused_frames)
        self._first_clip, self._begun = store.manifest.first_clip, time.perf_counter()

    def ask(
        self, role: str, method: str, *arguments, store: RunStore | None = None, folder: str = ""
    ) -> Reply:
        """Call ``method`` of the agent in ``role``.

        Raises:
            AgentError: It has no answer. What it tried is left in ``folder`` of ``store``, and charged like any other.
        """
        agent, begun, store = getattr(self._agents, role), time.perf_counter(), store or self.store
        try:
            with self.watch("agents"):
                reply = getattr(agent, method)(*arguments)
        except AgentError as error:
            self._charge(role, error.trace, time.perf_counter() - begun, failed=True)
            what = f"the {role} ({agent.name}) gave no answer: {error.what}"
            self.store.begin()
            self.write_spec()
            name = f"{folder}{role}_failed_{self._costs[role].failed_calls}.json"
            told = str(AgentError(what, trace=error.trace, got=error.got, do=error.do))
            store.write(name, FailedCall(error=told, trace=error.trace))
            self.save()
            do = f"{error.do or 'The same command asks again'}; {store.path / name} holds the exchange"
            raise AgentError(what, trace=error.trace, got=error.got, do=do) from error
        self._charge(role, reply.trace, time.perf_counter() - begun)
        return reply

    def recall_refused(self) -> Reply[SemanticReply] | None:
        """The answer of the semantic agent that an earlier process was told, and could not use."""
        refused = self.store.find_refused()
        if refused is None:
            return None
        self._costs = {cost.agent: cost for cost in refused.agents}
        return Reply(refused.reply, refused.trace)

    def refuse(self, reading: Reply[SemanticReply], error: UserError) -> NoReturn:
        """End a run that has simulated nothing; what a model said of the sentence is kept, for it is paid for.

        Raises:
            UserError: ``error``, with the place of what is kept.
        """
        if reading.trace.is_empty:
            raise error  # rules say the same again, for nothing
        self.store.keep_refused(
            RefusedReading(
                inputs=self.store.manifest.inputs,
                prompt=self._run.spec.prompt,
                error=str(error),
                reply=reading.value,
                trace=reading.trace,
                agents=tuple(self._costs.values()),
            )
        )
        kept = f"The sentence has been read: {self.store.path / REFUSED} keeps that for the same run"
        do = f"{error.do.rstrip('.')}. {kept}" if error.do else kept
        raise UserError(error.what, got=error.got, do=do) from error

    def write_spec(self) -> None:
        """Leave what was asked for."""
        self.store.write("run.json", self._run.spec.located(self._run.base_dir))

    def note_first_clip(self, begun: float, stages: dict[str, float]) -> None:
        """Note that the run's first clip is there, which was ``begun`` [s] after ``stages`` that took so long [s]."""
        if self._first_clip is None:
            now = time.perf_counter()
            self._first_clip = FirstClip(
                seconds=round(now - self._begun, 4), draw=round(now - begun, 4), stages=Stages(**stages)
            )

    def save(self, **changes) -> None:
        """Write what the run has cost so far into the manifest, with ``changes`` to it."""
        costs = dict(stages=Stages(**self.watch.seconds()), agents=tuple(self._costs.values()))
        self.store.update(**costs, first_clip=self._first_clip, reused_frames=self.reused, **changes)

    def _charge(self, role: str, trace: Trace, seconds: float, *, failed: bool = False) -> None:
        cost = self._costs.get(role) or AgentCost(agent=role, implementation=getattr(self._agents, role).name)
        self._costs[role] = cost.model_copy(
            update=dict(
                calls=cost.calls + 1,
                failed_calls=cost.failed_calls + failed,
                input_tokens=cost.input_tokens + trace.input_tokens,
                output_tokens=cost.output_tokens + trace.output_tokens,
                seconds=round(cost.seconds + seconds, 4),
                latency_seconds=round(cost.latency_seconds + trace.latency_seconds, 4),
            )
        )
