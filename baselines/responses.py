"""The responses of an object to each skill: knowledge of methods that read the truth before they search.

An object that floats or is held answers nearly in proportion to what acts, and at any time alike (a linear,
time-invariant system) as long as it deforms little. One simulation per skill and axis then says, by superposition
(`baselines.superposition`) and delay, what every combination of them in every window would do.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from baselines.evaluation import Evaluator
from baselines.superposition import Base
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    ConstraintType,
    ForceField,
    HalfSpaceRegion,
    Region,
    VelocityConstraint,
)
from physagent_jax.forces.skills import list_skills
from physagent_jax.metrics.targets import Stretch, Turn
from physagent_jax.metrics.task_judge import compute_residuals

_SUPERPOSED = [skill for skill in list_skills("actions") if skill.superposes]

SKILLS = tuple(ActionType(s.name) for s in sorted(_SUPERPOSED, key=lambda s: s.is_axis or s.is_two_sided))
"""Skills whose response in any window follows from one simulation; among equals the first is preferred."""

WRING = ConstraintType("enforce_particle_rotation")
"""Two ends turned against each other and held so: what no torque does to a body that springs back. Prescribed motions
do not add up, so that both ends are one response."""

END_SKILLS = tuple(skill for skill in SKILLS if not skill.skill.is_two_sided)
"""Skills of an end; those with two sides too where the target speaks of its length."""

SIDED_SKILLS = tuple(skill for skill in SKILLS if skill.skill.is_two_sided)
"""A stretch or squeeze along an axis."""

STRENGTH = MAGNITUDE_MIN
"""[|M|] of what is simulated: weak, to be in proportion; what is pulled hard tears, and says nothing of what holds."""

SHARE = 0.4
"""Share of the budget that responses may cost; regions that would cost more are left out."""

BLOW_LENGTH = 2
"""[frames] of a blow."""

CLOSEST = 3
"""[frames] by which two changes are apart, at least."""

PARTICLES = 120
"""Particles of the superposed paths, about."""

CLEARLY = 0.9
"""Share of the loss at rest; a fall that leaves more is none of what is asked for.

An object that falls comes to touch the ground, and answers to every skill in another way.
"""

SHORTER = 4
"""Part of the clip for which a skill acts whose response failed: less strength the library does not have."""


@dataclasses.dataclass(frozen=True)
class Slot:
    """A place and time at which an action may act.

    Attributes:
        first, last: Frames.
        region: None = the whole object.
        against: The other end, which turns the other way (`WRING`).
    """

    first: int
    last: int
    region: Region | None = None
    against: Region | None = None

    @property
    def place(self) -> tuple[Region | None, Region | None]:
        """The place, at any time."""
        return self.region, self.against


Skill = ActionType | ConstraintType
Structure = tuple[tuple[Skill, Slot], ...]


@dataclasses.dataclass(frozen=True)
class Responses:
    """An object's motion by itself, and the response to each skill.

    Attributes:
        base: Motion without actions.
        drop: Whether it is let fall.
        rest: Motion without the fall either, where actions may do better without it: nothing is there to fall onto.
        mass: [kg], shape (n,).
        stride: Step between the particles that are kept.
        steps: By skill and place, what one along each axis adds at |M| = 1 when it acts from frame 0 on, a blow at
            frame 0, and a turn that is held from the first change on, as by `Base.compare`, shape
            (3, T, 2 + n, 3).
    """

    base: Base
    drop: bool
    mass: np.ndarray
    stride: int
    steps: dict[tuple[Skill, tuple[Region | None, Region | None]], np.ndarray]
    rest: Base | None = None

    def superpose(self, skill: Skill, slot: Slot) -> np.ndarray:
        """The response to a skill in a slot, shape (3, T, 2 + n, 3)."""
        step = self.steps[skill, slot.place]
        begun = _delay(step, slot.first)
        if skill.skill.is_sudden or skill is WRING or slot.last >= step.shape[1] - 1:
            return begun
        return begun - _delay(step, slot.last)


def measure_responses(evaluator: Evaluator) -> Responses:
    """Simulate each skill along each axis, and the fall; the fall is what is added to where it misses clearly less.

    In a smooth task rest is kept beside it: a fall that does better than nothing says little about what a push does.

    What fails is simulated once more, for a shorter time. An axis along which a skill fails then too adds nothing, as
    its record says, and a skill that fails along all is left out in that place.
    """
    until = evaluator.spent + SHARE * evaluator.remaining
    frames, steps = evaluator.task.frame_count, {}
    fallen = evaluator.watch(ForceField(default_drop=True), "fall")
    still, stride = None, 1
    for slot, skills in list_places(evaluator):
        if slot.region is not None and evaluator.spent + 3 * len(skills) > until:
            break
        for skill in skills:
            made = [_respond(evaluator, skill, slot, axis) for axis in np.eye(3)]
            worked = [x for x, _ in made if x is not None]
            if not worked:
                continue
            if still is None:
                x = worked[0]
                stride = max(1, round(x.shape[1] / PARTICLES))
                mass = evaluator.task.mass[::stride]
                still = Base.of(np.repeat(x[:1, ::stride], frames, axis=0), mass)
            ways = [still.compare(still.x if x is None else x[:, ::stride], mass) for x, _ in made]
            added = [_prolong(way, short) for way, (_, short) in zip(ways, made)]
            steps[skill, slot.place] = np.stack(added) / STRENGTH
    if still is None:
        nothing = Base.of(np.zeros((frames, 1, 3)), np.ones(1))
        return Responses(nothing, False, np.ones(1), 1, {})
    losses = [np.inf]
    if fallen is not None:
        fallen = fallen[:, ::stride]
        losses = [find_loss(evaluator, x, mass) for x in (fallen, still.x)]
    drop = losses[0] < CLEARLY * losses[-1]
    base = Base.of(fallen, mass) if drop and fallen is not None else still
    return Responses(base, drop, mass, stride, steps, still if drop and evaluator.task.spec.smooth else None)


def _respond(evaluator: Evaluator, skill: Skill, slot: Slot, axis: np.ndarray) -> tuple[Any, int]:
    """Paths, and for how many frames the skill acted [0 = as it should]; None where it fails for a short time too."""
    timed = fit_slot(skill, slot, evaluator)
    for short in (0, *((round(evaluator.task.frame_count / SHORTER),) if _adds_up(skill) else ())):
        acting = dataclasses.replace(timed, last=timed.first + short) if short else timed
        field = make_field(((skill, acting),), STRENGTH * axis, False, evaluator.task.frame_count)
        note = f"response to {skill}" + (", once more for a shorter time" if short else "")
        x = evaluator.watch(field, note)
        if x is not None:
            return x, short
    return None, 0


def _adds_up(skill: Skill) -> bool:
    """Return whether acting for longer is acting for a short time again and again."""
    return skill.skill.group == "actions" and skill.skill.is_memoryless


def _prolong(added: np.ndarray, short: int) -> np.ndarray:
    """Extend a response of ``short`` frames to a skill that goes on acting (0 = all)."""
    later = range(short, len(added), short) if short else ()
    return added + sum((_delay(added[None], frames)[0] for frames in later), np.zeros_like(added))


def list_places(evaluator: Evaluator) -> list[tuple[Slot, Sequence[Skill]]]:
    """The places at which something may act for the whole clip, and the skills there.

    The whole; two ends that the target wants turned against each other; where the task's own first force field acts,
    and the ends that the target speaks of.
    """
    end, clauses = evaluator.task.frame_count - 1, evaluator.task.target.clauses
    places: dict[Slot, Sequence[Skill]] = {Slot(0, end): SKILLS}
    for clause in clauses:
        if isinstance(clause, Turn) and clause.part is not None and clause.against is not None:
            places[Slot(0, end, make_end(clause.part), make_end(clause.against))] = (WRING,)
    regions = [action.region for action in evaluator.task.start.actions if action.region is not None]
    for clause in clauses:
        ends = (clause.part, getattr(clause, "against", None))
        regions += [make_end(each) for each in ends if each is not None]
    stretched = [
        make_end(each.part) for each in clauses if isinstance(each, Stretch) and each.part is not None
    ]
    for region in regions:
        more = SIDED_SKILLS if region in stretched else ()
        places[Slot(0, end, region)] = (*END_SKILLS, *more)
    return list(places.items())


def make_end(direction: tuple[float, float, float]) -> Region:
    """The last third of the object's box along a direction."""
    x, y, z = (0.5 + each / 6.0 for each in direction)
    return HalfSpaceRegion(point=(x, y, z), normal=direction)


def list_changes(evaluator: Evaluator) -> list[int]:
    """Frames at which something can be expected to change: where clauses' windows begin and end, and the middle."""
    end = evaluator.task.frame_count - 1
    windows = [clause.window for clause in evaluator.task.target.clauses]
    wanted = [*sorted({frame for window in windows for frame in window}), end // 2]
    kept: list[int] = []
    for frame in wanted:
        if all(abs(frame - other) >= CLOSEST for other in (0, end, *kept)):
            kept.append(frame)
    return sorted(kept)


def fit_slot(skill: Skill, slot: Slot, evaluator: Evaluator) -> Slot:
    """The slot; a blow's is at its beginning, and ends are turned until the first change."""
    if skill.skill.is_sudden:
        return dataclasses.replace(slot, last=min(slot.first + BLOW_LENGTH, slot.last))
    if skill is WRING:
        return dataclasses.replace(slot, first=0, last=list_changes(evaluator)[0])
    return slot


def make_field(structure: Structure, u: np.ndarray, drop: bool, frame_count: int) -> ForceField:
    """The force field with these numbers, brought into the library's range."""
    actions, constraints, end = [], [], frame_count - 1
    for (skill, slot), vector in zip(structure, u.reshape(-1, 3)):
        size = float(np.linalg.norm(vector))
        way = vector / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
        size = min(max(size, MAGNITUDE_MIN), MAGNITUDE_MAX)
        if skill.skill.is_two_sided and way[np.argmax(np.abs(way))] < 0:
            way, size = -way, -size  # a squeeze
        x, y, z = way.tolist()
        window = None if (slot.first, slot.last) == (0, end) else (float(slot.first), float(slot.last))
        same: dict[str, Any] = dict(vector=(x, y, z), magnitude=size, active_time=window, region=slot.region)
        if isinstance(skill, ActionType):
            actions.append(Action(action_type=skill, **same))
            continue
        for region, side in ((slot.region, 1.0), (slot.against, -1.0)):
            same |= dict(vector=(side * x, side * y, side * z), region=region)
            constraints.append(VelocityConstraint(constraint_type=skill, held_until=float(end), **same))
    return ForceField(default_drop=drop, actions=tuple(actions), constraints=tuple(constraints))


def find_loss(evaluator: Evaluator, x: np.ndarray, mass: np.ndarray) -> float:
    """|r|^2 of paths of some of the particles; infinite where they are not finite."""
    r = np.asarray(compute_residuals(evaluator.task.target, x, mass, evaluator.task.frame_dt), np.float64)
    return float(r @ r) if np.isfinite(r).all() else np.inf


def _delay(step: np.ndarray, frames: int) -> np.ndarray:
    """The same, later, shape (3, T, n, 3)."""
    if frames == 0:
        return step
    return np.concatenate([np.zeros_like(step[:, :frames]), step[:, :-frames]], axis=1)
