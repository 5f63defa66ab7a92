"""The context of an agent's call: the task, the skills, and every earlier attempt."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.description import SkillDescription
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import ExpectedMotion, Judgement, SceneBrief
from physagent_jax.perception.schema import MotionReport


class KeyFrame(NamedTuple):
    """A picture of a round's clip.

    Attributes:
        frame: Its place in the clip.
        png: The encoded picture.
    """

    frame: int
    png: bytes


class KeyFrames(Protocol):
    """Pictures of a round, encoded when they are asked for: who reads only the report never makes them."""

    def pick(self, most: int = 6) -> tuple[KeyFrame, ...]:
        """At most ``most`` evenly spaced frames, the first and the last among them."""
        ...


@dataclass(frozen=True)
class Observation:
    """A simulated round and what is seen of it, not judged yet.

    Attributes:
        force_field: What was simulated.
        report: What perception measured; ``report.text`` tells it in words.
        key_frames: The clip's pictures.
        ending: What perception measured from the last planned frame to the true end; None = it was not looked at.
    """

    force_field: ForceField
    report: MotionReport
    key_frames: KeyFrames
    ending: MotionReport | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Round(Observation):
    """A round with its judgement."""

    judgement: Judgement


@dataclass(frozen=True)
class AgentContext:
    """The context with which every agent is called.

    Attributes:
        prompt: The sentence.
        brief: The scene's facts.
        skills: What a force field may hold and what it means.
        reading: The semantic agent's answer; None while it is asked.
        rounds: Earlier rounds, oldest first; the one that the call is about is not among them.
    """

    prompt: str
    brief: SceneBrief
    skills: SkillDescription
    reading: SemanticReply | None = None
    rounds: tuple[Round, ...] = ()

    @property
    def expectations(self) -> tuple[ExpectedMotion, ...]:
        """Motions that the semantic agent expects to be seen; may be empty."""
        return self.reading.expectations if self.reading else ()
