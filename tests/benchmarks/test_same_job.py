"""The job that all codes do alike: one body at every resolution, errors against a reference, and honest rows."""

import json

import numpy as np
import pytest

from benchmarks.peers.drop import DT
from benchmarks.peers.flight import CELLS, FRAME_DT, SIDE, SIZE, block_means, flight
from benchmarks.throughput import same_job
from benchmarks.throughput.measure import Contender
from benchmarks.throughput.parts import QUICK
from benchmarks.throughput.strict import same_job as tables
from benchmarks.throughput.strict import same_law


def test_blocks_hold_the_same_matter_at_every_resolution():
    coarse, fine = flight(1), flight(2, dtype=np.float64)
    np.testing.assert_allclose(block_means(coarse.x), block_means(fine.x), atol=1e-6)
    np.testing.assert_allclose(block_means(coarse.v), block_means(fine.v), atol=0.02)  # of 2.5 m/s
    assert coarse.mass.sum() == pytest.approx(fine.mass.sum()) and fine.cells == 2 * CELLS
    np.testing.assert_allclose(
        [coarse.x.min(), coarse.x.max()], SIZE / 2 + SIDE * np.array([-0.5, 0.5]), atol=0.02
    )


def test_steps_fit_frames_in_multiples():
    assert same_job._fit_step(DT) == DT
    for dt in (1.1e-3, 7e-4, 1.0e-3):
        fitted = same_job._fit_step(dt)
        count = FRAME_DT / fitted
        assert fitted <= dt and round(count) % same_job.GRANULE == 0 and count == pytest.approx(round(count))


def test_every_code_has_both_steps_both_orders_and_its_threads():
    names = [job.name for job in same_job.jobs(QUICK, None)]
    assert names[0] == same_job.FIRST and len(names) == len(set(names))
    for code in ("ours", "warp_classical", "taichi_mls", "genesis", "jax_naive"):
        for order in ("sorted", "random"):
            for step in ("customary", "bound"):
                assert f"{code}, 1 threads, {order}, {step}" in names


def row(code, step, seconds, error, threads=1, **changes):
    blank = same_job._make_blank_row(Contender(code, same_job.LAW, threads, order="sorted"), step, 1)
    known = dict(seconds=seconds, range=[seconds, seconds], substeps=100, least_dt=1e-3, largest_dt=1e-3)
    return blank | known | dict(error=error, setup_seconds=1.0, load_average=0.5) | changes


def level(cells, change, error):
    return row("ours", "automatic", 1.0, error, double=True, cells=cells, change=change)


def write(rows):
    return "\n\n".join(tables(rows).values())


def test_the_tables_set_all_against_ours_and_say_whether_the_reference_is_one():
    rows = [level(40, None, 4e-3), level(80, 1e-3, 1e-3), level(160, 3e-4, None) | {"means": "0"}]
    rows += [row("ours", "automatic", 2.0, 4e-3), row("warp_classical", "customary", 30.0, 6e-3)]
    rows += [row("warp_classical", "bound", None, None, message="NotImplementedError: a | b")]
    rows += [row("jax_naive", "bound", 5.0, None, message="breaks down")]
    text = write(rows)
    assert "| warp_classical | 1 | customary | 100 | 30 (30) | 15 | 6 (1.5) |  |  |  |" in text
    assert "customary step the fastest peer, warp_classical (1 thread(s), sorted), takes **15** times" in text
    assert "with 1.5 times our error" in text and "its own bound the fastest" not in text
    assert "NotImplementedError: a / b" in text and "| 5 (5) | 2.5 | breaks down |" in text
    assert "The last change is 0.075 of the least error above, less than the tenth" in text
    assert "| ours, float64 | 160 | 13,824 | 100 | 0.001 | 0.3 | (reference) |" in text
    rows[2] |= {"change": 9e-4}
    assert "0.22 of the least error above, **more** than" in write(rows)
    for table in text.split("\n\n"):
        lines = [line.count("|") for line in table.splitlines() if line.startswith("|")]
        assert len(set(lines)) <= 1


def test_substeps_are_set_against_ours_of_the_same_order():
    def timed(code, order, median):
        figures = dict(median_ms=median, min_ms=median, max_ms=median, busy=1.0, load_average=0.1)
        about = dict(code=code, law="jelly", threads=1, order=order, particles=1000, note="", message="")
        return about | figures

    rows = [timed("ours", "sorted", 2.0), timed("ours, unsorted", "random", 4.0)]
    rows += [timed("taichi_mls", "sorted", 20.0), timed("taichi_mls, unsorted", "random", 20.0)]
    text = same_law(rows)
    assert "| code | threads | order | fixed corotated [ms] | x ours |" in text
    assert "| taichi_mls | 1 | sorted | 20 (20 to 20) | 10 |" in text
    assert "| taichi_mls | 1 | random | 20 (20 to 20) | 5 |" in text


@pytest.mark.slow
def test_a_job_is_run_and_judged(tmp_path, monkeypatch):
    monkeypatch.setattr(same_job, "SHORT", 0.0)
    rows = same_job._make_reference(QUICK)
    assert (
        len(rows) == 2 and rows[0]["error"] == pytest.approx(rows[1]["change"]) and rows[1]["error"] is None
    )
    rows_file = tmp_path / "rows.json"
    labelled = [row | {"job": same_job.FIRST} for row in rows]
    rows_file.write_text(json.dumps({"same_job": {"rows": labelled}}))
    errors = {}
    for code, step in (("ours", "automatic"), ("ours", "bound"), ("jax_naive", "bound")):
        (found,) = same_job._measure_row(
            Contender(code, same_job.LAW, 1, order="random"), step, 1, rows_file, 1
        )
        assert found["message"] == "" and found["seconds"] > 0
        errors[code, step] = found["error"]
    assert errors["ours", "automatic"] == pytest.approx(rows[0]["error"], rel=1e-2)
    assert errors["jax_naive", "bound"] == pytest.approx(errors["ours", "bound"], rel=1e-2)
