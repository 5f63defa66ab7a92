"""Questions and speeches that ask for no motion: "who pushed it?", "did it fall?", "I don't know where to push it"."""

from __future__ import annotations

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.neighbours import get_phrase, has_motion

_ASKING = frozenset({"who", "whom", "when", "where", "why", "which"})
_MEASURING = frozenset("far hard often fast long high many much strongly quickly".split())
_FACTS = frozenset({"did", "has", "have", "had"})
_SUPPOSING = frozenset({"if", "when", "not", "don't", "once", "as"})
_KNOWING = frozenset({"know", "care", "remember", "understand", "see"})


def find_questions(mentions: list[Mention], prompt: str) -> list[str]:
    """Plain sentences about what is asked of a motion that is not asked for."""
    words = [m.form for m in mentions]
    first, second = [*words, "", ""][:2]
    supposes = bool(_SUPPOSING & set(words[1:])) or any(m.kind is MentionKind.NOT for m in mentions)
    asks = first in _ASKING | _FACTS or first == "how" and second in _MEASURING
    asks = asks or first == "what" and second in ("made", "makes")
    doubts = []
    if prompt.rstrip().endswith("?") and asks and not supposes and has_motion(mentions):
        doubts.append(f"Whether what '{first}' asks for is a motion is not understood.")
    for index, mention in enumerate(mentions):
        unsure = mention.kind is MentionKind.NOT and (mentions[index + 1].form if index + 1 < len(mentions) else "")
        if unsure in _KNOWING and get_phrase(mentions, index + 2) in ("which", "where", "how", "whether", "if"):
            doubts.append(f"What is not said by '{mention.words} {unsure}' is not understood.")
    return doubts
