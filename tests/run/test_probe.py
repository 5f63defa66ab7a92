"""Coarse rounds before the fine ones: what is coarsened and taken on, resuming, and when they are left out."""

from types import SimpleNamespace

import pytest

from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ForceField, SphereRegion
from physagent_jax.report.html import write_report
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.resolve import resolve
from physagent_jax.scene.coarse import coarsen
from physagent_jax.scene.config import SceneConfig
from physagent_jax.scene.presets import PRESETS, PresetName
from physagent_jax.simulation.record import SimulationRecord
from tests.run.specs import made, small, with_rules
from tests.run.test_loop import ScriptedPlanner


def body(particles, extent=1.0):
    return SimpleNamespace(extent=extent, particles=SimpleNamespace(count=particles))


@pytest.mark.parametrize("name", PresetName)
def test_a_coarse_scene_is_the_same_clip_with_fewer_particles_cells_and_pixels(name):
    fine = PRESETS[name]
    coarse = coarsen(fine, body(16_000))
    assert coarse.domain.size == fine.domain.size and coarse.domain.dx == 2 * fine.domain.dx
    assert coarse.filling.max_particles == 2000
    assert coarse.rendering.width == round(fine.rendering.width / 3)
    assert coarse.timing.frame_count == fine.timing.frame_count and coarse.timing.substep_dt == "auto"
    assert coarse.transfer == fine.transfer


@pytest.mark.parametrize("small", [body(1000), body(16_000, extent=0.5)])
def test_what_is_too_coarse_already_is_not_coarsened(small):
    with pytest.raises(UserError, match="too coarse already"):
        coarsen(PRESETS[PresetName.FAST], small)


# --- in the loop --------------------------------------------------------------------------------------


NOWHERE = SphereRegion(center=(9, 9, 9), radius=0.1)


class CountingExecutor(ExecutorAgent):
    """Pushes with M = 1.0, 1.1, ... what is in a region; may be told to stop the run instead."""

    def __init__(self, interrupt=False, region=None):
        self.interrupt, self.region = interrupt, region

    def rewrite(self, context, failed):
        if self.interrupt:
            raise KeyboardInterrupt
        magnitude = 1.0 + 0.1 * len(context.rounds)
        push = Action(action_type="translation", vector=(0, 0, 1), magnitude=magnitude, region=self.region)
        return Reply(Rewrite(force_field=ForceField(actions=(push,)), changes=("scripted",)))


def run_loop(robot_path, out, scores, interrupt=False, region=None, **options):
    options = {**dict(frames=6, particles=1800, resolution=64, cells=None, probe=True), **options}
    spec = small(robot_path, "push the robot to the left", **options)
    return made(spec, out, with_rules(ScriptedPlanner(scores), CountingExecutor(interrupt, region)))


def push_of(folder):
    return SceneConfig.model_validate_json((folder / "scene.json").read_bytes()).force_field.actions[0]


def record_of(folder):
    return SimulationRecord.model_validate_json((folder / "simulation.json").read_bytes())


def test_the_fine_rounds_begin_with_the_best_coarse_one_also_after_a_stop(robot_path, tmp_path):
    out = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        run_loop(robot_path, out, [0.2], interrupt=True)  # after the first coarse round
    assert not (out / "iterations").exists()
    video = out / "probe" / "iterations" / "0" / "perception.mp4"
    stamp = video.stat().st_mtime_ns
    spent = Manifest.model_validate_json((out / "manifest.json").read_bytes()).stages.probe

    store = run_loop(robot_path, out, [0.7, 0.4, 1.0])  # two more coarse rounds, then a fine one
    coarse = [out / "probe" / "iterations" / str(k) for k in range(3)]
    assert video.stat().st_mtime_ns == stamp and all((k / "judgement.json").is_file() for k in coarse)
    assert [push_of(k).magnitude for k in coarse[1:]] == [1.0, 1.1]
    assert push_of(store.round_folder(0)) == push_of(coarse[1]) == push_of(out)
    # An eighth of the particles, and the joints to the robot's hands, which come on top of the cap.
    eighth = record_of(store.round_folder(0)).particle_count // 8
    assert eighth <= record_of(coarse[0]).particle_count <= 1.25 * eighth

    manifest = store.manifest
    assert (manifest.iterations, manifest.verdict) == (1, "SUCCESS")
    assert (manifest.probe_iterations, manifest.probe_best) == (3, 1)
    assert manifest.stages.probe > spent > 0
    assert {cost.agent: cost.calls for cost in manifest.agents}["planner"] == 4
    page = write_report(out).read_text()
    assert "Coarse rounds" in page and "taken on" in page


def test_a_coarse_round_that_fails_ends_the_coarse_rounds_only(robot_path, tmp_path):
    store = run_loop(robot_path, tmp_path / "run", [0.3, 1.0], region=NOWHERE)
    manifest = store.manifest
    assert manifest.complete and (manifest.probe_iterations, manifest.probe_best) == (1, 0)
    assert any("left out" in text and "selects no particle" in text for text in manifest.warnings)


def test_coarse_rounds_are_left_out_with_a_warning_if_the_object_is_too_coarse(robot_path, tmp_path):
    store = run_loop(robot_path, tmp_path / "run", [1.0], particles=600)
    assert store.manifest.complete and not (store.path / "probe").exists()
    assert any(
        "coarse rounds were left out: the object is too coarse" in text for text in store.manifest.warnings
    )
    assert "Coarse rounds" not in write_report(store.path).read_text()


def test_asking_for_coarse_rounds_makes_it_another_run(robot_path, tmp_path):
    with_probe, without = (resolve(small(robot_path, cells=None, probe=probe)) for probe in (True, False))
    assert with_probe.inputs != without.inputs
