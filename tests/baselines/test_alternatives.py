"""Other force fields in place of the one that acts: the mixture against simulations of either, and its differences."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import physagent_jax as pa
from baselines.alternatives import compile_alternatives
from baselines.simulation import Simulation
from baselines.truncation import WHOLE, replay_truncated
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import make_jelly
from tests.baselines.tiny import act

pytestmark = pytest.mark.usefixtures(
    "module_least_optimised"
)  # derivatives of small scenes: to compile takes longest

PUSH = act("translation", (1, 0, 0), 1.0, (0, 5))
OTHERS = (
    act("impulse", (1, 0, 0), 1.0, (0, 5)),
    act("impulse", (0, 0, 1), 1.0, (0, 5)),  # leaves the ground
    act("scale", (1, 0, 0), -1.0, (0, 5)),
    act("torque", (0, 0, 1), 1.0, (0, 5)),
    act("torque", (0, 1, 0), 1.0, (0, 5)),  # tips it
    act("translation", (0, 1, 0), 1.0, (0, 5)),
)
NAMES = ["blow", "jump", "squeeze", "spin", "tip", "push aside"]


@dataclasses.dataclass(frozen=True)
class Mixture:
    """Positions, shape (T, n, 3), as a function of the weights, shape (others,)."""

    rollout: object
    scene: object
    idle: object

    @staticmethod
    def of(rollout, others):
        scene = rollout.scene
        return Mixture(rollout, scene, compile_alternatives(scene, others))

    def play(self, weights):
        idle = dataclasses.replace(self.idle, weights=weights)
        model = self.scene.model.replace(forces=(*self.scene.model.forces, idle))
        schedule = self.rollout.schedule.covering(model)
        return replay_truncated(model, self.scene.state, schedule, WHOLE)[0]


class World:
    """A jelly of 200 particles in empty space, or on the ground."""

    mass = frame_dt = None

    def __init__(self, folder, world):
        path = folder / "jelly.ply"
        write_ply(path, make_jelly(0, count=400))
        self.jelly = pa.load_object(path, up="+z", kind="jelly", extent=0.8, cells=32, max_particles=200)
        self.world = world

    def build(self, force_field):
        return pa.build_scene(
            self.jelly,
            force_field=force_field,
            material=dict(youngs_modulus=2e4, poissons_ratio=0.3, density=400.0),
            anchor="none",
            world=self.world,
            frame_count=6,
            width=64,
            height=48,
        )


@pytest.fixture(scope="module", params=[pytest.param("free", marks=pytest.mark.slow), "ground"])
def mixture(request, tmp_path_factory):
    simulation = Simulation(World(tmp_path_factory.mktemp(request.param), request.param))
    return Mixture.of(simulation.simulate(PUSH), OTHERS), simulation


def test_at_zero_it_is_what_acts(mixture):
    mixed, _ = mixture
    assert np.abs(np.asarray(mixed.play(jnp.zeros(len(OTHERS)))) - mixed.rollout.x).max() < 2e-6


@pytest.mark.parametrize("index", range(len(OTHERS)), ids=NAMES)
def test_at_one_it_is_the_other(mixture, index):
    """Simulated by itself, with steps of its own, from which the positions differ by the order of the step."""
    mixed, simulation = mixture
    own = simulation.simulate(OTHERS[index]).x
    found = np.asarray(mixed.play(jnp.zeros(len(OTHERS)).at[index].set(1.0)))
    moved = np.abs(own - mixed.rollout.x).max()
    assert moved > 0.01 and np.abs(found - own).max() < 0.02 * moved


def test_its_derivative_is_that_of_differences(mixture):
    """Of where the mass centre, and five others, go; on the ground through what overcomes friction as well."""
    mixed, _ = mixture
    ways = np.random.default_rng(0).normal(size=(6, *mixed.rollout.x.shape))
    ways[0] = 1.0
    none = jnp.zeros(len(OTHERS))
    _, pull = jax.vjp(mixed.play, none)
    found = np.stack([np.asarray(pull(jnp.asarray(way, jnp.float32))[0]) for way in ways])
    assert np.isfinite(found).all()
    step = 0.02
    differences = np.stack(
        [
            (
                np.asarray(mixed.play(none.at[k].set(step)), float)
                - np.asarray(mixed.play(none.at[k].set(-step)), float)
            )
            / (2 * step)
            for k in range(len(OTHERS))
        ]
    )
    wanted = np.tensordot(ways, differences, [(1, 2, 3), (1, 2, 3)])
    errors = np.abs(found - wanted).max(axis=0) / np.abs(wanted).max(axis=0)
    assert (errors < 0.03).all(), dict(zip(NAMES, errors))
