"""The page in a headless browser: by keyboard, on a phone, without a network, interrupted, refused."""

import json
import threading
import time

import pytest

from physagent_jax.study.schema import PAGE, collect_ballots, read_ballot
from physagent_jax.study.serve import make_server
from tests.study.browser import Browser, find_browser
from tests.study.studies import make_study, vote

pytestmark = pytest.mark.skipif(find_browser() is None, reason="no Chromium or Chrome is on the path")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """One for all tests: its start takes a second."""
    browser = Browser(tmp_path_factory.mktemp("browser"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def study_and_folder(tmp_path_factory):
    study, folder, *_ = make_study(tmp_path_factory.mktemp("study"))
    return study, folder


def begin(browser, address, code=""):
    browser.messages.clear()
    browser.open(f"{address}#{code}")
    browser.wait("$('begin').onclick !== null")
    browser.run("$('begin').click()")


def answer(browser, keys):
    """Answer a set by keys once it has been watched, and go on."""
    number = browser.run("ballot.answers.length")
    for key in keys:
        browser.press(key)
    browser.wait("!$('next').disabled")
    browser.press("Enter")
    browser.wait(f"ballot.answers.length == {number + 1}")


def find_chosen(study, ballot):
    """Places of the chosen clips, counted from 1, as typed."""
    sets = study.sheets[ballot.sheet].sets
    return [
        "".join(str(shown.index(id_) + 1) for id_ in each.choices.values())
        for each, shown in zip(ballot.answers, sets)
    ]


def test_a_file_by_keyboard_leaves_a_file_of_votes(browser, study_and_folder, tmp_path):
    study, folder = study_and_folder
    browser.call("Browser.setDownloadBehavior", session=None, behavior="allow", downloadPath=str(tmp_path))
    browser.resize(1280, 800)
    begin(browser, (folder / PAGE).as_uri(), study.sheets[2].code)
    assert browser.run("$('sentence').textContent") in {f"“{item.sentence}”" for item in study.items}
    browser.press("3")
    assert browser.run("$('next').disabled")
    answer(browser, "12")
    browser.run("$('stop').click()")  # what there is can be saved before the end
    assert browser.run("!$('save').hidden && ballot.answers.length == 1")
    begin(browser, (folder / PAGE).as_uri(), study.sheets[2].code)
    answer(browser, "111")
    browser.open(
        (folder / PAGE).as_uri() + "#" + study.sheets[2].code
    )  # closed by mistake: it goes on at set 3
    browser.wait("$('begin').onclick !== null")
    browser.run("$('begin').click()")
    assert browser.run("$('count').textContent") == "Set 3 of 3"
    answer(browser, "223")
    browser.wait("!$('end').hidden && !$('save').hidden")
    browser.run("$('save').click()")
    path = tmp_path / f"votes-{study.sheets[2].code}.json"
    end = time.monotonic() + 20
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.05)
    ballot = read_ballot(path.read_bytes(), study, "it")
    assert find_chosen(study, ballot) == ["312", "111", "223"]
    assert all(0.2 < each.seconds < 60 for each in ballot.answers)
    begin(browser, (folder / PAGE).as_uri(), study.sheets[2].code)  # who has voted is not asked again
    assert browser.run("!$('end').hidden && $('set').hidden")
    assert browser.messages == []


def test_answers_need_all_videos_seen_and_all_questions(browser, study_and_folder):
    study, folder = study_and_folder
    begin(browser, (folder / PAGE).as_uri(), study.sheets[0].code)
    browser.wait("seen")
    assert browser.run("$('next').disabled && $('hint').textContent") == "Questions left: 3"
    browser.press("Enter")
    assert browser.run("ballot.answers.length") == 0
    browser.press(" ")
    stopped = "videos().every(video => video.paused || video.ended)"
    assert browser.run("$('play').textContent") == "Play"
    browser.wait(stopped)
    time.sleep(0.4)  # longer than a clip: they do not begin again by themselves
    assert browser.run(stopped)
    browser.press(" ")
    browser.wait(f"!({stopped}) && $('play').textContent == 'Pause'")
    browser.run("document.querySelector('input[name=overall]').focus()")
    browser.press("2")  # the question that has the focus, not the first that is open
    assert browser.run("[...new FormData($('set')).keys()].join()") == "overall"


def test_a_phone_shows_all_and_scrolls_one_way(browser, study_and_folder):
    study, folder = study_and_folder
    browser.resize(360, 640, phone=True)
    begin(browser, (folder / PAGE).as_uri(), study.sheets[1].code)
    assert browser.run("document.documentElement.scrollWidth") <= 360
    boxes = "[...document.querySelectorAll('figure')].map(each => each.getBoundingClientRect())"
    assert browser.run(f"{boxes}.every((box, i, all) => i == 0 || box.top >= all[i - 1].bottom)")
    assert browser.run(f"{boxes}.every(box => box.bottom <= 640)"), "all three fit on the screen together"
    spans = "[...document.querySelectorAll('label span'), ...document.querySelectorAll('button')]"
    assert browser.run(
        f"{spans}.filter(e => e.offsetParent).every(e => e.getBoundingClientRect().height >= 44)"
    )
    browser.resize(1280, 800)


@pytest.mark.parametrize("code", ["", "000-", "099-0123456789abcdef", "<b>"])
def test_a_code_that_there_is_not_is_told(code, browser, study_and_folder):
    _, folder = study_and_folder
    begin(browser, (folder / PAGE).as_uri(), code)
    assert "not a code" in browser.run("$('refused').textContent") and browser.run("$('set').hidden")


@pytest.fixture
def serve():
    servers = []

    def start(folder):
        servers.append(server := make_server(folder, "127.0.0.1", 0))
        threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        return f"http://127.0.0.1:{server.server_address[1]}/"

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


def test_a_server_gets_the_votes_set_by_set(browser, tmp_path, serve):
    study, folder, *_ = make_study(tmp_path)
    begin(browser, serve(folder), study.sheets[3].code)
    path = folder / "votes" / f"{study.sheets[3].code}.json"
    answer(browser, "123")
    end = time.monotonic() + 20
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert len(json.loads(path.read_text())["answers"]) == 1
    answer(browser, "321")
    answer(browser, "222")
    browser.wait("$('told').textContent.includes('are stored')")
    ballots, faults = collect_ballots([path], study)
    assert faults == [] and find_chosen(study, ballots[0]) == ["123", "321", "222"]
    assert browser.run("$('save').hidden") and browser.messages == []


def test_votes_that_a_server_refuses_stay_with_the_participant(browser, tmp_path, serve):
    study, folder, *_ = make_study(tmp_path, items=("a",))
    other = vote(study, 0, lambda shown, question: shown[0])
    (folder / "votes" / f"{other.code}.json").write_text(other.model_dump_json())
    begin(browser, serve(folder), study.sheets[0].code)
    answer(browser, "333")
    browser.wait("$('told').textContent.includes('could not be stored')")
    assert "has voted already" in browser.run("$('told').textContent")
    assert browser.run("!$('save').hidden && !$('again').hidden && ballot.answers.length == 1")


def test_an_open_study_needs_no_code(browser, tmp_path, serve):
    study, folder, *_ = make_study(tmp_path, items=("a",), open_=True)
    address = serve(folder)
    begin(browser, address)
    answer(browser, "123")
    browser.wait("$('told').textContent.includes('are stored')")
    begin(browser, address)  # the same browser has voted
    browser.wait("$('told').textContent.includes('are stored')")
    ballots, faults = collect_ballots((folder / "votes").iterdir(), study)
    assert faults == [] and [find_chosen(study, ballot) for ballot in ballots] == [["123"]]
