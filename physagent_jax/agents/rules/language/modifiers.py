"""Lexicon of everything that is not a verb: directions, intensities, places, counts, connectives.

Direction values are names of `DirectionTable` fields; several names are added as vectors.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN

Names = tuple[str, ...]
T = TypeVar("T")


class Join(enum.Enum):
    """The relation of a clause to the one before it."""

    THEN = "then"  # follows in time
    COMMA = "comma"  # follows if a verb comes, else continues the clause
    AND = "and"  # at the same time
    WHILE = "while"  # at the same time, whatever stands between
    RESULT = "result"  # says what the clause before brings about
    BUT = "but"  # contrasts with a negated clause
    BEFORE = "before"
    AFTER = "after"


@dataclass(frozen=True)
class Repeat:
    """The number of repetitions, and whether the direction alternates.

    Attributes:
        count: Number of cycles or repetitions; None leaves the verb's own.
        alternate: To and fro instead of again and again.
        names: The direction of the first swing, if the phrase names it.
        vague: It says "often", not how often.
    """

    count: int | None = None
    alternate: bool = False
    names: Names = ()
    vague: bool = False


@dataclass(frozen=True)
class Place:
    """A part of the object.

    Attributes:
        names: The direction in which it lies from the middle; empty = the middle band.
        start: Fraction of the extent along that direction at which it begins.
    """

    names: Names
    start: float = 0.5


def _spread(rows: Mapping[str, T]) -> dict[str, T]:
    return {phrase.strip(): value for phrases, value in rows.items() for phrase in phrases.split(",")}


_LANDMARKS: dict[str, Names] = {
    "camera": ("toward",),
    "viewer": ("toward",),
    "sky": ("up",),
    "ceiling": ("up",),
    "ground": ("down",),
    "floor": ("down",),
}
# Whoever looks, and what looks for them.
_WATCHERS = ("camera", "viewer", "lens", "audience", "observer", "spectator")
DIRECTIONS: dict[str, Names] = (
    {f"in the direction of the {where}": names for where, names in _LANDMARKS.items()}
    | {f"{to} the {who}": ("toward",) for to in ("toward", "towards", "to", "at") for who in _WATCHERS}
    | {f"away from the {who}": ("away",) for who in _WATCHERS}
) | _spread(
    {
        "left, leftward, leftwards, to the viewer left": ("left",),
        "right, rightward, rightwards, to the viewer right": ("right",),
        "up, upward, upwards, above, skyward, into the air, overhead, toward the sky, "
        "towards the sky, to the sky, into the sky, toward the ceiling, towards the ceiling, to the ceiling": (
            "up",
        ),
        "down, downward, downwards, below, underneath, to the ground, to the floor, "
        "toward the ground, towards the ground, towards the floor, toward the floor, "
        "into the ground, onto the ground, into the floor, onto the floor, against the floor, "
        "against the ground, beneath": ("down",),
        "forward, forwards, toward us, towards us, toward me, towards me, at us, at me, at you, "
        "to us, to me, to you, out of the screen, closer, out of the picture, "
        "toward you, towards you, frontward, frontwards, nearer, over here, behind us, behind me, "
        "behind the camera, downstage": ("toward",),
        "away, backward, backwards, away from us, "
        "away from me, behind, into the screen, into the picture, into the distance, rearward, "
        "rearwards, into the background, upstage, head on": ("away",),
        "upper left, top left": ("up", "left"),
        "upper right, top right": ("up", "right"),
        "lower left, bottom left": ("down", "left"),
        "lower right, bottom right": ("down", "right"),
    }
)
# After a verb of swaying these are whom it greets: "wave to us".
ADDRESSEES = frozenset({"to us", "to me", "to you", "at us", "at me", "at you"})
# Directions that tell a place rather than a way when they follow a cause.
LOCATIONS = frozenset({"above", "below", "beneath", "underneath", "behind", "overhead"})
# Words for an end of the object that also serve as directions after "to the" and "from the".
ENDS: dict[str, Names] = _spread(
    {
        "top": ("up",),
        "bottom": ("down",),
        "front": ("toward",),
        "back, rear": ("away",),
    }
)
# An axis named as a line: stretching goes along it, rotation about it.
AXES: dict[str, Names] = _spread(
    {
        "vertical axis, axis, height, its own axis, its axis, vertical": ("up",),
        "horizontal axis, width, horizontal": ("right",),
        "length, lengthwise, lengthways": ("lengthwise",),
        "long axis, longest axis": ("long",),
        "depth, viewing axis, viewing direction, line of sight, view axis, depth axis, "
        "viewer axis, crosswise, front to back, from front to back, back to front": ("toward",),
        "x axis": ("x",),
        "y axis": ("y",),
        "z axis": ("z",),
    }
)
# An axis named as the plane of the motion: rotation in it is about its normal.
PLANES: dict[str, Names] = _spread(
    {
        "horizontally, sideways, sideway, laterally, lateral, to the side, to one side, aside": ("right",),
        "vertically": ("up",),
        "diagonally": ("up", "left"),
    }
)
# All around: (names, isotropic).
SIDES: dict[str, bool] = _spread(
    {
        "sides, both sides, both ends, left and right sides, opposite sides, opposite ends, "
        "opposite directions, both directions, either side, two sides": False,
        "all sides, every side, all directions, every direction, outward, outwards, inward, inwards": True,
    }
)

SENSES: dict[str, int] = _spread(
    {
        "clockwise, clock wise, cw": -1,
        "counterclockwise, anticlockwise, ccw, acw, counter clockwise, anti clockwise, counter clock wise, "
        "anti clock wise": 1,
    }
)
_ONLOOKERS: dict[str, Names] = _spread(
    {
        "above, the top": ("up",),
        "below, underneath": ("down",),
        "the front": ("toward",),
        "behind, the back": ("away",),
        "the left": ("left",),
        "the right": ("right",),
    }
)
VIEWS: dict[str, Names] = {
    f"{looked} from {where}": names
    for looked in ("seen", "viewed", "looked at", "as seen", "as viewed", "when seen", "when viewed")
    for where, names in _ONLOOKERS.items()
} | _spread(
    {
        "from a bird eye view, top view, from the top view, from a top view": ("up",),
        "as we see it, as seen by the viewer, seen by the viewer, "
        "in the picture, in the picture plane, in the image plane, in the plane of the picture, "
        "in the plane of the image, in the plane of the screen": ("toward",),
    }
)

INTENSITIES: dict[str, float] = _spread(
    {
        "slightly, slight, barely, minimally, feebly, imperceptibly, hardly, scarcely, ever so slightly, "
        "a wee bit, tiniest, slightest, faintest, gentlest, softest, lightest, "
        " faint, faintly, a tiny bit, a touch, a tad, "
        "as gently as possible, as gently as you can, as softly as possible, a hair, a smidge, a smidgen, a notch, "
        "a whisker, a trifle, hardly any, barely any, only just, just barely": MAGNITUDE_MIN,
        "gently, gentle, softly, soft, a bit, a little, a little bit, weak, weakly, lightly, "
        "light, mild, mildly, little, tiny, delicately, delicate, subtle, subtly, small, calm, "
        "calmly, carefully, tender, tenderly, gingerly, limply, languid, languidly, low, with care, "
        "with great care": 0.5,
        "slowly, slow, lazily, leisurely, sluggishly, unhurriedly": 0.6,
        "moderate, moderately, somewhat, medium": 0.8,
        "quickly, quick, fast, rapidly, rapid, swiftly, swift, briskly, hastily, hurriedly, speedily, at speed, "
        "at full speed, at top speed, at full tilt": 1.3,
        "strong, strongly, hard, firmly, firm, heavily, forcefully, forceful, powerfully, "
        "powerful, big, much, severely, severe, vigorously, vigorous, a lot, far, intense, "
        "intensely, sharply, sharp, considerably, deep, large, high, deeply, heavy, with force, mighty, "
        "great, greatly, energetically, significantly, forcibly, mightily, decisively, with vigour, with vigor": 1.3,
        "frantically, feverishly, madly, crazily, savagely, ruthlessly, explosively, at breakneck speed, "
        "violently, violent, fiercely, fierce, extremely strong, extreme, brutally, brutal, "
        "furiously, furious, wildly, wild, massive, massively, tremendous, enormous, huge, "
        "ferocious, with all its force, with all your might, with all its might, with all my might, "
        "completely, hugely, ferociously, drastically, immense, "
        "as fast as possible, as fast as you can, as quickly as possible, strongest, hardest, mightiest, "
        "with all your strength, "
        "as hard as possible, as hard as you can, as strongly as possible, with full force, like mad, like crazy, "
        "with all one might, with violence, with great violence, "
        "dramatically, enormously": MAGNITUDE_MAX,
    }
)
# What is great or small in "with great violence", "at high speed": how it is done, and no motion.
MANNERS = frozenset(
    "speed pace rate frequency amplitude force strength power energy intensity violence vigour vigor effort".split()
)
DEGREES: dict[str, float] = _spread(
    {
        "very, really, quite, so, too, particularly, rather": 1.5,
        "extremely, incredibly, super, ever so": 2.0,
    }
)
# Relative to the clause before.
COMPARATIVES: dict[str, float] = _spread(
    {
        "harder, stronger, more strongly, faster, more violently, more forcefully, more, quicker, "
        "speed up, speed ~ up, with more force": 1.4,
        "gentler, softer, weaker, more gently, slower, more slowly, less, slow down, lighter, "
        "more softly, slow ~ down, less hard, less strongly, less violently, less forcefully": 0.6,
    }
)

REPEATS: dict[str, Repeat] = _spread(
    {
        "twice": Repeat(2),
        "thrice": Repeat(3),
        "once, once more, one more time, once again": Repeat(1),
        "repeatedly, again and again, several times, a few times, many times, multiple times, "
        "a couple of times, over and over, over and over again": Repeat(3, vague=True),
        "changing direction, changes direction, back and forth, to and fro, alternating, "
        " alternatingly, alternately, rhythmically, "
        "periodically, and back, and back again": Repeat(None, alternate=True),
        "side to side, left and right, left and then right, from left to right and back, "
        "from side to side, left to right and back": Repeat(None, True, ("left",)),
        "right and left": Repeat(None, True, ("right",)),
        "up and down": Repeat(None, True, ("up",)),
        "forward and backward, forwards and backwards, backward and forward, backwards and forwards": Repeat(
            None, True, ("toward",)
        ),
    }
)

# Parts that name their own place.
PLACES: dict[str, Place] = _spread(
    {
        "blossom, petal, frond, leaf, leaves, branches, branch, foliage, crown, canopy, flowers, flower, blossoms, "
        "petals, fronds": Place(("up",), 0.4),
        "head, face, hat, ears, antenna, neck, hair": Place(("up",), 0.72),
        "tip, peak, summit": Place(("up",), 0.8),
        "lampshade, roof": Place(("up",), 0.6),
        "base, pot, roots, flowerpot, vase base, stand": Place(("down",), 0.75),
        "feet, foot, legs, wheels, trunk base": Place(("down",), 0.65),
        "middle, center, centre, waist, belly, tummy, stomach, torso, midsection": Place(()),
    }
)
# With "a" in front these are parts of the object still; "a hat", "a top" are other things.
ONE_OF_MANY = frozenset(
    "blossom petal frond leaf leaves branches branch flowers flower blossoms petals fronds".split()
)
# A blow on them comes from the front.
FRONTS = frozenset({"face", "belly", "tummy", "stomach", "torso", "waist"})
# Nouns that take a direction in front: "the left arm", "its upper half"; value = where the part begins.
PARTS: dict[str, float] = _spread(
    {
        "half, side, part, portion, section, region, area": 0.5,
        "face, surface": 0.8,
        "third": 2 / 3,
        "quarter": 0.75,
        "end, edge, tip, corner, slab": 0.8,
        "arm, hand, wing, shoulder, ear, fist, leg, foot, eye, branch, leaf": 0.65,
    }
)
PART_ADJECTIVES: dict[str, Names] = _spread(
    {
        "upper, uppermost, topmost": ("up",),
        "lower, bottommost, lowermost": ("down",),
        "front": ("toward",),
        "rear, back, hind": ("away",),
        "top": ("up",),
        "bottom": ("down",),
        "left": ("left",),
        "right": ("right",),
        "left hand": ("left",),
        "right hand": ("right",),
        "leftmost": ("left",),
        "rightmost": ("right",),
        "upper left, top left": ("up", "left"),
        "upper right, top right": ("up", "right"),
        "lower left, bottom left": ("down", "left"),
        "lower right, bottom right": ("down", "right"),
    }
)

# Where gravity acts to, as far as the words say: `agents.schema.WorldRequest.gravity`.
GRAVITY: dict[str, str] = {
    phrase: "down"
    for turn in ("turn", "switch")
    for back in ("", "back ")
    for the in ("", "the ")
    for phrase in (f"{turn} {back}on {the}gravity", f"{turn} {the}gravity {back}on", f"gravity {back}on")
} | _spread(
    {
        "gravity, own weight, its weight, from a height, from height, from high up, from the sky, "
        "from a great height, free fall": "down",
        "weightless, weightlessly, weightlessness, zero gravity, in space, outer space, in zero g, "
        "in orbit, in mid air, in midair, held in the air, hold ~ in the air, floating in the air, gravity off, "
        "gravity stops, gravity vanishes, gravity disappears, gravity ceases, gravity is off, "
        "gravity is switched off, gravity is turned off, gravity switched off, gravity turned off, "
        "turn off gravity, turn off the gravity, turn gravity off, "
        "turn the gravity off, switch gravity off, switch the gravity off, switch off the gravity, "
        "switch off gravity": "none",
        "gravity is reversed, gravity reversed, reversed gravity, reverse gravity, reverse the gravity, "
        "gravity is inverted, inverted gravity, gravity is upside down, gravity upside down, "
        "gravity points up, gravity points upward, gravity points upwards, gravity acts upward, "
        "gravity acts upwards, gravity is flipped, negative gravity, "
        "turn gravity upside down, turn the gravity upside down, "
        "flip gravity, flip the gravity, invert gravity, invert the gravity, "
        "gravity flips, gravity reverses, gravity inverts, gravity turns around, gravity turns upside down, "
        "gravity ~ flips, gravity ~ reverses, gravity ~ inverts, gravity is ~ reversed, gravity is ~ inverted, "
        "gravity is ~ flipped": "up",
    }
)
# As before, but the other way.
REVERSALS = frozenset(
    {
        "the other way",
        "the other way around",
        "the other way round",
        "the opposite way",
        "the other direction",
        "the opposite direction",
        "in reverse",
    }
)
# As before, and the same way.
SAME_WAYS = frozenset({"in the same direction", "the same way", "in the same way", "the same direction"})
OPPOSITE_GRAVITY = {"down": "none", "none": "down", "up": "down"}
GROUND_WORDS = frozenset({"ground", "floor"})  # "no ground"
# Things around the object that are neither walls nor blocks.
SCENE_NOUNS = frozenset(
    (
        "ground floor table ceiling sky wall walls plate plates hand hands finger fingers rope ball hammer person "
        "people"
    ).split()
)
# Solids that a sentence names: `agents.schema.ObstacleRequest.kind`. Blocks only where something goes against them.
OBSTACLES: dict[str, str] = _spread(
    {
        "wall, obstacle, barrier, fence, barricade, ceiling": "wall",
        "block, box, brick, crate, step, rock, stone": "block",
    }
)
# What goes before "but" or an exception when all the rest is meant.
WHOLE_WORDS = frozenset({"everything", "all", "whole", "entire", "rest"})
EXCEPTIONS = frozenset(
    {
        "except",
        "except for",
        "excepting",
        "excluding",
        "apart from",
        "aside from",
        "other than",
        "save for",
        "with the exception of",
    }
)
ANCHORS: dict[str, str] = _spread(
    {
        "rooted, potted, planted, stuck to the ground, attached to the ground, "
        "fixed to the ground, in a pot, in its pot": "base",
        "fixed at the bottom, fixed at the base, fixed at its base, fixed at its bottom, "
        "anchored at the base": "base",
        "hanging from the ceiling, fixed at the top, held at the top, fixed at its top": "top",
        "unattached, detached, free floating, freely floating, unanchored, loose, free, freely, "
        "uproot, uproots, uprooted, unsupported, out of the ground, out of its pot, out of the pot, "
        "out of the soil": "none",
    }
)

JOINS: dict[str, Join] = _spread(
    {
        "then, and then, in the end, and in the end, after that, "
        "afterwards, afterward, finally, next, later, followed by, "
        "subsequently, lastly, at last, eventually, after a while, after a moment, a moment later, "
        "thereafter, after which, followed, and finally, and last, whereupon, thereupon, and after that": Join.THEN,
        "while, as, when, whilst, at the same time, simultaneously, meanwhile, and at the same time": Join.WHILE,
        "and, plus, with": Join.AND,
        "so that, making, causing, which makes, such that, to make, until, that makes, "
        "in order to, which, because of, caused by, due to, make, makes, cause, causes": Join.RESULT,
        "but, however, yet": Join.BUT,
        "before": Join.BEFORE,
        "after, not until, as soon as, before that, beforehand, before this, but first": Join.AFTER,
    }
)
NEGATIONS = frozenset(
    {"not", "no", "never", "without", "neither", "nor", "none", "instead of", "rather than"}
)

# At one speed from beginning to end.
EVENLY = frozenset(
    f"{at} {how} {speed}"
    for at in ("at", "with")
    for how in ("a constant", "constant", "an even", "even", "a steady", "a uniform", "uniform", "one")
    for speed in ("speed", "velocity", "pace", "rate")
) | {"evenly", "uniformly"}

UNITS: dict[str, str] = {
    "ms": "millisecond",
    "millisecond": "millisecond",
    "milliseconds": "millisecond",
    "second": "second",
    "seconds": "second",
    "sec": "second",
    "secs": "second",
    "s": "second",
    "frame": "frame",
    "frames": "frame",
}
_ORDINALS = ("third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
# Nouns of parts of a whole: "a fifth", "three quarters".
FRACTIONS: dict[str, float] = {"half": 0.5, "quarter": 0.25, "quarters": 0.25} | {
    name + plural: 1 / number
    for number, name in (*enumerate(_ORDINALS, 3), (12, "twelfth"), (15, "fifteenth"), (20, "twentieth"))
    for plural in ("", "s")
}
CLIP_PARTS: dict[str, float] = {"half": 0.5, "third": 1 / 3, "quarter": 0.25}
NUMBERS: dict[str, float] = {
    "a": 1,
    "an": 1,
    "one": 1,
    "two": 2,
    "three": 3,
    "four": 4,
    "five": 5,
    "six": 6,
    "seven": 7,
    "eight": 8,
    "nine": 9,
    "ten": 10,
    "twelve": 12,
    "twenty": 20,
    "half": 0.5,
    "few": 3,
    "several": 3,
    "couple": 2,
}
# Fixed phrases about time: (start, length) in fractions of the clip, None = as the sequence gives.
MOMENTS: dict[str, tuple[float | None, float | None]] = _spread(
    {
        "briefly, brief, for a moment, shortly, momentarily, for an instant, for a split second, "
        "for a fraction of a second, "
        "for just a fraction of a second, for just a moment, for just an instant": (None, -1.0),
        "suddenly, sudden, abruptly, instantly, impulsive, instantaneous": (None, None),
        "at the end, towards the end, toward the end, near the end": (0.75, 0.25),
        "at the beginning, at the start, at first, in the beginning, initially": (None, None),
        "immediately, right away, at once, right now, from the start": (0.0, None),
        "halfway through, midway, halfway, in the middle of the clip, half way through": (0.5, None),
        "for a bit, for a while, a while, for some time, for a little while, "
        "the whole time, throughout, all the time, the entire time, until the end, continuously, "
        "constantly, steadily, forever, during the whole clip, for the whole clip": (None, None),
    }
)
