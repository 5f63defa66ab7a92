"""The intent of a sentence that was read into clauses of mentions."""

from __future__ import annotations

from physagent_jax.agents import intent
from physagent_jax.agents.lexicon import Effect, Place, Repeat, read_lexicon
from physagent_jax.agents.rules.language.clauses import Clause, get_verb
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import ADDRESSEES, GROUND_WORDS, OPPOSITE_GRAVITY, Join
from physagent_jax.agents.rules.language.quantities import Quantity
from physagent_jax.agents.rules.language.solids import Solid
from physagent_jax.agents.rules.language.timing import Duration, TimeSpan

_RELATIONS = {
    MentionKind.DIRECTION: intent.Relation.TO,
    MentionKind.FROM: intent.Relation.FROM,
    MentionKind.AXIS: intent.Relation.ALONG,
    MentionKind.PLANE: intent.Relation.IN,
    MentionKind.SIDES: intent.Relation.TO,
    MentionKind.REVERSAL: intent.Relation.TO,
}
_STRENGTHS = (MentionKind.DEGREE, MentionKind.INTENSITY, MentionKind.COMPARATIVE)
_UNITS = {
    "second": ("seconds", 1.0),
    "millisecond": ("seconds", 0.001),
    "frame": ("frames", 1.0),
    "clip": ("clip", 1.0),
}
_SIDES = {True: "all", False: "both"}
_LONGEST, _MOST_CLAUSES, _MOST_WORDS, _MOST_WAYS = 200, 100, 1000, 20  # as in `agents.intent`


def make_intent(
    clauses: list[Clause], mentions: list[Mention], unknown: list[str], notes: list[str]
) -> intent.Intent:
    """The intent of clauses, with what stands between them."""
    told = [clause for clause in clauses if clause.head is not None]
    if len(told) > _MOST_CLAUSES:
        notes = [*notes, f"Of {len(told)} clauses the first {_MOST_CLAUSES} are used."]
        told = told[:_MOST_CLAUSES]
    doubts = [doubt for clause in told for doubt in _list_doubts(clause)]
    return intent.Intent(
        clauses=tuple(_make_clause(clause, clauses) for clause in told),
        held=_find_held(clauses),
        surroundings=_describe_surroundings(clauses, mentions),
        unknown=tuple(word[:_LONGEST] for word in unknown[:_MOST_WORDS]),
        doubts=tuple(doubts[:_MOST_CLAUSES]),
        notes=tuple(note[:_MOST_WORDS] for note in notes[-_MOST_CLAUSES:]),
    )


def _make_clause(clause: Clause, clauses: list[Clause]) -> intent.Clause:
    """A clause in words."""
    held = _names_held_end(clause, clauses)
    waits = _is_posture(clause) and clause.select(MentionKind.TIME)  # "rest for a while"
    motion = "hold" if held else "wait" if waits else _name_motion(clause.verb)
    cause = _name_motion(clause.cause) or ("gravity" if clause.select(MentionKind.GRAVITY) else "")
    senses, views = clause.select(MentionKind.SENSE), clause.select(MentionKind.VIEW)
    mentions = [m for m in clause.mentions if m.words] or [m for m in (clause.verb, clause.cause) if m]
    return intent.Clause.model_validate(
        dict(
            motion=motion,
            cause=None if held else cause or None,
            order=_find_order(clause),
            ways=_list_ways(clause),
            turning=("counterclockwise" if senses[0].value == 1 else "clockwise") if senses else None,
            seen_from=views[0].value[0] if views and isinstance(views[0].value, tuple) else None,
            parts=_list_parts(clause),
            strength=tuple(
                _name_strength(mention)
                for mention in clause.select(*_STRENGTHS)
                if mention.phrase != "as strong"
            )[:_MOST_WAYS],
            quantities=_list_quantities(clause),
            timing=_find_timing(clause),
            repetitions=_list_repetitions(clause),
            solids=tuple(_make_solid(mention) for mention in clause.select(MentionKind.SOLID)),
            negated=clause.negated and not held,
            inherited=clause.inherited,
            stays=clause.stays,
            even=bool(clause.select(MentionKind.EVEN)),
            said=clause.words[:_LONGEST],
            text=" ".join(m.words for m in sorted(mentions, key=lambda m: m.first))[:_LONGEST],
        )
    )


def _find_order(clause: Clause) -> str:
    if clause.join is Join.WHILE:
        return "together"
    if clause.join is Join.COMMA and _is_posture(clause) and not clause.select(MentionKind.TIME):
        return "and"  # "..., the rest stays"
    return "then" if clause.join in (Join.THEN, Join.COMMA, Join.BEFORE, Join.AFTER) else "and"


def _is_posture(clause: Clause) -> bool:
    """Return whether it tells how the object stands, sits or stays."""
    motion = get_verb(clause.head)
    return motion.effect is Effect.STILL and motion.generic


def _name_motion(mention: Mention | None) -> str:
    """The lexicon's word for what a mention does: its own phrase, or another one of the same meaning."""
    if mention is None:
        return ""
    motion, lexicon = get_verb(mention), read_lexicon()
    table = lexicon.motions if mention.kind is MentionKind.VERB else lexicon.causes
    if table.get(mention.phrase) == motion:
        return mention.phrase
    return next((phrase for phrase, value in table.items() if value == motion), mention.phrase)


def _name_strength(mention: Mention) -> str:
    """A word for strength; what is denied is its opposite."""
    lexicon = read_lexicon()
    table = {
        MentionKind.DEGREE: lexicon.degrees,
        MentionKind.INTENSITY: lexicon.intensities,
        MentionKind.COMPARATIVE: lexicon.comparatives,
    }[mention.kind]
    if table.get(mention.phrase) == mention.value:
        return mention.words if mention.words.lower() == mention.phrase else mention.phrase
    return f"not {mention.phrase}"


def _list_ways(clause: Clause) -> tuple[intent.Way, ...]:
    sways = clause.verb is not None and get_verb(clause.verb).effect is Effect.SWAY
    found = [
        mention for mention in clause.select(*_RELATIONS) if not (sways and mention.phrase in ADDRESSEES)
    ]  # "wave to us"
    ways = [
        intent.Way(relation=_RELATIONS[mention.kind], word=_name_way(mention), text=mention.words[:_LONGEST])
        for mention in found
    ]
    out = [m for m in clause.select(MentionKind.ANCHOR) if m.phrase.startswith("out of")]
    if out and not ways:  # "pull it out of the pot"
        ways = [intent.Way(word="up", text=out[0].words)]
    return tuple(ways[:_MOST_WAYS])


def _name_way(mention: Mention) -> str:
    """The lexicon's word for a way."""
    lexicon = read_lexicon()
    if mention.kind is MentionKind.REVERSAL:
        return "same" if mention.value == "same" else "other"
    if mention.kind is MentionKind.SIDES:
        return mention.phrase if lexicon.sides.get(mention.phrase) == _SIDES[bool(mention.value)] else "apart"
    if mention.phrase == "back":
        return "back"
    table = {MentionKind.AXIS: lexicon.axes, MentionKind.PLANE: lexicon.planes}.get(mention.kind)
    if table is None:
        table = lexicon.directions
    if table.get(mention.phrase) == mention.value:
        return mention.phrase
    return " ".join(mention.value) if isinstance(mention.value, tuple) else mention.phrase


def _list_parts(clause: Clause) -> tuple[intent.Part, ...]:
    return tuple(
        intent.Part(
            word=_name_part(mention),
            excluded=mention.kind is MentionKind.EXCLUDED,
            text=mention.words[:_LONGEST],
        )
        for mention in clause.select(MentionKind.PLACE, MentionKind.EXCLUDED)
        if isinstance(mention.value, Place) and not _lands_on(mention, clause)
    )


def _lands_on(mention: Mention, clause: Clause) -> bool:
    """Return whether it falls on that part: "lands on its feet", but not "its feet fall"."""
    falls = clause.verb is not None and get_verb(clause.verb).effect is Effect.FALL
    down = isinstance(mention.value, Place) and mention.value.names == ("down",)
    return falls and down and clause.verb is not None and mention.first > clause.verb.first


def _name_part(mention: Mention) -> str:
    """The lexicon's words for a part: its own phrase, or a side with a noun for where it begins."""
    place, lexicon = mention.value, read_lexicon()
    assert isinstance(place, Place)
    if lexicon.parts.get(mention.phrase) == place:
        return mention.phrase
    side = " ".join(place.names)
    nouns = [noun for noun, start in lexicon.part_nouns.items() if start == place.start and noun != "third"]
    own = mention.phrase.split()[-1]
    return f"{side} {own if own in nouns else nouns[0]}" if nouns else side


def _list_quantities(clause: Clause) -> tuple[intent.Quantity, ...]:
    found = []
    for mention in clause.select(MentionKind.QUANTITY):
        assert isinstance(mention.value, Quantity)
        told = mention.value
        relation = "is" if told.acts else "to" if told.goal else "by" if told.relative else ""
        found.append(
            intent.Quantity.model_validate(
                dict(
                    value=min(told.value, 1e9),
                    unit=told.unit or "other",
                    dimension=told.dimension,
                    relation=relation,
                    text=mention.words[:_LONGEST],
                )
            )
        )
    for mention in clause.select(MentionKind.COMPARATIVE):
        if mention.phrase == "as strong":
            assert isinstance(mention.value, float)
            found.append(
                intent.Quantity(
                    value=min(mention.value, 1e9),
                    unit="share",
                    dimension="strength",
                    text=mention.words[:_LONGEST],
                )
            )
    return tuple(found[:_MOST_WAYS])


def _find_timing(clause: Clause) -> intent.Timing:
    """What all phrases of time say together."""
    timing = intent.Timing()
    for mention in clause.select(MentionKind.TIME):
        told = mention.value
        assert isinstance(told, TimeSpan)
        update = {}
        if told.start is not None:
            update["starts"] = _make_duration(told.start, mention.words)
        if told.length is not None:
            length = _make_duration(told.length, mention.words)
            update |= {"lasts": length, "within": told.whole, "overall": told.total}
        timing = timing.model_copy(update=update)
    return timing


def _make_duration(told: Duration, words: str) -> intent.Duration:
    unit, factor = _UNITS[told.unit]
    value = min(max(told.value * factor, -1e6), 1e6)
    return intent.Duration.model_validate(dict(value=value, unit=unit, text=words[:_LONGEST]))


def _list_repetitions(clause: Clause) -> tuple[intent.Repetition, ...]:
    found = []
    for mention in clause.select(MentionKind.REPEAT):
        told = mention.value
        assert isinstance(told, Repeat)
        found.append(
            intent.Repetition.model_validate(
                dict(
                    times=None if told.count is None else min(told.count, 1_000_000),
                    often=told.vague,
                    alternating=told.alternate,
                    first=told.names[0] if told.names else None,
                    text=mention.words[:_LONGEST],
                )
            )
        )
    return tuple(found[:_MOST_WAYS])


def _make_solid(mention: Mention) -> intent.Solid:
    solid = mention.value
    assert isinstance(solid, Solid)
    return intent.Solid.model_validate(
        dict(kind=solid.kind, sides=solid.names, opposite=solid.opposite, text=mention.words[:_LONGEST])
    )


def _list_doubts(clause: Clause) -> list[str]:
    """What a clause says twice."""
    times = [(m.value, m.words) for m in clause.select(MentionKind.TIME) if isinstance(m.value, TimeSpan)]
    starts = [words for told, words in times if told.start or words.lower().startswith("at the ")]
    lengths = [words for told, words in times if told.length]
    return [
        f"Which of several times ({', '.join(several)}) is meant is not understood."
        for several in (starts, lengths)
        if len(several) > 1 and not clause.negated
    ]


def _find_held(clauses: list[Clause]) -> intent.Held | None:
    for clause in clauses:
        for mention in clause.select(MentionKind.ANCHOR):
            return intent.Held.model_validate(
                dict(end=mention.value, described=True, text=mention.words[:_LONGEST])
            )
    return None


def _describe_surroundings(clauses: list[Clause], mentions: list[Mention]) -> intent.Surroundings:
    """Gravity ("no gravity" is a NOT before the mention), ground, and solids of clauses without a motion."""
    gravity, ground = None, None
    for before, mention in zip([None, *mentions], mentions):
        negated = before is not None and before.kind is MentionKind.NOT
        if mention.kind is MentionKind.GRAVITY:
            said = OPPOSITE_GRAVITY[str(mention.value)] if negated else str(mention.value)
            gravity = said if gravity in (None, "down") else gravity
        elif negated and mention.phrase in GROUND_WORDS:
            ground = False
    solids = [m for clause in clauses if clause.head is None for m in clause.select(MentionKind.SOLID)]
    words = [m.words for m in mentions if m.kind is MentionKind.GRAVITY]
    return intent.Surroundings.model_validate(
        dict(
            gravity=gravity,
            ground=ground,
            solids=tuple(_make_solid(mention) for mention in solids),
            text=", ".join(words)[:_LONGEST],
        )
    )


def _names_held_end(clause: Clause, clauses: list[Clause]) -> bool:
    """Return whether a clause says of a part that it does not move while the rest does."""
    verb = get_verb(clause.head)
    still = verb.effect is Effect.STILL or (clause.negated and _is_said_of_part(clause))
    ends = [m.value.names for m in clause.select(MentionKind.PLACE) if isinstance(m.value, Place)]
    held = still and bool(ends) and ("up" in ends[0] or "down" in ends[0])
    return held and (clause is clauses[0] or clause.join is not Join.THEN)


def _is_said_of_part(clause: Clause) -> bool:
    """Return whether a part moves rather than is acted on: "its base does not tilt", not "don't hit its head"."""
    head = clause.head
    if head is None or get_verb(head).effect is Effect.STILL:
        return False
    places = [mention.first for mention in clause.select(MentionKind.PLACE)]
    return get_verb(head).generic or min(places, default=0) < head.first
