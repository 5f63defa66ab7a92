"""Sentences of `readings.yaml`: the motions that people read in them, what is clear and what must be doubted."""

import pytest

from tests.agents.scenes import brief, read
from tests.agents.sentences import load_table
from tests.agents.tellings import ground, order, tell
from tests.agents.test_limbs import HEAD

READINGS = load_table("readings.yaml")
MOTIONS = [pair for topic in READINGS["motions"].values() for pair in topic.items()]


@pytest.mark.parametrize(("prompt", "expected"), MOTIONS)
def test_motions(prompt, expected):
    """Order, way and part as a person reads them; the readings were written by hand."""
    assert order(prompt) == expected


@pytest.mark.parametrize("prompt", READINGS["clear"])
def test_what_is_clear_is_not_doubted(prompt):
    assert read(prompt, ground()).unsure == ()


@pytest.mark.parametrize("prompt", READINGS["doubtful"])
def test_what_is_beyond_the_language_is_doubted(prompt):
    """A plain sentence in ``unsure``, which keeps a run from being called a success."""
    unsure = read(prompt, ground()).unsure
    assert unsure and all(text.endswith(".") for text in unsure)


def test_what_stands_and_tips_over_is_not_lifted_first():
    """Its fall is the end of the toppling; before, "and falls" let it drop from above the ground."""
    for prompt in ("it tips over to the right and falls", "it topples over and falls to the ground"):
        assert read(prompt, ground()).force_field.default_drop is False
        assert read(prompt, brief(world="free")).force_field.default_drop is True
    assert read("it falls and tips over", ground()).force_field.default_drop is True


def test_each_way_has_its_own_time():
    """Two ways with a time each are two steps."""
    first, second = read(
        "push it for two seconds to the left and for one second to the right", ground()
    ).expectations
    assert (tell(first), tell(second)) == ("move left", "move right")
    assert second.window[0] == first.window[1]
    assert first.amount is not None and first.amount.value == 2.0
    assert second.amount is not None and second.amount.value == 1.0


def test_a_view_belongs_to_its_turn():
    """ "As seen from above" tells which way is clockwise, and is no second turn."""
    (turn,) = read("rotate it clockwise as seen from above", ground()).expectations
    assert turn.direction == (0.0, 0.0, -1.0)


def test_manner_alone_is_denied():
    """A denied "too hard" is done less hard than a "hard"."""
    denied, hard = (
        read(prompt, ground()).expectations[0]
        for prompt in ("do not push it too hard to the right", "push it too hard to the right")
    )
    assert tell(denied) == tell(hard) == "move right" and denied.strength <= 1.0 < hard.strength
    assert read("do not push it", ground()).expectations[0].kind.value == "still"


@pytest.mark.parametrize(
    ("prompt", "alike"),
    [
        ("push it left, medium force", "push it left with medium force"),
        ("push it left with great violence", "push it violently to the left"),
        ("move it a smidgen to the left", "move it slightly to the left"),
        ("a slow, steady push to the left", "a slow push to the left"),
        ("don't push it hard to the left", "don't push it too hard to the left"),
    ],
)
def test_manner_in_other_words(prompt, alike):
    """A noun of manner is as strong as its adjective."""
    one, other = (read(text, ground()).expectations[0].strength for text in (prompt, alike))
    assert one == pytest.approx(other, abs=0.15)


def test_what_rolls_on_wheels_stays_upright():
    """A barrel turns as it rolls, a cart does not."""
    barrel, cart = (
        read("roll it to the left", ground(object_name=name)).expectations
        for name in ("barrel", "shopping cart")
    )
    assert [tell(motion) for motion in barrel] == ["move left", "rotate toward"]
    assert [tell(motion) for motion in cart] == ["move left"]
    wheel = HEAD.model_copy(update=dict(name="front wheel", origin="file"))
    thing = read("roll it to the left", ground(object_name="a1", parts=(wheel,))).expectations
    assert [tell(motion) for motion in thing] == ["move left"]


def test_what_is_not_there():
    """A wall that is denied, and a hold that is none: what hangs at the top of its flight falls."""
    assert read("no wall, push the robot left", ground()).world.obstacles == ()
    reply = read("it is hurled up, hangs there for a moment and falls", ground())
    assert reply.anchor.kind is None and [tell(motion) for motion in reply.expectations] == ["hit up", "fall"]


def test_what_holds_is_no_motion():
    """A part that is stuck does nothing more; one that is fixed by somebody is held."""
    reply = read("squash the robot from above while its feet are stuck to the ground", ground())
    assert reply.anchor.kind == "base" and [tell(motion) for motion in reply.expectations] == ["squeeze down"]


def test_two_walls():
    """One on either side."""
    walls = read("with walls on both sides, shake the robot sideways", ground()).world.obstacles
    assert [tuple(round(c) for c in wall.direction) for wall in walls] == [(-1, 0, 0), (1, 0, 0)]


def test_what_was_misspelt_is_told():
    """Reading one word for another is an assumption."""
    assert "'psuh' is read as 'push'." in read("psuh the robot to the left", ground()).notes


def test_thanks_have_no_strength():
    """The "much" of "thank you very much" is of no motion."""
    plain, thanked = (
        read(prompt, ground()).expectations[0].strength
        for prompt in ("push it left", "push it left, thank you very much")
    )
    assert plain == thanked


def test_the_long_axis_is_the_object_s():
    """The object is stretched across where it is longest across."""
    (motion,) = read(
        "stretch it along its long axis by a factor of 1.3", ground(long_axis=(1, 0, 0))
    ).expectations
    assert motion.direction == (1.0, 0.0, 0.0)
    assert motion.amount is not None and (motion.amount.value, motion.amount.unit) == (1.3, "factor")


@pytest.mark.parametrize(
    ("prompt", "alike"),
    [
        ("gravity suddenly reverses and it falls", "gravity is reversed and it falls"),
        ("gravity is suddenly inverted and it falls", "gravity is inverted and it falls"),
    ],
)
def test_gravity_that_turns(prompt, alike):
    one, other = (read(text, ground()) for text in (prompt, alike))
    assert not one.unsure and one.world.gravity == other.world.gravity
    assert [(m.kind, m.direction, m.part, m.excludes_part, m.window) for m in one.expectations] == [
        (m.kind, m.direction, m.part, m.excludes_part, m.window) for m in other.expectations
    ]


def test_in_both_directions_is_once():
    (motion,) = read("stretch it in both directions, left and right", ground()).expectations
    assert motion.kind.value == "stretch" and motion.repeats == 1


def test_a_hold_before_a_release_is_how_long():
    """A hold before a release is a duration."""
    (motion,) = read("stretch it to twice its width, hold for 2 seconds and release", ground()).expectations
    assert tell(motion) == "stretch right" and motion.released
    assert motion.window[1] == 50  # 2 s of 0.04 s


def test_what_holds_beside_a_motion():
    """Hanging and being clamped are no motions, and hide none."""
    hanging = read("it hangs from a rope, spinning", ground())
    assert hanging.anchor.kind == "top" and [tell(m) for m in hanging.expectations] == ["rotate up"]
    clamped = read("torsion by 45 degrees about the vertical axis with the lower end clamped", ground())
    assert clamped.anchor.kind == "base" and [tell(m) for m in clamped.expectations] == ["rotate up on up"]


def test_what_is_not_done_holds_nothing():
    """ "Instead of" and "free" anchor neither the top nor nothing."""
    assert read("instead of raising its head it spins", ground()).anchor.kind is None
    assert read("pull the free upper end up while the base is clamped", ground()).anchor.kind == "base"


def test_forms_of_alike_verbs():
    """A taped thing is held, and a tapped one is struck."""
    assert read("it is taped to the table", ground()).anchor.kind == "base"
    assert order("it is tapped from the left") == "hit right"


def test_a_letter_that_is_left_out():
    """A doubled letter that is written once."""
    (motion,) = read("squeeze it in the midle", ground()).expectations
    assert motion.partial


def test_one_wall_of_brick():
    """A brick wall is a wall, and no block besides."""
    (wall,) = read("it crashes into the brick wall on the right", ground()).world.obstacles
    assert wall.kind == "wall" and wall.direction == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(("long", "axis"), [((0.0, 1.0, 0.0), 1), ((1.0, 0.0, 0.0), 0)])
def test_what_lies_tips_over_sideways_across_its_length(long, axis):
    turn, _ = read("it tips over sideways", ground(long_axis=long)).expectations
    assert abs(turn.direction[axis]) == pytest.approx(1.0)


def test_what_clatters_to_the_floor_falls():
    assert [tell(motion) for motion in read("it clatters onto the floor", ground()).expectations] == ["fall"]


def test_a_tool_that_is_swung_down_tips_over_its_lower_end():
    axe = ground(object_name="axe", object_kind="tool")
    for prompt in ("swing it down as though chopping wood", "the axe swings down hard"):
        (turn,) = read(prompt, axe).expectations
        assert tell(turn) == "rotate toward" and turn.amount is not None
    assert [tell(m) for m in read("swing the axe from side to side", axe).expectations] == ["sway left x2"]
    swung = read("somebody swings the axe to the right", axe).expectations
    assert [tell(m) for m in swung] == ["rotate toward", "rotate away"] and swung[0].means
