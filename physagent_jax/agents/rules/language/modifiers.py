"""Everything of the lexicon that is no verb under the names of this folder."""

from __future__ import annotations

from physagent_jax.agents.lexicon import Join, Names, Place, Repeat, read_lexicon

__all__ = ["Join", "Names", "Place", "Repeat"]
_WORDS = read_lexicon()
DIRECTIONS, ENDS, AXES, PLANES = _WORDS.directions, _WORDS.ends, _WORDS.axes, _WORDS.planes
SIDES = {phrase: side == "all" for phrase, side in _WORDS.sides.items()}
SENSES, VIEWS = _WORDS.senses, _WORDS.views
REVERSALS = frozenset(phrase for phrase, value in _WORDS.reversals.items() if value == "other")
SAME_WAYS = frozenset(_WORDS.reversals) - REVERSALS
ADDRESSEES, LOCATIONS = _WORDS.addressees, _WORDS.locations
INTENSITIES, DEGREES, COMPARATIVES = _WORDS.intensities, _WORDS.degrees, _WORDS.comparatives
MANNERS, EVENLY = _WORDS.manners, _WORDS.even
REPEATS, MOMENTS = _WORDS.repeats, _WORDS.moments
NUMBERS, FRACTIONS, UNITS, CLIP_PARTS = _WORDS.numbers, _WORDS.fractions, _WORDS.units, _WORDS.clip_parts
PLACES, PARTS, PART_ADJECTIVES = _WORDS.parts, _WORDS.part_nouns, _WORDS.part_adjectives
FRONTS, ONE_OF_MANY, UNPLACED_PARTS = _WORDS.fronts, _WORDS.one_of_many, _WORDS.unplaced
GRAVITY, ANCHORS, OBSTACLES = _WORDS.gravity, _WORDS.anchors, _WORDS.obstacles
GROUND_WORDS, SCENE_NOUNS = _WORDS.ground, _WORDS.scene_nouns
OPPOSITE_GRAVITY = {"down": "none", "none": "down", "up": "down"}
JOINS, NEGATIONS, EXCEPTIONS, WHOLE_WORDS = _WORDS.joins, _WORDS.negations, _WORDS.exceptions, _WORDS.whole
FUNCTION_WORDS, FUNCTION_PHRASES = _WORDS.words, _WORDS.phrases
MOODS, AGENT_NOUNS = _WORDS.moods, _WORDS.agents
