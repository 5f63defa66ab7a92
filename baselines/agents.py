"""The product's own agents on a task: the sentence, what they are told of the scene, and rounds that are charged.

As the loop of a run has them (`physagent_jax.run.loop`): semantic agent, perception of pictures, planner, executor.
Here the task says what the scene is, so that what a sentence asks of the world or the clip's length is not followed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Protocol

from baselines.evaluation import Evaluator
from baselines.simulation import Pictures
from physagent_jax.agents.context import AgentContext, KeyFrame, Observation, Round
from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Verdict
from physagent_jax.output.video import encode_png
from physagent_jax.perception.measure import perceive
from physagent_jax.run.key_frames import spread_evenly

Change = Callable[[ForceField], ForceField]


def keep_as_it_is(force_field: ForceField) -> ForceField:
    """Return an agent's force field unchanged, for the simulation."""
    return force_field


@dataclasses.dataclass(frozen=True)
class PictureFrames:
    """Implements `agents.context.KeyFrames` for pictures in memory."""

    pictures: Pictures

    def pick(self, most: int = 6) -> tuple[KeyFrame, ...]:
        """At most ``most`` evenly spaced frames, the first and the last among them."""
        frames = self.pictures.rgb
        return tuple(KeyFrame(k, encode_png(frames[k])) for k in spread_evenly(len(frames), most))


class Sight(Protocol):
    """The viewer of a clip on behalf of the agents."""

    def look(
        self, evaluator: Evaluator, field: ForceField, note: str, windows: Sequence[tuple[int, int]]
    ) -> Observation | None:
        """Plays ``field``, charged, and says what is seen; None where it cannot be simulated."""
        ...


class PictureSight(Sight):
    """Perception of the pictures: all that the product has."""

    def look(
        self, evaluator: Evaluator, field: ForceField, note: str, windows: Sequence[tuple[int, int]]
    ) -> Observation | None:
        """As `Sight.look`."""
        pictures = evaluator.play(field, note)
        if pictures is None:
            return None
        seen = perceive(
            pictures.rgb, pictures.depth, pictures.camera, frame_dt=pictures.frame_dt, windows=windows
        )
        return Observation(field, seen.report, PictureFrames(pictures))


def read_sentence(evaluator: Evaluator, agents: Agents | None = None) -> SemanticReply:
    """Read the task's sentence with the semantic agent; nothing is simulated.

    Raises:
        UserError: Nothing in it can be understood.
    """
    agents = agents or make_agents()
    return _ask(evaluator, agents.semantic.compile, _make_context(evaluator)).value


def play_rounds(
    evaluator: Evaluator,
    reading: SemanticReply,
    *,
    rounds: int,
    agents: Agents | None = None,
    change: Change = keep_as_it_is,
    rate: bool = True,
    sight: Sight | None = None,
) -> ForceField:
    """Plays, perceives, judges and rewrites until the planner is satisfied or the executor has nothing left to try.

    Args:
        evaluator: Charged for every round.
        reading: The semantic agent's answer.
        rounds: At most.
        agents: Who judges and rewrites; the offline rules by default.
        change: Applied to every force field before it is played.
        rate: Whether the planner's score, negated, becomes the objective of each round.
        sight: Who looks; perception of the pictures by default.

    Returns:
        The best round's force field by the planner's score.

    Raises:
        BudgetSpent: Before a round that cannot be paid.
    """
    agents, sight = agents or make_agents(), sight or PictureSight()
    field, done = change(reading.force_field), []
    for index in range(rounds):
        context = _make_context(evaluator, reading, tuple(done))
        observation = sight.look(evaluator, field, f"round {index + 1}", agents.planner.windows(context))
        if observation is None:
            break  # what cannot be simulated is no success, and there is nothing to be learned from it
        judgement = _ask(evaluator, agents.planner.judge, context, observation).value
        if rate and judgement.score is not None:
            evaluator.rate(-judgement.score)
        done.append(Round(field, observation.report, observation.key_frames, judgement))
        if judgement.verdict is Verdict.SUCCESS or index + 1 == rounds:
            break
        rewritten = change(_ask(evaluator, agents.executor.rewrite, context, done[-1]).value.force_field)
        if rewritten == field:
            break
        field = rewritten
    if not done:
        return field
    scores = [-1.0 if each.judgement.score is None else each.judgement.score for each in done]
    return done[scores.index(max(scores))].force_field


def _ask(evaluator: Evaluator, ask: Callable[..., Reply], *arguments) -> Reply:
    """An agent's reply, its calls and tokens counted; rules exchange no messages and cost none."""
    reply = ask(*arguments)
    if not reply.trace.is_empty:
        evaluator.model_calls += 1 + len(reply.trace.validation_errors)
        evaluator.tokens += reply.trace.input_tokens + reply.trace.output_tokens
    return reply


def _make_context(
    evaluator: Evaluator, reading: SemanticReply | None = None, rounds: tuple[Round, ...] = ()
) -> AgentContext:
    return AgentContext(evaluator.task.spec.sentence, evaluator.brief, describe_skills(), reading, rounds)
