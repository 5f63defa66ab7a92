"""The balance of what jumps, is lifted or pushed over the ground: it stays upright, and comes to rest standing."""

import itertools
import math

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.forces import calibration
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Opposition, Response
from physagent_jax.forces.terms import (
    AxleBalance,
    Balance,
    Landing,
    PushCompensation,
    Settling,
    TurnCompensation,
)

G, FRICTION, WIDTH, HEIGHT = calibration.GRAVITY, 0.4 * calibration.GRAVITY, 0.2, 1.0
TOWER = np.array(list(itertools.product(*[np.linspace(-0.5, 0.5, 5)] * 3))) * [WIDTH, 0.3, HEIGHT]
TOWER[:, 2] += 0.5 * HEIGHT
UP = (0.0, 0.0, 1.0)
MASS = np.ones(len(TOWER))


def compile_entries(*actions, constraints=(), lever=0.5 * HEIGHT, responses=(), rest=TOWER, drop=False):
    opposition = Opposition(friction=FRICTION, weight=G, tipping=1.0, lever=lever, travel=1.0, time=2.0)
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=1e5, density=1.0, duration=2.0, opposition=opposition
    )
    scaling = scaling.model_copy(update=dict(responses=tuple(responses)))
    entries = dict(actions=list(actions), constraints=list(constraints), default_drop=drop)
    field, numbers = ForceField.model_validate(entries), dict(frame_dt=0.04, frame_count=51)
    return compile_force_field(field, scaling, rest.astype(np.float32), MASS.astype(np.float32), **numbers)


def act(kind, vector, first, last, magnitude=1.0):
    return dict(action_type=kind, vector=vector, magnitude=magnitude, active_time=(first, last))


def find_balance(*actions, **more):
    return [each for each in compile_entries(*actions, **more)[0] if isinstance(each, Balance)]


def evaluate(terms, x, v, time):
    state = (jnp.asarray(each, jnp.float32) for each in (x, v, MASS, time, 1e-3))
    state = list(state)
    return np.asarray(sum(each.acceleration(*state) for each in terms), float)


def push_mean(terms, velocity, time):
    return evaluate(terms, TOWER, np.broadcast_to(velocity, TOWER.shape), time).mean(0)


def turned(degrees):
    return Rotation.from_euler("x", degrees, degrees=True).apply(TOWER)


def test_what_jumps_is_turned_back_to_how_it_stood():
    (balance,) = find_balance(act("impulse", (0, 0, 1), 0, 1))
    r = turned(10) - turned(10).mean(0)
    field = evaluate([balance], turned(10), np.zeros_like(TOWER), 0.5)
    spin = np.cross(r, field).mean(0)
    assert spin[0] < 0 and abs(spin[1:]).max() < 1e-3 * abs(spin[0])
    np.testing.assert_allclose(field.mean(0), 0, atol=1e-3)  # and is not moved
    wanted = -np.sin(np.radians(10)) * 20.0**2
    np.testing.assert_allclose(field, np.cross([wanted, 0, 0], r), atol=0.02 * abs(wanted))


def test_what_was_turned_over_is_not_set_upright_again_as_it_is_pushed():
    topple = dict(
        constraint_type="enforce_particle_rotation", vector=(0, 1, 0), magnitude=1.0, active_time=(0, 14)
    )
    push = act("translation", (1, 0, 0), 25, 50)
    assert find_balance(push) and not find_balance(push, constraints=[topple])


def test_what_slides_on_its_side_does_not_rock_there():
    """A van that was tipped over lurched to and fro as it was pushed along: nothing opposed its spin."""
    topple = dict(
        constraint_type="enforce_particle_rotation", vector=(0, 1, 0), magnitude=1.0, active_time=(0, 14)
    )
    lying = TOWER[:, [2, 1, 0]] - [0, 0, TOWER[:, 0].min()]
    spin = np.cross([0, 0.5, 0], lying - lying.mean(0))
    terms, _ = compile_entries(act("translation", (1, 0, 0), 25, 50), constraints=[topple])
    (slide,) = [each for each in terms if isinstance(each, PushCompensation)]
    assert slide.feet is None  # it lies on other matter
    field = evaluate([slide], lying, spin, 1.5)
    against = np.cross(lying - lying.mean(0), field).mean(0) @ [0, 1, 0]
    assert against < 0.0
    rolls = act("torque", (0, 1, 0), 25, 50)
    for each in compile_entries(act("translation", (1, 0, 0), 25, 50), rolls, constraints=[topple])[0]:
        assert not isinstance(each, PushCompensation) or not float(each.lever)


def test_it_lets_go_when_something_else_begins_and_leaves_alone_what_rolls_is_kicked_or_turned():
    hop, topple = act("impulse", (0, 0, 1), 0, 1), act("torque", (1, 0, 0), 25, 50)
    (balance,) = find_balance(hop, topple)
    assert float(balance.end) == pytest.approx(1.0)
    assert float(find_balance(hop)[0].end) > 100
    assert not find_balance(hop, lever=0.0, rest=TOWER * [1, 1, 0.25])
    assert not find_balance(act("impulse", (1, 0, 0), 0, 1))
    assert not find_balance(act("impulse", (0, 0, 1), 0, 2), act("torque", (1, 0, 0), 0, 30))


def test_what_is_lifted_rises_as_fast_as_was_asked_whatever_slows_it():
    terms, _ = compile_entries(act("translation", (0, 0, 1), 0, 50))
    k = 2 * calibration.TRAVEL / 2.0**2
    np.testing.assert_allclose(push_mean(terms, [0, 0, k], 1.0)[2], k + G, rtol=0.01)
    assert push_mean(terms, [0, 0, k + 0.05], 1.0)[2] < G  # faster: less than its weight is borne
    assert push_mean(terms, [0, 0, k - 0.05], 1.0)[2] > k + 1.3 * G


def test_what_is_lifted_by_a_small_part_of_it_is_borne_as_a_whole():
    """The end of a handle that is too stiff to bend: the whole follows, and its weight is what there is to lift."""
    grip = dict(kind="box", low=(0, 0, 0.8), high=(1, 1, 1))
    k, share = 2.5, 0.2
    response = Response.model_validate(dict(quantity="translation", region=grip, vector=UP, k=k, share=share))
    terms, _ = compile_entries(act("translation", UP, 0, 50) | dict(region=grip), responses=[response])
    field = evaluate(terms, TOWER, np.broadcast_to([0, 0, k * share], TOWER.shape), 1.0)
    np.testing.assert_allclose(field.mean(0)[2], G + k * share, rtol=0.01)
    assert abs(field[TOWER[:, 2] < 0.7] - [0, 0, G]).max() < 0.2 * G  # and not by its end alone
    assert push_mean(terms, [0, 0, k * share + 0.3], 1.0)[2] < k * share + 0.1


def test_a_push_over_the_ground_ends_in_a_slide_that_does_not_trip():
    """A tower of this width tips with g w / h; what is fast is stopped within 0.7 s, and steadied."""
    terms, _ = compile_entries(act("translation", (-1, 0, 0), 0, 50, 1.3))
    slide = [each for each in terms if isinstance(each, PushCompensation)]
    rate = max(0.7 * G * WIDTH / HEIGHT, 1.3 / 0.7)
    for late in (0.1, 0.3, 0.6):
        helped = -push_mean(slide, [rate * late - 1.3, 0, 0], 2.0 + late)[0]
        assert FRICTION - helped == pytest.approx(rate, rel=0.03)
    assert push_mean(slide, [0, 0, 0], 2.75) == pytest.approx(np.zeros(3), abs=1e-3)  # it stands
    brief = compile_entries(act("translation", (-1, 0, 0), 0, 10), act("torque", (0, 0, 1), 10, 50))[0]
    assert push_mean(brief[1:2], [-0.2, 0, 0], 0.45) == pytest.approx(np.zeros(3))  # left to what follows


def test_what_is_tilted_by_a_constraint_turns_about_the_edge_of_its_foot():
    turn = dict(constraint_type="enforce_particle_rotation", magnitude=0.42)
    there = turn | dict(vector=(0, 1, 0), active_time=(0, 25), held_until=40)
    back = turn | dict(vector=(0, -1, 0), active_time=(40, 50))
    motions = compile_entries(constraints=[there, back])[1]
    for motion in motions[:1] + motions[2:]:
        np.testing.assert_allclose(np.asarray(motion.center)[[0, 2]], [0.5 * WIDTH, 0], atol=1e-6)
    over = compile_entries(constraints=[there | dict(magnitude=1.6, active_time=(0, 39))])[1]
    assert over[0].center is None  # it is turned over about its middle


def test_what_overhangs_meets_the_ground_as_it_is_tilted():
    """A car that rears: about its bumper it hung over the ground, about its wheels the bumper went into that."""
    foot, above = TOWER[TOWER[:, 2] < 0.1], TOWER[TOWER[:, 2] > 0.1] * [10.0, 1.0, 1.0]
    car = np.concatenate([foot, above]).astype(np.float32)
    turn = dict(constraint_type="enforce_particle_rotation", vector=(0, 1, 0), active_time=(0, 25))
    motion = compile_entries(constraints=[turn | dict(magnitude=0.42, held_until=40)], rest=car)[1][0]
    rate = np.asarray(motion.angular_velocity)
    degrees = np.degrees(rate[1]) * 25 * 0.04
    after = Rotation.from_rotvec(rate * 25 * 0.04).apply(car - np.asarray(motion.center)) + motion.center
    assert 5.0 < degrees < 20.0 and after[:, 2].min() == pytest.approx(0.0, abs=1e-3)


def follow(motion, x):
    """Places after each part of a motion about its own middle."""
    paces = np.asarray(motion.velocity)
    seconds, places = float(motion.end - motion.start) / len(paces), [x]
    for pace in paces:
        middle = np.average(places[-1], axis=0, weights=MASS)
        turn = Rotation.from_rotvec(np.asarray(motion.angular_velocity) * seconds)
        places.append(turn.apply(places[-1] - middle) + middle + pace * seconds)
    return places[1:]


@pytest.mark.parametrize("magnitude", [1.0, 1.6])
@pytest.mark.parametrize("drop", [False, True])
def test_what_is_narrow_below_rolls_over_its_rim_as_it_is_laid_onto_its_side(magnitude, drop):
    """A pan went over its foot alone, and its rim into the ground; a barrel stuck there."""
    pan = TOWER * [1.0, 1.0, 0.1]
    pan[:, 0] *= 1.0 + 20.0 * pan[:, 2]
    at = dict(active_time=(20, 45), held_until=50) if drop else dict(active_time=(0, 25), held_until=40)
    turn = dict(constraint_type="enforce_particle_rotation", vector=(0, 1, 0), magnitude=magnitude) | at
    rolls, _ = compile_entries(constraints=[turn], rest=pan, drop=drop)[1]
    *_, last = places = follow(rolls, pan)
    np.testing.assert_allclose([x[:, 2].min() for x in places], 0.0, atol=1e-4)
    gone = last.mean(0) - pan.mean(0)
    assert gone[0] > 0.05 and abs(gone[1]) < 1e-4 and rolls.center is rolls.about is None


@pytest.mark.parametrize("back", [False, True])
def test_what_is_turned_over_rests_on_the_ground_all_the_way(back):
    """A fish on its belly went into the floor with the fin of its back, which is longer."""
    fish = (TOWER - TOWER.mean(0)) * [0.5, 1.0, 1.0]
    fish[:, 2] *= np.where(fish[:, 2] > 0, 1.5, 1.0)
    fish[:, 2] -= fish[:, 2].min()
    turn = dict(constraint_type="enforce_particle_rotation", magnitude=1.6, gain=2.5)
    spans = [turn | dict(vector=(0, 1, 0), active_time=(0, 25), held_until=None if back else 40)]
    spans += [turn | dict(vector=(0, -1, 0), active_time=(25, 50))] * back
    motions, places = compile_entries(constraints=spans, rest=fish)[1], [fish]
    for motion in motions if back else motions[:-1]:
        places += follow(motion, places[-1])
        assert np.degrees(abs(motion.angular_velocity[1]) * (motion.end - motion.start)) == pytest.approx(
            180.0
        )
    np.testing.assert_allclose([x[:, 2].min() for x in places], 0.0, atol=1e-4)
    np.testing.assert_allclose(places[-1].mean(0)[:2], fish.mean(0)[:2], atol=1e-4)
    assert not back or np.abs(places[-1] - fish).max() < 1e-4


@pytest.mark.parametrize("more", [(), (dict(action_type="torque", vector=(0, 1, 0), active_time=(32, 50)),)])
def test_what_rocks_turns_about_the_edge_that_it_stands_on(more):
    """There and back over one edge of its foot, then over the other, whatever comes after it."""
    turn = dict(constraint_type="enforce_particle_rotation", magnitude=0.42)
    rocked = [
        turn | dict(vector=(0, side, 0), active_time=(8 * i, 8 * i + 8))
        for i, side in enumerate((1, -1, -1, 1))
    ]
    motions = compile_entries(*more, constraints=rocked)[1]
    edges = [np.asarray(each.center)[[0, 2]] for each in motions]
    half = 0.5 * WIDTH
    np.testing.assert_allclose(edges, [[half, 0], [half, 0], [-half, 0], [-half, 0]], atol=1e-6)


@pytest.mark.parametrize(("height", "kept"), [(1.0, True), (0.25, False)])
def test_what_is_tall_and_leaps_comes_down_upright_however_round_its_foot(height, kept):
    """A rolling foot has no lever: an aubergine lay after its second hop."""
    rest = TOWER * [1, 1, height]
    hop = [act("impulse", (0, 0, 1), first, first + 1) for first in (0, 24)]
    assert len(find_balance(*hop, lever=0.0, rest=rest)) == 2 * kept
    assert not find_balance(act("translation", (1, 0, 0), 0, 20), lever=0.0)


def test_what_rolls_on_as_it_lies_comes_to_rest():
    tipped = act("torque", (0, 1, 0), 0, 12)
    roll = act("torque", (0, 1, 0), 20, 30)
    (settling,) = [each for each in compile_entries(tipped, roll)[0] if isinstance(each, Settling)]
    r = turned(90) - turned(90).mean(0)
    spinning = np.cross([0, 3.0, 0], r)
    assert abs(evaluate([settling], turned(90), spinning, 1.0)).max() == 0.0
    slowed = np.cross(r, evaluate([settling], turned(90), spinning, 1.4)).mean(0)
    assert slowed[1] < 0 and np.abs(slowed[[0, 2]]).max() < 1e-3 * -slowed[1]


def test_what_is_led_over_and_let_go_lies_where_it_falls():
    """A chest that fell on its back went on until it lay on its lid."""
    tilt = dict(
        constraint_type="enforce_particle_rotation", magnitude=1.0, vector=(1, 0, 0), active_time=(0, 25)
    )
    (landing,) = [each for each in compile_entries(constraints=[tilt])[0] if isinstance(each, Landing)]
    assert float(landing.start) == pytest.approx(1.0)
    for degrees in (30, 60):  # it falls freely
        assert abs(evaluate([landing], turned(degrees), turned(degrees), 1.5)).max() < 1e-3

    def find_spin_up(degrees, spin):
        r = turned(degrees) - turned(degrees).mean(0)
        field = evaluate([landing], turned(degrees), np.cross([spin, 0, 0], r), 1.5)
        return np.cross(r, field).mean(0)[0]

    assert find_spin_up(90, 2.0) < 0 < find_spin_up(90, -2.0) and abs(find_spin_up(95, 0.0)) < 1e-3
    assert find_spin_up(130, 0.0) < 0  # it rolls back
    held = compile_entries(constraints=[tilt | dict(held_until=40)])[0]
    small = compile_entries(constraints=[tilt | dict(magnitude=0.5)])[0]
    assert not any(isinstance(each, Landing) for each in (*held, *small))


@pytest.mark.parametrize(
    "before",
    [
        act("translation", (-1, 0, 0), 0, 20),
        act("impulse", (0, 0, 1), 0, 1),
        *(
            dict(constraint_type="enforce_particle_rotation", vector=way, magnitude=0.8, active_time=(0, 9))
            for way in ((1, 0, 0), (0, 0, 1))
        ),
    ],
    ids=["slid", "leapt", "tilted", "spun"],
)
def test_what_stands_elsewhere_is_tilted_over_its_foot_there(before):
    """A turn about its middle is left to what lies or looks another way by then."""
    tilt = dict(
        constraint_type="enforce_particle_rotation", magnitude=0.42, vector=(0, 1, 0), active_time=(25, 50)
    )
    actions, constraints = ([before], []) if "action_type" in before else ([], [before])
    motion = compile_entries(*actions, constraints=[*constraints, tilt])[1][-1]
    assert motion.center is None and (motion.about is None) == (not actions)
    if actions:
        edge = TOWER[np.asarray(motion.about) > 0]
        assert len(edge) and (edge[:, 0] == TOWER[:, 0].max()).all() and (edge[:, 2] == 0).all()


def test_gradients_of_the_balance_are_finite_also_where_nothing_is_off():
    import jax

    (balance,) = find_balance(act("translation", (-1, 0, 0), 0, 50))

    def find(x):
        state = (jnp.asarray(each, jnp.float32) for each in (0 * TOWER, MASS, 1.0, 1e-3))
        v, mass, time, dt = state
        return (balance.acceleration(x, v, mass, time, dt) ** 2).sum()

    for x in (TOWER, turned(6)):
        assert np.isfinite(np.asarray(jax.grad(find)(jnp.asarray(x, jnp.float32)))).all()


def pair(kind, way, first, last, held_until=None):
    return [
        dict(
            constraint_type=kind,
            vector=tuple(sign * each for each in way),
            magnitude=1.0,
            active_time=(first, last),
            held_until=held_until,
        )
        for sign in (1.0, -1.0)
    ]


def test_what_was_pressed_and_let_go_stands_upright_again():
    """A soft toy that was let go fell over a second later."""
    (balance,) = find_balance(constraints=pair("moving_plate", (1, 0, 0), 0, 15, held_until=25))
    assert float(balance.start) == pytest.approx(1.0) and float(balance.end) > 100
    (balance,) = find_balance(constraints=pair("moving_plate", (1, 0, 0), 0, 15))
    assert float(balance.start) == pytest.approx(0.6)
    again = [*pair("moving_plate", (1, 0, 0), 0, 15), *pair("moving_plate", (1, 0, 0), 25, 40)]
    assert sorted(float(each.end) for each in find_balance(constraints=again))[0] == pytest.approx(1.0)
    topple = act("torque", (1, 0, 0), 25, 50)
    (balance,) = find_balance(topple, constraints=pair("moving_plate", (1, 0, 0), 0, 15))
    assert float(balance.end) == pytest.approx(1.0)
    assert not find_balance(constraints=pair("moving_plate", (1, 0, 0), 0, 15), lever=0.0)


def test_what_is_thrown_aside_tumbles_and_what_leaps_aside_does_not():
    assert not find_balance(act("impulse", (0.53, 0.0, 0.848), 0, 1))
    assert find_balance(act("impulse", (0.38, 0.0, 0.925), 0, 1))


@pytest.mark.parametrize(("fallen", "limited"), [(False, True), (True, False)])
def test_what_lies_is_rolled_over_one_edge_after_another(fallen, limited):
    """A can that had fallen over was not turned: as if it stood, its weight was overcome up to its balance alone."""
    over = dict(constraint_type="enforce_particle_rotation", vector=(1, 0, 0), active_time=(0, 15))
    roll = act("torque", (0, 1, 0), 30, 50)
    forces, _ = compile_entries(roll, constraints=[dict(over, magnitude=1.6)] if fallen else [])
    (turn,) = [each for each in forces if isinstance(each, TurnCompensation)]
    assert (turn.balance is not None) is limited


def leap_and_land(*turns, constraints=()):
    """A leap at frame 20, the turns, and the landing at frame 42."""
    landing = dict(
        constraint_type="enforce_particle_translation", vector=(0, 0, -1), magnitude=0.4, gain=0.02
    )
    landing |= dict(active_time=(42, 43), held_until=50)
    actions = [act("impulse", (0, 0, 1), 20, 21), *turns]
    made = find_balance(*actions, constraints=[*constraints, landing])
    return [each for each in made if float(each.start) > 1.6]


def spin_aloft(degrees):
    """Two opposed turns, by which it spins in between, of M = 1 being pi / 4 rad/s^2."""
    rate = math.radians(degrees) / (17 * 0.04) / (4 * 0.04)
    size = dict(magnitude=1.6, gain=rate / (1.6 * math.pi / 4))
    return [act("torque", (0, y, 0), at, at + 4) | size for y, at in ((1, 21), (-1, 38))]


def test_what_comes_down_from_a_somersault_stands_and_from_half_a_turn_lies():
    """The robot fell over at the end of its backflip: it stands on a tip."""
    assert leap_and_land() and leap_and_land(*spin_aloft(360))
    assert not leap_and_land(*spin_aloft(180)) and not leap_and_land(*spin_aloft(90))


def test_what_sat_lands_on_its_feet_and_what_was_tipped_over_does_not():
    tilts = [
        dict(constraint_type="enforce_particle_rotation", vector=(0, 1, 0), magnitude=m, active_time=(0, 19))
        for m in (0.8, 1.6)
    ]
    assert leap_and_land(constraints=tilts[:1]) and not leap_and_land(constraints=[tilts[1] | dict(gain=2.0)])


def make_disc(axis=1):
    """A disc on its edge, its axle along y or x."""
    disc = np.array(
        list(itertools.product(np.linspace(-0.5, 0.5, 9), [-0.05, 0.05], np.linspace(-0.5, 0.5, 9)))
    )
    disc = disc[np.hypot(disc[:, 0], disc[:, 2]) <= 0.5] + [0, 0, 0.5]
    return disc if axis == 1 else disc[:, [1, 0, 2]]


def keep_axle(rest, vector=(0, 1, 0)):
    volume = np.ones(len(rest), np.float32)
    opposition = Opposition(friction=FRICTION, weight=G, tipping=1.0, lever=0.0, travel=1.0, time=2.0)
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=1e5, density=1.0, duration=2.0, opposition=opposition
    )
    field = ForceField.model_validate({"actions": [act("torque", vector, 0, 50)]})
    terms, _ = compile_force_field(
        field, scaling, rest.astype(np.float32), volume, frame_dt=0.04, frame_count=51
    )
    return [each for each in terms if isinstance(each, AxleBalance)]


def test_what_rolls_on_its_edge_is_kept_up_and_free_about_its_axle():
    rest = make_disc()
    (kept,) = keep_axle(rest)
    rolled = Rotation.from_euler("y", 200, degrees=True).apply(rest - rest.mean(0)) + (0.3, 0, 0.5)

    def turn(x, v):
        field = kept.acceleration(
            *(jnp.asarray(each, jnp.float32) for each in (x, v, np.ones(len(x)), 0.5, 1e-3))
        )
        r = x - x.mean(0)
        inertia = (r**2).sum() * np.eye(3) - r.T @ r
        return np.linalg.solve(inertia, np.cross(r, np.asarray(field, float)).sum(0))

    r = rolled - rolled.mean(0)
    np.testing.assert_allclose(turn(rolled, np.cross([0, 5.0, 0], r)), 0, atol=2e-2)
    leaning = Rotation.from_euler("x", 2, degrees=True)
    x = leaning.apply(r) + (0.3, 0, 0.5)
    wanted = [-np.sin(np.radians(2)) * 20.0**2, 0, 0]
    np.testing.assert_allclose(turn(x, np.zeros_like(x)), wanted, atol=0.02 * abs(wanted[0]))
    spun = turn(rolled, np.cross([0.1, 3.0, 0.2], r))
    np.testing.assert_allclose(spun, [-4.0, 0, -8.0], atol=0.05)


def test_only_a_disc_on_its_edge_is_kept_up():
    assert keep_axle(make_disc(axis=0), (1, 0, 0))
    assert not keep_axle(make_disc(axis=0)) and not keep_axle(TOWER)
