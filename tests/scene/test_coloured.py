"""Parts that a sentence tells by their colour alone."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.run.coloured import find_coloured_words
from physagent_jax.scene.parts import find_coloured
from tests.scene.test_part_roles import make

# A grey chassis with a box on one end of it, painted on its outside, darker below.
POINTS = make([((0, 0, 0), (0.5, 0.2, 0.06)), ((0.2, 0, 0.2), (0.25, 0.2, 0.18))], 6000)
BOX = (((POINTS - (0.2, 0, 0.2)) / (0.25, 0.2, 0.18)) ** 2).sum(1)
PAINTS = dict(green=(0.2, 0.8, 0.2), red=(0.9, 0.1, 0.1), yellow=(0.9, 0.8, 0.1), blue=(0.2, 0.3, 0.9))


def paint(colour):
    shade = (0.4 + 0.6 * (POINTS[:, 2] > 0.1))[:, None]
    outside = (BOX <= 1) & (BOX > 0.6) & (POINTS[:, 2] > 0.05)
    return np.where(outside[:, None], np.asarray(PAINTS[colour]), 0.5) * shade


@pytest.mark.parametrize("colour", PAINTS)
def test_the_part_of_a_colour_holds_what_is_inside_it(colour):
    (part,) = find_coloured(POINTS, paint(colour), [(colour, "box")])
    assert part.name == f"{colour} box" and part.seated and part.arm[2] > 0 and not part.unsure
    mask, inside = make_region_mask(part.moved, POINTS), (BOX < 0.5) & (POINTS[:, 2] > 0.08)
    assert mask[inside].mean() > 0.95 and mask[POINTS[:, 0] < -0.2].mean() < 0.02
    other = next(each for each in PAINTS if each != colour)
    assert not find_coloured(POINTS, paint(colour), [(other, "box"), ("purple", "part")])


@pytest.mark.parametrize(
    ("sentence", "found"),
    [
        ("Push the big green box down.", [("green", "box")]),
        ("Its red part is squashed while the blue top stays", [("red", "part"), ("blue", "top")]),
        ("the red truck rolls away", []),
        ("a green box falls on it", []),
        ("it is thrown against the yellow wall", []),
        ("it slides over the green grass under the blue sky", []),
    ],
)
def test_words_for_parts_by_their_colour(sentence, found):
    assert list(find_coloured_words(sentence, {"truck", "wheel"})) == found
