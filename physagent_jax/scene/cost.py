"""The estimated time and memory of a simulation, refused beyond a limit before it begins.

Least costs, for orders of magnitude: matter that is fast or stretched needs shorter steps and a larger grid.
"""

from __future__ import annotations

import dataclasses
import math
import os
from pathlib import Path

from physagent_jax.core.errors import UserError
from physagent_jax.scene.body import Body
from physagent_jax.scene.burden import find_firmness
from physagent_jax.scene.config import SceneConfig
from physagent_jax.scene.damping import find_scene_slowdown
from physagent_jax.scene.materials.cost import stable_step

# Seconds on two cores, measured (docs/throughput.md, docs/startup.md); a pixel's are those of drawing it, of
# following it and of encoding it.
SECONDS_PER_PARTICLE_STEP, SECONDS_PER_NODE_STEP, SECONDS_PER_PIXEL = 5e-8, 5e-9, 8e-7
SECONDS_PER_VIDEO_PIXEL = 2e-7  # of drawing and encoding the video for people, a few frames at a time
# Bytes on the host, measured as the slope of the peak over frames: pictures, depth, trajectories and what is made of
# them on the way to files.
BYTES_PER_PIXEL, BYTES_PER_PARTICLE, BYTES_PER_NODE = 24.0, 220.0, 64.0
BASE_BYTES = 6e8  # of the process with its compiled programs
ROOM = 1.5  # sides of the grid window over the object's
MEMORY_SHARE = 0.8  # of the machine's memory that may be used unless told otherwise
MINUTES = 60.0  # that a round may take unless told otherwise


@dataclasses.dataclass(frozen=True)
class Cost:
    """An estimate of what one simulation takes at least.

    Attributes:
        substeps: Substeps of all frames.
        seconds: Wall time on two cores [s].
        memory: Memory of the host [bytes].
        largest: What takes most of the time, and what takes most of the memory, in words.
        watching: Seconds of them that pictures and video take, all but the simulation [s].
    """

    substeps: float
    seconds: float
    memory: float
    largest: tuple[str, str]
    watching: float = 0.0


@dataclasses.dataclass(frozen=True)
class Limits:
    """The limits of a simulation's time and memory.

    Attributes:
        minutes: Wall time, as estimated [min].
        memory: As estimated [GB]; None = `MEMORY_SHARE` of the machine's.
    """

    minutes: float = MINUTES
    memory: float | None = None

    def __post_init__(self):
        for option, value in (("--max-minutes", self.minutes), ("--max-memory", self.memory)):
            if value is not None and not 0 < value < math.inf:
                raise UserError(f"`{option}` must be positive and finite", got=value)


def estimate_cost(config: SceneConfig, body: Body, video_size: tuple[int, int] | None = None) -> Cost:
    """The least that simulating and rendering a scene takes, with a video for people of that width and height."""
    timing, domain, picture = config.timing, config.domain, config.rendering
    step = find_stable_step(config, body) if timing.substep_dt == "auto" else timing.substep_dt
    substeps = max(timing.duration / step, timing.frame_count - 1)
    nodes = math.prod(
        min(domain.cells + 1, ROOM * side / domain.dx + 6) for side in (body.high - body.low).tolist()
    )
    pixels = timing.frame_count * picture.width * picture.height
    particles = body.particles.count + body.cloud.count
    simulating = substeps * (particles * SECONDS_PER_PARTICLE_STEP + nodes * SECONDS_PER_NODE_STEP)
    seconds = {
        f"{substeps:,.0f} substeps of {body.particles.count:,} particles": simulating,
        f"{timing.frame_count:,} pictures of {picture.width} x {picture.height}": pixels * SECONDS_PER_PIXEL,
    }
    if video_size is not None:
        video_pixels = timing.frame_count * video_size[0] * video_size[1]
        seconds[f"a video of {video_size[0]} x {video_size[1]}"] = video_pixels * SECONDS_PER_VIDEO_PIXEL
    memory = {
        f"{timing.frame_count:,} pictures of {picture.width} x {picture.height}": pixels * BYTES_PER_PIXEL,
        f"{timing.frame_count:,} frames of {body.particles.count:,} particles": timing.frame_count
        * particles
        * BYTES_PER_PARTICLE,
        f"a grid of {nodes:,.0f} nodes": nodes * BYTES_PER_NODE,
    }
    largest = max(seconds, key=seconds.__getitem__), max(memory, key=memory.__getitem__)
    total = sum(seconds.values())
    return Cost(substeps, total, BASE_BYTES + sum(memory.values()), largest, total - simulating)


def find_stable_step(config: SceneConfig, body: Body) -> float:
    """The longest step [s] that a scene at rest allows, with its margin of safety; inf for what has no stress."""
    materials = (config.material, *(region.material for region in config.material_regions))
    step = min(stable_step(material, config.domain.dx) for material in materials)
    firmness = find_firmness(body, config.material, config.anchor, config.bearing, dx=config.domain.dx)
    most = 1.0 if config.bearing is None else config.bearing.most
    slowdown = find_scene_slowdown(config, body.particles.x, body.particles.volume, firmness, most)
    return config.timing.safety * step / (math.sqrt(most) * slowdown)


def check_cost(cost: Cost, limits: Limits) -> None:
    """Refuse what takes more than ``limits``.

    Raises:
        UserError: It does; the message says what takes most, and which option raises the limit.
    """
    minutes = cost.seconds / 60
    if minutes > limits.minutes:
        raise UserError(
            f"this would take at least {_format_minutes(minutes)}, most of it for {cost.largest[0]}; "
            f"the limit is {_format_minutes(limits.minutes)} a round",
            do=f"Make it smaller or softer, or pass --max-minutes {_round_up(minutes)}",
        )
    available = MEMORY_SHARE * read_machine_memory() if limits.memory is None else limits.memory * 1e9
    if cost.memory > available:
        raise UserError(
            f"this would take at least {cost.memory / 1e9:.1f} GB of memory, most of it for {cost.largest[1]}; "
            f"the limit is {available / 1e9:.1f} GB",
            do=f"Make it smaller, or pass --max-memory {_round_up(cost.memory / 1e9)}",
        )


def read_machine_memory() -> float:
    """Memory that this process may use, of the machine or its control group [bytes]; inf if unknown."""
    sizes = []
    if "SC_PHYS_PAGES" in getattr(os, "sysconf_names", {}):
        sizes.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    for name in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            text = Path(name).read_text().strip()
        except OSError:
            continue
        if text.isdecimal():  # "max" is none
            sizes.append(int(text))
    return float(min(sizes, default=math.inf))


def _format_minutes(value: float) -> str:
    if value < 120:
        return f"{value:.3g} minutes"
    hours = value / 60
    return f"{hours:.3g} hours" if hours < 72 else f"{hours / 24:.3g} days"


def _round_up(value: float) -> str:
    """A number with two digits that is no less."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / unit) * unit:.12g}"
