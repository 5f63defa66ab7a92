"""The blade and the handle of tools, told by the surfaces that they are built of."""

import numpy as np
import pytest

from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.parts import Frame, Shells, guess_parts
from physagent_jax.scene.parts.tools import find_tool

VIEWER = Frame(toward=np.array([0.0, -1.0, 0.0]), right=np.array([1.0, 0.0, 0.0]))
# Size and middle of each surface.
SABRE = [
    ((0.06, 0.06, 0.05), (0, 0, 0.02)),  # the pommel
    ((0.05, 0.05, 0.2), (0, 0, 0.15)),
    ((0.06, 0.26, 0.06), (0, 0, 0.28)),  # the guard
    ((0.02, 0.08, 0.45), (0, 0, 0.52)),
    ((0.02, 0.08, 0.25), (0, 0, 0.87)),
]
HATCHET = [((0.06, 0.06, 0.95), (0, 0, 0.48)), ((0.3, 0.03, 0.25), (0.18, 0, 0.8))]
PIN = [((0.04, 0.04, 0.2), (0, 0, z)) for z in (0.1, 0.9)] + [((0.1, 0.1, 0.6), (0, 0, 0.5))]
VASE = [((0.4, 0.4, 0.3), (0, 0, 0.15)), ((0.4, 0.4, 0.3), (0, 0, 0.45))]


def build(surfaces):
    chance = np.random.default_rng(0)
    points = [chance.uniform(-0.5, 0.5, (600, 3)) * size + middle for size, middle in surfaces]
    return np.concatenate(points), np.repeat(np.arange(len(surfaces)), 600)


def build_cutter():
    """A wheel with a hub in its middle, on a flat handle."""
    points, labels = build([((0.5, 0.08, 0.05), (-0.5, 0, 0)), ((0.02, 0.02, 0.06), (0, 0, 0))])
    chance = np.random.default_rng(1)
    angle, away = chance.uniform(0, 2 * np.pi, 1500), 0.25 * np.sqrt(chance.uniform(0, 1, 1500))
    wheel = np.stack([away * np.cos(angle), away * np.sin(angle), chance.uniform(-0.01, 0.01, 1500)], axis=1)
    return np.concatenate([points, wheel]), np.concatenate([labels, np.full(1500, 2)])


@pytest.mark.parametrize(
    ("made", "blade"),
    [(build(SABRE), {3, 4}), (build(HATCHET), {1}), (build_cutter(), {1, 2})],
    ids=["sabre", "hatchet", "cutter"],
)
def test_a_blade_is_the_thin_end_and_all_else_is_the_handle(made, blade):
    points, labels = made
    found = find_tool(points, labels)
    assert {*labels[found.blade]} == blade and (found.handle == ~found.blade).all()


def test_what_is_no_tool_has_neither():
    assert find_tool(*build(VASE)) is None and find_tool(*build(PIN)) is None
    assert find_tool(build(SABRE)[0], np.zeros(3000, int)) is None


@pytest.mark.parametrize(("word", "inside"), [("blade", [3, 4]), ("hilt", [0, 1, 2])])
def test_the_words_of_a_tool_mean_its_ends(word, inside):
    points, labels = build(SABRE)
    (part,) = guess_parts(points, (), [word], VIEWER, Shells(points, labels), "sabre")
    mine = ~make_region_mask(part.rest, points)
    assert part.name == word and not part.unsure and part.axle is None
    assert (mine == np.isin(labels, inside)).mean() > 0.97


@pytest.mark.parametrize("word", ["blade", "wheel"])
def test_a_blade_that_is_a_disc_turns_about_its_axle(word):
    points, labels = build_cutter()
    (part,) = guess_parts(points, (), [word], VIEWER, Shells(points, labels), "cutter")
    assert abs(part.axle[2]) > 0.95 and part.moved.rigid
