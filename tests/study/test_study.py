"""Studies from results to analysis: what participants may see, which votes count, and what comes out of them."""

import http.client
import json
import threading
import urllib.error
import urllib.request

import av
import numpy as np
import pytest

from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.study.analysis import analyse_study, write_summary
from physagent_jax.study.build import build_study
from physagent_jax.study.schema import PAGE, PLAN, QUESTIONS, Judged, collect_ballots, read_study
from physagent_jax.study.serve import make_server
from physagent_jax.study.sources import copy_clip, read_method
from tests.report.fake_run import build_run
from tests.study.studies import make_study, vote, write_clip, write_results


def test_the_page_tells_no_method_and_loads_nothing(tmp_path):
    study, folder, balance, notes = make_study(
        tmp_path, methods=("xqa", "xqb", "xqc"), items=("f/xqi", "f/xqj", "c")
    )
    page = (folder / PAGE).read_text()
    assert not any(word in page for word in ("xqa", "xqb", "xqc", "xqi", "results", "{{"))
    assert "://" not in page and " src=" not in page and " href=" not in page
    assert r"move \u003c" in page and "move <" not in page  # a sentence is data, not markup
    assert [item.family for item in study.items] == ["", "f", "f"] and notes == []
    assert balance.shown == (18, 18) and read_study(folder) == study
    assert len({sheet.code for sheet in study.sheets}) == 6


def test_titles_of_videos_do_not_reach_participants(tmp_path):
    path = tmp_path / "a.mp4"
    write_clip(tmp_path / "plain.mp4")
    with av.open(str(tmp_path / "plain.mp4")) as source, av.open(str(path), "w") as file:
        file.metadata["title"] = "made by theirs"
        stream = file.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                file.mux(packet)
    assert b"made by theirs" in path.read_bytes()
    content, look = copy_clip(path)
    assert b"made by theirs" not in content and look == (64, 48, 0.25)
    (tmp_path / "copy.mp4").write_bytes(content)
    with av.open(str(tmp_path / "copy.mp4")) as file:
        assert sum(1 for _ in file.decode(video=0)) == 6


def test_links_and_dots_in_names_are_followed(tmp_path):
    """Results often lie elsewhere; a link back up is not followed for ever."""
    for method in "abc":
        write_clip(tmp_path / "else" / method / "v1.5.mp4")
        (tmp_path / method).mkdir()
        (tmp_path / method / "deep").symlink_to(tmp_path / "else" / method)
        (tmp_path / method / "round").symlink_to(tmp_path / method)
        assert list(read_method(str(tmp_path / method))[1]) == ["deep/v1.5"]


def test_items_without_all_methods_are_used_and_told(tmp_path):
    methods = ("a", "b", "c", "d")
    lacking = {("d", "drop/a"), ("c", "sway/c"), ("d", "sway/c")}
    study, _, _, notes = make_study(tmp_path, methods=methods, lacking=lacking)
    assert [item.name for item in study.items] == ["drop/a", "drop/b"]
    assert notes[0] == "drop/a lacks d."
    assert notes[1] == "sway/c is left out: 2 methods have a clip of it, and a set has 3."


def test_finished_runs_are_clips_with_our_judge(tmp_path):
    """A method that has no staged video makes all be shown plainly, so that nobody is told by the stage."""
    for method in ("full", "ablated", "third"):
        build_run(tmp_path / method / "plant")
    (tmp_path / "third" / "plant" / "video.mp4").unlink()
    given = [f"x={tmp_path / 'full'}", str(tmp_path / "ablated"), str(tmp_path / "third")]
    study, _, notes = build_study(
        given, tmp_path / "s", participants=1, sets=None, alternatives=3, open_=True, seed=0
    )
    assert study.methods == ("x", "ablated", "third")
    (item,) = study.items
    assert item.sentence.startswith("A strong wind") and all(
        "perception" in clip.source for clip in item.clips
    )
    assert item.clips[0].judged == Judged(by="planner", success=True, score=0.93)
    assert notes == ["plant: not all have video.mp4, so all are shown by perception.mp4."]
    path = tmp_path / "ablated" / "plant" / "manifest.json"
    path.write_text(path.read_text().replace('"complete": true', '"complete": false'))
    with pytest.raises(UserError, match="plant is left out: 2 methods have a clip"):
        build_study(given, tmp_path / "t", participants=1, sets=None, alternatives=3, open_=True, seed=0)


def test_methods_of_the_head_to_head_are_judged_by_their_task(tmp_path):
    """Of two successes the smaller error is the favourite; a planner's score is not compared with it."""
    for method, error in (("a", 0.5), ("b", 0.25), ("c", 3.0)):
        folder = build_run(tmp_path / method / "plant")
        for path in folder.glob("iterations/*/judgement.json"):
            path.unlink()
        (folder / "fit.json").write_text(json.dumps({"judgement": {"success": error < 1, "error": error}}))
    given = [str(tmp_path / method) for method in "abc"]
    study, *_ = build_study(
        given, tmp_path / "s", participants=1, sets=None, alternatives=3, open_=False, seed=0
    )
    assert study.items[0].clips[0].judged == Judged(by="task", success=True, score=-0.5)
    judge = analyse_study(study, [vote(study, 0, lambda shown, question: "b")])["questions"]["overall"][
        "judge"
    ]
    assert judge["sets"] == 1 and judge["share"] == 1
    build_run(tmp_path / "d" / "plant")
    mixed, *_ = build_study(
        [*given[:2], str(tmp_path / "d")],
        tmp_path / "t",
        participants=1,
        sets=None,
        alternatives=3,
        open_=False,
        seed=0,
    )
    judge = analyse_study(mixed, [vote(mixed, 0, lambda shown, question: "b")])["questions"]["overall"][
        "judge"
    ]
    assert judge == {"sets": 0, "without_favourite": 1, "chance": 1 / 3}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda b: b | {"study": "0" * 12}, "another study"),
        (lambda b: b | {"code": "000-" + "0" * 16}, "a code that nobody was given"),
        (lambda b: b | {"code": "999-" + "0" * 16}, "a code that nobody was given"),
        (lambda b: b | {"code": "../../etc/passwd"}, "not a ballot"),
        (lambda b: b | {"answers": []}, "answers 0 sets"),
        (lambda b: b | {"answers": b["answers"] * 2}, "answers 6 sets"),
        (lambda b: b | {"name": "Ann"}, "not a ballot"),
        (lambda b: b | {"answers": [{"choices": {}, "seconds": 1}]}, "leaves questions of set 1 open"),
        (lambda b: b | {"answers": b["answers"][::-1]}, "that set 1 did not show"),
        (lambda b: b | {"answers": [b["answers"][0] | {"seconds": -1}]}, "not a ballot"),
        (lambda b: [b], "not a ballot"),
    ],
)
def test_bad_votes_are_told_in_one_line_and_left_where_they_are(change, told, tmp_path, study_and_folder):
    study, _ = study_and_folder
    good = json.loads(vote(study, 0, lambda shown, question: shown[0]).model_dump_json())
    bad, fine = tmp_path / "bad.json", tmp_path / "fine.json"
    bad.write_text(text := json.dumps(change(good)))
    fine.write_text(json.dumps(good))
    ballots, faults = collect_ballots([bad, fine], study)
    assert len(ballots) == 1 and len(faults) == 1
    assert told in faults[0] and "bad.json" in faults[0] and "\n" not in faults[0]
    assert bad.read_text() == text


@pytest.fixture(scope="module")
def study_and_folder(tmp_path_factory):
    study, folder, *_ = make_study(tmp_path_factory.mktemp("study"))
    return study, folder


def test_nobody_votes_twice(tmp_path, study_and_folder):
    """The same votes again are the same; more votes go on; other votes are refused."""
    study, _ = study_and_folder
    part, whole, other = (
        vote(study, 0, lambda shown, question: sorted(shown)[0], 2),
        vote(study, 0, lambda shown, question: sorted(shown)[0]),
        vote(study, 0, lambda shown, question: sorted(shown)[1]),
    )
    files = []
    for index, ballot in enumerate((part, whole, part, whole, other)):
        files.append(tmp_path / f"{index}.json")
        files[-1].write_text(ballot.model_dump_json())
    ballots, faults = collect_ballots(files, study)
    assert ballots == [whole]
    assert len(faults) == 1 and faults[0].startswith("4.json votes a second time")


def post(port, content):
    request = urllib.request.Request(f"http://127.0.0.1:{port}/votes", data=content, method="POST")
    try:
        with urllib.request.urlopen(request, timeout=10) as reply:
            return reply.status, reply.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def get(port, path):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=10) as reply:
            return reply.status, reply.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


@pytest.fixture
def served():
    servers = []

    def start(folder):
        servers.append(server := make_server(folder, "127.0.0.1", 0))
        threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        return server.server_address[1]

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def test_the_server_stores_votes_once_and_shows_nothing_else(tmp_path, served):
    study, folder, *_ = make_study(tmp_path)
    port = served(folder)
    assert get(port, "/")[1] == (folder / PAGE).read_bytes() and get(port, "/session") == (200, b"{}")
    for path in ("/study.json", "/../study.json", "/codes.txt", "/votes", "/%2e%2e/study.json"):
        assert get(port, path)[0] == 404
    first = [vote(study, 1, lambda shown, question: min(shown), count) for count in (1, 2, 3)]
    for ballot in (first[1], first[0], first[2], first[2]):  # late and repeated messages do no harm
        assert post(port, ballot.model_dump_json().encode())[0] == 200
    other = vote(study, 1, lambda shown, question: max(shown))
    status, told = post(port, other.model_dump_json().encode())
    assert status == 400 and "has voted already" in told and "\n" not in told
    assert post(port, b"{")[0] == 400
    for length in ("1048577", "-1", "x"):
        link = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        link.request("POST", "/votes", headers={"Content-Length": length})
        assert link.getresponse().status == 400
        link.close()
    (stored,) = (folder / "votes").iterdir()
    assert collect_ballots([stored], study) == ([first[2]], [])


def test_an_open_study_deals_the_rarest_sheet(tmp_path, served):
    study, folder, *_ = make_study(tmp_path, participants=3, open_=True)
    port = served(folder)
    assert sorted(json.loads(get(port, "/session")[1])["sheet"] for _ in range(6)) == [0, 0, 1, 1, 2, 2]
    assert not (folder / "codes.txt").exists()
    assert post(port, vote(study, 2, lambda shown, question: shown[0]).model_dump_json().encode())[0] == 200


def test_raters_of_known_taste_are_found_again(tmp_path):
    """Simulated: chances 0.6, 0.3, 0.1 by method; the judge of this code always favours `ours`."""
    study, *_ = make_study(tmp_path, participants=200)
    chances, rng = {"ours": 0.6, "theirs": 0.3, "others": 0.1}, np.random.default_rng(1)

    def judge(clip):
        return clip.model_copy(
            update={"judged": Judged(by="planner", success=True, score=float(clip.method == "ours"))}
        )

    def taste(shown, question):
        if question == "overall":
            return "ours"
        return str(rng.choice(shown, p=[chances[name] for name in shown]))

    items = [item.model_copy(update={"clips": tuple(map(judge, item.clips))}) for item in study.items]
    study = study.model_copy(update={"items": tuple(items)})
    result = analyse_study(study, [vote(study, sheet, taste) for sheet in range(200)])
    told = result["questions"]["alignment"]
    for name, chance in chances.items():
        rate, strength = told["upr"]["all"][name], told["strengths"]["methods"][name]
        assert rate["low"] < chance < rate["high"] and rate["shown"] == 600
        assert strength["low"] < np.log(chance / (0.6 * 0.3 * 0.1) ** (1 / 3)) < strength["high"]
    assert told["upr"]["drop"]["ours"]["shown"] == 400 and told["upr"]["sway"]["ours"]["shown"] == 200
    assert told["agreement"]["same"] == pytest.approx(0.46, abs=0.03)  # 0.36 + 0.09 + 0.01
    assert abs(told["agreement"]["fleiss_kappa"]) < 0.02 > abs(told["agreement"]["krippendorff_alpha"])
    assert told["judge"]["share"] == told["upr"]["all"]["ours"]["share"]
    assert told["places"]["p"] > 0.001
    alike = result["questions"]["overall"]
    assert alike["agreement"]["same"] == 1 and alike["strengths"]["methods"] is None
    assert "never chosen: theirs, others" in alike["strengths"]["reason"]
    assert "UPR 100.0%" in write_summary(result)


def test_one_who_always_takes_the_left_is_seen_in_the_places(tmp_path):
    study, *_ = make_study(tmp_path)
    result = analyse_study(
        study, [vote(study, sheet, lambda shown, question: shown[0]) for sheet in range(6)]
    )
    for question in QUESTIONS:
        assert result["questions"][question]["places"]["chosen"] == [18, 0, 0]
        assert result["questions"][question]["places"]["p"] < 1e-6
        assert {rate["share"] for rate in result["questions"][question]["upr"]["all"].values()} == {1 / 3}


def test_the_commands(tmp_path, capsys):
    results, out = write_results(tmp_path / "results"), str(tmp_path / "s")
    assert main(["study", "build", *results, "--out", out, "--participants", "2", "--sets", "2"]) == 0
    assert "3 items, 3 methods, 2 sheets of 2 sets" in capsys.readouterr().out
    assert main(["study", "analyse", out]) == 2
    assert "there are no votes" in capsys.readouterr().err
    study = read_study(tmp_path / "s")
    sent = tmp_path / "sent.json"
    sent.write_text(vote(study, 0, lambda shown, question: "theirs").model_dump_json())
    (tmp_path / "s/votes/broken.json").write_text("{")
    assert main(["study", "analyse", out, str(sent), "--json", str(tmp_path / "r.json")]) == 0
    told = capsys.readouterr()
    assert "1 participants (1 saw all their sets)" in told.out and "not counted: broken.json" in told.err
    result = json.loads((tmp_path / "r.json").read_text())
    assert (
        result["questions"]["fidelity"]["upr"]["all"]["theirs"]["share"] == 1
        and len(result["not_counted"]) == 1
    )


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "fewer methods than a set has clips"),
        (["a", "b", "c"], "a method is a folder of results"),
        (["R/ours", "R/theirs", "R/ours"], "two methods have the same name"),
        (["R/ours", "R/theirs", "empty"], "holds no result"),
        (["R/ours", "R/theirs", "R/others", "--sets", "4"], "more than there are items"),
        (["R/ours", "R/theirs", "R/others", "--participants", "0"], "between 1 and 1000"),
        (["R/ours", "R/theirs", "R/others", "--out", "made"], "holds a study"),
        (["R/ours", "R/theirs", "odd"], "have different sentences for drop/a"),
        (["R/ours", "R/theirs", "apart"], "no item has clips of 3 methods"),
        (["R/ours", "R/theirs", "torn"], "cannot read the video"),
    ],
)
def test_results_that_make_no_study(arguments, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_results(tmp_path / "R")
    write_clip(tmp_path / "odd/drop/a.mp4", sentence="something else")
    write_clip(tmp_path / "apart/other.mp4")
    write_clip(tmp_path / "torn/drop/a.mp4", sentence="move <the a> & hold")
    (tmp_path / "torn/drop/a.mp4").write_bytes(b"torn")
    (tmp_path / "empty").mkdir()
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / PLAN).write_text("{}")
    assert main(["study", "build", *arguments, *([] if "--out" in arguments else ["--out", "s"])]) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
    assert not (tmp_path / "s").exists()


def test_a_port_that_is_taken_is_told(study_and_folder):
    _, folder = study_and_folder
    with make_server(folder, "127.0.0.1", 0) as server, pytest.raises(UserError, match="cannot serve at"):
        make_server(folder, "127.0.0.1", server.server_address[1])
    with pytest.raises(UserError, match="holds no study.json"):
        make_server(folder / "votes", "127.0.0.1", 0)
