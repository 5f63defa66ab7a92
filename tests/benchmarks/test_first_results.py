"""What the twelve sentences' document says of perception and of oddities."""

import numpy as np
import pytest

from benchmarks.first_results.markdown import BEGIN, END, document
from benchmarks.first_results.oddities import find_pieces, pieces, simulation
from physagent_jax.simulation.record import SimulationRecord

DX = 0.1


def box(count, low):
    """A lattice of ``count`` particles along each axis, two per cell."""
    axes = [(np.arange(n) + 0.5) * DX / 2 + start for n, start in zip(count, low)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


BODY, HAND = box((10, 10, 10), (0, 0, 0)), box((3, 3, 3), (0.8, 0, 0))


def record(**changes):
    blank = dict(
        particle_count=1,
        gaussian_count=1,
        grid_shape=(1, 1, 1),
        dx=DX,
        substeps=1,
        substep_dt=(0.1,),
        stable_dt=None,
        kinetic_energy=(0.0,),
        elastic_energy=(0.0,),
        momentum=((0.0, 0.0, 0.0),),
        min_volume_ratio=(1.0,),
        max_volume_ratio=(1.0,),
    )
    return SimulationRecord(**(blank | changes))


def test_pieces_are_what_no_cell_joins_the_largest_first():
    piece = find_pieces(np.concatenate([HAND, BODY]), 1.5 * DX)
    assert np.all(piece[: len(HAND)] == 1) and np.all(piece[len(HAND) :] == 0)


def test_a_free_hand_that_flies_off_is_told_with_its_distance():
    still = np.concatenate([BODY, HAND])
    flown = np.concatenate([BODY, HAND + np.array([0.3, 0, 0])])
    (words,) = pieces(np.stack([still, flown]), record())
    length = np.ptp(still, axis=0).max()
    assert words.startswith(
        "a piece of 2.6% of the particles is joined to the body by nothing, from the start, and"
    )
    before = HAND.mean(0) - BODY.mean(0)
    grown = np.linalg.norm(before + np.array([0.3, 0, 0])) - np.linalg.norm(before)
    assert f"is {grown / length:.2f} L farther at the end" in words
    (words,) = pieces(np.stack([still, still + 0.2]), record())
    assert words.endswith("and keeps its distance")
    assert list(pieces(np.stack([BODY, BODY]), record())) == []


def test_what_comes_off_in_the_clip_is_told():
    torn = BODY.copy()
    torn[BODY[:, 0] < 0.05] -= np.array([1.0, 0, 0])
    (words,) = pieces(np.stack([BODY, torn]), record())
    assert words == "1 piece(s) of 10.00% of the particles in all come off in the clip"


def test_crushed_matter_stopped_particles_and_redone_frames_are_told():
    assert list(simulation(record())) == []
    found = list(
        simulation(
            record(
                min_volume_ratio=(1.0, 0.1),
                max_volume_ratio=(1.0, 3.0),
                stopped_particles=7,
                redone_frames={3: "too fast", 4: "too fast"},
            )
        )
    )
    assert [words.split()[0] for words in found] == ["matter", "matter", "particles", "2"]
    assert "0.1 of its volume" in found[0] and "7 times" in found[2] and found[3].endswith("step: too fast")


def row(number, oddities, **changes):
    blank = {
        "run": 0,
        "job": str(number),
        "number": number,
        "object": "robot",
        "prompt": "spin it",
        "force_field": {"default_drop": True, "actions": [], "constraints": []},
        "perceived_centroid": None,
        "true_centroid": [0.1, 0.0, 0.0],
        "perceived_farthest": None,
        "true_farthest": [0.1, 0.0, 0.0],
        "perceived_rotation": 60.0,
        "true_rotation": 80.0,
        "perceived_stretch": [1.0, 1.0, 1.2],
        "true_stretch": [1.0, 1.0, 1.1],
        "frames": 50,
        "errors": dict(
            centroid_error_max=None,
            rotation_error_max=20.0,
            stretch_error_last=0.1,
            size_ratio=0.98,
            frames_observed=40,
        ),
        "oddities": oddities,
        "verdict": "FAIL",
        "score": 0.5,
        "failed_checks": ["is it still? expected yes, observed no"],
        "iterations": 3,
        "wall_s": {"total": 12.3},
    }
    return blank | changes


@pytest.fixture
def result():
    run = dict(command="c", machine="m", load_average=[0.1], git_revision="abc", quick=False, seconds=1.0)
    rows = [row(1, ["seen by all", "hands fly off"]), row(2, ["seen by all"], failed_checks=[])]
    return {"sentences": {"runs": [run | {"left_out": ["cow"]}], "complete": True, "rows": rows}}


def test_the_document_has_revision_perception_errors_and_oddities(result, tmp_path):
    text = document(result, tmp_path / "first.json", tmp_path / "first.md")
    assert "| sentences | 2 | 1.0 | `c`; m; 0.1; abc |" in text and "no file: cow." in text
    assert "| 1 | not seen | (+0.10 +0.00 +0.00) | not seen | 60 | 80 | 20 " in text
    assert "| (1.00 1.00 1.20) | (1.00 1.00 1.10) | 0.1 | 0.98 | 40 of 50 |" in text
    assert "- **All rows**: seen by all" in text
    assert 'robot, "spin it"**: hands fly off; not passed: is it still? expected yes, observed no.' in text
    assert '- **2, robot, "spin it"**: nothing.' in text
    for table in text.split("\n\n"):
        lines = [line.count("|") for line in table.splitlines() if line.startswith("|")]
        assert len(set(lines)) <= 1


def test_what_people_wrote_around_the_measured_part_stays(result, tmp_path):
    target = tmp_path / "first.md"
    target.write_text(f"# Title\n{BEGIN}old\n{END}## Remarks\n")
    text = document(result, tmp_path / "first.json", target)
    assert text.startswith("# Title\n") and text.endswith("## Remarks\n") and "old" not in text
    target.write_text(text)
    assert document(result, tmp_path / "first.json", target) == text
