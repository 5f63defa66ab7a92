"""The lexicon: words as data, with what they mean checked when they are read."""

from importlib import resources

import pytest

from physagent_jax.agents.lexicon import Effect, LexiconError, Motion, Place, make_lexicon, read_lexicon
from physagent_jax.agents.lexicon.reading import FILES
from physagent_jax.forces.calibration import MAGNITUDE_MAX


@pytest.fixture
def texts() -> dict[str, str]:
    folder = resources.files("physagent_jax.agents.lexicon")
    return {name: (folder / f"{name}.yaml").read_text(encoding="utf-8") for name in FILES}


def test_words_of_each_kind_are_read() -> None:
    words = read_lexicon()
    assert words.motions["nudge"] == Motion(Effect.PUSH, strength=0.5, taps=True)
    assert words.motions["smash"].strength == MAGNITUDE_MAX
    assert words.motions["flip"].tumbles and words.motions["flip"].picture
    assert words.causes["gust of wind"].wind
    assert words.directions["away from the lens"] == ("away",)
    assert words.views["when seen from above"] == words.views["viewed from above"] == ("up",)
    assert words.gravity["turn gravity back on"] == words.gravity["switch on the gravity"] == "down"
    assert words.parts["head"] == Place(("up",), 0.72, "head top")
    assert words.fractions["thirds"] == pytest.approx(1 / 3)
    assert words.moments["briefly"].lasts == 0.15


@pytest.mark.parametrize(
    "file, old, new, complaint",
    [
        ("motions", "pulls: true", "pulled: true", "unknown field 'pulled'"),
        ("motions", "effect: sway", "effect: sweep", "'sweep' is not a valid Effect"),
        ("motions", "strength: max", "strength: most", "Invalid literal"),
        ("motions", "direction: up", "direction: over", "no direction: over"),
        ("ways", "  clockwise:", "  leftwise:", "must be one of clockwise"),
        ("ways", "\ndirections:", "\ndirection:", "unknown section 'direction'"),
        ("surroundings", "\nground:", "\nnouns:", "lacks ground"),
    ],
)
def test_a_row_that_means_nothing_is_told(texts, file: str, old: str, new: str, complaint: str) -> None:
    assert old in texts[file]
    texts[file] = texts[file].replace(old, new, 1)
    with pytest.raises(LexiconError, match=complaint):
        make_lexicon(texts)


def test_directions_of_motions_are_bare(texts) -> None:
    texts["motions"] += "- effect: push\n  direction: up left\n  words: arc\n"
    with pytest.raises(LexiconError, match="arc"):
        make_lexicon(texts)


def test_words_of_one_row_mean_the_same() -> None:
    words = read_lexicon()
    assert words.motions["let go"] is words.motions["release"]
    for motion in (*words.motions.values(), *words.causes.values()):
        assert motion.effect is not Effect.HOLD or motion.holds in ("base", "top")
