"""One run of the stress matrix: a small block, a force, a place, a step rule."""

from __future__ import annotations

import dataclasses
from typing import Literal

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import lattice
from benchmarks.stability.materials import make_material
from physagent_jax.forces.terms import Stretch, Torque, UniformAcceleration
from physagent_jax.mpm import DomainBox, Grid, Lumped, Model, Sharpened, State, simulate, stable_dt
from physagent_jax.mpm.timestep import SAFETY

LUMPED = Lumped()

Force = Literal["drop", "translation", "scale", "impulse", "torque"]
Wall = Literal["far", "resting", "corner"]
StepRule = tuple[Literal["auto", "bound", "fixed"], float]

SIZE = 1.0  # side of the domain [m]
DENSITY = 1000.0  # [kg/m^3]
SIDE = 4  # of the block [cells]
CLIP = 0.4  # longest clip [s]
FRAMES = 8
ACTIVE = 0.6  # share of the clip in which forces act; after it energy must not rise
BLOW = 0.02  # share of the clip that an impulse takes
# What is too soft to bear these is thrown at 0.4 times its speed of sound, under a weight that strains it by 0.3.
THROW = 2.0  # speed per axis of what is thrown into a corner [m/s]
GRAVITY = 9.8  # [m/s^2]
WALL = 1  # cells
WINDOW = 24  # nodes along the grid window's side, above 32 cells


@dataclasses.dataclass(frozen=True)
class Scenario:
    """A point of the stress matrix.

    Attributes:
        material: A name of `materials.MATERIALS`.
        force: What acts. "drop" is gravity alone; the others act in free space unless ``wall`` asks for gravity.
        magnitude: 1 gives a speed of 1 m/s within the clip ("drop": 1 g).
        youngs_modulus: E [Pa]; the bulk modulus of a fluid.
        poissons_ratio: nu.
        step: ("auto", safety), ("bound", fraction of the bound) or ("fixed", dt [s]).
        forced: Whether a step above the bound is run nevertheless.
        cells: Along the domain's side of 1 m.
        per_cell: Particles per cell; 0 = random, 1 to 27.
        wall: "far" from any, "resting" on the floor under gravity, or thrown into a "corner" under gravity.
        dtype: "float32" or "float64" (which needs x64 enabled).
        stress_form, inertia: As `Model` has them.
        most_steps: The clip is cut to so many automatic steps.
    """

    material: str
    force: Force = "drop"
    magnitude: float = 1.0
    youngs_modulus: float = 1e6
    poissons_ratio: float = 0.3
    step: StepRule = ("auto", SAFETY)
    forced: bool = False
    cells: int = 32
    per_cell: int = 8
    wall: Wall = "far"
    dtype: str = "float32"
    stress_form: Literal["mls", "gradient"] = "mls"
    inertia: Lumped | Sharpened = LUMPED
    most_steps: int = 2000

    @property
    def name(self) -> str:
        """Short, unique within a matrix."""
        step = "auto" if self.step[0] == "auto" else f"{self.step[0]} {self.step[1]:g}"
        return (
            f"{self.material}, {self.force} x{self.magnitude:g}, "
            f"E {self.youngs_modulus:g}, nu {self.poissons_ratio:g}, "
            f"{step}{' forced' if self.forced else ''}, {self.cells} cells, ppc {self.per_cell or 'random'}, "
            f"{self.wall}, {self.dtype}, {self.stress_form}"
        )

    @property
    def refusable(self) -> bool:
        """Return whether the step rule asks for more than the bound allows, so that it has to be refused."""
        return self.step[0] == "bound" and self.step[1] > 1 and not self.forced


@dataclasses.dataclass(frozen=True)
class Run:
    """A scenario ready for `mpm.simulate`.

    Attributes:
        model, state: The scene.
        frame_dt: [s].
        options: Further arguments of `simulate`.
        walls_rest: Whether no wall moves, so that none does work.
    """

    model: Model
    state: State
    frame_dt: float
    options: dict
    walls_rest: bool = True

    def frames(self, count: int = FRAMES + 1, **options):
        """`simulate` with the ledger on."""
        options = {**self.options, "ledger": True, **options}
        return simulate(self.model, self.state, frame_count=count, frame_dt=self.frame_dt, **options)


def build(scenario: Scenario) -> Run:
    """Particles, model and step of ``scenario``.

    Force terms that do not act are there with strength zero: so all scenarios of a material share one executable.
    """
    dtype, dx = np.dtype(scenario.dtype).type, SIZE / scenario.cells
    x, volume = _place_particles(scenario, dx)
    material = make_material(
        scenario.material, len(x), scenario.youngs_modulus, scenario.poissons_ratio, dtype
    )
    sound = np.sqrt(scenario.youngs_modulus / DENSITY)
    v = np.full_like(x, -min(THROW, 0.4 * sound) if scenario.wall == "corner" else 0.0)
    state = State.at_rest(jnp.asarray(x, dtype), jnp.asarray(v, dtype), materials=(material,))
    falls = scenario.force == "drop" or scenario.wall != "far"
    gravity = min(GRAVITY, 0.3 * sound**2 / (SIDE * dx)) * (
        scenario.magnitude if scenario.force == "drop" else 1.0
    )
    model = Model(
        grid=_make_grid(scenario, x, dx),
        dt=jnp.asarray(0, dtype),
        gravity=jnp.asarray([0, 0, -gravity if falls else 0], dtype),
        mass=jnp.asarray(DENSITY * volume, dtype),
        volume=jnp.asarray(volume, dtype),
        materials=(material,),
        boundaries=(DomainBox(3),),
        wall=WALL,
        stress_form=scenario.stress_form,
        inertia=scenario.inertia,
    )
    bound = float(stable_dt(model, state))
    clip = min(CLIP, scenario.most_steps * 0.7 * bound)
    model = model.replace(forces=_make_forces(scenario, clip, 0.5 * SIDE * dx, dtype))
    options: dict = {}
    if scenario.step[0] == "auto":
        options["safety"] = scenario.step[1]
    else:
        options["substep_dt"] = scenario.step[1] * (bound if scenario.step[0] == "bound" else 1.0)
        options["force_substep"] = scenario.forced
    return Run(model, state, clip / FRAMES, options)


def _place_particles(scenario: Scenario, dx: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m], shape (n, 3), and volumes [m^3], shape (n,)."""
    side = SIDE * dx
    low = {
        "far": np.full(3, 0.5 * (SIZE - side)),
        "resting": np.array([0.5 * (SIZE - side), 0.5 * (SIZE - side), 3 * dx]),
        "corner": np.full(3, 3.5 * dx),
    }[scenario.wall]
    if scenario.per_cell:
        per_axis = round(scenario.per_cell ** (1 / 3))
        x = lattice((SIDE,) * 3, dx, low, per_axis)
        return x, np.full(len(x), (dx / per_axis) ** 3)
    rng = np.random.default_rng(0)
    counts = rng.integers(1, 28, SIDE**3)
    corners = np.stack(np.meshgrid(*[np.arange(SIDE)] * 3, indexing="ij"), -1).reshape(-1, 3)
    cell = np.repeat(corners, counts, axis=0)
    x = low + (cell + rng.uniform(size=cell.shape)) * dx
    return x, np.repeat(dx**3 / counts, counts)


def _make_grid(scenario: Scenario, x: np.ndarray, dx: float) -> Grid:
    """The whole domain where it is small, so that its shape never changes; else a window about the block."""
    if scenario.cells <= 32:
        return Grid.whole(SIZE, scenario.cells)
    origin = np.clip((x.mean(0) / dx).astype(int) - WINDOW // 2, 0, scenario.cells + 1 - WINDOW)
    return Grid(jnp.asarray(origin, jnp.int32), (WINDOW,) * 3, dx, scenario.cells)


def _make_forces(scenario: Scenario, clip: float, radius: float, dtype) -> tuple:
    def strength(*forces: str) -> float:
        return scenario.magnitude if scenario.force in forces else 0.0

    length = (BLOW if scenario.force == "impulse" else ACTIVE) * clip
    start, end = jnp.zeros((), dtype), jnp.asarray(length, dtype)
    heading = np.array([1.0, 0.5, 0.25]) / np.linalg.norm([1.0, 0.5, 0.25])
    axis = jnp.asarray(heading, dtype)
    push = jnp.asarray(heading * strength("translation", "impulse") / length, dtype)
    pull = jnp.asarray(strength("scale") / length, dtype)
    turn = jnp.asarray(strength("torque") / (length * radius), dtype)
    ramp = jnp.asarray(0.4 * length, dtype)
    return (
        UniformAcceleration(push, start, end),
        Stretch(axis, pull, start, end, ramp),
        Torque(axis, turn, start, end),
    )
