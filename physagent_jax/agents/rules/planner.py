"""The offline planner: compares a motion report with what the sentence leads a viewer to expect."""

from __future__ import annotations

from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.materials import DENTED, GIVING, find_materials, find_meaning
from physagent_jax.agents.protocols import PlannerAgent
from physagent_jax.agents.trace import Reply
from physagent_jax.motion.judging.posing import tells_pose
from physagent_jax.motion.judging.seen import View, has_gravity
from physagent_jax.motion.judging.verdict import judge
from physagent_jax.motion.matching import is_last_rest
from physagent_jax.motion.schema import Judgement
from physagent_jax.motion.tolerances import list_windows


class RulePlanner(PlannerAgent):
    """Judges by the sentence and the motion alone: what the force field holds is no yardstick."""

    def windows(self, context: AgentContext) -> list[tuple[int, int]]:
        """One per expectation."""
        return list_windows(context.expectations, context.brief.frame_count)

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare the report with what is expected of the sentence; see `protocols.PlannerAgent`."""
        expectations, reading = context.expectations, context.reading
        obstacles, unsure = (reading.world.obstacles, reading.unsure) if reading else ((), ())
        field, world = seen.force_field, reading.world.gravity if reading else None
        gravity = has_gravity(world, context.brief, expectations, field)
        told = find_materials(context.prompt, context.brief)
        of = {meaning.preset for each in told if (meaning := find_meaning(each.word))}
        dented, soft = not of.isdisjoint(DENTED), not of.isdisjoint(GIVING)
        asked = context.brief, expectations, field, gravity, obstacles, context.prompt, dented
        return Reply(judge(View(seen.report, *asked, seen.ending, soft), unsure))

    def watches_ending(self, context: AgentContext) -> bool:
        """Return whether the sentence is about how it is left."""
        told = context.prompt, context.expectations, context.brief
        return any(is_last_rest(each, told[1]) for each in told[1]) or tells_pose(*told)
