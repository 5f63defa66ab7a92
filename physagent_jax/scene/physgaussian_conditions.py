"""PhysGaussian's boundary conditions, and checked access to its JSON."""

from __future__ import annotations

from typing import Any

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name, find_nearest
from physagent_jax.core.reading import shorten
from physagent_jax.core.strict import LARGEST, Vector
from physagent_jax.scene.config import (
    Cuboid,
    DomainBox,
    HalfSpace,
    ParticleImpulse,
    ParticleRelease,
    ParticleRotation,
    ParticleTranslation,
    Surface,
)

END = 1e3  # PhysGaussian's default end of a window [s]
_SURFACES = {"sticky": Surface.STICKY, "slip": Surface.SLIP}  # anything else separates
_MISSING = object()


class ConditionReader:
    """Typed access to a JSON object; errors name the key, warnings collect at the root.

    Args:
        data: The object.
        path: Its place in the file, for messages; empty at the root.
        warnings: Where warnings go; None = a new list.
    """

    def __init__(self, data: dict, path: str, warnings: list[str] | None = None):
        self.data, self.path = data, path
        self.warnings = [] if warnings is None else warnings

    def warn(self, message: str) -> None:
        """Add a warning."""
        self.warnings.append(message)

    def number(self, key: str, default: object = _MISSING) -> float:
        """A finite number."""
        return self._check(key, self._get(key, default))

    def word(self, key: str, default: str) -> str:
        """A name."""
        value = self._get(key, default)
        if not isinstance(value, str):
            raise self._make_error(key, "must be a name", value)
        return value

    def integer(self, key: str, default: object = _MISSING) -> int:
        """A whole number."""
        value = self.number(key, default)
        if value != int(value):
            raise self._make_error(key, "must be a whole number", value)
        return int(value)

    def numbers(self, key: str, length: int | None, default: object = _MISSING) -> tuple[float, ...]:
        """A list of finite numbers; of any length if ``length`` is None."""
        value = self._get(key, default)
        if not isinstance(value, list | tuple) or (length is not None and len(value) != length):
            raise self._make_error(key, f"must be a list of {length or 'any number of'} numbers", value)
        return tuple(self._check(key, item) for item in value)

    def vector(self, key: str, default: object = _MISSING) -> Vector:
        """A list of three finite numbers."""
        x, y, z = self.numbers(key, 3, default)
        return (x, y, z)

    def part(self, key: str) -> ConditionReader:
        """An object."""
        return self._make_reader(key, self.data[key])

    def parts(self, key: str) -> list[ConditionReader]:
        """A list of objects; empty if the key is missing or null."""
        value = self.data.get(key)
        if value is None:
            return []
        if not isinstance(value, list):
            raise self._make_error(key, "must be a list", value)
        return [self._make_reader(f"{key}[{i}]", item) for i, item in enumerate(value)]

    def name(self, key: str) -> str:
        """The full path of a key."""
        return f"{self.path}{key}"

    def _get(self, key: str, default: object) -> object:
        if key in self.data:
            return self.data[key]
        if default is _MISSING:
            raise UserError(f"PhysGaussian scene: `{self.name(key)}` is missing", do="Add it")
        return default

    def _check(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not -LARGEST <= value <= LARGEST:
            raise self._make_error(key, f"must be a finite number of at most {LARGEST:g}", value)
        return float(value)

    def _make_reader(self, key: str, value: object) -> ConditionReader:
        if not isinstance(value, dict):
            raise self._make_error(key, "must be an object", value)
        return ConditionReader(value, f"{self.name(key)}.", self.warnings)

    def _make_error(self, key: str, rule: str, value: object) -> UserError:
        got = shorten(repr(value) if isinstance(value, int | float | str) else type(value).__name__, 60)
        return UserError(f"PhysGaussian scene: `{self.name(key)}` {rule}", got=got, do="Mend the file")


def read_conditions(reader: ConditionReader, substep_dt: float) -> tuple[tuple, tuple]:
    """Boundaries and constraints, in the file's order.

    The domain's walls come last, whether there is a ``bounding_box`` or not: without them PhysGaussian writes
    outside its grid when particles leave.

    Args:
        reader: The scene.
        substep_dt: Duration of one step, which impulses are counted in [s].
    """
    boundaries, constraints = [], []
    for part in reader.parts("boundary_conditions"):
        kind = part.word("type", "")
        if _is_never(part):
            reader.warn(f"`{part.name('end_time')}` is not after `start_time`: the condition is left out")
        elif kind in _BOUNDARIES:
            boundaries += _BOUNDARIES[kind](part)
        elif kind == "particle_impulse":
            constraints.append(_read_impulse(part, substep_dt))
        elif kind in _CONSTRAINTS:
            constraints += _CONSTRAINTS[kind](part)
        elif find_nearest(kind, _KINDS):
            raise explain_unknown_name(f"PhysGaussian scene: `{part.name('type')}`", kind, _KINDS)
        else:
            reader.warn(f"`{part.name('type')}` = {kind!r} is left out: such a condition is not known")
    return (*boundaries, DomainBox(padding=3)), tuple(constraints)


def _is_never(part: ConditionReader) -> bool:
    return part.number("end_time", END) <= part.number("start_time", 0.0)


def _read_window(part: ConditionReader) -> dict[str, Any]:
    return dict(start=part.number("start_time", 0.0), end=part.number("end_time", END))


def _read_cuboid(part: ConditionReader) -> list:
    if part.number("reset", 0):
        part.warn(f"`{part.name('reset')}` is ignored: it zeroes the whole grid outside the window")
    return [
        Cuboid(
            point=part.vector("point"),
            half_size=part.vector("size"),
            velocity=part.vector("velocity"),
            **_read_window(part),
        )
    ]


def _read_surface_collider(part: ConditionReader) -> list:
    surface = part.word("surface", "sticky")
    if surface == "cut":
        part.warn(f"`{part.name('surface')}` = 'cut' is left out: it is tied to one scene of PhysGaussian")
        return []
    if surface != "sticky":
        part.warn(
            f"`{part.name('surface')}` = {surface!r} acts as declared here; in PhysGaussian it acts as sticky"
        )
    friction = part.number("friction", 0.0)
    if surface in _SURFACES and friction:
        part.warn(f"`{part.name('friction')}` is ignored: a {surface} surface has none here")
        friction = 0.0
    return [
        HalfSpace(
            point=part.vector("point"),
            normal=part.vector("normal"),
            surface=_SURFACES.get(surface, Surface.SEPARATE),
            friction=friction,
            **_read_window(part),
        )
    ]


def _read_impulse(part: ConditionReader, substep_dt: float) -> ParticleImpulse:
    return ParticleImpulse(
        point=part.vector("point", (1.0, 1.0, 1.0)),
        half_size=part.vector("size", (1.0, 1.0, 1.0)),
        force=part.vector("force"),
        start=part.number("start_time", 0.0),
        duration=part.integer("num_dt", 1) * substep_dt,
    )


def _read_translation(part: ConditionReader) -> list:
    return [
        ParticleTranslation(
            point=part.vector("point"),
            half_size=part.vector("size"),
            velocity=part.vector("velocity"),
            **_read_window(part),
        )
    ]


def _read_rotation(part: ConditionReader) -> list:
    """PhysGaussian turns from its first horizontal axis h towards h x normal: left-handed about the normal."""
    half_height, radius = part.numbers("half_height_and_radius", 2)
    return [
        ParticleRotation(
            point=part.vector("point"),
            normal=part.vector("normal"),
            half_height=half_height,
            radius=radius,
            angular_velocity=-part.number("rotation_scale"),
            axial_velocity=part.number("translation_scale"),
            **_read_window(part),
        )
    ]


def _read_release(part: ConditionReader) -> list:
    """Layers held still and let go one after another; ``num_layers`` is honoured (PhysGaussian overwrites it).

    The sign of PhysGaussian's ``normal`` means nothing: positions are coordinates along its axis.
    """
    normal = part.vector("normal")
    axes = [i for i in range(3) if normal[i] != 0]
    if len(axes) != 1:
        raise UserError(
            f"PhysGaussian scene: `{part.name('normal')}` must lie along one axis",
            got=list(normal),
            do="Mend the file",
        )
    layers = part.integer("num_layers")
    if layers < 1:
        raise UserError(f"PhysGaussian scene: `{part.name('num_layers')}` must be positive", got=layers)
    start, end = part.number("start_position"), part.number("end_position")
    if start == end:
        raise UserError(
            f"PhysGaussian scene: `{part.name('end_position')}` must differ from `start_position`",
            got=end,
            do="Mend the file",
        )
    x, y, z = (float(axis == axes[0]) for axis in range(3))
    return [
        ParticleRelease(
            normal=(x, y, z), start_position=start, end_position=end, layers=layers, **_read_window(part)
        )
    ]


_BOUNDARIES = {
    "bounding_box": lambda part: [],
    "cuboid": _read_cuboid,
    "surface_collider": _read_surface_collider,
}
_CONSTRAINTS = {
    "enforce_particle_translation": _read_translation,
    "enforce_particle_velocity_rotation": _read_rotation,
    "release_particles_sequentially": _read_release,
}
_KINDS = (*_BOUNDARIES, *_CONSTRAINTS, "particle_impulse")
