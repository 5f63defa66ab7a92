"""The sentences, what is said of their videos, the contact sheets, and the page."""

import dataclasses
import hashlib
import json
from collections import Counter
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pytest
from pydantic import ValidationError

from benchmarks.first_results import markdown, pins
from benchmarks.first_results.__main__ import ROOT, Command, hide_folders
from benchmarks.first_results.catalogue import FIRST, KINDS, SETS, THINGS, name_case, name_cases
from benchmarks.first_results.held_back import FILES
from benchmarks.first_results.objects import main as fetch_objects
from benchmarks.first_results.pins import PinnedFile, collect
from benchmarks.first_results.sheets import (
    FRAMES,
    MOST_BYTES,
    STILLS,
    WIDTH,
    encode_jpeg,
    write_sheets,
    write_stills,
)
from benchmarks.first_results.viewing import (
    UNSEEN,
    Remark,
    find_view,
    hash_video,
    list_unseen,
    rank,
    read_remarks,
)
from physagent_jax.core.errors import UserError
from physagent_jax.output.video import write_video
from physagent_jax.scene.presets import PresetName


def test_the_sentences_are_many_different_and_of_every_kind():
    assert len(FIRST) == 24 and len({case.sentence for case in FIRST}) == 24
    assert set(Counter(case.thing for case in FIRST).values()) == {3} and len(THINGS) == 8 + len(FILES)
    assert Counter(case.preset for case in FIRST) == {PresetName.FAST: 16, PresetName.PAPER: 8}
    assert {kind for cases in SETS.values() for case in cases for kind in case.kinds.split()} == KINDS
    assert name_case(7, FIRST[6]) == "07-plant" and list(name_cases("sixty"))[0] == "sixty-01-teapot"


@pytest.mark.parametrize(
    "group, pairs, things, digest",
    [
        ("sixty", 60, 18, "a9d96a6e7426a7f5"),
        ("twenty", 20, 5, "02b65ccff9944666"),
        ("again", 20, 5, "a9414912cd9bd2a4"),
        ("third", 20, 5, "b393d83dc5031727"),
        ("fourth", 20, 5, "4ca76606e04e86f2"),
        ("fifth", 20, 5, "5c0b5bdb1ef0352c"),
        ("sixth", 20, 5, "40f088f1b3113338"),
        ("seventh", 20, 5, "5f3e39558da59383"),
        ("eighth", 20, 5, "d8373225c6d1bc58"),
        ("ninth", 20, 5, "51638dbc910b4a7e"),
        ("tenth", 20, 5, "5c2c91172decac09"),
        ("eleventh", 20, 5, "815c78c88b4b0ece"),
        ("twelfth", 20, 5, "cdd46dabe9be7e94"),
        ("thirteenth", 20, 5, "fd143df9f31932e2"),
        ("fourteenth", 20, 5, "04a04c0e454b02de"),
        ("fifteenth", 20, 5, "900b044c0525abca"),
        ("sixteenth", 20, 5, "258bb64572068a31"),
        ("seventeenth", 20, 5, "e455694860e1b56d"),
        ("eighteenth", 20, 5, "80a3f572f22d65be"),
        ("nineteenth", 20, 5, "acba7f8cff5fa4bd"),
        ("twentieth", 20, 5, "2d636910404c39fa"),
        ("twentyfirst", 20, 5, "9687b5eb1def3ee3"),
        ("twentysecond", 20, 5, "379e99ee998ea9de"),
        ("twentythird", 20, 5, "15a6a474634063ef"),
        ("twentyfourth", 20, 5, "dff41fc2cb8ea1e2"),
        ("twentyfifth", 20, 5, "0f0fbf016f430f65"),
        ("twentysixth", 20, 5, "3fee7311cf004e81"),
        ("twentyseventh", 20, 5, "9d764af322504f9e"),
        ("twentyeighth", 20, 5, "6119aaf329110f9b"),
        ("twentyninth", 20, 5, "731ffcd45cce95b0"),
    ],
)
def test_pairs_that_were_held_back_are_as_they_were_written(group, pairs, things, digest):
    """A pair that has been run can be changed no more: whoever wants another writes another set."""
    cases = SETS[group]
    told = [(case.thing, case.sentence, case.preset.value, case.options) for case in cases]
    named = dict.fromkeys(case.thing for case in cases)
    files = [(name, FILES[name].name, FILES[name].sha256, THINGS[name].options) for name in named]
    assert hashlib.sha256(repr((told, files)).encode()).hexdigest()[:16] == digest
    assert len({case.sentence for case in cases}) == pairs and len({case.thing for case in cases}) == things
    assert all(case.preset is PresetName.FAST and not case.options for case in cases)


def test_the_sixty_have_parts_and_materials_and_the_sets_share_no_object():
    kinds = Counter(kind for case in SETS["sixty"] for kind in case.kinds.split())
    assert kinds["part"] >= 15 and kinds["material"] >= 10
    named = [{case.thing for case in cases} for cases in SETS.values()]
    assert sum(map(len, named)) == len(set.union(*named))
    assert (
        len({file.sha256 for file in FILES.values()})
        == len({file.name for file in FILES.values()})
        == len(FILES)
    )


@pytest.fixture
def copies(tmp_path):
    """A folder that has, below it and under another name, a file that a pin is made of."""
    folder = tmp_path / "copies" / "deep"
    folder.mkdir(parents=True)
    (folder / "other-name.bin").write_bytes(b"a mesh")
    (folder / "else.bin").write_bytes(b"another")
    return folder.parent


def pin(content=b"a mesh"):
    return PinnedFile("ball.obj", "owner/name/commit", hashlib.sha256(content).hexdigest(), "mesh")


def test_copies_are_taken_by_their_hash_and_kept(copies, tmp_path):
    (path,) = collect([pin()], tmp_path / "into", copies)
    assert path == tmp_path / "into" / "ball.obj" and path.read_bytes() == b"a mesh"
    assert collect([pin()], tmp_path / "into", tmp_path / "nowhere") == [path]  # it is there already
    path.write_bytes(b"changed")
    collect([pin()], tmp_path / "into", copies)
    assert path.read_bytes() == b"a mesh"
    with pytest.raises(UserError, match="Fetch https://raw.githubusercontent.com/owner/name/commit/ball.obj"):
        collect([pin(b"a third")], tmp_path / "into", copies)


@pytest.mark.parametrize(
    "content, message",
    [(b"a mesh", None), (b"another", "gives another file"), (None, "cannot be downloaded")],
)
def test_a_download_is_kept_only_if_it_is_what_was_pinned(content, message, tmp_path, monkeypatch):
    if content is not None:
        (tmp_path / "commit").mkdir()
        (tmp_path / "commit" / "ball.obj").write_bytes(content)
    monkeypatch.setattr(pins, "_SITE", tmp_path.as_uri() + "/")
    file = dataclasses.replace(pin(), folder="commit")
    if message is None:
        assert collect([file], tmp_path / "into")[0].read_bytes() == b"a mesh"
        return
    with pytest.raises(UserError, match=message):
        collect([file], tmp_path / "into")
    assert not (tmp_path / "into" / "ball.obj").exists()


def test_objects_that_are_not_there_are_refused_in_one_line(copies, tmp_path, capsys):
    assert fetch_objects(["--into", str(tmp_path), "unicorn"]) == 2
    assert "no object unicorn; there are: teapot" in capsys.readouterr().err
    assert fetch_objects(["--into", str(tmp_path), "--from", str(copies), "teapot"]) == 2
    assert "teapot.obj is not among the copies" in capsys.readouterr().err


def test_another_file_of_an_objects_name_is_not_run(tmp_path):
    assert THINGS["teapot"].find_file(tmp_path, tmp_path) is None
    (tmp_path / "teapot.obj").write_bytes(b"v 0 0 0")
    with pytest.raises(UserError, match="another file than the sentences are about"):
        THINGS["teapot"].find_file(tmp_path, tmp_path)


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
    names = {name for group in SETS for name in name_cases(group)}
    assert read_remarks().keys() <= names


def test_remarks_that_are_still_to_be_written_are_listed_with_their_videos(tmp_path):
    rows = [{"case": f"sixty-0{n}-duck", "video": video} for n, video in ((1, "aa"), (2, "bb"), (3, None))]
    seen = {"sixty-01-duck": Remark(video="aa", viewer="yes", would_show="no", remark="It rocks.")}
    unseen = list_unseen(rows, seen)
    assert [remark["video"] for remark in unseen.values()] == ["bb", None]
    filled = {
        name: remark | {"viewer": "no", "would_show": "no", "remark": "x"} for name, remark in unseen.items()
    }
    (tmp_path / "seen.json").write_text(json.dumps(filled))
    assert list_unseen(rows, seen | read_remarks(tmp_path / "seen.json")) == {}
    (tmp_path / "seen.json").write_text(json.dumps(unseen))
    with pytest.raises(ValidationError):  # what is not filled in is no remark
        read_remarks(tmp_path / "seen.json")


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


def test_stills_are_many_frames_of_each_video_there_is(videos, tmp_path):
    files = write_stills(tmp_path / "look", videos, tmp_path)
    assert [file.name for file in files] == ["01-robot.png", "02-robot.png"]
    picture, height = imageio.imread(files[0]), round(400 * 72 / 128)
    assert picture.shape == (4 * (26 + height), 4 * 400, 3) and STILLS == 16
    greys = [
        picture[line * (26 + height) + 26 + height // 2, place * 400 + 200].mean() / 4
        for line in range(4)
        for place in range(4)
    ]
    np.testing.assert_allclose(greys, np.linspace(0, 24, 16).round(), atol=1)


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


def row(number, **changes):
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
        "frames": 50,
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
    refused = {key: row(4)[key] for key in ("run", "job", "case", "object", "sentence", "preset", "options")}
    rows = [
        row(1),
        row(2, failed_checks=[], unsure=["which way"]),
        row(3, verdict="SUCCESS", true_failed_checks=["far? expected a, observed b"]),
        {**refused, "video": None, "verdict": "REFUSED", "message": "no motion in 'be'"},
    ]
    return {"sentences": {"runs": [run | {"left_out": ["cow"]}], "complete": True, "rows": rows}}


def test_the_page_has_the_revision_and_whole_tables(result):
    text = document(result)
    assert "| sentences | 4 | 1.0 | A; 0.1; abc |" in text and "A: m." in text and "no file: cow." in text
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


def pair(number, thing, viewer, verdict, would_show, **changes):
    case = name_case(number, SETS["sixty"][number - 1], "sixty")
    assert case.endswith(thing)
    remark = viewer and Remark(
        video=f"digest {number}", viewer=viewer, would_show=would_show, remark="It moves."
    )
    made = row(number, case=case, object=thing, verdict=verdict, seconds=10.0 * number, iterations=1)
    return made | changes, remark


def test_totals_count_what_viewers_say_and_what_verdicts_do():
    pairs = [
        pair(1, "teapot", "yes", "SUCCESS", "yes"),
        pair(2, "teapot", "yes", "FAIL", "no", iterations=3),  # about a part
        pair(3, "teapot", "no", "SUCCESS", "no"),  # with a material
        pair(4, "teapot", "no", "FAIL", "no", iterations=2),  # about a part
        pair(5, "armadillo", "partly", "FAIL", "no"),
        pair(6, "armadillo", None, "FAIL", None),
    ]
    remarks = {made["case"]: remark for made, remark in pairs if remark}
    result = {"sixty": {"runs": [], "complete": False, "rows": [made for made, _ in pairs]}}
    text = markdown.write_tables(result, remarks)["totals"]
    heads, _, wanted, counted = (
        [cell.strip() for cell in line.split("|")[1:-1]] for line in text.strip().splitlines()
    )
    assert list(zip(heads, wanted, counted)) == [
        ("set", "wanted", "`sixty`"),
        ("pairs", "", "6"),
        ("looked at", "", "5"),
        ("shows it", "at least 75 %", "40 % (2 of 5)"),
        ("partly", "", "20 % (1 of 5)"),
        ("would show", "at least 50 %", "20 % (1 of 5)"),
        ("shows it, of parts", "at least 60 %", "50 % (1 of 2)"),
        ("shows it, of materials", "", "0 % (0 of 1)"),
        ("shows it, of sequences", "", ""),
        ("false SUCCESS, of clips that do not show it", "at most 3 %", "50 % (1 of 2)"),
        ("false FAIL, of clips that show it", "at most 10 %", "50 % (1 of 2)"),
        ("shows it, of runs that went past round 1", "", "50 % (1 of 2)"),
        ("seconds, median", "", "35"),
    ]


def test_totals_of_many_sets_begin_with_the_newest_and_count_those_together():
    made, remark = pair(1, "teapot", "yes", "SUCCESS", "yes")
    missed = made | {"case": "sixty-02-teapot"}
    remarks = {made["case"]: remark, missed["case"]: remark.model_copy(update={"viewer": "no"})}
    names = ("sixty", "twenty", "again", "third", "fourth")
    result = {name: {"runs": [], "complete": False, "rows": [made]} for name in names}
    result["sixty"]["rows"] = [missed]
    lines = markdown.write_tables(result, remarks)["totals"].strip().splitlines()[3:]
    assert [line.split(" | ")[0] for line in lines] == [
        "| newest 4 together",
        *(f"| `{name}`" for name in reversed(names)),
    ]
    assert "100 % (4 of 4)" in lines[0] and "0 % (0 of 1)" in lines[-1]


def test_pairs_that_were_held_back_have_a_table_and_sheets_of_their_own():
    first, remark = pair(1, "teapot", "yes", "SUCCESS", "no")
    refused, _ = pair(2, "teapot", None, "REFUSED", None, video=None, message="Which part?")
    run = dict(command="c", machine="m", load_average=[0.1], git_revision="abc", quick=False, seconds=1.0)
    section = {"runs": [run | {"left_out": []}], "complete": False, "rows": [first, refused]}
    tables = markdown.write_tables({"sixty": section}, {first["case"]: remark})
    sheet = "first-results-sixty-1.jpg"
    line = "| 01 | teapot | spin it | yes | no | It moves. | SUCCESS (0.50) | 1 | 10 |"
    assert f"{line} [sheet](images/{sheet}) |" in tables["sixty"]
    assert f"| 02 | teapot | spin it | {UNSEEN} |  | refused: Which part? | REFUSED |" in tables["sixty"]
    assert tables["sixty sheets"] == f"![Frames of the videos](images/{sheet})"
    assert "sentences" not in tables and "twenty" not in tables
