"""Small runs on the bundled object, and scripted agents."""

from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.registry import make_agents
from physagent_jax.run.loop import run_loop
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec

LEFT = "a strong wind pushes the robot to the left"


def small(
    object_path, prompt=LEFT, *, frames=10, particles=600, resolution=96, cells: int | None = 48, **parts
) -> RunSpec:
    """A run that takes seconds; without a video for people unless ``save`` asks for one."""
    overrides = dict(frame_count=frames, max_particles=particles, width=resolution, height=resolution)
    overrides |= {} if cells is None else dict(cells=cells)
    parts = {"object": {"path": str(object_path)}, "prompt": prompt, "overrides": overrides, **parts}
    parts["save"] = {"video_size": None, **parts.get("save", {})}
    return RunSpec.model_validate(parts)


def made(spec, out, agents=None, **options):
    """The finished store of a run."""
    return run_loop(resolve(spec), out, agents=agents, command="test", **options)


def with_rules(planner=None, executor=None) -> Agents:
    """The offline agents, but for those given."""
    rules = make_agents()
    return Agents(rules.semantic, planner or rules.planner, executor or rules.executor)
