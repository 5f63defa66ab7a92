"""The sentences, what is said of their videos, the contact sheets, and the page."""

import json
from collections import Counter
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pytest
from pydantic import ValidationError

from benchmarks.first_results import markdown
from benchmarks.first_results.__main__ import ROOT, Command, hide_folders
from benchmarks.first_results.catalogue import CASES, KINDS, THINGS, name_case
from benchmarks.first_results.oddities import find_pieces, pieces, simulation
from benchmarks.first_results.sheets import FRAMES, MOST_BYTES, WIDTH, encode_jpeg, write_sheets
from benchmarks.first_results.viewing import UNSEEN, Remark, find_view, hash_video, rank, read_remarks
from physagent_jax.core.errors import UserError
from physagent_jax.output.video import write_video
from physagent_jax.scene.presets import PresetName
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
    return SimulationRecord.model_validate(blank | changes)


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


def test_the_sentences_are_many_different_and_of_every_kind():
    assert len(CASES) == 24 and len({case.sentence for case in CASES}) == 24
    assert Counter(case.thing for case in CASES) == dict.fromkeys(THINGS, 3) and len(THINGS) == 8
    assert Counter(case.preset for case in CASES) == {PresetName.FAST: 16, PresetName.PAPER: 8}
    assert {kind for case in CASES for kind in case.kinds.split()} == KINDS
    assert name_case(7, CASES[6]) == "07-plant"


def test_objects_are_found_made_or_missing(tmp_path):
    assert THINGS["robot"].find_file(None, tmp_path) == ROOT / "examples" / "assets" / "robot.ply"
    assert THINGS["cow"].find_file(None, tmp_path) is None
    (tmp_path / "spot.obj").touch()
    assert THINGS["cow"].find_file(tmp_path, tmp_path) == tmp_path / "spot.obj"
    ball = THINGS["ball"].find_file(None, tmp_path / "made")
    assert ball is not None and ball.read_text().count("\nf ") == 1280


def test_rows_do_not_say_where_folders_are(tmp_path):
    command = Command(json=tmp_path / "rows.json", out=Path("runs/first"), data=tmp_path / "data")
    text = f"{tmp_path}/data/spot.obj {ROOT}/examples runs/first"
    assert hide_folders(text, command) == "DIR/spot.obj ./examples runs/first"
    inside = Command(json=tmp_path / "rows.json", out=ROOT / "runs" / "first")
    assert hide_folders(f"{ROOT}/runs/first/ball.obj", inside) == "OUT/ball.obj"


def test_a_remark_holds_for_the_video_that_was_looked_at_alone(tmp_path):
    file = tmp_path / "seen.json"
    file.write_text(json.dumps({"01-robot": {"video": "aa", "viewer": "partly", "remark": "It slides."}}))
    remarks = read_remarks(file)
    assert find_view({"case": "01-robot", "video": "aa"}, remarks) == ("partly", "It slides.")
    assert find_view({"case": "01-robot", "video": "bb"}, remarks) == (UNSEEN, "")
    assert find_view({"case": "02-robot", "video": "aa"}, remarks) == (UNSEEN, "")
    file.write_text(json.dumps({"01-robot": {"video": "aa", "viewer": "perhaps", "remark": "It slides."}}))
    with pytest.raises(ValidationError):
        read_remarks(file)


def test_the_remarks_kept_are_of_sentences_that_there_are():
    names = {name_case(number, case) for number, case in enumerate(CASES, 1)}
    assert read_remarks().keys() <= names


def test_disagreements_come_first():
    assert rank("SUCCESS", "no") == rank("FAIL", "yes") == rank("REFUSED", "yes") == 0
    assert rank("SUCCESS", "partly") == 1 and rank("SUCCESS", UNSEEN) == rank("FAIL", UNSEEN) == 2
    assert rank("SUCCESS", "yes") == rank("FAIL", "no") == rank("FAIL", "partly") == 3


@pytest.fixture
def videos(tmp_path):
    """Runs of two sentences whose pictures turn from black to grey, frame by frame, and rows of them and of a third."""
    rows = []
    for number in (1, 2):
        case, video = f"0{number}-robot", tmp_path / f"0{number}-robot" / "video.mp4"
        video.parent.mkdir()
        grey = np.arange(25, dtype=np.uint8) * (4 * number)
        write_video(video, np.broadcast_to(grey[:, None, None, None], (25, 72, 128, 3)), 25)
        about = dict(preset="fast", sentence="push it", verdict="FAIL", true_verdict="SUCCESS", frames=25)
        rows.append({"case": case, "video": hash_video(video), "frame_dt": 0.04, **about})
    refused = dict(case="03-robot", video=None, preset="fast", sentence="do it", verdict="REFUSED")
    return [*rows, refused]


def test_a_strip_shows_the_video_from_its_first_frame_to_its_last(videos, tmp_path):
    (file,) = write_sheets(tmp_path / "images", videos, tmp_path)
    sheet = imageio.imread(file)
    height = round(WIDTH * 72 / 128)
    assert file.name == "first-results-1.jpg" and file.stat().st_size <= MOST_BYTES
    assert sheet.shape == (3 * 26 + 2 * height, FRAMES * WIDTH, 3)
    middle = 26 + height // 2  # of the first strip's pictures, above the label
    greys = [sheet[middle, place * WIDTH + WIDTH // 2].mean() for place in range(FRAMES)]
    np.testing.assert_allclose(greys, np.arange(25)[::4] * 4, atol=4)
    assert sheet[:26].min() < 100 and sheet[:26].mean() > 230  # a caption, black on white
    assert sheet[-26:].mean() > 230  # of the sentence that was refused


def test_a_sheet_is_of_the_videos_that_were_judged(videos, tmp_path):
    videos[1]["video"] = "0123456789abcdef"
    with pytest.raises(UserError, match="02-robot: another video"):
        write_sheets(tmp_path / "images", videos, tmp_path)
    (tmp_path / "01-robot" / "video.mp4").unlink()
    with pytest.raises(UserError, match="01-robot: no video"):
        write_sheets(tmp_path / "images", videos, tmp_path)


def test_what_hardly_compresses_is_made_small_all_the_same():
    noise = np.random.default_rng(0).integers(0, 256, (966, 1680, 3), np.uint8)
    with pytest.raises(UserError, match="too large"):
        encode_jpeg(noise)
    assert 0 < len(encode_jpeg(noise[::2, ::2])) <= MOST_BYTES


def row(number, oddities, **changes):
    blank = {
        "run": 0,
        "job": str(number),
        "case": f"0{number}-robot",
        "object": "robot",
        "sentence": "spin it",
        "preset": "fast",
        "options": [],
        "video": f"digest {number}",
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
        "true_verdict": "SUCCESS",
        "true_score": 0.9,
        "true_failed_checks": [],
        "unsure": [],
        "not_understood": [],
        "iterations": 3,
        "particle_count": 20000,
        "substeps": 1234,
        "wall_s": {"total": 12.3},
    }
    return blank | changes


REMARKS = {
    "01-robot": Remark(video="digest 1", viewer="no", remark="It slides aside."),
    "02-robot": Remark(video="digest 2", viewer="yes", remark="It turns."),
    "03-robot": Remark(video="another", viewer="yes", remark="It turned once."),
    "04-robot": Remark(video=None, viewer="no", remark="There is nothing to see."),
}


def document(result):
    return "\n\n".join(markdown.write_tables(result, REMARKS).values())


@pytest.fixture
def result():
    run = dict(command="c", machine="m", load_average=[0.1], git_revision="abc", quick=False, seconds=1.0)
    refused = {
        key: row(4, [])[key] for key in ("run", "job", "case", "object", "sentence", "preset", "options")
    }
    rows = [
        row(1, ["seen by all", "hands fly off"]),
        row(2, ["seen by all"], failed_checks=[], unsure=["which way"]),
        row(3, ["seen by all"], verdict="SUCCESS", true_failed_checks=["far? expected a, observed b"]),
        {**refused, "video": None, "verdict": "REFUSED", "message": "no motion in 'be'"},
    ]
    return {"sentences": {"runs": [run | {"left_out": ["cow"]}], "complete": True, "rows": rows}}


def test_the_page_has_revision_perception_errors_and_oddities(result):
    text = document(result)
    assert "| sentences | 4 | 1.0 | A; 0.1; abc |" in text and "A: m." in text and "no file: cow." in text
    assert "| 01 | not seen | (+0.10 +0.00 +0.00) | not seen | 60 | 80 | 20 " in text
    assert "| (1.00 1.00 1.20) | (1.00 1.00 1.10) | 0.1 | 0.98 | 40 of 50 |" in text
    assert "- **All**: seen by all" in text
    assert "- **01, robot**: hands fly off; not passed: is it still? expected yes, observed no." in text
    assert "- **02, robot**: unsure: which way." in text
    assert "not passed, from the truth: far? expected a, observed b." in text
    assert "- **04, robot**: refused: no motion in 'be'." in text
    for table in text.split("\n\n"):
        lines = [line.count("|") for line in table.splitlines() if line.startswith("|")]
        assert len(set(lines)) <= 1


def test_the_page_counts_and_lists_where_verdict_and_viewer_disagree(result):
    text = document(result)
    for line in (
        "| SUCCESS from the pictures | 0 | 0 | 0 | 1 | 1 |",
        "| REFUSED from the pictures | 0 | 0 | 1 | 0 | 1 |",
        "| FAIL from the pictures | 1 | 0 | 1 | 0 | 2 |",
        "| SUCCESS from the truth | 1 | 0 | 1 | 1 | 3 |",
    ):
        assert line in text
    rows = [
        "| 02 | robot | fast | spin it | yes | It turns. | FAIL (0.50) | SUCCESS (0.90) | 3 | 12 | [sheet]",
        f"| 03 | robot | fast | spin it | {UNSEEN} |  | SUCCESS (0.50) |",
        "| 01 | robot | fast | spin it | no | It slides aside. |",
        "| 04 | robot | fast | spin it | no | There is nothing to see. | REFUSED |",
    ]
    places = [text.index(line) for line in rows]
    assert places == sorted(places)
    assert text.count("(images/first-results-1.jpg)") == 4  # three rows, and the sheet itself


def test_runs_without_oddities_share_a_line_and_warnings_end_with_their_first_clause(result):
    first, second = result["sentences"]["rows"][:2]
    quiet = dict(failed_checks=[], true_failed_checks=[], oddities=[], unsure=[])
    loud = dict(quiet, oddities=["warning: it would fall: it is held"])
    result["sentences"]["rows"] = [first | quiet, second | quiet, first | loud | {"case": "05-robot"}]
    text = markdown.write_tables(result, REMARKS)["oddities"]
    assert text == "- **05, robot**: warning: it would fall.\n- **01, robot; 02, robot**: nothing.\n"
