"""From an object and a motion to a scene: the same data that a scene file holds."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from benchmarks.verdicts.motions import (
    FRICTION,
    TOWED,
    Burst,
    Grip,
    Motion,
    Part,
    Press,
    Push,
    Spin,
    Tow,
    Wring,
)
from benchmarks.verdicts.things import DOMAIN, FILLING, Thing
from physagent_jax.forces.schema import Action, ActionType, BoxRegion, ForceField, SkillScaling
from physagent_jax.scene.body import Body
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import (
    FOREVER,
    Anchor,
    Attractor,
    CameraConfig,
    ConstantEnvelope,
    DomainBox,
    HalfSpace,
    Material,
    MaterialModel,
    ParticleRotation,
    ParticleTranslation,
    Rendering,
    SceneConfig,
    SineEnvelope,
    Source,
    Surface,
    Timing,
    Transfer,
    Uniform,
    Wind,
)

FRAME_DT = 0.04  # [s]
SETTLING = 25  # frames before the first that is kept: on the ground matter first sags a little,
_CALMED = 12.0  # [1/s] slowed down by drag, so that it does not bounce
SIZE = (320, 240)  # width, height [px]
REACH = 1.3  # [L] from where it was that the camera follows what moves
HELD_FOOT = 0.15  # share of the height
_WEAKEST, _STRONGEST = 0.4, 1.6  # of an action's magnitude
_LEAST_SPIN = 1e-6  # [degrees/s^2], nothing that can be seen
_PUSHES, _SPINS = (
    4,
    2,
)  # terms in a scene, at least: those that do nothing spare compiling a program for each number
_RIGID, _TURNING = 1.5e4, 3e4  # [Pa]
_WHOLE = BoxRegion(low=(-9, -9, -9), high=(9, 9, 9))
_NOTHING = Uniform(acceleration=(0.0, 0.0, 0.0), envelope=ConstantEnvelope(start=0.0, end=0.1), region=_WHOLE)
GIVES_WAY = 0.5  # cells by which matter gets into a plate that presses it
GRIPPING = 1.0  # friction of plates: what is tall does not slip out
_SLAB = {
    "top": ((-9, -9, 2 / 3), (9, 9, 9)),
    "bottom": ((-9, -9, -9), (9, 9, 1 / 3)),
}


def count_lead(motion: Motion) -> int:
    """Frames that are simulated before the clip begins."""
    return SETTLING if motion.world == "ground" and not motion.lifted else 0


def make_scene(thing: Thing, source: Source, body: Body, motion: Motion) -> SceneConfig:
    """The scene that shows ``motion``; its first `count_lead` frames come before the clip."""
    axes = find_axes(thing)
    lead = count_lead(motion) * FRAME_DT
    ground = float(body.low[2]) - motion.lifted
    boundaries: tuple = (DomainBox(),)
    if motion.world == "ground":
        plane = HalfSpace(point=(0, 0, ground), normal=(0, 0, 1), surface=Surface.SEPARATE, friction=FRICTION)
        boundaries += (plane,)
    boundaries += tuple(
        p for c in motion.causes if isinstance(c, Press) for p in _plates(c, axes, lead, body)
    )
    spins = [cause for cause in motion.causes if isinstance(cause, Spin)]
    terms: list[Uniform | Attractor | Wind] = [
        _term(c, axes, lead, body) for c in motion.causes if isinstance(c, Push | Burst)
    ]
    terms += [_NOTHING] * (_PUSHES - len(terms))
    terms += [_tow(c, axes, lead) for c in motion.causes if isinstance(c, Tow)]
    if lead:
        terms.append(Wind(linear_drag=_CALMED, envelope=ConstantEnvelope(start=0.0, end=lead)))
    grips = [_grip(c, axes, lead, body) for c in motion.causes if isinstance(c, Grip)]
    wrings = [_wring(c, axes, lead, body) for c in motion.causes if isinstance(c, Wring)]
    field, scaling = _spin(spins, axes, lead)
    frames = round(motion.seconds / FRAME_DT) + count_lead(motion)
    return SceneConfig(
        prompt=motion.words,
        source=source,
        filling=FILLING,
        material=_material(thing, motion),
        domain=DOMAIN,
        timing=Timing(frame_count=frames, frame_dt=FRAME_DT),
        transfer=Transfer(damping_rate=motion.drag),
        always_gravity=motion.world == "ground",
        boundaries=boundaries,
        constraints=(*grips, *wrings),
        anchor=Anchor(kind="base", fraction=HELD_FOOT, reason="held") if motion.held else Anchor(),
        force_field=field,
        forces=tuple(terms),
        scaling=scaling,
        camera=CameraConfig(azimuth_degrees=thing.azimuth),
        rendering=Rendering(width=SIZE[0], height=SIZE[1]),
    )


def _material(thing: Thing, motion: Motion) -> Material:
    """Softer material for what moves as a rigid body: it is cheap, and nothing strains it."""
    causes, whole = motion.causes, all(getattr(cause, "part", "all") == "all" for cause in motion.causes)
    if motion.world == "ground" or motion.held or not whole:
        return thing.make_material()
    if all(isinstance(cause, Push) for cause in causes):
        return thing.make_material(_RIGID)
    if thing.frail and any(isinstance(cause, Spin) for cause in causes):
        return Material(model=MaterialModel.RIGID, density=thing.make_material().density)
    return thing.make_material(_TURNING)


def find_axes(thing: Thing) -> np.ndarray:
    """World vectors of the viewer's right, up and away, rows, shape (3, 3)."""
    words = find_viewer_directions(CameraConfig(azimuth_degrees=thing.azimuth))
    return np.array([words["right"], words["up"], words["away"]])


def _world(direction, axes: np.ndarray) -> tuple[float, float, float]:
    return tuple(float(c) for c in np.round(np.asarray(direction) @ axes, 9) + 0.0)  # type: ignore[return-value]


def _term(cause: Push | Burst, axes: np.ndarray, lead: float, body: Body) -> Uniform | Attractor:
    start, end = lead + cause.start, lead + cause.end
    if isinstance(cause, Burst):
        middle = tuple(float(c) for c in 0.5 * (body.low + body.high))
        envelope = ConstantEnvelope(start=start, end=end)
        return Attractor(point=middle, strength=-cause.strength, power=0.0, softening=0.1, envelope=envelope)  # type: ignore[arg-type]
    acceleration = _world(np.multiply(cause.direction, cause.strength), axes)
    envelope = (
        SineEnvelope(start=start, end=end, frequency=cause.frequency)
        if cause.frequency
        else ConstantEnvelope(start=start, end=end)
    )
    return Uniform(acceleration=acceleration, envelope=envelope, region=_region(cause.part, axes))


def _tow(cause: Tow, axes: np.ndarray, lead: float) -> Wind:
    envelope = ConstantEnvelope(start=lead + cause.start, end=lead + cause.end)
    way = _world(cause.direction, axes)
    return Wind(direction=way, speed=cause.speed, linear_drag=TOWED, envelope=envelope)


def _region(part: Part, axes: np.ndarray) -> BoxRegion:
    """A third of the object, or all of it."""
    if part == "all":
        return _WHOLE
    if part in _SLAB:
        low, high = _SLAB[part]
        return BoxRegion(low=low, high=high)
    right = axes[0]
    axis = int(np.argmax(np.abs(right)))
    low, high = np.full(3, -9.0), np.full(3, 9.0)
    if (right[axis] > 0) == (part == "right"):
        low[axis] = 2 / 3
    else:
        high[axis] = 1 / 3
    return BoxRegion(low=tuple(low.tolist()), high=tuple(high.tolist()))


def _plates(cause: Press, axes: np.ndarray, lead: float, body: Body) -> tuple[HalfSpace, HalfSpace]:
    """A plate while it moves, and where it then stays."""
    side = np.round(np.asarray(_world(cause.side, axes)), 6)
    axis = int(np.argmax(np.abs(side)))
    end = (body.high if side[axis] > 0 else body.low) - GIVES_WAY * DOMAIN.dx * side
    way = -cause.way * float(body.high[axis] - body.low[axis]) * side
    moved, stopped = lead + cause.duration, lead + cause.hold

    def plate(point: np.ndarray, velocity: np.ndarray, start: float, stop: float) -> HalfSpace:
        place, normal, speed = (tuple((v + 0.0).tolist()) for v in (point, -side, velocity))
        return HalfSpace(point=place, normal=normal, velocity=speed, friction=GRIPPING, start=start, end=stop)

    return (
        plate(end, way / cause.duration, lead, moved),
        plate(end + way, np.zeros(3), moved, stopped),
    )


def _grip(cause: Grip, axes: np.ndarray, lead: float, body: Body) -> ParticleTranslation:
    """A slab at one end, as a box around it."""
    side = np.round(np.asarray(_world(cause.side, axes)), 6)
    axis = int(np.argmax(np.abs(side)))
    low, high = np.asarray(body.low, float) - 0.5, np.asarray(body.high, float) + 0.5
    extent = float(body.high[axis] - body.low[axis])
    first, last = (cause.low * extent if cause.low else -0.5), cause.high * extent
    if side[axis] > 0:
        low[axis], high[axis] = float(body.high[axis]) - last, float(body.high[axis]) - first
    else:
        low[axis], high[axis] = float(body.low[axis]) + first, float(body.low[axis]) + last
    return ParticleTranslation(
        point=tuple((0.5 * (low + high)).tolist()),
        half_size=tuple((0.5 * (high - low)).tolist()),
        velocity=_world(np.multiply(cause.velocity, extent), axes),
        start=lead + cause.start,
        end=min(lead + cause.end, FOREVER),
    )


def _wring(cause: Wring, axes: np.ndarray, lead: float, body: Body) -> ParticleRotation:
    """A slab at one end, as a wide cylinder about the object's axis."""
    side = np.round(np.asarray(_world(cause.side, axes)), 6)
    axis = int(np.argmax(np.abs(side)))
    low, high = np.asarray(body.low, float), np.asarray(body.high, float)
    centre, half = 0.5 * (low + high), 0.5 * cause.depth * float(high[axis] - low[axis])
    centre[axis] = high[axis] - half if side[axis] > 0 else low[axis] + half
    return ParticleRotation(
        point=tuple(centre.tolist()),
        normal=tuple(side.tolist()),
        half_height=half + 0.01,  # [m]: the outermost particles too
        radius=DOMAIN.size,
        angular_velocity=math.radians(cause.velocity),
        start=lead + cause.start,
        end=min(lead + cause.end, FOREVER),
    )


def _spin(spins: list[Spin], axes: np.ndarray, lead: float) -> tuple[ForceField, SkillScaling]:
    """Torques; what a magnitude of 1 means is chosen so that all of them are in its range."""
    if not spins:
        spins = [Spin((0.0, 1.0, 0.0), _LEAST_SPIN, 0.0, 0.1)]
    if len(spins) < _SPINS:
        first = dataclasses.replace(spins[0], strength=spins[0].strength / 2)
        spins = [first, first]
    strengths = [abs(spin.strength) for spin in spins]
    unit = max(strengths) / _STRONGEST
    if min(strengths) / unit < _WEAKEST - 1e-9:
        raise ValueError(f"turns of one clip differ by more than a factor of 4: {strengths}")
    actions = tuple(
        Action(
            action_type=ActionType.TORQUE,
            vector=_world(spin.axis, axes),
            magnitude=spin.strength / unit,
            active_time=((lead + spin.start) / FRAME_DT, (lead + spin.end) / FRAME_DT),
            region=_region(spin.part, axes),
        )
        for spin in spins
    )
    scaling = SkillScaling(
        translation=1.0, scale=1.0, impulse=1.0, torque=math.radians(unit), velocity=1.0, reason="by hand"
    )
    return ForceField(actions=actions), scaling
