"""`python -m benchmarks.gallery --objects DIR`: sixteen sentences as small moving pictures, and a page with them.

Four objects are the project's own, twelve are other people's: ``DIR`` holds their files by the names below, as
`python -m benchmarks.first_results.objects --into DIR` leaves them. Runs are kept, so that a stopped gallery goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import io
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

import physagent_jax as pa
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import replace_file, write_text
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import PROCEDURAL

ROBOT = Path(__file__).parents[1] / "examples" / "assets" / "robot.ply"
WIDTH = 320  # [px]
MOST_BYTES = 300_000
QUALITIES = (80, 65, 50, 40, 30, 20, 10)
SMALL = dict(
    rounds=1,
    overrides=dict(frame_count=12, max_particles=1500, width=160, height=120),
    save=dict(video_size=(320, 180)),
)


@dataclasses.dataclass(frozen=True)
class Clip:
    """One clip of the gallery.

    Attributes:
        name: Name of its picture.
        file: Name of the object's file; "" = the object of that name is the project's own.
        prompt: What should happen.
        up: The file's up axis; None = found.
    """

    name: str
    file: str
    prompt: str
    up: str | None = None


CLIPS = (
    Clip("robot", "", "the robot does a backflip"),
    Clip("plant", "", "a strong wind bends the plant to the left, then lets go"),
    Clip("jelly", "", "drop the jelly"),
    Clip("loaf", "", "someone presses down on the middle of the loaf and lets go"),
    Clip("teapot", "teapot.obj", "push the teapot to the left", "+y"),
    Clip("armadillo", "armadillo.obj", "twist the armadillo", "+y"),
    Clip("duck", "Duck.glb", "drop the duck"),
    Clip("penguin", "penguin.obj", "the penguin is knocked over to the right", "+y"),
    Clip("koala", "koala_low_resolution.obj", "two plates squeeze the koala from left and right", "+y"),
    Clip("cat", "cat-low-resolution.obj", "the cat jumps", "+y"),
    Clip("fish", "fish.obj", "stretch the fish", "+y"),
    Clip("boot", "boot.obj", "kick the boot away from the camera", "+y"),
    Clip("truck", "CesiumMilkTruck.glb", "push the truck toward the camera"),
    Clip("tree", "low-poly-tree.glb", "a gust bends the tree to the right"),
    Clip("biker", "biker.spz", "the wind blows against the biker from the left"),
    Clip("chair", "Chair.obj", "spin the chair", "+y"),
)


def find_object(clip: Clip, objects: Path | None, made: Path) -> tuple[Path, str | None]:
    """The file of a clip's object and its up axis; the project's own are made in ``made``.

    Raises:
        UserError: The file is not there.
    """
    if clip.name in PROCEDURAL and not clip.file:
        path = made / f"{clip.name}.ply"
        if not path.is_file():
            write_ply(path, PROCEDURAL[clip.name](0))
        return path, "+z"
    if not clip.file:
        return ROBOT, None
    path = (objects or Path()) / clip.file
    if objects is None or not path.is_file():
        raise UserError(
            f"the object of the clip {clip.name!r} is not there",
            got=str(path),
            do="Fetch it with `python -m benchmarks.first_results.objects --into DIR`, and pass --objects DIR",
        )
    return path, clip.up


def encode(frames: np.ndarray, seconds: float) -> bytes:
    """An animated WebP of at most `MOST_BYTES`, as fine as that allows.

    Args:
        frames: uint8, shape (T, height, width, 3).
        seconds: Duration of a frame [s].
    """
    step = 1 + len(frames) // 80
    size = WIDTH, round(WIDTH * frames.shape[1] / frames.shape[2])
    pictures = [Image.fromarray(each).resize(size, Image.Resampling.LANCZOS) for each in frames[::step]]
    content = b""
    for quality in QUALITIES:
        file = io.BytesIO()
        pictures[0].save(
            file,
            "WEBP",
            save_all=True,
            append_images=pictures[1:],
            duration=round(1000 * seconds * step),
            loop=0,
            quality=quality,
            method=4,
        )
        content = file.getvalue()
        if len(content) <= MOST_BYTES:
            break
    return content


def film(clip: Clip, objects: Path | None, runs: Path, settings: dict) -> tuple[bytes, str]:
    """A clip's moving picture, and the verdict on it; a run that is there already is not made again."""
    path, up = find_object(clip, objects, runs)
    spec = pa.RunSpec.model_validate(
        dict(object=dict(path=str(path.resolve()), up=up), prompt=clip.prompt, **settings)
    )
    run = pa.synthesize(spec, runs / clip.name)
    manifest = run.manifest
    assert manifest is not None  # the run is finished
    return encode(run.frames(), 0.04), str(manifest.verdict)


def write_page(path: Path, images: Path, clips: Sequence[tuple[Clip, str]]) -> None:
    """Write the page that shows the pictures, two beside each other.

    Args:
        path: The page.
        images: Folder of the pictures, below the page's.
        clips: The clips and the verdicts on them.
    """
    place = images.relative_to(path.parent).as_posix()
    lines = [
        "# Gallery",
        "",
        "Each clip comes from one sentence at the default settings (`make gallery`); the verdict is the run's own.",
        "Objects with a file name are other people's: [first-results.md](first-results.md) names authors and licences.",
        "",
        "| | |",
        "|---|---|",
    ]
    cells = [
        f"![{clip.prompt}]({place}/gallery-{clip.name}.webp)<br>*{clip.prompt}*<br>"
        f"{clip.file or clip.name}: {verdict}"
        for clip, verdict in clips
    ]
    cells += [""] * (len(cells) % 2)
    lines += [f"| {left} | {right} |" for left, right in zip(cells[::2], cells[1::2])]
    write_text(path, "\n".join(lines) + "\n")


def main(arguments: list[str] | None = None) -> int:
    """Make the pictures and the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=Path, help="folder with the files of other people's objects")
    parser.add_argument("--runs", type=Path, default=Path("runs/gallery"), help="where the runs are kept")
    parser.add_argument(
        "--docs", type=Path, default=Path("docs"), help="folder of the page; pictures: images/"
    )
    parser.add_argument("--only", nargs="+", choices=[clip.name for clip in CLIPS], help="these clips alone")
    parser.add_argument("--small", action="store_true", help="small and coarse, to try it")
    command = parser.parse_args(arguments)
    images = command.docs / "images"
    images.mkdir(parents=True, exist_ok=True)
    command.runs.mkdir(parents=True, exist_ok=True)
    done = []
    try:
        for clip in CLIPS:
            if command.only and clip.name not in command.only:
                continue
            content, verdict = film(clip, command.objects, command.runs, SMALL if command.small else {})
            with replace_file(images / f"gallery-{clip.name}.webp") as temporary:
                temporary.write_bytes(content)
            done.append((clip, verdict))
            print(f"{clip.name}: {clip.prompt!r}, {verdict}, {len(content) / 1e3:.0f} kB", flush=True)
    except UserError as error:
        print(error, file=sys.stderr)
        return 2
    write_page(command.docs / "gallery.md", images, done)
    return 0


if __name__ == "__main__":
    pa.enable_compile_cache()
    sys.exit(main())
