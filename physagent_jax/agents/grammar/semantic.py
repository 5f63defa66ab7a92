"""The offline semantic agent: a grammar of everyday English reads the sentence, the compiler does the rest."""

from __future__ import annotations

import unicodedata

from physagent_jax.agents import intent as intents
from physagent_jax.agents.compiler import compile_forces, compile_intent
from physagent_jax.agents.compiler.compilation import EXAMPLES
from physagent_jax.agents.compiler.words import suggest_motions
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.grammar.asides import OTHER
from physagent_jax.agents.grammar.clauses import Clause, mark_displacements
from physagent_jax.agents.grammar.coverage import Coverage, ignore_captions, is_mostly_unknown, sort_words
from physagent_jax.agents.grammar.intent import make_intent
from physagent_jax.agents.grammar.mentions import MOTIONS, WAYS, Mention, read_as
from physagent_jax.agents.grammar.nouns import collect_names
from physagent_jax.agents.grammar.patterns import suggest_patterns
from physagent_jax.agents.grammar.reading import read_mentions
from physagent_jax.agents.grammar.relations import read_clauses
from physagent_jax.agents.grammar.tokens import correct_spelling, describe_corrections, tokenise
from physagent_jax.agents.intent import Intent
from physagent_jax.agents.materials import find_materials, mask_materials, shows_by_drop
from physagent_jax.agents.protocols import SemanticAgent
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.core.errors import UserError
from physagent_jax.motion.parts import list_names
from physagent_jax.motion.schema import SceneBrief

MOST_CHARACTERS = 100_000  # read within seconds


class GrammarSemanticAgent(SemanticAgent):
    """Reads by a grammar: no model, no network, the same words give the same field."""

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
        UserError: It is no text, too little of it is understood, or it names no motion of the object.
    """
    _check_text(prompt)
    text = mask_materials(prompt, materials := find_materials(prompt, brief))
    names = collect_names(text, brief)
    mentions = ignore_captions(read_mentions(text, names, list_names(brief)))
    coverage = sort_words(mentions, names, brief)
    if is_mostly_unknown(mentions, coverage):
        raise UserError(
            "Most words of the prompt are not understood",
            got=_quote(prompt),
            do=f"Say in English what should happen to the {brief.object_name}, for example {EXAMPLES}",
        )
    clauses = read_clauses(mentions)
    others = [mention.words for mention in mentions if mention.phrase == OTHER]
    if not coverage.doubtful and not others:
        clauses = _assume_push(clauses)
    taken = f"'{' '.join(coverage.taken)}' is taken to be the object ({brief.object_name})."
    notes = [taken] * bool(coverage.taken)
    notes += [
        f"'{words}' acts on it, but it is not to move: nothing is made of that."
        for words in _list_resisted(clauses, mentions)
    ]
    mark_displacements(clauses, [token.text for token in correct_spelling(tokenise(text), names)])
    intent = make_intent(clauses, mentions, coverage, notes + describe_corrections(text, names))
    if not (intent.clauses or intent.held or intent.surroundings.gravity):
        said = [m for m in materials if not m.named and shows_by_drop(m, prompt)]
        said = [m.phrase for m in said if not others or len(m.phrase.split()) > 2]
        if not said:
            raise _refuse(prompt, brief, coverage, others)
        note = f"'{said[0]}' tells no motion: it is dropped, which shows what it is made of."
        drop = intents.Clause(motion="drop", said=said[0], text=said[0])
        intent = intent.model_copy(update=dict(clauses=(drop,), notes=(*intent.notes, note)))
    return intent.model_copy(update={"materials": tuple(each.word for each in materials)})


def _list_resisted(clauses: list[Clause], mentions: list[Mention]) -> list[str]:
    """The words for what acts on an object that stays still all the same: it is left out (`relations`)."""
    if [clause.verb.phrase for clause in clauses if clause.verb] != ["stay still"]:
        return []
    kept = {mention.first for mention in clauses[0].mentions}
    return [each.words for each in mentions if each.kind in MOTIONS and each.first not in kept]


def _assume_push(clauses: list[Clause]) -> list[Clause]:
    """A bare "to the left" is a push."""
    if any(clause.head for clause in clauses):
        return clauses
    for clause in clauses:
        for way in clause.select(*WAYS)[:1]:
            clause.verb = read_as(way, "push")
    return clauses


def _refuse(prompt: str, brief: SceneBrief, coverage: Coverage, others: list[str]) -> UserError:
    """The error for a sentence without a motion of the object: the word, the nearest known ones, two patterns."""
    patterns = " or ".join(f'"{p.form}" ({p.examples[0]})' for p in suggest_patterns(prompt))
    if others:
        what = f"'{others[0]}' is said of something else than the {brief.object_name}"
        return UserError(
            what, got=_quote(prompt), do=f"Say what the {brief.object_name} does, as in {patterns}"
        )
    word = coverage.doubtful[0] if coverage.doubtful else ""
    what = "The prompt names no motion that is understood"
    what = f"No motion is known in the prompt: '{word}' is not understood" if word else what
    near = suggest_motions(word)
    nearest = f"; the nearest known motions are {', '.join(near)}" if near else ""
    do = f"Say in English what should happen to the {brief.object_name}, as in {patterns}{nearest}"
    return UserError(what, got=_quote(prompt), do=do)


def _quote(prompt: str) -> str:
    text = " ".join(prompt.split())
    return repr(text if len(text) <= 80 else text[:77] + "...")


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
