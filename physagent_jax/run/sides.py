"""Sides that a sentence tells behind a part, put before it: "the left ear" for "the ear on the left"."""

from __future__ import annotations

import re

from physagent_jax.agents.lexicon import read_lexicon

_FLAT = {"face", "surface", "side", "section", "region", "area", "slab"}  # of which one end is meant
_LIMBS = ("arm", "leg", "ear", "wing", "horn")  # roles of which a file may have its own left and right
_NOUNS = "|".join(sorted(read_lexicon().part_nouns.keys() - _FLAT, key=len, reverse=True))
_JUTTING = re.compile(
    r"\b(?:end|part|bit|piece) (?:that (?:sticks|juts|pokes)|sticking|jutting|poking) out\b", re.IGNORECASE
)
_BESIDE = re.compile(
    rf"\b(?P<article>the|its|his|her|their|one|both) (?P<noun>(?:{_NOUNS})s?) (?:on|at) (?:the|its|his|her) "
    rf"(?P<side>left|right|front|back|rear)\b(?!(?: hand)?(?: side)? of| (?!hand)(?:{_NOUNS}))(?: hand)?(?: side)?",
    re.IGNORECASE,
)


def put_sides_first(sentence: str) -> str:
    """The sentence with sides before their parts, and with protrusions for ends that stick out."""
    return _BESIDE.sub(_lead, _JUTTING.sub("protrusion", sentence))


def _lead(match: re.Match[str]) -> str:
    """The part with its side before it; "the arm on the left" is so in the picture, whatever the file calls it."""
    side, noun = match["side"], match["noun"]
    role = getattr(read_lexicon().parts.get(noun.lower().removesuffix("s")), "role", "")
    most = "most" * (side in ("left", "right") and role.startswith(_LIMBS))
    return f"{match['article']} {side}{most} {noun}"
