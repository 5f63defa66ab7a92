"""The offline semantic agent: what sentences lead to, and what no sentence may lead to."""

import collections
import math
import tracemalloc
from collections.abc import Iterator

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from physagent_jax.agents.compiler.builder import MAX_ACTIONS
from physagent_jax.agents.grammar.patterns import read_patterns
from physagent_jax.agents.grammar.tokens import correct_spelling, tokenise
from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.agents.lexicon.types import Motion
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ActionType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cosine
from physagent_jax.scene.priors import list_nouns
from tests.agents.scenes import brief, described, read, table
from tests.agents.sentences import SENTENCES


@pytest.mark.parametrize(("prompt", "held", "actions", "seen"), SENTENCES, ids=[row[0] for row in SENTENCES])
def test_sentence(prompt, held, actions, seen):
    """Every sentence leads to the actions, order, windows, signs, anchor and expectations in the table."""
    scene = brief(anchored="base" if held else None)
    assert described(read(prompt, scene), scene) == (actions, seen)


@pytest.mark.parametrize("degrees", [30.0, 90.0, 205.0])
@pytest.mark.parametrize(
    ("prompt", "held"), [row[:2] for row in SENTENCES if "x axis" not in row[0]], ids=lambda v: str(v)[:40]
)
def test_directions_follow_the_camera(prompt, held, degrees):
    """The same words from another camera mean that camera's directions: nothing is hard-coded."""
    texts = []
    for scene in (brief(anchored=held or None), brief(anchored=held or None, directions=table(degrees))):
        texts.append(described(read(prompt, scene), scene))
    assert texts[0] == texts[1]


@pytest.mark.parametrize(
    "prompt",
    ["", "  \n\t", "asdf qwer", "12345", "The colour of mathematics", "?!...", "Schieb den Roboter nach links",
     "推动机器人向左", "😀", "quickly", "the top of it", "\x00"],
)  # fmt: skip
def test_nonsense_is_refused_with_help(prompt):
    """A sentence without a motion is refused, with what was got and documented examples."""
    with pytest.raises(UserError) as error:
        read(prompt)
    examples = [example for pattern in read_patterns() for example in pattern.examples]
    assert any(example in str(error.value) for example in examples)
    assert not prompt.strip() or prompt.strip()[:5] in str(error.value).replace("\\x00", "\x00")


@pytest.mark.parametrize(
    ("words", "low", "high"),
    [("very slightly", 0.4, 0.4), ("slightly", 0.4, 0.4), ("gently", 0.4, 0.6), ("slowly", 0.4, 0.7),
     ("moderately", 0.8, 0.8), ("", 1.0, 1.0), ("not too hard", 0.7, 0.9), ("hard", 1.3, 1.3),
     ("very hard", 1.4, 1.6), ("violently", 1.6, 1.6), ("extremely violently", 1.6, 1.6)],
)  # fmt: skip
def test_intensity_classes(words, low, high):
    """Intensity words set the magnitude monotonically inside [0.4, 1.6]."""
    action = read(f"push the robot to the left {words}").force_field.actions[0]
    assert low <= action.magnitude <= high


@pytest.mark.parametrize(
    ("prompt", "window"),
    [("push it left for one second", (0, 25)), ("push it left for half a second", (0, 12)),
     ("push it left during the second half", (24, 48)), ("push it left in the first third", (0, 16)),
     ("in the last second push it left", (23, 48)), ("push it left between 0.4 and 1.2 seconds", (10, 30)),
     ("push it left at the end", (36, 48)), ("push it left after 20 frames", (20, 48)),
     ("push it left briefly", (0, 7)), ("push it left for 99 seconds", (0, 48)),
     ("push it left at frame 12", (12, 48)), ("push it left for a couple of frames", (0, 2))],
)  # fmt: skip
def test_told_times(prompt, window):
    """Times in words are windows in frames of 0.04 s, kept inside the clip."""
    assert read(prompt).force_field.actions[0].active_time == window


def test_regions_are_on_the_named_side():
    """Parts are half-spaces whose normal is the viewer's direction, and a box for the middle."""
    scene = brief(directions=table(37.0))
    left = read("push the left arm up", scene).force_field.actions[0].region
    assert left.normal == pytest.approx(scene.directions.left)
    top = read("push the upper half to the left", scene).force_field.actions[0].region
    assert (top.point, top.normal) == ((0.5, 0.5, 0.5), (0, 0, 1))
    corner = read("push the upper left corner away", scene).force_field.actions[0].region
    assert cosine(corner.normal, scene.directions.left) == pytest.approx(math.sqrt(0.5))
    middle = read("push the middle to the left", scene).force_field.actions[0].region
    assert (middle.low[2], middle.high[2]) == pytest.approx((1 / 3, 2 / 3))


def test_evidence_leads_from_words_to_values():
    """Each field of each action has the words that led to it."""
    reply = read("a strong wind pushes the robot to the left for one second")
    found = {e.field: e.words for e in reply.evidence}
    assert found == {
        "actions[0].action_type": "pushes",
        "actions[0].magnitude": "strong",
        "actions[0].vector": "left",
        "actions[0].active_time": "for one second",
    }
    drop = read("drop the robot").evidence
    assert [(e.words, e.field, e.value) for e in drop] == [("drop", "default_drop", "true")]


def test_unknown_words_are_reported():
    """Content words that led to nothing are listed; function words and the object's name are not."""
    assert read("the robot is pushed melodiously to the left").not_understood == ("melodiously",)
    assert read("push the robot to the left").not_understood == ()
    assert read("push the Ficus Tree left", brief(object_name="ficus_tree")).not_understood == ()
    for name, words in {
        "OldBarrel": "barrel",
        "goathead": "goat head",
        "motorbike": "bike",
        "goathorn": "goat",
    }.items():
        assert read(f"push the {words} left", brief(object_name=name)).not_understood == ()
    assert read("push the jar left", brief(object_name="jam")).not_understood


def test_assumptions_are_noted():
    """Assumptions are noted where the sentence leaves something open."""
    assert read("push the robot").notes == ("'push': no direction given, assumed left.",)


def test_an_axis_that_the_verb_brings_is_told_as_an_axis():
    """A turn about the verb's own axis names the axis; a throw names a direction."""
    (spin,) = [e for e in read("spin the robot").evidence if e.field.endswith("vector")]
    assert spin.why == "no axis given: it points up by default"
    (throw,) = [e for e in read("throw the robot").evidence if e.field.endswith("vector")]
    assert throw.why == "no direction given: up by default"


def test_a_noun_is_the_object_if_its_file_or_kind_says_so():
    """A name that says nothing leaves it to the sentence; else a noun is the object's own, or one of its kind."""
    scan = read("the sand castle collapses", brief(object_name="scan_04"))
    assert "'sand castle' is taken to be the object" in scan.notes[0] and not scan.unsure
    assert read("push the elephant left").unsure == ("'elephant' is not understood.",)
    loaf = brief(object_name="loaf", object_kind="food", object_nouns=("loaf", "bread", "head"))
    for prompt in ("squeeze the bread", "squeeze bread", "squeeze the loaf of bread"):
        assert not read(prompt, loaf).unsure
    assert read("squeeze the bread of the loaf", loaf).unsure
    assert read("push the head left", loaf).expectations[0].partial
    assert read("push the loaf's head left", loaf).expectations[0].partial
    assert read("the robot moves in a zigzag", brief(object_name="scan_04")).unsure


def test_a_noun_for_any_object_is_the_only_one():
    """A likeness may be of anything, a class of things only of what may belong to it; who acts is another."""
    queen = brief(object_name="nefertiti", object_nouns=list_nouns("object"))
    for words in (
        "bust",
        "statue",
        "sculpture",
        "animal",
        "vehicle",
        "toy",
        "thing",
        "figure",
        "queen",
        "lady",
    ):
        assert not read(f"push the {words} to the left", queen).unsure
    pot = brief(object_name="teapot", object_kind="vessel", object_nouns=list_nouns("vessel"))
    for words, known in dict(container=True, toy=True, car=False, animal=False, lady=False).items():
        assert bool(read(f"push the {words} to the left", pot).unsure) is not known
    assert read("a bust made of jelly wobbles", queen).materials == ("jelly",)
    pushed = read("a woman pushes the statue to the left", queen)
    assert pushed.ignored == ("woman",) and not pushed.unsure


def test_opposite_ends_of_a_sequence_do_not_overlap():
    """Parts of a sequence follow each other and fill the clip."""
    actions = read("squeeze it, then stretch it, then twist it, then push it up").force_field.actions
    windows = [a.active_time for a in actions]
    assert windows == [(0, 12), (12, 24), (24, 36), (24, 36), (36, 48)]  # both ends of the twist at once


def test_a_free_object_is_braked_before_it_turns_back():
    """Acceleration and brake cancel, so that the next push starts from rest; a held object needs no brake."""
    free = read("push it to the left, then to the right").force_field.actions
    assert [a.vector[0] for a in free] == [-1, 1, 1]
    actions = read("push it to the left, then to the right", brief(anchored="base")).force_field.actions
    assert [a.vector[0] for a in actions] == [-1, 1]


@pytest.mark.parametrize(
    "prompt",
    ["a strong gust pushes it to the left, then it stops", "shove it to the left, then push it to the right"],
)
def test_friction_stops_what_is_shoved_along_the_ground(prompt):
    """A gust the other way would blow it back: it overcomes friction anew."""
    first, *later = read(prompt, brief(world="ground", anchored=None)).force_field.actions
    assert first.vector[0] == -1 and first.gain > 1
    assert all(each.active_time[0] >= 12 for each in later)


@pytest.mark.parametrize(
    "prompt", ["shake the robot twice", "shake the robot", "sway the robot left and right three times"]
)
def test_what_swings_a_free_object_leaves_it_at_rest(prompt):
    """Velocity and displacement of the alternating accelerations both come back to zero."""
    actions = read(prompt, brief(frame_count=121)).force_field.actions
    velocity = position = 0.0
    for action in actions:
        assert action.action_type is ActionType.TRANSLATION and action.active_time[1] <= 120
        span = action.active_time[1] - action.active_time[0]
        push = action.magnitude * action.vector[0]
        position += velocity * span + push * span**2 / 2
        velocity += push * span
    assert velocity == pytest.approx(0)
    assert position == pytest.approx(0)


@pytest.mark.parametrize("frame_count", [1, 2, 3, 5])
def test_tiny_clips(frame_count):
    """Clips too short for the sentence still give valid windows."""
    scene = brief(frame_count=frame_count)
    for prompt in (
        "push left, then right, then up, then kick it down, then stop",
        "shake it ten times",
        "jump",
    ):
        check_windows(read(prompt, scene), frame_count)


def test_a_word_longer_than_any_is_not_looked_up_by_its_slips():
    """Each slip is a copy of the word: of one with 5,000 letters they would take 75 MB."""
    words = list(tokenise("a" * 5000))
    tracemalloc.start()
    try:
        assert correct_spelling(words, frozenset(("aardvark",))) == words
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


def test_long_prompts_stay_small_and_quick():
    """Thousands of clauses neither crash nor flood the simulator."""
    reply = read("push it to the left, then kick it up, then " * 1000 + "stop")
    assert len(reply.force_field.actions) <= MAX_ACTIONS
    check_windows(reply, 49)


def check_windows(reply, frame_count: int) -> None:
    """All windows lie inside the clip; impulses are brief; magnitudes and strengths are in range."""
    for action in reply.force_field.actions:
        assert 0.4 <= abs(action.magnitude) <= 1.6
        assert math.hypot(*action.vector) == pytest.approx(1.0)
        if action.active_time is None:
            assert frame_count == 1
            continue
        first, last = action.active_time
        assert 0 <= first < last <= frame_count - 1
        if action.action_type is ActionType.IMPULSE:
            assert last - first <= 2
    for expected in reply.expectations:
        assert 0 <= expected.window[0] <= expected.window[1] <= frame_count - 1
    assert reply.expectations


WORDS = read_lexicon()
LEXICON = sorted(
    {word for words in (WORDS.motions, WORDS.causes, WORDS.directions, WORDS.intensities, WORDS.repeats,
                        WORDS.joins, WORDS.parts, WORDS.moments, WORDS.anchors, WORDS.gravity,
                        WORDS.senses, WORDS.axes, WORDS.sides, WORDS.comparatives)
     for word in words}
    | {"the", "a", "to", "from", "robot", "not", "no", ",", ".", "for 2 seconds", "half", "side", "its",
       "after 3 frames"}
)  # fmt: skip


@example(["every direction", "squall"], 50, False)
@example(
    "wrench off,bang down against a counter,wrench off,balance up on her back bumper".split(","), 50, False
)
@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(LEXICON), max_size=14), st.integers(1, 200), st.booleans())
def test_any_words_give_a_valid_field_or_an_error(words, frame_count, held):
    """Any heap of known words is refused or gives a valid force field, and the same one twice."""
    check_text(
        " ".join(words).replace("~", "it"), brief(frame_count=frame_count, anchored="base" if held else None)
    )


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=200))
def test_any_text_gives_a_valid_field_or_an_error(text):
    """Any Unicode text is refused or gives a valid force field."""
    check_text(text, brief())


def check_text(text: str, scene) -> None:
    try:
        reply = read(text, scene)
    except UserError:
        return
    check_windows(reply, scene.frame_count)
    assert reply == read(text, scene)


def list_phrases(most: int = 25) -> Iterator[tuple[str, Motion]]:
    """The phrases of the lexicon's verbs; of those with more optional words than that, some evenly."""
    variants = collections.defaultdict(list)
    for phrase, verb in WORDS.motions.items():
        variants[id(verb), phrase.split()[0]].append((phrase, verb))
    for each in variants.values():
        yield from each[:: -(-len(each) // most)]


def test_every_verb_of_the_lexicon_does_something():
    """Each lemma alone, said of the object, is understood."""
    for phrase, verb in list_phrases():
        reply = read(f"{phrase.replace('~', 'it')} the robot to the left")
        moves = reply.force_field.actions or reply.force_field.constraints or reply.force_field.default_drop
        still = {e.kind for e in reply.expectations} <= {MotionKind.STILL, MotionKind.FALL}
        gives = verb.gives and reply.materials  # its weight does the rest
        assert moves or still or gives or reply.anchor.kind, (phrase, verb)
