"""The table of what gradients cost."""

from pathlib import Path

from benchmarks.gradients import document


def test_the_page_shows_ratio_aim_and_memory_and_what_is_missing():
    row = {
        "run": 0,
        "job": "20 x 200",
        "particles": 20_000,
        "substeps": 200,
        "forward_ms": 1.5,
        "gradient_ms": 6.0,
    }
    row |= {"ratio": 4.0, "ratio_range": [3.9, 4.1], "aim": 5.0, "memory_gb": None, "allowed_gb": 2.0}
    row |= {"first_seconds": [1.0, 9.0]}
    run = {
        "quick": False,
        "seconds": 3.0,
        "command": "c",
        "machine": "m",
        "load_average": [0.1],
        "git_revision": "r",
    }
    page = document({"cost": {"runs": [run], "complete": True, "rows": [row]}}, Path("a.json"), Path("b.md"))
    assert "| 20,000 | 200 | 1.5 | 6 | 4 (3.9 to 4.1) | 5 |  | 2 | 1, 9 |" in page
    assert "Not measured yet: precision" in page
