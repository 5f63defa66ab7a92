"""The throughput benchmark: same particles for all, honest rows, and a document made of the rows."""

import json

import numpy as np
import pytest

from benchmarks.peers import Contact, Material
from benchmarks.peers.drop import CELLS, DT, FLOOR, SIDE, drop, floor_as_wall
from benchmarks.peers.ours import Ours, build
from benchmarks.throughput import measure, parts
from benchmarks.throughput.markdown import PARTS, write_tables
from benchmarks.throughput.measure import Contender, Effort, compare, interleaved
from benchmarks.throughput.ours import job, stages

SHORT = Effort(rounds=2, round_seconds=0.0, least=10, slowest=1e9)


def test_the_cube_is_the_same_whoever_asks_and_fills_its_box():
    first, second = drop(500, Material.JELLY), drop(500, Material.SAND, cells=64)
    np.testing.assert_array_equal(first.x, second.x)
    np.testing.assert_allclose(np.ptp(first.x, axis=0), SIDE, rtol=0.05)
    assert 0.004 < first.x[:, 2].min() - FLOOR < 0.02
    np.testing.assert_allclose(first.mass.sum(), 1000 * SIDE**3, rtol=1e-5)
    assert np.any(np.diff(first.x[:, 0]) < 0)  # not sorted


def test_the_wall_in_place_of_the_floor_has_its_height():
    scene = floor_as_wall(drop(10, Material.JELLY))
    assert scene.planes == () and scene.domain_box is not None
    assert scene.domain_box * scene.dx == pytest.approx(FLOOR)


def test_our_model_is_the_scene():
    scene = drop(50, Material.METAL)
    model, state = build(scene, "reference")
    assert model.kernels == "reference" and model.grid.cells == CELLS
    np.testing.assert_allclose(state.x, scene.x)
    metal = model.materials[0]
    np.testing.assert_allclose(metal.yield_stress, np.sqrt(1.5) * scene.yield_stress, rtol=1e-6)
    assert [type(boundary).__name__ for boundary in model.boundaries] == ["HalfSpace", "DomainBox"]
    assert model.boundaries[0].contact.value == Contact.STICKY.value


def test_ours_advances_by_as_many_steps_as_asked_for_and_times_compilation_apart():
    ours = Ours()
    ours.load(drop(500, Material.NEO_HOOKEAN, cells=32), DT)
    ours.run(450)
    assert float(ours.state.time) == pytest.approx(450 * DT, rel=1e-4)
    assert ours.compile_seconds >= 0
    timed = stages(ours, 2)
    assert {"p2g", "grid update", "g2p", "projection and stress", "substep"} < set(timed)
    assert min(timed.values()) > 0


def test_a_job_tells_its_steps_and_heights():
    found = job(drop(300, Material.NEO_HOOKEAN, cells=32), frames=2)
    assert len(found["heights"]) == 3 and found["substeps"] > 0
    assert found["heights"][2] < found["heights"][0]


@pytest.mark.slow
def test_rounds_take_turns_and_nobody_is_dropped():
    contenders = [
        Contender("ours", Material.NEO_HOOKEAN, 1),
        Contender("jax_naive", Material.JELLY, 1),
        Contender("jax_naive", Material.SAND, 1),
        Contender("genesis", Material.SAND, 1),
    ]
    rows = interleaved(contenders, 300, SHORT, cells=32)
    compare(rows)
    assert [row["code"] for row in rows] == ["ours", "jax_naive", "jax_naive", "genesis"]
    for row in rows[:2]:
        assert len(row["rounds_ms"]) == 2 and row["min_ms"] <= row["median_ms"] <= row["max_ms"]
        assert row["setup_seconds"] > 0 and row["peak_mb"] > 50 and row["message"] == ""
    assert rows[1]["over_default"] == pytest.approx(rows[1]["median_ms"] / rows[0]["median_ms"], rel=1e-2)
    assert rows[1]["over_ours"] is None  # no row of ours with that law
    assert "sand" in rows[2]["message"] and rows[2]["median_ms"] is None
    assert rows[3]["message"]
    json.dumps(rows)


def test_a_code_that_is_too_slow_keeps_its_row():
    rows = interleaved([Contender("ours", Material.NEO_HOOKEAN, 1)], 100, Effort(slowest=0.0), cells=32)
    assert rows[0]["message"].startswith("skipped: one substep takes") and rows[0]["median_ms"] is None


def test_a_process_that_dies_is_a_reason(monkeypatch):
    monkeypatch.setattr(measure.sys, "executable", "false")
    rows = interleaved([Contender("ours", Material.NEO_HOOKEAN, 1)], 100, SHORT, cells=32)
    assert "its process ended with code 1" in rows[0]["message"]


def row(code, law, group, median, threads=1, **rest):
    blank = measure._make_blank_row(Contender(code, law, threads), 200_000, CELLS)
    return blank | dict(group=group, median_ms=median, min_ms=median, max_ms=median, setup_seconds=1.0) | rest


def test_the_tables_have_the_rows_and_say_what_falls_short():
    jelly = [
        row("ours", Material.NEO_HOOKEAN, "jelly", 10.0),
        row("ours", Material.NEO_HOOKEAN, "jelly", 8.0, threads=2),
        row("ours", Material.JELLY, "jelly", 19.0, threads=2),
        row("ours", Material.JELLY, "jelly", 20.0),
        row("warp_classical", Material.JELLY, "jelly", 150.0),
        row("taichi_mls", Material.JELLY, "jelly", None, message="taichi | is not installed"),
    ]
    compare(jelly)
    lengthy = dict(seconds=10.0, heights=[0.0, 0.1], least_dt=8e-4)
    own = parts.row_of(
        "job", Contender("ours", Material.NEO_HOOKEAN, 2), 200_000, extrapolated=False, **lengthy
    )
    peer = parts.row_of("job", Contender("warp_classical", Material.JELLY, 1), 200_000, seconds=600.0)
    own |= dict(substeps=50, largest_dt=8e-4, setup_seconds=1.0)
    peer |= dict(substeps=10_000, least_dt=DT, largest_dt=DT, setup_seconds=1.0)
    peer |= dict(extrapolated=True, measured_substeps=250)
    run = dict(command="c", machine="m", git_revision="r", quick=False, seconds=1.0, load_average=[0.1])

    def section(*rows):
        return {"runs": [run], "complete": True, "rows": [row | {"run": 0, "job": "j"} for row in rows]}

    finer = parts.row_of(
        "error", Contender("ours", Material.JELLY, 2), 1_600_000, heights=[0.5, 0.1], error=None
    )
    finer |= dict(code="ours, 200 cells", cells=200, substeps=400, least_dt=4e-4, largest_dt=5e-4)
    coarse = finer | dict(code="ours", particles=200_000, cells=100, heights=[0.5, 0.103])
    warp = coarse | dict(code="warp_classical", heights=[0.5, 0.104])
    result = {"materials": section(*jelly), "job": section(own, peer), "error": section(finer, coarse, warp)}
    text = "\n\n".join(write_tables(result).values())
    assert "Not measured yet: same_law, same_job, sizes, grids, stages, memory." in text and len(PARTS) == 9
    assert (
        "| Warp, each code's default jelly | 14 | 18.8 (1 thread, ours 2); 15.0 (one thread each) | reached |"
        in text
    )
    assert "| 50 | 60.0 (1 thread, ours 2, extrapolated) | reached |" in text
    assert "Falls short: Warp, the same corotated law." in text
    assert "taichi / is not installed" in text
    assert "600 (extrapolated from 250 substeps) |  | 60 |" in text
    assert "no larger error than Warp's: 2.12 mm against 2.83 mm, reached." in text
    assert "| ours | 100 | 200,000 | 400 | 0.0004 to 0.0005 | 2.12 | 3 |" in text
    run["quick"] = True
    quick = "\n\n".join(write_tables(result).values())
    assert "quick: not to be quoted" in quick and "| reached |" not in quick and "Falls short" not in quick


def test_sizes_stand_side_by_side():
    """A line for each code, with its time, that over our default, and what there is to remark."""
    rows = [
        row("ours", Material.NEO_HOOKEAN, "sizes", 2.0) | {"particles": 1000},
        row("genesis", Material.JELLY, "sizes", 8.0, note="a | wall") | {"particles": 1000},
        row("ours", Material.NEO_HOOKEAN, "sizes", 20.0),
        row("genesis", Material.JELLY, "sizes", None, message="skipped"),
    ]
    compare(rows[:2])
    compare(rows[2:])
    run = dict(command="c", machine="m", git_revision="r", quick=False, seconds=1.0, load_average=[0.1])
    text = write_tables({"sizes": {"runs": [run], "complete": True, "rows": rows}})["sizes"]
    assert "| code | law | threads | 1,000 | 200,000 |" in text
    assert "| ours | neo_hookean | 1 | 2 (1) | 20 (1) |" in text
    assert "| genesis | jelly | 1 | 8 (4) | skipped |" in text and "\ngenesis: a / wall.\n" in text
