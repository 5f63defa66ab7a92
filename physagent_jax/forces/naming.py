"""Names of a force field's entries for people, in place of their places in the JSON."""

from __future__ import annotations

import re
from collections.abc import Mapping

from physagent_jax.forces.schema import ForceField
from physagent_jax.forces.skills import get_skill

_PLACE = re.compile(r"\b(?P<list>actions|constraints)\[(?P<index>\d+)\](?:\.(?P<value>[a-z_]+))?")
_MANY = re.compile(
    r"((?:actions|constraints)\[\d+\](?:\.[a-z_]+)?)((?:, (?:actions|constraints)\[\d+\](?:\.[a-z_]+)?){3,})"
)
_VALUES = {
    "action_type": "kind",
    "constraint_type": "kind",
    "vector": "direction",
    "active_time": "time",
    "held_until": "hold",
}
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth")


def name_places(text: str, field: ForceField | None, words: Mapping[str, str] | None = None) -> str:
    """Text in which every "actions[0].vector" is named by its skill: "the direction of the translation 'push left'".

    Of a list of more than three the first is named, and the others are counted.

    Args:
        text: Text of an agent.
        field: The force field that the places are of; None = it is not known.
        words: Words of the sentence that led to an entry, by its place.
    """
    short = _MANY.sub(lambda found: f"{found[1]} and {found[2].count(', ')} more", text)
    return _PLACE.sub(lambda found: _name(found, field, words or {}), short)


def _name(found: re.Match[str], field: ForceField | None, words: Mapping[str, str]) -> str:
    place = f"{found['list']}[{found['index']}]"
    said = f" \u2018{words[place]}\u2019" if words.get(place) else ""
    entry = _name_entry(found["list"], int(found["index"]), field)
    value = found["value"]
    named = "" if value is None else f"the {_VALUES.get(value, value.replace('_', ' '))} of "
    return f"{named}{entry}{said}"


def _name_entry(kind: str, index: int, field: ForceField | None) -> str:
    """The skill of an entry, with its number where the field has several of them."""
    entries = () if field is None else getattr(field, kind)
    if index >= len(entries):
        return f"the {_count(index)} {'action' if kind == 'actions' else 'constraint'}"
    skills = [get_skill(entry).name for entry in entries]
    number = f"{_count(skills[:index].count(skills[index]))} " if skills.count(skills[index]) > 1 else ""
    return f"the {number}{skills[index].removeprefix('enforce_').replace('_', ' ')}"


def _count(index: int) -> str:
    return _ORDINALS[index] if index < len(_ORDINALS) else f"{index + 1}th"
