"""The object's parts for people and for words: what each is called, and which of them a phrase names."""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import ORIGINS, SIDES, Part, split_name
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.motion.limbs import PLACES, take_middle_off
from physagent_jax.motion.schema import DirectionTable, SceneBrief
from physagent_jax.motion.vectors import cosine

_SIDE = 0.5  # cosine to one of the viewer's directions from which a part lies there
_SIDES = dict(left="left", right="right", toward="front", away="back", up="upper", down="lower")
_PLAIN = {place: f"part at the {place}" for place in PLACES} | {
    "grip": "end of the handle",
    "forefinger": "index finger",
    "middlefinger": "middle finger",
    "ringfinger": "ring finger",
    "littlefinger": "little finger",
}
_INNER = 0.8  # share of a part's places that lie in another one
_SINGLE = ("head", "tail", "lid", "knob", "spout", "back")  # roles that an object has but one part of
_MOST_SEEDS = 256  # of a region
_RANK = {"option": 0, "file": 1, "shape": 2, "place": 3}


def label_parts(parts: Sequence[Part], table: DirectionTable) -> tuple[Part, ...]:
    """The parts with labels for people: their names, else their roles, with a side where several are alike.

    Args:
        parts: The object's parts.
        table: The viewer's directions.
    """
    plain = [part.name or _PLAIN.get(part.roles[0], part.roles[0]) for part in parts]
    labels = []
    for part, name in zip(parts, plain):
        alike = [each.side for each, other in zip(parts, plain) if other == name]
        sided = f"{_find_sides(take_middle_off(part.side, alike), table)} {name}".strip()
        labels.append(name if part.name or len(alike) == 1 else sided)
    found = []
    for index, (part, label) in enumerate(zip(parts, labels)):
        doubt = f", unsure: {part.confidence:.0%}" if part.unsure else ""
        source = f"taken to be '{part.stands_for}'" if part.stands_for else ORIGINS[part.origin]
        told = f"{label} (part {index + 1}, {source}{doubt})"
        moved = part.moved.model_copy(update=dict(label=told))
        found.append(part.model_copy(update=dict(label=label, moved=moved)))
    return tuple(found)


def _find_sides(way: Vector, table: DirectionTable) -> str:
    """The words for a direction: "front left"; by as many of them as tell it."""
    shares = {word: cosine(way, getattr(table, name)) for name, word in _SIDES.items()}
    level = [word for word in ("front", "back", "left", "right") if shares[word] > _SIDE]
    return " ".join(level or [max(shares, key=lambda word: shares[word])])


def find_named(parts: Sequence[Part], phrase: str, *, plural: bool = False) -> tuple[int, ...]:
    """Places of the parts that a phrase names; none if no part is called so.

    A part's whole name counts first, then its last word: "lid" is the "pot lid". What a person has named goes before
    what the file names.

    Args:
        parts: The object's parts.
        phrase: The words of a sentence, without articles.
        plural: Whether several may be meant; else several that are called alike are none.
    """
    said = split_name(phrase)
    if not said:
        return ()
    ends = {said[-1], *((said[-1].removesuffix("s"), said[-1].removesuffix("es")) if plural else ())}
    phrases = {(*said[:-1], end) for end in ends}
    for match in (lambda name: name in phrases, lambda name: _drop_number(name)[-1:] in phrases):
        for rank in sorted(_RANK.values()):
            found = [
                index
                for index, part in enumerate(parts)
                if part.name and _RANK[part.origin] == rank and match(split_name(part.name))
            ]
            found = [k for k in found if not _is_jumble(parts[k], parts)]
            found = [k for k in found if not any(_is_within(parts[k], parts[j]) for j in found if j != k)]
            if len(found) == 1 or found and plural:
                return tuple(found)
    return ()


def _is_jumble(part: Part, parts: Sequence[Part]) -> bool:
    """Return whether it has another one's name with a number, and holds parts of other names: no second wheel."""
    name = split_name(part.stands_for or part.name)
    plain = _drop_number(name)
    others = [each for each in parts if not each.stands_for and split_name(each.name) != name]
    copies = name != plain and any(split_name(each.name) == plain for each in others)
    return copies and any(split_name(each.name) != plain and _is_within(each, part) for each in others)


def _is_within(inner: Part, outer: Part) -> bool:
    """Return whether a part is a smaller piece of another one, which takes it along: the arm without what it holds."""
    own = inner.moved.inside
    held = sum(not _is_in_rest(seed, outer) for seed in own)
    return inner.share < outer.share and held > _INNER * len(own)


def explain_missing(text: str, parts: Sequence[Part]) -> str:
    """The doubt about a part that the object does not show and nobody has named, or about which of several is meant."""
    known = ", ".join(dict.fromkeys(p.label or p.name or p.roles[0] for p in parts if not p.stands_for))
    told = f"the parts that are known are {known}" if known else "no part of the object is known"
    return f"Where '{text}' is, is not known: {told}; `--part` names others (`physagent inspect` shows them all)."


def explain_guess(
    text: str, parts: Sequence[Part], chosen: Sequence[int], *, plural: bool, roles: Sequence[str] = ()
) -> str | None:
    """The doubt about parts that a word may mean, and nothing tells for certain; None if there is none.

    What a person or the file names is certain. A shape tells a role; not so its place alone, a role of which it says
    that it may as well be another one, one of a pair where all are meant, or one of several where there is but one.
    A place is certain where the word is for what is there ("the dish"), or the part may have the word's role alone or
    as one of a pair, and of leaves where more than two are. What alone sticks out of an object is its handle, if it has
    one.

    Args:
        text: The word in the sentence.
        parts: The object's parts.
        chosen: Places of those that it is taken to mean.
        plural: Whether it means several.
        roles: The roles that the word may mean, likeliest first.
    """
    guessed = [k for k in chosen if not parts[k].name or parts[k].origin == "place" or parts[k].stands_for]
    guessed = [k for k in guessed if not parts[k].stands_for or parts[k].unsure]
    if not guessed:
        return None
    part = parts[guessed[0]]
    rivals = [each for each in parts if each.roles[:1] == part.roles[:1] and not each.name]
    several = bool(set(part.roles[:1]) & set(_SINGLE)) and len(rivals) > 1 and not plural
    faint = any(parts[index].unsure for index in guessed)
    meant = next((role for role in roles if role in part.roles), _get_noun(text))
    lone = "handle" in roles and sum(each.origin == "shape" for each in parts) == 1
    own = lone or meant not in PLACES or [meant] == [*roles[:1]]
    alike = [index for index, each in enumerate(parts) if meant in each.roles]
    said = own and (alike == sorted(guessed) or len(alike) == 2 and {*guessed} <= {*alike})
    clear = (said or set(part.roles[:1]).isdisjoint(PLACES)) and not faint
    many = plural and len(guessed) > 2 and not (faint or roles)  # leaves, which have no shape of their own
    if many or clear and not several and not (plural and len(chosen) == 1 and part.roles):
        return None
    label, number = part.label or part.name or part.roles[0], guessed[0] + 1
    if part.stands_for:
        article = "" if part.stands_for.startswith("a ") else "the "
        return (
            f"Whether '{text}' is {article}{part.stands_for} is not certain: `--part {_get_noun(text)}=N` names "
            "another one (`physagent inspect` shows them all)."
        )
    chance = f" ({part.confidence:.0%})" if faint else ""
    return (
        f"Whether '{text}' is the {label} (part {number}) is not certain{chance}: "
        f"`--part {_get_noun(text)}={number}` says so, or names another one (`physagent inspect` shows them all)."
    )


def _get_noun(text: str) -> str:
    words = split_name(text)
    return words[-1] if words else text


def list_names(brief: SceneBrief) -> frozenset[tuple[str, ...]]:
    """The phrases that name a part of the object: whole names, and their last words, singular and plural.

    A piece that has the object's own name is no part: the name is said of all of it. Pieces that are numbered under
    that name ("grinder 3" of a coffee grinder) have no such word.
    """
    own = split_name(brief.object_name)
    names = [name for part in brief.parts if part.name and (name := split_name(part.name)) != own]
    whole = set(names)
    sided = [(name[0], name[1:]) for name in whole if len(name) > 1 and name[0] in SIDES]
    turned = {(*rest, end) for side, rest in sided for end in (side, side[0])}  # as files have it: "Arm_L"
    whole |= turned | {(side[0], *rest) for side, rest in sided}
    whole |= {(*name[:-1], name[-1] + "s") for name in names if len(name) > 1}  # "one of the ear cups"
    whole |= {tuple(part.name.split()) for part in brief.parts if part.stands_for}  # as the sentence has it
    last = {
        _drop_number(name)[-1] for name in names if not (name[-1].isdigit() and {*own}.issuperset(name[:-1]))
    }
    words = {word for word in last if len(word) > 1}  # "chair A" is a name, and "a" alone an article
    return frozenset(whole | {(form,) for word in words for form in (word, word + "s", word + "es")})


def _drop_number(name: tuple[str, ...]) -> tuple[str, ...]:
    return name[:-1] if len(name) > 1 and name[-1].isdigit() else name


def join_rest(limbs: Sequence[Part]) -> CellsRegion:
    """The particles that belong to none of the limbs."""
    outside = tuple(seed for limb in limbs for seed in limb.rest.outside)
    inside = tuple(
        seed for limb in limbs for seed in limb.rest.inside if all(_is_in_rest(seed, each) for each in limbs)
    )
    rigid = all(limb.rest.rigid for limb in limbs)
    return CellsRegion(inside=_thin(inside or limbs[0].rest.inside), outside=_thin(outside), rigid=rigid)


def _thin(seeds: tuple[Vector, ...]) -> tuple[Vector, ...]:
    """At most as many of the seeds as a region holds, evenly."""
    return seeds[:: -(-len(seeds) // _MOST_SEEDS)]


def _is_in_rest(seed: Vector, limb: Part) -> bool:
    def find_nearest(seeds) -> float:
        return min(math.dist(seed, each) for each in seeds)

    return find_nearest(limb.rest.inside) < find_nearest(limb.rest.outside)
