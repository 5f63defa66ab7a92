"""Schemas of what is asked and what is seen of it: the scene brief, expected motions, the judgement.

Pure data: no arrays, no jax. Frames are the unit of time, body lengths the unit of length. ``words`` are those of the
sentence that led to a value.
"""

from __future__ import annotations

import enum
from typing import Annotated, Literal

from pydantic import Field

from physagent_jax.core.strict import Count, Direction, Number, Numbers, Strict
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN, find_reference_time
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion

Manner = Literal["", "bend", "rock", "wobble", "shake", "fly", "fold", "crumple", "hinge", "detach", "split"]
"""The manner of a motion: it bends over its foot, which stays; it tilts over the edges of its foot as a whole; its foot
stays and its own stiffness does the rest; it goes to and fro, foot and all; it leaves the ground; one half
goes over the other; it is pressed from one side after another; it turns about its hinge; it comes off; it
comes apart in two halves; or any ("")."""
SeenManner = Manner | Literal["spin", "circle", "slash"]
"""The same of what is to be seen; what spins shows all of its sides, a circle is gone along, heading first, and what
is swung as a sword turns about the end that it is held by."""
LAST_FRAME = 1e5
_Frame = Annotated[float, Field(ge=0, le=LAST_FRAME)]
_Degrees = Annotated[float, Field(ge=-360, le=360)]


class Verdict(enum.StrEnum):
    """The planner's binary judgement."""

    SUCCESS = "SUCCESS"
    FAIL = "FAIL"


class MotionKind(enum.StrEnum):
    """The kinds of motion that a sentence can ask for and pictures can show."""

    MOVE = "move"  # net displacement along `direction` (push, pull, blow, kick)
    SWAY = "sway"  # bend away from rest and come back, once or repeatedly
    FALL = "fall"  # move along gravity, perhaps bounce
    STRETCH = "stretch"  # extent along +-`direction` grows
    SQUEEZE = "squeeze"  # extent along +-`direction` shrinks
    ROTATE = "rotate"  # turn about `direction` (right-hand rule)
    STILL = "still"  # nothing moves


class DirectionTable(Strict):
    """The viewer's words as unit world vectors, derived from the reference camera and world up.

    Attributes:
        right, left: Along the image's horizontal axis.
        up, down: World up and its opposite.
        toward, away: Towards the camera (horizontally) and away from it.
    """

    right: Numbers
    left: Numbers
    up: Numbers
    down: Numbers
    toward: Numbers
    away: Numbers


class FootEdge(Strict):
    """A straight edge of what an object stands on.

    Attributes:
        way: The level way across it, outwards (unit world vector).
        reach: Its distance from the middle of the object [body lengths].
    """

    way: Numbers
    reach: float = Field(ge=0, le=10)


class SceneBrief(Strict):
    """The facts about a scene that an agent may use.

    Attributes:
        object_name: What the object is called ("robot", "plant", ...), from the file name or the user.
        object_kind: Class with a physical prior: "plant", "food", "jelly", "robot", "instrument", "animal", "object".
        object_nouns: Nouns that may name it beside its name: those of its kind, or of all kinds if that is unknown.
        anchored: What is held fixed, in words; None if the object is free.
        may_be_held: Whether what is free may be held, at once or in a later round: the user has not chosen.
        frame_count: Number of frames of the clip.
        frames_fixed: Whether the user fixed that number; else the semantic agent may ask for another
            (`SemanticReply.frame_count`).
        frame_dt: Seconds per frame [s].
        size: The object's longest side [m].
        long_axis: World axis along which the object is clearly longest; None if it has none.
        extents: Its width, height and depth as the viewer sees it [body lengths].
        box: Its extents along the world's axes [body lengths]; None = not measured.
        edges: The straight edges of its foot; none where that is round.
        world: "ground": gravity acts and the object stands on the ground, unless the sentence says otherwise; "free":
            it floats at rest in empty space.
        reach: Distance from its middle to the nearest wall of the space that is simulated [body lengths].
        rigid: Whether it is simulated as a rigid body, whose shape cannot change.
        directions: The direction table.
    """

    object_name: str
    object_kind: str = "object"
    object_nouns: tuple[str, ...] = ()
    anchored: str | None = None
    may_be_held: bool = False
    frame_count: int = Field(ge=1, le=10_000)
    frames_fixed: bool = False
    frame_dt: float = Field(ge=1e-6, le=100)
    size: float = Field(default=1.0, ge=1e-6, le=1e6)
    long_axis: Numbers | None = None
    extents: Numbers = (1.0, 1.0, 1.0)
    box: Numbers | None = None
    edges: tuple[FootEdge, ...] = ()
    world: Literal["ground", "free"] = "free"
    reach: float = Field(default=1e5, ge=0, le=1e6)
    rigid: bool = False
    directions: DirectionTable
    parts: tuple[Part, ...] = ()

    def find_room(self, way: Numbers) -> float:
        """The distance that it can go a way (unit world vector) before it meets a wall of that space [body lengths]."""
        table = self.directions
        lines = zip((table.right, table.up, table.toward), self.extents)
        half = sum(abs(sum(a * b for a, b in zip(way, line))) * extent / 2 for line, extent in lines)
        return max(self.reach - half, 0.0)

    @property
    def last(self) -> float:
        """Index of the clip's last frame."""
        return self.frame_count - 1.0

    @property
    def seconds(self) -> float:
        """Duration of the clip [s]."""
        return self.last * self.frame_dt

    def count_frames(self, seconds: float) -> float:
        """Frames that a time [s] takes; half of what a window can name at most."""
        return min(seconds / self.frame_dt, 0.5 * LAST_FRAME)

    @property
    def reference_seconds(self) -> float:
        """T of the skills [s]."""
        return find_reference_time(self.anchored is not None, self.seconds)


class AnchorRequest(Strict):
    """A request of the prompt to hold or release the object.

    Attributes:
        kind: "base" (a slab at the foot), "top", "rest" (``region``: all but the parts that move), "none" (explicitly
            free), or None (says nothing).
        described: True if a word describes the object so ("potted"); False if the sentence asks that it be held.
    """

    kind: Literal["base", "top", "rest", "none"] | None = None
    words: str = ""
    described: bool = False
    region: CellsRegion | None = None


class ObstacleRequest(Strict):
    """A solid that the sentence names.

    Attributes:
        kind: "wall" stands upright or hangs overhead across the way; "block" is a box beside the object.
        direction: Where it is, seen from the object (unit world vector).
        distance: Distance of its face from the object's nearest side [body lengths].
    """

    kind: Literal["wall", "block"] = "wall"
    direction: Direction
    distance: float = Field(default=0.6, ge=0, le=10)
    words: str = ""


class WorldRequest(Strict):
    """A request of the sentence about the surroundings; None = nothing.

    Attributes:
        gravity: "up" is reversed.
        ground: Whether there is ground under the object.
        obstacles: Walls and blocks that it names.
        drop_height: Height above the ground from which the object falls [body lengths].
        attitude: Rotation of the object before it begins, about the world's x and y axes together (a rotation vector)
            [degrees]: "drop it upside down".
        restitution: Coefficient of restitution of what is hard, where it is to rebound from a wall [1].
    """

    gravity: Literal["down", "up", "none"] | None = None
    ground: bool | None = None
    obstacles: tuple[ObstacleRequest, ...] = ()
    drop_height: float | None = Field(default=None, ge=0, le=1e5)
    attitude: tuple[_Degrees, _Degrees] | None = None
    restitution: float | None = Field(default=None, ge=0, le=1)
    words: str = ""


class Amount(Strict):
    """A quantity that the sentence names: a target, whatever ``strength`` says.

    Attributes:
        value: How much; at least 0.
        unit: "lengths" [body lengths], "metres", "degrees", "factor" (of the extent along the direction: 2 = twice as
            long, 0.5 = half), "seconds" (how long the cause lasts).
    """

    value: float = Field(ge=0, le=1e5)
    unit: Literal["lengths", "metres", "degrees", "factor", "seconds"]


class ExpectedMotion(Strict):
    """One motion that the sentence asks for: the planner's yardstick.

    Attributes:
        kind: What should be seen.
        direction: World direction or axis; None where the kind needs none (fall, still) and for a stretch
            or squeeze in all directions.
        strength: 0.4 (slight) .. 1.0 (plain) .. 1.6 (violent).
        window: [first, last] frames in which it should be seen.
        repeats: How often the motion should reverse or recur; 1 = once.
        released: True if the cause stops before the clip ends ("then lets go").
        springs: True if it then comes back as a spring does, fast and a little too far.
        sudden: True if the motion starts with a blow rather than from rest.
        partial: True if only a part of the object is acted on, so that the whole moves less.
        part: The end that is named (unit world vector towards it: the top is up); None = the whole, or a part that is
            no end.
        limb: Place in the brief's parts of the part that is asked about; None = none of them.
        excludes_part: True if ``part`` is the one that should not move ("everything except the head").
        stays: True if it is to stay where it was brought ("and hold it there").
        even: True if it is to go at one speed ("evenly", "at a constant speed").
        leaves_place: True if a move takes the object as a whole from its place: it is thrown, it jumps, it slides or
            is carried, or it goes a told distance. False for what may as well bend an object whose foot is held.
        put_back: True if a move brings it back to where it was, or down to what it stood on.
        may_stop_short: True if a turn over may as well end on its back, and a door half open: no number tells how far.
        to_ground: True if the way ends at the ground ("bend its head down to the ground").
        rebounds: How often it comes up again from what it falls onto.
        counted: False if no word tells how often: ``repeats`` or ``rebounds`` is then one number among many.
        jiggles: True if any change of place, tilt or shape that comes and goes is one ("wobble").
        means: True if it only makes possible what is asked, as a lift before a drop.
        manner: How it goes on.
        amount: A quantity that the sentence names; None = none.
    """

    kind: MotionKind
    direction: Numbers | None = None
    strength: float = Field(default=1.0, ge=MAGNITUDE_MIN, le=MAGNITUDE_MAX)
    window: tuple[_Frame, _Frame]
    repeats: int = Field(default=1, ge=1, le=10_000)
    rebounds: int = Field(default=0, ge=0, le=10_000)
    released: bool = False
    springs: bool = False
    sudden: bool = False
    partial: bool = False
    part: Numbers | None = None
    limb: Count | None = None
    excludes_part: bool = False
    stays: bool = False
    even: bool = False
    leaves_place: bool = False
    put_back: bool = False
    may_stop_short: bool = False
    to_ground: bool = False
    counted: bool = True
    jiggles: bool = False
    means: bool = False
    manner: SeenManner = ""
    amount: Amount | None = None
    words: str = ""


class Check(Strict):
    """One comparison of an expectation with the report.

    Attributes:
        expectation: Index into the expectations.
        question: What was asked of the pictures.
        expected: The acceptable range, in words.
        observed: What was seen, in words.
        passed: None if not observable.
        aspect: Which property of the motion was compared; tells the executor which remedies apply.
        score: 0 (contrary) .. 1 (as asked).
        margin: How far inside (> 0) or outside (< 0) of its limits the value lies, in tolerances: smooth, 1 at the
            value aimed at; None if not observable.
        confidence: Chance that the verdict of this check would be the same without errors of perception, 0.5 .. 1.
        gain: Factor by which the cause's magnitude should change to meet the expectation; negative =
            reverse it; None = magnitude is not the remedy.
        remedy: What to change, in one sentence; empty if passed.
    """

    expectation: Count
    question: str
    expected: str
    observed: str
    passed: bool | None
    aspect: Literal[
        "amount", "direction", "repeats", "return", "stillness", "part", "order", "collateral", "integrity"
    ] = "amount"
    score: float = Field(ge=0, le=1)
    margin: Number | None = None
    confidence: float = Field(default=1.0, ge=0, le=1)
    gain: Number | None = None
    remedy: str = ""


class StageVerdict(enum.StrEnum):
    """The verdict on one stage of a sentence."""

    MET = "met"
    NOT_MET = "not met"
    NOT_SEEN = "not seen"


class Stage(Strict):
    """One step of a sentence, judged by itself: the motions that begin together.

    Attributes:
        expectations: Indices of its motions.
        window: [first, last] frames of its motions.
        verdict: Met, if all of its checks passed; not met, if one failed; not seen, if one could not be made.
        asked: The range in words of the check that decides it, with its question.
        measured: The value seen in words.
        misfit: What the worst of its checks is short of a full score, in [0, 1]; 0 = met.
    """

    expectations: tuple[Count, ...]
    words: str = ""
    window: tuple[_Frame, _Frame]
    verdict: StageVerdict
    asked: str = ""
    measured: str = ""
    misfit: float = Field(default=0.0, ge=0, le=1)


class Judgement(Strict):
    """The planner's answer: SUCCESS, or FAIL with a suggestion; that alone is a complete judgement.

    Attributes:
        verdict: Whether the motion is what the sentence asks for.
        score: 0 (contrary) .. 1 (as asked), ranks the rounds; None = the planner gives none.
        checks: Every comparison made, if the planner judges by comparisons.
        stages: The sentence's steps in order, each with its own verdict, if the planner judges them one by one.
        suggestion: What the executor should change, in words (empty on SUCCESS).
        notes: How it came about, in plain sentences: a model's comparison, a disagreement between judges.
    """

    verdict: Verdict
    score: float | None = Field(default=None, ge=0, le=1)
    checks: tuple[Check, ...] = ()
    stages: tuple[Stage, ...] = ()
    suggestion: str = ""
    notes: tuple[str, ...] = ()

    @property
    def stages_met(self) -> int:
        """The number of stages that came true."""
        return sum(stage.verdict is StageVerdict.MET for stage in self.stages)
