"""The response of a part, or of what is held, to a skill: the probe that sizes forces which no closed form tells.

A whole, free object goes where its mass lets it (`forces.scaling`). A part moves against the rest of the object, and
what is held against its fixture: how far depends on shape and stiffness. Linear elasticity on a coarse grid answers the
skill's own field in a fraction of a second. With u the answer to a unit of it, in the measure of the skill (way along
the vector, turn about it, strain along it), and A the rate at which a rigid object would follow,

    sudden push, turn: k = s / (A T^2 / 2 + D u),  D = 1 - cos(min(w T, pi)) but at most `OVERSHOOT`,  w^2 = 1 / u
    blow:              k = s / (A T + min(sqrt(u), T))
    stretch:           k = s / u

What stands does not follow as a rigid object until friction or its foot give way; k is the lesser of what bends it and
of what slides or tips it. No k strains more than a twentieth of the object beyond `MOST_STRAIN`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from physagent_jax.core.recent import Recent
from physagent_jax.forces import calibration
from physagent_jax.forces.holding import OVERSHOOT
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import Action, ForceField, Opposition, Response, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Material
from physagent_jax.scene.elasticity import GridElasticity

MOST_PARTICLES = 4000
PER_CELL = 6  # particles in a cell of the probe's grid
SHARE = 0.03  # of the residual that is left
ROUNDS = 400  # of conjugate gradients
TOUCHING = 1.5  # cells above the lowest nodes that the ground holds
MOST_STRAIN = 0.5  # [1] that a twentieth of the object exceeds: matter beyond it looks torn
LARGEST = 2000.0  # [m/s^2], [rad/s^2]: beyond it steps get shorter than those of sound
FAINT = 1 / 3  # of what M = 1 is to show: less is not seen, and said

Entry = Action | VelocityConstraint
_recent: Recent[tuple[float, float, float] | None] = Recent(64)  # rounds of a run keep most of what acts


@dataclasses.dataclass(frozen=True)
class Setting:
    """Everything that an object's response depends on.

    Attributes:
        body: The object at rest.
        material: Of which the Young's modulus, Poisson's ratio and density count.
        anchor: What is held; a mask's path is absolute.
        stands: Whether it rests on the ground.
        opposition: What friction and weight do to the whole; None = nothing.
        time: T of the skills [s].
    """

    body: Body
    material: Material
    anchor: Anchor
    stands: bool
    opposition: Opposition | None
    time: float


def find_responses(setting: Setting, force_field: ForceField) -> tuple[Response, ...]:
    """The k of every entry of ``force_field`` that acts on a part, or turns or stretches what is held.

    Matter without stiffness has none: the closed form stays.
    """
    if not setting.material.youngs_modulus:
        return ()
    held = setting.anchor.kind != "none"
    found: dict[str, Response] = {}
    for entry in (*force_field.actions, *force_field.constraints):
        skill = get_skill(entry)
        needed = entry.region is not None or (held and skill.quantity in ("torque", "scale"))
        if skill.prescribes or skill.quantity not in _TARGETS or not needed:
            continue
        response = _find_response(setting, entry, skill.quantity)
        if response is not None:
            found.setdefault(response.key, response)
    return tuple(found.values())


def _find_response(setting: Setting, entry: Entry, quantity: str) -> Response | None:
    measured = _recent.find(setting.body, _make_key(setting, entry, quantity), lambda: _measure(setting, entry, quantity))
    if measured is None:
        return None
    answer, rigid, strain = measured
    target, time = _TARGETS[quantity](setting, entry), setting.time
    per_k = _find_way(quantity, answer, rigid, time)
    k = target / max(per_k, 1e-12)
    if setting.stands and setting.opposition is not None and rigid == 0.0:
        k = min(k, _find_breakaway(setting, entry, quantity, target))
    note = ""
    load = math.sqrt(1 / max(answer, 1e-12)) if quantity == "impulse" else 1.0  # a blow strains as its swing's push
    sudden = OVERSHOOT if quantity in ("translation", "torque") else 1.0
    most = min(LARGEST, MOST_STRAIN / max(strain * load * sudden, 1e-12))
    if k > most:
        shown = most / k
        k = most
        if shown < FAINT:
            note = f"it shows about {100 * shown:.2g} % of what a magnitude of 1 is to show"
    return Response(quantity=quantity, region=entry.region, vector=entry.vector, k=k, note=note)


def _find_way(quantity: str, answer: float, rigid: float, time: float) -> float:
    """What k = 1 shows by ``time``, or at its largest before."""
    if quantity == "scale":
        return answer
    if quantity == "impulse":
        return rigid * time + min(math.sqrt(answer), time)
    phase = min(time / math.sqrt(max(answer, 1e-12)), math.pi)
    return 0.5 * rigid * time**2 + min(OVERSHOOT, 1 - math.cos(phase)) * answer


def _find_breakaway(setting: Setting, entry: Entry, quantity: str, target: float) -> float:
    """The k that slides, tips or turns the whole object where friction and weight hold it."""
    opposition, body = setting.opposition, setting.body
    assert opposition is not None
    mask, mass, arm = _select(setting, entry)
    vector, share = np.asarray(entry.vector, float), float(mass[mask].sum() / mass.sum())
    if quantity == "scale" or (quantity != "torque" and vector[2] < -0.5):
        return math.inf  # nothing goes through the ground
    flat = math.sqrt(max(1 - vector[2] ** 2, 0.0))
    if quantity == "torque":
        turned = float((mass[mask] * (np.cross(vector, arm[mask]) ** 2).sum(1)).sum())
        whole = arm - np.average(arm, axis=0, weights=mass)
        inertia = float((mass * (np.cross(vector, whole) ** 2).sum(1)).sum())
        resisting = opposition.turning * vector[2] ** 2 + opposition.tipping * flat**2
        return (resisting + 2 * target / setting.time**2) * inertia / max(turned, 1e-12)
    resisting = opposition.friction * flat + opposition.weight * max(vector[2], 0.0)
    if opposition.lever and flat > 0.5:  # pushed high up it tips before it slides
        height = np.average(body.particles.x[mask, 2], weights=mass[mask]) - body.low[2]
        spread = float(np.average((arm**2).sum(1) - 0.5 * (arm[:, :2] ** 2).sum(1), weights=mass))
        resisting = min(resisting, opposition.tipping * spread / max(float(height), 1e-6))
    if quantity == "impulse":
        return math.sqrt(2 * max(resisting, target / setting.time**2) * target) / share
    return (resisting + 2 * target / setting.time**2) / share


def _measure(setting: Setting, entry: Entry, quantity: str) -> tuple[float, float, float] | None:
    """The answer, the rate of the rigid motion, and the strain to a unit of a skill; None where it hangs on nothing."""
    particles, material = setting.body.particles, setting.material
    every = -(-particles.count // MOST_PARTICLES)
    mask, mass, arm = _select(setting, entry)
    held = select_anchored(
        setting.anchor, particles.x, particles.gaussian_index, ".", gaussian_count=setting.body.cloud.count
    )[::every]
    x, volume = particles.x[::every], particles.volume[::every].astype(np.float64) * every
    mask, mass, arm = mask[::every] & ~held, mass[::every] * every, arm[::every]
    if not mask.any():
        return None
    E, nu = float(material.youngs_modulus or 0.0), float(material.poissons_ratio or 0.0)
    mu, lam = (np.full(len(x), each) for each in (E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))))
    dx = float((PER_CELL * volume.mean()) ** (1 / 3))
    grid = GridElasticity(x, volume, mass, mu, lam, dx=dx, form="mls", share=SHARE)
    fixed = grid.spread @ (mass * held) > 0.5 * grid.mass
    if setting.stands and not held.any():
        fixed = grid.height <= grid.height[~grid.light].min() + TOUCHING * dx
    vector = np.asarray(entry.vector, float)
    field = np.where(mask[:, None], _FIELDS[quantity](vector, arm, mass * mask), 0.0)
    rigid = np.zeros_like(field)
    if fixed.any():
        moves = ~(fixed | grid.light) & grid.find_borne(fixed)
    else:
        rigid = _fit_rigid(field, x, mass)
        moves = ~grid.light
    if not moves.any():
        return None
    free = np.repeat(moves[:, None], 3, axis=1)
    load = grid.spread @ (mass[:, None] * (field - rigid))
    u, _ = grid.solve(np.where(free, load, 0.0), free, ROUNDS)
    moved = grid.weight @ u
    if not fixed.any():
        moved = moved - _fit_rigid(moved, x, mass)
    read = _READINGS[quantity]
    gradient = grid.find_gradient(u)
    strain = 0.5 * (gradient + gradient.transpose(0, 2, 1))
    weight = mass * mask
    return (
        max(read(vector, arm, weight, moved), 0.0),
        max(read(vector, arm, weight, rigid), 0.0) if rigid.any() else 0.0,
        float(np.percentile(np.linalg.norm(strain, axis=(1, 2)), 95)),
    )


def _select(setting: Setting, entry: Entry) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Particles that the entry acts on, all masses [kg], and positions from the chosen ones' centre [m]."""
    particles = setting.body.particles
    x, mass = np.asarray(particles.x, float), setting.material.density * particles.volume.astype(np.float64)
    mask = np.ones(len(x), bool) if entry.region is None else make_region_mask(entry.region, particles.x)
    return mask, mass, x - np.average(x[mask], axis=0, weights=mass[mask])


def _fit_rigid(field: np.ndarray, x: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """The rigid motion with the momenta of a field, shape (n, 3)."""
    r = x - np.average(x, axis=0, weights=mass)
    mean = np.average(field, axis=0, weights=mass)
    spin = (mass[:, None] * np.cross(r, field)).sum(0)
    inertia = (mass * (r**2).sum(1)).sum() * np.eye(3) - (mass[:, None] * r).T @ r
    turn = np.linalg.pinv(inertia, rcond=1e-6, hermitian=True) @ spin
    return mean + np.cross(turn, r)


# --- each quantity: its unit field on the chosen particles, and how its answer is read -------------------------------


def _push(vector, arm, weight) -> np.ndarray:
    return np.broadcast_to(vector, arm.shape)


def _turn(vector, arm, weight) -> np.ndarray:
    return np.cross(vector, arm)


def _pull(vector, arm, weight) -> np.ndarray:
    field, inside = np.sign(arm @ vector)[:, None] * vector, weight > 0
    field[inside] -= _fit_rigid(field[inside], arm[inside], weight[inside])
    return field


def _read_way(vector, arm, weight, moved) -> float:
    return float(np.average(moved @ vector, weights=weight))


def _read_turn(vector, arm, weight, moved) -> float:
    lever = np.cross(vector, arm)
    return float((weight * (lever * moved).sum(1)).sum() / max((weight * (lever**2).sum(1)).sum(), 1e-30))


def _read_strain(vector, arm, weight, moved) -> float:
    height, along = arm @ vector, moved @ vector
    along = along - np.average(along, weights=weight)
    return float((weight * height * along).sum() / max((weight * height**2).sum(), 1e-30))


_FIELDS: dict[str, Callable] = dict(translation=_push, impulse=_push, torque=_turn, scale=_pull)
_READINGS: dict[str, Callable] = dict(
    translation=_read_way, impulse=_read_way, torque=_read_turn, scale=_read_strain
)


def _find_shift(setting: Setting, entry: Entry) -> float:
    """Way of a part [m]: no more than its own size, which it cannot bend beyond."""
    mask, _, _ = _select(setting, entry)
    size = float(np.ptp(setting.body.particles.x[mask], axis=0).max())
    return min(calibration.PART_SHIFT * setting.body.extent, calibration.PART_BEND * size)


_TARGETS: dict[str, Callable[[Setting, Entry], float]] = dict(
    translation=_find_shift,
    impulse=_find_shift,
    torque=lambda setting, entry: math.radians(calibration.PART_TURN),
    scale=lambda setting, entry: calibration.PART_STRAIN,
)


def _make_key(setting: Setting, entry: Entry, quantity: str) -> str:
    region = "" if entry.region is None else entry.region.model_dump_json()
    parts = (setting.material.model_dump_json(), setting.anchor.model_dump_json(), setting.stands)
    return "|".join(map(str, (*parts, quantity, entry.vector, region)))
