"""`physagent simulate` and `physagent import-physgaussian`: scenes without agents."""

from __future__ import annotations

import dataclasses
import json
import shlex
import sys
import time
from pathlib import Path
from typing import Annotated, Literal

import tyro

from physagent_jax.cli.console import FrameBar, stderr, warn
from physagent_jax.cli.options import parse_size
from physagent_jax.core.errors import UserError
from physagent_jax.scene.config import SplatEncoding


@dataclasses.dataclass(frozen=True)
class Simulate:
    """Play a scene file (ours, or a PhysGaussian config): video, motion and figures, no agents."""

    scene: tyro.conf.Positional[Path]
    """scene.json of a run, or a PhysGaussian config."""
    out: Path
    """Folder to write to."""
    object: Path | None = None
    """The object's file, where the scene does not name it (PhysGaussian) or it has moved."""
    splat_encoding: SplatEncoding | None = None
    """Encoding of the object's scales and opacities; default: as the scene says, else found out."""
    ledger: bool = False
    """Also record work, dissipation and impulses, frame by frame."""
    force_substep: bool = False
    """Run the scene's `substep_dt` even above the stable bound."""
    video_size: str = "1280x720"
    """Width and height of the video, which is drawn for people; off: none is."""
    save_frames: bool = False
    """Also leave the scene's plain pictures as PNG."""
    save_splats: Literal["ply", "spz", "glb"] | None = None
    """Also leave one file of 3D Gaussians per frame, in this format; named without one: ply."""
    max_minutes: float = 60.0
    """Refuse what is estimated to take longer."""
    max_memory: float | None = None
    """Refuse what is estimated to need more [GB]; default: 80 % of the machine's."""
    overwrite: bool = False
    """Replace another run in the folder."""
    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one line of JSON instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.run.replay import replay_scene
        from physagent_jax.run.store import PLAIN_VIDEO, VIDEO
        from physagent_jax.scene.cost import Limits

        begun = time.perf_counter()
        from physagent_jax.scene.scene_file import read_scene

        config, notes = read_scene(self.scene, self.object, self.splat_encoding)
        for text in notes:
            warn(text)
        config, video_size = self._adjust(config), parse_size(self.video_size)
        bar = FrameBar("simulating and rendering")
        try:
            record, stages = replay_scene(
                config,
                self.scene,
                self.out,
                bar,
                command=shlex.join(sys.argv),
                save_frames=self.save_frames,
                save_splats=self.save_splats or False,
                video_size=video_size,
                limits=Limits(self.max_minutes, self.max_memory),
                overwrite=self.overwrite,
                warn=warn,
            )
        finally:
            bar.close()
        if self.json_line:
            wall = {**stages.model_dump(), "total": round(time.perf_counter() - begun, 3)}
            summary = {
                "frames": len(record.kinetic_energy),
                "particle_count": record.particle_count,
                "substeps": record.substeps,
                "redone_frames": len(record.redone_frames),
                "wall_s": wall,
                "out": str(self.out),
            }
            print(json.dumps(summary))
        else:
            print(f"video: {self.out / (PLAIN_VIDEO if video_size is None else VIDEO)}")
        return 0

    def _adjust(self, config):
        """The scene with what the options ask for."""
        if self.force_substep and config.timing.substep_dt == "auto":
            raise UserError(
                "`--force-substep` needs a scene with a fixed `substep_dt`",
                got='"auto"',
                do="Set `timing.substep_dt` in the scene, or leave the option out",
            )
        timing = config.timing
        return config.model_copy(
            update=dict(
                ledger=config.ledger or self.ledger,
                timing=timing.model_copy(
                    update=dict(force_substep=timing.force_substep or self.force_substep)
                ),
            )
        )


@dataclasses.dataclass(frozen=True)
class ImportPhysGaussian:
    """Translate a PhysGaussian config into a scene file."""

    config: tyro.conf.Positional[Path]
    """PhysGaussian's JSON."""
    object: Path
    """The 3DGS PLY that it is meant for."""
    out: Path
    """Scene file to write."""
    splat_encoding: SplatEncoding | None = None
    """Encoding of the object's scales and opacities; default: found out."""
    overwrite: bool = False
    """Replace a file that holds something else."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.core.files import write_new
        from physagent_jax.scene.config import dump_scene
        from physagent_jax.scene.scene_file import read_scene

        scene, notes = read_scene(self.config, self.object, self.splat_encoding)
        for text in notes:
            warn(text)
        write_new({self.out: dump_scene(scene).encode()}, overwrite=self.overwrite)
        stderr.print(f"{len(notes)} key(s) had no meaning here")
        print(self.out)
        return 0
