"""The intent of a sentence that was read into clauses of mentions: the last step of the grammar."""

from __future__ import annotations

from physagent_jax.agents import intent
from physagent_jax.agents.grammar.clauses import OPPOSITE_GRAVITY, Clause, find_repeats, get_verb
from physagent_jax.agents.grammar.coverage import Coverage
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.grammar.tables import LEXICON
from physagent_jax.agents.lexicon import NAMED, Effect, Join, Place

_RELATIONS = {
    MentionKind.DIRECTION: intent.Relation.TO,
    MentionKind.FROM: intent.Relation.FROM,
    MentionKind.AXIS: intent.Relation.ALONG,
    MentionKind.PLANE: intent.Relation.IN,
    MentionKind.SIDES: intent.Relation.TO,
    MentionKind.REVERSAL: intent.Relation.TO,
}
_WAYS = {MentionKind.AXIS: LEXICON.axes, MentionKind.PLANE: LEXICON.planes}
_STRENGTHS = {
    MentionKind.DEGREE: LEXICON.degrees,
    MentionKind.INTENSITY: LEXICON.intensities,
    MentionKind.COMPARATIVE: LEXICON.comparatives,
}
_SENSES = {1: "counterclockwise", -1: "clockwise"}
_CHOSEN = (MentionKind.VERB, MentionKind.DIRECTION, MentionKind.FROM, MentionKind.SENSE)
_MOST_CLAUSES = 100  # no clip has time for more; the rest is a doubt
_LONGEST, _MOST_TIMES = 200, 1_000_000


def make_intent(
    clauses: list[Clause], mentions: list[Mention], coverage: Coverage, notes: list[str]
) -> intent.Intent:
    """The intent of clauses, with what stands between them."""
    told = [clause for clause in clauses if clause.head is not None]
    doubts = [doubt for clause in told for doubt in _list_doubts(clause)] + _list_choices(mentions)
    if len(told) > _MOST_CLAUSES:
        doubts.insert(0, f"Only the first {_MOST_CLAUSES} of {len(told)} motions are read.")
    return intent.Intent(
        clauses=tuple(_make_clause(clause, clauses) for clause in told[:_MOST_CLAUSES]),
        held=_find_held(clauses),
        surroundings=_describe_surroundings(clauses, mentions),
        ignored=tuple(map(_cut, coverage.ignored)),
        unknown=tuple(map(_cut, coverage.doubtful)),
        unknown_parts=tuple(map(_cut, coverage.parts)),
        doubts=tuple(doubts),
        notes=tuple(notes),
    )


def _make_clause(clause: Clause, clauses: list[Clause]) -> intent.Clause:
    """A clause in words."""
    held = _is_holding_an_end(clause, clauses)
    gravity = "gravity" if clause.select(MentionKind.GRAVITY) else None
    senses, views = clause.select(MentionKind.SENSE), clause.select(MentionKind.VIEW)
    mentions = [m for m in clause.mentions if m.words] or [m for m in (clause.verb, clause.cause) if m]
    return intent.Clause.model_validate(
        dict(
            motion="hold" if held else _name_motion(clause.verb),
            cause=None if held else _name_motion(clause.cause) or gravity,
            order=_find_order(clause),
            ways=_list_ways(clause),
            turning=_SENSES[senses[0].value] if senses and isinstance(senses[0].value, int) else None,
            seen_from=views[0].value[0] if views and isinstance(views[0].value, tuple) else None,
            parts=_list_parts(clause),
            strength=tuple(_name_strength(m) for m in clause.select(*_STRENGTHS) if m.phrase != "as strong"),
            quantities=_list_quantities(clause),
            timing=_find_timing(clause),
            repetitions=_list_repetitions(clause),
            solids=tuple(_make_solid(mention) for mention in clause.select(MentionKind.SOLID)),
            negated=clause.negated and not held,
            inherited=clause.inherited,
            stays=clause.stays,
            pace=next((str(m.value) for m in clause.select(MentionKind.PACE)), ""),
            elsewhere=clause.elsewhere,
            pose=next((m.value for m in clause.select(MentionKind.POSE)), ""),
            said=_cut(clause.words),
            text=_cut(" ".join(m.words for m in sorted(mentions, key=lambda m: m.first))),
        )
    )


def _cut(words: str) -> str:
    return words[:_LONGEST]


def _find_order(clause: Clause) -> str:
    rests = clause.has(Effect.STILL) and bool(clause.select(MentionKind.PLACE))
    if clause.join is Join.WHILE or rests and clause.join is not Join.THEN:
        return "together"  # "..., but the hull stays put"
    if clause.join is Join.COMMA and clause.has(Effect.STILL) and get_verb(clause.head).generic:
        return "and"  # "..., the rest stays"
    return "then" if clause.join in (Join.THEN, Join.COMMA, Join.BEFORE, Join.AFTER) else "and"


def _name_motion(mention: Mention | None) -> str:
    """The lexicon's word for what a mention does: its own phrase, or another one of the same meaning."""
    if mention is None:
        return ""
    motion = get_verb(mention)
    table = LEXICON.motions if mention.kind is MentionKind.VERB else LEXICON.causes
    if table.get(mention.phrase) == motion:
        return mention.phrase
    return next((phrase for phrase, value in table.items() if value == motion), mention.phrase)


def _name_strength(mention: Mention) -> str:
    """A word for strength; what is denied is its opposite."""
    if _STRENGTHS[mention.kind].get(mention.phrase) == mention.value:
        return mention.words if mention.words.lower() == mention.phrase else mention.phrase
    return f"not {mention.phrase}"


def _list_ways(clause: Clause) -> tuple[intent.Way, ...]:
    greets = clause.verb is not None and clause.has(Effect.SWAY)  # "wave to us"
    found = [m for m in clause.select(*_RELATIONS) if not (greets and m.phrase in LEXICON.addressees)]
    ways = [intent.Way(relation=_RELATIONS[m.kind], word=_name_way(m), text=_cut(m.words)) for m in found]
    out = [m for m in clause.select(MentionKind.ANCHOR) if m.phrase.startswith("out of")]
    if out and not ways:  # "pull it out of the pot"
        ways = [intent.Way(word="up", text=out[0].words)]
    return tuple(ways)


def _name_way(mention: Mention) -> str:
    """The lexicon's word for a way."""
    if mention.kind is MentionKind.REVERSAL:
        return str(mention.value)
    if mention.kind is MentionKind.SIDES or mention.phrase == "back":
        return mention.phrase
    if _WAYS.get(mention.kind, LEXICON.directions).get(mention.phrase) == mention.value:
        return mention.phrase
    return " ".join(mention.value) if isinstance(mention.value, tuple) else mention.phrase


def _list_parts(clause: Clause) -> tuple[intent.Part, ...]:
    return tuple(
        intent.Part(word=_name_part(m), excluded=m.kind is MentionKind.EXCLUDED, text=_cut(m.words))
        for m in clause.select(MentionKind.PLACE, MentionKind.EXCLUDED)
        if not _is_landed_on(m, clause)
    )


def _is_landed_on(mention: Mention, clause: Clause) -> bool:
    """Return whether it falls on that part: "lands on its feet", but not "its feet fall"."""
    falls = clause.verb is not None and clause.has(Effect.FALL) and mention.first > clause.verb.first
    return falls and isinstance(mention.value, Place) and mention.value.names == ("down",)


def _name_part(mention: Mention) -> str:
    """The lexicon's words for a part: its own phrase, or a side with a noun for where it begins."""
    place = mention.value
    assert isinstance(place, Place)
    if place == NAMED or LEXICON.parts.get(mention.phrase) == place:
        return mention.phrase
    side, own = " ".join(place.names), mention.phrase.split()[-1]
    nouns = [noun for noun, start in LEXICON.part_nouns.items() if start == place.start and noun != "third"]
    return f"{side} {own if own in nouns else nouns[0]}" if nouns else side


def _list_quantities(clause: Clause) -> tuple[intent.Quantity, ...]:
    told = [
        (m.value, m.words)
        for m in clause.select(MentionKind.QUANTITY)
        if isinstance(m.value, intent.Quantity)
    ]
    for mention in clause.select(MentionKind.COMPARATIVE):
        if mention.phrase == "as strong" and isinstance(mention.value, float):
            told.append(
                (intent.Quantity(value=mention.value, unit="share", dimension="strength"), mention.words)
            )
    return tuple(quantity.model_copy(update={"text": _cut(words)}) for quantity, words in told)


def _find_timing(clause: Clause) -> intent.Timing:
    """The sum of all phrases of time."""
    timing = intent.Timing()
    for mention in clause.select(MentionKind.TIME):
        told = mention.value
        assert isinstance(told, intent.Timing)
        text = {"text": _cut(mention.words)}
        if told.starts is not None:
            timing = timing.model_copy(update={"starts": told.starts.model_copy(update=text)})
        if told.lasts is not None:
            lasts = told.lasts.model_copy(update=text)
            timing = timing.model_copy(update=dict(lasts=lasts, within=told.within, overall=told.overall))
    return timing


def _list_repetitions(clause: Clause) -> tuple[intent.Repetition, ...]:
    mentions = clause.select(MentionKind.REPEAT)
    return tuple(
        intent.Repetition.model_validate(
            dict(
                times=None if told.count is None else min(told.count, _MOST_TIMES),
                often=told.vague,
                alternating=told.alternate,
                in_turn=told.in_turn,
                first=told.names[0] if told.names else None,
                text=_cut(" ".join(mention.words for mention in mentions if mention.value is told)),
            )
        )
        for told in find_repeats(clause)
    )


def _make_solid(mention: Mention) -> intent.Solid:
    assert isinstance(mention.value, intent.Solid)
    return mention.value.model_copy(update={"text": _cut(mention.words)})


def _list_doubts(clause: Clause) -> list[str]:
    """Doubts about what a clause says twice."""
    times = [(m, m.value) for m in clause.select(MentionKind.TIME) if isinstance(m.value, intent.Timing)]
    starts = [m.words for m, told in times if told.starts or m.words.lower().startswith("at the ")]
    lengths = [m.words for m, told in times if told.lasts]
    return [
        f"Which of several times ({', '.join(several)}) is meant is not understood."
        for several in (starts, lengths)
        if len(several) > 1 and not clause.negated
    ] + [
        f"How much '{mention.words}' each time is, is not understood."
        for mention in clause.select(MentionKind.COMPARATIVE)
        if not clause.inherited and any((count.count or 0) > 1 for count in find_repeats(clause))
    ]


def _list_choices(mentions: list[Mention]) -> list[str]:
    """Doubts about two motions or two ways of which one is meant: "push it left or lift it"."""
    doubts = []
    told = [m for m in mentions if m.kind is not MentionKind.FUNCTION or m.phrase == "or"]
    for before, choice, after in zip(told, told[1:], told[2:]):
        if choice.phrase == "or" and after.kind in _CHOSEN and before.kind in _CHOSEN:
            doubts.append(f"Which of '{before.words}' and '{after.words}' is meant is not understood.")
    return doubts


def _find_held(clauses: list[Clause]) -> intent.Held | None:
    mention = next((each for clause in clauses for each in clause.select(MentionKind.ANCHOR)), None)
    if mention is None:
        return None
    return intent.Held.model_validate(dict(end=mention.value, described=True, text=_cut(mention.words)))


def _describe_surroundings(clauses: list[Clause], mentions: list[Mention]) -> intent.Surroundings:
    """Gravity ("no gravity" is a NOT before the mention), ground, and solids of clauses without a motion."""
    gravity, ground = None, None
    for before, mention in zip([None, *mentions], mentions):
        negated = before is not None and before.kind is MentionKind.NOT
        if mention.kind is MentionKind.GRAVITY:
            said = OPPOSITE_GRAVITY[str(mention.value)] if negated else str(mention.value)
            gravity = said if gravity in (None, "down") else gravity
        elif negated and mention.phrase in LEXICON.ground:
            ground = False
    solids = [m for clause in clauses if clause.head is None for m in clause.select(MentionKind.SOLID)]
    words = [m.words for m in mentions if m.kind is MentionKind.GRAVITY]
    return intent.Surroundings.model_validate(
        dict(
            gravity=gravity,
            ground=ground,
            solids=tuple(map(_make_solid, solids)),
            text=_cut(", ".join(words)),
        )
    )


def _is_holding_an_end(clause: Clause, clauses: list[Clause]) -> bool:
    """Return whether a clause says of an end that it does not move while the rest does."""
    places = [m for m in clause.select(MentionKind.PLACE) if isinstance(m.value, Place)]
    if not places or clause.head is None or clause is not clauses[0] and clause.join is Join.THEN:
        return False
    # "Its base does not tilt" is said of a part that moves, "don't hit its head" of one that is acted on.
    moves = get_verb(clause.head).generic or places[0].first < clause.head.first
    still = clause.has(Effect.STILL) or clause.negated and moves
    names = places[0].value.names if isinstance(places[0].value, Place) else ()
    return still and ("up" in names or "down" in names)
