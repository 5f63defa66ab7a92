"""Which actions, when and where: read off how the object answers to each skill once.

An object that floats or is held answers nearly in proportion to what acts, and at any time alike (a linear,
time-invariant system) as long as it turns and deforms little. One simulation per skill and axis then says, by
superposition and delay, what every combination of them in every window would do, and combinations are ranked without
simulating them: each gets the numbers that are best for it by the superposed paths. What is promised is no more than a
good start: of large turns, of stretches along other lines and on the ground it is a guess, which a search that
simulates corrects.

Windows are those between which the target's clauses change, regions are the ends that it speaks of: an oracle may read
both.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from baselines.evaluation import Evaluator
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
from physagent_jax.metrics.targets import Integrity, Target, Turn
from physagent_jax.metrics.task_judge import compute_residuals

SKILLS = (ActionType.TRANSLATION, ActionType.IMPULSE, ActionType.SCALE, ActionType.TORQUE)
"""Of equals the first is preferred: superposed turns grow what they turn, and pass for a stretch."""

WRING = ConstraintType.PARTICLE_ROTATION
"""Two ends turned against each other and held so: what no torque does to a body that springs back. Prescribed motions
do not add up, so that both ends are one response."""

END_SKILLS = (ActionType.TRANSLATION, ActionType.IMPULSE, ActionType.TORQUE)
"""Of an end."""

STRENGTH = MAGNITUDE_MIN
"""[|M|] of what is simulated: weak, to be in proportion; what is pulled hard tears, and says nothing of what holds."""

SHARE = 0.4
"""Of the budget that responses may cost; regions that would cost more are left out."""

BLOW_LENGTH = 2
"""[frames] of a blow."""

CLOSEST = 3
"""[frames] by which two changes are apart, at least."""

PARTICLES = 120
"""Of which the superposed paths are made, about."""

FAINT = 0.05
"""Loss that an action more has to be worth, and below which no more of them are tried."""

WEAKER = 0.7
"""By which |M| is multiplied."""

_WEAKENINGS = 3
_STEPS = 6  # of each fit
_MOST = 3  # actions
_BATCH = 16  # structures that are fitted side by side


@dataclasses.dataclass(frozen=True)
class Slot:
    """Where and when an action may act.

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
        """Where, whenever."""
        return self.region, self.against


Skill = ActionType | ConstraintType
Structure = tuple[tuple[Skill, Slot], ...]


@dataclasses.dataclass(frozen=True)
class Responses:
    """What an object does by itself, and what each skill adds.

    Attributes:
        base: Paths without actions [m], shape (T, n, 3).
        drop: Whether it is let fall.
        mass: [kg], shape (n,).
        steps: By skill and place, what one along each axis adds at |M| = 1 when it acts from frame 0 on, a blow at
            frame 0, and a turn that is held from the first change on [m], shape (3, T, n, 3).
    """

    base: np.ndarray
    drop: bool
    mass: np.ndarray
    steps: dict[tuple[Skill, tuple[Region | None, Region | None]], np.ndarray]

    def superpose(self, skill: Skill, slot: Slot) -> np.ndarray:
        """What a skill in a slot adds, shape (3, T, n, 3)."""
        step = self.steps[skill, slot.place]
        begun = _delay(step, slot.first)
        if skill in (ActionType.IMPULSE, WRING) or slot.last >= step.shape[1] - 1:
            return begun
        return begun - _delay(step, slot.last)


def find_starts(evaluator: Evaluator, count: int) -> list[ForceField]:
    """The ``count`` best force fields by superposed responses, all their structures different.

    Half of them at most are of as many actions: what one action does by superposition may be out of proportion in
    truth, and take two. Those that miss by more than no action does are made weaker (`weaken`).

    Charged one simulation for each skill and axis, of the whole and of each end that the target or the task's own
    first force field speaks of, as far as `SHARE` of the budget goes, and those of what it returns.
    """
    responses = measure_responses(evaluator)
    structures = [
        each
        for each in dict.fromkeys(list_structures(evaluator))
        if all((skill, slot.place) in responses.steps for skill, slot in each)
    ]
    ranked: list[tuple[float, ForceField]] = []
    for size in range(1, _MOST + 1):
        enough = min((loss for loss, _ in ranked), default=np.inf) <= FAINT
        mine = [each for each in structures if len(each) == size]
        ranked += zip(*fit_structures(evaluator, responses, mine)) if mine else ()
        if enough:
            break
    idle = 0.5 * _find_loss(evaluator, responses.base, responses.mass)
    if responses.drop:
        fall = ForceField(default_drop=True)
        ranked.append((evaluator.score(fall, "start").loss, fall))
    ranked.sort(key=lambda pair: round(pair[0] + FAINT * _count(pair[1]), 2))
    return [weaken(evaluator, field, idle) for field in pick([field for _, field in ranked], count)]


def pick(ranked: Sequence[ForceField], count: int) -> list[ForceField]:
    """The first ``count``, half of them at most of as many actions where there are others, the likeliest first."""
    taken: list[ForceField] = []
    for field in ranked:
        alike = sum(_count(each) == _count(field) for each in taken)
        if len(taken) < count and alike < (count + 1) // 2:
            taken.append(field)
    taken += [field for field in ranked if field not in taken][: count - len(taken)]
    return sorted(taken, key=ranked.index)


def weaken(evaluator: Evaluator, field: ForceField, idle: float) -> ForceField:
    """The force field, `WEAKER` as often as it misses by more than ``idle``, the loss without any action.

    Superposition knows nothing of what tears: pulled hard, an object gives way and leaves no slope to come back by.
    """
    for _ in range(_WEAKENINGS):
        if not (field.actions or field.constraints) or evaluator.score(field, "start").loss <= idle:
            return field
        field = field.model_copy(
            update=dict(
                actions=tuple(map(_make_weaker, field.actions)),
                constraints=tuple(map(_make_weaker, field.constraints)),
            )
        )
    return field


def measure_responses(evaluator: Evaluator) -> Responses:
    """Simulates each skill along each axis, and the fall; the fall is what is added to where it misses less."""
    until = evaluator.spent + SHARE * evaluator.remaining
    frames, steps = evaluator.task.frame_count, {}
    fallen = evaluator.watch(ForceField(default_drop=True), "fall")
    still, stride = None, 1
    for slot, skills in list_places(evaluator):
        if slot.region is not None and evaluator.spent + 3 * len(skills) > until:
            break
        for skill in skills:
            made, timed = [], _fit(skill, slot, evaluator)
            for axis in np.eye(3):
                field = _make(((skill, timed),), STRENGTH * axis, False, frames)
                x = evaluator.watch(field, f"response to {skill}")
                if x is not None and still is None:
                    stride = max(1, round(x.shape[1] / PARTICLES))
                    still = np.repeat(x[:1, ::stride], frames, axis=0)
                made.append(None if x is None else x[:, ::stride])
            if still is not None:
                steps[skill, slot.place] = np.stack(
                    [np.zeros_like(still) if x is None else (x - still) / STRENGTH for x in made]
                )
    mass = evaluator.task.mass[::stride]
    if still is None:
        return Responses(np.zeros((frames, 1, 3)), False, np.ones(1), {})
    losses = [np.inf]
    if fallen is not None:
        fallen = fallen[:, ::stride]
        losses = [_find_loss(evaluator, x, mass) for x in (fallen, still)]
    drop = losses[0] < losses[-1]
    return Responses(fallen if drop and fallen is not None else still, drop, mass, steps)


def list_places(evaluator: Evaluator) -> list[tuple[Slot, Sequence[Skill]]]:
    """Where something may act for the whole clip, and what.

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
    places |= {Slot(0, end, region): END_SKILLS for region in regions}
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


def list_structures(evaluator: Evaluator) -> Iterator[Structure]:
    """Combinations of skills that may be what is asked for.

    The task's own windows and regions with all skills; one action between any two changes, of the whole or of an end;
    the same at two ends; two skills after each other; the same skill three times.
    """
    end, changes = evaluator.task.frame_count - 1, list_changes(evaluator)
    own = [
        Slot(*_round(action.active_time or (0, end)), action.region)
        for action in evaluator.task.start.actions
    ]
    for skills in itertools.product(SKILLS, repeat=len(own) if len(own) <= _MOST else 0):
        yield tuple((skill, _fit(skill, slot, evaluator)) for skill, slot in zip(skills, own))
    windows = list(itertools.combinations((0, *changes, end), 2))
    ends: list[Slot] = []
    for slot, skills in list_places(evaluator):
        for (first, last), skill in itertools.product(windows, skills):
            timed = dataclasses.replace(slot, first=first, last=last)
            yield ((skill, _fit(skill, timed, evaluator)),)
        ends += [slot] if slot.region is not None and slot.against is None else []
    for pair, skill in itertools.product(itertools.combinations(ends, 2), END_SKILLS):
        yield tuple((skill, _fit(skill, slot, evaluator)) for slot in pair)
    for change, skills in itertools.product(changes, itertools.product(SKILLS, repeat=2)):
        parts = (Slot(0, change), Slot(change, end))
        yield tuple((skill, _fit(skill, slot, evaluator)) for skill, slot in zip(skills, parts))
    for (one, two), skill in itertools.product(itertools.combinations(changes, 2), SKILLS):
        parts = (Slot(0, one), Slot(one, two), Slot(two, end))
        yield tuple((skill, _fit(skill, slot, evaluator)) for slot in parts)


def fit_structures(
    evaluator: Evaluator, responses: Responses, structures: list[Structure]
) -> tuple[list[float], list[ForceField]]:
    """For each structure, all of one size, the best numbers by superposed paths, and the loss there.

    A stretch takes the axis that it makes most of, for between axes its responses do not add. Whether neighbours part
    is not asked: superposition does not know.
    """
    clauses = tuple(each for each in evaluator.task.target.clauses if not isinstance(each, Integrity))
    target = Target(clauses=clauses or evaluator.task.target.clauses)
    frame_dt, mass = evaluator.task.frame_dt, jnp.asarray(responses.mass)
    parts = list(dict.fromkeys(part for structure in structures for part in structure))
    bank = jnp.asarray(np.stack([responses.superpose(*part) for part in parts]), jnp.float32)
    base = jnp.asarray(responses.base, jnp.float32)
    count = -len(structures) % _BATCH + len(structures)  # whole batches: one program
    filled = [structures[index % len(structures)] for index in range(count)]
    rows = jnp.asarray([[parts.index(part) for part in structure] for structure in filled])

    def residuals(u, row):
        x = base + jnp.einsum("ai,aitnc->tnc", u.reshape(-1, 3), bank[row])
        return compute_residuals(target, x, mass, frame_dt)

    @jax.jit
    def fit(free, start):
        fit_one = partial(_fit_numbers, residuals)
        return jax.lax.map(lambda each: fit_one(*each), (rows, free, start), batch_size=_BATCH)

    free = np.ones((count, 3 * len(structures[0])), np.float32)
    u, losses = (np.asarray(each) for each in fit(free, 0.05 * free))
    axial = np.array([[skill is ActionType.SCALE for skill, _ in structure] for structure in filled])
    sizes = np.abs(u).reshape(*axial.shape, 3)
    other = axial[..., None] & (sizes < sizes.max(-1, keepdims=True))
    free = np.where(other.reshape(u.shape), 0.0, free).astype(np.float32)
    u, losses = (np.asarray(each) for each in fit(free, free * u))
    fields = [_make(each, v, responses.drop, evaluator.task.frame_count) for each, v in zip(structures, u)]
    return [float(loss) if np.isfinite(loss) else np.inf for loss in losses[: len(structures)]], fields


def _fit_numbers(residuals, row, free, start):
    """Levenberg-Marquardt with a fixed number of steps, then into the library's range; what is not ``free`` stays."""

    def loss(u):
        return 0.5 * jnp.sum(residuals(u, row) ** 2)

    def step(_, state):
        u, damping, here = state
        r = residuals(u, row)
        J = jax.jacfwd(residuals)(u, row) * free
        normal = J.T @ J
        ridge = (damping * jnp.max(jnp.diag(normal)) + 1e-9) * jnp.eye(len(u), dtype=u.dtype)
        trial = u - jnp.linalg.solve(normal + ridge, J.T @ r)
        trial = jnp.clip(trial, -MAGNITUDE_MAX, MAGNITUDE_MAX)
        there = loss(trial)
        good = there < here
        return (
            jnp.where(good, trial, u),
            jnp.where(good, damping / 3, damping * 4),
            jnp.where(good, there, here),
        )

    u, _, _ = jax.lax.fori_loop(0, _STEPS, step, (start, jnp.float32(1e-2), loss(start)))
    sizes = jnp.sqrt(jnp.sum(u.reshape(-1, 3) ** 2, -1) + 1e-12)
    u = u * jnp.repeat(jnp.clip(sizes, MAGNITUDE_MIN, MAGNITUDE_MAX) / sizes, 3)
    return u, loss(u)


def _fit(skill: Skill, slot: Slot, evaluator: Evaluator) -> Slot:
    """The slot; a blow's is at its beginning, and ends are turned until the first change."""
    if skill is ActionType.IMPULSE:
        return dataclasses.replace(slot, last=min(slot.first + BLOW_LENGTH, slot.last))
    if skill is WRING:
        return dataclasses.replace(slot, first=0, last=list_changes(evaluator)[0])
    return slot


def _make(structure: Structure, u: np.ndarray, drop: bool, frame_count: int) -> ForceField:
    """The force field with these numbers, brought into the library's range."""
    actions, constraints, end = [], [], frame_count - 1
    for (skill, slot), vector in zip(structure, u.reshape(-1, 3)):
        size = float(np.linalg.norm(vector))
        way = vector / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
        size = min(max(size, MAGNITUDE_MIN), MAGNITUDE_MAX)
        if skill is ActionType.SCALE and way[np.argmax(np.abs(way))] < 0:
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


def _count(field: ForceField) -> int:
    return len(field.actions) + len(field.constraints)


def _make_weaker(item):
    size = max(MAGNITUDE_MIN, WEAKER * abs(item.magnitude))
    return item.model_copy(update=dict(magnitude=np.copysign(size, item.magnitude).item()))


def _round(window: tuple[float, float]) -> tuple[int, int]:
    return round(window[0]), round(window[1])


def _delay(step: np.ndarray, frames: int) -> np.ndarray:
    """The same, later, shape (3, T, n, 3)."""
    if frames == 0:
        return step
    return np.concatenate([np.zeros_like(step[:, :frames]), step[:, :-frames]], axis=1)


def _find_loss(evaluator: Evaluator, x: np.ndarray, mass: np.ndarray) -> float:
    r = np.asarray(compute_residuals(evaluator.task.target, x, mass, evaluator.task.frame_dt), np.float64)
    return float(r @ r) if np.isfinite(r).all() else np.inf
