"""The compiler of intents: words -> force field and expectations, whoever wrote the words."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_jax.agents.compiler import compile_forces, compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.agents.intent import (
    Clause,
    Duration,
    Held,
    Intent,
    Part,
    Quantity,
    Relation,
    Repetition,
    Solid,
    Surroundings,
    Timing,
    Way,
)
from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ActionType
from physagent_jax.motion.schema import DirectionTable, MotionKind, SceneBrief

TABLE = DirectionTable(
    right=(1, 0, 0), left=(-1, 0, 0), up=(0, 0, 1), down=(0, 0, -1), toward=(0, -1, 0), away=(0, 1, 0)
)
# Seen from the world's +x side, with world up along y.
ROTATED = DirectionTable(
    right=(0, 0, -1), left=(0, 0, 1), up=(0, 1, 0), down=(0, -1, 0), toward=(1, 0, 0), away=(-1, 0, 0)
)


def make_brief(**changes) -> SceneBrief:
    facts = dict(object_name="robot", frame_count=50, frame_dt=0.04, directions=TABLE)
    return SceneBrief(**(facts | changes))


def compile_clauses(*clauses: Clause, brief: SceneBrief | None = None, **more) -> SemanticReply:
    return compile_forces(Intent(clauses=clauses, **more), brief or make_brief())


@pytest.mark.parametrize(
    "clause, kind, vector, sign",
    [
        (Clause(motion="push", ways=(Way(word="left"),)), ActionType.TRANSLATION, "left", 1),
        (Clause(motion="push", ways=(Way(word="to the left"),)), ActionType.TRANSLATION, "left", 1),
        (
            Clause(motion="push", ways=(Way(relation=Relation.FROM, word="left"),)),
            ActionType.TRANSLATION,
            "right",
            1,
        ),
        (
            Clause(motion="pull", ways=(Way(relation=Relation.FROM, word="left"),)),
            ActionType.TRANSLATION,
            "left",
            1,
        ),
        (Clause(motion="hit", parts=(Part(word="right side"),)), ActionType.IMPULSE, "left", 1),
        (Clause(motion="kick", ways=(Way(word="away from us"),)), ActionType.IMPULSE, "away", 1),
        (Clause(motion="", cause="wind", ways=(Way(word="toward"),)), ActionType.TRANSLATION, "toward", 1),
        (
            Clause(motion="stretch", ways=(Way(relation=Relation.ALONG, word="vertical"),)),
            ActionType.SCALE,
            "up",
            1,
        ),
        (Clause(motion="squeeze"), ActionType.SCALE, "right", -1),
        (Clause(motion="spin", turning="counterclockwise"), ActionType.TORQUE, "up", 1),
        (Clause(motion="spin", turning="clockwise"), ActionType.TORQUE, "down", 1),
        (Clause(motion="rotate", turning="counterclockwise"), ActionType.TORQUE, "toward", 1),
        (
            Clause(motion="rotate", turning="clockwise", seen_from="left"),
            ActionType.TORQUE,
            "right",
            1,
        ),
        (
            Clause(motion="turn", ways=(Way(relation=Relation.ABOUT, word="horizontal axis"),)),
            ActionType.TORQUE,
            "right",
            1,
        ),
        # In a horizontal plane: about the vertical.
        (
            Clause(motion="turn", ways=(Way(relation=Relation.IN, word="horizontal"),)),
            ActionType.TORQUE,
            "up",
            1,
        ),
    ],
)
@pytest.mark.parametrize("table", [TABLE, ROTATED], ids=["plain", "rotated"])
def test_directions_are_the_viewers(clause: Clause, kind, vector: str, sign: int, table) -> None:
    reply = compile_clauses(clause, brief=make_brief(directions=table))
    (action,) = reply.force_field.actions
    assert action.action_type is kind
    assert action.vector == pytest.approx(getattr(table, vector))
    assert math.copysign(1, action.magnitude) == sign
    assert not reply.unsure


def test_two_ways_are_added() -> None:
    reply = compile_clauses(Clause(motion="push", ways=(Way(word="up"), Way(word="left"))))
    assert reply.force_field.actions[0].vector == pytest.approx((-math.sqrt(0.5), 0, math.sqrt(0.5)))
    assert (
        compile_clauses(Clause(motion="push", ways=(Way(word="up left"),))).force_field == reply.force_field
    )


def test_the_other_way_and_back() -> None:
    first = Clause(motion="push", ways=(Way(word="right"),))
    for word in ("other", "back"):
        reply = compile_clauses(first, Clause(motion="push", ways=(Way(word=word),)))
        moves = [each.direction for each in reply.expectations]
        assert moves == [(1, 0, 0), (-1, 0, 0)]
    same = compile_clauses(first, Clause(motion="push", inherited=True, strength=("harder",)))
    assert [each.direction for each in same.expectations] == [(1, 0, 0), (1, 0, 0)]
    assert same.expectations[1].strength == pytest.approx(1.4)


@pytest.mark.parametrize(
    "words, strength",
    [
        ((), 1.0),
        (("gently",), 0.5),
        (("very", "gently"), 0.4),
        (("hard",), 1.3),
        (("violently",), 1.6),
        (("not hard",), 0.8),
    ],
)
def test_words_for_strength(words: tuple[str, ...], strength: float) -> None:
    reply = compile_clauses(Clause(motion="push", ways=(Way(word="left"),), strength=words))
    assert reply.expectations[0].strength == pytest.approx(strength)


@pytest.mark.parametrize(
    "motion, quantity, unit, value",
    [
        ("push", Quantity(value=2, unit="lengths"), "lengths", 2),
        ("move", Quantity(value=0.3, unit="metres"), "metres", 0.3),
        ("turn", Quantity(value=90, unit="degrees"), "degrees", 90),
        ("stretch", Quantity(value=0.5, unit="share", relation="by"), "factor", 1.5),
        ("squeeze", Quantity(value=0.25, unit="share", relation="by"), "factor", 0.75),
        ("stretch", Quantity(value=2, unit="share", dimension="height", relation="to"), "factor", 2),
    ],
)
def test_quantities_are_targets(motion: str, quantity: Quantity, unit: str, value: float) -> None:
    reply = compile_clauses(Clause(motion=motion, quantities=(quantity,)))
    amount = reply.expectations[0].amount
    assert amount is not None and amount.unit == unit and amount.value == pytest.approx(value)
    if quantity.dimension == "height":
        assert reply.expectations[0].direction == TABLE.up


@pytest.mark.parametrize(
    "quantity", [Quantity(value=5, unit="other", text="5 newtons"), Quantity(value=0, unit="lengths")]
)
def test_a_quantity_that_fits_nothing_is_a_doubt(quantity: Quantity) -> None:
    reply = compile_clauses(Clause(motion="push", quantities=(quantity,)))
    assert reply.unsure and reply.expectations[0].amount is None


def test_counted_turns_are_an_angle_and_a_somersault_is_a_whole_one() -> None:
    counted = compile_clauses(Clause(motion="spin", repetitions=(Repetition(times=3),)))
    assert counted.expectations[0].amount is not None and counted.expectations[0].amount.value == 1080
    once = compile_clauses(Clause(motion="somersault"))
    assert once.expectations[0].amount is not None and once.expectations[0].amount.value == 360


def test_times() -> None:
    brief = make_brief(frames_fixed=True, frame_count=101)  # 4 s
    told = Timing(starts=Duration(value=1), lasts=Duration(value=25, unit="frames"))
    reply = compile_clauses(Clause(motion="push", ways=(Way(word="left"),), timing=told), brief=brief)
    assert reply.force_field.actions[0].active_time == (25, 50)
    half = Timing(lasts=Duration(value=0.5, unit="clip"))
    reply = compile_clauses(Clause(motion="push", ways=(Way(word="left"),), timing=half), brief=brief)
    assert reply.force_field.actions[0].active_time == (0, 50)


def test_order_of_clauses() -> None:
    push, spin = Clause(motion="push", ways=(Way(word="left"),)), Clause(motion="spin")
    windows = [
        [each.window for each in compile_clauses(push, spin.model_copy(update={"order": order})).expectations]
        for order in ("then", "together", "and")
    ]
    assert windows[0][0][1] <= windows[0][1][0]
    assert windows[1][0] == windows[1][1] and windows[2] == windows[1]
    pull = Clause(motion="pull", ways=(Way(word="right"),), order="and")  # would cancel: one after the other
    contrary = [each.window for each in compile_clauses(push, pull).expectations]
    assert contrary[0][1] <= contrary[1][0]


@pytest.mark.parametrize(
    "word, end, start",
    [("head", "up", 0.72), ("the top", "up", 2 / 3), ("upper half", "up", 0.5), ("left end", "left", 0.8)],
)
def test_parts(word: str, end: str, start: float) -> None:
    reply = compile_clauses(Clause(motion="push", ways=(Way(word="away"),), parts=(Part(word=word),)))
    (action,), (expected,) = reply.force_field.actions, reply.expectations
    assert expected.part == getattr(TABLE, end) and expected.partial
    reach = sum(p * n for p, n in zip(action.region.point, action.region.normal, strict=True))
    middle = 0.5 * sum(action.region.normal)
    assert reach - middle == pytest.approx(start - 0.5, abs=1e-5)


def test_all_but_a_part() -> None:
    part = Part(word="head", excluded=True)
    (expected,) = compile_clauses(Clause(motion="push", parts=(part,))).expectations
    assert expected.excludes_part and expected.part == TABLE.up


def test_holding_what_was_moved_and_what_was_not() -> None:
    squeeze = Clause(motion="squeeze")
    reply = compile_clauses(squeeze, Clause(motion="hold"))
    assert reply.expectations[0].stays and reply.anchor.kind is None
    kept = compile_clauses(squeeze, Clause(motion="squeeze", stays=True))  # "squeeze it and keep it squeezed"
    assert [each.stays for each in kept.expectations] == [True]
    reply = compile_clauses(Clause(motion="hold", parts=(Part(word="bottom"),)), squeeze)
    assert reply.anchor.kind == "base" and not reply.expectations[0].stays
    held = compile_forces(Intent(clauses=(squeeze,), held=Held(end="top", text="hanging")), make_brief())
    assert (held.anchor.kind, held.anchor.words) == ("top", "hanging")


def test_surroundings() -> None:
    wall = Solid(sides=("right",), text="the wall on the right")
    clause = Clause(motion="push", solids=(wall,))
    reply = compile_clauses(clause, surroundings=Surroundings(gravity="none", ground=False, text="in space"))
    assert reply.force_field.actions[0].vector == TABLE.right
    assert [each.direction for each in reply.world.obstacles] == [TABLE.right]
    assert (reply.world.gravity, reply.world.ground) == ("none", False)
    fall = compile_forces(Intent(surroundings=Surroundings(gravity="up")), make_brief())
    assert fall.expectations[0].kind is MotionKind.FALL and fall.expectations[0].direction == TABLE.up


def test_what_does_not_happen() -> None:
    reply = compile_clauses(Clause(motion="push", negated=True))
    assert not reply.force_field.actions and reply.expectations[0].kind is MotionKind.STILL
    assert any("negated" in note for note in reply.notes)


def test_what_an_intent_leaves_aside_is_passed_on() -> None:
    intent = Intent(
        clauses=(Clause(motion="push", ways=(Way(word="left"),)),),
        materials=("jelly",),
        ignored=("red", "studio"),
        unknown=("frobnicate",),
        doubts=("Which way it faces is not understood.",),
        notes=("'castle' is taken to be the object.",),
    )
    reply = compile_forces(intent, make_brief())
    assert (reply.materials, reply.ignored, reply.not_understood) == (
        ("jelly",),
        ("red", "studio"),
        ("frobnicate",),
    )
    assert reply.unsure == ("Which way it faces is not understood.", "'frobnicate' is not understood.")
    assert "'castle' is taken to be the object." in reply.notes
    calm = compile_forces(intent.model_copy(update={"unknown": (), "doubts": ()}), make_brief())
    assert not calm.unsure


def test_evidence_quotes_the_sentence() -> None:
    clause = Clause(
        motion="push",
        said="pushes",
        ways=(Way(word="left", text="to the left"),),
        strength=("gently",),
        parts=(Part(word="head", text="its head"),),
        timing=Timing(lasts=Duration(value=1, text="for a second")),
    )
    told = {item.field: item.words for item in compile_clauses(clause).evidence}
    assert told == {
        "actions[0].action_type": "pushes",
        "actions[0].vector": "to the left",
        "actions[0].magnitude": "gently",
        "actions[0].region": "its head",
        "actions[0].active_time": "for a second",
    }


def test_what_goes_elsewhere_leaves_its_place() -> None:
    push = Clause(motion="push", ways=(Way(word="left"),))
    for elsewhere in (False, True):
        reply = compile_clauses(push.model_copy(update={"elsewhere": elsewhere}))
        assert reply.expectations[0].leaves_place is elsewhere


def test_words_that_nobody_knows_are_doubts() -> None:
    clause = Clause(
        motion="push",
        cause="gnome",
        ways=(Way(word="left"), Way(word="widdershins")),
        parts=(Part(word="flange"),),
        strength=("quasi",),
    )
    reply = compile_clauses(clause, Clause(motion="frobnicate"))
    for word in ("widdershins", "flange", "quasi", "frobnicate"):
        assert any(word in doubt for doubt in reply.unsure), word
    assert reply.force_field.actions[0].vector == TABLE.left


def test_an_unknown_motion_alone_is_refused_with_the_nearest_known_ones() -> None:
    with pytest.raises(UserError, match="'pusch'") as refused:
        compile_clauses(Clause(motion="pusch"))
    assert "'push'" in str(refused.value)
    with pytest.raises(UserError, match="names no motion"):
        compile_forces(Intent(), make_brief())


def test_words_in_the_wrong_place_are_understood() -> None:
    """As language models write them: a sense among the ways, two words for one strength, a side."""
    turned = compile_clauses(Clause(motion="spin it", ways=(Way(word="clockwise"),)))
    assert turned.force_field.actions[0].vector == TABLE.down and not turned.unsure
    pushed = compile_clauses(
        Clause(motion="push", ways=(Way(word="the left side"),), strength=("very gently",))
    )
    assert pushed.force_field.actions[0].vector == TABLE.left and not pushed.unsure
    assert pushed.expectations[0].strength == 0.4
    assert compile_clauses(Clause(motion="let it go")).force_field.default_drop


@pytest.mark.parametrize("motion", ["pushes", "Pushing", "pushed", "the push"])
def test_inflected_motions_are_known(motion: str) -> None:
    assert (
        compile_clauses(Clause(motion=motion)).force_field
        == compile_clauses(Clause(motion="push")).force_field
    )


@pytest.mark.parametrize(
    "sentence, clauses",
    [
        (
            "push the robot gently to the left",
            [dict(motion="push", ways=[dict(word="left")], strength=["gently"])],
        ),
        (
            "hit its head from the right, then turn it clockwise by 90 degrees",
            [
                dict(motion="hit", parts=[dict(word="head")], ways=[dict(word="right", relation="from")]),
                dict(motion="turn", turning="clockwise", quantities=[dict(value=90, unit="degrees")]),
            ],
        ),
        (
            "stretch it to twice its height and hold it there",
            [
                dict(
                    motion="stretch",
                    quantities=[dict(value=2, unit="share", dimension="height", relation="to")],
                    stays=True,
                )
            ],
        ),
        (
            "shake it three times for 2 seconds",
            [dict(motion="shake", repetitions=[dict(times=3)], timing=dict(lasts=dict(value=2)))],
        ),
    ],
)
def test_equal_words_give_equal_fields_whoever_wrote_them(sentence: str, clauses: list[dict]) -> None:
    brief = make_brief()
    by_hand = Intent.model_validate_json(Intent.model_validate(dict(clauses=clauses)).model_dump_json())
    read, told = compile_forces(read_intent(sentence, brief), brief), compile_forces(by_hand, brief)
    assert read.force_field == told.force_field
    kinds = [(each.kind, each.direction, each.window, each.amount, each.stays) for each in read.expectations]
    assert kinds == [(e.kind, e.direction, e.window, e.amount, e.stays) for e in told.expectations]


def test_an_intent_survives_json() -> None:
    intent = read_intent(
        "push it left by 30 cm, then squeeze its top twice; there is a wall on the left", make_brief()
    )
    assert Intent.model_validate_json(intent.model_dump_json()) == intent
    assert {clause.motion for clause in intent.clauses} == {"push", "squeeze"}


def _make_words(*tables) -> st.SearchStrategy[str]:
    known = sorted({phrase for table in tables for phrase in table})
    return st.one_of(st.sampled_from(known), st.sampled_from(known), st.text(max_size=12))


_LEX = read_lexicon()
_DIRECTIONS = st.sampled_from(["left", "right", "up", "down", "toward", "away"])
_WAY_WORDS = _make_words(
    _LEX.directions, _LEX.axes, _LEX.planes, _LEX.sides, _LEX.reversals, ("back", "same", "x", "long axis")
)
_DURATIONS = st.builds(
    Duration, value=st.floats(-1e6, 1e6), unit=st.sampled_from(["seconds", "frames", "clip"])
)
_QUANTITIES = st.builds(
    Quantity,
    value=st.one_of(st.floats(0, 4), st.floats(0, 1e9)),
    unit=st.sampled_from(["degrees", "lengths", "metres", "share", "other"]),
    dimension=st.sampled_from(
        ["", "length", "height", "width", "depth", "size", "volume", "far", "strength"]
    ),
    relation=st.sampled_from(["", "by", "to", "is"]),
)
_SOLIDS = st.builds(
    Solid,
    kind=st.sampled_from(["wall", "block"]),
    sides=st.lists(_DIRECTIONS, max_size=3).map(tuple),
    opposite=st.lists(_DIRECTIONS, max_size=2).map(tuple),
)


def _make_tuples(values: st.SearchStrategy, most: int = 3) -> st.SearchStrategy[tuple]:
    return st.lists(values, max_size=most).map(tuple)


_CLAUSES = st.builds(
    Clause,
    motion=_make_words(_LEX.motions, _LEX.causes),
    cause=st.one_of(st.none(), _make_words(_LEX.causes, ("gravity",))),
    order=st.sampled_from(["then", "together", "and"]),
    ways=_make_tuples(st.builds(Way, relation=st.sampled_from(Relation), word=_WAY_WORDS)),
    turning=st.sampled_from([None, "clockwise", "counterclockwise"]),
    seen_from=st.one_of(st.none(), _DIRECTIONS),
    parts=_make_tuples(
        st.builds(
            Part, word=_make_words(_LEX.parts, _LEX.part_adjectives, ("left arm",)), excluded=st.booleans()
        ),
        2,
    ),
    strength=_make_tuples(_make_words(_LEX.intensities, _LEX.degrees, _LEX.comparatives, ("not hard",))),
    quantities=_make_tuples(_QUANTITIES, 2),
    timing=st.builds(
        Timing,
        starts=st.one_of(st.none(), _DURATIONS),
        lasts=st.one_of(st.none(), _DURATIONS),
        within=st.booleans(),
        overall=st.booleans(),
    ),
    repetitions=_make_tuples(
        st.builds(
            Repetition,
            times=st.one_of(st.none(), st.integers(0, 1_000_000)),
            often=st.booleans(),
            alternating=st.booleans(),
            first=st.one_of(st.none(), _DIRECTIONS),
        ),
        2,
    ),
    solids=_make_tuples(_SOLIDS, 1),
    negated=st.sampled_from([False, False, False, True]),
    inherited=st.booleans(),
    stays=st.booleans(),
    pace=st.sampled_from(["", "even", "sudden"]),
)
_INTENTS = st.builds(
    Intent,
    clauses=_make_tuples(_CLAUSES, 4),
    held=st.one_of(st.none(), st.builds(Held, end=st.sampled_from(["base", "top", "none"]))),
    surroundings=st.builds(
        Surroundings,
        gravity=st.sampled_from([None, "down", "up", "none"]),
        ground=st.sampled_from([None, True, False]),
        solids=_make_tuples(_SOLIDS, 1),
    ),
)
_BRIEFS = st.builds(
    make_brief,
    object_kind=st.sampled_from(["object", "plant", "food"]),
    anchored=st.sampled_from([None, "the base", "the top"]),
    frame_count=st.sampled_from([1, 2, 3, 50, 10_000]),
    frames_fixed=st.booleans(),
    frame_dt=st.sampled_from([1e-6, 0.04, 1.0]),
    long_axis=st.sampled_from([None, (1.0, 0.0, 0.0)]),
    world=st.sampled_from(["ground", "free"]),
    directions=st.sampled_from([TABLE, ROTATED]),
)


@settings(max_examples=150, deadline=None)
@given(intent=_INTENTS, brief=_BRIEFS)
def test_every_intent_compiles_or_is_refused(intent: Intent, brief: SceneBrief) -> None:
    try:
        reply = compile_intent(intent, brief)
    except UserError as refused:
        assert not intent.held and intent.surroundings.gravity is None
        assert refused.do
        return
    assert SemanticReply.model_validate_json(reply.model_dump_json()).expectations
    last = (reply.frame_count or brief.frame_count) - 1
    for action in reply.force_field.actions:
        assert math.hypot(*action.vector) == pytest.approx(1)
        assert action.active_time is None or 0 <= action.active_time[0] < action.active_time[1] <= last
