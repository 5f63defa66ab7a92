"""Motions that viewers take for what was asked, or do not, beyond the plain kinds."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.posing import find_last_lean, tells_pose
from physagent_jax.motion.judging.seen import View, count_excursions
from physagent_jax.motion.judging.verdict import judge as judge_view
from physagent_jax.motion.matching import is_last_rest
from physagent_jax.motion.schema import MotionKind, Verdict
from physagent_jax.perception.schema import Box, Extent
from tests.agents.scenes import asked, brief, judge, ramp, read
from tests.agents.test_planner import along, ends, expected, show

AWAY, DOWN, LEFT, RIGHT, UP = (0, 1, 0), (0, 0, -1), (-1, 0, 0), (1, 0, 0), (0, 0, 1)
GROUND = brief(world="ground", extents=(0.4, 1.0, 0.4))
KINDS, LAST = MotionKind, 48


def verdict(sentence, expectations, seen, scene=GROUND):
    reply = SemanticReply(force_field=ForceField(), expectations=tuple(expectations))
    judgement = judge(sentence, reply, seen, scene).judgement
    return judgement.verdict is Verdict.SUCCESS


def hop(t, height=0.4):
    return 0, 0, height * abs(math.sin(3 * math.pi * t / LAST))


def test_what_is_loose_may_flap_where_it_leaps():
    """The shape by 0.7 for a while; of what only sways aside that is too much."""

    def flap(t):
        return np.multiply((0.7, -0.2, -0.2), 1.0 if 10 < t < 20 else 0.0)

    leaps = expected(KINDS.SWAY, UP, repeats=3)
    assert verdict("it jumps up and down three times", [leaps], show(hop, strain=flap))
    aside = show(lambda t: (0.1 * math.sin(6 * math.pi * t / LAST), 0, 0), strain=flap)
    assert not verdict("it sways three times", [expected(KINDS.SWAY, RIGHT, repeats=3)], aside)


def test_a_gentle_push_sets_no_end_to_rolling():
    gentle = dict(strength=0.5, words="roll it gently")
    roll = expected(direction=RIGHT, **gentle), expected(KINDS.ROTATE, AWAY, **gentle)
    assert verdict("roll it gently to the right", roll, show(along(RIGHT, 0.6), along(AWAY, 120)))
    assert not verdict("turn it gently", roll[1:], show(turn=along(AWAY, 120)), brief())


def test_a_slow_turn_may_go_far_in_a_long_clip():
    scene = brief(frame_count=100)
    slow = expected(KINDS.ROTATE, UP, strength=0.5, window=(0, 99))
    seen = show(turn=lambda t: np.multiply(UP, 100 * ramp(t, 0, 99)), count=100)
    assert verdict("turn it gently", [slow], seen, scene)


@pytest.mark.parametrize(("back_at", "right"), [(40, True), (16, False)])
def test_what_was_kicked_may_come_rolling_back_once_it_was_away(back_at, right):
    kicked = [expected(direction=AWAY, sudden=True, strength=1.3)]

    def place(t):
        return np.multiply(AWAY, 1.2 * min(t / 8, 1.0) - 1.2 * ramp(t, back_at, back_at + 8))

    assert verdict("kick it", kicked, show(place)) is right
    assert not verdict("push it", [expected(direction=AWAY, strength=1.3)], show(place))


@pytest.mark.parametrize("figure", ["strain", "turn", "place"])
def test_any_change_that_comes_and_goes_is_a_wobble(figure):
    wave = lambda t, size: size * math.sin(6 * math.pi * t / LAST) * math.exp(-t / 40)  # noqa: E731
    ways = dict(
        strain=lambda t: (wave(t, -0.06), wave(t, -0.06), wave(t, 0.25)),
        turn=lambda t: (0, wave(t, 14.0), 0),
        place=lambda t: (0, 0, wave(t, 0.12)),
    )
    sway = expected(KINDS.SWAY, LEFT, repeats=3, manner="bend", jiggles=True, strength=0.8)
    once = dict(
        strain=lambda t: np.multiply((-0.06, -0.06, 0.25), ramp(t, 0, 9)),
        turn=lambda t: np.multiply((0, 14, 0), ramp(t, 0, 9)),
        place=lambda t: np.multiply((0, 0, 0.12), ramp(t, 0, 9)),
    )
    assert verdict("the jelly wobbles", [sway], show(**{figure: ways[figure]}))
    assert not verdict("the jelly wobbles", [sway], show(**{figure: once[figure]})), "it comes, and stays"
    faint = {figure: lambda t: np.multiply(0.1, ways[figure](t))}
    assert not verdict("the jelly wobbles", [sway], show(**faint))


def test_what_falls_wobbles_from_where_it_lands():
    """Its planned time for the wobble is later; by then it stands."""
    motions = (
        expected(KINDS.FALL, None, window=(0, 30)),
        expected(KINDS.SWAY, LEFT, repeats=3, manner="bend", jiggles=True, window=(30, LAST)),
    )

    def strain(t):
        return np.multiply((-0.1, -0.1, 0.25), math.sin(math.pi * (t - 10) / 4) if 10 < t < 28 else 0.0)

    assert verdict("it drops and wobbles", motions, show(along(DOWN, 0.5, 0, 10), strain=strain))
    assert not verdict("it drops and wobbles", motions, show(along(DOWN, 0.5, 0, 10)))


@pytest.mark.parametrize(
    ("sentence", "right"), [("it sways in the wind", True), ("it sways three times", False)]
)
def test_nobody_counts_what_no_number_is_told_of(sentence, right):
    (told, *_) = read(sentence, brief(world="ground", anchored="base")).expectations
    sways = [expected(KINDS.SWAY, RIGHT, repeats=3, counted=told.counted)]
    seen = show(lambda t: (0.1 * math.sin(4 * math.pi * t / LAST), 0, 0))
    assert verdict(sentence, sways, seen) is right


@pytest.mark.parametrize(
    ("sentence", "lean", "right"),
    [
        ("it hops and lands on its feet", 10, True),
        ("it hops and lands on its feet", 90, False),
        ("the robot hops", 90, False),
        ("it wobbles but does not fall over", 80, False),
        ("throw the robot up", 90, True),
        ("the robot jumps and lands on its side", 90, True),
        ("the robot jumps and lands on its side", 170, False),
    ],
)
def test_a_leap_ends_as_the_sentence_says(sentence, lean, right):
    leap = expected(direction=UP, sudden=True, words="hops", window=(0, 20))
    fall = expected(KINDS.FALL, None, window=(20, LAST), words="hops")

    def place(t):
        return 0, 0, 0.6 * 4 * (t / 30) * (1 - t / 30) if t < 30 else 0.0

    seen = show(place, turn=along(AWAY, lean, 10, 40))
    assert verdict(sentence, (leap, fall), seen) is right


@pytest.mark.parametrize("topples", [False, True])
def test_what_topples_after_it_has_landed_need_not_stand(topples):
    prompt = "the robot jumps and lands on its feet" + ", and then topples onto its face" * topples
    motions = read(prompt, GROUND).expectations
    last = round(max(each.window[1] for each in motions))
    seen = show(turn=along(AWAY, 90, 60, 90), count=last + 1)
    judged = judge(prompt, SemanticReply(force_field=ForceField(), expectations=motions), seen, GROUND)
    assert any("does it stand" in each.question for each in judged.judgement.checks) is not topples


def test_the_true_end_decides_how_it_is_left():
    """At the last planned frame it stands; in the frames after it goes over."""
    sways = [expected(KINDS.SWAY, RIGHT, repeats=2)]
    seen = show(lambda t: (0.1 * math.sin(4 * math.pi * t / LAST), 0, 0))
    after = show(turn=along(AWAY, 85, 0, 20), count=25)
    reply = SemanticReply(force_field=ForceField(), expectations=tuple(sways))
    context = asked("it wobbles but does not fall", GROUND, reply)
    observation = judge(context.prompt, reply, seen, GROUND)
    assert observation.judgement.verdict is Verdict.SUCCESS
    watched = dataclasses.replace(observation, ending=after)
    assert RulePlanner().watches_ending(context)
    assert RulePlanner().judge(context, watched).value.verdict is Verdict.FAIL
    view = View(seen, GROUND, tuple(sways), ForceField(), ending=after)
    assert find_last_lean(view) == pytest.approx(85, abs=1e-6)


@pytest.mark.parametrize(
    ("sentence", "tells"),
    [
        ("the robot tips over", True),
        ("the robot hops", True),
        ("push the robot to the left", False),
        ("spin the robot around", False),
    ],
)
def test_only_who_tells_a_pose_has_the_ending_looked_at(sentence, tells):
    assert tells_pose(sentence, read(sentence, GROUND).expectations, GROUND) is tells
    assert not tells_pose(sentence, read(sentence).expectations, brief())


@pytest.mark.parametrize(
    ("turned", "manner", "right"),
    [(0, "hinge", False), (30, "hinge", True), (0, "", True)],
)
def test_what_opens_turns(turned, manner, right):
    held = brief(world="ground", anchored="base")
    opens = [expected(direction=UP, part=UP, manner=manner, strength=0.6)]
    parts = ends((0, 0, 0.15), (0, 0, 0), turn_top=(turned, 0, 0))
    seen = show(along(UP, 0.05), parts=parts)
    assert verdict("", opens, seen, held) is right


@pytest.mark.parametrize(("metres", "cut"), [(1.0, 1.0), (3.0, 0.95 * 1.4)])
def test_a_way_without_room_is_cut_and_judged_so(metres, cut):
    scene = brief(world="ground", extents=(0.5, 1.0, 0.5), reach=1.9)
    reply = read(f"throw the robot {metres:g} metres up into the air", scene)
    amount = reply.expectations[0].amount
    assert amount is not None and amount.unit == "metres" and amount.value == pytest.approx(cut)
    assert any("there is room for" in note for note in reply.notes) is (cut < metres)
    seen = show(lambda t: (0, 0, cut * 4 * (t / 40) * (1 - t / 40) if t < 40 else 0.0))
    expectations = [reply.expectations[0].model_copy(update=dict(window=(0, 24)))]
    assert verdict("throw it", expectations, seen, scene)


def test_room_is_less_along_a_longer_side():
    scene = brief(extents=(1.0, 0.4, 0.4), reach=1.9)
    assert scene.find_room(RIGHT) == pytest.approx(1.4) and scene.find_room(UP) == pytest.approx(1.7)


def arcs(*heights, each=12):
    """Leaps of these heights, one after another."""

    def place(t):
        k, phase = divmod(t / each, 1.0)
        return 0, 0, 4 * heights[int(k)] * phase * (1 - phase) if k < len(heights) else 0.0

    return show(place)


@pytest.mark.parametrize(
    ("heights", "right"),
    [
        ((0.4, 0.12, 0.4, 0.12), True),
        ((0.3, 0.15, 0.15, 0.08), True),
        ((0.4, 0.4, 0.4, 0.4), False),
        ((0.4, 0.02), False),
    ],
)
def test_rebounds_are_counted_as_leaps_only_where_leaps_lack(heights, right):
    leaps = (
        expected(direction=UP, sudden=True, repeats=2, words="hop"),
        expected(KINDS.FALL, None, window=(24, LAST), words="hop"),
    )
    assert verdict("it hops twice", leaps, arcs(*heights)) is right


@pytest.mark.parametrize(
    ("rises", "counted", "right"),
    [
        ((0.4, 0.2), True, True),
        ((0.4, 0.02), True, False),
        ((0.4, 0.02), False, True),
        ((), False, False),
        ((-0.2,), False, False),  # it is pressed together and springs back
    ],
)
def test_bounces_are_counted_above_where_it_comes_to_rest(rises, counted, right):
    fall = expected(KINDS.FALL, None, rebounds=2, counted=counted)

    def place(t):
        if t < 12:
            return 0, 0, -((t / 12) ** 2)
        k, phase = divmod((t - 12) / 9, 1.0)
        return 0, 0, -1.0 + (4 * rises[int(k)] * phase * (1 - phase) if k < len(rises) else 0.0)

    assert verdict("it is dropped and bounces", [fall], show(place)) is right


@pytest.mark.parametrize(
    ("sentence", "right"),
    [
        ("the robot is dropped", False),
        ("the rubber robot is dropped", True),
        ("the robot is dropped and flops onto the ground", True),
    ],
)
def test_what_is_soft_or_flops_may_change_its_shape_as_it_lands(sentence, right):
    def squash(t):
        return np.multiply((1.4, 0.2, -0.5), 1.0 if 14 < t < 24 else 0.0)

    seen = show(lambda t: (0, 0, -min((t / 14) ** 2, 1.0)), strain=squash)
    assert verdict(sentence, [expected(KINDS.FALL, None)], seen) is right


def test_leaps_to_one_side_are_counted_by_their_heights():
    """Along the way that they go nothing comes back."""
    way = (math.sqrt(0.5), 0.0, math.sqrt(0.5))
    leaps = (
        expected(direction=way, sudden=True, repeats=2, words="hop"),
        expected(KINDS.FALL, None, window=(24, LAST), words="hop"),
    )

    def place(t, each=12, height=0.3):
        k, phase = divmod(t / each, 1.0)
        return min(t / (2 * each), 1.0), 0, 4 * height * phase * (1 - phase) if k < 2 else 0.0

    assert verdict("it hops to the right twice", leaps, show(place))


def test_what_springs_back_on_the_ground_may_leap_up():
    """Its shape is lost from sight as it does; its outline tells that it came back."""
    press = expected(KINDS.SQUEEZE, UP, window=(0, 24), released=True)
    depth = lambda t: 0.3 * ramp(t, 0, 20) * (1 - ramp(t, 24, 26))  # noqa: E731
    known = [(0.3 * depth(t), 0.3 * depth(t), -depth(t)) for t in range(LAST + 1)]
    seen = show(lambda t: (0, 0, 0.8 * ramp(t, 26, 36) if t < 36 else 0.8), strain=lambda t: known[t])
    outline = Extent(
        direction=UP,
        ratio=tuple(1.0 - depth(t) for t in range(LAST + 1)),
        half_width=(0.02,) * 25 + (None,) * (LAST - 24),
    )
    lost = tuple(each if t < 25 else None for t, each in enumerate(seen.stretch))
    seen = seen.model_copy(update=dict(stretch=lost, extents=(outline,)))
    assert verdict("squash it flat and let it spring back", [press], seen)
    flat = seen.model_copy(
        update=dict(extents=(outline.model_copy(update=dict(ratio=outline.ratio[:21] + (0.7,) * 28)),))
    )
    assert not verdict("squash it flat and let it spring back", [press], flat)


@pytest.mark.parametrize(
    ("strength", "degrees", "right"), [(0.6, 60, True), (0.4, 60, False), (0.6, 4, False)]
)
def test_what_opens_slowly_may_open_wide(strength, degrees, right):
    held = brief(world="ground", anchored="base")
    opens = [expected(KINDS.ROTATE, RIGHT, part=UP, manner="hinge", strength=strength)]
    seen = show(parts=ends((0, 0, 0.05), (0, 0, 0), turn_top=(degrees, 0, 0)))
    assert verdict("", opens, seen, held) is right


@pytest.mark.parametrize(("change", "right"), [(0.01, True), (0.4, False)])
def test_a_shape_that_no_outline_shows_is_not_out_of_shape(change, right):
    """Of a flat thing that is seen aslant the points do not tell the thickness."""
    lines = [
        Extent(direction=axis, ratio=(1.0, *(1.0 + change,) * LAST), half_width=(0.02,) * (LAST + 1))
        for axis in (UP, RIGHT)
    ]
    leap = expected(KINDS.SWAY, UP, repeats=3)
    seen = show(hop, strain=along((0, -0.9, 0), 1.0), extents=tuple(lines))
    assert verdict("it bounces three times", [leap], seen) is right


@pytest.mark.parametrize(("size", "right"), [(1.0, True), (1.6, False)])
def test_the_box_around_what_turns_grows_without_a_burst(size, right):
    """Of a cube that is turned about two axes it grows by a half."""
    corners = np.array(np.meshgrid(*[(-0.3, 0.3)] * 3)).reshape(3, -1).T

    def turn(t):
        return np.multiply((0.5, 0.7, 0.0), 90 * ramp(t, 0, 30))

    seen = show(along(RIGHT, 0.5), turn)
    boxes = []
    for t in range(LAST + 1):
        there = Rotation.from_rotvec(np.radians(turn(t))).apply(corners) * (size if t > 20 else 1.0)
        boxes.append(Box(low=tuple(there.min(0).tolist()), high=tuple(there.max(0).tolist())))
    assert boxes[24].high[0] > 1.5 * boxes[0].high[0] or size > 1.0
    tumbles = (expected(direction=RIGHT, words="roll"), expected(KINDS.ROTATE, None, words="roll"))
    seen = seen.model_copy(update=dict(box=tuple(boxes)))
    assert verdict("it rolls to the right", tumbles, seen) is right


@pytest.mark.parametrize(
    ("degrees", "count"),
    [((0, 0), 0), ((0, 180), 1), ((0, 360), 2), ((0, 720), 4), ((0, 90), 0), ((0, 20), 0)],
)
def test_the_height_of_a_turning_rods_outline_tells_its_half_turns(degrees, count):
    """A rod of length 1 and width 0.3 is as high as |cos| + 0.3 |sin| of its angle."""
    angles = np.radians(np.linspace(*degrees, 200))
    heights = np.abs(np.cos(angles)) + 0.3 * np.abs(np.sin(angles))
    assert count_excursions(heights - 1.0, 0.12) == count


@pytest.mark.parametrize(("degrees", "count"), [(360, 2), (25, 0)])
def test_what_is_squashed_as_it_lands_has_not_turned_over(degrees, count):
    """A leap of jelly was a somersault to whoever counted the changes of its outline on the ground as well."""
    flight = lambda t: min(t / 24, 1.0)  # noqa: E731
    seen = show(
        lambda t: (0, 0, 4 * flight(t) * (1 - flight(t))), turn=lambda t: (min(degrees * flight(t), 40), 0, 0)
    )
    angle = [math.radians(degrees * flight(t)) for t in range(LAST + 1)]
    squash = [0.3 * math.exp(-(((t - 28) / 2) ** 2)) if t >= 24 else 0.0 for t in range(LAST + 1)]
    ratio = tuple(abs(math.cos(a)) + 0.3 * abs(math.sin(a)) - b for a, b in zip(angle, squash))
    outline = Extent(direction=UP, ratio=ratio, half_width=(0.02,) * (LAST + 1))
    plan = (expected(KINDS.MOVE, UP, sudden=True), expected(KINDS.ROTATE, RIGHT))
    view = View(seen.model_copy(update=dict(extents=(outline,))), GROUND, plan, ForceField())
    assert view.is_aloft(plan[1]) and view.count_half_turns() == count


def rock(left: float):
    """A turn to and fro, of which a share is left in the end."""
    return lambda t: (0.0, 60.0 * (left if t > 70 else 1.0) * math.sin(0.5 * t), 0.0)


STIRS = [
    (None, rock(0.08), True),
    (along(RIGHT, 1.0, 0, 60), None, True),
    (lambda t: (0.06 * min(t, 60) + 0.003 * max(t - 60, 0), 0, 0), None, True),
    (None, rock(0.5), False),
    (lambda t: (0.01 * t, 0, 0), None, False),
    (None, lambda t: (0, 0, 3.0 * t), False),
]


@pytest.mark.parametrize(("place", "turn", "still"), STIRS)
def test_what_hardly_moves_beside_what_it_did_has_come_to_rest(place, turn, still):
    """It is looked for at the end alone; what goes on as before is no rest."""
    motions = [expected(window=(0, 20)), expected(KINDS.STILL, None, window=(20, 90))]
    view = View(show(place, turn, count=91), GROUND, tuple(motions), ForceField())
    assert is_still(view) is still


@pytest.mark.parametrize(
    ("after", "still"), [(None, True), (along(RIGHT, 0.2, 0, 24), False), (along(RIGHT, 0.03, 0, 5), False)]
)
def test_what_stops_after_the_planned_frames_is_still(after, still):
    """The frames after them may be cut short: speed tells, not the way."""
    motions = [expected(window=(0, 20)), expected(KINDS.STILL, None, window=(20, 60))]
    view = View(show(along(RIGHT, 1.2, 0, 60), count=61), GROUND, tuple(motions), ForceField())
    assert not is_still(view)
    count = 6 if after and after(5)[0] > 0.02 else 25
    assert is_still(dataclasses.replace(view, ending=show(after, count=count))) is still


def is_still(view: View) -> bool | None:
    return next(check.passed for check in judge_view(view).checks if check.aspect == "stillness")


@pytest.mark.parametrize(
    ("sentence", "rests"),
    [
        ("the robot rolls to the right and then comes to a stop", True),
        ("the robot wobbles until it settles", True),
        ("the robot moves right, stops, and then jumps", False),
        ("the robot moves right, then stays still for 2 seconds", False),
    ],
)
def test_a_rest_is_looked_at_to_the_true_end(sentence, rests):
    """Save one that is told its length, which is a rest for so long."""
    motions = read(sentence, GROUND).expectations
    assert any(is_last_rest(each, motions) for each in motions) is rests
    context = asked(sentence, GROUND, read(sentence, GROUND))
    assert RulePlanner().watches_ending(context) >= rests
