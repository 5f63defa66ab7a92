"""The material of a run that the sentence chooses: "made of jelly", unless the user has chosen one."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_jax.agents.materials import MaterialMention, find_materials, find_meaning
from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import find_nearest
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.run.spec import MaterialChoice
from physagent_jax.scene.materials import LIBRARY, find_material
from physagent_jax.scene.priors import PRIORS


@dataclass(frozen=True)
class SaidMaterial:
    """The outcome of a sentence's material words.

    Attributes:
        preset: Kind or library entry that the sentence chooses; None = it chooses none.
        phrase: The words that choose it.
        notes: What follows from the words, or why nothing does, in plain sentences.
    """

    preset: str | None = None
    phrase: str = ""
    notes: tuple[str, ...] = ()


def choose_said_material(
    prompt: str, brief: SceneBrief, choice: MaterialChoice, words: tuple[str, ...]
) -> SaidMaterial:
    """The material that the sentence chooses.

    The user's own choice goes first. A word of the object's own name chooses only presets that are made for visible
    motion, as those of kinds are: a porcelain doll's sentence need not ask for porcelain.

    Args:
        prompt: The sentence.
        brief: The scene.
        choice: The user's choice.
        words: Material words that the semantic agent found (`SemanticReply.materials`).
    """
    mentions = _locate(prompt, brief, words)
    notes = [_explain_unknown(each) for each in mentions if find_meaning(each.word) is None]
    known = [(each, meaning) for each in mentions if (meaning := find_meaning(each.word)) is not None]
    for mention, meaning in [pair for pair in known if pair[0].named and pair[1].preset not in PRIORS]:
        known.remove((mention, meaning))
        if choice.name is None and choice.physgm is None:
            notes.append(
                f"'{mention.word}' belongs to the object's name, so that its material stays that of its kind: "
                f"--material {meaning.preset} chooses it"
            )
    known = [pair for pair in known if pair[1].becomes] or known
    presets = list(dict.fromkeys(meaning.preset for _, meaning in known))
    if not presets:
        return SaidMaterial(notes=tuple(notes))
    said = " and ".join(f"'{mention.phrase}'" for mention, _ in known)
    if choice.name is not None or choice.physgm is not None:
        mine = choice.name or "PhysGM's prediction"
        if choice.name is None or _find_key(choice.name) not in presets:
            notes.append(f"the sentence says {said}, but {mine} is chosen for the run: that stays")
        return SaidMaterial(notes=tuple(notes))
    if len(presets) > 1:
        notes.append(
            f"the sentence names several materials ({said}) and an object has one: its kind's stays; "
            "--material chooses one"
        )
        return SaidMaterial(notes=tuple(notes))
    mention, meaning = known[0]
    near = f", the nearest to '{mention.word}' that there is" if meaning.near else ""
    start = " from the first frame on" if mention.turns else ""
    why = f"by '{mention.phrase}' in the sentence{start}" if mention.span else "as it is to give way"
    notes.append(f"material: {meaning.preset}{near}, {why}; --material overrides")
    return SaidMaterial(meaning.preset, mention.phrase, tuple(notes))


def tell_material(
    prompt: str, brief: SceneBrief, choice: MaterialChoice, reply: SemanticReply
) -> SemanticReply:
    """The reply with the outcome of its material words among its notes and its evidence.

    Args:
        prompt: The sentence.
        brief: The scene.
        choice: The user's choice.
        reply: The semantic agent's answer.
    """
    said = choose_said_material(prompt, brief, choice, reply.materials)
    if not said.notes:
        return reply
    evidence = reply.evidence
    if said.preset is not None:
        why = "the sentence says what the object is made of, and no material was chosen for the run"
        evidence += (Evidence(words=said.phrase, field="material", value=said.preset, why=why),)
    return reply.model_copy(update=dict(evidence=evidence, notes=(*reply.notes, *said.notes)))


def _locate(prompt: str, brief: SceneBrief, words: tuple[str, ...]) -> list[MaterialMention]:
    """The words as mentions of the sentence; one that is not found there stands for itself."""
    found = {mention.word: mention for mention in find_materials(prompt, brief)}
    keys = [" ".join(word.lower().split()) for word in words]
    return [found.get(key) or MaterialMention(key, key) for key in dict.fromkeys(keys)]


def _explain_unknown(mention: MaterialMention) -> str:
    near = [name for name in LIBRARY if mention.word in name.split("_")] or find_nearest(
        mention.word, LIBRARY, 1
    )
    hint = (
        f"--material {near[0]} is the nearest" if near else "`physagent materials` lists those that there are"
    )
    return f"no material stands for '{mention.word}' in '{mention.phrase}', so that it is not used: {hint}"


def _find_key(name: str) -> str:
    """The name under which the sentence's words know a material; the name itself if the library has none."""
    meaning = find_meaning(name.replace("_", " "))
    if meaning is not None:
        return meaning.preset
    try:
        return find_material(name).name
    except UserError:
        return name
