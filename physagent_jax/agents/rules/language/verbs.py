"""Lexicon of verbs and causes: what a word makes the object do.

Every row is data: lemmas, then the `Verb` that they stand for. ``~`` in a phrase stands for up to four
words ("let ~ go" = "let it go", "lets the plant go"). Inflections are derived in `words`.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from physagent_jax.forces.calibration import MAGNITUDE_MAX
from physagent_jax.forces.skills import Skill, list_skills


class Effect(enum.Enum):
    """The ways in which a verb acts on the object; each is compiled by one function of `compilation`."""

    PUSH = "push"  # steady force along a direction
    LEAN = "lean"  # the upper end goes along a direction
    SWAY = "sway"  # to and fro
    SCALE = "scale"  # stretch or squeeze along one axis
    SWELL = "swell"  # stretch or squeeze along all axes
    STRIKE = "strike"  # sudden velocity along a direction
    BURST = "burst"  # sudden outward force
    TURN = "turn"  # rotation about an axis
    ROLL = "roll"  # rotation with travel
    FALL = "fall"  # gravity
    TOPPLE = "topple"  # gravity and a lean
    JUMP = "jump"  # a leap against gravity
    HOLD = "hold"  # something is held fixed
    RELEASE = "release"  # what acted before stops, the object comes back
    STILL = "still"  # nothing moves


@dataclass(frozen=True)
class Verb:
    """The meaning of a verb, or of a noun that names a cause.

    Attributes:
        effect: How it acts.
        strength: Factor on the magnitude that the word itself carries ("tap" is weak, "smash" is not).
        direction: The direction (or axis) assumed if the sentence names none; None = left, the most
            visible one, with a note.
        sign: +1 stretches, -1 squeezes.
        pulls: The cause stands where the object goes: "pulled from the left" moves left.
        gravity: Gravity acts with it (a thrown thing comes down).
        strokes: How many blows it is, unless the sentence counts.
        cycles: How often a sway goes to and fro unless the sentence counts.
        brief: The cause lasts only a part of its time ("gust").
        generic: Adds nothing to a more telling verb beside it: "a kick *sends* it *flying*",
            "squash it *flat*", "*stands* swaying".
        wind: A cause that pushes whatever verb it "does" ("the wind hits the plant").
        wrings: A turn of one end against the other, unless the sentence names a part.
        holds: The end that a HOLD verb or adjective fixes unless the sentence names one.
        bound: ``direction`` is part of what it means: nothing is lifted downwards.
        skill: Name of the skill that it stands for; None = what its effect is compiled to.
    """

    effect: Effect
    strength: float = 1.0
    direction: str | None = None
    sign: int = 1
    pulls: bool = False
    gravity: bool = False
    cycles: int = 2
    strokes: int = 1
    brief: bool = False
    generic: bool = False
    wind: bool = False
    wrings: bool = False
    holds: Literal["base", "top"] = "base"
    bound: bool = False
    skill: str | None = None


_D = Effect
_VERB_ROWS: tuple[tuple[str, Verb], ...] = (
    # steady motion
    (
        "push, drive, sweep, propel, force, shift, displace, thrust, translate, relocate, skid, sail",
        Verb(_D.PUSH),
    ),
    (
        "move, slide, glide, go, travel, carry, send, fly, drift, accelerate, slip, bring, transport, transfer, "
        "guide, steer, "
        "enter, exit, stagger, stumble",
        Verb(_D.PUSH, generic=True),
    ),
    ("shove", Verb(_D.PUSH, strength=1.3)),
    (
        "speed, race, rush, dash, hurtle, dart, scoot, careen, speed off, speed away, dash off, race off, "
        "rush off, shoot off, whisk away, whisk ~ away, whisk off, whiz, whizz, streak, scurry, hurry",
        Verb(_D.PUSH, strength=1.3),
    ),
    ("nudge, ease, creep, waft, crawl, budge", Verb(_D.PUSH, strength=0.5)),
    ("retreat, recede, withdraw, back away, back off", Verb(_D.PUSH, direction="away")),
    ("approach us, approach the camera, approach the viewer", Verb(_D.PUSH, direction="toward")),
    ("pull, drag, tug, draw, haul, tow, attract, suck", Verb(_D.PUSH, pulls=True)),
    ("yank, jerk", Verb(_D.PUSH, strength=1.3, pulls=True)),
    ("blow", Verb(_D.PUSH, wind=True)),
    (
        "lift, raise, rise, hoist, elevate, ascend, pick up, pick ~ up, put up, put ~ up, heave",
        Verb(_D.PUSH, direction="up", bound=True),
    ),
    ("climb", Verb(_D.PUSH, direction="up")),
    ("float, levitate, hover", Verb(_D.PUSH, strength=0.5, direction="up")),
    ("soar, take off, lift off, blast off", Verb(_D.PUSH, strength=1.3, direction="up")),
    (
        "lower, sink, descend, set down, set ~ down, put down, put ~ down, come back down, go back down, "
        "float back down, "
        "sink back down, put ~ back down, set ~ back down, bring ~ back down",
        Verb(_D.PUSH, direction="down", bound=True),
    ),
    # the upper end goes somewhere
    ("bend, lean, tilt, tip, slant, incline", Verb(_D.LEAN)),
    ("droop, sag", Verb(_D.LEAN, direction="down")),
    ("bow, slump, stoop, curtsy", Verb(_D.LEAN, direction="toward")),
    # to and fro
    ("sway, swing, rock, oscillate, undulate, ring", Verb(_D.SWAY)),
    ("wave, waggle, wag, flap", Verb(_D.SWAY, cycles=3)),
    (
        "wobble, wiggle, flutter, teeter, totter, jitter, judder, twitch, shimmy, waver, billow, ripple, seesaw",
        Verb(_D.SWAY, cycles=3, strength=0.8),
    ),
    ("shake, rattle, thrash, flail, convulse", Verb(_D.SWAY, cycles=4)),
    ("jiggle, vibrate, quake, jostle", Verb(_D.SWAY, cycles=4, strength=0.8)),
    ("tremble, shiver, quiver, shudder, rustle", Verb(_D.SWAY, cycles=4, strength=0.5)),
    ("bob", Verb(_D.SWAY, direction="up")),
    ("nod", Verb(_D.SWAY, direction="toward")),
    # deformation
    ("stretch, elongate, extend, lengthen, widen, broaden, distend", Verb(_D.SCALE, direction="right")),
    (
        "pull apart, pull ~ apart, spread, draw out, pull ~ in opposite directions",
        Verb(_D.SCALE, direction="right"),
    ),
    (
        "tear, tear apart, tear ~ apart, rip, rip apart, rip ~ apart, split",
        Verb(_D.SCALE, strength=MAGNITUDE_MAX, direction="right"),
    ),
    ("press, compress, squash, flatten, squish, mash", Verb(_D.SCALE, sign=-1, direction="up")),
    ("crush, crumple, cave in", Verb(_D.SCALE, sign=-1, strength=1.3, direction="up")),
    (
        "squeeze, pinch, narrow, constrict, push together, push ~ together, press together, press ~ together",
        Verb(_D.SCALE, sign=-1, direction="right"),
    ),
    (
        "expand, inflate, swell, enlarge, grow, puff up, puff ~ up, plump up, plump ~ up, fluff up, fluff ~ up, "
        "bloat, "
        "dilate",
        Verb(_D.SWELL),
    ),
    ("shrink, contract, deflate, shrivel, let ~ air out, let air out, lose air", Verb(_D.SWELL, sign=-1)),
    # blows
    (
        "hit, strike, kick, punch, knock, bump, bat, swat, collide, impact, lurch, boot, thump, swipe, jab, "
        "cuff, bonk, punt",
        Verb(_D.STRIKE),
    ),
    ("knock on, knock at, rap on", Verb(_D.STRIKE, direction="away")),
    ("pummel, batter, pelt, buffet", Verb(_D.STRIKE, strokes=3)),
    ("slap, poke, prod, bounce off", Verb(_D.STRIKE, strength=0.8)),
    ("tap, flick, pat", Verb(_D.STRIKE, strength=0.5)),
    (
        "jolt, whack, smack, bang, ram, wallop, clobber, thwack, clout, crash into, run into",
        Verb(_D.STRIKE, strength=1.3),
    ),
    ("smash, slam, pound, hammer", Verb(_D.STRIKE, strength=MAGNITUDE_MAX)),
    ("throw, toss, chuck, lob, sling", Verb(_D.STRIKE, direction="up", gravity=True)),
    ("fling, hurl", Verb(_D.STRIKE, strength=1.3, direction="up", gravity=True)),
    ("launch, shoot, catapult", Verb(_D.STRIKE, strength=1.3, direction="up")),
    ("explode, burst, blow up, pop, erupt, detonate, blow ~ apart", Verb(_D.BURST, strength=MAGNITUDE_MAX)),
    # rotation
    (
        "spin, swirl, stir, whirl, twirl, screw, gyrate, pirouette, swivel, turn around, turn ~ around",
        Verb(_D.TURN, direction="up"),
    ),
    ("twist, wring", Verb(_D.TURN, direction="up", wrings=True)),
    ("turn, pivot", Verb(_D.TURN, direction="up")),
    ("round and round, around and around", Verb(_D.TURN, direction="up", generic=True)),
    ("rotate, revolve", Verb(_D.TURN, direction="up")),
    (
        "flip, upend, somersault, tumble, cartwheel, turn over, turn ~ over, roll over, roll ~ over, "
        "turn upside down, turn ~ upside down, flip upside down, flip ~ upside down, flip over, flip ~ over",
        Verb(_D.TURN, direction="toward"),
    ),
    ("backflip, back flip", Verb(_D.TURN, direction="left")),
    ("front flip, frontflip", Verb(_D.TURN, direction="right")),
    ("roll", Verb(_D.ROLL)),
    # gravity
    (
        "drop, fall, plummet, plunge, land, let fall, let ~ fall, fall down, collapse, bounce, "
        "let ~ fall down, let ~ drop down, "
        "release ~ from, let ~ drop, hit the ground, hit the floor, strike the ground, "
        "touch the ground, reach the ground, hit the table, crash to the ground, crash down, "
        "come down, plop, plunk, plonk, nosedive, crash to the floor, drop down, crash, bounce off the ground, "
        "bounce off the floor",
        Verb(_D.FALL),
    ),
    (
        "knock ~ off its feet, sweep ~ off its feet, knock ~ off balance, topple, capsize, flop over, "
        "go over sideways, fall over, tip over, tip ~ over, keel over, topple over, "
        "overturn, knock over, let ~ fall over, let ~ tip over, let ~ topple over, "
        "knock ~ over, push over, push ~ over, blow over, blow ~ over, kick over, kick ~ over",
        Verb(_D.TOPPLE),
    ),
    ("jump, leap, hop, vault, spring up", Verb(_D.JUMP, direction="up", gravity=True)),
    # states
    (
        "hold, fix, anchor, clamp, pin, attach, glue, nail, bolt, root, fasten, tie, stick, weld, strap, tape, "
        "screw to, "
        "screw down, screw onto, "
        "secure, mount, hold ~ there, keep ~ there, hold ~ that way, keep ~ that way, keep ~ so, hold ~ so, "
        "hold ~ in place, keep ~ in place, keep ~ fixed, hold ~ fixed, "
        "hold ~ still, keep ~ still, stay there, remain there, stay that way, remain that way, stay so, remain so",
        Verb(_D.HOLD),
    ),
    ("hang, suspend, dangle", Verb(_D.HOLD, holds="top")),
    (
        "let go, let ~ go, release, rebound, recoil, recover, relax, spring back, snap back, "
        "swing back, bounce back, come back, is back, be back, return, go back, move back to, let ~ spring back, "
        "let ~ snap back, let ~ swing back, let loose, regain its shape, let ~ relax, "
        "let ~ recover, spring back upright, return upright, come back upright, snap back upright, "
        "swing back upright, coast, set free, leave alone, leave ~ alone, die down, subside, calm down, fall back, "
        "free itself, "
        "die away, die out, straighten, straighten up, straighten itself, straighten ~ up, "
        "right itself",
        Verb(_D.RELEASE),
    ),
    ("stand, sit, stay, remain, rest, lie", Verb(_D.STILL, generic=True)),
    (
        "is calm, be calm, is quiet, stop, halt, cease, freeze, wait, pause, stand still, stay still, remain still, "
        "bring ~ to a stop, bring ~ to a halt, bring ~ to rest, short pause, short break, short rest, keep still, "
        "hold still, come to rest, come to a stop, "
        "come to a halt, settle, be still, "
        "is still, nothing happens, nothing moves, stay put, stay in place, remain in place, "
        "remain motionless, lie still, sit still, is motionless, is at rest, at rest, motionless, "
        "immobile, motionlessly, do nothing, does nothing, without motion, stationary, "
        "stay as it is, remain as it is, stay where it is, remain where it is, stay motionless, come to a standstill, "
        "hang still, stop dead, stop ~ dead, stand upright, stay upright, remain upright",
        Verb(_D.STILL),
    ),
)

# Nouns that name a cause; used as the verb if the clause has no other.
_CAUSE_ROWS: tuple[tuple[str, Verb], ...] = (
    ("wind, winds, air, airflow, fan, wind gusts, draft, draught, current", Verb(_D.PUSH, wind=True)),
    ("breeze, breezes, puff, puff of air", Verb(_D.PUSH, strength=0.6, wind=True)),
    (
        "gust, gusts, squall, squalls, gust of wind, gusts of wind, blast of wind, blast of air",
        Verb(_D.PUSH, strength=1.2, brief=True, wind=True),
    ),
    (
        "storm, hurricane, gale, tornado, typhoon, tempest, blizzard",
        Verb(_D.PUSH, strength=MAGNITUDE_MAX, wind=True),
    ),
    ("explosion, blast, detonation, bomb", Verb(_D.BURST, strength=MAGNITUDE_MAX)),
    (
        "collision, blow, impact, header, impulse, initial velocity, shock wave, shockwave",
        Verb(_D.STRIKE),
    ),
    ("uppercut", Verb(_D.STRIKE, direction="up")),
    # nouns of what verbs do
    ("translation, displacement, acceleration, propulsion", Verb(_D.PUSH)),
    ("elevation, ascent, levitation", Verb(_D.PUSH, direction="up")),
    ("expansion, inflation, enlargement", Verb(_D.SWELL)),
    ("contraction, deflation, shrinkage", Verb(_D.SWELL, sign=-1)),
    (
        "elongation, extension, tensile load, tensile loading, tensile force",
        Verb(_D.SCALE, direction="right"),
    ),
    (
        "compressive load, compressive loading, compressive force, compressive stress",
        Verb(_D.SCALE, sign=-1, direction="up"),
    ),
    ("revolution, gyration", Verb(_D.TURN, direction="up")),
    ("inclination", Verb(_D.LEAN)),
    ("earthquake, tremor", Verb(_D.SWAY, cycles=4, strength=1.3)),
    ("compression, pressure", Verb(_D.SCALE, sign=-1, direction="up")),
    ("tension", Verb(_D.SCALE, direction="right")),
    (
        "rotation, torque, angular velocity, angular impulse, angular acceleration",
        Verb(_D.TURN, direction="up"),
    ),
    ("torsion", Verb(_D.TURN, direction="up", wrings=True)),
    ("vibration, vibrations, oscillation, harmonic motion", Verb(_D.SWAY, cycles=4)),
    ("force", Verb(_D.PUSH)),
    ("suction", Verb(_D.PUSH, pulls=True)),
)

# Adjectives that say how the object becomes: "it gets taller".
_RESULT_ROWS: tuple[tuple[str, Verb], ...] = (
    ("taller, higher, more tall, more high", Verb(_D.SCALE, direction="up", generic=True)),
    (
        "wider, longer, broader, more wide, more long, more broad",
        Verb(_D.SCALE, direction="right", generic=True),
    ),
    ("shorter, flatter, flat, more short, more flat", Verb(_D.SCALE, sign=-1, direction="up", generic=True)),
    (
        "thinner, narrower, slimmer, more thin, more narrow, more slim",
        Verb(_D.SCALE, sign=-1, direction="right", generic=True),
    ),
    ("bigger, larger, fatter, more big, more large", Verb(_D.SWELL, generic=True)),
    ("smaller, more small", Verb(_D.SWELL, sign=-1, generic=True)),
)

# Past forms that rules do not derive.
IRREGULAR_FORMS: dict[str, str] = {
    "blow": "blew blown",
    "shake": "shook shaken",
    "swing": "swung",
    "strike": "struck stricken",
    "hit": "hit",
    "throw": "threw thrown",
    "shoot": "shot",
    "spin": "spun",
    "fall": "fell fallen",
    "bend": "bent",
    "lean": "leant",
    "sink": "sank sunk",
    "rise": "rose risen",
    "shrink": "shrank shrunk shrunken",
    "tear": "tore torn",
    "fling": "flung",
    "hold": "held",
    "hang": "hung",
    "stick": "stuck",
    "wring": "wrung",
    "spring": "sprang sprung",
    "let": "let",
    "go": "went gone goes",
    "come": "came come",
    "draw": "drew drawn",
    "fly": "flew flown",
    "drive": "drove driven",
    "sweep": "swept",
    "send": "sent",
    "slide": "slid",
    "swell": "swollen",
    "grow": "grew grown",
    "leap": "leapt",
    "creep": "crept",
    "burst": "burst",
    "stand": "stood",
    "sit": "sat",
    "lie": "lay lying lain",
    "keep": "kept",
    "freeze": "froze frozen",
    "be": "is are was",
    "tie": "tying",
    "do": "does did done",
    "run": "ran",
    "take": "took taken",
    "split": "split",
    "thrust": "thrust",
    "spread": "spread",
    "set": "set",
    "put": "put",
    "slip": "slipped",
    "free": "frees",
    "die": "dying",
    "speed": "sped",
    "ring": "rang rung",
}


def _build_table(rows: tuple[tuple[str, Verb], ...]) -> dict[str, Verb]:
    return {phrase.strip(): verb for phrases, verb in rows for phrase in phrases.split(",")}


def _add_skills(table: dict[str, Verb], words: Callable[[Skill], tuple[str, ...]]) -> dict[str, Verb]:
    """The table with the words of skills: what it knows of them already stays."""
    named = {word: skill for skill in list_skills("actions") for word in words(skill)}
    return table | {
        word: replace(table.get(word) or _make_verb(skill), skill=skill.name) for word, skill in named.items()
    }


def _make_verb(skill: Skill) -> Verb:
    """A word of a skill, which is read like the words of the skill's kind."""
    effect = Effect.STRIKE if skill.is_sudden else Effect.TURN if skill.is_axis else Effect.PUSH
    effect = Effect.SCALE if skill.is_two_sided else effect
    return Verb(effect, direction=skill.towards, brief=skill.is_brief, skill=skill.name)


VERBS = _add_skills(_build_table(_VERB_ROWS) | _build_table(_RESULT_ROWS), lambda skill: skill.verbs)
CAUSES = _add_skills(_build_table(_CAUSE_ROWS), lambda skill: skill.nouns)

# Verbs whose clockwise is meant in the picture plane; the others turn about the vertical, seen from above.
PICTURE_PLANE_TURNS = frozenset({"rotate", "revolve", "flip", "tumble", "cartwheel", "somersault", "roll"})
# Their direction is where the top goes.
LANDINGS = frozenset(
    {"land", "reach the ground", "hit the ground", "hit the floor", "strike the ground", "touch the ground"}
)
"""Ends of a fall: told after a fall, they tell of the same one."""
TUMBLES = frozenset(
    {"flip", "tumble", "somersault", "cartwheel", "turn over", "turn ~ over", "roll over", "roll ~ over"}
    | {"backflip", "back flip", "front flip", "frontflip"}
)
WHOLE_TURNS = frozenset({"somersault", "cartwheel", "backflip", "back flip", "front flip", "frontflip"})
"""They turn all the way round unless the sentence says otherwise."""
# They turn by half a turn unless the sentence says otherwise.
TURNED_OVER = frozenset(
    {f"{verb} {way}" for verb in ("turn", "turn ~", "flip", "flip ~") for way in ("upside down", "over")}
)
# After "the", these are things rather than verbs ("the rock rocks").
NOUNS_AFTER_THE = frozenset(
    {
        "rock",
        "wave",
        "bow",
        "land",
        "hammer",
        "bat",
        "screw",
        "fly",
        "root",
        "nail",
        "bolt",
        "rest",
        "tip",
        "stick",
        "ram",
        "boot",
        "ring",
        "tape",
        "strap",
        "race",
        "rush",
        "dash",
        "speed",
        "streak",
        "incline",
        "slant",
        "exit",
        "guide",
        "dart",
        "sail",
        "ripple",
    }
)
