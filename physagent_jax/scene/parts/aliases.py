"""Parts under the names that a sentence gives them: "wheel" for what the file calls blades, "the tallest leaf" for one.

A part keeps its own name beside: the part that is added says which one it stands for. The file's own names go first,
then names of the same thing, then what a person may call so (`synonyms.yaml`). Where two parts of different names are
as likely, none is taken. An adjective that compares chooses one of several parts of a kind (`choices.yaml`).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any, get_args

import numpy as np
import yaml

from physagent_jax.forces.part import MOST_LETTERS, SIDES, Part, PartRole, get_singular, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.priors import PRIORS

_WORD = re.compile(r"[^\W\d_]+")
_BETWEEN = 2  # words between an adjective that chooses and its noun, at most
_CLEAR = (
    1.15  # times as much of what is compared the plain adjective's part must have: "the big wheel" of two
)
_LIMB = 0.35  # share of the object, above which what sticks out is no leaf
_HIGH = 0.5  # cosine to the vertical, from which on a part is above or below the middle
_BEHIND = 0.5  # cosine to the line of sight, above which of two limbs none is on the viewer's left
_FRONTS = frozenset(("head", "nose", "bow"))
_PLAIN = frozenset("long short stubby big large thick fat tiny small thin".split())


@functools.cache
def _read(name: str) -> dict[str, Any]:
    return yaml.safe_load((resources.files("physagent_jax.scene.parts") / f"{name}.yaml").read_text("utf-8"))


@functools.cache
def read_groups(kind: str) -> dict[str, frozenset[str]]:
    """The words of files that stand with each word of sentences in a group of a kind, "same" or "near"."""
    found: dict[str, set[str]] = {}
    for group in _read("synonyms")[kind]:
        for word in group.split():
            if not word.startswith("("):
                found.setdefault(word, set()).update(each.strip("()") for each in group.split())
    return {word: frozenset(others - {word}) for word, others in found.items()}


@functools.cache
def _read_comparisons() -> dict[str, str]:
    return {word: key for key, words in _read("choices")["by"].items() for word in words.split(", ")}


@functools.cache
def _read_limbs() -> dict[str, tuple[str, ...]]:
    rows = _read("choices")["limbs"].items()
    return {word: tuple(roles.split()) for words, roles in rows for word in words.split()}


def list_wholes(name: str, kind: str) -> set[str]:
    """Words for parts of other things that are all of an object of a name or a kind: a taxi is a cab."""
    own = {
        kind,
        *(set(split_name(name)) - PRIORS.keys()),
    }  # a kind is not told by the name where one is given
    return {word for word, owners in _read("choices")["wholes"].items() if own & {*owners.split()}}


def find_aliases(
    points: np.ndarray, parts: Sequence[Part], sentence: str, name: str, toward: np.ndarray
) -> tuple[Part, ...]:
    """The parts that a sentence calls by other names than the file does, or chooses among several, so named.

    Args:
        points: Particles at rest [m], shape (n, 3).
        parts: Parts that file, person and shape show.
        sentence: The sentence.
        name: What the object is called; its words are no part's.
        toward: Unit vector to the viewer, shape (3,).
    """
    words = [word.lower() for word in _WORD.findall(sentence)]
    own = {get_singular(word) for word in split_name(name)}
    told = [pair for at in range(len(words)) for pair in _find_at(points, parts, words, at, own, toward)]
    return tuple(_rename(parts, index, phrase) for phrase, index in dict.fromkeys(told))


def _find_at(
    points: np.ndarray,
    parts: Sequence[Part],
    words: Sequence[str],
    at: int,
    own: set[str],
    toward: np.ndarray,
) -> list[tuple[str, int]]:
    """The phrases that end with a word, each with the place of the part that it means."""
    said, noun, start = words[at], get_singular(words[at]), _find_adjective(words, at)
    if noun in own and start is None or at + 1 < len(words) and _is_compound(words, at + 1, own):
        return []
    sided = _find_sided(parts, words, at)
    if noun == "half":  # "the top half" of what has two cases, and no "half its height"
        return sided if len(_list_candidates(parts, noun)) > 1 else []
    if sided and said != noun:  # "the big rear wheels" are the rear ones, however large
        return sided
    candidates = [] if start is None else _list_candidates(parts, noun, limbs=True)
    both = start is not None and words[start] in _PLAIN and said != noun and len(candidates) == 2
    if start is not None and not both:  # "the big ears" are all there are
        chosen = _choose(points, parts, candidates, words[start], toward)
        if chosen is not None:
            return [(" ".join(words[start : at + 1]), chosen)]
    pair = " ".join(words[max(at - 1, 0) : at + 1])
    if sided:
        return sided
    if noun in own:
        return []
    if (limb := _find_own_side(parts, words, at, toward)) is not None:
        return [(pair, limb)]
    if (single := _find_single(points, parts, words, at)) is not None:
        return [(said, single)]
    if any(_drop_number(part)[-1:] in ([said], [said.removesuffix("s")]) for part in parts):
        return []
    first = words[at - 1] if _is_compound(words, at, own) else ""
    found = []
    others = [part if _get_noun(part) not in own else part.model_copy(update=dict(name="")) for part in parts]
    on_top = list(words[at + 1 : at + 3]) == ["on", "top"]
    for index in _list_candidates(others, noun):  # the stand of "wind turbine 1" is no rotor
        if on_top and parts[index].side[2] < _HIGH:
            continue  # "the rotor on top" is not that of the tail
        before, after = _find_rest(parts[index])
        found.append((" ".join(each for each in (*before, first, said, *after) if each), index))
    named = [
        (k, {get_singular(word) for word in _drop_number(part)}) for k, part in enumerate(parts) if part.name
    ]
    bodies = [k for k, words in named if words <= own]
    if not found and noun in _read("choices")["bodies"].split() and len(bodies) == 1 < len(named):
        return [(said, bodies[0])]
    return found


def _get_noun(part: Part) -> str:
    """The last word of a part's name that is no number, in the singular; empty for a thing of another name."""
    words = _drop_number(part)
    apart = any(part.name.endswith(each) for each in _read("synonyms")["apart"].split(", "))
    return "" if apart or not words else get_singular(words[-1])


def _drop_number(part: Part) -> list[str]:
    return [word for word in split_name(part.name) if not word.isdigit()]


def _find_rest(part: Part) -> tuple[list[str], list[str]]:
    """The sides of a part's name, and its number."""
    words = split_name(part.name)
    return [w for w in words if w in SIDES], [w for w in words[-1:] if w.isdigit()]


def _is_known(word: str) -> bool:
    return word in read_groups("same") or word in read_groups("near")


def _is_compound(words: Sequence[str], at: int, own: set[str]) -> bool:
    """Return whether a word and the one before it are one name: "tail vane"."""
    pair = [get_singular(word) for word in words[max(at - 1, 0) : at + 1]]
    known = len(pair) == 2 and own.isdisjoint(pair) and SIDES.isdisjoint(pair) and all(map(_is_known, pair))
    return known and pair[0] == words[at - 1]


def _find_adjective(words: Sequence[str], at: int) -> int | None:
    """The place of an adjective that compares, before a noun and its other adjectives."""
    places = range(at - 1, max(at - 2 - _BETWEEN, -1), -1)
    if f"middle{get_singular(words[at])}" in get_args(PartRole):  # "the middle finger" is one by its name
        return None
    found = next((k for k in places if words[k] in _read_comparisons()), None)
    midst = found is not None and _read_comparisons()[words[found]].endswith("middle")
    return None if midst and "of" in words[found:at] else found  # "in the middle of the wheels"


def _find_sided(parts: Sequence[Part], words: Sequence[str], at: int) -> list[tuple[str, int]]:
    """The parts of a kind on the sides that stand before its noun, under that phrase: "the rear wheels" of four."""
    rows = [row.split() for row in _read("choices")["sides"]]
    start = at
    while start and any(words[start - 1] in row for row in rows):
        start -= 1
    like = [next({*row} for row in rows if word in row) for word in words[start:at]]
    phrase = " ".join(words[start : at + 1])
    named = [k for k in _list_candidates(parts, get_singular(words[at])) if parts[k].name]
    there = [k for k in named if like and all(side & {*split_name(parts[k].name)} for side in like)]
    if like and len(named) == 1 and not _find_rest(parts[named[0]])[0]:
        up = parts[named[0]].side[2]  # "the bottom rim" is not the one on top
        there = not any(
            ("lower" in side and up > _HIGH) or ("upper" in side and up < -_HIGH) for side in like
        )
        return [(phrase, named[0])] if there else []  # "the front fork" of one
    return [(phrase, k) for k in there] if any(parts[k].name != phrase for k in there) else []


def _find_own_side(parts: Sequence[Part], words: Sequence[str], at: int, toward: np.ndarray) -> int | None:
    """The left or the right one of two limbs that lie before each other, as what has a front has them; else None."""
    roles = _read_limbs().get(get_singular(words[at]), ())
    limbs = [[k for k, p in enumerate(parts) if p.roles[:1] == (role,) and not p.name] for role in roles]
    pair = next(filter(None, limbs), [])
    fronts = [np.asarray(each.side) for each in parts if not _FRONTS.isdisjoint(each.roles[:1])]
    if at == 0 or words[at - 1] not in ("left", "right") or len(pair) != 2 or len(fronts) != 1:
        return None
    left = np.cross((0.0, 0.0, 1.0), fronts[0])
    apart = np.subtract(parts[pair[0]].side, parts[pair[1]].side)
    if abs(apart @ toward) < _BEHIND * np.linalg.norm(apart):
        return None
    return pair[int((apart @ left > 0) != (words[at - 1] == "left"))]


def _find_single(points: np.ndarray, parts: Sequence[Part], words: Sequence[str], at: int) -> int | None:
    """The longest limb that may be "a leaf", "one of the branches" or the like; None if that is not said."""
    noun, before = get_singular(words[at]), words[max(at - 3, 0) : at]
    single = before[-1:] and before[-1] in ("a", "one", "single") or list(before[:2]) == ["one", "of"]
    if not single or noun not in next(iter(_read("choices")["limbs"])).split():
        return None
    return _choose(points, parts, _list_candidates(parts, noun, limbs=True), "longest", np.zeros(3))


def _list_candidates(parts: Sequence[Part], noun: str, *, limbs: bool = False) -> list[int]:
    """Places of the parts that a noun may mean: those called so, then those of like names, then limbs if asked for."""
    named = [(index, _get_noun(part)) for index, part in enumerate(parts) if part.name]
    same, near = (read_groups(kind).get(noun, frozenset()) for kind in ("same", "near"))
    own_roles = _read_limbs().get(noun, ())[:2]
    pairs = (
        [k for k, each in enumerate(parts) if not each.name and each.roles[:1] == (r,)] for r in own_roles
    )
    if any(len(pair) == 2 for pair in pairs):
        near = frozenset()  # the two limbs of an airplane are its wings, whatever its rotor is called
    for wanted in ({noun}, same, near):
        found = [(index, own) for index, own in named if own in wanted]
        if found:
            alike = len({own for _, own in found}) == 1
            return [index for index, _ in found] if alike or limbs else []
    alone = _read("choices")["alone"].get(noun)
    found = [k for k, each in enumerate(parts) if not each.name and each.roles[:1] == (alone,)]
    if len(found) == 1:
        return found
    shown = {role for each in parts for role in each.roles[:1]}
    for role, beside in _read("choices")["beside"].get(noun, {}).items():
        found = [k for k, each in enumerate(parts) if not each.name and each.roles[:1] == (role,)]
        if len(found) == 2 and beside in shown and noun not in shown:
            return found
    roles = _read_limbs().get(noun, ()) if limbs else ()
    found = [k for k, each in enumerate(parts) if not each.name and {*roles} & {*each.roles[:1]}]
    return [k for k in found if parts[k].share < _LIMB]


def _choose(
    points: np.ndarray, parts: Sequence[Part], candidates: Sequence[int], adjective: str, toward: np.ndarray
) -> int | None:
    """The one of several parts that an adjective tells; None if there is none, or it tells none apart."""
    key = _read_comparisons()[adjective]
    own = [points[~make_region_mask(parts[k].rest, points)] for k in candidates]
    if key.endswith("middle"):
        if len(own) < 3 or any("middle" in split_name(parts[k].name) for k in candidates):
            return None  # of two, none is
        middle = np.mean([each.mean(0) for each in own], axis=0)
        sizes = [-float(np.linalg.norm(each.mean(0) - middle)) for each in own]
    else:
        sizes = [_MEASURES[key.removeprefix("-")](each, toward) for each in own]
    least = key.startswith("-")
    ranked = sorted(zip(sizes, candidates), key=lambda each: each[0] if least else -each[0])
    if not ranked or adjective in _PLAIN and not _differ(*(size for size, _ in ranked[:2])):
        return None
    return ranked[0][1]


def _differ(one: float, other: float | None = None) -> bool:
    return other is not None and max(one, other) > _CLEAR * min(one, other)


_MEASURES: dict[str, Callable[[np.ndarray, np.ndarray], float]] = {
    "height": lambda own, _: float(own[:, 2].max()),
    "length": lambda own, _: float(np.linalg.norm(np.ptp(own, axis=0))),
    "size": lambda own, _: float(len(own)),
    "nearness": lambda own, toward: float((own @ toward).mean()),
}
"""Measures that are compared, of a part's particles and the way to the viewer."""


def _rename(parts: Sequence[Part], index: int, name: str) -> Part:
    part = parts[index]
    told = part.name or f"{part.roles[0]} (part {index + 1})"
    return part.model_copy(update=dict(name=name[:MOST_LETTERS], stands_for=told))
