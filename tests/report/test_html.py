from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
from html.parser import HTMLParser

import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.core.text import split_reason
from physagent_jax.forces.schema import Action
from physagent_jax.perception.schema import MotionReport, Uncertainty
from physagent_jax.report.directions import make_direction_table
from physagent_jax.report.force_cards import Setting, find_acceleration
from physagent_jax.report.html import write_report
from physagent_jax.scene.config import CameraConfig
from physagent_jax.simulation.record import SimulationRecord
from tests.report.fake_run import FRAMES, PROMPT, build_run, store

VOID = {"br", "img", "link", "meta", "wbr"}
HOSTILE = 'A <script>alert("x")</script> strong <b>wind</b> & "rain" bends the plant to the left\' </title>'


class Page(HTMLParser):
    """Parses a page, checks that every element is closed in order, and collects what tests ask for."""

    def __init__(self, text: str):
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), f"attribute given twice in <{tag}>"
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).replace("\u202f", "").split())

    def all(self, tag: str, class_: str = "") -> list[dict[str, str | None]]:
        wanted = set(class_.split())
        return [
            a for name, a in self.elements if name == tag and wanted <= set((a.get("class") or "").split())
        ]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return build_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def page(run):
    return Page(write_report(run).read_text(encoding="utf-8"))


@pytest.fixture
def copy(run, tmp_path):
    """A run folder that a test may damage."""
    return shutil.copytree(run, tmp_path / "copy")


def render(folder) -> Page:
    return Page(write_report(folder).read_text(encoding="utf-8"))


def test_says_what_was_asked_and_how_it_ended(page):
    assert f"\u201c{PROMPT}\u201d" in page.text
    assert page.all("span", "badge success") and len(page.all("span", "badge fail")) == 2
    for part in ("What happened", "From words to forces", "Rounds", "Measurements", "Scene", "Cost"):
        assert part in page.text
    assert "swings back and forth twice" in page.text
    assert "redone with half the time step" in page.text


def test_is_one_file_that_loads_nothing(run, page):
    for tag, attributes in page.elements:
        for name in ("src", "poster", "data", "xlink:href", "srcset"):
            assert (attributes.get(name) or "data:").startswith("data:"), (tag, name)
        if tag in ("a", "link", "use"):
            assert (attributes.get("href") or "#").startswith("#"), attributes
    text = re.sub(r"data:[a-z0-9/]+;base64,[\w+/=]+", "", (run / "report.html").read_text(encoding="utf-8"))
    assert not re.search(r"https?:|@import|url\(", text)
    assert not page.all("link") and not page.all("iframe")


def test_only_the_own_script_may_run(run, page):
    text = (run / "report.html").read_text(encoding="utf-8")
    script = re.search(r"<script>(.*?)</script>", text, re.S)[1]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = next(a["content"] for a in page.all("meta") if a.get("http-equiv") == "Content-Security-Policy")
    assert f"script-src 'sha256-{digest}'" in policy and "default-src 'none'" in policy
    assert not [name for _, attributes in page.elements for name in attributes if name.startswith("on")]


def test_embeds_the_videos_once_each(run, page):
    videos = page.all("video")
    assert len(videos) == 4  # the best at the top, and one per round
    embedded = [v["src"] for v in videos if v.get("src")]
    assert len(embedded) == len(set(embedded)) == 4
    names = ["video.mp4", *(f"iterations/{index}/perception.mp4" for index in range(3))]
    assert [base64.b64decode(each.split(",")[1]) for each in embedded] == [
        (run / name).read_bytes() for name in names
    ]
    for video in videos:
        assert {"controls", "loop", "autoplay", "muted", "playsinline"} <= set(video)
    assert len(page.all("div", "filmstrip")) == 1


def test_without_a_video_for_people_the_plain_one_is_shown_and_embedded_once(copy):
    (copy / "video.mp4").unlink()
    page = render(copy)
    assert "Missing from the run folder" not in page.text
    videos = page.all("video")
    embedded = [v["src"] for v in videos if v.get("src")]
    assert len(embedded) == len(set(embedded)) == 3
    assert base64.b64decode(embedded[0].split(",")[1]) == (copy / "perception.mp4").read_bytes()
    borrowed = next(v for v in videos if not v.get("src"))
    assert borrowed["data-same-as"] == videos[0]["id"]


def test_words_lead_to_values(page):
    ids = {attributes["id"] for _, attributes in page.elements if attributes.get("id")}
    links = [a["href"][1:] for a in page.all("a") if a["href"]]
    assert set(links) <= ids
    marked = page.all("a", "topic")
    assert len(marked) == 5 and {"evidence-0", "evidence-4"} <= {a["href"][1:] for a in marked}
    assert len(page.all("mark", "topic unknown")) == 1
    assert "compiled-actions-0" in links
    assert "The wind is even over the upper part of the plant." in page.text


def test_ids_are_unique(page):
    ids = [attributes["id"] for _, attributes in page.elements if attributes.get("id")]
    assert len(ids) == len(set(ids))


def test_force_cards_speak_the_viewers_words(page):
    assert "pushes left" in page.text
    assert "turns clockwise seen from above" in page.text  # +z with a negative magnitude
    assert "is knocked once left and slightly up" in page.text
    assert "the upper 60 % along z" in page.text
    assert "was 0.60" in page.text and "was 0.90" in page.text
    assert "2.6 m/s\u00b2 (1 means 2)" in page.text
    assert "frames 0\u201325 (0.00\u20131.00 s)" in page.text


def test_every_check_and_change_is_shown(run, page):
    for index in range(3):
        judgement = json.loads((run / f"iterations/{index}/judgement.json").read_text())
        for check in judgement["checks"]:
            for key in ("question", "expected", "observed", "remedy"):
                assert check[key] in page.text
            if check["margin"] is not None:
                assert f"{check['margin']:.2f}".replace("-", "\u2212") in page.text.replace("-", "\u2212")
        assert "83 %" in page.text and "100 %" in page.text
        for sentence in filter(None, split_reason(judgement["suggestion"])):
            assert sentence in page.text
        assert f"score {judgement['score']:.2f}" in page.text
    for kind, many in (("pass", 4), ("failed", 2), ("open", 3)):
        assert len(page.all("span", f"result {kind}")) == many
    assert "the magnitude of the translation from 0.9 to 1.3: the bend was too small." in page.text
    assert "anchored objects keep impulse" in page.text


def test_actions_are_named_by_skill_and_not_by_their_place_in_the_file(page):
    assert "actions[" not in page.text and "constraints[" not in page.text


def test_a_force_card_tells_the_acceleration_and_gravity_beside_it(page):
    assert "2.6 m/s\u00b2 (1 means 2) 0.27 times gravity" in page.text


def test_the_acceleration_of_a_blow_is_its_speed_over_its_time():
    setting = Setting(make_direction_table(CameraConfig()), 50, 0.04)
    blow = Action(action_type="impulse", vector=(1, 0, 0), magnitude=1.0, active_time=(5, 10))
    assert find_acceleration(blow, 3.0, setting) == pytest.approx(15.0)  # 3 m/s in 0.2 s
    assert find_acceleration(blow.model_copy(update={"active_time": None}), 3.0, setting) is None
    turn = Action(action_type="torque", vector=(0, 0, 1), magnitude=1.0, active_time=(5, 10))
    assert find_acceleration(turn, 3.0, setting) is None


def test_a_failure_says_why_before_anything_else_in_two_plain_sentences(copy):
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest |= {"verdict": "FAIL", "stopped": "no improvement"}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    judgement = json.loads((copy / "iterations/2/judgement.json").read_text())
    why = "\u2018bends\u2019 is seen too little."
    judgement |= {"verdict": "FAIL", "suggestion": f"{why} The margin of actions[0] is 0.3."}
    (copy / "iterations/2/judgement.json").write_text(json.dumps(judgement))
    page = render(copy)
    line = f"FAIL {why} No further round was made: the last rounds brought no improvement."
    head = page.text[: page.text.index("At a glance")]
    assert line in " ".join(head.split()) and "margin" not in head
    assert "The margin of the translation is 0.3." in page.text


def test_figures_of_the_planner_and_of_perception_are_folded(run):
    text = (run / "report.html").read_text(encoding="utf-8")
    folds = re.findall(r"<details><summary>(.*?)</summary>(.*?)</details>", text, re.DOTALL)
    assert sum(title == "What the planner checked" and "margin" in body for title, body in folds) == 3
    assert sum(title == "The motion in figures" and "swings back" in body for title, body in folds) == 1


def test_the_agents_exchanges_are_shown(page):
    for index in range(3):
        assert f"Round {index + 1}: too little < enough." in page.text
    assert page.text.count("How the planner came to it") == 3
    assert "How the semantic agent came to it" in page.text and "`magnitude` is missing" in page.text
    assert "user, with 2 pictures" in page.text and "some-model" in page.text
    assert "How the executor came to it" not in page.text  # rules, which left an empty trace


def test_a_verdict_without_score_and_checks_is_shown(copy):
    for index in range(3):
        plain = {"verdict": "SUCCESS" if index == 2 else "FAIL"}
        (copy / f"iterations/{index}/judgement.json").write_text(json.dumps(plain))
    page = render(copy)
    assert page.text.count("The planner gave its verdict without single checks.") == 3
    assert "score" not in page.text.lower()


def test_numbers_equal_those_in_the_files(run, page):
    record = SimulationRecord.model_validate_json((run / "iterations/2/simulation.json").read_text())
    assert f"particles {record.particle_count}" in page.text
    assert f"Gaussians {record.gaussian_count}" in page.text
    assert f"substeps {record.substeps} over 49 frame intervals" in page.text
    assert "stable bound at the start 640 \u00b5s" in page.text
    assert "250 \u00b5s to 500 \u00b5s" in page.text
    assert "velocity above the grid's limit" in page.text
    assert "Young\u2019s modulus 2 MPa" in page.text and "density 200 kg/m\u00b3" in page.text
    assert "64 \u00d7 48 \u00d7 72 nodes" in page.text
    assert "planner chat model 3 5210 884 7.1 s 7.5 s" in page.text
    assert "all 6 5210 884 7.1 s 7.52 s" in page.text
    assert "tokens 5210 in, 884 out, 7.1 s waited" in page.text
    assert "simulate 31.5 s 43 %" in page.text
    assert "Longest extent in frame 0 0.980 1.000 \u22120.020 m" in page.text
    assert "The truth is for your eyes only; no agent saw it." in page.text
    assert "seed 7" in page.text and "physagent simulate scene.json" in page.text


def test_plots_hold_every_frame(page):
    assert len(page.all("figure", "plot")) == 3 * 8
    assert len(page.all("path", "curve")) >= 3 * 20
    outputs = [a["data-values"].split(";") for a in page.all("output")]
    assert all(len(values) == FRAMES for values in outputs)
    seen = outputs[-1]
    assert seen[0] == "1.000"  # smallest det F of the rest pose
    assert page.all("g", "mark"), "redone frames are marked"


def test_hostile_text_stays_text(tmp_path, page):
    hostile = render(build_run(tmp_path, prompt=HOSTILE))
    assert f"\u201c{HOSTILE}\u201d" in hostile.text
    for name in ("script", "b", "title"):
        assert len(hostile.all(name)) == len(page.all(name))
    marked = hostile.all("a", "topic")
    assert len(marked) == 3, "the words are still found in the sentence"


@pytest.mark.parametrize(
    "name",
    [
        "manifest.json",
        "semantic.json",
        "scene.json",
        "iterations/2/scene.json",
        "iterations/2/force_field.json",
        "iterations/2/motion_report.json",
        "iterations/2/judgement.json",
        "iterations/1/rewrite.json",
        "iterations/2/simulation.json",
        "iterations/2/perception.mp4",
    ],
)
def test_a_missing_file_is_named_and_the_rest_is_shown(copy, name):
    (copy / name).unlink()
    page = render(copy)
    assert f"{name} is missing." in page.text
    assert "Round 3" in page.text and page.all("video")


def test_a_broken_file_is_named_with_its_field(copy):
    data = json.loads((copy / "iterations/1/judgement.json").read_text())
    data["score"] = 7
    (copy / "iterations/1/judgement.json").write_text(json.dumps(data))
    (copy / "iterations/0/perception.mp4").write_bytes(b"half a video")
    page = render(copy)
    assert "iterations/1/judgement.json cannot be used: field `score`:" in page.text
    assert "perception.mp4 cannot be played" in page.text


def test_a_run_that_has_just_begun(copy):
    shutil.rmtree(copy / "iterations")
    for name in ("video.mp4", "perception.mp4", "scene.json"):
        (copy / name).unlink()
    manifest = json.loads((copy / "manifest.json").read_text())
    manifest |= {"complete": False, "best_iteration": None, "verdict": None}
    (copy / "manifest.json").write_text(json.dumps(manifest))
    page = render(copy)
    assert "This run is not complete." in page.text
    assert "No round has been stored yet." in page.text and "video.mp4 is missing." in page.text
    assert "not judged" in page.text


def test_courtesies_are_not_reported_missing(copy):
    for overlay in copy.glob("iterations/*/overlay.png"):
        overlay.unlink()
    assert "Missing from the run folder" not in render(copy).text


def test_a_video_too_large_to_embed_is_linked(copy, monkeypatch):
    monkeypatch.setattr("physagent_jax.report.media.MAX_EMBEDDED_BYTES", 10)
    sources = [v["src"] for v in render(copy).all("video") if v.get("src")]
    assert sources == ["video.mp4", *(f"iterations/{index}/perception.mp4" for index in range(3))]


def test_rounds_are_counted_from_one_as_in_the_terminal(run):
    page = render(run)
    assert "Round 1" in page.text and "Round 3" in page.text and "the best is round 3" in page.text
    assert "Round 0" not in page.text and "teration" not in page.text.split("Scene as JSON")[0]


def test_stretch_is_compared_with_the_truth(copy):
    page = render(copy).text
    assert f"Stretch along x in frame {FRAMES - 1} 1.020" in page
    path = copy / "iterations/2/motion_report.json"
    report = MotionReport.model_validate_json(path.read_text())
    turned = report.windows[0].model_copy(update={"rotation_degrees": 40.0})
    store(path, report.model_copy(update={"windows": (turned, *report.windows[1:])}))
    assert render(copy).text.count("not comparable after a turn") == 3


def test_stated_half_widths_stand_beside_the_errors(copy):
    path = copy / "iterations/2/motion_report.json"
    report = MotionReport.model_validate_json(path.read_text())
    store(path, report.model_copy(update={"uncertainty": Uncertainty(displacement=0.031)}))
    text = render(copy).text
    assert "Half width stated by perception: displacement 0.031 body lengths" in text
    assert "stated by perception: rotation" not in text, "what is not known is not stated"


def test_rollouts_without_truth(copy):
    path = copy / "iterations/2/simulation.json"
    record = SimulationRecord.model_validate_json(path.read_text()).model_copy(update={"truth": None})
    store(path, record)
    page = render(copy)
    assert "The comparison needs both the motion report and the true motion." in page.text


def test_same_files_same_page(run):
    assert write_report(run).read_bytes() == write_report(run).read_bytes()


def test_folders_that_are_not_runs(tmp_path):
    for folder in (tmp_path, tmp_path / "absent"):
        with pytest.raises(UserError, match="is not a run folder"):
            write_report(folder)
