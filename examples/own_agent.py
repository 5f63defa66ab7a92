"""A planner of one's own in the closed loop: it wants the object high, and says so in a plain SUCCESS or FAIL.

Run: python examples/own_agent.py
"""

import tempfile
from pathlib import Path

import physagent_jax as pa
from physagent_jax.agents.protocols import Agents, ExecutorAgent, PlannerAgent
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.motion.schema import Judgement, Verdict

ROBOT = Path(__file__).parent / "assets" / "robot.ply"


class HighEnough(PlannerAgent):
    """Success is a rise of a fifth of the object's length; `seen` is what perception measured in the pictures."""

    def judge(self, context, seen):
        """SUCCESS, or FAIL with what to change."""
        rise = (seen.report.centroid[-1] or (0, 0, 0))[2]
        if rise > 0.2:
            return Reply(Judgement(verdict=Verdict.SUCCESS))
        return Reply(
            Judgement(verdict=Verdict.FAIL, suggestion=f"it rose by {rise:.2f} lengths: push harder")
        )


class Harder(ExecutorAgent):
    """Doubles every magnitude, within the library's range."""

    def rewrite(self, context, failed):
        """The next force field."""
        old = failed.force_field
        actions = tuple(a.model_copy(update={"magnitude": min(2 * a.magnitude, 1.6)}) for a in old.actions)
        force_field = old.model_copy(update={"actions": actions})
        return Reply(Rewrite(force_field=force_field, changes=(failed.judgement.suggestion,)))


def main(folder):
    """Return the finished run."""
    spec = pa.RunSpec.model_validate(
        dict(
            object=dict(path=str(ROBOT)),
            prompt="lift it a little",
            overrides=dict(frame_count=12, max_particles=800, width=96, height=96),
            rounds=3,
        )
    )
    agents = Agents(make_agents().semantic, HighEnough(), Harder())
    return pa.synthesize(spec, Path(folder) / "run", agents=agents)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        run = main(folder)
        print(f"{run.manifest.verdict} after {len(run.rounds)} round(s)")
        assert run.manifest.verdict == "SUCCESS"
