"""The stress matrix: its checks can fail, and the simulator stands its hardest rows (all: benchmarks.stability)."""

import dataclasses

import numpy as np
import pytest

from benchmarks.stability.comparisons import permuted, shifted
from benchmarks.stability.criteria import Result, examine, watch
from benchmarks.stability.degenerate import MALFORMED, Edge, squeezed
from benchmarks.stability.dt_crit import REQUIRED, measure
from benchmarks.stability.matrix import pairwise
from benchmarks.stability.pairwise import covering_array, uncovered
from benchmarks.stability.scenario import Scenario, build


@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("subject", ["neo-hookean", "cohesive-fluid"])
def test_the_bound_is_safe_and_sharp_for_lone_particles(subject, form, x64):
    found = measure(subject, "isolated", form)
    assert REQUIRED <= found.ratio < 1.06 and not found.unlimited


def test_the_bound_is_safe_where_particles_cross_cells(x64):
    assert measure("neo-hookean, nu 0.45", "spray", "gradient").good


def test_viscosity_is_in_the_bound(x64):
    assert REQUIRED <= measure("viscous cohesive-fluid", "isolated", "mls").ratio < 1.5


@pytest.mark.parametrize(
    "scenario",
    [
        Scenario("neo-hookean", "impulse", 100.0),
        Scenario("neo-hookean", "torque", 1.0),
        Scenario("fluid", "translation", 100.0),
        Scenario("neo-hookean", youngs_modulus=1e3, wall="corner"),
        Scenario("neo-hookean", youngs_modulus=1e9, wall="corner", most_steps=500),
    ],
    ids=lambda scenario: scenario.name,
)
def test_the_automatic_step_survives(scenario):
    result = examine(scenario)
    assert result.verdict == "pass", result.message


def test_a_step_above_the_bound_is_refused_and_by_force_never_wrong_in_silence():
    above = Scenario("neo-hookean", step=("bound", 1.1), wall="corner", most_steps=500)
    refused = examine(above)
    assert refused.verdict == "refused" and "stable bound" in refused.message
    forced = examine(dataclasses.replace(above, step=("bound", 2.0), forced=True))
    assert forced.verdict in ("pass", "refused"), forced.message


@pytest.mark.parametrize("name", MALFORMED)
def test_senseless_input_is_refused_in_words(name):
    edge = Edge(name, Scenario("neo-hookean"), MALFORMED[name], "refused")
    result = examine(edge.scenario, name, edge.build)
    assert result.verdict == "refused", result.message


def test_squeezed_to_nothing_is_not_wrong_in_silence():
    edge = Edge("squeezed", Scenario("neo-hookean", most_steps=500), squeezed)
    result = examine(edge.scenario, edge.name, edge.build)
    assert result.verdict != "FAIL", result.message


def broken(change) -> Result:
    """The verdict on a good run of which one frame was tampered with."""
    scenario = Scenario("neo-hookean", "translation", most_steps=200)
    run = build(scenario)
    frames = list(run.frames(4))
    frames[2] = change(frames[2])
    result = Result("tampered")
    watch(scenario, run, frames, result)
    return result


def replaced(frame, **changes):
    return dataclasses.replace(frame, state=dataclasses.replace(frame.state, **changes))


@pytest.mark.parametrize(
    "criterion, change",
    [
        ("P1", lambda f: replaced(f, x=f.state.x.at[0].set(np.nan))),
        ("P2", lambda f: replaced(f, x=f.state.x.at[0].set(-0.1))),
        ("P3", lambda f: dataclasses.replace(f, min_J=0.01)),
        (
            "P4",
            lambda f: dataclasses.replace(
                f, exchange=dataclasses.replace(f.exchange, numerical_loss=f.exchange.numerical_loss - 1.0)
            ),
        ),
        ("P5", lambda f: replaced(f, v=f.state.v * 1.01)),
    ],
)
def test_every_check_can_fail(criterion, change):
    assert criterion in broken(change).failed
    assert not broken(lambda frame: frame).failed


def test_order_and_place_of_particles_do_not_matter():
    for result in (permuted("neo-hookean"), shifted("neo-hookean")):
        assert result.verdict == "pass", result.message


def test_covering_arrays_cover():
    axes = {"a": (1, 2, 3), "b": "xyz", "c": (True, False), "d": tuple(range(7))}
    rows = covering_array(axes, seed=3)
    assert uncovered(axes, rows) == 0 and len(rows) < 30
    assert uncovered(axes, rows[:-1]) > 0
    keys = [tuple(row.values()) for row in covering_array({"a": axes["a"], "b": axes["b"]})]
    restricted = covering_array(axes, keys=keys)
    assert uncovered(axes, restricted) == 0
    assert {(row["a"], row["b"]) for row in restricted} <= set(keys)


def test_the_matrix_holds_every_pair():
    scenarios = pairwise()
    names = (
        "material",
        "cells",
        "per_cell",
        "dtype",
        "stress_form",
        "force",
        "youngs_modulus",
        "wall",
        "magnitude",
    )
    axes = {name: sorted({getattr(s, name) for s in scenarios}) for name in names}
    assert uncovered(axes, [{name: getattr(s, name) for name in names} for s in scenarios]) == 0
    assert {s.step for s in scenarios if s.refusable} == {("bound", 1.1), ("bound", 2.0)}
    assert len(scenarios) < 150
