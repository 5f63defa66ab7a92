"""Questions and speeches that ask for no motion: "who pushed it?", "did it fall?", "I don't know where to push it"."""

from __future__ import annotations

import re

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import has_motion

_ASKING = frozenset({"who", "whom", "when", "where", "why", "which"})
_MEASURING = frozenset("far hard often fast long high many much strongly quickly".split())
_STATES = frozenset({"is", "was", "will", "does"})
_BETWEEN = (MentionKind.FUNCTION, MentionKind.INTENSITY, MentionKind.DEGREE, MentionKind.TIME)
_FACTS = frozenset({"did", "has", "have", "had"})
_SUPPOSING = frozenset({"if", "when", "not", "don't", "once", "as"})
_IGNORANCE = re.compile(
    r"\b(don't|do not|doesn't|does not) (know|care|remember|mind) (which|where|how|whether|if|what)\b"
)


def find_questions(mentions: list[Mention], prompt: str, names: frozenset[str]) -> list[str]:
    """Plain sentences about what is asked of a motion that is not asked for; ``names`` are words for the object."""
    words = [m.form for m in mentions]
    first, second = [*words, "", ""][:2]
    supposes = bool(_SUPPOSING & set(words[1:])) or any(m.kind is MentionKind.NOT for m in mentions)
    asks = first in _ASKING | _FACTS or first == "how" and second in _MEASURING
    asks = asks or first == "what" and second in ("made", "makes")
    doubts = []
    asks = asks or first in _STATES and _is_about_object(mentions, names)
    if prompt.rstrip().endswith("?") and asks and not supposes and has_motion(mentions):
        doubts.append(f"Whether what '{first}' asks for is a motion is not understood.")
    unsaid = _IGNORANCE.search(prompt.lower().replace("\u2019", "'"))
    if unsaid is not None:
        doubts.append(f"What is not said by '{unsaid.group(0)}' is not understood.")
    return doubts


def _is_about_object(mentions: list[Mention], names: frozenset[str]) -> bool:
    """Return whether the object itself does what is asked: "is it leaning left?", "will the robot fall?"."""
    at = 2 if len(mentions) > 1 and mentions[1].phrase in DETERMINERS else 1
    subject = mentions[at].phrase if at < len(mentions) else ""
    at += 1
    while (
        at < len(mentions) and mentions[at].kind in _BETWEEN and mentions[at].form not in ("to", "be", "able")
    ):
        at += 1
    verb = mentions[at] if at < len(mentions) else None
    asked = verb is not None and (verb.kind is MentionKind.VERB or verb.form == "going")
    return asked and subject in names | {"it", "he", "she", "this", "that"}
