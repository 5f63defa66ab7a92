"""`python -m baselines.scores.toy.clips`: simulated clips of objects that are in no task, with prompts."""

from __future__ import annotations

import dataclasses
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import tyro

import physagent_jax as pa
from baselines.scores.toy.motions import FRAMES, MOTIONS, draw_force_field
from baselines.scores.toy.objects import OBJECTS, write_object
from physagent_jax.core.errors import UserError

SIZE = 32  # [px] of a clip; pictures are rendered twice as large and averaged
UNSEEN = "vase"  # its clips are kept for validation


@dataclasses.dataclass(frozen=True)
class Clips:
    """Clips and what they show.

    Attributes:
        videos: uint8, shape (n, FRAMES, SIZE, SIZE, 3).
        motions: Index into `MOTIONS`, shape (n,).
        objects: Index into `OBJECTS`, shape (n,).
        instances: Which instance of its kind of object, shape (n,).
    """

    videos: np.ndarray
    motions: np.ndarray
    objects: np.ndarray
    instances: np.ndarray

    @staticmethod
    def load(path: Path) -> Clips:
        """What `save` wrote.

        Raises:
            UserError: There is no such file.
        """
        if not path.exists():
            raise UserError(
                "there are no clips to learn from", got=path, do="Run `python -m baselines.scores.toy.clips`"
            )
        with np.load(path) as data:
            return Clips(**{field.name: data[field.name] for field in dataclasses.fields(Clips)})

    def save(self, path: Path) -> None:
        """As one npz file."""
        np.savez_compressed(path, **dataclasses.asdict(self))

    def select(self, mask: np.ndarray) -> Clips:
        """Those where ``mask`` is true."""
        return Clips(**{field.name: getattr(self, field.name)[mask] for field in dataclasses.fields(Clips)})


@dataclasses.dataclass(frozen=True)
class Command:
    """Simulates clips for the toy prior."""

    out: Path = Path("runs/toy_prior/clips.npz")
    """Where they go."""
    count: int = 960
    """How many; each motion as often."""
    instances: int = 6
    """Of each kind of object; the last of them is for validation."""
    particles: int = 700
    """At most."""
    seed: int = 0
    """Of everything drawn."""


def make_clips(command: Command) -> Clips:
    """Simulates and renders."""
    rng = np.random.default_rng(command.seed)
    rows, begun = [], time.perf_counter()
    command.out.parent.mkdir(parents=True, exist_ok=True)
    names, prompts = list(OBJECTS), list(MOTIONS)
    loaded = {}
    for index in range(command.count):
        motion = index % len(prompts)
        kind, instance = int(rng.integers(len(names))), int(rng.integers(command.instances))
        if (kind, instance) not in loaded:
            path = write_object(names[kind], command.seed + instance, command.out.parent)
            extent = float(rng.uniform(0.7, 0.9))
            loaded[kind, instance] = pa.load_object(
                path, up="+z", kind="jelly", extent=extent, cells=32, max_particles=command.particles
            )
        video = play(loaded[kind, instance], prompts[motion], rng)
        rows.append((video, motion, kind, instance))
        if (index + 1) % 24 == 0:
            print(f"{index + 1} of {command.count} clips, {time.perf_counter() - begun:.0f} s", flush=True)
    videos, motions, kinds, instances = (np.array(column) for column in zip(*rows))
    return Clips(videos, motions, kinds, instances)


def play(loaded: pa.LoadedObject, prompt: str, rng: np.random.Generator) -> np.ndarray:
    """One clip of a motion, uint8, shape (FRAMES, SIZE, SIZE, 3): free of the ground, seen almost from the front."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of coarse filling: these are toys
        scene = pa.build_scene(
            loaded,
            force_field=draw_force_field(prompt, rng),
            material=dict(youngs_modulus=float(10 ** rng.uniform(4.3, 5)), poissons_ratio=0.3, density=300.0),
            anchor="none",
            world="free",
            camera=dict(
                azimuth_degrees=float(rng.uniform(-12, 12)), elevation_degrees=float(rng.uniform(0, 15))
            ),
            frame_count=FRAMES,
            width=2 * SIZE,
            height=2 * SIZE,
        )
    pictures = pa.simulate_scene(scene).rgb.astype(np.float32)
    halved = pictures.reshape(FRAMES, SIZE, 2, SIZE, 2, 3).mean((2, 4))
    return (halved + 0.5).astype(np.uint8)


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line; returns the exit code."""
    command = tyro.cli(Command, prog="python -m baselines.scores.toy.clips", args=arguments)
    pa.enable_compile_cache()
    try:
        if command.count < 1 or command.instances < 1:
            raise UserError("`--count` and `--instances` must be at least 1")
        clips = make_clips(command)
    except UserError as error:
        print(f"clips: {error}", file=sys.stderr)
        return 2
    clips.save(command.out)
    print(f"{len(clips.videos)} clips in {command.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
