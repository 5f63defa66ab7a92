"""`python -m baselines.scores.toy.clips`: simulated clips of objects that are in no task, with prompts."""

from __future__ import annotations

import dataclasses
import json
import sys
import time
import warnings
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import tyro

import physagent_jax as pa
from baselines.scores.toy.motions import FRAMES, MOTIONS, draw_force_field
from baselines.scores.toy.objects import OBJECTS, write_object
from physagent_jax.core.errors import UserError

SIZE = 32  # [px] of a clip; pictures are rendered twice as large and averaged
_KEPT_EVERY = 24  # clips
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
        """Load what `save` wrote.

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
    """File of the clips."""
    count: int = 960
    """Number of clips; each motion as often."""
    instances: int = 6
    """Instances of each kind of object; the last of them is for validation."""
    particles: int = 700
    """Particles of an object, at most."""
    seed: int = 0
    """Seed of everything drawn."""

    @property
    def kept(self) -> Path:
        """The folder of clips until all are complete."""
        return self.out.with_name(f"{self.out.stem}.part.npz")

    def list_settings(self) -> dict[str, int]:
        """The settings that two calls must share for one to continue the other."""
        return {name: getattr(self, name) for name in ("count", "instances", "particles", "seed")}


def make_clips(command: Command) -> Clips:
    """Simulate and render; go on where an earlier call with these settings was cut off.

    Raises:
        UserError: What was kept is of other settings.
    """
    rng = np.random.default_rng(command.seed)
    command.out.parent.mkdir(parents=True, exist_ok=True)
    names, prompts = list(OBJECTS), list(MOTIONS)
    loaders, takes = {}, []
    for index in range(command.count):  # what is drawn does not depend on what was made before
        motion = index % len(prompts)
        kind, instance = int(rng.integers(len(names))), int(rng.integers(command.instances))
        if (kind, instance) not in loaders:
            path = write_object(names[kind], command.seed + instance, command.out.parent)
            extent = float(rng.uniform(0.7, 0.9))
            loaders[kind, instance] = partial(
                pa.load_object,
                path,
                up="+z",
                kind="jelly",
                extent=extent,
                cells=32,
                max_particles=command.particles,
            )
        takes.append((motion, kind, instance, draw_options(prompts[motion], rng)))
    load = cache(lambda kind, instance: loaders[kind, instance]())
    columns = [np.array(column) for column in zip(*(take[:3] for take in takes))]
    videos, begun = _load_kept(command), time.perf_counter()
    if videos:
        print(f"goes on after {len(videos)} clips, kept in {command.kept}", flush=True)
    for index in range(len(videos), command.count):
        _, kind, instance, options = takes[index]
        videos.append(play(load(kind, instance), options))
        if (index + 1) % _KEPT_EVERY == 0:
            _keep(command, videos)
            print(f"{index + 1} of {command.count} clips, {time.perf_counter() - begun:.0f} s", flush=True)
    return Clips(np.array(videos), *columns)


def draw_options(prompt: str, rng: np.random.Generator) -> dict[str, Any]:
    """Draw the options with which `play` shows a motion: force field, material and camera."""
    return dict(
        force_field=draw_force_field(prompt, rng),
        material=dict(youngs_modulus=float(10 ** rng.uniform(4.3, 5)), poissons_ratio=0.3, density=300.0),
        camera=dict(azimuth_degrees=float(rng.uniform(-12, 12)), elevation_degrees=float(rng.uniform(0, 15))),
    )


def play(loaded: pa.LoadedObject, options: dict[str, Any]) -> np.ndarray:
    """One clip of a motion, uint8, shape (FRAMES, SIZE, SIZE, 3): free of the ground, seen almost from the front."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of coarse filling: these are toys
        scene = pa.build_scene(
            loaded,
            anchor="none",
            world="free",
            frame_count=FRAMES,
            width=2 * SIZE,
            height=2 * SIZE,
            **options,
        )
    pictures = pa.simulate_scene(scene).rgb.astype(np.float32)
    halved = pictures.reshape(FRAMES, SIZE, 2, SIZE, 2, 3).mean((2, 4))
    return (halved + 0.5).astype(np.uint8)


def _keep(command: Command, videos: list[np.ndarray]) -> None:
    """Whole or not at all."""
    beside = command.kept.with_name(f"{command.kept.stem}.new.npz")
    np.savez_compressed(beside, videos=np.array(videos), settings=json.dumps(command.list_settings()))
    beside.replace(command.kept)


def _load_kept(command: Command) -> list[np.ndarray]:
    if not command.kept.exists():
        return []
    with np.load(command.kept) as file:
        found = json.loads(str(file["settings"]))
        if found != command.list_settings():
            raise UserError(
                f"clips with other settings were cut off in {command.kept}",
                got=f"{command.list_settings()}, there {found}",
                do="Give those settings to go on, or delete the file",
            )
        return list(file["videos"])


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit code."""
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
    command.kept.unlink(missing_ok=True)
    print(f"{len(clips.videos)} clips in {command.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
