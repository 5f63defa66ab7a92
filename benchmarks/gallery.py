"""`python -m benchmarks.gallery --objects DIR`: sixteen sentences as small moving pictures, and a page with them.

Four objects are the project's own, twelve are Kenney's (CC0), from his starter kits on GitHub. What ``DIR`` lacks of
them is fetched. Runs are kept, so that a stopped gallery goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import io
import sys
import urllib.request
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
    """

    name: str
    file: str
    prompt: str


# Folder of the kit's files: its repository of github.com/KenneyNL, and the commit.
KITS = {
    "platformer": ("Starter-Kit-3D-Platformer", "3fa8a04b1c01ab23db43123d4ce814a34c3fc7f0"),
    "racing": ("Starter-Kit-Racing", "2f2e5f2646dda89cb21d4e8539bab60c6e955dc8"),
    "city": ("Starter-Kit-City-Builder", "48458e6f343d6369ac015c77476eb262b964df2b"),
    "arena": ("Starter-Kit-FPS", "cc46ba7b2b14275916429df7fdf7692f431902f2"),
}
TEXTURE = "Textures/colormap.png"  # of all files of a kit
PATIENCE = 30.0  # [s] for an answer

CLIPS = (
    Clip("robot", "", "the robot does a backflip"),
    Clip("plant", "", "a strong wind bends the plant to the left, then lets go"),
    Clip("jelly", "", "drop the jelly"),
    Clip("loaf", "", "someone presses down on the middle of the loaf and lets go"),
    Clip("character", "platformer/character.glb", "the character jumps"),
    Clip("coin", "platformer/coin.glb", "spin the coin"),
    Clip("cloud", "platformer/cloud.glb", "two plates squeeze the cloud from left and right"),
    Clip("flag", "platformer/flag.glb", "a gust bends the flag to the right"),
    Clip("block", "platformer/block-coin.glb", "drop the block"),
    Clip("motorcycle", "racing/vehicle-motorcycle.glb", "the motorcycle is knocked over to the right"),
    Clip("pickup", "racing/vehicle-truck-yellow.glb", "push the pickup toward the camera"),
    Clip("house", "city/building-small-a.glb", "push the house to the left"),
    Clip("tower", "city/building-small-c.glb", "twist the tower"),
    Clip("trees", "city/grass-trees-tall.glb", "the wind blows against the trees from the left"),
    Clip("drone", "arena/enemy-flying.glb", "kick the drone away from the camera"),
    Clip("blaster", "arena/blaster.glb", "stretch the blaster"),
)


def find_object(clip: Clip, objects: Path, made: Path) -> tuple[Path, str | None]:
    """The file of a clip's object and its up axis, None = found; the project's own are made in ``made``.

    Raises:
        UserError: The file is not in ``objects``, and cannot be fetched.
    """
    if clip.name in PROCEDURAL and not clip.file:
        path = made / f"{clip.name}.ply"
        if not path.is_file():
            write_ply(path, PROCEDURAL[clip.name](0))
        return path, "+z"
    if not clip.file:
        return ROBOT, None
    kit, name = clip.file.split("/")
    for each in (TEXTURE, name):
        if not (path := objects / kit / each).is_file():
            fetch(kit, each, path)
    return objects / clip.file, None


def fetch(kit: str, name: str, path: Path) -> None:
    """Fetch a file of a kit to ``path``.

    Raises:
        UserError: It cannot be had.
    """
    url = "https://raw.githubusercontent.com/KenneyNL/{}/{}/models/{}".format(*KITS[kit], name)
    try:
        with urllib.request.urlopen(url, timeout=PATIENCE) as answer:
            content = answer.read()
    except OSError as error:  # `urllib.error.URLError` is one
        raise UserError(
            f"cannot fetch {url}", got=error, do=f"Try again later, or put the file at {path} yourself"
        ) from None
    path.parent.mkdir(parents=True, exist_ok=True)
    with replace_file(path) as temporary:
        temporary.write_bytes(content)


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


def film(clip: Clip, objects: Path, runs: Path, settings: dict) -> tuple[bytes, str]:
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
        "Objects with a file name are from [Kenney's](https://github.com/KenneyNL) starter kits, free of rights (CC0).",
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
    parser.add_argument("--objects", type=Path, default=Path("runs/objects"), help="folder of Kenney's files")
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
