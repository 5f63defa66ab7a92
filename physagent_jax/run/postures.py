"""Words for parts that tell how all of the object comes to lie or goes: "nose first", "ends up on its wheels".

Nothing is done to such a part: it is neither looked for nor asked for.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_PART = (
    r"(?:(?:front|rear|hind|back|left|right|lower|two|four)\s+)*(?P<part>wheels?|tyres?|tires?|feet|foot|legs?|paws?|"
    r"hooves|toes?|tiptoes?|knees?|hands?|heads?|nose|snout|beak|face|chin|back|backside|bottom|belly|stomach|tummy|chest|rump|"
    r"shoulders?|side|sides|tail|tip|top|roof|hood|bonnet|bow|stern|keel|base|handle|rim|tracks|skids|leaves|crown)\b"
)
_GOES = (
    "land fall stand end wind finish come lie lay roll balance rest topple flip tumble drop plunge plummet crash sit"
    " stay turn tip settle spin dive collapse hop walk drive run glide slide slip remain keep rear rise get teeter rock"
).split()
_IRREGULAR = (
    "fell fallen stood came lay lain sat kept ran driven drove slid slipped rose risen got lying sitting running"
    " putting dropped dropping flipped flipping tipped tipping spun spinning dove hopping hopped"
).split()
_ON = re.compile(
    rf"\b(?:{'|'.join([*_GOES, *_IRREGULAR])})(?:s|es|ed|d|ing)?\b(?:\s+(?!an?\s|on\b|onto\b)\w+){{0,4}}?"
    rf"\s+(?:on|onto|upon|over|to)\s+(?:its|his|her|their|the|all|both|one)\s+{_PART}"
)
_FIRST = re.compile(rf"{_PART}[\s-]+(?:first|foremost|over\s+(?:heels|tail|head))\b(?:heels|tail)?")
_TURNED = re.compile(
    rf"(?<!\w)(?<!the )(?<!its )(?<!his )(?<!her )(?<!their )(?<!s ){_PART}[\s-]+(?:down|up)\b"
)
_POSTURES = (_ON, _FIRST, _TURNED)


def strip_postures(sentence: str) -> str:
    """The sentence without the words for parts that tell a posture alone."""
    text = sentence.lower()
    for pattern in _POSTURES:
        for match in pattern.finditer(text):
            start, end = match.span("part")
            sentence = sentence[:start] + " " * (end - start) + sentence[end:]
    return sentence


def list_acted(words: Iterable[str], sentence: str) -> tuple[str, ...]:
    """Those of some words for parts that stand in a sentence for more than a posture."""
    left = strip_postures(sentence).lower()
    return tuple(word for word in words if re.search(rf"\b{re.escape(word.lower())}\b", left))
