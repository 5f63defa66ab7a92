"""The contract of every registered skill, whoever writes it; closed forms of the vortex and the gust."""

import copy
import dataclasses
import math
import pickle

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from baselines.parametrisation import Parametrisation
from baselines.starts import KINDS, turn_into
from physagent_jax.agents.hard_rules import apply_hard_rules
from physagent_jax.agents.rules.remedies import list_remedies
from physagent_jax.forces import calibration
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.description import describe_skills
from physagent_jax.forces.free_path import compute_free_path
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import Action, ActionType, ForceField, Opposition
from physagent_jax.forces.skills import Skill, find_skill, list_skills, register_skill, unregister_skill
from physagent_jax.forces.skills.vortex import CORE
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.motion.edits import Case, retime, shorten
from physagent_jax.motion.matching import agrees, find_causes
from physagent_jax.motion.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.motion.tolerances import list_windows
from physagent_jax.report.force_cards import Setting, make_force_cards
from tests.agents.scenes import brief, make_report, table

FRAMES, FRAME_DT, LENGTH = 101, 0.01, 0.8
SCALING = make_closed_form_scaling(extent=LENGTH, youngs_modulus=1e5, density=500.0, duration=1.0)
UP, RIGHT = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
LOWER = {"kind": "half_space", "point": [0.5, 0.5, 0.5], "normal": [0, 0, -1]}
EACH = pytest.mark.parametrize("skill", list_skills(), ids=lambda skill: skill.name)
FORCES = pytest.mark.parametrize("skill", list_skills("actions"), ids=lambda skill: skill.name)


def make_field(skill, vector=RIGHT, magnitude=0.8, window=(10.0, 60.0), **more) -> ForceField:
    """One entry of a skill; what is sudden has a short window."""
    window = (window[0], window[0] + 1.0) if skill.is_sudden else window
    key = "action_type" if skill.group == "actions" else "constraint_type"
    entry = {key: skill.name, "vector": vector, "magnitude": magnitude, "active_time": window, **more}
    return ForceField.model_validate({skill.group: [entry]})


def make_cloud(count: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """A box of particles, the longest side along z, and their volumes."""
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.5, 0.5, (count, 3)) * [0.3, 0.5, LENGTH]
    x[:2, 2] = -0.5 * LENGTH, 0.5 * LENGTH
    return x + 1.0, rng.uniform(1, 2, count)


def compile_field(field, scaling=SCALING, parameters=None, cloud=None):
    rest, volume = cloud or make_cloud()
    return compile_force_field(
        field, scaling, rest, volume, frame_dt=FRAME_DT, frame_count=FRAMES, parameters=parameters
    )


def accelerate(forces, x, v, mass, time, dt):
    return sum((each.acceleration(x, v, mass, time, dt) for each in forces), jnp.zeros_like(x))


@EACH
def test_it_survives_json_and_the_schema_names_it(skill):
    field = make_field(skill)
    assert ForceField.model_validate_json(field.model_dump_json()) == field
    assert f'"{skill.name}"' in field.model_dump_json() and skill.name in str(describe_skills().json_schema)
    assert f"- `{skill.name}`: {skill.meaning}." in describe_skills().text


@EACH
def test_it_says_what_it_does(skill):
    assert float(skill.find_k(SCALING, np.asarray(UP))) > 0 and skill.unit and skill.one_means
    assert skill.causes and set(skill.causes) <= set(MotionKind)
    assert skill.prescribed_by is None or find_skill(skill.prescribed_by).group == "constraints"
    assert skill.towards is None or getattr(table(), skill.towards)


@EACH
def test_its_terms_are_finite_and_differentiable(skill, x64):
    """By magnitude and direction, against central differences; a direction may cut a two-sided body elsewhere."""
    field = make_field(skill, vector=(0.6, 0.0, 0.8), region=LOWER)
    numbers = jax.tree.map(jnp.asarray, ForceFieldParameters.of(field, FRAMES))
    rest, volume = make_cloud()
    x, v, mass = jnp.asarray(rest) + 0.01, jnp.zeros(rest.shape), jnp.asarray(volume)
    weights = jnp.asarray(np.random.default_rng(1).normal(size=rest.shape))

    def measure(change):
        entry = getattr(numbers, skill.group)[0]
        moved = dataclasses.replace(
            entry, magnitude=entry.magnitude + change[0], vector=entry.vector + change[1:]
        )
        forces, constraints = compile_field(
            field, parameters=dataclasses.replace(numbers, **{skill.group: (moved,)})
        )
        made = accelerate(forces, x, v, mass, jnp.asarray(0.1), jnp.asarray(0.01))
        leaves = [leaf for leaf in jax.tree.leaves(constraints) if jnp.issubdtype(leaf.dtype, jnp.floating)]
        return (weights * made).sum() + sum((leaf.sum() for leaf in leaves), jnp.zeros(()))

    gradient = np.asarray(jax.grad(measure)(jnp.zeros(4)))
    step, count = 1e-6, 1 if skill.is_two_sided else 4
    differences = [(measure(step * axis) - measure(-step * axis)) / (2 * step) for axis in jnp.eye(4)[:count]]
    assert np.isfinite(gradient).all() and abs(gradient[0]) > 0
    np.testing.assert_allclose(gradient[:count], differences, rtol=1e-5, atol=1e-6 * abs(gradient).max())


@FORCES
@pytest.mark.parametrize("magnitude", [1.0, -0.7])
def test_a_free_body_goes_the_free_path(skill, magnitude, x64):
    """The mean motion under its forces; nothing moves the middle of what is stretched or turned."""
    field = make_field(skill, vector=RIGHT, magnitude=magnitude)
    forces, _ = compile_field(field)
    rest, volume = make_cloud()
    x, mass, steps = jnp.asarray(rest), jnp.asarray(volume), 4 * (FRAMES - 1)
    dt = FRAME_DT * (FRAMES - 1) / steps

    def advance(state, time):
        shift, speed = state
        a = accelerate(forces, x + shift, jnp.broadcast_to(speed, x.shape), mass, time, jnp.asarray(dt))
        mean = (mass[:, None] * a).sum(0) / mass.sum()
        speed = speed + dt * mean
        return (shift + dt * (speed - 0.5 * dt * mean), speed), None

    (shift, _), _ = jax.lax.scan(advance, (jnp.zeros(3), jnp.zeros(3)), dt * jnp.arange(steps))
    path = compute_free_path(field, SCALING, frame_dt=FRAME_DT, frame_count=FRAMES)
    np.testing.assert_allclose(shift, path[-1], rtol=0.02, atol=0.01 * LENGTH)
    assert bool(np.abs(path[-1]).max() > 0.1) == ("move" in skill.causes)


@EACH
@pytest.mark.parametrize("magnitude", [0.8, -0.8])
def test_a_card_shows_it(skill, magnitude):
    setting = Setting(table(), last_frame=FRAMES - 1, frame_dt=FRAME_DT, scaling=SCALING)
    card = str(make_force_cards(make_field(skill, magnitude=magnitude), setting))
    assert "<svg" in card and skill.unit in card and "{" not in card.split("<svg")[1].split("</dl>")[0]
    assert skill.name.replace("_", " ").capitalize() in card
    marks = skill.draw_icon(magnitude < 0)
    assert marks and all(math.hypot(*point) < 1.2 for mark in marks for point in mark.points)


@EACH
def test_the_executor_changes_it(skill):
    """It is found as a cause, the hard rules leave it alone, and it is made stronger, reversed, moved and cut short."""
    kind = MotionKind(skill.causes[0])
    field = make_field(skill)
    wanted = ExpectedMotion(kind=kind, direction=RIGHT, window=(10.0, 40.0), sudden=skill.is_sudden)
    (cause,) = find_causes(wanted, field)
    assert agrees(cause, wanted) or skill.is_two_sided or skill.deforms
    assert apply_hard_rules(field, brief(frame_count=FRAMES), ()) == (field, ())
    weak = Check(expectation=0, question="", expected="", observed="", passed=False, score=0.2, gain=1.5)
    still = [(0.0, 0.0, 0.0)] * FRAMES
    report = make_report(still, windows=list_windows((wanted,), FRAMES))
    case = Case(field, wanted, (wanted,), brief(frame_count=FRAMES), (weak,), report)
    tried = [change.force_field for change in list_remedies(case)]
    assert tried and all(isinstance(each, ForceField) and each != field for each in tried[:1])
    for change in (retime(case, [cause]), shorten(case, [cause], 0.5, "")):
        assert change is not None
        ForceField.model_validate(change.force_field.model_dump())


@FORCES
def test_search_methods_vary_it(skill):
    kinds = [kind for kind in KINDS if kind[0] == skill.name]
    assert len(kinds) == (2 if skill.is_two_sided else 1)
    action = Action(action_type=KINDS[0][0], vector=(0.6, 0.0, 0.8), magnitude=1.2)
    field = ForceField(actions=(turn_into(action, kinds[-1]),))
    unknowns = Parametrisation(field, FRAMES)
    assert unknowns.decode(unknowns.encode(field)).actions[0].action_type == skill.name


def test_names_that_no_skill_has_are_refused():
    with pytest.raises(ValueError, match="'translation', .*'vortex'"):
        ForceField.model_validate({"actions": [{"action_type": "teleport", "vector": UP}]})
    with pytest.raises(ValueError, match="TELEPORT"):
        ActionType("TELEPORT")
    with pytest.raises(AttributeError, match="TELEPORT"):
        _ = ActionType.TELEPORT
    with pytest.raises(ValueError, match="already"):
        register_skill(find_skill("scale"))


@pytest.mark.parametrize("skill", ["wind_gust", "enforce_particle_translation"])
def test_a_name_stays_one_object(skill):
    """By whatever way it comes: so that what is said of it by identity holds, also in another process."""
    field = make_field(find_skill(skill))
    for other in (copy.deepcopy(field), pickle.loads(pickle.dumps(field)), field.model_copy(deep=True)):
        (entry,), (same,) = field.actions or field.constraints, other.actions or other.constraints
        names = [getattr(each, "action_type", None) or each.constraint_type for each in (entry, same)]
        assert names[0] is names[1] and names[0].skill is find_skill(skill) and type(names[0].value) is str


class Lift(Skill):
    """A push upwards whatever the vector: a skill that only this test knows."""

    name = "test_lift"
    meaning = "a lift that heeds no vector"
    one_means = "unopposed, one body length by the clip's end"
    quantity, unit = "translation", "m/s\u00b2"
    effect = "lifts, told {direction}"
    causes = ("move",)

    def make_forces(self, bound):
        """One uniform push."""
        k = self.find_k(bound.scaling, bound.values.vector) * bound.values.magnitude
        return [UniformAcceleration(bound.leaf(k * np.asarray(UP)), *bound.window, bound.weight)]


def test_a_skill_of_one_class_reaches_description_simulation_and_report():
    before = describe_skills()
    register_skill(Lift())
    try:
        assert "`test_lift`: a lift that heeds no vector." in describe_skills().text
        assert "test_lift" in str(describe_skills().json_schema)
        field = make_field(find_skill("test_lift"), magnitude=0.5, window=(0.0, 100.0))
        (push,), _ = compile_field(field)
        np.testing.assert_allclose(push.value, [0, 0, 0.5 * 2 * calibration.TRAVEL * LENGTH], rtol=1e-6)
        card = str(make_force_cards(field, Setting(table(), scaling=SCALING)))
        assert "Test lift" in card and "lifts, told right" in card and "<svg" in card
        assert apply_hard_rules(field, brief(frame_count=FRAMES), ()) == (field, ())
    finally:
        unregister_skill("test_lift")
    assert describe_skills() == before
    with pytest.raises(ValueError, match="Input should be"):
        ForceField.model_validate(field.model_dump())


def test_a_vortex_is_solid_at_its_axis_and_free_far_from_it(x64):
    """Kaufmann's profile: half of the axis's rate at the core's edge, 1 / d far from it, and nothing on the axis."""
    rest, volume = make_cloud()
    centre = np.average(rest, axis=0, weights=volume)
    forces, _ = compile_field(make_field(find_skill("vortex"), vector=UP, magnitude=1.0, window=(0.0, 100.0)))
    extent = np.ptp(rest, axis=0).max()
    core = CORE * extent
    radii = np.array([0.0, 0.01, 1.0, 2.0, 30.0, 60.0]) * core
    places = jnp.asarray(centre + radii[:, None] * np.array(RIGHT) + 0.2 * np.array(UP))
    a = accelerate(forces, places, 0 * places, jnp.ones(6), jnp.asarray(0.2), jnp.asarray(0.01))
    rate = a[1, 1] / radii[1]  # at the axis
    assert rate > 2 * calibration.TURN
    np.testing.assert_allclose(a[:, [0, 2]], 0, atol=1e-9)  # tangential
    np.testing.assert_allclose(a[2:4, 1], rate * core * np.array([1 / 2, 2 / 5]), rtol=1e-3)
    np.testing.assert_allclose(a[4, 1] / a[5, 1], 2.0, rtol=1e-2)


def test_a_vortex_turns_a_rigid_body_as_a_torque_does(x64):
    """Moment over inertia, summed over particles, is 2 theta / T^2 times M.

    What holds it upright is made up for as long as it turns no faster than that.
    """
    rest, volume = make_cloud()
    arm = rest - np.average(rest, axis=0, weights=volume)
    opposition = Opposition(tipping=7.0, travel=LENGTH, time=1.0)
    rate = 0.9 * 2 * calibration.TURN
    spin = rate * (0.2 - 10 * FRAME_DT) * np.cross(RIGHT, arm)
    for opposed, more, v in ((None, 0.0, 0 * arm), (opposition, 7.0, spin), (opposition, 0.0, 2 * spin)):
        scaling = SCALING.model_copy(update={"opposition": opposed})
        forces, _ = compile_field(make_field(find_skill("vortex"), vector=RIGHT, magnitude=0.9), scaling)
        a = accelerate(
            forces,
            jnp.asarray(rest),
            jnp.asarray(v),
            jnp.asarray(volume),
            jnp.asarray(0.2),
            jnp.asarray(0.01),
        )
        turned = (volume * np.cross(arm, a)[:, 0]).sum() / (volume * (arm[:, 1:] ** 2).sum(1)).sum()
        np.testing.assert_allclose(turned, rate + more, rtol=1e-6)


def test_a_gust_rises_and_falls_as_the_discrete_gust_does(x64):
    """1 - cos over the window (14 CFR 25.341): nothing at its ends, twice the mean in the middle."""
    forces, _ = compile_field(make_field(find_skill("wind_gust"), magnitude=1.0, window=(20.0, 60.0)))
    x = jnp.asarray(make_cloud()[0])
    times = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
    seen = [accelerate(forces, x, 0 * x, jnp.ones(len(x)), t, 1e-9)[0, 0] for t in jnp.asarray(times)]
    k = 2 * calibration.TRAVEL * LENGTH
    np.testing.assert_allclose(seen, k * np.array([0, 0, 1, 2, 1, 0, 0]), atol=1e-6 * k)


def test_a_gust_takes_an_object_as_far_as_a_push_of_its_window():
    """Closed form k M T^2 / 2, and k M T on the way on."""
    ends = [
        compute_free_path(
            make_field(find_skill(name), window=(0.0, 100.0)), SCALING, frame_dt=0.01, frame_count=101
        )
        for name in ("wind_gust", "translation")
    ]
    np.testing.assert_allclose(ends[0][-1], ends[1][-1], rtol=1e-9)
    np.testing.assert_allclose(ends[1][-1], [0.8 * calibration.TRAVEL * LENGTH, 0, 0], rtol=0.02)


@pytest.mark.parametrize("drag", [0.0, 1.5])
def test_a_gust_overcomes_friction_and_keeps_its_profile(drag, x64):
    """Coulomb's friction as in a textbook: the block moves as a free one does under the gust and drag alone."""
    friction, frames = 4.0, (0.0, 80.0)
    opposition = Opposition(friction=friction, damping_rate=drag, travel=LENGTH, time=1.0)
    field = make_field(find_skill("wind_gust"), magnitude=1.0, window=frames)
    opposed, _ = compile_field(field, SCALING.model_copy(update={"opposition": opposition}))
    free, _ = compile_field(field)
    rest, volume = make_cloud(40)
    x, mass, dt = jnp.asarray(rest), jnp.asarray(volume), 0.0005

    def run(forces, rubbing):
        def advance(state, time):
            shift, speed = state
            a = accelerate(forces, x, jnp.broadcast_to(speed * jnp.asarray(RIGHT), x.shape), mass, time, dt)
            push = (mass * a[:, 0]).sum() / mass.sum() - drag * speed
            moved = speed + dt * push
            speed = jnp.sign(moved) * jnp.maximum(jnp.abs(moved) - dt * rubbing, 0.0)
            return (shift + dt * speed, speed), speed

        return jax.lax.scan(advance, (0.0, 0.0), dt * jnp.arange(1600))

    (way, _), speeds = run(opposed, friction)
    (wanted, _), wished = run(free, 0.0)
    np.testing.assert_allclose(way, wanted, rtol=0.03)
    np.testing.assert_allclose(speeds[200:], wished[200:], atol=0.04 * float(wished.max()))
