"""The motion of a clause, and its strength: what stands beside a verb may change both."""

from __future__ import annotations

import re
from dataclasses import replace

from physagent_jax.agents.compiler.events import Event, ValueSource
from physagent_jax.agents.compiler.words import WAYS, Meaning, WayKind
from physagent_jax.agents.lexicon import Effect, Motion, read_lexicon
from physagent_jax.agents.schema import SceneBrief
from physagent_jax.agents.vectors import clamp
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN


def choose_motion(meaning: Meaning, brief: SceneBrief) -> tuple[Motion, str]:
    """The clause's motion as what stands beside it makes it, and the phrase that it then goes by."""
    motion, phrase = _join_cause(meaning)
    motions, effect = read_lexicon().motions, motion.effect
    told, repeats = meaning.pick(*WAYS), meaning.clause.repetitions
    counted = any((each.times or 1) > 1 for each in repeats)
    if effect is Effect.ROLL and (meaning.clause.turning or meaning.clause.seen_from) and not told:
        return replace(motion, effect=Effect.TURN, direction="toward"), phrase  # rolls on the spot
    if meaning.verb is None and motion.wind and not told and _is_swaying_in_wind(brief):
        return replace(motions["sway"], strength=motion.strength), "sway"
    if any(each.alternating for each in repeats) and (effect in (Effect.FALL, Effect.JUMP) or motion.gravity):
        phrase = "sway" if effect is Effect.STRIKE else "bob"  # "is tossed to and fro", "jumps up and down"
    elif motion.bounces and (counted or meaning.is_upwards):
        phrase = "jump"  # "it bounces three times"
    elif motion.coasts and told:
        phrase = "move"  # "it coasts to the left"; else it goes on by itself
    elif effect is Effect.ROLL and has_wheels(brief):
        phrase = "push"  # its wheels turn, and it does not
    elif effect is Effect.SWELL and (told or meaning.pick(WayKind.LINE, WayKind.PLANE)):
        return replace(motion, effect=Effect.SCALE), phrase  # "expands horizontally", "grows upwards"
    else:
        return motion, phrase
    return motions[phrase], phrase


def _join_cause(meaning: Meaning) -> tuple[Motion, str]:
    """The motion; a wind that "hits" pushes, a cause of generic motion ("sends it") gives its own kind."""
    cause, verb = meaning.cause, meaning.verb
    if verb is None:
        assert cause is not None
        return cause, meaning.cause_phrase
    if cause is None:
        return verb, meaning.phrase
    quakes = cause.effect is Effect.SWAY and meaning.phrase in ("hit", "strike")  # "an earthquake hits"
    struck = verb.effect is Effect.STRIKE and (cause.wind or cause.skill is not None)  # "a vortex hits it"
    if (verb.generic and verb.effect is Effect.PUSH) or struck or quakes:
        return cause, meaning.cause_phrase
    skill = cause.skill if verb.effect is cause.effect else verb.skill  # "a vortex spins it"
    return replace(verb, brief=verb.brief or cause.brief, skill=skill), meaning.phrase


def _is_swaying_in_wind(brief: SceneBrief) -> bool:
    """Return whether a bare wind makes it sway: what is held or grows sways, what is free is blown away."""
    return brief.anchored is not None or brief.object_kind == "plant"


def has_wheels(brief: SceneBrief) -> bool:
    """Return whether it rolls on wheels, and so stays upright when it is rolled."""
    return not read_lexicon().wheeled.isdisjoint(re.findall(r"[^\W\d_]+", brief.object_name.lower()))


def resolve_strength(meaning: Meaning, motion: Motion, before: Event | None) -> tuple[float, ValueSource]:
    """Base strength of motion and cause times the intensities; degrees widen the next one's distance from 1."""
    clause, value, degree, absolute = meaning.clause, motion.strength, 1.0, []
    if meaning.cause is not None and meaning.verb is not None and meaning.cause not in (motion, meaning.verb):
        value *= meaning.cause.strength
    shares = [each for each in clause.quantities if each.dimension == "strength"]
    told = [*meaning.strengths, *(("relative", each.value) for each in shares)]
    for kind, factor in told:
        if kind == "degree":
            degree = factor
        elif kind == "absolute":
            value *= 1.0 + (factor - 1.0) * degree
            degree = 1.0
            absolute.append(factor)
        else:
            value = factor * (before.strength if before else value)
    # A word for how strong it is outweighs the motion's own strength.
    if absolute and degree == 1.0 and motion.strength >= 0.8:
        if min(absolute) >= 1.3:
            value = max(value, 1.2)
        elif max(absolute) <= 0.6:
            value = min(value, 0.7)
    value = round(clamp(value, MAGNITUDE_MIN, MAGNITUDE_MAX), 3)
    if told:
        words = ", ".join([*clause.strength, *(each.text for each in shares)])
        return value, ValueSource(words, "intensity words")
    why = "the word's own strength" if value != 1.0 else "no intensity word: plain"
    return value, ValueSource(meaning.words, why)
