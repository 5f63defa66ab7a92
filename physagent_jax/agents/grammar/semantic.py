"""The offline semantic agent: a grammar of everyday English reads the sentence, the compiler does the rest."""

from __future__ import annotations

import unicodedata
from dataclasses import replace

from physagent_jax.agents.compiler import compile_forces, compile_intent
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.lexicon import Effect, Motion
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.rules.language.clauses import Clause
from physagent_jax.agents.rules.language.explanations import merge_explanations
from physagent_jax.agents.rules.language.grammar import read_clauses
from physagent_jax.agents.rules.language.intent import make_intent
from physagent_jax.agents.rules.language.mentions import MentionKind
from physagent_jax.agents.rules.language.naming import collect_object_words
from physagent_jax.agents.rules.language.reading import find_mentions
from physagent_jax.agents.rules.language.spelling import describe_corrections
from physagent_jax.agents.rules.language.unknowns import is_mostly_unknown, list_unknown
from physagent_jax.agents.schema import SceneBrief, SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.core.errors import UserError

EXAMPLES = (
    '"push the robot to the left", "a gentle wind sways the plant", "drop the guitar", "twist the loaf"'
)
MOST_CHARACTERS = 100_000  # read within seconds


class GrammarSemanticAgent(SemanticAgent):
    """Reads by rules: no model, no network, the same words give the same field."""

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read the sentence and compile what it says; see `protocols.SemanticAgent`."""
        return Reply(compile_intent(read_intent(context.prompt, context.brief), context.brief))


def read_sentence(prompt: str, brief: SceneBrief) -> SemanticReply:
    """Read a sentence into the paper's four skills, all of them body forces.

    Raises:
        UserError: Nothing in it, or too little of it, can be understood.
    """
    return compile_forces(read_intent(prompt, brief), brief)


def read_intent(prompt: str, brief: SceneBrief) -> Intent:
    """The intent of a sentence.

    Raises:
        UserError: Nothing in it, or too little of it, can be understood.
    """
    _check_text(prompt)
    names = collect_object_words(prompt, brief)
    mentions = find_mentions(prompt, names)
    clauses, mentions = merge_explanations(read_clauses(mentions), mentions)
    unknown, notes = list_unknown(mentions, names, brief)
    notes += describe_corrections(prompt, names)
    clauses = _assume_push(clauses, unknown)
    if is_mostly_unknown(mentions, unknown):
        raise _refuse("Most words of the prompt are not understood", prompt, brief)
    intent = make_intent(clauses, mentions, unknown, notes)
    if not (intent.clauses or intent.held or intent.surroundings.gravity):
        raise _refuse("The prompt names no motion that is understood", prompt, brief)
    return intent


def _refuse(what: str, prompt: str, brief: SceneBrief) -> UserError:
    text = " ".join(prompt.split())
    return UserError(
        what,
        got=repr(text if len(text) <= 80 else text[:77] + "..."),
        do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
    )


def _check_text(prompt: str) -> None:
    """Refuse what is no sentence at all, before any of it is read."""
    if not prompt.strip():
        raise UserError("The prompt is empty", do=f"Say what should happen, for example {EXAMPLES}")
    if len(prompt) > MOST_CHARACTERS:
        raise UserError(
            f"The prompt is longer than {MOST_CHARACTERS:,} characters",
            got=f"{len(prompt):,}",
            do=f"Say in a sentence or two what should happen, for example {EXAMPLES}",
        )
    # Line breaks and tabs are spaces to a reader; other control characters and halves of characters are no text.
    strange = next((c for c in prompt if unicodedata.category(c) in ("Cc", "Cs") and not c.isspace()), None)
    if strange is not None:
        raise UserError(
            "The prompt holds a character that is no text",
            got=ascii(strange),
            do=f"Type the sentence anew, for example {EXAMPLES}",
        )


def _assume_push(clauses: list[Clause], unknown: list[str]) -> list[Clause]:
    """A bare "to the left" is a push; among words that are not understood it is nothing."""
    if unknown or any(clause.head for clause in clauses):
        return clauses
    directed = [c for c in clauses if c.select(MentionKind.DIRECTION, MentionKind.FROM)]
    for clause in directed:
        first = clause.select(MentionKind.DIRECTION, MentionKind.FROM)[0]
        clause.verb = replace(first, kind=MentionKind.VERB, value=Motion(Effect.PUSH), phrase="push")
    return clauses
