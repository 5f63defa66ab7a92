"""The hard rules: each repairs what it is about and leaves what obeys it alone."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_jax.agents.hard_rules import RULES, apply_hard_rules, base_directions
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.motion.vectors import cosine
from tests.agents.scenes import brief, read, table
from tests.agents.sentences import SENTENCES

LEFT, RIGHT, UP = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def action(kind="translation", vector=LEFT, magnitude=1.0, active_time=(0, 48), **more) -> dict:
    return {
        "action_type": kind, "vector": list(vector), "magnitude": magnitude, "active_time": list(active_time), **more
    }  # fmt: skip


def slab(vector, normal, **more) -> dict:
    region = {"kind": "half_space", "point": [0.5 + 0.35 * c for c in normal], "normal": list(normal)}
    values = {
        "constraint_type": "enforce_particle_translation",
        "vector": list(vector),
        "magnitude": 1.0,
        "region": region,
    }
    return values | more


def mended(*actions, constraints=(), expectations=(), scene=None, **extra):
    raw = {"actions": list(actions), "constraints": list(constraints), **extra}
    field, repairs = apply_hard_rules(raw, scene or brief(), expectations)
    return field, [repair.rule for repair in repairs]


@pytest.mark.parametrize("row", SENTENCES[::3], ids=lambda row: row[0])
def test_what_the_semantic_agent_writes_needs_no_repair(row):
    """The rules change nothing in the offline agent's own force fields."""
    scene = brief(anchored="base" if row[1] else None)
    reply = read(row[0], scene)
    assert apply_hard_rules(reply.force_field, scene, reply.expectations) == (reply.force_field, ())


@pytest.mark.parametrize(
    ("given_", "kept"),
    [(3.0, 1.6), (-3.0, -1.6), (0.1, 0.4), (-0.1, -0.4), (0, 0.4), ("much", 1.0), (None, 1.0), (1.2, 1.2)],
)
def test_magnitude_range(given_, kept):
    """Magnitudes are clamped with their sign; what is no number is plain."""
    field, rules = mended(action(magnitude=given_))
    assert field.actions[0].magnitude == kept
    assert ("magnitude_range" in rules) == (given_ != kept)


@pytest.mark.parametrize(("given_", "kept"), [(3.0, 3.0), (1e9, 50.0), (0.0, 0.02), ("much", 1.0)])
def test_gain_range(given_, kept):
    """The factor on k has a range of its own; what is no number is no factor."""
    field, rules = mended(action(gain=given_))
    assert field.actions[0].gain == kept
    assert ("magnitude_range" in rules) == (given_ != kept)


@pytest.mark.parametrize(
    ("given_", "kept"),
    [([-5, 10], (0, 10)), ([10, 900], (10, 48)), ([30, 10], (10, 30)), ([20, 20], (20, 21)), ([48, 48], (47, 48)),
     ("always", None), ([0, float("nan")], None), ([3, 9], (3, 9))],
)  # fmt: skip
def test_window_in_clip(given_, kept):
    """Windows are ordered, at least a frame long and inside the clip."""
    field, _ = mended({**action(), "active_time": given_})
    assert field.actions[0].active_time == kept


@pytest.mark.parametrize("kind", ["impulse", "particle_impulse"])
def test_brief_impulse(kind):
    """Impulses of both kinds last at most two frames."""
    item = action("impulse", active_time=(5, 30))
    if kind == "particle_impulse":
        item = {"constraint_type": kind} | {k: v for k, v in item.items() if k != "action_type"}
        field, rules = mended(constraints=[item])
    else:
        field, rules = mended(item)
    assert [*field.actions, *field.constraints][0].active_time == (5, 6)
    assert rules == ["brief_impulse"]


def test_unit_vectors():
    """Vectors are normalised; entries without a direction are dropped."""
    field, rules = mended(action(vector=(-3, 0, 0)), action(vector=(0, 0, 0)), action(vector=("a", 1, 2)))
    assert [a.vector for a in field.actions] == [LEFT]
    assert rules == ["unit_vectors"] * 3


def test_directional_rigidity():
    """A vector off the base directions moves to the nearest sum of them; sums and sentence vectors stay."""
    field, rules = mended(action(vector=(-0.95, 0.1, 0.05)), action(vector=(-1, 0, 1)))
    assert field.actions[0].vector == LEFT
    assert field.actions[1].vector == pytest.approx((-math.sqrt(0.5), 0, math.sqrt(0.5)))
    assert rules.count("directional_rigidity") == 1
    odd = (0.6, 0.64, 0.48)
    expected = ExpectedMotion(kind=MotionKind.MOVE, direction=odd, window=(0, 48))
    field, _ = mended(action(vector=odd), expectations=[expected])
    assert cosine(field.actions[0].vector, odd) == pytest.approx(1.0)


def test_base_directions_follow_the_camera():
    """26 unit vectors, built from the table alone."""
    vectors = base_directions(table(33.0))
    assert len(vectors) == 26
    assert any(cosine(v, table(33.0).left) > 0.9999 for v in vectors)
    assert all(math.hypot(*v) == pytest.approx(1.0) for v in vectors)


def test_sentence_direction_takes_precedence():
    """Against the sentence: opposite signs are flipped, other vectors replaced; brakes stay."""
    left = ExpectedMotion(kind=MotionKind.MOVE, direction=LEFT, window=(0, 48), words="left")
    field, rules = mended(action(vector=RIGHT), expectations=[left])
    assert (field.actions[0].vector, field.actions[0].magnitude, rules) == (
        RIGHT,
        -1.0,
        ["sentence_direction"],
    )
    field, _ = mended(action(vector=UP), expectations=[left])
    assert (field.actions[0].vector, field.actions[0].magnitude) == (LEFT, 1.0)
    _, rules = mended(
        action(active_time=(0, 24)), action(vector=RIGHT, active_time=(24, 48)), expectations=[left]
    )
    assert rules == []


def test_sentence_sign_of_a_scale():
    """A squeeze with a positive magnitude is flipped."""
    squeeze = ExpectedMotion(kind=MotionKind.SQUEEZE, direction=UP, window=(0, 48))
    field, _ = mended(action("scale", vector=UP), expectations=[squeeze])
    assert field.actions[0].magnitude == -1.0


def test_paired_translation():
    """A lone end slab gets its mirror image; more than two become one pair; a pair stays."""
    stretch = ExpectedMotion(kind=MotionKind.STRETCH, direction=RIGHT, window=(0, 48))
    for slabs in (
        [slab(RIGHT, RIGHT)],
        [slab(RIGHT, RIGHT), slab(LEFT, LEFT), slab(RIGHT, RIGHT, magnitude=0.5)],
    ):
        field, rules = mended(constraints=slabs, expectations=[stretch])
        one, two = field.constraints
        assert rules == ["paired_translation"]
        assert one.vector == pytest.approx([-c for c in two.vector]) and one.magnitude == two.magnitude
        assert two.region.point == pytest.approx([1 - c for c in one.region.point])
        assert two.region.normal == pytest.approx([-c for c in one.region.normal])
    _, rules = mended(constraints=[slab(RIGHT, RIGHT), slab(LEFT, LEFT)], expectations=[stretch])
    assert rules == []


def test_a_part_that_is_pressed_has_no_partner():
    """Its mirror image would lift the ground's side."""
    pressed = ExpectedMotion(kind=MotionKind.SQUEEZE, direction=UP, window=(0, 48), partial=True)
    field, rules = mended(constraints=[slab((0.0, 0.0, -1.0), UP)], expectations=[pressed])
    assert rules == [] and len(field.constraints) == 1


def test_each_of_two_changes_of_length_has_its_own_pair():
    """Squeezed first, then stretched along the same line: neither pair is the other's surplus."""
    squeeze = ExpectedMotion(kind=MotionKind.SQUEEZE, direction=RIGHT, window=(0, 24))
    stretch = ExpectedMotion(kind=MotionKind.STRETCH, direction=RIGHT, window=(24, 48))
    inward = [slab(LEFT, RIGHT, active_time=[0, 14]), slab(RIGHT, LEFT, active_time=[0, 14])]
    outward = [slab(RIGHT, RIGHT, active_time=[24, 38]), slab(LEFT, LEFT, active_time=[24, 38])]
    field, rules = mended(constraints=[*inward, *outward], expectations=[squeeze, stretch])
    assert rules == [] and len(field.constraints) == 4
    field, rules = mended(constraints=[*inward, outward[0]], expectations=[squeeze, stretch])
    assert rules == ["paired_translation"] and len(field.constraints) == 4
    assert field.constraints[3].active_time == (24, 38)


def test_known_skills():
    """Unknown skills, keys and shapes vanish with a reason."""
    field, rules = mended(
        action("teleport"),
        "push",
        action(speed=3),
        action(region={"kind": "cube"}, vector=UP),
        n_grid=200,
        default_drop="true",
    )
    assert field.default_drop and len(field.actions) == 2
    assert all(a.region is None for a in field.actions)
    assert rules == ["known_skills"] * 4 + ["known_regions"]


def test_no_stacking():
    """Actions that act at once along a line share the range; one that is left too weak goes."""
    field, rules = mended(action(magnitude=1.0), action(magnitude=1.0))
    assert [a.magnitude for a in field.actions] == pytest.approx([1.0, 0.6]) and rules == ["no_stacking"]
    field, rules = mended(action(magnitude=1.4), action(vector=RIGHT, magnitude=-1.0))
    assert [a.magnitude for a in field.actions] == [1.4] and rules == ["no_stacking"]
    field, rules = mended(action("scale", magnitude=1.6), action("scale", vector=RIGHT, magnitude=1.6))
    assert len(field.actions) == 1  # an axis has no sense of its own


@pytest.mark.parametrize(
    "other",
    [
        action(vector=UP, magnitude=1.6),  # another line
        action(vector=RIGHT, magnitude=1.6),  # against it
        action("impulse", magnitude=1.6, active_time=(0, 1)),  # another kind
        action(magnitude=1.6, active_time=(24, 48)),  # another time
    ],
)
def test_what_is_no_stacking_stays(other):
    first = action(magnitude=1.6, active_time=(0, 24))
    field, rules = mended(first, other)
    assert len(field.actions) == 2 and rules == []


def test_blows_of_either_kind_share_the_range_and_parts_have_their_own():
    blow = {"constraint_type": "particle_impulse", "vector": LEFT, "magnitude": 1.6, "active_time": [0, 1]}
    field, _ = mended(action("impulse", magnitude=1.2, active_time=(0, 1)), constraints=[blow])
    assert len(field.actions) == 1 and field.constraints[0].magnitude == pytest.approx(0.4)
    ends = [slab(RIGHT, RIGHT, magnitude=1.6), slab(RIGHT, LEFT, magnitude=1.6)]
    assert mended(constraints=ends)[1] == []
    assert mended(constraints=[ends[0], {**ends[0], "region": None}])[1] == ["no_stacking"]


@given(
    st.lists(
        st.tuples(
            st.sampled_from([LEFT, RIGHT, UP]), st.floats(0.4, 1.6), st.integers(0, 40), st.integers(1, 48)
        ),
        max_size=7,
    )
)
@settings(max_examples=60, deadline=None)
def test_no_instant_exceeds_the_range(entries):
    """Whatever is asked for, the largest sum of what pulls the same way at once stays inside it."""
    raw = [action(vector=v, magnitude=m, active_time=(a, min(a + d, 48))) for v, m, a, d in entries]
    field, _ = mended(*raw)
    for frame in range(48):
        for way in (LEFT, RIGHT, UP):
            acting = [
                a.magnitude
                for a in field.actions
                if a.active_time[0] <= frame < a.active_time[1] and cosine(a.vector, way) > 0.9
            ]
            assert sum(acting) <= 1.6 + 1e-5


def test_gravity_makes_it_fall():
    """A push down in place of gravity goes; a sentence that asks for one keeps it."""
    fall = ExpectedMotion(kind=MotionKind.FALL, window=(0, 48), words="drop it")
    down = ExpectedMotion(kind=MotionKind.MOVE, direction=(0, 0, -1), window=(0, 48))
    push = action(vector=(0, 0, -1))
    field, rules = mended(push, expectations=[fall])
    assert field == ForceField(default_drop=True) and set(rules) == {"gravity_makes_it_fall"}
    field, rules = mended(push, expectations=[fall, down])
    assert len(field.actions) == 1 and rules == []
    field, _ = mended(push, expectations=[fall], scene=brief(world="ground"))
    assert field == ForceField()  # gravity is there already


def test_held_until_in_clip():
    constraint = slab(RIGHT, RIGHT, active_time=[0, 20])
    assert mended(constraints=[{**constraint, "held_until": 400}])[0].constraints[0].held_until == 48
    for bad in (10, "long", float("nan")):
        field, rules = mended(constraints=[{**constraint, "held_until": bad}])
        assert field.constraints[0].held_until is None and "held_until_in_clip" in rules


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=8,
)
ENTRY = st.fixed_dictionaries(
    {},
    optional={
        "action_type": st.sampled_from(["translation", "scale", "impulse", "torque", "x"]),
        "constraint_type": st.sampled_from(
            [
                "enforce_particle_translation",
                "enforce_particle_rotation",
                "particle_impulse",
                "moving_plate",
                "y",
            ]
        ),
        "vector": st.lists(st.floats(-3, 3), min_size=3, max_size=3) | JSON,
        "magnitude": st.floats(-5, 5) | JSON,
        "active_time": st.lists(st.floats(-100, 100), min_size=2, max_size=2) | JSON,
        "held_until": st.floats(-10, 100) | JSON,
        "region": JSON,
        "object": JSON,
    },
)


@settings(max_examples=100, deadline=None)
@given(
    st.fixed_dictionaries(
        {}, optional={"default_drop": JSON, "actions": st.lists(ENTRY, max_size=4) | JSON,
                      "constraints": st.lists(ENTRY, max_size=3) | JSON, "extra": JSON}
    ),
    st.sampled_from([row[0] for row in SENTENCES]),
    st.integers(1, 60),
)  # fmt: skip
def test_any_json_is_repaired_to_a_valid_field(raw, prompt, frame_count):
    """Whatever a model replies, the result is valid, inside the clip, and needs no further repair."""
    scene = brief(frame_count=frame_count)
    try:
        expectations = read(prompt, scene).expectations
    except UserError:
        expectations = ()
    field, _ = apply_hard_rules(raw, scene, expectations)
    assert ForceField.model_validate(field.model_dump()) == field
    for item in (*field.actions, *field.constraints):
        assert item.active_time is None or item.active_time[1] <= frame_count - 1
    again, repairs = apply_hard_rules(field, scene, expectations)
    assert repairs == () and again == field


def test_a_direction_that_is_normalised_stays_so_to_the_last_bit():
    raw = {"actions": [{"action_type": "scale", "vector": [0.0, 0.5, 9.294479649546126e-05]}]}
    field, _ = apply_hard_rules(raw, brief(frame_count=30), ())
    assert ForceField.model_validate(field.model_dump()) == field


def test_every_rule_is_documented():
    """A rule's name and first sentence are what the report and a language model are told."""
    for name, rule in RULES.items():
        assert rule.__name__ == name and rule.__doc__


def test_the_axis_of_a_joint_is_none_of_the_base_directions():
    """It follows from how the part points: the nearest base direction would turn it in another plane."""
    axis = (0.3, 0.954, 0.0)
    turn = slab(axis, (1, 0, 0), constraint_type="enforce_particle_rotation", active_time=[0, 20])
    field, repairs = mended(constraints=[turn | {"pivot": [0.5, 0.5, 0.5]}])
    assert cosine(field.constraints[0].vector, axis) > 0.9999 and "directional_rigidity" not in repairs
