"""The response of a part, or of what is held, to a skill: the probe that sizes forces which no closed form tells.

A whole, free object goes where its mass lets it (`forces.scaling`). A part moves against the rest of the object, and
what is held against its fixture: how far depends on shape and stiffness. Linear elasticity on a coarse grid answers the
skill's own field in a fraction of a second. With u the answer to a unit of it, in the measure of the skill (way along
the vector, turn about it, strain along it), and A the rate at which a rigid object would follow,

    sudden push, turn: k = s / (A T^2 / 2 + D u),  D = 1 - cos(min(w T, pi)) but at most `OVERSHOOT`,  w^2 = 1 / u
    blow:              k = s / (A T + min(sqrt(u), T))
    stretch:           k = s / u

What stands is pushed and turned by less than slides or tips it where that bends it visibly; where it is too stiff, the
whole is led as if it were pushed itself, with friction made up for. Weight makes what leans softer. No k strains more
than a twentieth of the object, or of the part, beyond `MOST_STRAIN`.
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
from physagent_jax.mpm import lame_parameters
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
MOST_STRETCH = 0.25  # [1] the same of a stretch, which grows faster than linearly and carries no bending
SAFE = 0.5  # of what slides or tips it, with which it stays where it is
SOFTENS = 2.0  # how much farther it leans than linear elasticity says, close to tipping over
SEEN = 0.5  # of what M = 1 is to show, which is as good
ROCKS = 0.85  # of the blow that topples it
LEAST_LEFT = 0.25  # of the stiffness that weight leaves to what leans
WEIGHED = 24  # sections in which the weight above is counted
LARGEST = 1e8  # [m/s^2], [rad/s^2]: what single precision can compute with
FAINT = 1 / 3  # of what M = 1 is to show: less is not seen, and said

Entry = Action | VelocityConstraint
_recent: Recent[Measured | None] = Recent(64)  # rounds of a run keep most of what acts


@dataclasses.dataclass(frozen=True)
class Setting:
    """Everything that an object's response depends on.

    Attributes:
        body: The object at rest.
        material: Its material; Young's modulus, Poisson's ratio and density count.
        anchor: What is held; a mask's path is absolute.
        stands: Whether it rests on the ground.
        gravity: Acceleration by the weight of what stands or is held at its foot [m/s^2]; 0 = none acts.
        opposition: What friction and weight do to the whole; None = nothing.
        time: T of the skills [s].
        firmness: Factors of stiffness of the particles (`scene.burden`), shape (n,); None = 1.
    """

    body: Body
    material: Material
    anchor: Anchor
    stands: bool
    gravity: float
    opposition: Opposition | None
    time: float
    firmness: np.ndarray | None = None


@dataclasses.dataclass(frozen=True)
class Measured:
    """The response to a unit of a skill.

    Attributes:
        answer: Way [s^2], turn [s^2] or strain [s^2/m] by elasticity.
        shift: Way of the mass centre along the vector [s^2].
        rigid: Acceleration with which it follows as a rigid object, over the skill's; 0 where it is held.
        resisting: Deceleration that has to be overcome before it follows [m/s^2] or [rad/s^2].
        strain: Strain that a twentieth of the object, or of the part, exceeds.
        frequency: Angular frequency of its swing, by Rayleigh's quotient [1/s].
    """

    answer: float
    shift: float
    rigid: float
    resisting: float
    strain: float
    frequency: float


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
    key = _make_key(setting, entry, quantity)
    measured = _recent.find(setting.body, key, lambda: _measure(setting, entry, quantity))
    if measured is None:
        return None
    target = _TARGETS[quantity](setting, entry)
    if setting.stands and measured.rigid and quantity != "impulse":
        k = min(
            _find_bending_k(measured, target, setting.time), SAFE * _find_stable_k(setting, entry, measured)
        )
        shown = k * measured.answer * _find_swing(max(measured.answer, 1e-12), setting.time)
        if shown < SEEN * target:  # too stiff to bend before it slides or tips: it is led as a whole is
            k = 2 * target / (measured.rigid * setting.time**2)
            return _make_response(entry, quantity, k, share=measured.rigid)
    else:
        k = _find_k(setting, measured, quantity, target)
    if setting.stands and quantity == "impulse":
        k = min(k, _find_toppling_blow(setting, entry))
    load = 1.0  # a blow strains as the steady push of its swing does
    if quantity == "impulse":
        load = 1 / math.sqrt(max(measured.answer, 1e-12))
    sudden = OVERSHOOT if quantity in ("translation", "torque") else 1.0
    torn = MOST_STRETCH if quantity == "scale" else MOST_STRAIN
    most, note = min(LARGEST, torn / max(measured.strain * load * sudden, 1e-12)), ""
    if k > most:
        if most < FAINT * k:
            note = f"it shows about {100 * most / k:.2g} % of what a magnitude of 1 is to show"
        k = most
    swings = {}
    if quantity == "translation" and not measured.rigid and measured.answer:
        far = calibration.EXPECTED_SWAY / calibration.EXPECTED_HELD_SHIFT * target
        most = MOST_STRAIN * measured.answer / max(measured.strain, 1e-12)  # [m], where it strains so
        swings = dict(answer=measured.answer, frequency=measured.frequency, swing=min(far, most))
    return _make_response(entry, quantity, k, note=note, **swings)


def _make_response(entry: Entry, quantity: str, k: float, **more) -> Response:
    return Response.model_validate(
        dict(quantity=quantity, region=entry.region, vector=entry.vector, k=k, **more)
    )


def _find_bending_k(measured: Measured, target: float, time: float) -> float:
    """The k of a sudden push or turn that bends it as far as the target."""
    answer = max(measured.answer, 1e-12)
    return target / (_find_swing(answer, time) * answer)


def _find_k(setting: Setting, measured: Measured, quantity: str, target: float) -> float:
    """The k with which bending and following as a rigid object add up to the target."""
    answer, rigid, time = max(measured.answer, 1e-12), measured.rigid, setting.time
    resisting = measured.resisting
    if quantity == "scale":
        return target / answer
    if quantity == "impulse":
        swing = min(math.sqrt(answer), time)
        if not rigid:
            return target / swing
        if not resisting:
            return target / (swing + rigid * time)
        return (math.sqrt(swing**2 + 2 * target * rigid**2 / resisting) - swing) * resisting / rigid**2
    return target / (_find_swing(answer, time) * answer + 0.5 * rigid * time**2)


def _find_swing(answer: float, time: float) -> float:
    """The way of a sudden push within ``time``, over where it would come to rest."""
    return min(OVERSHOOT, 1 - math.cos(min(time / math.sqrt(answer), math.pi)))


def _find_stable_k(setting: Setting, entry: Entry, measured: Measured) -> float:
    """The k at which what stands slides, turns or tips over."""
    opposition, vector = setting.opposition, np.asarray(entry.vector, float)
    slides = measured.resisting / measured.rigid
    flat = math.sqrt(max(1 - vector[2] ** 2, 0.0))
    turns = get_skill(entry).is_axis
    if opposition is None or not opposition.lever or flat < 0.5 or not opposition.tipping or turns:
        return slides
    mask, mass, arm = _select(setting, entry)
    x, whole = setting.body.particles.x, arm - np.average(arm, axis=0, weights=mass)
    spread = float(np.average((whole**2).sum(1) - 0.5 * (whole[:, :2] ** 2).sum(1), weights=mass))
    righting = opposition.tipping * spread  # g times how far inside its foot the mass centre is
    high = float(np.average(x[mask, 2], weights=mass[mask]) - x[:, 2].min())
    moment = high * measured.rigid * flat
    leaning = (
        SOFTENS * opposition.weight * _find_swing(max(measured.answer, 1e-12), setting.time) * measured.shift
    )
    return min(slides, righting / max(moment + leaning, 1e-12))


def _find_toppling_blow(setting: Setting, entry: Entry) -> float:
    """The blow that rocks what stands and does not topple it: its energy lifts the mass centre nearly over the edge."""
    opposition, vector = setting.opposition, np.asarray(entry.vector, float)
    flat = math.sqrt(max(1 - vector[2] ** 2, 0.0))
    if opposition is None or not opposition.lever or flat < 0.5 or not opposition.tipping:
        return math.inf
    mask, mass, arm = _select(setting, entry)
    x, whole = setting.body.particles.x, arm - np.average(arm, axis=0, weights=mass)
    spread = float(np.average((whole**2).sum(1) - 0.5 * (whole[:, :2] ** 2).sum(1), weights=mass))
    inside = (
        opposition.tipping * spread / opposition.weight
    )  # how far from the edge of its foot the mass centre is
    high = float(np.average(x[mask, 2], weights=mass[mask]) - x[:, 2].min())
    about_edge = spread + opposition.lever**2 + inside**2
    rise = math.hypot(opposition.lever, inside) - opposition.lever
    spin = math.sqrt(2 * opposition.weight * rise / about_edge)
    share = float(mass[mask].sum() / mass.sum())
    return ROCKS * spin * about_edge / max(share * high * flat, 1e-9)


def _measure(setting: Setting, entry: Entry, quantity: str) -> Measured | None:
    """The response to a unit of a skill; None where what it acts on hangs on nothing."""
    particles, material = setting.body.particles, setting.material
    every = -(-particles.count // MOST_PARTICLES)
    mask, mass, arm = _select(setting, entry)
    held = select_anchored(
        setting.anchor, particles.x, particles.gaussian_index, ".", gaussian_count=setting.body.cloud.count
    )[::every]
    x, volume = particles.x[::every].astype(np.float64), particles.volume[::every].astype(np.float64) * every
    mask, mass, arm = mask[::every] & ~held, mass[::every] * every, arm[::every]
    if not mask.any():
        return None
    firmness = np.ones(len(x)) if setting.firmness is None else setting.firmness[::every]
    mu, lam = lame_parameters(material.youngs_modulus * firmness, material.poissons_ratio)
    dx = float((PER_CELL * volume.mean()) ** (1 / 3))
    grid = GridElasticity(x, volume, mass, mu, lam, dx=dx, form="mls", share=SHARE)
    fixed = grid.spread @ (mass * held) > 0.5 * grid.mass
    if setting.stands and not held.any():
        fixed = grid.height <= grid.height[~grid.light].min() + TOUCHING * dx
    vector, weight = np.asarray(entry.vector, float), mass * mask
    field = np.where(mask[:, None], _FIELDS[quantity](vector, arm, weight), 0.0)
    balance = np.zeros_like(field) if fixed.any() else _fit_rigid(field, x, mass)
    moves = ~(fixed | grid.light)
    if fixed.any():
        moves &= grid.find_borne(fixed)
    if not moves.any():
        return None
    free = np.repeat(moves[:, None], 3, axis=1)
    load = np.where(free, grid.spread @ (mass[:, None] * (field - balance)), 0.0)
    u, _ = grid.solve(load, free, ROUNDS)
    moved, gradient = grid.weight @ u, grid.find_gradient(u)
    if not fixed.any():
        moved = moved - _fit_rigid(moved, x, mass)
    strain = np.linalg.norm(0.5 * (gradient + gradient.transpose(0, 2, 1)), axis=(1, 2))
    read = _READINGS[quantity]
    softer = 1.0
    if fixed.any() and setting.gravity:
        softer = 1 / max(
            1 - setting.gravity * _find_weight_share(x, volume, mass, gradient, float((load * u).sum())),
            LEAST_LEFT,
        )
    rigid, resisting = _find_following(
        setting, entry, quantity, mask, mass, arm, read(vector, arm, weight, balance)
    )
    return Measured(
        answer=softer * max(read(vector, arm, weight, moved), 0.0),
        shift=softer * abs(float(np.average(moved @ vector, weights=mass))),
        rigid=0.0 if held.any() else rigid,
        resisting=resisting,
        strain=softer * max(float(np.percentile(strain, 95)), float(np.percentile(strain[mask], 95))),
        frequency=math.sqrt(
            float((load * u).sum()) / softer / max(float((mass[:, None] * moved**2).sum()), 1e-30)
        ),
    )


def _find_weight_share(x, volume, mass, gradient, work: float) -> float:
    """Share of what bends it that its weight gives back as it leans, over g [s^2/m], by Rayleigh's quotient."""
    height = x[:, 2]
    order = np.argsort(height)
    bins = np.array_split(order, WEIGHED)
    above = np.cumsum([mass[b].sum() for b in bins][::-1])[::-1]
    pressure = np.zeros(len(x))
    for each, load in zip(bins, above):
        thick = max(float(np.ptp(height[each])), 1e-9)
        pressure[each] = load * thick / max(float(volume[each].sum()), 1e-30)
    slope = (gradient[:, :2, 2] ** 2).sum(1)
    return float((volume * pressure * slope).sum() / max(work, 1e-30))


def _find_following(setting, entry, quantity, mask, mass, arm, free: float) -> tuple[float, float]:
    """The rate at which it follows as a rigid object, and what resists that: friction, weight, its foot."""
    if not setting.stands:
        return max(free, 0.0), 0.0
    opposition, vector = setting.opposition, np.asarray(entry.vector, float)
    if quantity == "scale" or (quantity != "torque" and vector[2] < -0.5) or opposition is None:
        return 0.0, 0.0  # nothing goes through the ground
    flat = math.sqrt(max(1 - vector[2] ** 2, 0.0))
    if quantity == "torque":
        turned = float((mass[mask] * (np.cross(vector, arm[mask]) ** 2).sum(1)).sum())
        whole = arm - np.average(arm, axis=0, weights=mass)
        inertia = float((mass * (np.cross(vector, whole) ** 2).sum(1)).sum())
        resisting = opposition.turning * vector[2] ** 2 + opposition.tipping * flat**2
        return turned / max(inertia, 1e-12), resisting
    resisting = opposition.friction * flat + opposition.weight * max(vector[2], 0.0)
    return float(mass[mask].sum() / mass.sum()), resisting


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
    firmness = None if setting.firmness is None else setting.firmness.tobytes()
    parts = (
        setting.material.model_dump_json(),
        setting.anchor.model_dump_json(),
        setting.stands,
        hash(firmness),
        setting.gravity,
    )
    return "|".join(map(str, (*parts, quantity, entry.vector, region)))
