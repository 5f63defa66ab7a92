"""A reply beside what a person understands: which fields are right."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from benchmarks.language.notation import Clause, Reading, Sentence
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.motion.schema import DirectionTable, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import add, cosine, cross, normalise
from physagent_jax.scene.priors import guess_kind, list_nouns

Fields = list[tuple[str, bool]]
KINDS = {
    "plant": "plant",
    "cow": "animal",
    "guitar": "instrument",
    "jelly": "jelly",
    "loaf": "food",
    "robot": "robot",
    "orchid": "plant",
    "horse": "animal",
    "violin": "instrument",
    "bread": "food",
    "teddy": "toy",
    "vase": "vessel",
    "chair": "furniture",
    "jacket": "object",
    "scan": "object",  # a file name that does not say what it is
    "fern": "plant",
    "fox": "animal",
    "ukulele": "instrument",
    "pudding": "jelly",
    "cake": "food",
    "baguette": "food",
    "droid": "robot",
    "doll": "toy",
    "kettle": "vessel",
    "stool": "furniture",
    "coat": "object",
}  # the others are of the kind that the product guesses from the name
LENGTHWISE, UPRIGHT = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
LONG_AXES = {
    "loaf": LENGTHWISE,
    "bread": LENGTHWISE,
    "guitar": UPRIGHT,
    "violin": UPRIGHT,
    "baguette": LENGTHWISE,
    "ukulele": UPRIGHT,
}  # the others have none
SIZE = 1.6  # [m] so that metres are not lengths
SLIGHT, STRONG = 0.7, 1.2  # strength up to and from which a motion is called so
ALIKE = 0.97  # cosine of directions that are the same to a viewer
WITHOUT_STRENGTH = ("fall", "still")
AXES = ("stretch", "squeeze", "sway")  # either sense is the same


def make_scene(object_name: str) -> SceneBrief:
    """Scene that the parser is told of: a clip of two seconds, seen by a camera that looks along +y."""
    kind = KINDS.get(object_name) or guess_kind(object_name)
    table = DirectionTable(
        right=(1, 0, 0), left=(-1, 0, 0), up=(0, 0, 1), down=(0, 0, -1), toward=(0, -1, 0), away=(0, 1, 0)
    )
    return SceneBrief(
        object_name=object_name,
        object_kind=kind,
        object_nouns=list_nouns(kind),
        anchored="it is rooted" if kind == "plant" else None,
        frame_count=50,
        frame_dt=0.04,
        size=SIZE,
        long_axis=LONG_AXES.get(object_name),
        world="ground",
        directions=table,
    )


def score(sentence: Sentence, reply: SemanticReply | None, brief: SceneBrief) -> Fields:
    """Fields of the reading that fits the reply best; ``reply`` is None if the sentence was refused."""
    scored = [_score_reading(reading, reply, brief) for reading in sentence.readings]
    return max(scored, key=lambda fields: sum(right for _, right in fields) / len(fields))


def get_answer(reply: SemanticReply | None) -> str:
    """In a word: "refused", "unsure" (something is marked as not understood that matters) or "motion"."""
    return "refused" if reply is None else "unsure" if reply.unsure else "motion"


def _score_reading(reading: Reading, reply: SemanticReply | None, brief: SceneBrief) -> Fields:
    answer = get_answer(reply)
    if reading.answer != "motion":
        return [("answer", answer == reading.answer or (answer, reading.answer) == ("refused", "unsure"))]
    clauses = [clause for group in reading.groups for clause in group]
    fields = [("answer", answer == "motion")]
    if reply is None:
        return fields + [(name, False) for clause in clauses for name in ("kind", *_list_fields(clause))]
    fields += _score_motions(reading, reply, brief)
    fields.append(("world", _is_world_right(reading, reply, brief)))
    fields.append(("anchor", _is_anchor_right(reading, reply, brief)))
    return fields


def _score_motions(reading: Reading, reply: SemanticReply, brief: SceneBrief) -> Fields:
    """The best assignment of the reply's motions, in the order of time, to the clauses."""
    clauses = [clause for group in reading.groups for clause in group]
    asked = [motion for motion in reply.expectations if not motion.means]
    found = sorted(asked, key=lambda motion: motion.window)
    if len(found) != len(clauses):
        pairs = list(itertools.zip_longest(clauses, found))[: max(len(clauses), 1)]
        fields: Fields = [("kind", False)]
        for clause, motion in pairs:
            if motion is None:
                fields += [(name, False) for name in _list_fields(clause)]
            else:
                fields += _score_clause(clause, motion, reply, brief)
        return fields
    best: Fields = []
    for order in _list_orders(reading):
        fields = []
        for index, motion in zip(order, found):
            fields += _score_clause(clauses[index], motion, reply, brief)
        if not best or _compute_share(fields) > _compute_share(best):
            best = fields
    if len(clauses) > 1:
        best = [*best, ("order", _is_order_right(reading, found))]
    return best


def _list_orders(reading: Reading) -> Iterator[list[int]]:
    """Places of the clauses, with those of each group in any order."""
    start, places = 0, []
    for group in reading.groups:
        places.append(range(start, start + len(group)))
        start += len(group)
    for choice in itertools.product(*(itertools.permutations(place) for place in places)):
        yield [index for part in choice for index in part]


def _compute_share(fields: Fields) -> float:
    return sum(right for _, right in fields) / len(fields)


def _list_fields(clause: Clause) -> list[str]:
    """Fields that a clause has."""
    names = [] if clause.kind in WITHOUT_STRENGTH else ["direction"]
    if clause.kind not in WITHOUT_STRENGTH and clause.strength != "any" and clause.amount is None:
        names.append("strength")
    return [*names, "amount", "repeats", "part", "time", "state"]


def _score_clause(clause: Clause, motion: ExpectedMotion, reply: SemanticReply, brief: SceneBrief) -> Fields:
    checks = {
        "direction": lambda: _is_direction_right(clause, motion, brief),
        "strength": lambda: clause.strength == _classify(motion.strength),
        "amount": lambda: _is_amount_right(clause, motion, brief),
        "repeats": lambda: _is_count_right(clause, motion),
        "part": lambda: _is_part_right(clause, motion, brief),
        "time": lambda: _is_time_right(clause, motion, reply, brief),
        "state": lambda: _is_state_right(clause, motion, reply),
    }
    fields = [("kind", _is_kind_right(clause, motion))]
    tilts = (
        clause.kind == "lean" and motion.kind is MotionKind.ROTATE
    )  # a smaller turn than "rotate", by itself
    asked = [name for name in _list_fields(clause) if not (tilts and name == "strength")]
    return fields + [(name, checks[name]()) for name in asked]


def _is_kind_right(clause: Clause, motion: ExpectedMotion) -> bool:
    if clause.kind == "hit":
        return motion.kind is MotionKind.MOVE and motion.sudden
    if clause.kind == "lean":
        return motion.kind in (MotionKind.MOVE, MotionKind.ROTATE) and not motion.sudden
    return motion.kind.value == clause.kind


def _resolve(words: str, brief: SceneBrief):
    return normalise(add(getattr(brief.directions, word) for word in words.split("+")))


def _is_direction_right(clause: Clause, motion: ExpectedMotion, brief: SceneBrief) -> bool:
    if clause.direction == "*":
        return True
    if clause.direction == "-" or motion.direction is None:
        return clause.direction == "-" and motion.direction is None
    wanted = _resolve(clause.direction.removeprefix("+-"), brief)
    assert wanted is not None
    if clause.kind == "lean" and motion.kind is MotionKind.ROTATE:
        wanted = cross(brief.directions.up, wanted)
    alike = cosine(wanted, _to_vector(motion.direction))
    either = clause.direction.startswith("+-") or (clause.kind in AXES and "first" not in clause.flags)
    return (abs(alike) if either else alike) > ALIKE


def _to_vector(values) -> tuple[float, float, float]:
    return (values[0], values[1], values[2])


def _classify(strength: float) -> str:
    return "slight" if strength <= SLIGHT else "strong" if strength >= STRONG else "plain"


def _is_amount_right(clause: Clause, motion: ExpectedMotion, brief: SceneBrief) -> bool:
    amount = motion.amount
    if clause.amount is None:
        return amount is None or amount.unit == "seconds"
    if amount is None:
        return False
    metres = {"lengths": brief.size, "metres": 1.0}
    (value, unit), actual = clause.amount, amount.value
    if unit in metres and amount.unit in metres:
        value, actual = value * metres[unit], actual * metres[amount.unit]
    elif unit != amount.unit:
        return False
    return math.isclose(value, actual, rel_tol=0.03)


def _is_count_right(clause: Clause, motion: ExpectedMotion) -> bool:
    if clause.repeats == "*" or (clause.kind == "sway" and not clause.repeats):
        return True
    return motion.repeats == int(clause.repeats or 1)


def _is_part_right(clause: Clause, motion: ExpectedMotion, brief: SceneBrief) -> bool:
    if not clause.part:
        return not motion.partial and motion.part is None
    if clause.part in ("any", "mid"):
        return motion.partial and (clause.part == "any" or motion.part is None)
    if motion.part is None or motion.excludes_part != clause.excluded:
        return False
    return cosine(_resolve(clause.part, brief) or (0, 0, 0), _to_vector(motion.part)) > ALIKE


def _is_time_right(clause: Clause, motion: ExpectedMotion, reply: SemanticReply, brief: SceneBrief) -> bool:
    """Return whether the cause, or the motion where gravity is the cause, has the told length, start and end."""
    length, start, end = clause.span
    if clause.span == (None, None, None):
        return True
    windows = [a.active_time for a in reply.force_field.actions if a.active_time is not None]
    windows += [
        (c.active_time[0], c.held_until or c.active_time[1])
        for c in reply.force_field.constraints
        if c.active_time is not None
    ]
    inside = [w for w in windows if w[0] < motion.window[1] and w[1] > motion.window[0]]
    candidates = [motion.window, *inside]
    if inside:
        candidates.append((min(w[0] for w in inside), max(w[1] for w in inside)))

    def fits(window) -> bool:
        told = ((length, window[1] - window[0]), (start, window[0]), (end, window[1]))
        return all(value is None or abs(value / brief.frame_dt - frame) <= 1.01 for value, frame in told)

    return any(map(fits, candidates))


def _is_state_right(clause: Clause, motion: ExpectedMotion, reply: SemanticReply) -> bool:
    if motion.stays != ("stays" in clause.flags):
        return False
    if "released" in clause.flags and not motion.released:
        return False
    return bool(reply.notes) or "noted" not in clause.flags


def _is_order_right(reading: Reading, found: list[ExpectedMotion]) -> bool:
    """Groups begin one after another; what is in a group overlaps."""
    remaining = iter(found)
    groups = [[next(remaining) for _ in group] for group in reading.groups]
    together = all(
        a.window[0] < b.window[1] and b.window[0] < a.window[1] for g in groups for a in g for b in g
    )
    starts = [min(motion.window[0] for motion in group) for group in groups]
    return together and all(a < b for a, b in zip(starts, starts[1:]))


def _is_world_right(reading: Reading, reply: SemanticReply, brief: SceneBrief) -> bool:
    gravity = reply.world.gravity or ""
    if gravity != reading.gravity and not (gravity == "down" and not reading.gravity):
        return False
    found = reply.world.obstacles
    if len(found) != len(reading.obstacles):
        return False
    return all(
        obstacle.kind == kind
        and (way == "*" or cosine(_resolve(way, brief) or (0, 0, 0), _to_vector(obstacle.direction)) > ALIKE)
        for (kind, way), obstacle in zip(reading.obstacles, found)
    )


def _is_anchor_right(reading: Reading, reply: SemanticReply, brief: SceneBrief) -> bool:
    """Return whether the hold is the one that is expected; the usual one need not be named."""
    usual = "base" if brief.anchored else "none"
    return (reply.anchor.kind or usual) == (reading.anchor or usual)
