"""Score distillation that chooses skills, as OmniPhysGS chooses material laws: which of them acts is found by gradient.

OmniPhysGS (Lin et al. 2025) chooses a law for each group of particles by a straight-through argmax: the forward pass
has the likeliest law alone, the backward pass the softmax mixture of all. It goes through the clip in stages, again and
again, with Adam steps on the frames of one stage, whose first state is taken as given. Here each action chooses among
the skills (a stretch and a squeeze apart), and its vector is moved as well.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from baselines.evaluation import Evaluator
from baselines.methods.sds_steps import make_adam
from baselines.parametrisation import Parametrisation
from baselines.scores.method import Glance, SdsMethod
from baselines.starts import KINDS, turn_into
from baselines.truncation import Truncation
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import Action, ForceField


@dataclasses.dataclass(frozen=True)
class SdsChoice(SdsMethod):
    """Options are those of `SdsMethod`, and these.

    Attributes:
        stages: Parts of the clip.
        inner: Steps on a stage before the next; the published 30 leave a small budget on the first stage.
        epochs: How often all stages are gone through; the budget may hold fewer.
        learning_rate: Learning rate of vectors, in |M| v.
        logit_rate: Logit rate of what chooses the skill.
        preference: Logit of the start's own skill at first; the others begin at 0.
    """

    stages: int = 2
    inner: int = 5
    epochs: int = 10
    learning_rate: float = 0.05
    logit_rate: float = 0.2
    preference: float = 0.5

    def __post_init__(self):
        super().__post_init__()
        if min(self.stages, self.inner, self.epochs) < 1:
            raise UserError("`stages`, `inner` and `epochs` must be at least 1")
        if not (0 < self.learning_rate <= 10 and 0 <= self.logit_rate <= 10):
            raise UserError("rates must be above 0 and at most 10", got=(self.learning_rate, self.logit_rate))

    @property
    def name(self) -> str:
        """As in the registry."""
        return "sds_choice"

    def search(self, evaluator: Evaluator) -> None:
        """Stage after stage."""
        start = self.choose_start(evaluator)
        if not start.actions:
            raise UserError(
                "only actions have skills to choose among", got=f"{len(start.constraints)} constraints"
            )
        if self.stages >= evaluator.task.frame_count:
            raise UserError("there must be fewer stages than frames", got=self.stages)
        glance, state = self.open(evaluator), Choice.of(start, self.preference)
        count = self.epochs * self.stages * self.inner
        frame_count = evaluator.task.frame_count
        move_vectors = make_adam(self.learning_rate, count, state.vectors.size)
        move_logits = make_adam(self.logit_rate, count, state.logits.size)
        safe = state
        for first, last in self.plan(frame_count):
            slopes = self._differentiate(glance, state, first, last, frame_count)
            if slopes is None:  # half of the last step, with the skills that could be simulated
                state = dataclasses.replace(safe, vectors=0.5 * (state.vectors + safe.vectors))
                state = state.projected(frame_count)
                continue
            safe, (by_vectors, by_logits) = state, slopes
            vectors = state.vectors + move_vectors(by_vectors.ravel()).reshape(state.vectors.shape)
            logits = state.logits + move_logits(by_logits.ravel()).reshape(state.logits.shape)
            state = dataclasses.replace(state, vectors=vectors, logits=logits).projected(frame_count)
        glance.play(state.decode(frame_count), "result")

    def plan(self, frame_count: int) -> Iterator[tuple[int, int]]:
        """The frame that is taken as given and the last one of each step's stage."""
        edges = np.linspace(0, frame_count - 1, self.stages + 1).round().astype(int).tolist()
        for _ in range(self.epochs):
            for first, last in zip(edges, edges[1:]):
                for _ in range(self.inner):
                    yield first, last

    def _differentiate(
        self, glance: Glance, state: Choice, first: int, last: int, frame_count: int
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Gradients by vectors and logits; None where the simulation fails."""
        field = state.decode(frame_count)
        pictures = glance.play(field, f"frames {first} to {last}")
        if pictures is None:
            return None
        pixels = glance.look(pictures, slice(first, last + 1))
        pixels[first] = 0  # it is taken as given
        others = state.list_others(frame_count)
        slope, by_others = glance.pull_back(field, pixels, Truncation(first=first), others)
        by_vectors = state.pull_vectors(field, slope, frame_count)
        by_weights = state.place_weights(by_others)
        if not (np.isfinite(by_vectors).all() and np.isfinite(by_weights).all()):
            raise UserError("the gradient of score distillation is not finite", got=field)
        return by_vectors, state.pull_weights(by_weights)


@dataclasses.dataclass(frozen=True)
class Choice:
    """A force field whose actions' skills are being chosen.

    Attributes:
        start: Windows, regions and all else.
        vectors: |M| v of each action, shape (actions, 3).
        logits: Logits of each action's skills, shape (actions, kinds); the greatest acts.
    """

    start: ForceField
    vectors: np.ndarray
    logits: np.ndarray

    @staticmethod
    def of(start: ForceField, preference: float) -> Choice:
        """With a preference for the start's own skills."""
        vectors, logits = np.zeros((len(start.actions), 3)), np.zeros((len(start.actions), len(KINDS)))
        for vector, row, action in zip(vectors, logits, start.actions):
            kind = find_kind(action)
            row[kind] = preference
            vector[:] = KINDS[kind][1] * action.magnitude * np.asarray(action.vector, float)
        return Choice(start, vectors, logits)

    @property
    def chosen(self) -> np.ndarray:
        """Index of each action's kind, shape (actions,)."""
        return self.logits.argmax(1)

    def projected(self, frame_count: int) -> Choice:
        """With vectors that the library allows."""
        template = ForceField(actions=self._make(self.chosen))
        flat = Parametrisation(template, frame_count).project(self.vectors.ravel())
        return dataclasses.replace(self, vectors=flat.reshape(self.vectors.shape))

    def decode(self, frame_count: int) -> ForceField:
        """The force field with the likeliest skills alone."""
        return self._decode(self.chosen, frame_count)

    def list_others(self, frame_count: int) -> tuple[ForceField, ...]:
        """That with another skill in one action's place, for every action and skill."""
        made = []
        for index, kind in zip(*np.nonzero(self._find_idle())):
            kinds = self.chosen.copy()
            kinds[index] = kind
            made.append(self._decode(kinds, frame_count))
        return tuple(made)

    def pull_vectors(self, field: ForceField, slope: ForceFieldParameters, frame_count: int) -> np.ndarray:
        """The gradient by the vectors, shape (actions, 3), from one by the numbers of what acts."""
        bare = field.model_copy(update=dict(constraints=()))
        own = dataclasses.replace(slope, constraints=())
        return Parametrisation(bare, frame_count).pull_back(bare, own).reshape(-1, 3)

    def place_weights(self, by_others: np.ndarray) -> np.ndarray:
        """The gradient by each skill's weight, shape (actions, kinds), from those of `list_others`.

        Up to the same number for all skills of an action, which a softmax does not feel: 0 for the one that acts.
        """
        by_weights = np.zeros_like(self.logits)
        by_weights[self._find_idle()] = by_others
        return by_weights

    def pull_weights(self, by_weights: np.ndarray) -> np.ndarray:
        """The gradient by the logits: that of a softmax, though the mixture is hard (straight-through)."""
        weights = np.exp(self.logits - self.logits.max(1, keepdims=True))
        weights /= weights.sum(1, keepdims=True)
        return weights * (by_weights - (weights * by_weights).sum(1, keepdims=True))

    def _find_idle(self) -> np.ndarray:
        """The inactive skills, shape (actions, kinds)."""
        return np.arange(len(KINDS)) != self.chosen[:, None]

    def _decode(self, kinds: np.ndarray, frame_count: int) -> ForceField:
        template = ForceField(actions=self._make(kinds))
        made = Parametrisation(template, frame_count).decode(self.vectors.ravel())
        return self.start.model_copy(update=dict(actions=made.actions))

    def _make(self, kinds: np.ndarray) -> tuple[Action, ...]:
        return tuple(self._make_one(index, kind) for index, kind in enumerate(kinds))

    def _make_one(self, index: int, kind: int) -> Action:
        vector = self.vectors[index]
        size = float(np.linalg.norm(vector))
        x, y, z = (float(each) / size for each in vector)
        update = dict(magnitude=size, vector=(x, y, z))
        return turn_into(self.start.actions[index].model_copy(update=update), KINDS[kind])


def find_kind(action: Action) -> int:
    """Index into `KINDS`."""
    for index, (skill, sign) in enumerate(KINDS):
        if skill is action.action_type and (sign > 0) == (action.magnitude > 0):
            return index
    return [skill for skill, _ in KINDS].index(action.action_type)  # a pull is a push the other way round
