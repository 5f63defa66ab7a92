"""The closed loop on pictures alone: a real simulation in two rounds, so it takes more than other tests."""

from physagent_jax.motion.schema import Judgement, Verdict
from physagent_jax.perception.schema import MotionReport
from physagent_jax.run import rounds
from tests.run.specs import made, small


def test_a_gentle_push_is_rewritten_and_judged_a_success_without_depth(tmp_path, robot_path, monkeypatch):
    passed, perceive = [], rounds.perceive

    def watch(rgb, depth, camera, **options):
        passed.append(options["backends"].depth.takes_measured)
        return perceive(rgb, None, camera, **options)

    monkeypatch.setattr(rounds, "perceive", watch)
    sentence = "push the robot gently to the left"
    store = made(small(robot_path, sentence, frames=8, perception="rgb", rounds=2), tmp_path / "run")
    last = store.manifest.best_iteration
    judgement = store.read(f"iterations/{last}/judgement.json", Judgement)
    report = store.read(f"iterations/{last}/motion_report.json", MotionReport)
    assert judgement.verdict is Verdict.SUCCESS, judgement.suggestion
    assert report.unmeasured_direction is not None and report.centroid[-1][0] < -0.03
    assert any("No depth is measured" in note for note in report.quality.notes)
    assert passed and not any(passed)
