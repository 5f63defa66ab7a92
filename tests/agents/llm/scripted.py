"""A scripted chat model, and contexts in which agents ask it."""

import json

from physagent_jax.agents.context import AgentContext, KeyFrame, Observation, Round
from physagent_jax.chat.base import ChatMessage, Generation, ModelError, Usage
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Judgement
from physagent_jax.perception.schema import MotionReport
from tests.agents.scenes import brief, make_report


class ScriptedModel:
    """Answers in turn; a `ModelError` among the answers is raised. Keeps what it was asked."""

    def __init__(self, *answers, has_eyes=False, name="scripted:chat-1"):
        self.answers, self.has_eyes, self.name = list(answers), has_eyes, name
        self.asked: list[list[ChatMessage]] = []
        self.schemas: list = []
        self.closed = False

    def generate(self, messages, schema=None):
        self.asked.append(list(messages))
        self.schemas.append(schema)
        answer = self.answers.pop(0)
        if isinstance(answer, ModelError):
            raise answer
        text = answer if isinstance(answer, str) else json.dumps(answer)
        return Generation(text, None, Usage(100, 10), 0.25, "chat-1-2026")

    def close(self):
        self.closed = True

    @property
    def system(self) -> str:
        return self.asked[-1][0].text

    @property
    def user(self) -> str:
        return self.asked[-1][1].text


def make_context(prompt, *, reading=None, rounds=(), **changes) -> AgentContext:
    return AgentContext(prompt, brief(**changes), describe_skills(), reading, tuple(rounds))


class Pictures:
    """Two frames."""

    def pick(self, most=6):
        return (KeyFrame(0, b"\x89PNG first"), KeyFrame(48, b"\x89PNG last"))[:most]


def push(magnitude=1.0, way=(-1, 0, 0)) -> dict:
    return {"action_type": "translation", "vector": list(way), "magnitude": magnitude}


def field(*actions) -> ForceField:
    return ForceField.model_validate({"actions": actions or (push(),)})


def moving(x: float) -> MotionReport:
    """The report of an object that travels x body lengths to the right within the clip."""
    return make_report([(x * t / 48, 0.0, 0.0) for t in range(49)], windows=[(0, 48)])


def observe(x: float = -1.0, force_field: ForceField | None = None) -> Observation:
    return Observation(force_field or field(), moving(x), Pictures())


def failed(suggestion="Push harder.", force_field: ForceField | None = None, x: float = -0.1) -> Round:
    judgement = Judgement(verdict="FAIL", suggestion=suggestion)  # type: ignore[arg-type]
    return Round(force_field or field(), moving(x), Pictures(), judgement)
