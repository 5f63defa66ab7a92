"""The harness of the head-to-head: what a mark says, what is verified, and the page."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from baselines.measuring import judge_marks
from baselines.protocol import Evaluation, FitResult
from baselines.tasks import load_tasks, load_witnesses
from benchmarks.headtohead import jobs, leaderboard, measuring
from benchmarks.headtohead.__main__ import TASKS, choose_entrants, find_guided, main
from benchmarks.headtohead.entrants import ABLATION, ITERATIONS, METHODS, list_distillers, rename
from benchmarks.headtohead.jobs import NOTHING, list_gradients, list_materials, list_similarities, verify
from benchmarks.headtohead.markdown import choose_ablation, condense, write_tables
from benchmarks.headtohead.measuring import measure
from benchmarks.headtohead.neighbourhood import STRONGER, TURNED, perturb
from physagent_jax.core.errors import MissingPackageError, UserError
from physagent_jax.forces.schema import Action, ActionType, BoxRegion, ForceField
from physagent_jax.metrics import statistics
from physagent_jax.metrics.task_judge import ClauseJudgement, TaskJudgement
from tests.metrics.make_tiny_clip import FOLDER


def push(magnitude):
    return ForceField(
        actions=(Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=magnitude),)
    )


class Spec:
    """As much of a task's definition as is looked at."""

    task_hash = "abc"


class World:
    """A task that M = 1 solves; everything beyond M = 1.5 cannot be simulated."""

    frame_dt, spec = 0.04, Spec()

    def __init__(self):
        self.simulated = 0

    def simulate(self, field):
        self.simulated += 1
        return np.full((2, 1, 3), field.actions[0].magnitude)

    def build(self, field):
        return SimpleNamespace(model=SimpleNamespace(forces=(), constraints=(), mass=np.ones(1)))

    def judge(self, x):
        error = abs(float(x[0, 0, 0]) - 1.0) / 0.1
        clause = ClauseJudgement("distance", 0.0, 0.0, 1.0, "lengths", 1.0 - error)
        return TaskJudgement(error <= 1, error, (clause,))


def fitted(*tried):
    made = tuple(Evaluation(push(m), spent, spent, objective) for m, spent, objective in tried)
    return FitResult("x", "t", 0, push(0.4), made, False, made[-1].spent if made else 0.0, 1.0)


def test_a_mark_is_judged_by_what_the_method_itself_held_for_best():
    """Not by the best that it ever tried; before anything is tried, by the task's start; each field once."""
    task = World()
    result = fitted((1.0, 2.0, 5.0), (0.7, 4.0, 1.0), (0.6, 6.0, 3.0))
    rows = judge_marks(result, task, (1.0, 3.0, 10.0, 30.0))
    assert [row["success"] for row in rows] == [False, True, False, False]
    assert rows[0]["error"] == pytest.approx(6.0) and rows[2]["error"] == pytest.approx(3.0)
    assert task.simulated == 3


def test_a_stored_field_is_verified_against_target_and_simulation():
    task = World()
    (mark,) = judge_marks(fitted((1.0, 1.0, 0.0)), task, (10.0,))
    row = {"job": "j", "task_hash": "abc", "marks": [mark]}
    assert verify(row, task)[0]["good"]
    assert not verify(row | {"task_hash": "abd"}, task)[0]["good"]
    assert not verify(row | {"marks": [mark | {"error": 0.5}]}, task)[0]["good"]
    assert not verify(row | {"marks": [mark | {"success": False}]}, task)[0]["good"]
    missed, *_ = judge_marks(fitted((0.7, 1.0, 0.0)), task, (10.0,))
    for error, good in ((missed["error"] * (1 + 1e-6), True), (3.001, False), (float("inf"), False)):
        assert verify(row | {"marks": [missed | {"error": error}]}, task)[0]["good"] == good


class Reddish:
    """In place of a CLIP model: each picture's mean brightness, so that what moves differs from the first."""

    name = "reddish"

    def compare(self, rgb, sentence):
        assert sentence.startswith("Stretch the jelly")
        return rgb.mean((1, 2, 3)) / 255.0


def write_page(result):
    """All tables, of rows."""
    return "\n\n".join(write_tables(condense(result)).values())


def test_pictures_of_stored_fields_and_of_nothing_are_compared_with_the_sentence(tmp_path, monkeypatch):
    """A still clip scores as its first frame; one that stretches the object does not; one that cannot run says so."""
    monkeypatch.setattr(jobs, "load_clip", lambda folder: Reddish())
    (spec,) = [spec for spec in load_tasks(TASKS) if spec.name == "stretch-jelly-wide"]
    stretch = Action(action_type=ActionType.SCALE, vector=(1, 0, 0), magnitude=1.6)
    row = dict(run=0, job="j", label="adam", task=spec.name, oracle=True, seed=0)
    row["marks"] = [{"mark": 10.0, "force_field": ForceField(actions=(stretch,)).model_dump(mode="json")}]
    path = tmp_path / "rows.json"
    rounds = row | {"label": "rules", "marks": [row["marks"][0] | {"mark": mark} for mark in (1.0, 2.0)]}
    soft = row | {"material": "softer", "brought": False}
    parts = {"methods": [row, row | {"job": "k", "marks": []}], "iterations": [rounds]}
    parts["materials"] = [soft, soft | {"brought": True}]
    path.write_text(json.dumps({part: {"rows": rows} for part, rows in parts.items()}))
    listed = list_similarities((spec,), path, tmp_path, None)
    names = [
        "methods / j",
        "iterations / j / 1",
        "iterations / j / 2",
        "materials / j",
        f"{spec.name} / nothing",
    ]
    assert [job.name for job in listed] == names
    made = [listed[place].measure() for place in (0, -1)]
    (moved,), (still,) = made
    assert (moved["label"], moved["mark"], moved["model"]) == ("adam", 10.0, "reddish")
    assert abs(moved["mean"] - moved["still"]) > 1e-3 and moved["still"] == pytest.approx(still["still"])
    assert still["label"] == NOTHING and abs(still["mean"] - still["still"]) < 1e-4
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    rows = [each | {"run": 0} for (each,) in made]
    page = write_page({"clipsim": {"runs": [run], "complete": True, "rows": rows}})
    told = f"{moved['mean']:.4f} ({moved['mean'] - moved['still']:+.4f})"
    assert "| part | method | clips | stretch | all | model |" in page
    assert f"| methods | adam (oracle) | 1 | {told} | {told} | reddish |" in page


class Dropper:
    """In place of a CLIP model: brightness, and one more for sentences about a drop."""

    name = "dropper"

    def compare(self, rgb, sentence):
        return rgb.mean((1, 2, 3)) / 255.0 + sentence.startswith("Drop")


def test_a_clip_is_compared_with_another_sentence_too(tmp_path, monkeypatch):
    """The order of frames does not change CLIPsim, so that the control is another sentence about the same object."""
    monkeypatch.setattr(jobs, "load_clip", lambda folder: Dropper())
    specs = [
        spec for spec in load_tasks(TASKS) if spec.name in ("drop-jelly", "stretch-jelly-wide", "drop-loaf")
    ]
    by_name = {spec.name: spec for spec in specs}
    wide, drop, loaf = by_name["stretch-jelly-wide"], by_name["drop-jelly"], by_name["drop-loaf"]
    assert jobs.find_other_sentence(wide, specs) == drop.sentence
    assert jobs.find_other_sentence(drop, specs) == wide.sentence
    assert jobs.find_other_sentence(loaf, specs) is None
    row = dict(part="methods", label=NOTHING, task=wide.name, oracle=False, seed=0, marks=[])
    (found,) = jobs.measure_similarity(row, wide, tmp_path, None, drop.sentence)
    assert found["shuffled"] == pytest.approx(found["mean"] + 1)
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    page = write_page({"clipsim": {"runs": [run], "complete": True, "rows": [found | {"run": 0}]}})
    assert f"{found['mean']:.4f} ({found['mean'] - found['still']:+.4f}, -1.0000)" in page


def test_what_was_found_with_one_material_is_judged_with_another(tmp_path):
    """The witness of a stretch is a success with its own material; of ten times the stiffness it is judged anew."""
    (spec,) = [spec for spec in load_tasks(TASKS) if spec.name == "stretch-jelly-wide"]
    field = load_witnesses(TASKS)[spec.name].model_dump(mode="json")
    mark = {"mark": 30.0, "success": True, "error": 0.5, "force_field": field}
    row = dict(run=0, label="adam", task=spec.name, family="stretch", split="development", seed=0)
    row |= dict(oracle=True, marks=[mark], job=f"{spec.name} / adam / 0")
    path, others = tmp_path / "rows.json", [row | {"job": row["job"][:-1] + end} for end in ("1", "0 / 100")]
    path.write_text(json.dumps({"methods": {"rows": [row, *others]}}))
    hard = '{"youngs_modulus": 2e5}'
    fits = list_materials((spec,), (), ("own", hard), path, (30.0,), 30.0, None)
    (same,), (harder,) = (job.measure() for job in fits)
    assert same["marks"][0]["success"] and same["brought"] and harder["material"] == hard
    assert harder["marks"][0]["error"] > same["marks"][0]["error"]
    path.write_text(json.dumps({"methods": {"rows": [row | {"marks": []}]}}))
    (refused,) = list_materials((spec,), (), (hard,), path, (30.0,), 30.0, None)[0].measure()
    assert refused["brought"] and refused["marks"] == []
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    section = {"runs": [run], "complete": True, "rows": [each | {"run": 0} for each in (same, harder)]}
    page = write_page({"materials": section})
    assert "| adam |  |  | 1/1 |  |" in page


def test_a_refusal_is_a_row_and_a_missing_package_is_none():
    """A row would say that the method does not solve the task."""

    def enter(error):
        def fit(*_):
            raise error

        method = SimpleNamespace(oracle=True, fit=fit)
        return SimpleNamespace(make=lambda: method, label="cma", method="cma", options={})

    spec = SimpleNamespace(name="push", family="impulse", split="test", smooth=True, task_hash="abc")
    task = SimpleNamespace(spec=spec)
    (row,) = measure(enter(UserError("no expert")), task, (1.0,), 0, 1.0)  # type: ignore[arg-type]
    assert row["refused"].startswith("no expert") and row["marks"] == []
    with pytest.raises(
        MissingPackageError, match=r"Install the extra: pip install 'physagent-jax\[baselines\]'"
    ):
        measure(enter(MissingPackageError("no cmaes", "baselines")), task, (1.0,), 0, 1.0)  # type: ignore[arg-type]


def test_clipsim_without_a_model_is_refused(tmp_path, capsys, monkeypatch):
    line = ["headtohead", "--json", str(tmp_path / "x.json"), "--parts", "clipsim"]
    monkeypatch.setattr(sys, "argv", line)
    assert main() == 2 and "--clip" in capsys.readouterr().err


def test_what_clip_leads_takes_part_where_there_is_a_model(capsys):
    """Rows name the model, not the folder on this machine."""
    assert find_guided(None) == () and "`clip_guided` is left out" in capsys.readouterr().err
    for package in ("flax", "safetensors", "tokenizers"):
        pytest.importorskip(package, reason="needs the extra `clip`")
    (entrant,) = find_guided(FOLDER)
    assert entrant.label == "clip_guided (tiny_clip)" and entrant.make().name == "clip_guided"
    with pytest.raises(UserError, match="holds no CLIP model"):
        find_guided(FOLDER.parent)


def test_a_leaderboard_keeps_what_others_wrote_and_can_be_verified(tmp_path):
    """Ours is replaced by a later fit of the same; a line that claims what its force field does not do is found out."""
    task, path = World(), tmp_path / "board.jsonl"

    def make_result(magnitude):
        (mark,) = judge_marks(fitted((magnitude, 1.0, 0.0)), task, (10.0,))
        row = dict(run=0, job="j", label="adam", task="t", split="test", seed=0, oracle=True)
        row |= dict(spent=9.5, seconds=1.0, task_hash="abc", marks=[mark])
        return {
            "methods": {"runs": [{"git_revision": "r"}], "rows": [row, row | {"label": "x", "marks": []}]}
        }

    leaderboard.merge(path, make_result(0.6))
    assert [entry.success for entry in leaderboard.read(path)] == [False]
    theirs = leaderboard.read(path)[0].model_copy(update={"method": "theirs", "success": True, "error": 0.1})
    path.write_text(path.read_text() + theirs.model_dump_json() + "\n")
    leaderboard.merge(path, make_result(1.0))
    entries = leaderboard.read(path)
    assert [(entry.method, entry.success) for entry in entries] == [("adam", True), ("theirs", True)]
    found = [verify(leaderboard.as_row(entry), task)[0]["good"] for entry in entries]
    assert found == [True, False]
    path.write_text(path.read_text() + "{}\n")
    with pytest.raises(UserError, match="board.jsonl:3"):
        leaderboard.read(path)


def test_the_ablation_takes_what_the_comparison_has_and_only_tasks_that_all_have_done():
    def make_rows(label, tasks, success):
        mark = {"mark": 30.0, "success": success, "error": 0.5}
        same = dict(run=0, label=label, oracle=False, family="drop", split="test", seed=0, marks=[mark])
        return [same | {"task": task} for task in tasks]

    result = {
        "methods": {"rows": make_rows("rules", "abc", True) + make_rows("cma", "abc", True)},
        "ablation": {"rows": make_rows("without refinement", "bcd", False)},
    }
    rows = choose_ablation(result)
    assert {(row["label"], row["task"], row["marks"][0]["success"]) for row in rows} == {
        (label, task, label == "full")
        for label in ("full", "without refinement", "types: agent, numbers: agent")
        for task in "bc"
    }


def test_the_page_names_missed_tasks_of_development_only():
    """By every budget that was given; from afar, those of the comparison."""

    def make_row(split, smooth, success, label="adam, near", budget=30.0):
        mark = {"mark": budget, "success": success, "error": 0.5}
        row = dict(label=label, task=f"{split}-{smooth}", split=split, smooth=smooth, spent=9.0, marks=[mark])
        row |= dict(seconds=1.0, memory_gb=None, evaluations=9)
        return row | dict(run=0, oracle=True, family="drop", seed=0)

    rows = [make_row("development", True, False), make_row("development", False, True)]
    rows.append(make_row("test", True, False))
    afar = [make_row("test", True, budget > 30.0, "adam, responses", budget) for budget in (30.0, 100.0)]
    afar.append(make_row("test", True, True, "cma"))
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    parts = {"neighbourhood": rows, "methods": afar}
    summary = condense(
        {part: {"runs": [run], "complete": True, "rows": mine} for part, mine in parts.items()}
    )
    page = write_tables(summary)["neighbourhood"]
    assert "| method, start | split | smooth, 30 | smooth, 100 | others, 30 | others, 100 | missed |" in page
    assert "| adam, near | development | 0/1 |  | 1/1 |  | development-True |" in page
    assert "| adam, near | test | 0/1 |  |  |  | not told" in page and "test-True" not in page
    assert "| adam, responses | test | 0/1 | 1/1 |  |  | none |" in page and "cma" not in page


@pytest.mark.parametrize("size", [0.45, 1.0, 1.5])
def test_a_neighbour_is_so_far_away_and_in_range(size):
    region = BoxRegion(low=(0, 0, 0), high=(1, 1, 0.3))
    action = Action(action_type=ActionType.SCALE, vector=(0.6, 0.0, 0.8), magnitude=-size, region=region)
    near = perturb(ForceField(actions=(action,), default_drop=True), np.random.default_rng(0))
    (moved,) = near.actions
    assert near.default_drop and moved.region == region and moved.action_type is ActionType.SCALE
    assert abs(moved.magnitude / -size - 1.0) == pytest.approx(STRONGER) and 0.4 <= -moved.magnitude <= 1.6
    assert np.degrees(np.arccos(np.dot(moved.vector, action.vector))) == pytest.approx(TURNED)


def test_every_entrant_can_be_made_and_oracles_are_named():
    for entrants in (METHODS, ABLATION, ITERATIONS):
        assert len({entrant.label for entrant in entrants}) == len(entrants)
    oracles = {entrant.label: entrant.make().oracle for entrant in METHODS}
    assert not oracles["rules"] and not oracles["direction_only"] and oracles["adam, all types"]


def test_the_page_has_success_cost_and_pairs():
    def make_row(label, oracle, success):
        marks = [
            {"mark": 1.0, "success": False, "error": 4.0},
            {"mark": 10.0, "success": success, "error": 0.5},
        ]
        row = {
            "run": 0,
            "label": label,
            "task": "drop-a",
            "family": "drop",
            "split": "test",
            "seed": 0,
            "oracle": oracle,
        }
        row |= {"spent": 9.0, "seconds": 2.0, "evaluations": 9, "trace": [[9.0, 2.0, 0.5]]}
        return row | {"marks": marks}

    run = {
        "quick": True,
        "seconds": 3.0,
        "command": "c",
        "machine": "m",
        "load_average": [0.1],
        "git_revision": "r",
    }
    rows = [make_row("rules", False, True), make_row("adam", True, False)]
    page = write_page({"methods": {"runs": [run], "complete": True, "rows": rows}})
    assert "| method | published as | drop | all | share | refused | error | clean |" in page
    assert "| adam (oracle) |  | 0/1 | 0/1 | 0% (0–79) |  | 0.50 (0.50–0.50) |  |" in page
    assert "| rules | PhysAgent: there agents are a language model | 1/1 |" in page
    assert (
        "| rules | 1 | 0 | 1 | 1 | 1 | 1 | 1 | 10 | 9 | 2 |" in page
        and "(`rules`) are rules of English" in page
    )
    absent = "suite, ablation, iterations, models, distillation, materials, neighbourhood, gradients, "
    absent += "clipsim, fidelity, verify"
    assert f"Not measured yet: {absent}" in page and "| adam | 1 | 10 | 0 | 1 | 1 | 1 | none |" in page
    assert "tasks by run" not in page
    rows += [make_row("adam", True, True) | {"seed": 1}]
    page = write_page({"methods": {"runs": [run], "complete": True, "rows": rows}})
    assert "| adam | 2 | 0.50 (0.50–0.50) |  | 0.00 | 1.00 | 1.00 | 0 to 1 | 1 |" in page
    assert "| rules | 2" not in page


def test_a_gradient_is_timed_beside_a_simulation_with_its_residuals(monkeypatch):
    """By a clock that a simulation moves by 1.5 s, residuals by 0.5 s, a gradient by 8 s; first calls take longer."""
    now = [0.0]

    class Clockwork:
        def __init__(self, task):
            self.first = 30.0

        def simulate(self, field):
            now[0] += 1.5 + self.first

        def compute_residuals(self, rollout):
            now[0] += 0.5

        def differentiate(self, rollout, parameters):
            now[0] += 8.0 + self.first
            self.first = 0.0

    monkeypatch.setattr(measuring, "Simulation", Clockwork)
    monkeypatch.setattr(measuring.time, "perf_counter", lambda: now[0])
    spec = SimpleNamespace(name="t", family="drop", split="test")
    (row,) = measuring.measure_gradient(SimpleNamespace(spec=spec, frame_count=5), push(1.0), 2)  # type: ignore[arg-type]
    assert (row["plain_seconds"], row["gradient_seconds"], row["ratio"]) == (2.0, 8.0, 4.0)
    assert row["ratio_range"] == [4.0, 4.0]
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    longer = row | dict(run=0, plain_seconds=8.0, gradient_seconds=16.0, ratio=2.0)
    rows = [row | {"run": 0}, longer, longer | {"family": "sway"}]
    page = write_page({"gradients": {"runs": [run], "complete": True, "rows": rows}})
    assert "| drop | 2 | 5 | 12 | 3.00 (2.00 to 4.00) | 2.40 |" in page
    assert "| all | 3 | 8 | 16 | 2.00 (2.00 to 4.00) | 2.22 |" in page


def test_a_fall_alone_has_no_gradient_to_be_timed():
    witnesses = load_witnesses(TASKS)
    specs = [spec for spec in load_tasks(TASKS) if spec.family == "drop"]
    idle = {
        spec.name for spec in specs if not (witnesses[spec.name].actions or witnesses[spec.name].constraints)
    }
    named = {job.name for job in list_gradients(specs, TASKS, None)}
    assert idle and named == {spec.name for spec in specs} - idle


def test_a_refused_task_is_shown_apart_and_a_small_budget_is_ones_own(monkeypatch):
    """An expert that refuses three of four tasks has done one; three rows of another move nobody else's last mark."""
    monkeypatch.setattr(statistics, "DRAWS", 20)

    def make_row(label, task, marks):
        row = dict(
            run=0, label=label, task=task, family="drop", split="test", seed=0, oracle=False, smooth=True
        )
        row |= dict(spent=9.0, seconds=2.0, memory_gb=None, evaluations=9, trace=[], model_calls=0)
        return row | dict(marks=[{"mark": mark, "success": True, "error": 0.5} for mark in marks])

    rows = [make_row("expert", task, [10.0] if task == "a" else []) for task in "abcd"]
    rows += [make_row("rules", task, [10.0, 300.0]) for task in "abcd"]
    rows += [make_row("theirs", task, [10.0]) for task in "abc"]
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    page = write_page({"methods": {"runs": [run], "complete": True, "rows": rows}})
    assert "two of their force fields | 1/1 | 1/1 | 100% (21–100) | 3 |" in page
    assert (
        "| 300 | 9 | 2 |  | m |" in page
        and "| theirs | 3 | 3 |  | 3 | 3 | 3 | 3 | 10 | 9 | 2 |  | m |" in page
    )
    assert "| expert | 1 | 10 | 0 | 0 | 1 | 1 | none |" in page
    assert "no difference between `rules` and `expert` is shown (1 and 1 of 1;" in page
    assert "Some method solves each task." in page


def test_old_names_of_rows_are_read_as_those_of_today():
    """And no method, label or job has an old name afterwards."""
    old = [("physagent", "physagent", {}), ("without refinement", "physsplat_f", {"skills": True})]
    old += [
        (
            "dreamphysics_f, whole clip, Adam (toy prior)",
            "dreamphysics_f",
            {"prior": "toy", "schedule": "adam"},
        )
    ]
    rows = [
        dict(label=label, method=method, options=options, job=f"t / {label} / 0 / 100")
        for label, method, options in old
    ]
    made = rename({"methods": {"rows": [*rows, {"job": "t / physagent / 0"}]}})["methods"]["rows"]
    assert [row["job"] for row in made] == [
        "t / rules / 0 / 100",
        "t / without refinement / 0 / 100",
        "t / sds_whole_clip (toy prior) / 0 / 100",
        "t / rules / 0",
    ]
    entrants = {each.label: each for each in (*METHODS, *ABLATION, *list_distillers("toy", ""))}
    for row in made[:3]:
        assert row["method"] == entrants[row["label"]].method and entrants[row["label"]].make()
        known = {name: value for name, value in entrants[row["label"]].options.items() if name != "weights"}
        assert row["options"] == known


def test_methods_are_chosen_by_label_and_ones_own_by_file(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("from baselines.methods.random import RandomSearch as Mine\n")
    chosen = choose_entrants(("rules", f"{file}:Mine"), None)
    assert [each.label for each in chosen] == ["rules", "random"] and chosen[1].make().stochastic
    with pytest.raises(UserError, match="rules"):
        choose_entrants(("rule",), None)


def test_score_distillation_is_told_with_its_steps_stages_and_calls(monkeypatch):
    """Fourteen of fifty steps; five of 1,500, all on the first of two stages."""
    monkeypatch.setattr(statistics, "DRAWS", 20)
    rows = []
    for entrant, evaluations in zip(list_distillers("toy", ""), (15, 6, 6)):
        row = dict(run=0, label=entrant.label, task="a", family="drop", split="test", seed=0, oracle=False)
        row |= dict(spent=30.0, seconds=2.0, evaluations=evaluations, model_calls=48, trace=[])
        options = {name: value for name, value in entrant.options.items() if name != "weights"}
        rows.append(row | dict(options=options, marks=[{"mark": 30.0, "success": False, "error": 4.0}]))
    rows.append(rows[0] | dict(task="b", marks=[]))
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    page = write_page({"distillation": {"runs": [run], "complete": True, "rows": rows}})
    assert "| 0/1 | 1 | 4.00 (4.00–4.00) | 30 | 14 of 50 |  | 48 |" in page
    assert "| 0/1 | 0 | 4.00 (4.00–4.00) | 30 | 5 of 1500 | 1 of 2 | 48 |" in page


def test_the_page_says_how_much_was_verified():
    row = dict(run=0, label="adam", split="test", oracle=True, family="drop", seed=0)
    row |= dict(marks=[{"mark": 1.0, "success": True, "error": 0.5}])
    rows = [row | dict(job=f"{task} / adam / 0", task=task) for task in "abcd"]
    checked = [dict(run=0, job="a / adam / 0", good=True, stored=0.5, again=0.5)]
    run = dict(quick=False, seconds=1.0, command="c", machine="m", load_average=[0.1], git_revision="r")
    parts = {"neighbourhood": [each | {"smooth": True} for each in rows], "verify": checked}
    page = write_page({part: {"runs": [run], "complete": True, "rows": mine} for part, mine in parts.items()})
    assert "1 of 1 force fields, simulated again, have the error that they had." in page
    assert "They are 25% of the 4 stored fits, of 1 of 4 test tasks" in page
