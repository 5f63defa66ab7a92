"""Gradients through whole simulations agree with central differences: laws, walls, grips and forces in combination.

Each kind of part is tested alone elsewhere; here every pair of kinds meets in one case at least. What is asked for is
the derivative along random directions of each group of numbers, in double precision, with the reference transfers.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.terms import (
    Attractor,
    PushCompensation,
    Stretch,
    Torque,
    Turbulence,
    TurnCompensation,
    UniformAcceleration,
    UniformField,
    VelocityChange,
    Vortex,
    Wind,
)
from physagent_jax.mpm import (
    Box,
    Contact,
    Cuboid,
    DomainBox,
    HalfSpace,
    Model,
    PrescribedMotion,
    RigidBody,
    SignedDistance,
    Sphere,
    State,
    rollout,
)
from physagent_jax.mpm.boundaries import SymmetryPlane
from physagent_jax.mpm.constraints import MovingPlate
from tests.mpm.blocks import block
from tests.mpm.single_points import material

LOW, SIDE, DX = 0.4, 0.15, 0.05  # of a block of 3 x 3 x 3 cells [m]
SUBSTEPS, DT = 24, 6e-4
STIFF_AT_REST = ("sand", "slurry", "fluid")  # these have a corner at F = I: they begin compressed
CORNER_WITHOUT_HISTORY = ("sand", "cohesive soil")  # v_c >= 0: they begin with some volume to give back
FOREVER = 1e9


def arrays(**values):
    return {
        name: jnp.asarray(value, float) if not isinstance(value, bool) else value
        for name, value in values.items()
    }


ALWAYS = arrays(start=0.0, end=FOREVER)
WINDOW = arrays(start=0.2 * DT, end=0.77 * SUBSTEPS * DT)
ABOUT = {"center": [0.47, 0.48, 0.46]}


def make_distance():
    """A ball, by samples."""
    axis = np.arange(12) * DX + 0.25
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
    return jnp.asarray(np.linalg.norm(grid - [0.47, 0.62, 0.49], axis=-1) - 0.1)


BOUNDARIES = {
    "walls": lambda: DomainBox(),
    "floor with friction": lambda: HalfSpace(
        **arrays(point=[0.5, 0.5, 0.43], normal=[0, 0.1, 0.995], friction=0.3, **ALWAYS)
    ),
    "sticky floor": lambda: HalfSpace(
        **arrays(point=[0.5, 0.5, 0.42], normal=[0.0, 0, 1], friction=0.0, **ALWAYS), contact=Contact.STICKY
    ),
    "slippery side": lambda: HalfSpace(
        **arrays(point=[0.43, 0.5, 0.5], normal=[1.0, 0, 0], friction=0.0, **ALWAYS), contact=Contact.SLIP
    ),
    "moving floor": lambda: HalfSpace(
        **arrays(point=[0.5, 0.5, 0.41], normal=[0, 0, 1.0], friction=0.2, velocity=[0.3, 0.1, 0.2], **WINDOW)
    ),
    "ball": lambda: Sphere(**arrays(point=[0.48, 0.47, 0.3], radius=0.12, friction=0.4, **ALWAYS)),
    "bowl": lambda: Sphere(
        **arrays(point=[0.48, 0.47, 0.5], radius=0.12, friction=0.2, **ALWAYS), container=True
    ),
    "solid box": lambda: Box(
        **arrays(point=[0.35, 0.45, 0.45], half_size=[0.08, 0.2, 0.2], friction=0.5, **ALWAYS)
    ),
    "box around": lambda: Box(
        **arrays(point=[0.48, 0.48, 0.5], half_size=[0.1, 0.1, 0.09], friction=0.1, **ALWAYS), container=True
    ),
    "mesh": lambda: SignedDistance(
        make_distance(), **arrays(origin=[0.25] * 3, friction=0.3, **ALWAYS), spacing=DX
    ),
    "moving box": lambda: Cuboid(
        **arrays(point=[0.47, 0.47, 0.36], half_size=[0.1, 0.1, 0.06], velocity=[0.2, 0.1, 0.4], **WINDOW)
    ),
    "mirror": lambda: SymmetryPlane(jnp.asarray(8), axis=1, side=1),
}
HELD = jnp.arange(24)
CONSTRAINTS = {
    "none": lambda: (),
    "grip": lambda: (
        PrescribedMotion(
            HELD, **arrays(velocity=[0.3, 0, 0.2], angular_velocity=[0.5, 0.2, 2.0], **ABOUT, **WINDOW)
        ),
    ),
    "free axis": lambda: (
        PrescribedMotion(
            HELD, **arrays(velocity=[0.0, 0, 0], angular_velocity=[0.5, 3, 1.0]), center=None, **WINDOW
        ),
    ),
    "rigid part": lambda: (RigidBody(HELD),),
    "plate": lambda: (
        MovingPlate(
            HalfSpace(
                **arrays(
                    point=[0.5, 0.5, 0.53], normal=[0, 0, -1.0], friction=0.4, velocity=[0, 0, -0.5], **WINDOW
                )
            )
        ),
    ),
}
FORCES = {
    "push": lambda: UniformAcceleration(jnp.array([9.0, 2, -4]), **WINDOW),
    "swing": lambda: UniformField(jnp.array([5.0, -9, 4]), Envelope.sine(70.0, 0.4, **WINDOW)),
    "torque": lambda: Torque(**arrays(axis=[0.6, 0.0, 0.8], magnitude=300.0, **WINDOW)),
    "stretch": lambda: Stretch(
        **arrays(axis=[0.6, 0.8, 0.0], magnitude=30.0, **WINDOW, ramp=0.5 * SUBSTEPS * DT)
    ),
    "blow": lambda: VelocityChange(jnp.array([0.3, -0.2, 0.1]), **arrays(start=5.3 * DT, end=5.3 * DT)),
    "slide": lambda: PushCompensation(
        **arrays(
            direction=[0.6, 0.8, 0], friction=4.0, push=2.0, speed=0.1, lever=0.05, damping_rate=0.3, **WINDOW
        )
    ),
    "spin": lambda: TurnCompensation(
        **arrays(axis=[0.0, 0.6, 0.8], friction=9.0, turn=30.0, damping_rate=0.3, **WINDOW)
    ),
    "wind": lambda: Wind(jnp.array([0.6, 0, 0.8]), 12.0, 2.0, 0.3, Envelope.constant(**WINDOW)),
    "attractor": lambda: Attractor(jnp.array([0.5, 0.6, 0.7]), 3.0, 2.0, 0.2, Envelope.pulse(0.0, 0.01)),
    "vortex": lambda: Vortex(
        **arrays(
            point=[0.45, 0.5, 0.5], axis=[0, 0.6, 0.8], swirl=20.0, inward=9.0, axial=4.0, core=0.1, power=1.5
        ),
        envelope=Envelope.ramp(0.003, 0.004, **WINDOW),
    ),
    "turbulence": lambda: Turbulence.from_seed(
        3,
        strength=9.0,
        length_scale=0.1,
        time_scale=0.01,
        envelope=Envelope.constant(**WINDOW),
        modes=5,
        dtype=float,
    ),
}
LAWS = (
    "neo-Hookean",
    "fixed corotated",
    "Hencky",
    "von Mises",
    "plasticine",
    "sand",
    "cohesive soil",
    "foam",
    "snow",
    "fluid",
)
quick_jit = partial(
    jax.jit, compiler_options={"xla_backend_optimization_level": 0}
)  # compiling is what costs
Case = tuple[str, tuple[str, ...], str, tuple[str, ...]]


def cover_pairs(boundaries: int = 3, forces: int = 3) -> list[Case]:
    """Cases, each with a law, a constraint and some boundaries and forces, in which every pair of kinds meets."""
    kinds = {**{(0, i): None for i in LAWS}, **{(1, i): None for i in BOUNDARIES}}
    kinds |= {**{(2, i): None for i in CONSTRAINTS}, **{(3, i): None for i in FORCES}}
    left = {(a, b) for a, b in itertools.combinations(kinds, 2) if a[0] != b[0]}
    rng, cases = np.random.default_rng(0), []

    def draw() -> Case:
        pick = lambda names, count: tuple(sorted(rng.choice(list(names), count, replace=False).tolist()))  # noqa: E731
        law, constraint = pick(LAWS, 1)[0], pick(CONSTRAINTS, 1)[0]
        return law, pick(BOUNDARIES, boundaries), constraint, pick(FORCES, forces)

    def find_met(case: Case) -> set:
        law, walls, constraint, terms = case
        met = [(0, law), *((1, each) for each in walls), (2, constraint), *((3, each) for each in terms)]
        return {(a, b) for a in met for b in met} & left

    while left:
        best = max((draw() for _ in range(400)), key=lambda case: len(find_met(case)))
        left -= find_met(best)
        cases.append(best)
    return cases


def make_case(
    law: str, walls: tuple[str, ...], constraint: str, terms: tuple[str, ...]
) -> tuple[Model, State]:
    """A block in motion, turning, with undeformed, evenly compressed and doubly stretched particles, in contact."""
    model, state = block((3, 3, 3), low=(LOW,) * 3, dtype=np.float64, dt=DT, size=16 * DX, grid_cells=16)
    count, rng = len(state.x), np.random.default_rng(4)
    made = material(law, count)
    model = model.replace(
        materials=(made,),
        gravity=jnp.array([0.3, 0.1, -9.8]),
        viscosity=jnp.full(count, 3.0),
        damping_rate=jnp.asarray(0.7),
        forces=tuple(FORCES[each]() for each in terms),
        boundaries=tuple(BOUNDARIES[each]() for each in walls),
        constraints=CONSTRAINTS[constraint](),
        kernels="reference",
    )
    stretch = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
    stretch[0::3] = np.diag([0.985, 0.985, 1.004])
    stretch[1::3] *= 0.985
    if law in STIFF_AT_REST:
        stretch *= 0.985
    x = state.x + 1e-3 * rng.normal(size=state.x.shape)
    spin = np.array([[0, -2.0, 1.0], [2.0, 0, -0.5], [-1.0, 0.5, 0]])
    v = np.array([0.5, -0.6, -1.4]) + (np.asarray(x) - 0.47) @ spin.T
    state = State.at_rest(jnp.asarray(x), jnp.asarray(v), materials=model.materials)
    history = state.history
    if law in CORNER_WITHOUT_HISTORY:
        history = jax.tree.map(lambda volume: volume + 0.003, history)
    C = jnp.broadcast_to(spin, stretch.shape)
    return model, dataclasses.replace(state, F=jnp.asarray(stretch), C=C, history=history)


def list_groups(model: Model, state: State) -> dict:
    """The numbers that are varied together, by name."""
    return {
        "law": model.materials,
        "mass": model.mass,
        "volume": model.volume,
        "viscosity": model.viscosity,
        "drag and gravity": (model.damping_rate, model.gravity),
        "forces": model.forces,
        "walls": [
            (getattr(each, "friction", None), getattr(each, "velocity", None)) for each in model.boundaries
        ],
        "grips": [
            (
                getattr(each, "velocity", None),
                getattr(each, "angular_velocity", None),
                getattr(each, "face", None),
            )
            for each in model.constraints
        ],
        "x": state.x,
        "v": state.v,
        "C": state.C,
        "F": state.F,
        "history": state.history,
    }


def put_groups(model: Model, state: State, groups: dict) -> tuple[Model, State]:
    def replace(part, **changes):
        return dataclasses.replace(
            part, **{name: value for name, value in changes.items() if value is not None}
        )

    rate, gravity = groups["drag and gravity"]
    model = model.replace(
        materials=groups["law"],
        mass=groups["mass"],
        volume=groups["volume"],
        viscosity=groups["viscosity"],
        damping_rate=rate,
        gravity=gravity,
        forces=groups["forces"],
        boundaries=tuple(
            replace(each, friction=friction, velocity=velocity)
            for each, (friction, velocity) in zip(model.boundaries, groups["walls"])
        ),
        constraints=tuple(
            replace(each, velocity=velocity, angular_velocity=spin, face=face)
            for each, (velocity, spin, face) in zip(model.constraints, groups["grips"])
        ),
    )
    return model, dataclasses.replace(
        state, **{name: groups[name] for name in ("x", "v", "C", "F", "history")}
    )


def draw_direction(tree, seed):
    """A random direction in which every leaf changes by about its own size; bounds of time by a substep."""
    rng = np.random.default_rng(seed)

    def draw(leaf):
        leaf = np.asarray(leaf, float)
        size = np.abs(leaf).max(initial=0)
        return jnp.asarray(rng.normal(size=leaf.shape) * (size if 0 < size < FOREVER else 0 if size else 0.1))

    return jax.tree.map(draw, tree)


STEPS = (1e-7, 1e-6, 1e-5)  # round-off spoils short ones where a group hardly matters, contact long ones


def check_case(case: Case) -> dict[str, tuple[float, Iterator[float]]]:
    """Slope and differences of each group along a random direction: central ones, and one to either side.

    The differences are taken one by one, as they are asked for.

    A node that is about to slip or to leave makes a corner, which may lie nearer than the shortest step. The slope is
    then that of the side on which the case lies.
    """
    model, state = make_case(*case)
    weight = np.random.default_rng(1).normal(size=(3, *state.F.shape))

    def evaluate(groups):
        end, _ = rollout(*put_groups(model, state, groups), frame_count=1, substeps=SUBSTEPS)
        return (end.x * weight[0, :, 0] + 0.03 * end.v * weight[1, :, 0]).sum() + 0.1 * (
            end.F * weight[2]
        ).sum()

    at = list_groups(model, state)
    respond, slopes = quick_jit(evaluate), quick_jit(jax.grad(evaluate))(at)
    found, here = {}, float(respond(at))
    for seed, name in enumerate(at):
        direction = draw_direction(at[name], seed)
        pairs = zip(jax.tree.leaves(slopes[name]), jax.tree.leaves(direction))
        slope = sum(float((one * other).sum()) for one, other in pairs)

        def respond_at(step, name=name, direction=direction):
            return float(respond({**at, name: jax.tree.map(lambda a, b: a + step * b, at[name], direction)}))

        def differences(respond_at=respond_at):
            sides = {}
            for step in STEPS:
                sides[step] = [(respond_at(h) - here) / h for h in (step, -step)]
                yield sum(sides[step]) / 2
            yield from sides[STEPS[0]]

        found[name] = slope, differences()
    return found


def assert_slopes_are_differences(case: Case) -> None:
    found = check_case(case)
    for name, (slope, differences) in found.items():
        tried = []
        for difference in differences:
            tried.append(difference)
            if slope == pytest.approx(difference, rel=1e-4, abs=1e-8):
                break
        else:
            pytest.fail(f"{name}: a slope of {slope}, and differences {tried}")
    assert all(found[name][0] != 0 for name in ("law", "mass", "forces", "x", "v", "F"))


def test_one_of_the_cases(x64):
    walls, terms = ("floor with friction", "moving floor", "mesh"), ("slide", "swing", "torque")
    assert_slopes_are_differences(("neo-Hookean", walls, "grip", terms))


def pytest_generate_tests(metafunc):
    """List the cases only where they may run: to find them takes seconds, of every process that collects tests."""
    if "case" in metafunc.fixturenames:
        left_out = metafunc.config.getoption("markexpr") == "not slow"
        cases = [] if left_out else cover_pairs()
        metafunc.parametrize("case", cases, ids=lambda case: "-".join([case[0], case[2]]))


@pytest.mark.slow
def test_every_pair_of_kinds(case, x64):
    assert_slopes_are_differences(case)


def test_the_height_after_a_bounce_by_the_height_of_the_drop(x64):
    """Before contact 1; afterwards what starts higher comes later: -e + (1 + e) g s / v, a time s after the impact.

    Simulators that miss the time of impact have the wrong sign there. The rebound speed is e of the impact's; it, and
    the time, are those of the simulated motion, which has no closed form.
    """
    gravity, height, frame_dt = 9.8, 0.2, 0.01
    domain = dict(size=14 * DX, grid_cells=14)
    model, state = block(
        (2,) * 3, low=(0.3, 0.3, 0.2), youngs_modulus=4e5, dtype=np.float64, dt=5e-4, **domain
    )
    floor = HalfSpace(**arrays(point=[0.3, 0.3, 0.2], normal=[0, 0, 1], friction=0.0, **ALWAYS))
    model = model.replace(gravity=jnp.array([0, 0, -gravity]), boundaries=(floor,), kernels="reference")

    def compute_heights(height):
        begun = dataclasses.replace(state, x=state.x + height * jnp.array([0, 0, 1.0]))
        states = rollout(model, begun, frame_count=24, substeps=20)[1]
        return states.x[..., 2].mean(1)

    heights = jax.jit(compute_heights)  # many steps: running is what costs
    slope = jax.jit(jax.grad(lambda height, weight: compute_heights(height) @ weight))
    z, h = np.asarray(heights(height)), 1e-6
    speed = np.diff(z) / frame_dt  # at the middle of each frame
    impact, rebound = -speed.min(), speed.max()
    lowest = (z.argmin() + 1) * frame_dt
    differences = (heights(height + h) - heights(height - h)) / (2 * h)
    for frame in (9, 17, 18, 23):  # falling, at contact's onset, in contact, rising
        got = slope(height, jnp.zeros(24).at[frame].set(1.0))
        assert got == pytest.approx(float(differences[frame]), rel=1e-5)
    assert differences[9] == pytest.approx(1.0)
    e, s = rebound / impact, 24 * frame_dt - lowest
    wanted = -e + (1 + e) * gravity * s / impact
    assert 0.4 < e < 1 and wanted < -0.1 and got == pytest.approx(wanted, abs=0.2)
