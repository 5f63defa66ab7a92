"""Criteria that must hold in every frame, and the verdict on a run.

P1 finite; P2 inside; P3 det F in range; P4 no energy from nowhere; P5 momentum balances; P6 the grid has the
particles' mass. (P7 to P10 compare runs: `settling`, `matrix`, `equivalence`.)

Two bars depend on how hard a run is. Its *load* is the energy supplied per volume, over E: where it nears one, an
impact squeezes matter to a few per cent of its volume whatever the scheme, and det F and the share of particles
held at the wall are reported, not judged. And the energy of a leapfrog is only good to about a quarter of the
square of the cells that matter crosses in a step.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Iterable
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.stability.materials import FLUID
from benchmarks.stability.scenario import Run, Scenario, build
from physagent_jax.core.errors import UserError
from physagent_jax.mpm import Frame, Lumped
from physagent_jax.mpm.energy import elastic_energy
from physagent_jax.mpm.transfer import scatter_mass, stencil

ENERGY = 1e-3  # P4: least gain that counts, over the energy supplied
EXTREME = 0.1  # load above which det F and the wall share are only reported
SPREAD = 0.1  # change of the moment of inertia up to which the angular momentum that a torque gives is judged
LIMITS_J = (0.05, 20.0)  # P3, solids
FINITE_J = (
    1e6  # P3, anything; times the J at which Hencky's energy K/2 (ln J)^2, K = E/3, takes up the whole load
)
WALL_SHARE = 1e-3  # P2: particle-steps stopped at the wall
MOMENTUM = {"float32": (1e-5, 1e-4), "float64": (1e-12, 1e-11)}  # P5, over M v: in free space, touching walls
MASS = {"float32": 4e-6, "float64": 1e-12}  # P6; the first is the round-off of 256 equal summands
SPIN = {"float32": 1e-4, "float64": 1e-11}  # P5, angular, over M v R
SHARPENED_SPIN = 1e-3  # P5: sharpened increments keep some 2e-4 of it (`mpm.inertia`)

Verdict = Literal["pass", "refused", "FAIL"]


@dataclasses.dataclass
class Result:
    """Outcome of a run.

    Attributes:
        name: Name of the scenario.
        verdict: "refused" if it ended with a `UserError`.
        message: The error's, or the criteria that failed, with numbers.
        failed: Their names.
        figures: Numbers worth keeping.
    """

    name: str
    verdict: Verdict = "pass"
    message: str = ""
    failed: list[str] = dataclasses.field(default_factory=list)
    figures: dict = dataclasses.field(default_factory=dict)

    def fail(self, criterion: str, what: str) -> None:
        """Notes a broken criterion, once."""
        if criterion not in self.failed:
            self.failed.append(criterion)
            self.message = f"{self.message}; {criterion}: {what}".lstrip("; ")
            self.verdict = "FAIL"


def examine(scenario: Scenario, name: str = "", make: Callable[[], Run] | None = None) -> Result:
    """Build and run a scenario, and judge it; ``make`` builds it otherwise than `build` would."""
    begun = time.perf_counter()
    result = Result(f"{name}: {scenario.material}" if name else scenario.name)
    try:
        run = build(scenario) if make is None else make()
        watch(scenario, run, run.frames(), result)
        if scenario.refusable:
            result.fail("P8", "a step above the stable bound was accepted")
    except UserError as error:
        if not result.failed:
            result.verdict, result.message = "refused", str(error)
    except Exception as error:  # a crash is what must not happen: it is recorded, not passed on
        result.fail("crash", f"{type(error).__name__}: {error}")
    result.figures["seconds"] = round(time.perf_counter() - begun, 3)
    return result


def watch(scenario: Scenario, run: Run, frames: Iterable[Frame], result: Result) -> None:
    """Apply P1 to P6 to every frame; failures and figures go to ``result``.

    Raises:
        UserError: The simulator gave up, in words.
    """
    frames = iter(frames)
    first = next(frames)  # senseless input is refused here, before anything is made of it
    book = _Book(scenario, run)
    for frame in itertools.chain([first], frames):
        book.enter(frame)
        state = frame.state
        if not all(np.isfinite(np.asarray(leaf)).all() for leaf in (state.x, state.v, state.C, state.F)):
            result.fail("P1", f"a value of frame {frame.index} is not finite")
            break
        _check_inside(book, frame, result)
        _check_deformation(book, frame, result)
        _check_energy(book, frame, result)
        _check_momentum(book, frame, result)
        _check_mass(book, frame, result)
        result.figures.update(book.figures(frame))
    _check_impulse(book, result)


class _Book:
    """Sums over the frames of a run, in double precision."""

    def __init__(self, scenario: Scenario, run: Run):
        self.scenario, self.run = scenario, run
        self.mass = np.asarray(run.model.mass, np.float64)
        self.volume = float(np.asarray(run.model.volume, np.float64).sum())
        self.x0 = np.asarray(run.state.x, np.float64)
        self.v0 = np.asarray(run.state.v, np.float64)
        self.x, self.v, self.C = self.x0, self.v0, np.asarray(run.state.C, np.float64)
        self.spin0 = _compute_angular_momentum(self)
        self.radius = max(float(np.ptp(self.x0, axis=0).max()) / 2, run.model.grid.dx / 2)
        self.stored = (
            float(elastic_energy(run.model, run.state)) if bool((run.state.F != jnp.eye(3)).any()) else 0.0
        )
        J = np.linalg.det(np.asarray(run.state.F, np.float64))
        self.first_J = float(J.min()), float(J.max())
        self.steps, self.retries, self.loss, self.lowest = 0, 0, 0.0, 0.0
        self.min_J, self.max_J, self.courant, self.fastest = 1.0, 1.0, 0.0, 0.0
        self.work, self.drop, self.impulse = 0.0, 0.0, np.zeros(3)
        self.touched, self.applied_impulse, self.time = False, 0.0, 0.0
        self.inertia0 = self.inertia
        self.turn = 0.0  # angular momentum that the torque asks for, about its axis
        self.worst: dict[str, float] = {"momentum": 0.0, "spin": 0.0, "grid mass": 0.0}

    def enter(self, frame: Frame) -> None:
        """Add a frame."""
        state, exchange = frame.state, frame.exchange
        assert exchange is not None
        begun, inertia = self.time, self.inertia
        self.v, self.x = np.asarray(state.v, np.float64), np.asarray(state.x, np.float64)
        self.C = np.asarray(state.C, np.float64)
        self.time = float(state.time)
        if self.scenario.force == "torque":
            turn = self.run.model.forces[2]
            acting = max(0.0, min(self.time, float(turn.end)) - begun)
            self.turn += 0.5 * (inertia + self.inertia) * float(turn.magnitude) * acting
        self.steps += frame.substeps
        self.retries += len(frame.retries)
        low, high = frame.min_J, frame.max_J
        if _has_own_range(self.scenario.material):  # which holds after the return mapping, not before
            J = np.linalg.det(np.asarray(state.F, np.float64))
            low, high = float(J.min()), float(J.max())
        self.min_J, self.max_J = min(self.min_J, low), max(self.max_J, high)
        speed = float(np.sqrt((self.v**2).sum(-1).max()))
        self.fastest = max(self.fastest, speed)
        self.courant = max(self.courant, self.fastest * frame.dt / self.run.model.grid.dx)
        # Walls at rest do no work, and what an impact loses there is the scheme's loss.
        by_walls = float(exchange.boundary_work)
        self.loss += float(exchange.numerical_loss) - (by_walls if self.run.walls_rest else 0.0)
        self.work = max(self.work, self.work + (0.0 if self.run.walls_rest else by_walls))
        self.lowest = min(self.lowest, self.loss)
        self.work = max(self.work, self.work + float(exchange.force_work))
        gravity = np.asarray(self.run.model.gravity, np.float64)
        self.drop = max(self.drop, float((self.mass[:, None] * (self.x - self.x0) * gravity).sum()))
        wall = np.asarray(exchange.boundary_impulse, np.float64)
        near = 4.5 * self.run.model.grid.dx  # of a face: the walls' nodes are in reach
        inside = (
            near < self.x.min() and self.x.max() < self.run.model.grid.cells * self.run.model.grid.dx - near
        )
        self.touched = self.touched or not inside or bool(np.abs(wall).max() > 1e-6 * self.scale)
        asked = self.scenario.magnitude if self.scenario.force != "drop" else 0.0
        self.applied_impulse = float(self.mass.sum()) * (
            asked + float(np.linalg.norm(gravity)) * float(state.time)
        )
        self.impulse = self.impulse + wall + np.asarray(exchange.force_impulse, np.float64)

    @property
    def inertia(self) -> float:
        """Moment of inertia about the torque's axis through the mass centre, APIC's own part included [kg m^2]."""
        axis = np.asarray(self.run.model.forces[2].axis, np.float64) if self.run.model.forces else np.zeros(3)
        arm = self.x - np.average(self.x, axis=0, weights=self.mass)
        own = self.run.model.grid.dx**2 / 2
        return float((self.mass * ((arm**2).sum(-1) - (arm @ axis) ** 2 + own)).sum())

    @property
    def supplied(self) -> float:
        """Energy the run began with and was given [J]."""
        kinetic = 0.5 * float((self.mass * (self.v0**2).sum(-1)).sum())
        return kinetic + self.stored + self.work + self.drop

    @property
    def load(self) -> float:
        """Energy supplied per volume, over E."""
        return self.supplied / (self.volume * self.scenario.youngs_modulus)

    @property
    def scale(self) -> float:
        """Momentum at the largest speed so far and what was pushed [kg m/s]: the round-off of both counts."""
        return float(self.mass.sum()) * max(self.fastest, 1e-30) + self.applied_impulse

    def figures(self, frame: Frame) -> dict:
        """For the record."""
        return {
            "particles": len(self.mass),
            "substeps": self.steps,
            "dt": frame.dt,
            "retries": self.retries,
            "min_J": self.min_J,
            "max_J": self.max_J,
            "load": self.load,
            "stopped": int(frame.state.stopped) / max(1, self.steps * len(self.mass)),
            "loss": self.loss / max(self.supplied, 1e-30),
            "lowest_loss": self.lowest / max(self.supplied, 1e-30),
            **self.worst,
        }


def _check_inside(book: _Book, frame: Frame, result: Result) -> None:
    model = book.run.model
    low, high = model.wall * model.grid.dx, (model.grid.cells - model.wall) * model.grid.dx
    slack = 1e-6 * high
    if book.x.min() < low - slack or book.x.max() > high + slack:
        result.fail("P2", f"a particle is outside the domain in frame {frame.index}")
    share = int(frame.state.stopped) / max(1, book.steps * len(book.mass))
    if share > WALL_SHARE and book.load < EXTREME:
        result.fail("P2", f"{share:.2%} of particle-steps were stopped at the wall, load {book.load:.2g}")


def _check_deformation(book: _Book, frame: Frame, result: Result) -> None:
    if not 0 < frame.min_J <= frame.max_J < FINITE_J * math.exp(min(50.0, math.sqrt(6 * book.load))):
        result.fail("P3", f"det F in [{frame.min_J:.3g}, {frame.max_J:.3g}] in frame {frame.index}")
    low, high = _find_range_of_J(book.scenario.material)
    low, high = (
        min(low, 0.5 * book.first_J[0]),
        max(high, 2 * book.first_J[1]),
    )  # where it begins out of range
    if book.load < EXTREME and not (low < book.min_J and book.max_J < high):
        result.fail("P3", f"det F in [{book.min_J:.3g}, {book.max_J:.3g}], load {book.load:.2g}")


def _has_own_range(material: str) -> bool:
    """Return whether the return mapping keeps det F within the law's own range."""
    return material in (*FLUID, "snow", "sand", "wet-sand")


def _find_range_of_J(material: str) -> tuple[float, float]:
    """The elastic det F that is in order."""
    if material in FLUID:
        return 0.0, 2.0  # torn fluid expands, but not freely
    if material == "snow":
        return 0.9 * (1 - 0.025) ** 3, 1.1 * (1 + 0.0075) ** 3
    if material in ("sand", "wet-sand"):
        return LIMITS_J[0], 1.2
    return LIMITS_J


def _check_energy(book: _Book, frame: Frame, result: Result) -> None:
    noise = float(np.finfo(book.scenario.dtype).eps) * book.volume * book.scenario.youngs_modulus
    allowed = (ENERGY + 0.25 * min(book.courant, 1.0) ** 2) * book.supplied + noise
    if book.loss < -allowed:
        gain = -book.loss / max(book.supplied, 1e-30)
        result.fail("P4", f"energy gained {gain:.2e} of what was supplied by frame {frame.index}")


def _check_momentum(book: _Book, frame: Frame, result: Result) -> None:
    free, touching = MOMENTUM[book.scenario.dtype]
    change = (book.mass[:, None] * (book.v - book.v0)).sum(0)
    error = float(np.abs(change - book.impulse).max()) / book.scale
    book.worst["momentum"] = max(book.worst["momentum"], error)
    if error > (touching if book.touched else free):
        result.fail("P5", f"momentum is off by {error:.1e} M v in frame {frame.index}")
    if book.touched or book.scenario.force == "torque" or book.fastest == 0:
        return
    error = float(np.abs(_compute_angular_momentum(book) - book.spin0).max()) / (book.scale * book.radius)
    book.worst["spin"] = max(book.worst["spin"], error)
    lumped = isinstance(book.scenario.inertia, Lumped)
    if error > (SPIN[book.scenario.dtype] if lumped else SHARPENED_SPIN):
        result.fail(
            "P5", f"angular momentum about the mass centre is {error:.1e} M v R in frame {frame.index}"
        )


def _compute_angular_momentum(book: _Book) -> np.ndarray:
    """Angular momentum about the mass centre with APIC's own part [kg m^2/s], shape (3,)."""
    centre = (book.mass[:, None] * book.x).sum(0) / book.mass.sum()
    C = book.C
    axial = np.stack([C[:, 2, 1] - C[:, 1, 2], C[:, 0, 2] - C[:, 2, 0], C[:, 1, 0] - C[:, 0, 1]], -1)
    own = book.run.model.grid.dx**2 / 4 * axial
    mean = (book.mass[:, None] * book.v).sum(0) / book.mass.sum()
    return (book.mass[:, None] * (np.cross(book.x - centre, book.v - mean) + own)).sum(0)


def _check_mass(book: _Book, frame: Frame, result: Result) -> None:
    grid = book.run.model.grid
    if frame.grid_shape != grid.shape or max(grid.shape) <= grid.cells:
        return  # the window may have moved; where it covers the whole domain it cannot
    error = abs(float(_sum_grid_mass(grid, frame.state.x, book.run.model.mass)) / book.mass.sum() - 1)
    book.worst["grid mass"] = max(book.worst["grid mass"], error)
    if error > MASS[book.scenario.dtype]:
        result.fail("P6", f"the grid has {error:.1e} too much or too little mass in frame {frame.index}")


@jax.jit
def _sum_grid_mass(grid, x, mass):
    return scatter_mass(stencil(x, grid), grid, mass).sum()


def _check_impulse(book: _Book, result: Result) -> None:
    """P5: in free space a push, a blow and a turn give the momentum that was asked for."""
    scenario, forces = book.scenario, book.run.model.forces
    if book.touched or scenario.wall != "far" or scenario.force not in ("translation", "impulse", "torque"):
        return
    duration = min(float(forces[0].end), book.time)
    if scenario.force == "torque":
        if abs(book.inertia / book.inertia0 - 1) > SPREAD:
            return  # it flies apart, and its moment of inertia between frames is anyone's guess
        axis = np.asarray(forces[2].axis, np.float64)
        error = abs(float(_compute_angular_momentum(book) @ axis) / book.turn - 1)
        if error > 0.01:
            result.fail("P5", f"the torque gave {error:.1%} too much or too little")
        return
    asked = book.mass.sum() * np.asarray(forces[0].value, np.float64) * duration
    given = (book.mass[:, None] * (book.v - book.v0)).sum(0)
    error = float(np.linalg.norm(given - asked) / np.linalg.norm(asked))
    if error > 1e-4:
        result.fail("P5", f"the {scenario.force} gave {error:.1e} too much or too little momentum")
