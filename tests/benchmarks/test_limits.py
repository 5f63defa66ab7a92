"""The limits that docs/limits.md states: what is measured, its tables, and the words of the warnings."""

import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.evidence.catalogue import DOCS
from benchmarks.limits import (
    CELLS,
    PLATES,
    fill,
    liquid,
    list_parts,
    make_model,
    measure_parting,
    soft,
    write_tables,
)
from physagent_jax.mpm import Grid, State
from physagent_jax.mpm.limits import find_limits


def section(rows):
    run = dict(command="c", machine="m", git_revision="abc", load_average=[0.1], quick=False, seconds=1.0)
    return {"runs": [run], "complete": True, "rows": [row | {"run": 0, "job": "j"} for row in rows]}


def plate(matter, passed):
    return {"obstacle": "box", "cells": 1.5, "speed": 3.0, "matter": matter, "passed": passed}


def test_the_tables_show_least_and_greatest_share():
    thin = section([plate("sand", [0.5, 0.0, 1.0]), plate("fluid", [0.0, 0.0])])
    jar = section([{"per_axis": 2, "motion": "stirred", "depth": 0.92345, "det_F": 1.0071}])
    tables = write_tables({"thin": thin, "liquid": jar})
    assert "| box | 1.5 | 3 | 0 to 100 % | 0 % |  |" in tables["thin"]
    assert "| 8 | stirred | 0.923 | 1.007 |" in tables["liquid"]
    assert "Not measured yet: touching, tool." in tables["runs"]


def test_a_plate_of_triangles_stops_the_same_nodes_as_a_box():
    """Two cells thick with the upper face 0.3 above node 12: it covers nodes 11 and 12."""
    grid, time = Grid.whole(1.0, CELLS), jnp.array(0.0)
    falling = jnp.zeros((*grid.shape, 3)).at[..., 2].set(-1.0)
    stopped = [
        np.asarray(make(10.3 / CELLS, 12.3 / CELLS).apply(falling, grid, time))[CELLS // 2, CELLS // 2, :, 2]
        for make in PLATES.values()
    ]
    at = np.asarray(grid.node_positions(jnp.float32)[2]).ravel() * CELLS
    for velocity in stopped:
        # Node 11 lies nearer to the lower face, which pushes down.
        np.testing.assert_allclose(velocity[np.isclose(at, 12)], 0, atol=1e-6)
        np.testing.assert_allclose(velocity[at < 10.1], -1)
    np.testing.assert_allclose(stopped[0], stopped[1], atol=1e-6)


def test_bodies_that_touch_do_not_part():
    (row,) = measure_parting(0.0)
    assert row["free"] == pytest.approx(0.3 * 0.48 * 32) and -0.5 < row["opened"] < 0.1 * row["free"]


def test_a_quick_look_has_jobs_of_every_part():
    assert all(0 < len(make()) <= 2 for make in list_parts(quick=True).values())


def test_the_page_has_the_words_of_the_warnings():
    page = " ".join((DOCS / "limits.md").read_text().split())
    x, volume = fill((0.4, 0.4, 0.6), (0.6, 0.6, 0.8), 1 / CELLS / 2)
    apart = np.concatenate([x, x - [0, 0, 0.4]])
    cases = [
        (
            x,
            soft,
            (PLATES["box"](0.3, 0.3 + 1 / CELLS),),
            "obstacles of less than 3 cells let matter through",
        ),
        (
            apart,
            soft,
            (),
            "they share one velocity field, so that they stick and neither slide nor part again",
        ),
        (x, liquid, (), "liquids lose volume when they are stirred for long: some 8 % in 3 s"),
    ]
    for points, make, boundaries, words in cases:
        count = len(points)
        model = make_model(count, 1000 * volume, volume, [make(count)], boundaries=boundaries)
        (sentence,) = find_limits(model, State.at_rest(jnp.asarray(points, jnp.float32)), 3.0)
        assert words in sentence and words in page
