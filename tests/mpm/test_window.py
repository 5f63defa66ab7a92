"""The grid window covers what it must, and rarely has another shape."""

import numpy as np
import pytest

from physagent_jax.mpm import find_smallest_window, fit_window

CELLS = 96
DX = 1 / CELLS


def follow(boxes):
    """The windows for boxes [cells], shape (k, 2, 3), one after the other."""
    grid, windows = find_smallest_window(1.0, CELLS), []
    for low, high in boxes:
        grid = fit_window(grid, low * DX, high * DX, 2 * DX)
        origin, shape = np.asarray(grid.origin), np.asarray(grid.shape)
        assert np.all(origin >= 0) and np.all(origin + shape <= CELLS + 1)
        first, last = np.floor(low - 2 - 0.5), np.floor(high + 2 - 0.5) + 2
        assert np.all(origin <= np.maximum(first, 0))
        assert np.all(last.clip(max=CELLS) < origin + shape)
        windows.append(tuple(grid.shape))
    return windows


def growing(rates, frames):
    """A box of 20 cells in the middle that grows by so many cells per frame and axis, up to the domain."""
    half = 10 + 0.5 * np.arange(frames)[:, None] * np.asarray(rates)
    return np.stack([48 - half, 48 + half], axis=1).clip(0, CELLS)


@pytest.mark.parametrize(
    ("rates", "shapes"), [((1, 0, 0), 4), ((1, 1, 1), 4), ((0.1, 0, 1.5), 4), ((2, 1, 0.5), 6)]
)
def test_growth_takes_few_shapes(rates, shapes):
    """However the axes grow, from a fifth of the domain's side up to all of it; sides never shrink."""
    windows = follow(growing(rates, 80))
    assert len(set(windows)) <= shapes
    assert np.all(np.diff(windows, axis=0) >= 0)


def test_an_object_that_travels_or_shrinks_keeps_its_shape():
    """Small changes of what is needed are within the room that the first window has."""
    wobble = np.random.default_rng(0).uniform(-0.5, 0.5, size=(50, 2, 3))
    travelling = growing((0, 0, 0), 50) + np.linspace(-30, 30, 50)[:, None, None] + wobble
    assert len(set(follow(travelling))) == 1
    assert len(set(follow(growing((1, 1, 1), 60)[::-1]))) == 1
