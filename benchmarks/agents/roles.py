"""The agents that are asked in the benchmark, each with an answer of a model that is right for it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.trace import Reply
from physagent_jax.chat.base import ChatModel
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics import report_true_motion
from physagent_jax.motion.schema import DirectionTable, Judgement, SceneBrief, Verdict
from physagent_jax.perception.schema import MotionReport
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import CameraConfig

PROMPT = "a strong wind pushes the robot to the left"
FRAMES, FRAME_DT = 25, 0.04  # of the clip, [s]
PUSH = {
    "action_type": "translation",
    "vector": [-1.0, 0.0, 0.0],
    "magnitude": 1.0,
    "active_time": [0.0, 20.0],
}
HARDER = {**PUSH, "magnitude": 1.4}
CLAUSE = {"motion": "blow", "relation": "to", "word": "left", "strength": "strong"}
WORDS = "strong wind pushes the robot to the left"


@dataclasses.dataclass(frozen=True)
class Role:
    """An agent that asks a model.

    Attributes:
        name: Name of the agent.
        right: A right answer of the model.
        ask: The call of the agent.
    """

    name: str
    right: dict[str, Any]
    ask: Callable[[ChatModel], Reply[Any]]


def _read(model: ChatModel, name: str, form: str) -> Reply[Any]:
    return make_agents(semantic=(name, {"form": form}), model=model).semantic.compile(make_context())


def _judge(model: ChatModel, name: str) -> Reply[Any]:
    seen = Observation(ForceField.model_validate({"actions": [PUSH]}), make_report(), NoPictures())
    return make_agents(planner=name, model=model).planner.judge(make_context(read=True), seen)


def _rewrite(model: ChatModel) -> Reply[Any]:
    judgement = Judgement(verdict=Verdict.FAIL, suggestion="Push harder.")
    failed = Round(ForceField.model_validate({"actions": [PUSH]}), make_report(), NoPictures(), judgement)
    return make_agents(executor="chat", model=model).executor.rewrite(make_context(read=True), failed)


JUDGED = {"comparison": "It hardly moves.", "verdict": "FAIL", "suggestion": "Push harder."}
SENTENCE = {"clauses": [{**CLAUSE, "words": WORDS, "order": "then"}], "unclear": []}
ROLES = (
    Role("reader, clauses", SENTENCE, lambda model: _read(model, "model", "clauses")),
    Role("reader, by clause", CLAUSE, lambda model: _read(model, "model", "by-clause")),
    Role("reader, paper", {"actions": [PUSH]}, lambda model: _read(model, "model", "paper")),
    Role("reader beside the grammar", SENTENCE, lambda model: _read(model, "both", "clauses")),
    Role("planner", JUDGED, lambda model: _judge(model, "chat")),
    Role("planner beside the rules", JUDGED, lambda model: _judge(model, "both")),
    Role("executor", {"actions": [HARDER], "reason": "It hardly moves."}, _rewrite),
)


class NoPictures:
    """Key frames of a clip that nobody looks at."""

    def pick(self, most: int = 6) -> tuple:
        """None."""
        del most
        return ()


@functools.cache
def make_context(read: bool = False) -> AgentContext:
    """The sentence and its scene, with the grammar's reading if it is wanted."""
    brief = SceneBrief(
        object_name="robot",
        object_kind="robot",
        frame_count=FRAMES,
        frames_fixed=True,
        frame_dt=FRAME_DT,
        world="ground",
        directions=DirectionTable(**find_viewer_directions(CameraConfig())),
    )
    context = AgentContext(PROMPT, brief, describe_skills())
    if not read:
        return context
    return dataclasses.replace(context, reading=make_agents().semantic.compile(context).value)


@functools.cache
def make_report() -> MotionReport:
    """The report of a cube that travels a tenth of its size."""
    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3), -1).reshape(-1, 3)
    travelled = np.linspace(0, 0.1, FRAMES)[:, None, None] * np.array([-1.0, 0, 0])
    windows = make_agents().planner.windows(make_context(read=True))
    return report_true_motion(corners + travelled, frame_dt=FRAME_DT, windows=windows)
