"""Parts that turn in place, on a stool whose stem is the only slender place."""

import numpy as np
import pytest

from physagent_jax.forces.schema import Bend, CellsRegion
from physagent_jax.forces.twisting import TORN, find_twist

UP, FULL = np.array([0.0, 0.0, 1.0]), 2 * np.pi
STEP = 0.04


def fill(radius, low, high):
    side = np.arange(-radius, radius + 1e-9, STEP)
    grid = np.stack(np.meshgrid(side, side, np.arange(low, high - 1e-9, STEP), indexing="ij"), -1).reshape(
        -1, 3
    )
    return grid[np.hypot(grid[:, 0], grid[:, 1]) <= radius]


def make_stool(stem):
    """A foot, a stem of that radius, and a seat of which a region takes the upper half."""
    x = np.concatenate([fill(0.3, 0, 0.2), fill(stem, 0.2, 0.8), fill(0.5, 0.8, 1.2)])
    low, size = x.min(0), np.ptp(x, axis=0)
    middle = float(-low[0] / size[0])
    cut = (1.0 - low[2]) / size[2]
    region = CellsRegion(inside=((middle, middle, cut - 0.05),), outside=((middle, middle, cut + 0.05),))
    return x, Bend(joint=(middle, middle, cut), rest=region, reach=2.0, depth=0.1)


def test_a_seat_turns_on_its_stem_as_a_piece_of_its_own():
    x, bend = make_stool(0.08)
    twist = find_twist(bend, x, UP, 4 * FULL)
    assert twist is not None and twist.share is None
    turned = np.isin(np.arange(len(x)), twist.led)
    assert turned[x[:, 2] > 0.8].all() and not turned[x[:, 2] < 0.2].any()
    np.testing.assert_allclose(twist.pivot[:2], 0, atol=STEP)


def test_a_stem_is_twisted_evenly_where_it_is_slender_enough():
    x, bend = make_stool(0.08)
    twist = find_twist(bend, x, UP, 0.5 * np.pi)
    assert twist is not None and twist.share is not None
    height, share = x[twist.led, 2], np.asarray(twist.share)
    assert (share[height > 0.8] > 0.99).all() and height.min() < 0.75
    order = np.argsort(height)
    slope = np.diff(share[order]) / np.maximum(np.diff(height[order]), STEP)
    assert slope.max() * 0.08 * 0.5 * np.pi < TORN
    assert (np.diff(share[order]) > -1e-9).all()


@pytest.mark.parametrize(
    ("axis", "angle"), [(UP, 0.2), (np.array([1.0, 0.0, 0.0]), FULL)], ids=["a little", "a bend"]
)
def test_what_its_own_border_bears_bends_there(axis, angle):
    x, bend = make_stool(0.08)
    assert find_twist(bend, x, axis, angle) is None


def test_what_stands_beside_the_part_stays():
    """A post as high as the seat that does not hang together with it above the stem."""
    x, bend = make_stool(0.08)
    post = fill(0.06, 0.0, 1.19) + (0.0, 0.0, 0.0)
    post[:, 0] += 0.8
    both = np.concatenate([x, post])
    low, size = both.min(0), np.ptp(both, axis=0)
    region = CellsRegion(
        inside=tuple(map(tuple, (np.array([(0.0, 0.0, 0.95), (0.8, 0.0, 1.1)]) - low) / size)),
        outside=tuple(map(tuple, (np.array([(0.0, 0.0, 1.05)]) - low) / size)),
    )
    bend = bend.model_copy(update=dict(rest=region, joint=tuple((np.array([0.0, 0.0, 1.0]) - low) / size)))
    twist = find_twist(bend, both, UP, 4 * FULL)
    assert twist is not None and twist.led.max() < len(x)


def test_what_hangs_beside_the_rest_swings_and_twists_nothing():
    """A tail touches the rump all along, so that the way out of the rest is across it."""
    tail = fill(0.08, 0.2, 0.9) + [0.38, 0, 0]
    x = np.concatenate([fill(0.3, 0.0, 1.0), tail])
    low, size = x.min(0), np.ptp(x, axis=0)
    body, seed, joint = (
        (np.array(place) - low) / size for place in ([0.2, 0, 0.5], [0.4, 0, 0.5], [0.38, 0, 0.85])
    )
    region = CellsRegion(inside=(tuple(body),), outside=(tuple(seed),))
    bend = Bend(joint=tuple(joint), rest=region, reach=2.0, depth=0.1)
    out = np.array([1.0, 0.0, 0.0])
    assert find_twist(bend, x, out, 0.25 * np.pi) is None


def test_a_head_that_is_turned_far_is_cut_at_its_neck_and_not_at_the_waist():
    """A neck is too short to be twisted by half a turn, and the body below is to stay."""
    x = np.concatenate(
        [
            fill(0.3, 0, 0.4),
            fill(0.2, 0.4, 0.6),
            fill(0.35, 0.6, 1.0),
            fill(0.1, 1.0, 1.1),
            fill(0.35, 1.1, 1.6),
        ]
    )
    low, size = x.min(0), np.ptp(x, axis=0)
    middle, cut = float(-low[0] / size[0]), (1.1 - low[2]) / size[2]
    region = CellsRegion(inside=((middle, middle, cut - 0.05),), outside=((middle, middle, cut + 0.05),))
    bend = Bend(joint=(middle, middle, cut), rest=region, reach=2.0, depth=0.05)
    twist = find_twist(bend, x, UP, np.pi)
    assert twist is not None and twist.share is None
    turned = np.isin(np.arange(len(x)), twist.led)
    assert turned[x[:, 2] > 1.1].all() and not turned[x[:, 2] < 1.0 - STEP].any()
