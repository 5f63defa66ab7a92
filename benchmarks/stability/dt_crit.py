"""The measured critical step of every material, over the closed-form bound.

From a random strain of one in a million, a scene is run with longer and longer steps; the critical one is where
the velocity gradient grows a thousandfold. Instabilities of an explicit scheme grow by a factor per step, so that
a few hundred steps tell; particles that cross cells are watched for longer.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import lattice
from benchmarks.stability.materials import SNOW_CAP, make_material
from benchmarks.stability.scenario import LUMPED
from physagent_jax.mpm import Grid, Lumped, Model, Sharpened, State, stable_dt, step

CONFIGURATIONS = ("isolated", "spray", "plate", "block")
FORMS = ("mls", "gradient")
# name: (material, nu, viscosity over that at which viscosity alone would give the elastic bound)
SUBJECTS = {
    "neo-hookean, nu 0": ("neo-hookean", 0.0, 0.0),
    "neo-hookean": ("neo-hookean", 0.3, 0.0),
    "neo-hookean, nu 0.45": ("neo-hookean", 0.45, 0.0),
    "fixed-corotated": ("fixed-corotated", 0.3, 0.0),
    "hencky": ("hencky", 0.3, 0.0),
    "von-mises": ("von-mises", 0.3, 0.0),
    "plasticine": ("plasticine", 0.3, 0.0),
    "sand": ("sand", 0.3, 0.0),
    "wet-sand": ("wet-sand", 0.3, 0.0),
    "foam": ("foam", 0.3, 0.0),
    "compacted snow": ("snow", 0.3, 0.0),
    "fluid": ("fluid", 0.3, 0.0),
    "cohesive-fluid": ("cohesive-fluid", 0.3, 0.0),
    "damped neo-hookean": ("neo-hookean", 0.3, 0.3),
    "viscous cohesive-fluid": ("cohesive-fluid", 0.3, 3.0),
}
REQUIRED = 0.95
LOWEST, HIGHEST, RESOLUTION = 0.5, 2.0, 0.02  # of the bound

_CELLS, _DX, _E, _RHO = 32, 1.0 / 32, 1e6, 1000.0
_COUNT = 512  # particles in every configuration: one executable per material and form
_STRAIN, _GROWTH = 1e-6, 1e3
_CHUNK = 20  # steps between looks; the spray drifts two cells in them
_STEPS = {"isolated": 600, "spray": 2000, "plate": 600, "block": 600}
_DRIFT = np.array([0.11, 0.07, 0.05])  # of the spray [cells per step]


@dataclasses.dataclass(frozen=True)
class Critical:
    """A measured critical step.

    Attributes:
        subject, configuration, form: What was measured.
        bound: The closed form [s].
        ratio: Largest stable step found, over the bound.
        unlimited: Whether nothing grew up to `HIGHEST`.
    """

    subject: str
    configuration: str
    form: str
    bound: float
    ratio: float
    unlimited: bool

    @property
    def good(self) -> bool:
        """Return whether the bound is safe."""
        return self.ratio >= REQUIRED


def measure(subject: str, configuration: str, form: str, inertia: Lumped | Sharpened = LUMPED) -> Critical:
    """Bisect the critical step; needs x64."""
    model, state = scene(subject, configuration, form)
    model = model.replace(inertia=inertia)
    bound = float(stable_dt(model, state))

    def grows(ratio: float) -> bool:
        return _is_growing(model.replace(dt=jnp.asarray(ratio * bound)), state, configuration)

    low, high = LOWEST, HIGHEST
    if not grows(high):
        return Critical(subject, configuration, form, bound, high, True)
    if not grows(1.0):
        low = 1.0
    while high - low > RESOLUTION * low:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return Critical(subject, configuration, form, bound, low, False)


def measure_all(subjects=tuple(SUBJECTS)) -> Iterator[Critical]:
    """All subjects in all configurations and forms; needs x64."""
    for subject in subjects:
        for form in FORMS:
            for configuration in CONFIGURATIONS:
                yield measure(subject, configuration, form)


def scene(subject: str, configuration: str, form: str) -> tuple[Model, State]:
    """Particles at rest but for a small random strain, in the middle of empty space."""
    name, nu, damping = SUBJECTS[subject]
    x, volume = _place_particles(configuration)
    material = make_material(name, len(x), _E, nu, np.float64)
    state = State.at_rest(jnp.asarray(x), materials=(material,))
    if name == "snow":  # compacted until it hardens no more
        factor = 1 - np.log(SNOW_CAP) / 10.0
        state = dataclasses.replace(state, history=(jnp.full(len(x), factor),))
    strain = _STRAIN * np.random.default_rng(1).uniform(-1, 1, (len(x), 3, 3))
    state = dataclasses.replace(state, F=state.F + jnp.asarray(strain))
    model = Model(
        grid=Grid.whole(1.0, _CELLS),
        dt=jnp.asarray(0.0),
        gravity=None,
        mass=jnp.asarray(_RHO * volume),
        volume=jnp.asarray(volume),
        materials=(material,),
        stress_form=form,  # type: ignore[arg-type]
    )
    if damping:
        elastic = float(stable_dt(model, state))
        eta = damping * _RHO * _DX**2 / (4 * elastic)
        model = model.replace(viscosity=jnp.full(len(x), eta))
    return model, state


def _place_particles(configuration: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and volumes [m^3] of `_COUNT` particles."""
    full = (0.5 * _DX) ** 3
    if configuration == "block":
        return lattice((4, 4, 4), _DX, np.full(3, 14 * _DX)), np.full(_COUNT, full)
    if configuration == "plate":
        return lattice((8, 8, 1), _DX, np.array([12.0, 12.0, 15.3]) * _DX), np.full(_COUNT, full)
    # Two particles more than three cells apart share no node: they are alone, at random places of their cells.
    pitch, jitter = 3.4, 0.19
    sites = np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), -1).reshape(-1, 3)
    rng = np.random.default_rng(2)
    x = 2.6 + pitch * sites + rng.uniform(-jitter, jitter, sites.shape)
    return x * _DX, np.full(_COUNT, full)


def _is_growing(model: Model, state: State, configuration: str) -> bool:
    drift = _DRIFT * _DX / float(model.dt) if configuration == "spray" else np.zeros(3)
    state = dataclasses.replace(state, v=jnp.broadcast_to(jnp.asarray(drift), state.v.shape))
    limit = _GROWTH * _STRAIN
    home = np.asarray(state.x).mean(0)
    for _ in range(_STEPS[configuration] // _CHUNK):
        state = _advance(model, state)
        rate = float(jnp.abs(state.C).max() * model.dt)
        if not rate < limit:  # not finite counts
            return True
        # A shift by whole cells changes nothing; it keeps the spray in the domain.
        moved = np.round((np.asarray(state.x).mean(0) - home) / _DX) * _DX
        state = dataclasses.replace(state, x=state.x - jnp.asarray(moved))
    return False


@jax.jit
def _advance(model: Model, state: State) -> State:
    return jax.lax.fori_loop(0, _CHUNK, lambda _, s: step(model, s), state)
