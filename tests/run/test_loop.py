"""The closed loop on the bundled object, small and coarse: files, determinism, resuming, keeping the best."""

import dataclasses
import json
import os
import warnings

import numpy as np
import pytest
import trimesh

from physagent_jax.agents.protocols import ExecutorAgent, PlannerAgent
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.cli import main
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import link_or_copy
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.motion.schema import Check, Judgement, Verdict
from physagent_jax.output.motion_file import read_motion
from physagent_jax.output.video import read_video
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.backends.colour import ColorSegmenter
from physagent_jax.report.html import write_report
from physagent_jax.run import rounds
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.observer import Observer
from physagent_jax.run.stopping import STOP_REASONS
from physagent_jax.simulation.record import SimulationRecord
from tests.run.specs import made, small, with_rules

FRAMES = 10
PROMPT = "a strong wind pushes the robot to the left"


@pytest.fixture(scope="module")
def finished(tmp_path_factory, robot_path):
    out = tmp_path_factory.mktemp("loop") / "run"
    line = [
        "run",
        "--object",
        robot_path,
        "--prompt",
        PROMPT,
        "--out",
        out,
    ]
    options = [
        "--frames",
        FRAMES,
        "--particles",
        600,
        "--resolution",
        96,
        "--video-size",
        "160x90",
        "--save-splats",
        "--save-frames",
        "--json",
    ]
    assert main([str(part) for part in (*line, *options)]) == 0
    return out


def test_a_run_leaves_every_file(finished):
    names = {path.name for path in finished.iterdir()}
    assert {"manifest.json", "semantic.json", "scene.json", "video.mp4", "motion.npz", "report.html"} <= names
    first = {path.name for path in (finished / "iterations" / "0").iterdir()}
    assert {
        "scene.json",
        "force_field.json",
        "motion_report.json",
        "judgement.json",
        "simulation.json",
    } <= first
    clip = read_video(finished / "video.mp4")
    assert clip.shape[1:] == (90, 160, 3) and FRAMES <= len(clip) <= FRAMES + 25  # until rest, 1 s at most
    assert read_video(finished / "perception.mp4").shape == (FRAMES, 96, 96, 3)
    assert len(list((finished / "frames").iterdir())) == FRAMES
    assert len(list((finished / "splats").glob("*.ply"))) == FRAMES


def test_the_object_moves_the_way_the_sentence_says(finished):
    record = SimulationRecord.model_validate_json(
        (finished / "iterations" / "0" / "simulation.json").read_bytes()
    )
    x, y, z = record.truth.centroid[-1]
    assert x < -0.3 and abs(y) < 0.01 and abs(z) < 0.01


def test_a_sentence_is_read_for_the_scene_that_the_object_is_in(robot_path, tmp_path):
    """The robot would fall over, so that it is held in the air: there a later fall needs a push, which is said."""
    store = made(small(robot_path, "push it left, then drop it", world="ground", rounds=1), tmp_path / "run")
    first, second = store.read("semantic.json", SemanticReply).force_field.actions
    assert first.vector[0] < 0 and second.vector[2] < 0 and second.active_time[0] > 0


def test_perception_agrees_with_the_particles(finished):
    report = json.loads((finished / "iterations" / "0" / "motion_report.json").read_text())
    record = json.loads((finished / "iterations" / "0" / "simulation.json").read_text())
    np.testing.assert_allclose(report["centroid"][-1], record["truth"]["centroid"][-1], atol=0.06)


def test_frame_zero_of_the_exported_splats_is_the_object_itself(finished, robot_path):
    from physagent_jax.gaussians.formats import read_ply

    exported, original = (
        read_ply(finished / "splats" / "0000.ply"),
        read_ply(robot_path, opacity_threshold=0.02),
    )
    np.testing.assert_allclose(exported.means, original.means, atol=2e-5)
    np.testing.assert_allclose(exported.sh, original.sh, atol=2e-3)
    np.testing.assert_allclose(exported.opacities, original.opacities, atol=1e-3)
    assert np.sort(exported.scales, 1) == pytest.approx(np.sort(original.scales, 1), rel=0.02, abs=1e-4)


def test_the_motion_file_reproduces_the_particles(finished):
    motion = read_motion(finished / "motion.npz")
    assert motion.x.shape[0] == FRAMES and motion.x.shape[1] >= 500
    assert float(np.abs(motion.F[0] - np.eye(3)).max()) == 0


def test_the_large_files_of_the_best_round_are_kept_once(finished):
    for name in ("motion.npz", "perception.mp4"):
        assert os.path.samefile(finished / name, finished / "iterations" / "0" / name)
    scene = finished / "scene.json"  # people edit this one
    assert not os.path.samefile(scene, finished / "iterations" / "0" / "scene.json")
    manifest = json.loads((finished / "manifest.json").read_text())
    assert {"motion.npz", "iterations/0/motion.npz"} <= set(manifest["files"])


def test_without_hard_links_a_file_is_copied(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError("no hard links here")

    (tmp_path / "a").write_bytes(b"motion")
    monkeypatch.setattr(os, "link", refuse)
    link_or_copy(tmp_path / "a", tmp_path / "b")
    assert (tmp_path / "b").read_bytes() == b"motion"


def test_the_end_is_told_in_words_and_what_was_assumed_in_the_line_of_json(finished, robot_path, capsys):
    line = ["run", "--object", robot_path, "--prompt", PROMPT, "--out", finished, "--frames", FRAMES]
    options = [
        "--particles",
        600,
        "--resolution",
        96,
        "--video-size",
        "160x90",
        "--save-splats",
        "--save-frames",
    ]
    assert main([str(part) for part in (*line, *options)]) == 0  # it is there already
    stopped = Manifest.model_validate_json((finished / "manifest.json").read_bytes()).stopped
    assert stopped is not None and f": {STOP_REASONS[stopped]}\n" in capsys.readouterr().err
    options += ["--json"]
    assert main([str(part) for part in (*line, *options)]) == 0
    told = json.loads(capsys.readouterr().out)
    reply = json.loads((finished / "semantic.json").read_text())
    assert told["not_understood"] == reply["not_understood"] and told["assumptions"] == reply["notes"]


def test_the_same_command_gives_the_same_scene_bytes(finished, tmp_path, robot_path):
    store = made(small(robot_path, cells=None), tmp_path / "again")
    assert (store.path / "scene.json").read_bytes() == (finished / "scene.json").read_bytes()


def test_a_finished_run_is_not_made_again(finished, capsys, robot_path):
    stamp = (finished / "video.mp4").stat().st_mtime_ns
    store = made(
        small(robot_path, cells=None, save=dict(splats=True, frames=True, video_size=(160, 90))), finished
    )
    assert store.manifest.complete and (finished / "video.mp4").stat().st_mtime_ns == stamp


def test_another_prompt_needs_another_folder(finished, robot_path):
    with pytest.raises(ValueError, match="holds another run"):
        made(small(robot_path, "drop the robot"), finished)


# --- several rounds, with scripted judges ---------------------------------------------------------------


class ScriptedPlanner(PlannerAgent):
    """Gives the scores of a script."""

    def __init__(self, scores):
        self.scores = list(scores)

    def judge(self, context, seen):
        score = self.scores.pop(0)
        check = Check(expectation=0, question="?", expected="", observed="", passed=score == 1, score=score)
        verdict = Verdict.SUCCESS if score == 1 else Verdict.FAIL
        suggestion = "" if score == 1 else "again"
        return Reply(Judgement(verdict=verdict, score=score, checks=(check,), suggestion=suggestion))


class ScriptedExecutor(ExecutorAgent):
    """Pushes along another direction each time; may be told to stop the run instead."""

    def __init__(self, interrupt=False):
        self.interrupt = interrupt

    def rewrite(self, context, failed):
        if self.interrupt:
            raise KeyboardInterrupt
        action = Action(
            action_type="translation", vector=(0, 0, 1.0), magnitude=1.0 - 0.1 * len(context.rounds)
        )
        return Reply(Rewrite(force_field=ForceField(actions=(action,)), changes=("scripted",)))


def scripted(scores, interrupt=False):
    return with_rules(ScriptedPlanner(scores), ScriptedExecutor(interrupt))


def test_the_best_round_is_kept(tmp_path, robot_path):
    store = made(small(robot_path), tmp_path / "run", scripted([0.2, 0.7, 0.4]))
    assert (store.manifest.iterations, store.manifest.best_iteration, store.manifest.verdict) == (
        3,
        1,
        "FAIL",
    )
    assert (store.path / "scene.json").read_bytes() == (store.round_folder(1) / "scene.json").read_bytes()
    fields = [
        json.loads((store.round_folder(k) / "force_field.json").read_text())["actions"][0] for k in range(3)
    ]
    assert [f["magnitude"] for f in fields[1:]] == [1.0, 0.9]
    cameras = [json.loads((store.round_folder(k) / "scene.json").read_text())["camera"] for k in range(3)]
    assert cameras[1] != cameras[0]  # which was placed for a push to the left and does not show a lift
    assert cameras[2] == cameras[1]  # which shows the weaker lift too


@pytest.mark.parametrize("watches", [True, False])
def test_a_planner_that_asks_for_it_is_told_of_the_frames_after_the_planned_ones(
    tmp_path, robot_path, watches
):
    """They begin with the last planned one, and are simulated once, for the video too."""

    class Watcher(ScriptedPlanner):
        def watches_ending(self, context):
            return watches

        def judge(self, context, seen):
            self.ending = seen.ending
            return super().judge(context, seen)

    planner = Watcher([1.0])
    spec = small(robot_path, "drop the robot", frames=5, rounds=1, save=dict(video_size=(160, 90)))
    store = made(spec, tmp_path / "run", with_rules(planner))
    film = read_video(store.path / "video.mp4")
    if not watches:
        assert planner.ending is None
        return
    assert planner.ending.frame_count == len(film) - 4 > 2
    assert planner.ending.centroid[0] == (0.0, 0.0, 0.0), "it tells what comes after"


def test_success_stops_the_loop(tmp_path, robot_path):
    store = made(small(robot_path), tmp_path / "run", scripted([0.2, 1.0, 0.4]))
    assert (store.manifest.iterations, store.manifest.best_iteration, store.manifest.verdict) == (
        2,
        1,
        "SUCCESS",
    )


def test_a_stopped_run_goes_on_where_it_stopped(tmp_path, robot_path):
    asked, out = small(robot_path), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        made(asked, out, scripted([0.2], interrupt=True))
    manifest = Manifest.model_validate_json((tmp_path / "run" / "manifest.json").read_bytes())
    assert not manifest.complete
    video = tmp_path / "run" / "iterations" / "0" / "perception.mp4"
    stamp, spent = video.stat().st_mtime_ns, manifest.stages.simulate
    store = made(asked, out, scripted([1.0]))  # one score only: round 0 must not be judged again
    assert store.manifest.complete and store.manifest.best_iteration == 1
    assert video.stat().st_mtime_ns == stamp
    assert store.manifest.stages.simulate > spent


def test_a_run_with_other_agents_is_another_run(tmp_path, robot_path):
    asked, out = small(robot_path), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        made(asked, out, scripted([0.2], interrupt=True))
    with pytest.raises(UserError, match="holds another run"):
        made(asked, out)

    class OtherModel(ScriptedPlanner):
        name = "another model behind the same class"

    with pytest.raises(UserError, match="holds another run"):
        made(asked, out, dataclasses.replace(scripted([1.0]), planner=OtherModel([1.0])))
    assert made(asked, out, scripted([1.0])).manifest.complete


def test_a_run_with_another_perception_is_another_run(tmp_path, robot_path):
    class OtherSegmenter(ColorSegmenter):
        pass

    asked, out = small(robot_path), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        made(asked, out, scripted([0.2], interrupt=True))
    backends = dataclasses.replace(make_backends(), segmenter=OtherSegmenter())
    with pytest.raises(UserError, match="holds another run"):
        made(asked, out, scripted([1.0]), backends=backends)


class ToldSegmenter(ColorSegmenter):
    """Takes a prompt, keeps it, and goes by colour."""

    takes_prompt = True

    def __init__(self):
        super().__init__()
        object.__setattr__(self, "prompts", [])

    def segment(self, frames, prompt):
        self.prompts.append((frames.shape[1:3], prompt))
        return super().segment(frames, None)


def prompted(robot_path, prompt, **parts):
    return small(
        robot_path, particles=1800, resolution=288, cells=None, perception={"prompt": prompt}, **parts
    )


def test_a_prompt_of_the_spec_reaches_the_segmenter_at_every_resolution(tmp_path, robot_path):
    backends = dataclasses.replace(make_backends(), segmenter=ToldSegmenter())
    prompt = {"frame": 2, "points": [[0.5, 0.25], [0, 1]], "labels": [True, False], "box": [0, 0.1, 1, 0.9]}
    spec = prompted(robot_path, prompt, probe=True, rounds=1)
    made(spec, tmp_path / "run", scripted([1.0, 1.0]), backends=backends)
    assert [size for size, _ in backends.segmenter.prompts] == [(96, 96), (288, 288)]
    for (height, width), told in backends.segmenter.prompts:
        assert told.frame == 2 and told.labels.tolist() == [True, False] and told.mask is None
        np.testing.assert_allclose(told.points, [[0.5 * width, 0.25 * height], [0, height]])
        np.testing.assert_allclose(told.box, [0, 0.1 * height, width, 0.9 * height])


def test_a_mask_of_the_spec_reaches_the_segmenter(tmp_path, robot_path):
    mask = np.zeros((288, 288), bool)
    mask[100:190, 50:240] = True
    np.save(tmp_path / "mask.npy", mask)
    backends = dataclasses.replace(make_backends(), segmenter=ToldSegmenter())
    spec = prompted(robot_path, {"mask_path": str(tmp_path / "mask.npy")}, probe=True, rounds=1)
    made(spec, tmp_path / "run", scripted([1.0, 1.0]), backends=backends)
    (_, coarse), (_, fine) = backends.segmenter.prompts
    np.testing.assert_array_equal(fine.mask, mask)
    np.testing.assert_array_equal(coarse.mask, mask[1::3, 1::3])


def test_without_a_prompt_the_segmenter_gets_none(tmp_path, robot_path):
    backends = dataclasses.replace(make_backends(), segmenter=ToldSegmenter())
    made(small(robot_path, rounds=1), tmp_path / "run", scripted([1.0]), backends=backends)
    assert [prompt for _, prompt in backends.segmenter.prompts] == [None]


def test_a_prompt_for_a_segmenter_that_takes_none_is_refused_before_the_run_begins(tmp_path, robot_path):
    with pytest.raises(UserError, match="means nothing to this segmenter .got RgbdSegmenter."):
        made(prompted(robot_path, {"points": [[0.5, 0.5]]}), tmp_path / "run", scripted([1.0]))
    assert not (tmp_path / "run" / "manifest.json").exists()


def test_a_warning_of_any_stage_is_told_and_noted(robot_path, tmp_path, monkeypatch):
    """Not only those of the making of a scene: here the simulation warns."""
    simulate, told = rounds.simulate_scene, []

    def warn(*given, **options):
        warnings.warn("the matter is stirred", stacklevel=2)
        return simulate(*given, **options)

    class Watch(Observer):
        def warned(self, text):
            told.append(text)

    monkeypatch.setattr(rounds, "simulate_scene", warn)
    store = made(small(robot_path, rounds=1), tmp_path / "run", scripted([1.0]), observer=Watch())
    assert told.count("the matter is stirred") == 1 and "the matter is stirred" in store.manifest.warnings


def test_a_loose_piece_is_told_before_anything_is_simulated(tmp_path):
    """A piece too far from the rest to be joined is told on the way, in the record, and on the page."""
    far = trimesh.creation.box([0.2, 0.2, 0.2]).apply_translation([0.9, 0, 0])
    trimesh.util.concatenate([trimesh.creation.box([0.4, 0.4, 0.4]), far]).export(tmp_path / "pair.obj")
    told = []

    class Watch(Observer):
        def warned(self, text):
            told.append(text)

        def frame(self, done, total):
            assert told

    store = made(small(tmp_path / "pair.obj", rounds=1, cells=48), tmp_path / "run", observer=Watch())
    (loose,) = [text for text in told if "joined to the rest by nothing" in text]
    assert loose in store.manifest.warnings
    assert "joined to the rest by nothing" in write_report(store.path).read_text()
